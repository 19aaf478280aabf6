/* Drives an FMU of FMI 2.0 through all that it offers, linked with its sources, for sanitizers to watch.
   Every value reference is read and written, rightly and wrongly; states are saved, bent and restored.

   Ends with 0 if every answer was the one expected. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#include "identity.h"
#include "model.h"
#include "moved.h"

static int faults, lines;

#define EXPECT(condition) \
    do { \
        if (!(condition)) { \
            fprintf(stderr, "line %d: not " #condition "\n", __LINE__); \
            faults++; \
        } \
    } while (0)

static void logger(fmi2ComponentEnvironment env, fmi2String name, fmi2Status status, fmi2String category,
                   fmi2String message, ...)
{
    char text[2048];
    va_list arguments;
    (void)env, (void)status, (void)category;
    va_start(arguments, message);
    vsnprintf(text, sizeof text, message, arguments);
    va_end(arguments);
    EXPECT(strlen(text) > strlen(name));
    lines++;
}

static void move_inputs(fmi2Component instance, int index)
{
    for (unsigned i = FIRST_INPUT; (int)i < FIRST_OUTPUT; i++) {
        int kind = WL(variables)[i].kind;
        if (kind == REAL) {
            double value = moved_real((int)i, index);
            EXPECT(fmi2SetReal(instance, &i, 1, &value) == fmi2OK);
        } else if (kind == INTEGER || kind == ENUMERATION) {
            int whole = moved_whole((int)i, index);
            EXPECT(fmi2SetInteger(instance, &i, 1, &whole) == fmi2OK);
        } else {
            fmi2Boolean truth = index % 2;
            EXPECT(fmi2SetBoolean(instance, &i, 1, &truth) == fmi2OK);
        }
    }
}

static void read_all(fmi2Component instance)
{
    for (unsigned i = 0; i < VARIABLES + 3 + 2 * WL_STATES; i++) {
        double number;
        int whole;
        fmi2Boolean truth;
        Kind kind = i < VARIABLES ? WL(variables)[i].kind : IS_STATE(i) || IS_RATE(i) ? REAL : (Kind)9;
        EXPECT((fmi2GetReal(instance, &i, 1, &number) == fmi2OK) == (kind == REAL));
        EXPECT((fmi2GetInteger(instance, &i, 1, &whole) == fmi2OK) == (kind == INTEGER || kind == ENUMERATION));
        EXPECT((fmi2GetBoolean(instance, &i, 1, &truth) == fmi2OK) == (kind == BOOLEAN));
    }
}

/* `pairs`: of every variable by every other too, which takes by far the longest. */
static void take_derivatives(fmi2Component instance, int pairs)
{
    for (unsigned i = 0; i < VARIABLES + 2; i++) {
        for (unsigned k = 0; pairs && k < VARIABLES + 2; k++) {
            double seed = 1, slope = 0;
            fmi2GetDirectionalDerivative(instance, &i, 1, &k, 1, &seed, &slope);
        }
        for (int order = -1; order < 4; order++) {
            double value = 0.01;
            fmi2GetRealOutputDerivatives(instance, &i, 1, &order, &value);
            value = i < VARIABLES && (WL(variables)[i].flags & HAS_MAXIMUM) ? 0 : order == 1 ? 1e-3 : 1e-6;
            fmi2SetRealInputDerivatives(instance, &i, 1, &order, &value);
        }
    }
}

static void run(const fmi2CallbackFunctions *callbacks)
{
    fmi2Component instance = fmi2Instantiate("100 % driven", fmi2CoSimulation, WL_TOKEN, RESOURCES, callbacks, 0, 1);
    fmi2FMUstate state = NULL, copy = NULL;
    size_t size = 0;
    double steps[] = {0.01, 0.3, 1, 2.5, 60, 600}, time = 3;
    EXPECT(instance != NULL);
    EXPECT(fmi2DoStep(instance, 0, 1, 1) == fmi2Error);
    read_all(instance);
    EXPECT(fmi2SetupExperiment(instance, 1, 1e-6, time, 1, 1e6) == fmi2OK);
    EXPECT(fmi2EnterInitializationMode(instance) == fmi2OK);
    move_inputs(instance, 0);
    read_all(instance);
    take_derivatives(instance, 1);
    for (unsigned i = 0; (int)i < WL_PARAMETERS; i++) {
        double start = WL(variables)[i].start, bad = NAN;
        if (WL(variables)[i].kind != REAL)
            continue;
        EXPECT(fmi2SetReal(instance, &i, 1, &bad) == fmi2OK);
        EXPECT(fmi2ExitInitializationMode(instance) == fmi2Error);
        EXPECT(fmi2SetReal(instance, &i, 1, &start) == fmi2OK);
    }
    EXPECT(fmi2ExitInitializationMode(instance) == fmi2OK);
    for (int index = 0; index < 30; index++) {
        double step = steps[index % 6];
        move_inputs(instance, index);
        EXPECT(fmi2DoStep(instance, time, step, 1) == fmi2OK);
        time += step;
        read_all(instance);
        /* Of all pairs at a step with readings that are missing. */
        take_derivatives(instance, index == 24);
        EXPECT(fmi2DoStep(instance, time, -step, 1) == fmi2Error);
        EXPECT(fmi2DoStep(instance, time, HUGE_VAL, 1) == fmi2Error);
        EXPECT(fmi2DoStep(instance, time + 1e9, step, 1) == fmi2Error);
        if (index == 10)
            EXPECT(fmi2GetFMUstate(instance, &state) == fmi2OK);
    }
    EXPECT(fmi2SerializedFMUstateSize(instance, state, &size) == fmi2OK);
    char *bytes = malloc(size);
    EXPECT(fmi2SerializeFMUstate(instance, state, bytes, size - 1) == fmi2Error);
    EXPECT(fmi2SerializeFMUstate(instance, state, bytes, size) == fmi2OK);
    EXPECT(fmi2DeSerializeFMUstate(instance, bytes, size - 1, &copy) == fmi2Error);
    EXPECT(fmi2DeSerializeFMUstate(instance, bytes, size, &copy) == fmi2OK);
    EXPECT(fmi2SetFMUstate(instance, copy) == fmi2OK);
    read_all(instance);
    EXPECT(fmi2SetFMUstate(instance, NULL) == fmi2Error);
    EXPECT(fmi2GetFMUstate(instance, &state) == fmi2OK);
    EXPECT(fmi2FreeFMUstate(instance, &state) == fmi2OK && state == NULL);
    EXPECT(fmi2FreeFMUstate(instance, &copy) == fmi2OK);
    EXPECT(fmi2Terminate(instance) == fmi2OK);
    EXPECT(fmi2Terminate(instance) == fmi2Error);
    EXPECT(fmi2Reset(instance) == fmi2OK);
    read_all(instance);
    free(bytes);
    fmi2FreeInstance(instance);
}

int main(void)
{
    fmi2CallbackFunctions callbacks = {logger, calloc, free, NULL, NULL}, none = {0};
    fmi2Component integrated = fmi2Instantiate("a", fmi2ModelExchange, WL_TOKEN, RESOURCES, &callbacks, 0, 0);
    EXPECT((integrated != NULL) == WL_EXCHANGES);
    fmi2FreeInstance(integrated);
    EXPECT(fmi2Instantiate("a", fmi2CoSimulation, "{no}", "", &callbacks, 0, 0) == NULL);
    EXPECT(fmi2Instantiate("", fmi2CoSimulation, WL_TOKEN, RESOURCES, &none, 0, 0) == NULL);
    EXPECT(fmi2Instantiate("a", fmi2CoSimulation, WL_TOKEN, RESOURCES, NULL, 0, 0) == NULL);
    EXPECT(fmi2DoStep(NULL, 0, 1, 1) == fmi2Error);
    fmi2FreeInstance(NULL);
    run(&callbacks);
    EXPECT(lines > 10);
    return faults != 0;
}
