/* The state of an instance as bytes, and back; a part of fmi_rest.h. */

/* A serialised state: which component and version it belongs to, the numbers, and a digest of both; least byte
   first. */
#define STAMP "warmlink " WL_STATE_ID
#define STAMP_SIZE (sizeof STAMP - 1)
#define NUMBERS (sizeof(Memory) / sizeof(double))
#define DIGEST_AT (STAMP_SIZE + 8 * NUMBERS)

/* Beyond this a double no longer counts by ones. */
#define MOST_SAMPLES 9e15

typedef unsigned long long Word;

static void write_word(Word word, unsigned char *bytes)
{
    for (int k = 0; k < 8; k++)
        bytes[k] = (unsigned char)(word >> 8 * k);
}

static Word read_word(const unsigned char *bytes)
{
    Word word = 0;
    for (int k = 0; k < 8; k++)
        word |= (Word)bytes[k] << 8 * k;
    return word;
}

/* FNV-1a; any single byte that differs changes it. */
static Word digest(const unsigned char *bytes, size_t size)
{
    Word hash = 14695981039346656037u;
    for (size_t i = 0; i < size; i++)
        hash = (hash ^ bytes[i]) * 1099511628211u;
    return hash;
}

static size_t model_serialized_size(void)
{
    return DIGEST_AT + 8;
}

static void model_serialize(const Memory *memory, unsigned char *bytes)
{
    memcpy(bytes, STAMP, STAMP_SIZE);
    for (size_t i = 0; i < NUMBERS; i++) {
        Word word;
        memcpy(&word, (const double *)memory + i, 8);
        write_word(word, bytes + STAMP_SIZE + 8 * i);
    }
    write_word(digest(bytes, DIGEST_AT), bytes + DIGEST_AT);
}

static int fits(Kind kind, double value)
{
    return kind == REAL || (kind != BOOLEAN && value == model_whole(value)) || value == 0 || value == 1;
}

/* What no instance could have remembered; NULL where all is well. */
static const char *contradiction(Model *model, const Memory *memory)
{
    double start = memory->start_time, time = memory->time, stop = memory->stop_time;
    double slack = 4 * CLOCK_TOLERANCE * (fabs(start) + fabs(time)); /* as hosts' sums of steps may miss */
    int begun = memory->phase >= STEPPING;
    int known = memory->phase >= INSTANTIATED && memory->phase <= CONTINUOUS && memory->phase != UPDATING;
    if (!fits(INTEGER, memory->phase) || !known
        || (begun && memory->phase != TERMINATED && (memory->phase != STEPPING) != model->exchanges))
        return "no phase of such a run is the one in it";
    if (!(fabs(start) < HUGE_VAL && fabs(time) < HUGE_VAL && start - slack <= time
          && (model->exchanges || time <= stop + slack))
        || (!begun && time != start))
        return "its times contradict each other";
    if (!(memory->interpolates == 0 || memory->interpolates == 1 || memory->interpolates == 2))
        return "its inputs' derivatives contradict each other";
    for (int i = 0; i < WL_INPUTS; i++)
        if (WL(variables)[FIRST_INPUT + i].kind != REAL
            && !(memory->input_slopes[i] == 0 && memory->input_curvatures[i] == 0))
            return "its inputs' derivatives are of integers or booleans";
    for (int i = 0; i < FIRST_OUTPUT; i++)
        if (!fits(WL(variables)[i].kind, i < FIRST_INPUT ? memory->parameters[i] : memory->inputs[i - FIRST_INPUT]))
            return "an integer or a boolean in it is none";
    if (begun && !parameters_are_well(model, memory->parameters))
        return "a parameter in it is out of range";
    if (begun && wild_state(memory->states) >= 0)
        return "a number in it is not finite";
    for (int i = 0; i < AT_LEAST_1(WL_CLOCKS); i++) {
        double least = 0, most = 0, samples = memory->samples[i];
#if WL_CLOCKS
        if (begun) {
            least = fmax(0, samples_until(memory, i, time));
            most = fmin(MOST_SAMPLES, least + 1 + slack / period_of(memory, i));
        }
#endif
        if (!(samples >= least && samples <= most && samples == floor(samples)))
            return "its number of samples contradicts its time";
    }
    return NULL;
}

static int model_deserialize(Model *model, const unsigned char *bytes, size_t size, Memory *memory)
{
    if (size != model_serialized_size() || memcmp(bytes, STAMP, STAMP_SIZE) != 0)
        return model_report(model, ": the serialised state is not of this version of " WL_NAME
                                   "; serialise it anew with this FMU");
    for (size_t i = 0; i < NUMBERS; i++) {
        Word word = read_word(bytes + STAMP_SIZE + 8 * i);
        memcpy((double *)memory + i, &word, 8);
    }
    const char *damage = read_word(bytes + DIGEST_AT) != digest(bytes, DIGEST_AT) ? "its digest differs"
                                                                                  : contradiction(model, memory);
    return !damage || model_report(model, ": the serialised state is damaged: %s; serialise it anew", damage);
}

static void model_restore(Model *model, const Memory *memory)
{
    int settled = model->begun
                  && !memcmp(model->memory.parameters, memory->parameters, sizeof memory->parameters);
    model->memory = *memory;
    model->fresh = 0;
    model->begun = memory->phase >= STEPPING;
    if (model->begun && !settled)
        settle(model);
}
