/* FMI 2.0 around the shared model part: co-simulation, and model exchange where there is nothing sampled. */
#include "fmi2Functions.h"
#include "model_instance.h"

typedef struct {
    Model model;
    fmi2CallbackFunctions callbacks;
    char *name;
} Instance;

static void *allocated(const fmi2CallbackFunctions *callbacks, size_t size)
{
    return callbacks->allocateMemory ? callbacks->allocateMemory(1, size) : calloc(1, size);
}

static void release(const Instance *instance, void *memory)
{
    const fmi2CallbackFunctions *callbacks = &instance->callbacks;
    if (callbacks->allocateMemory && callbacks->freeMemory)
        callbacks->freeMemory(memory);
    else if (!callbacks->allocateMemory)
        free(memory);
}

/* The host takes the message for a printf format. */
static void report(void *host, Severity severity, const char *sentence)
{
    static const fmi2Status statuses[] = {fmi2Warning, fmi2Discard, fmi2Error};
    static const char *const categories[] = {"logStatusWarning", "logStatusDiscard", "logStatusError"};
    Instance *instance = host;
    char message[1024];
    size_t used = 0;
    for (; *sentence && used + 2 < sizeof message; sentence++) {
        message[used++] = *sentence;
        if (*sentence == '%')
            message[used++] = '%';
    }
    message[used] = 0;
    if (instance->callbacks.logger)
        instance->callbacks.logger(instance->callbacks.componentEnvironment, instance->name, statuses[severity],
                                   categories[severity], message);
}

#define allocate(instance, size) allocated(&(instance)->callbacks, size)
#define F(two, three) two
#define SIZED(values, size) values
#include "fmi_answers.h"

const char *fmi2GetTypesPlatform(void)
{
    return fmi2TypesPlatform;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging)
{
    const char *problem = NULL;
    Instance *instance = NULL;
    if (!callbacks)
        return NULL;
    if (!name || !*name)
        problem = WL_NAME ": an instance needs a name";
    else if (type != fmi2CoSimulation && !WL_EXCHANGES)
        problem = WL_NAME ": is for co-simulation, not for model exchange";
    else if (!guid || strcmp(guid, WL_TOKEN) != 0)
        problem = WL_NAME ": the GUID is not that of this FMU; take it from its modelDescription.xml";
    else if (!(instance = allocated(callbacks, sizeof *instance + strlen(name) + 1)))
        problem = WL_NAME ": no memory for an instance";
    if (problem) {
        if (callbacks->logger)
            callbacks->logger(callbacks->componentEnvironment, name ? name : "", fmi2Error, "logStatusError",
                              problem);
        return NULL;
    }
    instance->name = (char *)(instance + 1);
    strcpy(instance->name, name);
    instance->callbacks = *callbacks;
    instance->model.name = instance->name;
    instance->model.report = report;
    instance->model.host = instance;
    instance->model.exchanges = type == fmi2ModelExchange;
    model_reset(&instance->model);
    return instance;
}

/* ---- phases ---- */

fmi2Status fmi2SetupExperiment(fmi2Component component, fmi2Boolean tolerance_defined, fmi2Real tolerance,
                               fmi2Real start, fmi2Boolean stop_defined, fmi2Real stop)
{
    Instance *instance = component;
    return status(in_phase(instance, INSTANTIATED, __func__)
                  && set_times(&instance->model, start, stop_defined ? stop : HUGE_VAL));
}

fmi2Status fmi2EnterInitializationMode(fmi2Component component)
{
    return entered(component, INSTANTIATED, INITIALIZATION, __func__);
}

fmi2Status fmi2DoStep(fmi2Component component, fmi2Real time, fmi2Real step, fmi2Boolean no_return)
{
    Instance *instance = component;
    double reached;
    return instance ? status(model_step(&instance->model, time, step, NULL, &reached)) : fmi2Error;
}

fmi2Status fmi2CancelStep(fmi2Component component)
{
    return unsupported(component, "steps are not asynchronous; there is none to cancel");
}

fmi2Status fmi2GetRealStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Real *value)
{
    Instance *instance = component;
    if (!there(instance, value != NULL, __func__))
        return fmi2Error;
    if (kind != fmi2LastSuccessfulTime)
        return fmi2Discard;
    *value = instance->model.memory.time;
    return fmi2OK;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Boolean *value)
{
    if (!there(component, value != NULL, __func__))
        return fmi2Error;
    if (kind != fmi2Terminated)
        return fmi2Discard;
    *value = fmi2False;
    return fmi2OK;
}

#define NO_STATUS(name, type)                                                            \
    fmi2Status name(fmi2Component component, const fmi2StatusKind kind, type *value) \
    {                                                                                    \
        return component ? fmi2Discard : fmi2Error;                                      \
    }

NO_STATUS(fmi2GetStatus, fmi2Status)
NO_STATUS(fmi2GetIntegerStatus, fmi2Integer)
NO_STATUS(fmi2GetStringStatus, fmi2String)

/* ---- values and states ---- */

#include "fmi_values.h"

#define NO_STRINGS(name, type)                                                                                  \
    fmi2Status name(fmi2Component component, const fmi2ValueReference references[], size_t count, type values[]) \
    {                                                                                                           \
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
