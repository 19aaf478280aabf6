/* A communication step: samples, micro steps, inputs that change within it; a part of the unit that steps.

   Gains: FMUs that need no Python, and an hour of the cell in 18 ms, not 5,200 (python -m benchmarks.cores). */

#if WL_CONTINUOUS || !WL_CLOCKS
/* Into how many micro steps a step is divided, and how long they are. */
static long long micro_steps(double step, double *micro)
{
    double count = fmax(1, ceil(step / WL_MICRO_STEP - TICK_TOLERANCE));
    *micro = step / count;
    return (long long)count;
}

static void advance(Model *model, const double *inputs, const double *later, double time, double step)
{
#if WL_CONTINUOUS
    double next[WL_CONTINUOUS];
    WL(advance)(model->memory.states, inputs, later, model->settled, &time, &step, next);
    memcpy(model->memory.states, next, sizeof next);
#else
    (void)model, (void)inputs, (void)later, (void)time, (void)step;
#endif
}

static void integrate(Model *model, double time, double step)
{
    double micro;
    long long count = micro_steps(step, &micro);
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
    double inputs[2][AT_LEAST_1(WL_INPUTS)], micro;
    long long count = micro_steps(step, &micro);
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
    memory->interpolates = 2;
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
        double from = *reached, end = until, micro;
        long long count = micro_steps(end - from, &micro);
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
#else
        (void)time;
#endif
        for (int i = 0; clock >= 0 && i < WL_CLOCKS; i++)
            if (i == clock || memory->samples[i] < samples_until(memory, i, instant)) /* by rounding also one before it */
                sample(model, i);
    } while (clock >= 0);
}
#endif

/* A step is made of samples or micro steps, and of no more than so many: no host waits for ever. */
static double longest_step(const Memory *memory)
{
    (void)memory;
    double shortest = WL_CONTINUOUS || !WL_CLOCKS ? WL_MICRO_STEP : HUGE_VAL;
#if WL_CLOCKS
    for (int i = 0; i < WL_CLOCKS; i++)
        shortest = fmin(shortest, period_of(memory, i));
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
    forget_derivatives(memory);
    int well = 1;
    if (between)
        well = integrate_with_host(model, time, step, between, reached);
    else if (memory->interpolates)
        well = integrate_along(model, time, step);
    else
        integrate(model, time, step);
    if (!well)
        return 0;
#endif
    memory->time = *reached;
    return states_are_well(model, time);
}

static Outcome model_step(Model *model, double time, double step, Between between, double *reached)
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
    else if (WL_TABLES)
        model_tell_ends(model);
    model->fresh = 0;
    return well ? DONE : DISCARDED;
}
