/* FMI 3.0 around the shared model part: co-simulation, and model exchange where there is nothing sampled. */
#include "fmi3Functions.h"
#include "model_instance.h"

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

#define allocate(instance, size) malloc(size)
#define release(instance, memory) free(memory)
#define F(two, three) three
#define SIZED(values, size) values, size_t size
#include "fmi_answers.h"

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
    return instantiated(name, token, environment, log, WL_NAME ": is for co-simulation, not for scheduled execution");
}

/* ---- phases ---- */

fmi3Status fmi3EnterInitializationMode(fmi3Instance handle, fmi3Boolean tolerance_defined, fmi3Float64 tolerance,
                                       fmi3Float64 start, fmi3Boolean stop_defined, fmi3Float64 stop)
{
    Instance *instance = handle;
    int well = in_phase(instance, INSTANTIATED, __func__)
               && set_times(&instance->model, start, stop_defined ? stop : HUGE_VAL);
    return well ? entered(instance, INSTANTIATED, INITIALIZATION, "") : fmi3Error;
}

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

/* ---- values and states ---- */

#include "fmi_values.h"

/* ---- hosts that integrate ---- */

#include "fmi_exchange.h"

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *again, fmi3Boolean *end,
                                    fmi3Boolean *nominals_changed, fmi3Boolean *states_changed, fmi3Boolean *timed,
                                    fmi3Float64 *next)
{
    fmi3Boolean *const answers[] = {again, end, nominals_changed, states_changed, timed};
    for (size_t i = 0; i < sizeof answers / sizeof *answers; i++)
        if (answers[i])
            *answers[i] = fmi3False;
    return status(in_phase(instance, EVENTS, __func__));
}

#define COUNTED(name, number)                                                  \
    fmi3Status name(fmi3Instance instance, size_t *count)                      \
    {                                                                          \
        if (!exchanges(instance) || !there(instance, count != NULL, __func__)) \
            return fmi3Error;                                                  \
        *count = number;                                                       \
        return fmi3OK;                                                         \
    }

COUNTED(fmi3GetNumberOfContinuousStates, WL_STATES)
COUNTED(fmi3GetNumberOfEventIndicators, 0)

#include "fmi3_absent.h"
