/* Drives an FMU of FMI 3.0 through all that it offers, linked with its sources, for sanitizers to watch.
   Ends with 0 if every answer was the one expected. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi3Functions.h"
#include "identity.h"
#include "model.h"
#include "moved.h"

static int faults, lines, updates;
static fmi3Instance driven;

#define EXPECT(condition) \
    do { \
        if (!(condition)) { \
            fprintf(stderr, "line %d: not " #condition "\n", __LINE__); \
            faults++; \
        } \
    } while (0)

static void logger(fmi3InstanceEnvironment env, fmi3Status status, fmi3String category, fmi3String message)
{
    (void)env, (void)status, (void)category;
    EXPECT(strlen(message) > 5);
    lines++;
}

static void move_inputs(int index)
{
    for (unsigned i = FIRST_INPUT; (int)i < FIRST_OUTPUT; i++) {
        int kind = WL(variables)[i].kind;
        if (kind == REAL) {
            double value = moved_real((int)i, index);
            EXPECT(fmi3SetFloat64(driven, &i, 1, &value, 1) == fmi3OK);
        } else if (kind == BOOLEAN) {
            bool truth = index % 2;
            EXPECT(fmi3SetBoolean(driven, &i, 1, &truth, 1) == fmi3OK);
        } else {
            int32_t whole = moved_whole((int)i, index);
            int64_t wide = whole;
            EXPECT((kind == INTEGER ? fmi3SetInt32(driven, &i, 1, &whole, 1)
                                    : fmi3SetInt64(driven, &i, 1, &wide, 1)) == fmi3OK);
        }
    }
}

static void update(fmi3InstanceEnvironment env, fmi3Float64 time, fmi3Boolean set, fmi3Boolean get,
                   fmi3Boolean finished, fmi3Boolean may_end, fmi3Boolean *end, fmi3Float64 *end_time)
{
    (void)env;
    EXPECT(set != get && get == finished && may_end == finished);
    if (set)
        move_inputs(updates++);
    if (may_end && updates % 3 == 0) {
        *end = true;
        *end_time = time + (updates % 2 ? 0.4 : -1);
    }
}

/* `pairs`: derivatives of every variable by every other too, which takes by far the longest. They know nothing of
   updates within a step: the run without these asks for them. */
static void read_all(bool pairs)
{
    for (unsigned i = 0; i < VARIABLES + 3 + 2 * WL_STATES; i++) {
        double number[2];
        int32_t whole;
        int64_t wide;
        bool truth;
        int8_t small;
        Kind kind = i < VARIABLES ? WL(variables)[i].kind
                    : i == VARIABLES || IS_STATE(i) || IS_RATE(i) ? REAL : (Kind)9;
        EXPECT((fmi3GetFloat64(driven, &i, 1, number, 1) == fmi3OK) == (kind == REAL));
        EXPECT(fmi3GetFloat64(driven, &i, 1, number, 2) == fmi3Error);
        EXPECT((fmi3GetInt32(driven, &i, 1, &whole, 1) == fmi3OK) == (kind == INTEGER));
        EXPECT((fmi3GetInt64(driven, &i, 1, &wide, 1) == fmi3OK) == (kind == ENUMERATION));
        EXPECT((fmi3GetBoolean(driven, &i, 1, &truth, 1) == fmi3OK) == (kind == BOOLEAN));
        EXPECT(fmi3GetInt8(driven, &i, 1, &small, 1) == fmi3Error);
        for (unsigned k = 0; pairs && k < VARIABLES + 2; k++) {
            double seed = 1, slope;
            fmi3GetDirectionalDerivative(driven, &i, 1, &k, 1, &seed, 1, &slope, 1);
        }
        for (int32_t order = -1; order < 3; order++)
            fmi3GetOutputDerivatives(driven, &i, 1, &order, number, 1);
    }
}

static void run(bool with_updates)
{
    fmi3FMUState state = NULL, copy = NULL;
    size_t size = 0;
    bool event, end, early;
    double steps[] = {0.01, 0.3, 1, 2.5, 60, 600}, time = 3, reached = 0;
    driven = fmi3InstantiateCoSimulation("driven", WL_TOKEN, RESOURCES, false, true, false, with_updates, NULL, 0, NULL,
                                         logger, with_updates ? update : NULL);
    EXPECT(driven != NULL);
    EXPECT(fmi3DoStep(driven, 0, 1, true, &event, &end, &early, &reached) == fmi3Error);
    EXPECT(fmi3EnterInitializationMode(driven, true, 1e-6, time, true, 1e6) == fmi3OK);
    move_inputs(0);
    read_all(!with_updates);
    for (unsigned i = 0; (int)i < WL_PARAMETERS; i++) {
        double start = WL(variables)[i].start, bad = NAN;
        if (WL(variables)[i].kind != REAL)
            continue;
        EXPECT(fmi3SetFloat64(driven, &i, 1, &bad, 1) == fmi3OK);
        EXPECT(fmi3ExitInitializationMode(driven) == fmi3Error);
        EXPECT(fmi3SetFloat64(driven, &i, 1, &start, 1) == fmi3OK);
    }
    EXPECT(fmi3ExitInitializationMode(driven) == fmi3OK);
    for (int index = 0; index < 30; index++) {
        double step = steps[index % 6];
        move_inputs(index);
        EXPECT(fmi3DoStep(driven, time, step, true, &event, &end, &early, &reached) == fmi3OK);
        EXPECT(early == (reached < time + step) && reached > time);
        time = reached;
        /* Of all pairs at a step with readings that are missing. */
        read_all(index == 24 && !with_updates);
        EXPECT(fmi3DoStep(driven, time, -step, true, NULL, NULL, NULL, NULL) == fmi3Error);
        if (index == 10)
            EXPECT(fmi3GetFMUState(driven, &state) == fmi3OK);
    }
    EXPECT(fmi3SerializedFMUStateSize(driven, state, &size) == fmi3OK);
    fmi3Byte *bytes = malloc(size);
    EXPECT(fmi3SerializeFMUState(driven, state, bytes, size) == fmi3OK);
    EXPECT(fmi3DeserializeFMUState(driven, bytes, size - 1, &copy) == fmi3Error);
    EXPECT(fmi3DeserializeFMUState(driven, bytes, size, &copy) == fmi3OK);
    EXPECT(fmi3SetFMUState(driven, copy) == fmi3OK);
    read_all(false);
    EXPECT(fmi3FreeFMUState(driven, &state) == fmi3OK && fmi3FreeFMUState(driven, &copy) == fmi3OK);
    EXPECT(fmi3EnterEventMode(driven) == fmi3Error && fmi3SetTime(driven, 0) == fmi3Error);
    EXPECT(fmi3Terminate(driven) == fmi3OK && fmi3Reset(driven) == fmi3OK);
    free(bytes);
    fmi3FreeInstance(driven);
}

int main(void)
{
    fmi3Instance integrated = fmi3InstantiateModelExchange("a", WL_TOKEN, RESOURCES, false, false, NULL, logger);
    EXPECT((integrated != NULL) == WL_EXCHANGES);
    fmi3FreeInstance(integrated);
    EXPECT(fmi3InstantiateScheduledExecution("a", WL_TOKEN, RESOURCES, false, false, NULL, logger, NULL, NULL, NULL) == NULL);
    EXPECT(fmi3DoStep(NULL, 0, 1, true, NULL, NULL, NULL, NULL) == fmi3Error);
    fmi3FreeInstance(NULL);
    run(false);
    run(true);
    EXPECT(lines > 10);
    return faults != 0;
}
