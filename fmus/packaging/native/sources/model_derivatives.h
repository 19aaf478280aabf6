/* Derivatives: of inputs and outputs by time, of outputs and rates in a direction; a part of model_life.c. */

int model_set_derivative(Model *model, unsigned reference, int order, double value)
{
    Memory *memory = &model->memory;
    const Variable *variable = variable_of(model, reference, REAL);
    if (!variable)
        return 0;
    if (WL_CLOCKS || !IS_INPUT(reference))
        return model_report(model, ".%s: takes no derivative; only inputs of continuous components do", variable->name);
    if (order < 1 || order > 2)
        return model_report(model, ".%s: a derivative of order %d; give order 1 or 2", variable->name, order);
#if !WL_CLOCKS
    forget_derivatives(memory);
#endif
    memory->interpolates = 1;
    (order == 1 ? memory->input_slopes : memory->input_curvatures)[reference - FIRST_INPUT] = value;
    return 1;
}

int model_output_derivative(Model *model, unsigned reference, int order, double *value)
{
    const Variable *variable = variable_of(model, reference, REAL);
    if (!variable)
        return 0;
    if (WL_CLOCKS || order != 1 || (int)reference < FIRST_OUTPUT || reference >= FIRST_LOCAL
        || model->memory.phase < STEPPING)
        return model_report(model, ".%s: no derivative of order %d; outputs of continuous components have the first, "
                                   "once the run has begun", variable->name, order);
#if WL_CLOCKS || !WL_OUTPUTS
    (void)value;
#else
    Memory *memory = &model->memory;
    double slopes[AT_LEAST_1(WL_STATES)] = {0}, dtime = 1, derivatives[WL_OUTPUTS];
    rates_of(model, slopes);
    WL(tangent)(memory->states, memory->inputs, model->settled, &memory->time, slopes, memory->input_slopes,
                &dtime, derivatives);
    *value = derivatives[reference - FIRST_OUTPUT];
#endif
    return 1;
}

int model_seed(Model *model, unsigned reference, double seed, Direction *direction)
{
    const Variable *variable = NULL;
    if (reference == VARIABLES)
        direction->time += seed;
    else if (IS_STATE(reference))
        direction->states[reference - FIRST_STATE] += seed;
    else if (!(variable = variable_of(model, reference, REAL)))
        return 0;
    else if (!IS_INPUT(reference))
        return model_report(model, ".%s: is no input; derivatives are by inputs", variable->name);
    else
        direction->inputs[reference - FIRST_INPUT] += seed;
    return 1;
}

static void compute(Model *model, Direction *direction)
{
    Memory *memory = &model->memory;
    if (!model->begun)
        model_begin(model);
#if WL_STATES
    if (memory->phase < STEPPING)
        WL(begin_tangent)(memory->inputs, model->settled, &memory->time, direction->inputs, &direction->time,
                          direction->states);
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
    if (!rate && ((int)reference < FIRST_OUTPUT || reference >= FIRST_LOCAL))
        return model_report(model, ".%s: is no output; derivatives are of outputs", variable->name);
    if (!direction->computed)
        compute(model, direction);
    *value = rate ? direction->rates[reference - FIRST_RATE] : direction->outputs[reference - FIRST_OUTPUT];
    return 1;
}
