/* What no step needs of FMI 2.0: instances, phases, states, and what hosts that integrate ask for. */
#include "fmi2_host.h"

static void *allocate(const Host *host, size_t size)
{
    return host->callbacks.allocateMemory ? host->callbacks.allocateMemory(1, size) : calloc(1, size);
}

static void release(const Host *host, void *memory)
{
    if (host->callbacks.allocateMemory && host->callbacks.freeMemory)
        host->callbacks.freeMemory(memory);
    else if (!host->callbacks.allocateMemory)
        free(memory);
}

/* The host takes the message for a printf format. */
void report(void *to, Severity severity, const char *sentence)
{
    static const fmi2Status statuses[] = {fmi2Warning, fmi2Discard, fmi2Error};
    static const char *const categories[] = {"logStatusWarning", "logStatusDiscard", "logStatusError"};
    const Host *host = to;
    char message[1024];
    size_t used = 0;
    for (; *sentence && used + 2 < sizeof message; sentence++) {
        message[used++] = *sentence;
        if (*sentence == '%')
            message[used++] = '%';
    }
    message[used] = 0;
    if (host->callbacks.logger)
        host->callbacks.logger(host->callbacks.componentEnvironment, host->name, statuses[severity],
                               categories[severity], message);
}

#include "fmi_rest.h"

const char *fmi2GetTypesPlatform(void)
{
    return fmi2TypesPlatform;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging)
{
    (void)visible, (void)logging;
    int exchanges = type != fmi2CoSimulation;
    const char *problem = exchanges && !WL_EXCHANGES ? ONLY_STEPS : NULL;
    Instance *instance = callbacks ? instantiated((Host){*callbacks, name ? name : ""}, guid, resources, problem)
                                   : NULL;
    if (instance)
        instance->model.exchanges = exchanges;
    return instance;
}

/* ---- phases ---- */

fmi2Status fmi2SetupExperiment(fmi2Component component, fmi2Boolean tolerance_defined, fmi2Real tolerance,
                               fmi2Real start, fmi2Boolean stop_defined, fmi2Real stop)
{
    (void)tolerance_defined, (void)tolerance;
    Instance *instance = component;
    return status(in_phase(instance, INSTANTIATED, __func__)
                  && set_times(&instance->model, start, stop_defined ? stop : HUGE_VAL));
}

fmi2Status fmi2EnterInitializationMode(fmi2Component component)
{
    return entered(component, INSTANTIATED, INITIALIZATION, __func__);
}

fmi2Status fmi2CancelStep(fmi2Component component)
{
    return unsupported(component, "steps are not asynchronous; there is none to cancel");
}

/* Of steps that are never asynchronous, what is known of one kind. */
#define STATUS(name, type, known, answer)                                                    \
    fmi2Status name(fmi2Component component, const fmi2StatusKind kind, type *value)         \
    {                                                                                        \
        Instance *instance = component;                                                      \
        if (!there(instance, value != NULL, __func__))                                       \
            return fmi2Error;                                                                \
        if (kind == (known))                                                                 \
            *value = answer;                                                                 \
        return kind == (known) ? fmi2OK : fmi2Discard;                                       \
    }

#define NO_KIND (fmi2StatusKind)-1

STATUS(fmi2GetRealStatus, fmi2Real, fmi2LastSuccessfulTime, instance->model.memory.time)
STATUS(fmi2GetBooleanStatus, fmi2Boolean, fmi2Terminated, fmi2False)
STATUS(fmi2GetStatus, fmi2Status, NO_KIND, fmi2OK)
STATUS(fmi2GetIntegerStatus, fmi2Integer, NO_KIND, 0)
STATUS(fmi2GetStringStatus, fmi2String, NO_KIND, NULL)

/* ---- strings and derivatives of inputs ---- */

#define NO_STRINGS(name, type)                                                                                  \
    fmi2Status name(fmi2Component component, const fmi2ValueReference references[], size_t count, type values[]) \
    {                                                                                                           \
        (void)references, (void)values;                                                                         \
        return count ? unsupported(component, WL_NAME " has no strings") : status(component != NULL);           \
    }

NO_STRINGS(fmi2GetString, fmi2String)
NO_STRINGS(fmi2SetString, const fmi2String)

fmi2Status fmi2SetRealInputDerivatives(fmi2Component component, const fmi2ValueReference references[],
                                       size_t count, const fmi2Integer orders[], const fmi2Real values[])
{
    Instance *instance = component;
    int well = paired(instance, references, count, values, count)
               && given(instance, count, orders, values);
    for (size_t i = 0; well && i < count; i++)
        well = model_set_derivative(&instance->model, references[i], orders[i], values[i]);
    return status(well);
}

/* ---- hosts that integrate ---- */

#include "fmi_exchange.h"

fmi2Status fmi2NewDiscreteStates(fmi2Component component, fmi2EventInfo *info)
{
    if (!in_phase(component, EVENTS, __func__) || !there(component, info != NULL, __func__))
        return fmi2Error;
    *info = (fmi2EventInfo){fmi2False, fmi2False, fmi2False, fmi2False, fmi2False, 0};
    return fmi2OK;
}
