/* FMI 3.0 around the shared model part: co-simulation, and model exchange where there is nothing sampled. */
#include "fmi3Functions.h"
#include "identity.h"
#include "model.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    Model model;
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
    fmi3IntermediateUpdateCallback update;
    bool may_return_early;
    char *name;
} Instance;

static void report(void *host, Severity severity, const char *sentence)
{
    static const fmi3Status statuses[] = {fmi3Warning, fmi3Discard, fmi3Error};
    static const char *const categories[] = {"logStatusWarning", "logStatusDiscard", "logStatusError"};
    Instance *instance = host;
    if (instance->log)
        instance->log(instance->environment, statuses[severity], categories[severity], sentence);
}

static fmi3Status status(int well)
{
    return well == DISCARDED ? fmi3Discard : well ? fmi3OK : fmi3Error;
}

static int in_phase(Instance *instance, Phase phase, const char *function)
{
    return instance && model_in_phase(&instance->model, phase, function);
}

static fmi3Status unsupported(Instance *instance, const char *what)
{
    if (instance)
        model_report(&instance->model, ": %s", what);
    return fmi3Error;
}

/* One value each: whether so many references go with so many values, and both are there. */
static int paired(Instance *instance, const void *references, size_t count, const void *values, size_t value_count)
{
    if (instance && count != value_count)
        model_report(&instance->model, ": %lu value references and %lu values; give one each", (unsigned long)count,
                     (unsigned long)value_count);
    return instance && count == value_count && model_given(&instance->model, count, references, values);
}

/* What may change the whole instance must not come from within a step. */
static int between_steps(Instance *instance, const char *function)
{
    if (instance && instance->model.memory.phase == UPDATING)
        model_report(&instance->model, ": %s within a step; let the step end first", function);
    return instance && instance->model.memory.phase != UPDATING;
}

const char *fmi3GetVersion(void)
{
    return fmi3Version;
}

static Instance *instantiated(fmi3String name, fmi3String token, fmi3InstanceEnvironment environment,
                              fmi3LogMessageCallback log, const char *problem)
{
    Instance *instance = NULL;
    if (!name || !*name)
        problem = WL_NAME ": an instance needs a name";
    else if (!token || strcmp(token, WL_TOKEN) != 0)
        problem = WL_NAME ": the instantiation token is not that of this FMU; take it from its modelDescription.xml";
    else if (!problem && !(instance = calloc(1, sizeof *instance + strlen(name) + 1)))
        problem = WL_NAME ": no memory for an instance";
    if (problem) {
        if (log)
            log(environment, fmi3Error, "logStatusError", problem);
        return NULL;
    }
    instance->name = (char *)(instance + 1);
    strcpy(instance->name, name);
    instance->environment = environment;
    instance->log = log;
    instance->model.name = instance->name;
    instance->model.report = report;
    instance->model.host = instance;
    model_reset(&instance->model);
    return instance;
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean event_mode, fmi3Boolean early_return,
                                         const fmi3ValueReference required[], size_t required_count,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update)
{
    const char *problem = event_mode ? WL_NAME ": has no event mode; instantiate it without" : NULL;
    Instance *instance = instantiated(name, token, environment, log, problem);
    (void)resources, (void)visible, (void)logging, (void)required, (void)required_count;
    if (instance) {
        instance->update = WL_CLOCKS ? NULL : update;
        instance->may_return_early = early_return;
    }
    return instance;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                          fmi3Boolean logging, fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback log)
{
    const char *problem = WL_EXCHANGES ? NULL : WL_NAME ": is for co-simulation, not for model exchange";
    Instance *instance = instantiated(name, token, environment, log, problem);
    (void)resources, (void)visible, (void)logging;
    if (instance)
        instance->model.exchanges = 1;
    return instance;
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources,
                                               fmi3Boolean visible, fmi3Boolean logging,
                                               fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                               fmi3ClockUpdateCallback clock, fmi3LockPreemptionCallback lock,
                                               fmi3UnlockPreemptionCallback unlock)
{
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)clock, (void)lock, (void)unlock;
    if (log)
        log(environment, fmi3Error, "logStatusError", WL_NAME ": is for co-simulation, not for scheduled execution");
    return NULL;
}

void fmi3FreeInstance(fmi3Instance instance)
{
    free(instance);
}

/* There is nothing to switch: an instance speaks of errors alone, and of those always. */
fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean logging, size_t count, const fmi3String categories[])
{
    (void)logging, (void)count, (void)categories;
    return status(instance != NULL);
}

/* ---- phases ---- */

fmi3Status fmi3EnterInitializationMode(fmi3Instance handle, fmi3Boolean tolerance_defined, fmi3Float64 tolerance,
                                       fmi3Float64 start, fmi3Boolean stop_defined, fmi3Float64 stop)
{
    Instance *instance = handle;
    (void)tolerance_defined, (void)tolerance;
    if (!in_phase(instance, INSTANTIATED, "fmi3EnterInitializationMode")
        || !model_set_times(&instance->model, start, stop_defined ? stop : HUGE_VAL))
        return fmi3Error;
    instance->model.memory.phase = INITIALIZATION;
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance handle)
{
    Instance *instance = handle;
    if (!in_phase(instance, INITIALIZATION, "fmi3ExitInitializationMode"))
        return fmi3Error;
    return status(model_initialize(&instance->model));
}

fmi3Status fmi3Terminate(fmi3Instance handle)
{
    Instance *instance = handle;
    return status(instance && model_terminate(&instance->model, "fmi3Terminate"));
}

fmi3Status fmi3Reset(fmi3Instance handle)
{
    Instance *instance = handle;
    if (!between_steps(instance, "fmi3Reset"))
        return fmi3Error;
    model_reset(&instance->model);
    return fmi3OK;
}

#define NOT_HERE(name, parameters, unused, what) \
    fmi3Status name parameters                   \
    {                                            \
        unused;                                  \
        return unsupported(instance, what);      \
    }

NOT_HERE(fmi3EnterStepMode, (fmi3Instance instance), (void)0, WL_NAME " has no event mode to leave")
NOT_HERE(fmi3EnterConfigurationMode, (fmi3Instance instance), (void)0, WL_NAME " has no structural parameters")
NOT_HERE(fmi3ExitConfigurationMode, (fmi3Instance instance), (void)0, WL_NAME " has no structural parameters")
NOT_HERE(fmi3EvaluateDiscreteStates, (fmi3Instance instance), (void)0, WL_NAME " has no event mode")
/* Of types that no variable has nothing may be asked; nothing at all may. */
#define NONE_HERE(name, parameters, count, unused, what)                       \
    fmi3Status name parameters                                                 \
    {                                                                          \
        unused;                                                                \
        return count ? unsupported(instance, what) : status(instance != NULL); \
    }

/* Hosts look for the functions of the other interface types too. */
#define ONLY_COSIMULATION WL_NAME " is for co-simulation alone"
#if !WL_EXCHANGES
NOT_HERE(fmi3EnterEventMode, (fmi3Instance instance), (void)0, WL_NAME " has no event mode")
NOT_HERE(fmi3UpdateDiscreteStates,
         (fmi3Instance instance, fmi3Boolean *a, fmi3Boolean *b, fmi3Boolean *c, fmi3Boolean *d, fmi3Boolean *e,
          fmi3Float64 *f),
         ((void)a, (void)b, (void)c, (void)d, (void)e, (void)f), WL_NAME " has no event mode")
NOT_HERE(fmi3EnterContinuousTimeMode, (fmi3Instance instance), (void)0, ONLY_COSIMULATION)
NOT_HERE(fmi3CompletedIntegratorStep, (fmi3Instance instance, fmi3Boolean a, fmi3Boolean *b, fmi3Boolean *c),
         ((void)a, (void)b, (void)c), ONLY_COSIMULATION)
NOT_HERE(fmi3SetTime, (fmi3Instance instance, fmi3Float64 t), (void)t, ONLY_COSIMULATION)
NOT_HERE(fmi3SetContinuousStates, (fmi3Instance instance, const fmi3Float64 x[], size_t n), ((void)x, (void)n),
         ONLY_COSIMULATION)
NOT_HERE(fmi3GetContinuousStates, (fmi3Instance instance, fmi3Float64 x[], size_t n), ((void)x, (void)n),
         ONLY_COSIMULATION)
NOT_HERE(fmi3GetContinuousStateDerivatives, (fmi3Instance instance, fmi3Float64 x[], size_t n),
         ((void)x, (void)n), ONLY_COSIMULATION)
NOT_HERE(fmi3GetNominalsOfContinuousStates, (fmi3Instance instance, fmi3Float64 x[], size_t n),
         ((void)x, (void)n), ONLY_COSIMULATION)
NOT_HERE(fmi3GetEventIndicators, (fmi3Instance instance, fmi3Float64 x[], size_t n), ((void)x, (void)n),
         ONLY_COSIMULATION)
NOT_HERE(fmi3GetNumberOfEventIndicators, (fmi3Instance instance, size_t *n), (void)n, ONLY_COSIMULATION)
NOT_HERE(fmi3GetNumberOfContinuousStates, (fmi3Instance instance, size_t *n), (void)n, ONLY_COSIMULATION)
#endif
NOT_HERE(fmi3ActivateModelPartition, (fmi3Instance instance, fmi3ValueReference r, fmi3Float64 t),
         ((void)r, (void)t), ONLY_COSIMULATION)

/* ---- step ---- */

static void between(void *host, double time, int finished, double *until)
{
    Instance *instance = host;
    fmi3Boolean wanted = fmi3False, early = finished && instance->may_return_early;
    fmi3Float64 earlier = time;
    instance->update(instance->environment, time, !finished, finished, finished, early, &wanted, &earlier);
    if (early && wanted && earlier < *until)
        *until = earlier > time ? earlier : time;
}

fmi3Status fmi3DoStep(fmi3Instance handle, fmi3Float64 time, fmi3Float64 step, fmi3Boolean no_return,
                      fmi3Boolean *event_needed, fmi3Boolean *terminate, fmi3Boolean *early_return,
                      fmi3Float64 *last_time)
{
    Instance *instance = handle;
    double reached = time;
    (void)no_return;
    if (!instance)
        return fmi3Error;
    Outcome outcome = model_step(&instance->model, time, step, instance->update ? between : NULL, &reached);
    if (event_needed)
        *event_needed = fmi3False;
    if (terminate)
        *terminate = fmi3False;
    if (early_return)
        *early_return = outcome == DONE && reached < time + step;
    if (last_time)
        *last_time = instance->model.memory.time;
    return status(outcome);
}

/* ---- values ---- */

fmi3Status fmi3GetFloat64(fmi3Instance handle, const fmi3ValueReference references[], size_t count,
                          fmi3Float64 values[], size_t value_count)
{
    Instance *instance = handle;
    int well = paired(instance, references, count, values, value_count);
    for (size_t i = 0; well && i < count; i++)
        if (references[i] == VARIABLES)
            values[i] = instance->model.memory.time;
        else
            well = model_get(&instance->model, references[i], REAL, &values[i]);
    return status(well);
}

fmi3Status fmi3GetInt32(fmi3Instance handle, const fmi3ValueReference references[], size_t count, fmi3Int32 values[],
                        size_t value_count)
{
    Instance *instance = handle;
    int well = paired(instance, references, count, values, value_count);
    for (size_t i = 0; well && i < count; i++) {
        double value = 0;
        well = model_get(&instance->model, references[i], INTEGER, &value);
        values[i] = model_whole(value);
    }
    return status(well);
}

fmi3Status fmi3GetBoolean(fmi3Instance handle, const fmi3ValueReference references[], size_t count,
                          fmi3Boolean values[], size_t value_count)
{
    Instance *instance = handle;
    int well = paired(instance, references, count, values, value_count);
    for (size_t i = 0; well && i < count; i++) {
        double value = 0;
        well = model_get(&instance->model, references[i], BOOLEAN, &value);
        values[i] = value != 0;
    }
    return status(well);
}

static int set(Instance *instance, fmi3ValueReference reference, Kind kind, double value)
{
    if (reference != VARIABLES)
        return model_set(&instance->model, reference, kind, value);
    model_report(&instance->model, ".time: cannot be set; it goes on with the steps");
    return 0;
}

#define SETTER(name, type, kind)                                                                                   \
    fmi3Status name(fmi3Instance handle, const fmi3ValueReference references[], size_t count, const type values[], \
                    size_t value_count)                                                                            \
    {                                                                                                              \
        int well = paired(handle, references, count, values, value_count);                                         \
        for (size_t i = 0; well && i < count; i++)                                                                 \
            well = set(handle, references[i], kind, values[i]);                                                    \
        return status(well);                                                                                       \
    }

SETTER(fmi3SetFloat64, fmi3Float64, REAL)
SETTER(fmi3SetInt32, fmi3Int32, INTEGER)
SETTER(fmi3SetBoolean, fmi3Boolean, BOOLEAN)

#define ABSENT_TYPE(type)                                                                                        \
    NONE_HERE(fmi3Get##type,                                                                                     \
              (fmi3Instance instance, const fmi3ValueReference r[], size_t n, fmi3##type v[], size_t m), n,      \
              ((void)r, (void)v, (void)m), WL_NAME " has no variables of type " #type)                           \
    NONE_HERE(fmi3Set##type,                                                                                     \
              (fmi3Instance instance, const fmi3ValueReference r[], size_t n, const fmi3##type v[], size_t m), n, \
              ((void)r, (void)v, (void)m), WL_NAME " has no variables of type " #type)

ABSENT_TYPE(Float32)
ABSENT_TYPE(Int8)
ABSENT_TYPE(UInt8)
ABSENT_TYPE(Int16)
ABSENT_TYPE(UInt16)
ABSENT_TYPE(UInt32)
ABSENT_TYPE(Int64)
ABSENT_TYPE(UInt64)
ABSENT_TYPE(String)

NONE_HERE(fmi3GetBinary,
         (fmi3Instance instance, const fmi3ValueReference r[], size_t n, size_t s[], fmi3Binary v[], size_t m),
         n, ((void)r, (void)s, (void)v, (void)m), WL_NAME " has no variables of type Binary")
NONE_HERE(fmi3SetBinary,
         (fmi3Instance instance, const fmi3ValueReference r[], size_t n, const size_t s[], const fmi3Binary v[],
          size_t m),
         n, ((void)r, (void)s, (void)v, (void)m), WL_NAME " has no variables of type Binary")
NONE_HERE(fmi3GetClock, (fmi3Instance instance, const fmi3ValueReference r[], size_t n, fmi3Clock v[]),
         n, ((void)r, (void)v), WL_NAME " has no clocks")
NONE_HERE(fmi3SetClock, (fmi3Instance instance, const fmi3ValueReference r[], size_t n, const fmi3Clock v[]),
         n, ((void)r, (void)v), WL_NAME " has no clocks")
NONE_HERE(fmi3GetIntervalDecimal,
         (fmi3Instance instance, const fmi3ValueReference r[], size_t n, fmi3Float64 i[], fmi3IntervalQualifier q[]),
         n, ((void)r, (void)i, (void)q), WL_NAME " has no clocks")
NONE_HERE(fmi3GetIntervalFraction,
         (fmi3Instance instance, const fmi3ValueReference r[], size_t n, fmi3UInt64 c[], fmi3UInt64 s[],
          fmi3IntervalQualifier q[]),
         n, ((void)r, (void)c, (void)s, (void)q), WL_NAME " has no clocks")
NONE_HERE(fmi3GetShiftDecimal, (fmi3Instance instance, const fmi3ValueReference r[], size_t n, fmi3Float64 s[]),
         n, ((void)r, (void)s), WL_NAME " has no clocks")
NONE_HERE(fmi3GetShiftFraction,
         (fmi3Instance instance, const fmi3ValueReference r[], size_t n, fmi3UInt64 c[], fmi3UInt64 s[]),
         n, ((void)r, (void)c, (void)s), WL_NAME " has no clocks")
NONE_HERE(fmi3SetIntervalDecimal,
         (fmi3Instance instance, const fmi3ValueReference r[], size_t n, const fmi3Float64 i[]),
         n, ((void)r, (void)i), WL_NAME " has no clocks")
NONE_HERE(fmi3SetIntervalFraction,
         (fmi3Instance instance, const fmi3ValueReference r[], size_t n, const fmi3UInt64 c[], const fmi3UInt64 s[]),
         n, ((void)r, (void)c, (void)s), WL_NAME " has no clocks")
NONE_HERE(fmi3SetShiftDecimal, (fmi3Instance instance, const fmi3ValueReference r[], size_t n, const fmi3Float64 s[]),
         n, ((void)r, (void)s), WL_NAME " has no clocks")
NONE_HERE(fmi3SetShiftFraction,
         (fmi3Instance instance, const fmi3ValueReference r[], size_t n, const fmi3UInt64 c[], const fmi3UInt64 s[]),
         n, ((void)r, (void)c, (void)s), WL_NAME " has no clocks")
NOT_HERE(fmi3GetNumberOfVariableDependencies, (fmi3Instance instance, fmi3ValueReference r, size_t *n),
         ((void)r, (void)n), "dependencies are in modelDescription.xml")
NOT_HERE(fmi3GetVariableDependencies,
         (fmi3Instance instance, fmi3ValueReference r, size_t a[], fmi3ValueReference b[], size_t c[],
          fmi3DependencyKind d[], size_t n),
         ((void)r, (void)a, (void)b, (void)c, (void)d, (void)n), "dependencies are in modelDescription.xml")

/* ---- derivatives ---- */

fmi3Status fmi3GetOutputDerivatives(fmi3Instance handle, const fmi3ValueReference references[], size_t count,
                                    const fmi3Int32 orders[], fmi3Float64 values[], size_t value_count)
{
    Instance *instance = handle;
    int well = paired(instance, references, count, values, value_count)
               && model_given(&instance->model, count, orders, values);
    for (size_t i = 0; well && i < count; i++)
        well = model_output_derivative(&instance->model, references[i], orders[i], &values[i]);
    return status(well);
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance handle, const fmi3ValueReference unknowns[], size_t unknown_count,
                                        const fmi3ValueReference knowns[], size_t known_count,
                                        const fmi3Float64 seed[], size_t seed_count, fmi3Float64 sensitivity[],
                                        size_t sensitivity_count)
{
    Instance *instance = handle;
    Direction direction = {{0}, {0}, 0, {0}, {0}, 0};
    int well = paired(instance, knowns, known_count, seed, seed_count)
               && paired(instance, unknowns, unknown_count, sensitivity, sensitivity_count);
    for (size_t i = 0; well && i < known_count; i++)
        well = model_seed(&instance->model, knowns[i], seed[i], &direction);
    for (size_t i = 0; well && i < unknown_count; i++)
        well = model_sensitivity(&instance->model, unknowns[i], &direction, &sensitivity[i]);
    return status(well);
}

NOT_HERE(fmi3GetAdjointDerivative,
         (fmi3Instance instance, const fmi3ValueReference u[], size_t un, const fmi3ValueReference k[], size_t kn,
          const fmi3Float64 s[], size_t sn, fmi3Float64 v[], size_t vn),
         ((void)u, (void)un, (void)k, (void)kn, (void)s, (void)sn, (void)v, (void)vn),
         "gives directional derivatives, not adjoint ones")

/* ---- states ---- */

fmi3Status fmi3GetFMUState(fmi3Instance handle, fmi3FMUState *state)
{
    Instance *instance = handle;
    if (!instance || !state)
        return unsupported(instance, "there is nowhere to put the state");
    if (!between_steps(instance, "fmi3GetFMUState"))
        return fmi3Error;
    if (!*state)
        *state = malloc(sizeof(Memory));
    if (!*state)
        return unsupported(instance, "no memory for a state");
    memcpy(*state, &instance->model.memory, sizeof(Memory));
    return fmi3OK;
}

fmi3Status fmi3SetFMUState(fmi3Instance handle, fmi3FMUState state)
{
    Instance *instance = handle;
    if (!instance || !state)
        return unsupported(instance, "there is no state to go back to");
    if (!between_steps(instance, "fmi3SetFMUState"))
        return fmi3Error;
    model_restore(&instance->model, state);
    return fmi3OK;
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *state)
{
    if (!instance)
        return fmi3Error;
    if (state) {
        free(*state);
        *state = NULL;
    }
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t *size)
{
    if (!instance || !state || !size)
        return unsupported(instance, "there is no state to serialise, or nowhere to put its size");
    *size = model_serialized_size();
    return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[], size_t size)
{
    if (!instance || !state)
        return unsupported(instance, "there is no state to serialise");
    if (!bytes || size < model_serialized_size())
        return unsupported(instance, "too few bytes for the serialised state; ask for its size");
    model_serialize(state, bytes);
    return fmi3OK;
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance handle, const fmi3Byte bytes[], size_t size, fmi3FMUState *state)
{
    Instance *instance = handle;
    Memory memory;
    if (!instance || !bytes || !state)
        return unsupported(instance, "no serialised state is given, or nowhere to put the state");
    if (!model_deserialize(&instance->model, bytes, size, &memory))
        return fmi3Error;
    if (!*state)
        *state = malloc(sizeof(Memory));
    if (!*state)
        return unsupported(instance, "no memory for a state");
    memcpy(*state, &memory, sizeof memory);
    return fmi3OK;
}

/* ---- hosts that integrate ---- */

#define F(two, three) three
#include "exchange.h"

#if WL_EXCHANGES
fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *again, fmi3Boolean *end,
                                    fmi3Boolean *nominals_changed, fmi3Boolean *states_changed, fmi3Boolean *timed,
                                    fmi3Float64 *next)
{
    fmi3Boolean *const answers[] = {again, end, nominals_changed, states_changed, timed};
    (void)next;
    for (size_t i = 0; i < sizeof answers / sizeof *answers; i++)
        if (answers[i])
            *answers[i] = fmi3False;
    return status(in_phase(instance, EVENTS, "fmi3UpdateDiscreteStates"));
}

static fmi3Status counted(fmi3Instance instance, size_t *count, size_t value)
{
    if (!instance || !count)
        return unsupported(instance, "there is nowhere to put the number");
    *count = value;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *count)
{
    return counted(instance, count, WL_STATES);
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *count)
{
    return counted(instance, count, 0);
}
#endif
