/* An instance from its reset to its end; a part of what speaks with the host, so that a compiler sees all at once.

   What returns an int tells whether it succeeded; if not, a sentence has been reported and nothing has changed. */
#include "identity.h"
#include "model.h"

#include <limits.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Tells the host a sentence, in the way of the standard that is spoken. */
static void report(void *host, Severity severity, const char *sentence);

#include "model_checks.h"

static void model_reset(Model *model)
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

static int model_initialize(Model *model)
{
    if (!parameters_are_well(model, model->memory.parameters))
        return 0;
    begin(model);
    if (!states_are_well(model, model->memory.time))
        return 0;
    model->memory.phase = model->exchanges ? EVENTS : STEPPING;
    return 1;
}

#include "model_values.h"
#include "model_step.h"
#include "model_derivatives.h"
#include "model_state.h"
