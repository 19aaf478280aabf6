/* Values by reference, alike in FMI 2.0 and 3.0; a part of the units that get and set some.

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
static inline Reference next(const Reference references[], Place *place)
{
    Reference first = references[place->at], found = first + place->element;
    if (++place->element >= COUNT(first)) {
        place->at++;
        place->element = 0;
    }
    return found;
}

/* Whether so many references go with so many values, and both are there. */
static inline int paired(Instance *instance, const Reference references[], size_t count, const void *values, size_t size)
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

static inline int get(Instance *instance, Reference reference, Kind kind, double *value)
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

static inline int set(Instance *instance, Reference reference, Kind kind, double value)
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
