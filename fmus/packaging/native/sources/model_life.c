/* What runs now and then in an instance: its beginning, parameters that change, derivatives. */
#include "model.h"
#include "model_checks.h"
#include "model_table.h"

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
    for (int i = 0; i < WL_TABLES; i++)
        model->tables[i].ended = 0;
    model->begun = 0;
    model->fresh = 0;
}

/* Before the run the states follow parameters and inputs. */
void model_begin(Model *model)
{
    Memory *memory = &model->memory;
    settle(model);
#if WL_STATES
    WL(begin)(memory->inputs, model->settled, &memory->time, memory->states);
#endif
    memset(memory->samples, 0, sizeof memory->samples);
    model->begun = 1;
    model->fresh = 0;
}

int model_initialize(Model *model)
{
    if (!parameters_are_well(model, model->memory.parameters))
        return 0;
    model_begin(model);
    if (!states_are_well(model, model->memory.time))
        return 0;
    model->memory.phase = model->exchanges ? EVENTS : STEPPING;
    return 1;
}

/* A parameter that changes in the run, whose other parameters stay as they are. */
int model_tune(Model *model, unsigned reference, double value)
{
    double *parameter = &model->memory.parameters[reference], before = *parameter;
    *parameter = value;
    int well = parameters_are_well(model, model->memory.parameters);
    if (!well)
        *parameter = before;
    settle(model);
    model->fresh = 0;
    return well;
}

#include "model_derivatives.h"
