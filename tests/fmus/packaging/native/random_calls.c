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

/* ---- chance ---- */

static unsigned long long chance;

static unsigned draw(unsigned below)
{
    chance ^= chance << 13, chance ^= chance >> 7, chance ^= chance << 17;
    return (unsigned)((chance >> 11) % below);
}

static int one_in(unsigned n)
{
    return draw(n) == 0;
}

static double odd_number(void)
{
    static const double odd[] = {0, -0.0, 1, -1, 0.5, 1e-300, 5e-324, 1e-9, 2147483648.0, -4e9, 1e18, 9e15, 1e300, -1e300};
    unsigned which = draw(sizeof odd / sizeof *odd + 4);
    return which == 0 ? NAN : which == 1 ? HUGE_VAL : which == 2 ? -HUGE_VAL
           : which == 3 ? (draw(2001) - 1000.0) / 8 : odd[which - 4];
}

/* Mostly what the variable may be, so that runs get on. */
static double value_for(Reference reference)
{
    const Variable *variable = &WL(variables)[reference % VARIABLES];
    if (one_in(30))
        return odd_number();
    if (one_in(4) && (variable->flags & HAS_MINIMUM))
        return variable->minimum;
    if (one_in(8) && (variable->flags & HAS_MAXIMUM))
        return variable->maximum;
    return one_in(3) && variable->kind == REAL ? variable->start * (1 + draw(100) / 1e3) : variable->start;
}

static Reference some_reference(void)
{
    static const Reference wrong[] = {VARIABLES + 1 + 2 * WL_STATES, 99999, 0x7fffffff, 0x80000000, 0xffffffff};
    return one_in(20) ? wrong[draw(5)] : draw(VARIABLES + 1 + (WL_EXCHANGES ? 2 * WL_STATES : 0));
}

static size_t some_count(void)
{
    return one_in(6) ? 0 : one_in(5) ? 1 + draw(8) : 1;
}

/* An array of exactly that size, so that reading beyond it is seen; now and then none at all. */
static void *array(size_t bytes)
{
    return one_in(20) ? NULL : malloc(bytes ? bytes : 1);
}

/* ---- answers ---- */

static void judge(Status status, long before, int possible)
{
    FAULTY(status == ERROR && sentences == before, "an error without a sentence");
    FAULTY(status != ERROR && !possible, "a null pointer was followed");
}

/* One call: what it answers, and whether it could be answered at all. */
#define CALL(possible, call) \
    do { \
        long before_ = sentences; \
        Status status_ = (call); \
        judge(status_, before_, possible); \
    } while (0)

/* ---- values ---- */

#if FMI == 2
#define ARRAY(values, count) values
#else
#define ARRAY(values, count) values, count
#endif

static void values(int set)
{
    size_t count = some_count(), given = FMI == 3 && one_in(30) ? some_count() : count;
    Reference *references = array(count * sizeof *references);
    double *reals = array(given * sizeof *reals);
    int *integers = array(given * sizeof *integers);
    Truth *truths = array(given * sizeof *truths);
    unsigned type = draw(3);
    for (size_t i = 0; i < count && references; i++) {
        references[i] = some_reference();
        if (references[i] < VARIABLES && !one_in(10))
            type = count == 1 ? (unsigned)WL(variables)[references[i]].kind : type;
    }
    for (size_t i = 0; i < given; i++) {
        double value = value_for(references && i < count ? references[i] : 0);
        if (reals)
            reals[i] = value;
        if (integers)
            integers[i] = model_whole(value);
        if (truths)
            truths[i] = draw(2);
    }
    int there = given == count && (count == 0 || references);
    (void)given;
    if (type == 0)
        CALL(there && (count == 0 || reals),
             set ? F(SetReal, SetFloat64)(driven, references, count, ARRAY(reals, given))
                 : F(GetReal, GetFloat64)(driven, references, count, ARRAY(reals, given)));
    else if (type == 1)
        CALL(there && (count == 0 || integers),
             set ? F(SetInteger, SetInt32)(driven, references, count, ARRAY(integers, given))
                 : F(GetInteger, GetInt32)(driven, references, count, ARRAY(integers, given)));
    else
        CALL(there && (count == 0 || truths),
             set ? F(SetBoolean, SetBoolean)(driven, references, count, ARRAY(truths, given))
                 : F(GetBoolean, GetBoolean)(driven, references, count, ARRAY(truths, given)));
    free(references), free(reals), free(integers), free(truths);
}

static void strings(void)
{
    size_t count = some_count();
    CALL(count == 0, F(GetString, GetString)(driven, NULL, count, ARRAY(NULL, count)));
    CALL(count == 0, F(SetString, SetString)(driven, NULL, count, ARRAY(NULL, count)));
#if FMI == 3
    CALL(count == 0, fmi3GetBinary(driven, NULL, count, NULL, NULL, count));
    CALL(count == 0, fmi3SetClock(driven, NULL, count, NULL));
    CALL(count == 0, fmi3GetUInt64(driven, NULL, count, NULL, count));
    CALL(1, fmi3UpdateDiscreteStates(driven, NULL, NULL, NULL, NULL, NULL, NULL));
    CALL(1, fmi3GetAdjointDerivative(driven, NULL, count, NULL, count, NULL, count, NULL, count));
#endif
}

static void derivatives(void)
{
    size_t count = some_count(), seeds = some_count();
    Reference *unknowns = array(count * sizeof *unknowns), *knowns = array(seeds * sizeof *knowns);
    double *result = array(count * sizeof *result), *seed = array(seeds * sizeof *seed);
    int *orders = array(count * sizeof *orders);
    for (size_t i = 0; i < count && unknowns; i++)
        unknowns[i] = WL_OUTPUTS && !one_in(5) ? FIRST_OUTPUT + draw(AT_LEAST_1(WL_OUTPUTS)) : some_reference();
    for (size_t i = 0; i < count && orders; i++)
        orders[i] = one_in(10) ? (int)draw(5) - 2 : 1;
    for (size_t i = 0; i < count && result; i++)
        result[i] = odd_number();
    for (size_t i = 0; i < seeds && knowns; i++)
        knowns[i] = WL_INPUTS && !one_in(5) ? FIRST_INPUT + draw(AT_LEAST_1(WL_INPUTS)) : some_reference();
    for (size_t i = 0; i < seeds && seed; i++)
        seed[i] = odd_number();
    int outputs = count == 0 || (unknowns && result), inputs = seeds == 0 || (knowns && seed);
    CALL(outputs && inputs,
         F(GetDirectionalDerivative, GetDirectionalDerivative)(driven, unknowns, count, knowns, seeds,
                                                               ARRAY(seed, seeds), ARRAY(result, count)));
    CALL(outputs && (count == 0 || orders),
         F(GetRealOutputDerivatives, GetOutputDerivatives)(driven, unknowns, count, orders, ARRAY(result, count)));
#if FMI == 2
    CALL(outputs && (count == 0 || orders),
         fmi2SetRealInputDerivatives(driven, unknowns, count, orders, result));
    if (WL_INPUTS && one_in(3)) {
        Reference input = FIRST_INPUT + draw(AT_LEAST_1(WL_INPUTS));
        int order = 1 + (int)draw(2);
        double slope = odd_number() / 100;
        CALL(1, fmi2SetRealInputDerivatives(driven, &input, 1, &order, &slope));
    }
#endif
    free(unknowns), free(knowns), free(result), free(seed), free(orders);
}

/* ---- states ---- */

/* A phase, a time or another number becomes something else, and the digest is right all the same. */
static void damage(Memory *memory)
{
    double *numbers = (double *)memory;
    size_t size = sizeof *memory / sizeof *numbers, run = &memory->start_time - numbers;
    for (unsigned count = 1 + draw(2); count > 0; count--) {
        double *number = &numbers[one_in(2) ? run + draw((unsigned)(size - run)) : draw((unsigned)size)];
        unsigned long long bits;
        if (one_in(2)) {
            *number = odd_number();
            continue;
        }
        memcpy(&bits, number, sizeof bits);
        bits ^= 1ull << draw(64);
        memcpy(number, &bits, sizeof bits);
    }
}

static void serialised(void)
{
    State *place = &kept[draw(STATES_KEPT)], read = NULL;
    size_t size = 0;
    CALL(*place != NULL, F(SerializedFMUstateSize, SerializedFMUStateSize)(driven, *place, one_in(9) ? NULL : &size));
    if (size == 0)
        return;
    Byte *bytes = malloc(size);
    CALL(0, F(SerializeFMUstate, SerializeFMUState)(driven, *place, one_in(2) ? NULL : bytes, one_in(2) ? 0 : size - 1));
    CALL(0, F(DeSerializeFMUstate, DeserializeFMUState)(driven, one_in(2) ? NULL : bytes, 0, &read));
    CALL(0, F(DeSerializeFMUstate, DeserializeFMUState)(driven, bytes, size, NULL));
    CALL(1, F(SerializeFMUstate, SerializeFMUState)(driven, *place, bytes, size));
    Status status = F(DeSerializeFMUstate, DeserializeFMUState)(driven, bytes, size, &read);
    FAULTY(status != OK || memcmp(read, *place, sizeof(Memory)) != 0, "the instance's own state is not taken");
    if (one_in(2)) {
        bytes[draw((unsigned)size)] ^= (Byte)(1 << draw(8));
        CALL(0, F(DeSerializeFMUstate, DeserializeFMUState)(driven, bytes, size, &read));
    } else if (read) {
        Memory *memory = (Memory *)read;
        damage(memory);
        model_serialize(memory, (unsigned char *)bytes);
        long before = sentences;
        status = F(DeSerializeFMUstate, DeserializeFMUState)(driven, bytes, size, place);
        judge(status, before, 1);
        status == OK ? restored++ : refused++;
        if (status == OK && depth == 0)
            FAULTY(F(SetFMUstate, SetFMUState)(driven, *place) != OK, "a state that was read is not taken");
    }
    CALL(1, F(FreeFMUstate, FreeFMUState)(driven, &read));
    free(bytes);
}

static void states(void)
{
    State *place = &kept[draw(STATES_KEPT)];
    unsigned which = draw(10);
    if (which == 0)
        CALL(*place != NULL, F(SetFMUstate, SetFMUState)(driven, *place));
    else if (which == 1)
        CALL(1, F(FreeFMUstate, FreeFMUState)(driven, one_in(5) ? NULL : place));
    else if (which == 2)
        CALL(0, F(GetFMUstate, GetFMUState)(driven, NULL));
    else if (which == 3)
        CALL(1, F(GetFMUstate, GetFMUState)(driven, place));
    else
        serialised();
}

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

#if WL_EXCHANGES
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
#endif

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
#if WL_EXCHANGES
    case 6: integrate(); break;
#endif
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
    driven = fmi2Instantiate("driven", type, WL_TOKEN, NULL, &callbacks, 0, 1);
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
        driven = fmi3InstantiateModelExchange("driven", WL_TOKEN, NULL, false, true, NULL, logger);
    else
        driven = fmi3InstantiateCoSimulation("driven", WL_TOKEN, NULL, false, true, false, draw(2), NULL, 0, NULL,
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
