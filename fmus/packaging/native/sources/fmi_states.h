/* The functions that save, restore and serialise a state, alike in FMI 2.0 and 3.0; a part of fmi2_cs.c and of
   fmi3_cs.c, whose allocate() and release() are for this memory too. */

/* Puts what was remembered where the host wants it. */
static Answer kept(Instance *instance, const Memory *memory, State *state)
{
    if (!*state)
        *state = allocate(instance, sizeof *memory);
    if (!*state)
        return unsupported(instance, "no memory for a state");
    memcpy(*state, memory, sizeof *memory);
    return status(1);
}

Answer FUNCTION(F(GetFMUstate, GetFMUState))(void *handle, State *state)
{
    Instance *instance = handle;
    if (!instance || !state)
        return unsupported(instance, "there is nowhere to put the state");
    if (!between_steps(instance, F("fmi2GetFMUstate", "fmi3GetFMUState")))
        return status(0);
    return kept(instance, &instance->model.memory, state);
}

Answer FUNCTION(F(SetFMUstate, SetFMUState))(void *handle, State state)
{
    Instance *instance = handle;
    if (!instance || !state)
        return unsupported(instance, "there is no state to go back to");
    if (!between_steps(instance, F("fmi2SetFMUstate", "fmi3SetFMUState")))
        return status(0);
    model_restore(&instance->model, state);
    return status(1);
}

Answer FUNCTION(F(FreeFMUstate, FreeFMUState))(void *instance, State *state)
{
    if (instance && state && *state) {
        release(instance, *state);
        *state = NULL;
    }
    return status(instance != NULL);
}

Answer FUNCTION(F(SerializedFMUstateSize, SerializedFMUStateSize))(void *instance, State state, size_t *size)
{
    if (!instance || !state || !size)
        return unsupported(instance, "there is no state to serialise, or nowhere to put its size");
    *size = model_serialized_size();
    return status(1);
}

Answer FUNCTION(F(SerializeFMUstate, SerializeFMUState))(void *instance, State state, Byte bytes[], size_t size)
{
    if (!instance || !state)
        return unsupported(instance, "there is no state to serialise");
    if (!bytes || size < model_serialized_size())
        return unsupported(instance, "too few bytes for the serialised state; ask for its size");
    model_serialize(state, (unsigned char *)bytes);
    return status(1);
}

Answer FUNCTION(F(DeSerializeFMUstate, DeserializeFMUState))(void *handle, const Byte bytes[], size_t size, State *state)
{
    Instance *instance = handle;
    Memory memory;
    if (!instance || !bytes || !state)
        return unsupported(instance, "no serialised state is given, or nowhere to put the state");
    if (!model_deserialize(&instance->model, (const unsigned char *)bytes, size, &memory))
        return status(0);
    return kept(instance, &memory, state);
}
