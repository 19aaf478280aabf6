/* What no step needs, alike in FMI 2.0 and 3.0; a part of fmi2_rest.c and of fmi3_rest.c.

   The file around has allocate(), whose memory is 0, and release(). */
#include "fmi_values.h"
#include "model_state.h"
#include "fmi_tables.h"

#define ONLY_STEPS WL_NAME ": is for co-simulation, not for model exchange"

/* Whose end counts too, unless tables are played, for which a mark follows. */
#define TOKEN_SIZE (sizeof WL_TOKEN - (WL_TABLES ? 1 : 0))

/* An instance of the host's name, unless there is a problem, which is reported. */
static Instance *instantiated(Host host, const char *token, const char *resources, const char *problem)
{
    Instance *instance = NULL;
    if (!*host.name)
        problem = WL_NAME ": an instance needs a name";
    else if (!problem && (!token || strncmp(token, WL_TOKEN, TOKEN_SIZE) != 0))
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
    if (!take_tables(&instance->model, resources)) {
        release(&host, instance);
        return NULL;
    }
    return instance;
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
    if (instance) {
        drop_tables(&((Instance *)instance)->model);
        release(&((Instance *)instance)->host, instance);
    }
}

/* There is nothing to switch: an instance speaks of errors alone, and of those always. */
Answer FUNCTION(SetDebugLogging)(void *instance, Truth logging, size_t count, const FUNCTION(String) categories[])
{
    (void)logging, (void)count, (void)categories;
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

/* ---- values other than real numbers ---- */

GETTER(F(GetInteger, GetInt32), Whole, WHOLE(reference), model_whole(value))
F(, GETTER(GetInt64, fmi3Int64, ENUMERATION, model_whole(value)))
GETTER(GetBoolean, Truth, BOOLEAN, value != 0)

SETTER(F(SetInteger, SetInt32), Whole, WHOLE(reference), values[i])
F(, SETTER(SetInt64, fmi3Int64, ENUMERATION, (double)values[i]))
SETTER(SetBoolean, Truth, BOOLEAN, values[i] != 0)

/* ---- derivatives and states ---- */

Answer FUNCTION(F(GetRealOutputDerivatives, GetOutputDerivatives))(void *handle, const Reference references[],
                                                                   size_t count, const Whole orders[],
                                                                   double SIZED(values[], size))
{
    Instance *instance = handle;
    int well = paired(instance, references, count, values, SIZE)
               && given(instance, count, orders, values);
    Place place = {0, 0};
    for (size_t i = 0; well && i < SIZE; i++) {
        Whole order = orders[place.at];
        well = model_output_derivative(&instance->model, next(references, &place), order, &values[i]);
    }
    return status(well);
}

Answer FUNCTION(GetDirectionalDerivative)(void *handle, const Reference unknowns[], size_t unknown_count,
                                          const Reference knowns[], size_t known_count,
                                          const double SIZED(seed[], seed_size),
                                          double SIZED(sensitivity[], sensitivity_size))
{
    Instance *instance = handle;
    Direction direction = {{0}, {0}, 0, {0}, {0}, 0};
    int well = paired(instance, knowns, known_count, seed, F(known_count, seed_size))
               && paired(instance, unknowns, unknown_count, sensitivity, F(unknown_count, sensitivity_size));
    Place by = {0, 0}, of = {0, 0};
    for (size_t i = 0; well && i < F(known_count, seed_size); i++)
        well = model_seed(&instance->model, next(knowns, &by), seed[i], &direction);
    for (size_t i = 0; well && i < F(unknown_count, sensitivity_size); i++)
        well = model_sensitivity(&instance->model, next(unknowns, &of), &direction, &sensitivity[i]);
    return status(well);
}

/* Puts what was remembered where the host wants it. */
static Answer kept(Instance *instance, const Memory *memory, State *state)
{
    if (!*state)
        *state = allocate(&instance->host, sizeof *memory);
    if (!*state)
        return unsupported(instance, "no memory for a state");
    memcpy(*state, memory, sizeof *memory);
    return status(1);
}

Answer FUNCTION(F(GetFMUstate, GetFMUState))(void *handle, State *state)
{
    Instance *instance = handle;
    int well = there(instance, state != NULL, __func__) && between_steps(instance, __func__);
    return well ? kept(instance, &instance->model.memory, state) : status(0);
}

Answer FUNCTION(F(SetFMUstate, SetFMUState))(void *handle, State state)
{
    Instance *instance = handle;
    if (!there(instance, state != NULL, __func__) || !between_steps(instance, __func__))
        return status(0);
    model_restore(&instance->model, state);
    return status(1);
}

Answer FUNCTION(F(FreeFMUstate, FreeFMUState))(void *instance, State *state)
{
    if (instance && state && *state) {
        release(&((Instance *)instance)->host, *state);
        *state = NULL;
    }
    return status(instance != NULL);
}

Answer FUNCTION(F(SerializedFMUstateSize, SerializedFMUStateSize))(void *instance, State state, size_t *size)
{
    if (!there(instance, state && size, __func__))
        return status(0);
    *size = model_serialized_size();
    return status(1);
}

Answer FUNCTION(F(SerializeFMUstate, SerializeFMUState))(void *instance, State state, Byte bytes[], size_t size)
{
    if (!there(instance, state && bytes, __func__))
        return status(0);
    if (size < model_serialized_size())
        return unsupported(instance, "too few bytes for the serialised state; ask for its size");
    model_serialize(state, (unsigned char *)bytes);
    return status(1);
}

Answer FUNCTION(F(DeSerializeFMUstate, DeserializeFMUState))(void *handle, const Byte bytes[], size_t size, State *state)
{
    Instance *instance = handle;
    Memory memory;
    int well = there(instance, bytes && state, __func__)
               && model_deserialize(&instance->model, (const unsigned char *)bytes, size, &memory);
    return well ? kept(instance, &memory, state) : status(0);
}
