/* Parameters, inputs and outputs by value reference; a part of model.c. */

int model_whole(double value)
{
    if (isnan(value))
        return 0;
    return value <= INT_MIN ? INT_MIN : value >= INT_MAX ? INT_MAX : (int)value;
}

static const Variable *variable_of(Model *model, unsigned reference, Kind kind)
{
    static const char *const kinds[] = {"a real number", "an integer", "a boolean", "an enumeration"};
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
                    &model->outputs[WL(group_starts)[variable->group]]);
        model->fresh |= 1ull << variable->group;
    }
    return model->outputs[variable->position];
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
