#include "identity.h"
#include "model.h"

#include <limits.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Share of a sample time, or of a micro step, by which a communication point may miss it. */
#define TICK_TOLERANCE 1e-9
/* Share of time and step by which a host's sum of steps may miss our time. */
#define CLOCK_TOLERANCE 1e-6
/* Share of its nominal value by which an input may miss a bound, as sums and means of hosts do. */
#define BOUND_TOLERANCE 1e-9

#define SENTENCE_SIZE 512

/* ---- sentences ---- */

void model_report(Model *model, const char *format, ...)
{
    char sentence[SENTENCE_SIZE];
    int used = snprintf(sentence, sizeof sentence, "%s", model->name);
    va_list arguments;
    va_start(arguments, format);
    if (used >= 0 && (size_t)used < sizeof sentence)
        vsnprintf(sentence + used, sizeof sentence - (size_t)used, format, arguments);
    va_end(arguments);
    model->report(model->host, model->severity, sentence);
}

/* What is wrong with one value, with %s for bound and unit; NULL where it is well. */
static const char *fault(const Variable *variable, double value, double *bound)
{
    if (isnan(value))
        return variable->flags & ACCEPTS_NAN ? NULL : " is not a number; give a value";
    if (isinf(value))
        return " is not finite; give a finite value";
    *bound = 0;
    if ((variable->flags & POSITIVE) && value <= 0)
        return " is not positive; give a value above %s%s";
    *bound = variable->minimum;
    if ((variable->flags & HAS_MINIMUM) && value < variable->minimum)
        return " is too low; give at least %s%s";
    *bound = variable->maximum;
    if ((variable->flags & HAS_MAXIMUM) && value > variable->maximum)
        return " is too high; give at most %s%s";
    if (variable->kind != REAL && value != nearbyint(value))
        return " is not a whole number; give one";
    return NULL;
}

/* A number with six digits, or as many more as tell it from every other. */
static const char *shown(double value, char *text)
{
    for (int digits = 6; digits <= 17; digits++) {
        snprintf(text, 40, "%.*g", digits, value);
        if (strtod(text, NULL) == value)
            break;
    }
    return isnan(value) ? "nan" : text;
}

/* Whether a value lies within its variable's range; if not, the reason is reported. */
static int within(Model *model, const Variable *variable, double value)
{
    double bound = 0;
    const char *what = fault(variable, value, &bound);
    char reason[SENTENCE_SIZE], number[40], limit[40];
    if (!what)
        return 1;
    snprintf(reason, sizeof reason, what, shown(bound, limit), variable->unit);
    model_report(model, ".%s: %s%s%s", variable->name, shown(value, number), variable->unit, reason);
    return 0;
}

/* Reports a sentence in which `{12}` stands for the parameter of that value reference. */
static void report_check(Model *model, const double *parameters, const char *sentence)
{
    char text[SENTENCE_SIZE], number[40];
    size_t used = 0;
    while (*sentence && used + 1 < sizeof text) {
        if (*sentence != '{') {
            text[used++] = *sentence++;
            continue;
        }
        char *end;
        long reference = strtol(sentence + 1, &end, 10);
        snprintf(number, sizeof number, "%.9g", parameters[reference]);
        for (const char *digit = number; *digit && used + 1 < sizeof text; digit++)
            text[used++] = *digit;
        sentence = *end ? end + 1 : end;
    }
    text[used] = 0;
    model_report(model, ".%s", text);
}

static int parameters_are_well(Model *model, const double *parameters)
{
    int well = 1;
    double margins[AT_LEAST_1(WL_CHECKS)];
    for (int i = 0; i < WL_PARAMETERS; i++)
        well &= within(model, &WL(variables)[i], parameters[i]);
    if (!well)
        return 0;
    WL(margins)(parameters, margins);
    for (int i = 0; i < WL_CHECKS; i++)
        if (!(margins[i] >= 0)) {
            report_check(model, parameters, WL(sentences)[i]);
            well = 0;
        }
    return well;
}

/* Takes an input to its bound where it misses it by a rounding error only, and says so once. */
static void clamp(Model *model, int input, double *value)
{
    const Variable *variable = &WL(variables)[FIRST_INPUT + input];
    double low = variable->flags & HAS_MINIMUM ? variable->minimum : -HUGE_VAL;
    double high = variable->flags & HAS_MAXIMUM ? variable->maximum : HUGE_VAL;
    double bound = *value < low ? low : *value > high ? high : *value;
    char number[40], limit[40];
    if (*value == bound || !(fabs(*value - bound) <= BOUND_TOLERANCE * variable->nominal))
        return;
    if (!model->clamped[input]) {
        Severity before = model->severity;
        model->severity = WARNING;
        model_report(model, ".%s: %s%s is taken for %s%s, here and from now on", variable->name,
                     shown(*value, number), variable->unit, shown(bound, limit), variable->unit);
        model->severity = before;
        model->clamped[input] = 1;
    }
    *value = bound;
}

static int inputs_are_well(Model *model, double *inputs)
{
    int well = 1;
    for (int i = 0; i < WL_INPUTS; i++) {
        const Variable *variable = &WL(variables)[FIRST_INPUT + i];
        double bound;
        if (fault(variable, inputs[i], &bound)) {
            clamp(model, i, &inputs[i]);
            well &= within(model, variable, inputs[i]);
        }
    }
    return well;
}

/* The first state that is not finite, and NaN where it may not be; -1 where all are well. */
static int wild_state(const double *states)
{
    for (int i = 0; i < WL_STATES; i++)
        if (!(fabs(states[i]) < HUGE_VAL) && !(isnan(states[i]) && WL(state_variables)[i].accepts_nan))
            return i;
    return -1;
}

static int states_are_well(Model *model, double since)
{
    int wild = wild_state(model->memory.states);
    if (wild >= 0)
        model_report(model, ": %s is not finite after %g s; look for inputs and parameters far from their "
                            "nominal values", WL(state_variables)[wild].name, since);
    return wild < 0;
}

int model_given(Model *model, size_t count, const void *first, const void *second)
{
    if (count == 0 || (first && second))
        return 1;
    model_report(model, ": a null pointer in place of an array; give arrays of %lu elements", (unsigned long)count);
    return 0;
}

int model_in_phase(Model *model, Phase phase, const char *function)
{
    static const char *const phases[] = {"instantiation", "initialization mode", "step mode", "the end of the run",
                                         "intermediate update mode", "event mode", "continuous-time mode"};
    if (model->memory.phase == phase)
        return 1;
    model_report(model, ": %s belongs in %s, not in %s", function, phases[phase], phases[(int)model->memory.phase]);
    return 0;
}

/* ---- values ---- */

int model_whole(double value)
{
    if (isnan(value))
        return 0;
    return value <= INT_MIN ? INT_MIN : value >= INT_MAX ? INT_MAX : (int)value;
}

void model_reset(Model *model)
{
    Memory *memory = &model->memory;
    memset(memory, 0, sizeof *memory);
    for (int i = 0; i < WL_PARAMETERS; i++)
        memory->parameters[i] = WL(variables)[i].start;
    for (int i = 0; i < WL_INPUTS; i++)
        memory->inputs[i] = WL(variables)[FIRST_INPUT + i].start;
    memory->stop_time = HUGE_VAL;
    memory->phase = INSTANTIATED;
    model->severity = FAILURE;
    memset(model->clamped, 0, sizeof model->clamped);
    model->begun = 0;
    model->fresh = 0;
}

int model_set_times(Model *model, double start, double stop)
{
    if (!(fabs(start) < HUGE_VAL) || !(stop >= start)) {
        model_report(model, ": a run from %g s to %g s; give a start, and a stop after it", start, stop);
        return 0;
    }
    model->memory.start_time = model->memory.time = start;
    model->memory.stop_time = stop;
    model->fresh = 0;
    model->begun = 0;
    return 1;
}

/* Before the run the states follow parameters and inputs. */
static void begin(Model *model)
{
    Memory *memory = &model->memory;
    WL(settle)(memory->parameters, model->settled);
#if WL_STATES
    WL(begin)(memory->inputs, model->settled, memory->states);
#endif
    memset(memory->samples, 0, sizeof memory->samples);
    model->begun = 1;
    model->fresh = 0;
}

static const Variable *variable_of(Model *model, unsigned reference, Kind kind)
{
    static const char *const kinds[] = {"a real number", "an integer", "a boolean"};
    if (reference >= VARIABLES) {
        model_report(model, ": value reference %u is unknown; " WL_NAME " has 0 to %d", reference, VARIABLES - 1);
        return NULL;
    }
    if (WL(variables)[reference].kind != kind) {
        model_report(model, ".%s: is %s, not %s", WL(variables)[reference].name,
                     kinds[WL(variables)[reference].kind], kinds[kind]);
        return NULL;
    }
    return &WL(variables)[reference];
}

/* A parameter that changes in the run, whose other parameters stay as they are. */
static int tune(Model *model, unsigned reference, double value)
{
    double *parameter = &model->memory.parameters[reference], before = *parameter;
    *parameter = value;
    if (!parameters_are_well(model, model->memory.parameters)) {
        *parameter = before;
        return 0;
    }
    WL(settle)(model->memory.parameters, model->settled);
    model->fresh = 0;
    return 1;
}

int model_set(Model *model, unsigned reference, Kind kind, double value)
{
    Memory *memory = &model->memory;
    const Variable *variable = variable_of(model, reference, kind);
    if (!variable)
        return 0;
    if (reference < FIRST_INPUT) {
        if ((memory->phase == STEPPING || memory->phase == EVENTS) && (variable->flags & TUNABLE))
            return tune(model, reference, value);
        if (memory->phase >= STEPPING) {
            model_report(model, ".%s: parameters are fixed once the run has begun; set it before initialization",
                         variable->name);
            return 0;
        }
        memory->parameters[reference] = value;
    } else if (reference < FIRST_OUTPUT) {
        if (memory->phase == TERMINATED) {
            model_report(model, ".%s: the run has ended; reset the instance to set it", variable->name);
            return 0;
        }
        if (memory->phase == CONTINUOUS && kind != REAL) {
            model_report(model, ".%s: jumps; enter event mode to set it", variable->name);
            return 0;
        }
        memory->inputs[reference - FIRST_INPUT] = value;
    } else {
        model_report(model, ".%s: an output cannot be set; set an input", variable->name);
        return 0;
    }
    model->fresh = 0;
    model->begun &= memory->phase >= STEPPING;
    return 1;
}

static double output(Model *model, const Variable *variable)
{
    const Memory *memory = &model->memory;
    if (!model->begun)
        begin(model);
    if (!(model->fresh >> variable->group & 1)) {
        WL(outputs)(variable->group, memory->states, memory->inputs, model->settled, &memory->time,
                    model->outputs[variable->group]);
        model->fresh |= 1ull << variable->group;
    }
    return model->outputs[variable->group][variable->position];
}

#if WL_EXCHANGES
static double of_state(Model *model, unsigned reference)
{
    const Memory *memory = &model->memory;
    double rates[WL_STATES];
    if (!model->begun)
        begin(model);
    if (IS_STATE(reference))
        return memory->states[reference - FIRST_STATE];
    WL(rates)(memory->states, memory->inputs, model->settled, &memory->time, rates);
    return rates[reference - FIRST_RATE];
}
#endif

int model_get(Model *model, unsigned reference, Kind kind, double *value)
{
#if WL_EXCHANGES
    if (kind == REAL && (IS_STATE(reference) || IS_RATE(reference))) {
        *value = of_state(model, reference);
        return 1;
    }
#endif
    const Variable *variable = variable_of(model, reference, kind);
    if (!variable)
        return 0;
    if (reference < FIRST_INPUT)
        *value = model->memory.parameters[reference];
    else if (reference < FIRST_OUTPUT)
        *value = model->memory.inputs[reference - FIRST_INPUT];
    else
        *value = output(model, variable);
    return 1;
}

int model_initialize(Model *model)
{
    if (!parameters_are_well(model, model->memory.parameters))
        return 0;
    begin(model);
    if (!states_are_well(model, model->memory.time))
        return 0;
    model->memory.phase = model->exchanges ? EVENTS : STEPPING;
    return 1;
}

int model_terminate(Model *model, const char *function)
{
    int running = model->memory.phase == EVENTS || model->memory.phase == CONTINUOUS;
    if (!running && !model_in_phase(model, STEPPING, function))
        return 0;
    model->memory.phase = TERMINATED;
    return 1;
}

/* ---- rates, for hosts that integrate ---- */

#if WL_EXCHANGES
Outcome model_rates(Model *model, double *rates)
{
    Memory *memory = &model->memory;
    if (!model->begun)
        begin(model);
    model->severity = DISCARD;
    int well = inputs_are_well(model, memory->inputs);
    if (well) {
        WL(rates)(memory->states, memory->inputs, model->settled, &memory->time, rates);
        for (int i = 0; i < WL_STATES && well; i++)
            if (!(well = fabs(rates[i]) < HUGE_VAL))
                model_report(model, ": the rate of %s is not finite at %g s; look for states and inputs far from "
                                    "their nominal values", WL(state_variables)[i].name, memory->time);
    }
    model->severity = FAILURE;
    return well ? DONE : DISCARDED;
}

Outcome model_set_states(Model *model, const double *states)
{
    int wild = wild_state(states);
    if (wild >= 0) {
        model->severity = DISCARD;
        model_report(model, ": %s is not finite; give finite states", WL(state_variables)[wild].name);
        model->severity = FAILURE;
        return DISCARDED;
    }
    memcpy(model->memory.states, states, sizeof model->memory.states);
    model->fresh = 0;
    return DONE;
}
#endif

/* ---- steps ---- */

#if WL_CONTINUOUS || !WL_CLOCKS
static long long micro_steps(double step)
{
    double count = ceil(step / WL_MICRO_STEP - TICK_TOLERANCE);
    return count < 1 ? 1 : (long long)count;
}

static void advance(Model *model, const double *inputs, const double *later, double time, double step)
{
#if WL_CONTINUOUS
    double next[WL_CONTINUOUS];
    WL(advance)(model->memory.states, inputs, later, model->settled, &time, &step, next);
    memcpy(model->memory.states, next, sizeof next);
#endif
}

static void integrate(Model *model, double time, double step)
{
    long long count = micro_steps(step);
    double micro = step / (double)count;
    for (long long i = 0; i < count; i++)
        advance(model, model->memory.inputs, model->memory.inputs, time + (double)i * micro, micro);
}

#endif

#if !WL_CLOCKS
/* Inputs so long after the start of the step. */
static void inputs_after(const Memory *memory, double elapsed, double *inputs)
{
    for (int i = 0; i < WL_INPUTS; i++)
        inputs[i] = memory->inputs[i]
                    + elapsed * (memory->input_slopes[i] + elapsed / 2 * memory->input_curvatures[i]);
}

static int integrate_along(Model *model, double time, double step)
{
    Memory *memory = &model->memory;
    double inputs[2][AT_LEAST_1(WL_INPUTS)];
    long long count = micro_steps(step);
    double micro = step / (double)count;
    inputs_after(memory, step, inputs[0]);
    if (!inputs_are_well(model, inputs[0]))
        return 0;
    memcpy(inputs[0], memory->inputs, sizeof memory->inputs);
    for (long long i = 0; i < count; i++) {
        inputs_after(memory, (double)(i + 1) * micro, inputs[(i + 1) % 2]);
        advance(model, inputs[i % 2], inputs[(i + 1) % 2], time + (double)i * micro, micro);
    }
    memcpy(memory->inputs, inputs[count % 2], sizeof memory->inputs);
    for (int i = 0; i < WL_INPUTS; i++)
        memory->input_slopes[i] += step * memory->input_curvatures[i];
    return 1;
}

static void call_back(Model *model, Between between, double time, int finished, double *until)
{
    model->memory.phase = UPDATING;
    between(model->host, time, finished, until);
    model->memory.phase = STEPPING;
}

/* Stops between micro steps, where the host may give inputs, take outputs, and end the step early. */
static int integrate_with_host(Model *model, double time, double step, Between between, double *reached)
{
    Memory *memory = &model->memory;
    double inputs[AT_LEAST_1(WL_INPUTS)], until = time + step;
    *reached = time;
    while (*reached < until) {
        double from = *reached, end = until;
        long long count = micro_steps(end - from);
        double micro = (end - from) / (double)count;
        for (long long i = 0; i < count && until == end; i++) {
            double next = i + 1 < count ? from + (double)(i + 1) * micro : end;
            memcpy(inputs, memory->inputs, sizeof inputs);
            call_back(model, between, next, 0, &until);
            if (!inputs_are_well(model, memory->inputs))
                return 0;
            advance(model, inputs, memory->inputs, from + (double)i * micro, micro);
            memory->time = *reached = next;
            model->fresh = 0;
            call_back(model, between, next, 1, &until);
        }
    }
    return 1;
}
#endif

#if WL_CLOCKS
static double period_of(const Memory *memory, int clock)
{
    return memory->parameters[WL(clocks)[clock].sample_time];
}

/* Samples of a clock from the start until a time. */
static double samples_until(const Memory *memory, int clock, double time)
{
    return floor((time - memory->start_time) / period_of(memory, clock) + TICK_TOLERANCE);
}

static double next_sample(const Memory *memory, int clock)
{
    return memory->start_time + (memory->samples[clock] + 1) * period_of(memory, clock);
}

static void sample(Model *model, int clock)
{
    Memory *memory = &model->memory;
    const Clock *what = &WL(clocks)[clock];
    double period = period_of(memory, clock), instant = next_sample(memory, clock), next[AT_LEAST_1(WL_STATES)];
    memory->samples[clock] += 1;
    WL(sample)(clock, memory->states, memory->inputs, model->settled, &instant, &period, next);
    memcpy(memory->states + what->first, next, (size_t)what->count * sizeof *next);
}

/* The clock whose sample comes next, and when; -1 where none comes until then. */
static int next_clock(const Memory *memory, double until, double *instant)
{
    int clock = -1;
    *instant = until;
    for (int i = 0; i < WL_CLOCKS; i++)
        if (memory->samples[i] < samples_until(memory, i, until)
            && (clock < 0 || next_sample(memory, i) < *instant)) {
            clock = i;
            *instant = fmin(until, next_sample(memory, i));
        }
    return clock;
}

/* From sample to sample; of those due at once, first the first clock's. */
static void go_by_clocks(Model *model, double time, double until)
{
    Memory *memory = &model->memory;
    double instant;
    int clock;
    do {
        clock = next_clock(memory, until, &instant);
#if WL_CONTINUOUS
        if (instant - time > TICK_TOLERANCE * WL_MICRO_STEP)
            integrate(model, time, instant - time);
        time = instant;
#endif
        if (clock >= 0)
            sample(model, clock);
        for (int i = clock + 1; clock >= 0 && i < WL_CLOCKS; i++)
            if (memory->samples[i] < samples_until(memory, i, instant))
                sample(model, i);
    } while (clock >= 0);
    (void)time;
}
#endif

/* A step is made of samples or micro steps, and of no more than so many: no host waits for ever. */
static double longest_step(const Memory *memory)
{
    double shortest = WL_CONTINUOUS || !WL_CLOCKS ? WL_MICRO_STEP : HUGE_VAL;
#if WL_CLOCKS
    for (int i = 0; i < WL_CLOCKS; i++)
        shortest = fmin(shortest, period_of(memory, i));
#else
    (void)memory;
#endif
    return WL_MOST_IN_A_STEP * shortest;
}

static int step_is_well(Model *model, double time, double step)
{
    const Memory *memory = &model->memory;
    double longest = longest_step(memory);
    if (memory->phase != STEPPING)
        model_report(model, memory->phase < STEPPING     ? ": a step before initialization; initialize it first"
                            : memory->phase == TERMINATED ? ": a step after the end; reset the instance first"
                                                          : ": a step within a step; let that one end first");
    else if (!(step > 0 && step <= longest))
        model_report(model, ": a step of %g s; give one above 0 s and at most %g s", step, longest);
    else if (!(fabs(time - memory->time) <= fmin(longest, CLOCK_TOLERANCE * (fabs(time) + step))))
        model_report(model, ": a step from %.9g s, but %.9g s is reached; step from there, or restore a state",
                     time, memory->time);
    else if (time + step > memory->stop_time + CLOCK_TOLERANCE * (fabs(time) + step))
        model_report(model, ": a step to %.9g s, beyond the stop time; stop at %.9g s", time + step,
                     memory->stop_time);
    else
        return 1;
    return 0;
}

/* Whether time, inputs and states went on; if not, they may be anything. */
static int go(Model *model, double time, double step, Between between, double *reached)
{
    Memory *memory = &model->memory;
    *reached = time + step;
#if WL_CLOCKS
    (void)between;
    go_by_clocks(model, time, *reached);
#else
    if (memory->interpolates == 2) {
        memset(memory->input_slopes, 0, sizeof memory->input_slopes);
        memset(memory->input_curvatures, 0, sizeof memory->input_curvatures);
        memory->interpolates = 0;
    }
    if (between) {
        if (!integrate_with_host(model, time, step, between, reached))
            return 0;
    } else if (memory->interpolates) {
        if (!integrate_along(model, time, step))
            return 0;
        memory->interpolates = 2;
    } else
        integrate(model, time, step);
#endif
    memory->time = *reached;
    return states_are_well(model, time);
}

Outcome model_step(Model *model, double time, double step, Between between, double *reached)
{
    /* All but the parameters, which no step changes. */
    Memory *memory = &model->memory;
    unsigned char before[sizeof(Memory) - offsetof(Memory, inputs)];
    if (!step_is_well(model, time, step))
        return REFUSED;
    memcpy(before, memory->inputs, sizeof before);
    model->severity = DISCARD;
    int well = inputs_are_well(model, memory->inputs) && go(model, time, step, between, reached);
    model->severity = FAILURE;
    if (!well)
        memcpy(memory->inputs, before, sizeof before);
    model->fresh = 0;
    return well ? DONE : DISCARDED;
}

/* ---- derivatives ---- */

int model_set_derivative(Model *model, unsigned reference, int order, double value)
{
    Memory *memory = &model->memory;
    const Variable *variable = variable_of(model, reference, REAL);
    if (!variable)
        return 0;
    if (WL_CLOCKS || reference < FIRST_INPUT || reference >= FIRST_OUTPUT) {
        model_report(model, ".%s: takes no derivative; only inputs of continuous components do", variable->name);
        return 0;
    }
    if (order < 1 || order > 2) {
        model_report(model, ".%s: a derivative of order %d; give order 1 or 2", variable->name, order);
        return 0;
    }
    if (memory->interpolates == 2) {
        memset(memory->input_slopes, 0, sizeof memory->input_slopes);
        memset(memory->input_curvatures, 0, sizeof memory->input_curvatures);
    }
    memory->interpolates = 1;
    (order == 1 ? memory->input_slopes : memory->input_curvatures)[reference - FIRST_INPUT] = value;
    return 1;
}

int model_output_derivative(Model *model, unsigned reference, int order, double *value)
{
    const Variable *variable = variable_of(model, reference, REAL);
    if (!variable)
        return 0;
    if (WL_CLOCKS || reference < FIRST_OUTPUT || order != 1 || model->memory.phase < STEPPING) {
        model_report(model, ".%s: no derivative of order %d; outputs of continuous components have the first, once "
                            "the run has begun", variable->name, order);
        return 0;
    }
#if !WL_CLOCKS && WL_OUTPUTS
    Memory *memory = &model->memory;
    double slopes[AT_LEAST_1(WL_STATES)] = {0}, dtime = 1, derivatives[WL_OUTPUTS];
#if WL_CONTINUOUS
    WL(rates)(memory->states, memory->inputs, model->settled, &memory->time, slopes);
#endif
    WL(tangent)(memory->states, memory->inputs, model->settled, &memory->time, slopes, memory->input_slopes,
                &dtime, derivatives);
    *value = derivatives[reference - FIRST_OUTPUT];
#endif
    return 1;
}

int model_seed(Model *model, unsigned reference, double seed, Direction *direction)
{
    if (reference == VARIABLES) {
        direction->time += seed;
        return 1;
    }
    if (IS_STATE(reference)) {
        direction->states[reference - FIRST_STATE] += seed;
        return 1;
    }
    const Variable *variable = variable_of(model, reference, REAL);
    if (!variable)
        return 0;
    if (reference < FIRST_INPUT || reference >= FIRST_OUTPUT) {
        model_report(model, ".%s: is no input; derivatives are by inputs", variable->name);
        return 0;
    }
    direction->inputs[reference - FIRST_INPUT] += seed;
    return 1;
}

static void compute(Model *model, Direction *direction)
{
    Memory *memory = &model->memory;
    if (!model->begun)
        begin(model);
#if WL_STATES
    if (memory->phase < STEPPING)
        WL(begin_tangent)(memory->inputs, model->settled, direction->inputs, direction->states);
#endif
    WL(tangent)(memory->states, memory->inputs, model->settled, &memory->time, direction->states,
                direction->inputs, &direction->time, direction->outputs);
#if WL_EXCHANGES
    WL(rates_tangent)(memory->states, memory->inputs, model->settled, &memory->time, direction->states,
                      direction->inputs, &direction->time, direction->rates);
#endif
    direction->computed = 1;
}

int model_sensitivity(Model *model, unsigned reference, Direction *direction, double *value)
{
    const Variable *variable = NULL;
    int rate = IS_RATE(reference);
    if (!rate && !(variable = variable_of(model, reference, REAL)))
        return 0;
    if (reference < FIRST_OUTPUT) {
        model_report(model, ".%s: is no output; derivatives are of outputs", variable->name);
        return 0;
    }
    if (!direction->computed)
        compute(model, direction);
    if (rate)
        *value = direction->rates[reference - FIRST_RATE];
    else
        *value = direction->outputs[reference - FIRST_OUTPUT];
    return 1;
}

/* ---- memory ---- */

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

size_t model_serialized_size(void)
{
    return DIGEST_AT + 8;
}

void model_serialize(const Memory *memory, unsigned char *bytes)
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
    return kind == REAL || (kind == INTEGER && value == model_whole(value)) || value == 0 || value == 1;
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

int model_deserialize(Model *model, const unsigned char *bytes, size_t size, Memory *memory)
{
    if (size != model_serialized_size() || memcmp(bytes, STAMP, STAMP_SIZE) != 0) {
        model_report(model, ": the serialised state is not of this version of " WL_NAME
                            "; serialise it anew with this FMU");
        return 0;
    }
    for (size_t i = 0; i < NUMBERS; i++) {
        Word word = read_word(bytes + STAMP_SIZE + 8 * i);
        memcpy((double *)memory + i, &word, 8);
    }
    const char *damage = read_word(bytes + DIGEST_AT) != digest(bytes, DIGEST_AT) ? "its digest differs"
                                                                                  : contradiction(model, memory);
    if (damage)
        model_report(model, ": the serialised state is damaged: %s; serialise it anew", damage);
    return !damage;
}

void model_restore(Model *model, const Memory *memory)
{
    int settled = model->begun
                  && !memcmp(model->memory.parameters, memory->parameters, sizeof memory->parameters);
    model->memory = *memory;
    model->fresh = 0;
    model->begun = memory->phase >= STEPPING;
    if (model->begun && !settled)
        WL(settle)(memory->parameters, model->settled);
}
