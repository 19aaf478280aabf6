/* The functions by which a host integrates, alike in FMI 2.0 and 3.0; a part of fmi2_rest.c and of
   fmi3_rest.c. */

/* Whether there are states that a host may integrate. */
static int exchanges(Instance *instance)
{
    return instance && (WL_EXCHANGES || model_report(&instance->model, ": " WL_NAME " is for co-simulation alone"));
}

/* Whether there are, and the host gave room for as many numbers. */
static int sized(Instance *instance, size_t count, const double *numbers)
{
    if (!exchanges(instance))
        return 0;
    if (count != WL_STATES)
        return model_report(&instance->model, ": %lu numbers for %d states; give one each", (unsigned long)count,
                            WL_STATES);
    return given(instance, count, numbers, numbers);
}

Answer FUNCTION(EnterEventMode)(void *instance)
{
    return entered(instance, CONTINUOUS, EVENTS, __func__);
}

Answer FUNCTION(EnterContinuousTimeMode)(void *instance)
{
    return entered(instance, EVENTS, CONTINUOUS, __func__);
}

/* No step of the host's solver makes an event. */
Answer FUNCTION(CompletedIntegratorStep)(void *instance, Truth keep, Truth *event, Truth *end)
{
    (void)keep;
    if (event)
        *event = 0;
    if (end)
        *end = 0;
    return status(in_phase(instance, CONTINUOUS, __func__));
}

Answer FUNCTION(SetTime)(void *handle, double time)
{
    Instance *instance = handle;
    if (instance && instance->model.memory.phase != EVENTS && !in_phase(instance, CONTINUOUS, __func__))
        return status(0);
    if (!instance || !(fabs(time) < HUGE_VAL && time >= instance->model.memory.start_time))
        return unsupported(instance, "a time that is not finite, or before the start; give a later one");
    instance->model.memory.time = time;
    instance->model.fresh = 0;
    return status(1);
}

Answer FUNCTION(SetContinuousStates)(void *handle, const double states[], size_t count)
{
    Instance *instance = handle;
    int well = sized(instance, count, states) && in_phase(instance, CONTINUOUS, __func__);
    return status(well ? model_set_states(&instance->model, states) : REFUSED);
}

Answer FUNCTION(GetContinuousStates)(void *handle, double states[], size_t count)
{
    Instance *instance = handle;
    int well = sized(instance, count, states);
    for (int i = 0; well && i < WL_STATES; i++)
        well = model_get(&instance->model, (unsigned)(FIRST_STATE + i), REAL, &states[i]);
    return status(well);
}

Answer WL_JOIN(FUNCTION(Get), F(Derivatives, ContinuousStateDerivatives))(void *handle, double rates[], size_t count)
{
    Instance *instance = handle;
    return sized(instance, count, rates) ? status(model_rates(&instance->model, rates)) : status(0);
}

Answer FUNCTION(GetNominalsOfContinuousStates)(void *handle, double nominals[], size_t count)
{
    if (!sized(handle, count, nominals))
        return status(0);
    memcpy(nominals, WL(nominals), WL_STATES * sizeof *nominals);
    return status(1);
}

Answer FUNCTION(GetEventIndicators)(void *instance, double indicators[], size_t count)
{
    (void)indicators;
    return count ? unsupported(instance, WL_NAME " has no event indicators") : status(instance != NULL);
}
