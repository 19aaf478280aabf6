/* How FMI 2.0 and FMI 3.0 answer alike; a part of fmi2_cs.c and of fmi3_cs.c.

   F(a, b) is a in FMI 2.0 and b in 3.0; Host is that of the file around, as are allocate(), whose memory is 0, and
   release(). */

#define FUNCTION(name) WL_JOIN(F(fmi2, fmi3), name)
typedef FUNCTION(Status) Answer;
typedef FUNCTION(Boolean) Truth;
typedef FUNCTION(Byte) Byte;
typedef FUNCTION(ValueReference) Reference;
typedef FUNCTION(F(FMUstate, FMUState)) State;
typedef FUNCTION(F(Integer, Int32)) Whole;

typedef struct {
    Model model;
    Host host;
} Instance;

#define ONLY_STEPS WL_NAME ": is for co-simulation, not for model exchange"

/* An instance of the host's name, unless there is a problem, which is reported. */
static Instance *instantiated(Host host, const char *token, const char *problem)
{
    Instance *instance = NULL;
    if (!*host.name)
        problem = WL_NAME ": an instance needs a name";
    else if (!problem && (!token || strcmp(token, WL_TOKEN) != 0))
        problem = WL_NAME ": the " F("GUID", "instantiation token") " is not that of this FMU; take it from its "
                          "modelDescription.xml";
    else if (!problem && !(instance = allocate(&host, sizeof *instance + strlen(host.name) + 1)))
        problem = WL_NAME ": no memory for an instance";
    if (problem) {
        report(&host, FAILURE, problem);
        return NULL;
    }
    instance->host = host;
    instance->host.name = instance->model.name = strcpy((char *)(instance + 1), host.name);
    instance->model.host = &instance->host;
    model_reset(&instance->model);
    return instance;
}

static Answer status(int well)
{
    return well == DISCARDED ? FUNCTION(Discard) : well ? FUNCTION(OK) : FUNCTION(Error);
}

/* Whether an instance is in the phase that a function, by its name, belongs in. */
static int in_phase(Instance *instance, Phase phase, const char *function)
{
    static const char *const phases[] = {"instantiation", "initialization mode", "step mode", "the end of the run",
                                         "intermediate update mode", "event mode", "continuous-time mode"};
    Phase present = instance ? (Phase)instance->model.memory.phase : phase;
    if (present != phase)
        model_report(&instance->model, ": %s belongs in %s, not in %s", function, phases[phase], phases[present]);
    return instance && present == phase;
}

/* Whether the host gave the arrays that so many values need; either may be NULL where there are none. */
static int given(Instance *instance, size_t count, const void *first, const void *second)
{
    return count == 0 || (first && second)
           || model_report(&instance->model, ": a null pointer in place of an array; give arrays of %lu elements",
                           (unsigned long)count);
}

/* Whether the host gave what a function works on. */
static int there(Instance *instance, int given, const char *function)
{
    return instance && (given || model_report(&instance->model, ": %s of a null pointer; give what it is to read "
                                                                "or to fill", function));
}

static Answer unsupported(Instance *instance, const char *what)
{
    if (instance)
        model_report(&instance->model, ": %s", what);
    return FUNCTION(Error);
}

static int set_times(Model *model, double start, double stop)
{
    if (!(fabs(start) < HUGE_VAL) || !(stop >= start))
        return model_report(model, ": a run from %g s to %g s; give a start, and a stop after it", start, stop);
    model->memory.start_time = model->memory.time = start;
    model->memory.stop_time = stop;
    model->fresh = 0;
    model->begun = 0;
    return 1;
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
        release(&((Instance *)instance)->host, instance);
}

/* There is nothing to switch: an instance speaks of errors alone, and of those always. */
Answer FUNCTION(SetDebugLogging)(void *instance, Truth logging, size_t count, const FUNCTION(String) categories[])
{
    return status(instance != NULL);
}

Answer FUNCTION(ExitInitializationMode)(void *handle)
{
    Instance *instance = handle;
    return status(in_phase(instance, INITIALIZATION, __func__)
                  && model_initialize(&instance->model));
}

Answer FUNCTION(Terminate)(void *handle)
{
    Instance *instance = handle;
    Phase present = instance ? (Phase)instance->model.memory.phase : STEPPING;
    return entered(instance, present == EVENTS || present == CONTINUOUS ? present : STEPPING, TERMINATED, __func__);
}

Answer FUNCTION(Reset)(void *handle)
{
    Instance *instance = handle;
    if (!between_steps(instance, __func__))
        return status(0);
    model_reset(&instance->model);
    return status(1);
}
