/* Values, derivatives and states, alike in FMI 2.0 and 3.0; a part of fmi2_cs.c and of fmi3_cs.c.

   In FMI 3.0 the size of an array goes with it, SIZED(values, size); in FMI 2.0 it is the number of references. */

#define SIZE F(count, size)

/* How many values go with a reference. The references of an array's elements follow the first, which is its own. */
#if WL_ARRAYS
#define COUNT(reference) ((reference) < VARIABLES ? (Reference)WL(variables)[reference].count : 1)
#else
#define COUNT(reference) 1u
#endif

typedef struct {
    size_t at; /* which reference is next, */
    Reference element; /* and which of its values */
} Place;

/* Reference of the next value. */
static Reference next(const Reference references[], Place *place)
{
    Reference first = references[place->at], found = first + place->element;
    if (++place->element >= COUNT(first)) {
        place->at++;
        place->element = 0;
    }
    return found;
}

/* Whether so many references go with so many values, and both are there. */
static int paired(Instance *instance, const Reference references[], size_t count, const void *values, size_t size)
{
    size_t wanted = 0;
    if (!instance || !given(instance, count, references, references))
        return 0;
    for (size_t i = 0; i < count; i++) {
        unsigned values_of_one = COUNT(references[i]);
        if (!values_of_one)
            return model_report(&instance->model, ": a value reference within an array; give the array's");
        wanted += values_of_one;
    }
    if (wanted != size)
        return model_report(&instance->model, ": %lu value references and %lu values; give one each%s",
                            (unsigned long)count, (unsigned long)size,
                            WL_ARRAYS ? ", of an array one for each element" : "");
    return given(instance, size, values, values);
}

/* Time is a variable in FMI 3.0. */
#define IS_TIME(reference) (F(0, (reference) == VARIABLES))

static int get(Instance *instance, Reference reference, Kind kind, double *value)
{
    if (kind != REAL || !IS_TIME(reference))
        return model_get(&instance->model, reference, kind, value);
    *value = instance->model.memory.time;
    return 1;
}

/* Enumerations are integers of FMI 2.0, and have functions of their own in 3.0. */
#define IS_CHOICE(reference) ((reference) < VARIABLES && WL(variables)[reference].kind == ENUMERATION)
#define WHOLE(reference) F(IS_CHOICE(reference) ? ENUMERATION : INTEGER, INTEGER)

#define GETTER(name, type, kind, shown)                                                                         \
    Answer FUNCTION(name)(void *handle, const Reference references[], size_t count, type SIZED(values[], size)) \
    {                                                                                                           \
        int well = paired(handle, references, count, values, SIZE);                                             \
        Place place = {0, 0};                                                                                   \
        for (size_t i = 0; well && i < SIZE; i++) {                                                             \
            Reference reference = next(references, &place);                                                     \
            double value = 0;                                                                                   \
            well = get(handle, reference, kind, &value);                                                        \
            values[i] = shown;                                                                                  \
        }                                                                                                       \
        return status(well);                                                                                    \
    }

GETTER(F(GetReal, GetFloat64), double, REAL, value)
GETTER(F(GetInteger, GetInt32), Whole, WHOLE(reference), model_whole(value))
F(, GETTER(GetInt64, fmi3Int64, ENUMERATION, model_whole(value)))
GETTER(GetBoolean, Truth, BOOLEAN, value != 0)

static int set(Instance *instance, Reference reference, Kind kind, double value)
{
    return IS_TIME(reference) ? model_report(&instance->model, ".time: cannot be set; it goes on with the steps")
                              : model_set(&instance->model, reference, kind, value);
}

#define SETTER(name, type, kind, value)                                                                       \
    Answer FUNCTION(name)(void *handle, const Reference references[], size_t count,                           \
                          const type SIZED(values[], size))                                                   \
    {                                                                                                         \
        int well = paired(handle, references, count, values, SIZE);                                 \
        Place place = {0, 0};                                                                                 \
        for (size_t i = 0; well && i < SIZE; i++) {                                                           \
            Reference reference = next(references, &place);                                                   \
            well = set(handle, reference, kind, value);                                                       \
        }                                                                                                     \
        return status(well);                                                                                  \
    }

SETTER(F(SetReal, SetFloat64), double, REAL, values[i])
SETTER(F(SetInteger, SetInt32), Whole, WHOLE(reference), values[i])
F(, SETTER(SetInt64, fmi3Int64, ENUMERATION, (double)values[i]))
SETTER(SetBoolean, Truth, BOOLEAN, values[i] != 0)

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
