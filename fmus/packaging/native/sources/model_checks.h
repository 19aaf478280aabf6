/* What may be wrong with values and states; a part of every unit that asks. */
#include "model_fault.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Share of a sample time, or of a micro step, by which a communication point may miss it. */
#define TICK_TOLERANCE 1e-9
/* Share of time and step by which a host's sum of steps may miss our time. */
#define CLOCK_TOLERANCE 1e-6

/* Whether inputs are well, once those are mended that miss a bound by a rounding error. */
static inline int inputs_are_well(Model *model, double *inputs)
{
    int well = 1;
    (void)model, (void)inputs;
    for (int i = 0; i < WL_INPUTS; i++) {
        const Variable *variable = &WL(variables)[FIRST_INPUT + i];
        double bound;
        if (fault(variable, inputs[i], &bound))
            well &= model_mend(model, i, &inputs[i]);
    }
    return well;
}

/* The first state that is not finite, and NaN where it may not be; -1 where all are well. */
static inline int wild_state(const double *states)
{
    double a = 0, b = 0, c = 0, d = 0; /* a finite number less itself is 0; in fours, for the processor's sake */
    int i = 0;
    for (const double *x = states; i + 4 <= WL_STATES; i += 4, x += 4) {
        a += x[0] - x[0];
        b += x[1] - x[1];
        c += x[2] - x[2];
        d += x[3] - x[3];
    }
    for (i = (a + b) + (c + d) == 0 ? i : 0; i < WL_STATES; i++)
        if (!(fabs(states[i]) < HUGE_VAL) && !(isnan(states[i]) && WL(state_variables)[i].accepts_nan))
            return i;
    return -1;
}

static inline int states_are_well(Model *model, double since)
{
    int wild = wild_state(model->memory.states);
    return wild < 0 || model_report(model, ": %s is not finite after %g s; look for inputs and parameters far from "
                                           "their nominal values", WL(state_variables)[wild].name, since);
}

/* An integer's value; the nearest that an integer may have, 0 for none. */
static inline int model_whole(double value)
{
    if (isnan(value))
        return 0;
    return value <= INT_MIN ? INT_MIN : value >= INT_MAX ? INT_MAX : (int)value;
}

/* A variable of a kind; NULL if there is none, which is reported. */
static inline const Variable *variable_of(Model *model, unsigned reference, Kind kind)
{
    if (reference < VARIABLES && WL(variables)[reference].kind == kind)
        return &WL(variables)[reference];
    model_refuse(model, reference, kind);
    return NULL;
}

/* What the parameters settle, and beside it the tables' handles. */
static inline void settle(Model *model)
{
    WL(settle)(model->memory.parameters, model->settled);
    for (int i = 0; i < WL_TABLES; i++) {
        const Table *table = &model->tables[i];
        model->tables[i].columns = WL(played)[i].columns;
        memcpy(&model->settled[WL(played)[i].settled], &table, sizeof table);
    }
}

static inline void rates_of(const Model *model, double *rates)
{
#if WL_EXCHANGES
    const Memory *memory = &model->memory;
    WL(rates)(memory->states, memory->inputs, model->settled, &memory->time, rates);
#else
    (void)model, (void)rates;
#endif
}

#if WL_CLOCKS
static inline double period_of(const Memory *memory, int clock)
{
    return memory->parameters[WL(clocks)[clock].sample_time];
}

/* Samples of a clock from the start until a time. */
static inline double samples_until(const Memory *memory, int clock, double time)
{
    return floor((time - memory->start_time) / period_of(memory, clock) + TICK_TOLERANCE);
}
#else
/* Derivatives of inputs are good for one step. */
static inline void forget_derivatives(Memory *memory)
{
    if (memory->interpolates != 2)
        return;
    memset(memory->input_slopes, 0, sizeof memory->input_slopes);
    memset(memory->input_curvatures, 0, sizeof memory->input_curvatures);
    memory->interpolates = 0;
}
#endif
