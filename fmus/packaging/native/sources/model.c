/* An instance from its reset to its end. Its other parts are headers, so that a compiler sees all at once. */
#include "identity.h"
#include "model.h"

#include <limits.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "model_checks.h"

int model_given(Model *model, size_t count, const void *first, const void *second)
{
    return count == 0 || (first && second)
           || model_report(model, ": a null pointer in place of an array; give arrays of %lu elements",
                           (unsigned long)count);
}

int model_in_phase(Model *model, Phase phase, const char *function)
{
    static const char *const phases[] = {"instantiation", "initialization mode", "step mode", "the end of the run",
                                         "intermediate update mode", "event mode", "continuous-time mode"};
    return model->memory.phase == phase
           || model_report(model, ": %s belongs in %s, not in %s", function, phases[phase],
                           phases[(int)model->memory.phase]);
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
    if (!(fabs(start) < HUGE_VAL) || !(stop >= start))
        return model_report(model, ": a run from %g s to %g s; give a start, and a stop after it", start, stop);
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

#include "model_values.h"
#include "model_step.h"
#include "model_derivatives.h"
#include "model_state.h"
