/* Calls an FMU's functions at random, linked with its sources, for sanitizers to watch: any function in any order,
   null pointers, empty arrays, unknown references, values of any size, serialised states that were damaged and
   stamped anew. Compiled with -DFMI=2 or -DFMI=3; started with a seed and a number of calls.

   Ends with 0 if every answer was one that the standard allows: an error has its sentence, a null pointer is never
   followed, and a state that the instance itself wrote is taken again. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if FMI == 2
#include "fmi2Functions.h"
#define F(old, new) fmi2##old
#else
#include "fmi3Functions.h"
#define F(old, new) fmi3##new
#endif
#include "identity.h"
#include "model.h"

#define OK F(OK, OK)
#define ERROR F(Error, Error)
#define FAULTY(condition, what) \
    do { \
        if (condition) { \
            fprintf(stderr, "call %ld, line %d: %s\n", calls, __LINE__, what); \
            faults++; \
        } \
    } while (0)

typedef F(Status, Status) Status;
typedef F(ValueReference, ValueReference) Reference;
typedef F(Boolean, Boolean) Truth;
typedef F(Byte, Byte) Byte;
typedef F(FMUstate, FMUState) State;

enum { STATES_KEPT = 3 };

static F(Component, Instance) driven;
static State kept[STATES_KEPT];
static long calls, faults, sentences, steps, restored, refused;
static int depth; /* of calls from within a step */

#include "random_chance.h"
#include "random_values.h"
#include "random_states.h"

/* ---- phases and steps ---- */

static double time_reached(void)
{
    double time = 0;
#if FMI == 2
    CALL(0, fmi2GetRealStatus(driven, fmi2LastSuccessfulTime, NULL));
    CALL(1, fmi2GetRealStatus(driven, fmi2LastSuccessfulTime, &time));
#else
    Reference reference = VARIABLES;
    CALL(1, fmi3GetFloat64(driven, &reference, 1, &time, 1));
#endif
    return time;
}

static void step(void)
{
    static const double lengths[] = {1e-12, 0.01, 0.3, 1, 7.7, 60};
    double time = one_in(20) ? odd_number() : time_reached();
#if WL_CLOCKS
    double part = ((Model *)driven)->memory.parameters[WL(clocks)[0].sample_time];
#else
    double part = WL_MICRO_STEP;
#endif
    double length = one_in(20) ? odd_number() : part * (one_in(20) ? 1e7 : one_in(500) ? 1e4 : lengths[draw(6)]);
#if FMI == 2
    Status status = fmi2DoStep(driven, time, length, (fmi2Boolean)draw(2));
#else
    bool event, end, early;
    double reached;
    int told = draw(2);
    Status status = fmi3DoStep(driven, time, length, draw(2), told ? &event : NULL, told ? &end : NULL,
                               told ? &early : NULL, told ? &reached : NULL);
#endif
    FAULTY(status == OK && !(length > 0 && length < HUGE_VAL), "a step of no length was taken");
    steps += status == OK;
}

/* The call that comes next in an orderly run, or any of them. */
static void proceed(void)
{
    static const double starts[] = {0, 3, -5, 1e6};
    double phase = ((Model *)driven)->memory.phase, start = one_in(20) ? odd_number() : starts[draw(4)];
    double stop = one_in(5) ? odd_number() : start + 1e7;
    unsigned which = one_in(5) ? draw(5) : phase == INSTANTIATED ? draw(2) : phase == INITIALIZATION ? 2 : 3 + draw(2);
#if FMI == 2
    if (which == 0)
        CALL(1, fmi2SetupExperiment(driven, 1, 1e-6, start, (fmi2Boolean)draw(2), stop));
    else if (which == 1)
        CALL(1, fmi2EnterInitializationMode(driven));
#else
    if (which < 2)
        CALL(1, fmi3EnterInitializationMode(driven, true, 1e-6, start, draw(2), stop));
#endif
    else if (which == 2)
        CALL(1, F(ExitInitializationMode, ExitInitializationMode)(driven));
    else if ((phase != STEPPING && phase < EVENTS) || one_in(50))
        CALL(1, F(Terminate, Terminate)(driven));
    if (phase == TERMINATED || one_in(100))
        CALL(1, F(Reset, Reset)(driven));
}

/* What a host that integrates calls; of an instance that steps each is refused. */
static void integrate(void)
{
    size_t count = one_in(10) ? some_count() : WL_STATES;
    double *numbers = array(count * sizeof *numbers), time = one_in(9) ? odd_number() : ((Model *)driven)->memory.time + draw(9);
    Truth event, end;
    for (size_t i = 0; i < count && numbers; i++)
        numbers[i] = one_in(50) ? odd_number() : 290 + draw(30);
    int room = numbers && count == WL_STATES;
    switch (draw(9)) {
    case 0: CALL(room, F(SetContinuousStates, SetContinuousStates)(driven, numbers, count)); break;
    case 1: CALL(room, F(GetContinuousStates, GetContinuousStates)(driven, numbers, count)); break;
    case 2: CALL(room, F(GetDerivatives, GetContinuousStateDerivatives)(driven, numbers, count)); break;
    case 3: CALL(room, F(GetNominalsOfContinuousStates, GetNominalsOfContinuousStates)(driven, numbers, count)); break;
    case 4: CALL(count == 0, F(GetEventIndicators, GetEventIndicators)(driven, numbers, count)); break;
    case 5: CALL(1, F(SetTime, SetTime)(driven, time)); break;
    case 6: CALL(1, F(CompletedIntegratorStep, CompletedIntegratorStep)(driven, draw(2), one_in(2) ? &event : NULL, &end)); break;
    case 7: CALL(1, F(EnterEventMode, EnterEventMode)(driven)); break;
    default: CALL(1, F(EnterContinuousTimeMode, EnterContinuousTimeMode)(driven));
    }
#if FMI == 2
    fmi2EventInfo info;
    int given = !one_in(9);
    CALL(given, fmi2NewDiscreteStates(driven, given ? &info : NULL));
#endif
    free(numbers);
}

static void act(void)
{
    calls++;
    switch (draw(8)) {
    case 0: values(0); break;
    case 1: values(1); break;
    case 2: derivatives(); break;
    case 3: states(); break;
    case 4: proceed(); break;
    case 5: one_in(10) ? strings() : step(); break;
    case 6: integrate(); break;
    default: step();
    }
}

static void count_sentence(const char *sentence)
{
    FAULTY(strlen(sentence) < 10, "a sentence that says nothing");
    sentences++;
}

#if FMI == 2
static void logger(fmi2ComponentEnvironment env, fmi2String name, fmi2Status status, fmi2String category,
                   fmi2String message, ...)
{
    char text[2048];
    va_list arguments;
    (void)env, (void)name, (void)status, (void)category;
    va_start(arguments, message);
    vsnprintf(text, sizeof text, message, arguments);
    va_end(arguments);
    count_sentence(text);
}

static void instantiate(void)
{
    static const fmi2CallbackFunctions callbacks = {logger, calloc, free, NULL, NULL};
    fmi2Type type = WL_EXCHANGES && one_in(2) ? fmi2ModelExchange : fmi2CoSimulation;
    driven = fmi2Instantiate("driven", type, WL_TOKEN, RESOURCES, &callbacks, 0, 1);
}
#else
static void logger(fmi3InstanceEnvironment env, fmi3Status status, fmi3String category, fmi3String message)
{
    (void)env, (void)status, (void)category;
    count_sentence(message);
}

static void update(fmi3InstanceEnvironment env, double time, bool set, bool get, bool finished, bool may_return,
                   bool *wanted, double *earlier)
{
    (void)env, (void)set, (void)get, (void)may_return;
    *wanted = one_in(20);
    *earlier = one_in(2) ? time : odd_number();
    if (depth == 0 && one_in(finished ? 50 : 10)) {
        depth++;
        act();
        depth--;
    }
}

static void instantiate(void)
{
    if (WL_EXCHANGES && one_in(2))
        driven = fmi3InstantiateModelExchange("driven", WL_TOKEN, RESOURCES, false, true, NULL, logger);
    else
        driven = fmi3InstantiateCoSimulation("driven", WL_TOKEN, RESOURCES, false, true, false, draw(2), NULL, 0, NULL,
                                             logger, draw(2) ? update : NULL);
}
#endif

static void give_up(void)
{
    for (int i = 0; i < STATES_KEPT; i++)
        F(FreeFMUstate, FreeFMUState)(driven, &kept[i]);
    F(FreeInstance, FreeInstance)(driven);
}

int main(int count, char **arguments)
{
    unsigned long long seed = count > 1 ? strtoull(arguments[1], NULL, 10) : 1;
    long wanted = count > 2 ? atol(arguments[2]) : 1000;
    chance = seed * 0x9e3779b97f4a7c15ull + 0x2545f4914f6cdd1dull;
    instantiate();
    while (calls < wanted && faults < 20) {
        act();
        if (one_in(500)) {
            give_up();
            instantiate();
        }
    }
    give_up();
    printf("%ld calls: %ld steps, %ld sentences, %ld damaged states refused, %ld taken\n", calls, steps, sentences,
           refused, restored);
    return faults != 0;
}
