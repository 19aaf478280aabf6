/* FMI 3.0 around the shared model part: co-simulation, and model exchange where there is nothing sampled. */
#include "fmi3Functions.h"
#include "model_instance.h"

typedef struct {
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
    const char *name;
    fmi3IntermediateUpdateCallback update;
    bool may_return_early;
} Host;

static void report(void *to, Severity severity, const char *sentence)
{
    static const fmi3Status statuses[] = {fmi3Warning, fmi3Discard, fmi3Error};
    static const char *const categories[] = {"logStatusWarning", "logStatusDiscard", "logStatusError"};
    const Host *host = to;
    if (host->log)
        host->log(host->environment, statuses[severity], categories[severity], sentence);
}

#define allocate(host, size) calloc(1, size)
#define release(host, memory) free(memory)
#define F(two, three) three
#define SIZED(values, size) values, size_t size
#include "fmi_answers.h"

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean event_mode, fmi3Boolean early_return,
                                         const fmi3ValueReference required[], size_t required_count,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update)
{
    const char *problem = event_mode ? WL_NAME ": has no event mode; instantiate it without" : NULL;
    Host host = {environment, log, name ? name : "", WL_CLOCKS ? NULL : update, early_return};
    return instantiated(host, token, problem);
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                          fmi3Boolean logging, fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback log)
{
    Host host = {environment, log, name ? name : "", NULL, false};
    Instance *instance = instantiated(host, token, WL_EXCHANGES ? NULL : ONLY_STEPS);
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
    Host host = {environment, log, name ? name : "", NULL, false};
    return instantiated(host, token, WL_NAME ": is for co-simulation, not for scheduled execution");
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

static void between(void *to, double time, int finished, double *until)
{
    const Host *host = to;
    fmi3Boolean wanted = fmi3False, early = finished && host->may_return_early;
    fmi3Float64 earlier = time;
    host->update(host->environment, time, !finished, finished, finished, early, &wanted, &earlier);
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
    Outcome outcome = model_step(&instance->model, time, step, instance->host.update ? between : NULL, &reached);
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
