/* Parameters, inputs and outputs by value reference; a part of model_instance.h. */

/* An integer's value; the nearest that an integer may have, 0 for none. */
static int model_whole(double value)
{
    if (isnan(value))
        return 0;
    return value <= INT_MIN ? INT_MIN : value >= INT_MAX ? INT_MAX : (int)value;
}

static const Variable *variable_of(Model *model, unsigned reference, Kind kind)
{
    static const char *const kinds[] = {"a real number", "an integer", "a boolean", "an enumeration"};
    const Variable *found = &WL(variables)[reference < VARIABLES ? reference : 0];
    if (reference >= VARIABLES)
        model_report(model, ": value reference %u is unknown; " WL_NAME " has 0 to %d", reference, VARIABLES - 1);
    else if (found->kind != kind)
        model_report(model, ".%s: is %s, not %s", found->name, kinds[found->kind], kinds[kind]);
    else
        return found;
    return NULL;
}

/* A parameter that changes in the run, whose other parameters stay as they are. */
static int tune(Model *model, unsigned reference, double value)
{
    double *parameter = &model->memory.parameters[reference], before = *parameter;
    *parameter = value;
    int well = parameters_are_well(model, model->memory.parameters);
    if (!well)
        *parameter = before;
    WL(settle)(model->memory.parameters, model->settled);
    model->fresh = 0;
    return well;
}

static int model_set(Model *model, unsigned reference, Kind kind, double value)
{
    Memory *memory = &model->memory;
    const Variable *variable = variable_of(model, reference, kind);
    if (!variable)
        return 0;
    if (reference < FIRST_INPUT) {
        if ((memory->phase == STEPPING || memory->phase == EVENTS) && (variable->flags & TUNABLE))
            return tune(model, reference, value);
        if (memory->phase >= STEPPING)
            return model_report(model, ".%s: parameters are fixed once the run has begun; set it before "
                                       "initialization", variable->name);
        memory->parameters[reference] = value;
    } else if (reference < FIRST_OUTPUT) {
        if (memory->phase == TERMINATED)
            return model_report(model, ".%s: the run has ended; reset the instance to set it", variable->name);
        if (memory->phase == CONTINUOUS && kind != REAL)
            return model_report(model, ".%s: jumps; enter event mode to set it", variable->name);
        memory->inputs[reference - FIRST_INPUT] = value;
    } else
        return model_report(model, ".%s: an output cannot be set; set an input", variable->name);
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
                    &model->outputs[WL(group_starts)[variable->group]]);
        model->fresh |= 1ull << variable->group;
    }
    return model->outputs[variable->position];
}

static void rates_of(const Model *model, double *rates)
{
#if WL_EXCHANGES
    const Memory *memory = &model->memory;
    WL(rates)(memory->states, memory->inputs, model->settled, &memory->time, rates);
#endif
}

static double of_state(Model *model, unsigned reference)
{
    double rates[AT_LEAST_1(WL_STATES)];
    if (!model->begun)
        begin(model);
    if (IS_STATE(reference))
        return model->memory.states[reference - FIRST_STATE];
    rates_of(model, rates);
    return rates[reference - FIRST_RATE];
}

static int model_get(Model *model, unsigned reference, Kind kind, double *value)
{
    if (kind == REAL && (IS_STATE(reference) || IS_RATE(reference))) {
        *value = of_state(model, reference);
        return 1;
    }
    const Variable *variable = variable_of(model, reference, kind);
    if (!variable)
        return 0;
    *value = reference < FIRST_INPUT    ? model->memory.parameters[reference]
             : reference < FIRST_OUTPUT ? model->memory.inputs[reference - FIRST_INPUT]
                                        : output(model, variable);
    return 1;
}
