/* Values and derivatives by value reference, alike in FMI 2.0 and 3.0; a part of fmi2_cs.c and of fmi3_cs.c.

   In FMI 3.0 the size of an array goes with it, SIZED(values, size); in FMI 2.0 it is the number of references. */

/* One value each: whether so many references go with so many values, and both are there. */
static int paired(Instance *instance, const void *references, size_t count, const void *values, size_t size)
{
    if (instance && count != size)
        model_report(&instance->model, ": %lu value references and %lu values; give one each", (unsigned long)count,
                     (unsigned long)size);
    return instance && count == size && model_given(&instance->model, count, references, values);
}

/* Time is a variable in FMI 3.0. */
#define IS_TIME(reference) (F(0, (reference) == VARIABLES))

Answer FUNCTION(F(GetReal, GetFloat64))(void *handle, const Reference references[], size_t count,
                                        double SIZED(values[], size))
{
    Instance *instance = handle;
    int well = paired(instance, references, count, values, F(count, size));
    for (size_t i = 0; well && i < count; i++)
        if (IS_TIME(references[i]))
            values[i] = instance->model.memory.time;
        else
            well = model_get(&instance->model, references[i], REAL, &values[i]);
    return status(well);
}

/* Enumerations are integers of FMI 2.0, and have functions of their own in 3.0. */
#define IS_CHOICE(reference) ((reference) < VARIABLES && WL(variables)[reference].kind == ENUMERATION)
#define WHOLE(reference) F(IS_CHOICE(reference) ? ENUMERATION : INTEGER, INTEGER)

#define WHOLE_GETTER(name, type, kind)                                                                        \
    Answer FUNCTION(name)(void *handle, const Reference references[], size_t count, type SIZED(values[], size)) \
    {                                                                                                         \
        Instance *instance = handle;                                                                          \
        int well = paired(instance, references, count, values, F(count, size));                               \
        for (size_t i = 0; well && i < count; i++) {                                                          \
            double value = 0;                                                                                 \
            well = model_get(&instance->model, references[i], kind, &value);                                  \
            values[i] = model_whole(value);                                                                   \
        }                                                                                                     \
        return status(well);                                                                                  \
    }

WHOLE_GETTER(F(GetInteger, GetInt32), Whole, WHOLE(references[i]))
F(, WHOLE_GETTER(GetInt64, fmi3Int64, ENUMERATION))

Answer FUNCTION(GetBoolean)(void *handle, const Reference references[], size_t count, Truth SIZED(values[], size))
{
    Instance *instance = handle;
    int well = paired(instance, references, count, values, F(count, size));
    for (size_t i = 0; well && i < count; i++) {
        double value = 0;
        well = model_get(&instance->model, references[i], BOOLEAN, &value);
        values[i] = value != 0;
    }
    return status(well);
}

static int set(Instance *instance, Reference reference, Kind kind, double value)
{
    if (!IS_TIME(reference))
        return model_set(&instance->model, reference, kind, value);
    model_report(&instance->model, ".time: cannot be set; it goes on with the steps");
    return 0;
}

#define SETTER(name, type, kind, value)                                                                       \
    Answer FUNCTION(name)(void *handle, const Reference references[], size_t count,                           \
                          const type SIZED(values[], size))                                                   \
    {                                                                                                         \
        int well = paired(handle, references, count, values, F(count, size));                                 \
        for (size_t i = 0; well && i < count; i++)                                                            \
            well = set(handle, references[i], kind, value);                                                   \
        return status(well);                                                                                  \
    }

SETTER(F(SetReal, SetFloat64), double, REAL, values[i])
SETTER(F(SetInteger, SetInt32), Whole, WHOLE(references[i]), values[i])
F(, SETTER(SetInt64, fmi3Int64, ENUMERATION, (double)values[i]))
SETTER(SetBoolean, Truth, BOOLEAN, values[i] != 0)

Answer FUNCTION(F(GetRealOutputDerivatives, GetOutputDerivatives))(void *handle, const Reference references[],
                                                                   size_t count, const Whole orders[],
                                                                   double SIZED(values[], size))
{
    Instance *instance = handle;
    int well = paired(instance, references, count, values, F(count, size))
               && model_given(&instance->model, count, orders, values);
    for (size_t i = 0; well && i < count; i++)
        well = model_output_derivative(&instance->model, references[i], orders[i], &values[i]);
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
    for (size_t i = 0; well && i < known_count; i++)
        well = model_seed(&instance->model, knowns[i], seed[i], &direction);
    for (size_t i = 0; well && i < unknown_count; i++)
        well = model_sensitivity(&instance->model, unknowns[i], &direction, &sensitivity[i]);
    return status(well);
}
