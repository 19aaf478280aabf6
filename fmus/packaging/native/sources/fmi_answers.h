/* How FMI 2.0 and FMI 3.0 answer alike; a part of fmi2_cs.c and of fmi3_cs.c.

   F(a, b) is a in FMI 2.0 and b in 3.0; Instance is that of the file around. */

#define FUNCTION(name) WL_JOIN(F(fmi2, fmi3), name)
#define NAME_OF(name) F("fmi2", "fmi3") name
typedef FUNCTION(Status) Answer;
typedef FUNCTION(Boolean) Truth;
typedef FUNCTION(Byte) Byte;
typedef FUNCTION(ValueReference) Reference;
typedef FUNCTION(F(FMUstate, FMUState)) State;
typedef FUNCTION(F(Integer, Int32)) Whole;

static Answer status(int well)
{
    return well == DISCARDED ? FUNCTION(Discard) : well ? FUNCTION(OK) : FUNCTION(Error);
}

static int in_phase(Instance *instance, Phase phase, const char *function)
{
    return instance && model_in_phase(&instance->model, phase, function);
}

static Answer unsupported(Instance *instance, const char *what)
{
    if (instance)
        model_report(&instance->model, ": %s", what);
    return FUNCTION(Error);
}

/* What may change the whole instance must not come from within a step. */
static int between_steps(Instance *instance, const char *function)
{
    return instance && (instance->model.memory.phase != UPDATING
                        || model_report(&instance->model, ": %s within a step; let the step end first", function));
}

/* Goes from one phase to another, where the instance is in the first. */
static Answer entered(Instance *instance, Phase before, Phase after, const char *function)
{
    if (!in_phase(instance, before, function))
        return status(0);
    instance->model.memory.phase = after;
    return status(1);
}

const char *FUNCTION(GetVersion)(void)
{
    return FUNCTION(Version);
}

void FUNCTION(FreeInstance)(void *instance)
{
    if (instance)
        release(instance, instance);
}

/* There is nothing to switch: an instance speaks of errors alone, and of those always. */
Answer FUNCTION(SetDebugLogging)(void *instance, Truth logging, size_t count, const FUNCTION(String) categories[])
{
    return status(instance != NULL);
}

Answer FUNCTION(ExitInitializationMode)(void *handle)
{
    Instance *instance = handle;
    return status(in_phase(instance, INITIALIZATION, NAME_OF("ExitInitializationMode"))
                  && model_initialize(&instance->model));
}

Answer FUNCTION(Terminate)(void *handle)
{
    Instance *instance = handle;
    return status(instance && model_terminate(&instance->model, NAME_OF("Terminate")));
}

Answer FUNCTION(Reset)(void *handle)
{
    Instance *instance = handle;
    if (!between_steps(instance, NAME_OF("Reset")))
        return status(0);
    model_reset(&instance->model);
    return status(1);
}
