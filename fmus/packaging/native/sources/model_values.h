/* Parameters, inputs and outputs by value reference; a part of the unit that steps. */

int model_set(Model *model, unsigned reference, Kind kind, double value)
{
    Memory *memory = &model->memory;
    const Variable *variable = variable_of(model, reference, kind);
    if (!variable)
        return 0;
    if (IS_PARAMETER(reference)) {
        if ((memory->phase == STEPPING || memory->phase == EVENTS) && (variable->flags & TUNABLE))
            return model_tune(model, reference, value);
        if (memory->phase >= STEPPING)
            return model_report(model, ".%s: parameters are fixed once the run has begun; set it before "
                                       "initialization", variable->name);
        memory->parameters[reference] = value;
    } else if (IS_INPUT(reference)) {
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
        model_begin(model);
    if (!(model->fresh >> variable->group & 1)) {
        WL(outputs)(variable->group, memory->states, memory->inputs, model->settled, &memory->time,
                    &model->outputs[WL(group_starts)[variable->group]]);
        model->fresh |= 1ull << variable->group;
    }
    return model->outputs[variable->position];
}

static double of_state(Model *model, unsigned reference)
{
    double rates[AT_LEAST_1(WL_STATES)];
    if (!model->begun)
        model_begin(model);
    if (IS_STATE(reference))
        return model->memory.states[reference - FIRST_STATE];
    rates_of(model, rates);
    return rates[reference - FIRST_RATE];
}

int model_get(Model *model, unsigned reference, Kind kind, double *value)
{
    if (kind == REAL && (IS_STATE(reference) || IS_RATE(reference))) {
        *value = of_state(model, reference);
        return 1;
    }
    const Variable *variable = variable_of(model, reference, kind);
    if (!variable)
        return 0;
    *value = IS_PARAMETER(reference) ? model->memory.parameters[reference]
             : IS_INPUT(reference)   ? model->memory.inputs[reference - FIRST_INPUT]
                                     : output(model, variable);
    return 1;
}

Outcome model_rates(Model *model, double *rates)
{
    Memory *memory = &model->memory;
    if (!model->begun)
        model_begin(model);
    model->severity = DISCARD;
    int well = inputs_are_well(model, memory->inputs);
    if (well)
        rates_of(model, rates);
    for (int i = 0; well && i < WL_STATES; i++)
        if (!(fabs(rates[i]) < HUGE_VAL))
            well = model_report(model, ": the rate of %s is not finite at %g s; look for states and inputs far from "
                                       "their nominal values", WL(state_variables)[i].name, memory->time);
    model->severity = FAILURE;
    return well ? DONE : DISCARDED;
}

Outcome model_set_states(Model *model, const double *states)
{
    int wild = wild_state(states);
    model->severity = DISCARD;
    if (wild >= 0)
        model_report(model, ": %s is not finite; give finite states", WL(state_variables)[wild].name);
    else
        memcpy(model->memory.states, states, sizeof model->memory.states);
    model->severity = FAILURE;
    model->fresh = 0;
    return wild < 0 ? DONE : DISCARDED;
}
