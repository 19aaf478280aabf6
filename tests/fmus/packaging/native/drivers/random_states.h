/* States that are saved, restored, damaged and stamped anew; a part of random_calls.c. */

/* A phase, a time or another number becomes something else, and the digest is right all the same. */
static void damage(Memory *memory)
{
    double *numbers = (double *)memory;
    size_t size = sizeof *memory / sizeof *numbers, run = &memory->start_time - numbers;
    for (unsigned count = 1 + draw(2); count > 0; count--) {
        double *number = &numbers[one_in(2) ? run + draw((unsigned)(size - run)) : draw((unsigned)size)];
        unsigned long long bits;
        if (one_in(2)) {
            *number = odd_number();
            continue;
        }
        memcpy(&bits, number, sizeof bits);
        bits ^= 1ull << draw(64);
        memcpy(number, &bits, sizeof bits);
    }
}

static void serialised(void)
{
    State *place = &kept[draw(STATES_KEPT)], read = NULL;
    size_t size = 0;
    CALL(*place != NULL, F(SerializedFMUstateSize, SerializedFMUStateSize)(driven, *place, one_in(9) ? NULL : &size));
    if (size == 0)
        return;
    Byte *bytes = malloc(size);
    CALL(0, F(SerializeFMUstate, SerializeFMUState)(driven, *place, one_in(2) ? NULL : bytes, one_in(2) ? 0 : size - 1));
    CALL(0, F(DeSerializeFMUstate, DeserializeFMUState)(driven, one_in(2) ? NULL : bytes, 0, &read));
    CALL(0, F(DeSerializeFMUstate, DeserializeFMUState)(driven, bytes, size, NULL));
    CALL(1, F(SerializeFMUstate, SerializeFMUState)(driven, *place, bytes, size));
    Status status = F(DeSerializeFMUstate, DeserializeFMUState)(driven, bytes, size, &read);
    FAULTY(status != OK || memcmp(read, *place, sizeof(Memory)) != 0, "the instance's own state is not taken");
    if (one_in(2)) {
        bytes[draw((unsigned)size)] ^= (Byte)(1 << draw(8));
        CALL(0, F(DeSerializeFMUstate, DeserializeFMUState)(driven, bytes, size, &read));
    } else if (read) {
        Memory *memory = (Memory *)read;
        damage(memory);
        FAULTY(F(SerializeFMUstate, SerializeFMUState)(driven, read, bytes, size) != OK, "a state is not serialised");
        long before = sentences;
        status = F(DeSerializeFMUstate, DeserializeFMUState)(driven, bytes, size, place);
        judge(status, before, 1);
        status == OK ? restored++ : refused++;
        if (status == OK && depth == 0)
            FAULTY(F(SetFMUstate, SetFMUState)(driven, *place) != OK, "a state that was read is not taken");
    }
    CALL(1, F(FreeFMUstate, FreeFMUState)(driven, &read));
    free(bytes);
}

static void states(void)
{
    State *place = &kept[draw(STATES_KEPT)];
    unsigned which = draw(10);
    if (which == 0)
        CALL(*place != NULL, F(SetFMUstate, SetFMUState)(driven, *place));
    else if (which == 1)
        CALL(1, F(FreeFMUstate, FreeFMUState)(driven, one_in(5) ? NULL : place));
    else if (which == 2)
        CALL(0, F(GetFMUstate, GetFMUState)(driven, NULL));
    else if (which == 3)
        CALL(1, F(GetFMUstate, GetFMUState)(driven, place));
    else
        serialised();
}
