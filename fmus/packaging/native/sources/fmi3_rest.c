/* What no step needs of FMI 3.0: instances, phases, states, and what hosts that integrate ask for. */
#include "fmi3_host.h"

void report(void *to, Severity severity, const char *sentence)
{
    static const fmi3Status statuses[] = {fmi3Warning, fmi3Discard, fmi3Error};
    static const char *const categories[] = {"logStatusWarning", "logStatusDiscard", "logStatusError"};
    const Host *host = to;
    if (host->log)
        host->log(host->environment, statuses[severity], categories[severity], sentence);
}

#define allocate(host, size) calloc(1, size)
#define release(host, memory) free(memory)
#include "fmi_rest.h"

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean event_mode, fmi3Boolean early_return,
                                         const fmi3ValueReference required[], size_t required_count,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update)
{
    (void)visible, (void)logging, (void)required, (void)required_count;
    const char *problem = event_mode ? WL_NAME ": has no event mode; instantiate it without" : NULL;
    Host host = {environment, log, name ? name : "", WL_CLOCKS ? NULL : update, early_return};
    return instantiated(host, token, resources, problem);
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                          fmi3Boolean logging, fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback log)
{
    (void)visible, (void)logging;
    Host host = {environment, log, name ? name : "", NULL, false};
    Instance *instance = instantiated(host, token, resources, WL_EXCHANGES ? NULL : ONLY_STEPS);
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
    (void)visible, (void)logging, (void)clock, (void)lock, (void)unlock;
    Host host = {environment, log, name ? name : "", NULL, false};
    return instantiated(host, token, resources, WL_NAME ": is for co-simulation, not for scheduled execution");
}

/* ---- phases ---- */

fmi3Status fmi3EnterInitializationMode(fmi3Instance handle, fmi3Boolean tolerance_defined, fmi3Float64 tolerance,
                                       fmi3Float64 start, fmi3Boolean stop_defined, fmi3Float64 stop)
{
    (void)tolerance_defined, (void)tolerance;
    Instance *instance = handle;
    int well = in_phase(instance, INSTANTIATED, __func__)
               && set_times(&instance->model, start, stop_defined ? stop : HUGE_VAL);
    return well ? entered(instance, INSTANTIATED, INITIALIZATION, "") : fmi3Error;
}

/* ---- hosts that integrate ---- */

#include "fmi_exchange.h"

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *again, fmi3Boolean *end,
                                    fmi3Boolean *nominals_changed, fmi3Boolean *states_changed, fmi3Boolean *timed,
                                    fmi3Float64 *next)
{
    (void)next;
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
