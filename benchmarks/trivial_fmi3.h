/* The trivial slave's functions of FMI 3.0. */
#define S ((Slave *)instance)
#define D (&S->data)
const char *fmi3GetVersion(void) { return "3.0"; }
fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean on, size_t n, const fmi3String c[]) { return OK; }
fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String path, fmi3Boolean visible,
    fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early, const fmi3ValueReference required[], size_t n,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update) {
    Slave *s = calloc(1, sizeof *s);
    if (!s) return NULL;
    initial(&s->data);
    snprintf(s->name, sizeof s->name, "%s", name);
    s->log = log; s->update = update; s->environment = environment;
    return s;
}
void fmi3FreeInstance(fmi3Instance instance) { free(instance); }
fmi3Status fmi3EnterInitializationMode(fmi3Instance i, fmi3Boolean a, fmi3Float64 b, fmi3Float64 c, fmi3Boolean d, fmi3Float64 e) { return OK; }
fmi3Status fmi3ExitInitializationMode(fmi3Instance i) { return OK; }
fmi3Status fmi3Terminate(fmi3Instance i) { return OK; }
fmi3Status fmi3Reset(fmi3Instance instance) { initial(D); return OK; }
fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference v[], size_t n, fmi3Float64 x[], size_t m)
    EACH(get_real(D, v[k], &x[k]))
fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference v[], size_t n, const fmi3Float64 x[], size_t m)
    EACH(set_real(D, v[k], x[k]))
fmi3Status fmi3GetInt32(fmi3Instance instance, const fmi3ValueReference v[], size_t n, fmi3Int32 x[], size_t m)
    EACH(get_integer(D, v[k], &x[k]))
fmi3Status fmi3SetInt32(fmi3Instance instance, const fmi3ValueReference v[], size_t n, const fmi3Int32 x[], size_t m)
    EACH(set_integer(D, v[k], x[k]))
fmi3Status fmi3GetBoolean(fmi3Instance instance, const fmi3ValueReference v[], size_t n, fmi3Boolean x[], size_t m)
    EACH(get_boolean(D, v[k], &x[k]))
fmi3Status fmi3SetBoolean(fmi3Instance instance, const fmi3ValueReference v[], size_t n, const fmi3Boolean x[], size_t m)
    EACH(set_boolean(D, v[k], x[k]))
fmi3Status fmi3GetString(fmi3Instance instance, const fmi3ValueReference v[], size_t n, fmi3String x[], size_t m)
    EACH(get_string(D, v[k], &x[k]))
fmi3Status fmi3SetString(fmi3Instance instance, const fmi3ValueReference v[], size_t n, const fmi3String x[], size_t m)
    EACH(set_string(D, v[k], x[k]))
fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *state) { return save(D, state); }
fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state) { memcpy(D, state, sizeof(Data)); return OK; }
fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *state) { free(*state); *state = NULL; return OK; }
fmi3Status fmi3SerializedFMUStateSize(fmi3Instance i, fmi3FMUState s, size_t *n) { *n = sizeof(Data); return OK; }
fmi3Status fmi3SerializeFMUState(fmi3Instance i, fmi3FMUState s, fmi3Byte b[], size_t n) { memcpy(b, s, n); return OK; }
fmi3Status fmi3DeserializeFMUState(fmi3Instance i, const fmi3Byte b[], size_t n, fmi3FMUState *state) { return save(b, state); }
fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, const fmi3ValueReference v[], size_t n, const fmi3Int32 order[], fmi3Float64 x[], size_t m) {
    for (size_t k = 0; k < n; k++) { if (v[k] != Y || order[k] != 1) return ERROR; x[k] = D->r[RATE] * D->r[U]; }
    return OK;
}
fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 t, fmi3Float64 h, fmi3Boolean keep, fmi3Boolean *event,
    fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *last) {
    Status status = OK;
    *event = *terminate = *early = 0;
    /* Four micro steps with the input in the middle of each: exact for inputs linear in time. */
    for (int k = 0; k < 4 && status == OK; k++) {
        fmi3Boolean requested = 0; fmi3Float64 unused = 0;
        if (S->update) S->update(S->environment, t + (k + 0.5) * h / 4, 1, 1, 0, 0, &requested, &unused);
        status = h > D->r[LARGEST_STEP] * (1 + 1e-12) ? advance(S, t, h) : advance(S, t + k * h / 4, h / 4);
    }
    D->steps -= status == OK ? 3 : 0;
    *last = t + h;
    return status;
}
#define ABSENT(name, ...) fmi3Status name(fmi3Instance instance, ##__VA_ARGS__) { return ERROR; }
#define VALUES(T) \
    ABSENT(fmi3Get##T, const fmi3ValueReference v[], size_t n, fmi3##T x[], size_t m) \
    ABSENT(fmi3Set##T, const fmi3ValueReference v[], size_t n, const fmi3##T x[], size_t m)
VALUES(Float32) VALUES(Int8) VALUES(UInt8) VALUES(Int16) VALUES(UInt16) VALUES(UInt32) VALUES(Int64) VALUES(UInt64)
ABSENT(fmi3GetBinary, const fmi3ValueReference v[], size_t n, size_t s[], fmi3Binary x[], size_t m)
ABSENT(fmi3SetBinary, const fmi3ValueReference v[], size_t n, const size_t s[], const fmi3Binary x[], size_t m)
ABSENT(fmi3GetClock, const fmi3ValueReference v[], size_t n, fmi3Clock x[])
ABSENT(fmi3SetClock, const fmi3ValueReference v[], size_t n, const fmi3Clock x[])
ABSENT(fmi3GetNumberOfVariableDependencies, fmi3ValueReference v, size_t *n)
ABSENT(fmi3GetVariableDependencies, fmi3ValueReference v, size_t a[], fmi3ValueReference b[], size_t c[], fmi3DependencyKind d[], size_t n)
ABSENT(fmi3GetDirectionalDerivative, const fmi3ValueReference a[], size_t b, const fmi3ValueReference c[], size_t d, const fmi3Float64 e[], size_t f, fmi3Float64 g[], size_t h)
ABSENT(fmi3GetAdjointDerivative, const fmi3ValueReference a[], size_t b, const fmi3ValueReference c[], size_t d, const fmi3Float64 e[], size_t f, fmi3Float64 g[], size_t h)
ABSENT(fmi3EnterEventMode) ABSENT(fmi3EnterConfigurationMode) ABSENT(fmi3ExitConfigurationMode)
ABSENT(fmi3GetIntervalDecimal, const fmi3ValueReference v[], size_t n, fmi3Float64 x[], fmi3IntervalQualifier q[])
ABSENT(fmi3GetIntervalFraction, const fmi3ValueReference v[], size_t n, fmi3UInt64 x[], fmi3UInt64 y[], fmi3IntervalQualifier q[])
ABSENT(fmi3GetShiftDecimal, const fmi3ValueReference v[], size_t n, fmi3Float64 x[])
ABSENT(fmi3GetShiftFraction, const fmi3ValueReference v[], size_t n, fmi3UInt64 x[], fmi3UInt64 y[])
ABSENT(fmi3SetIntervalDecimal, const fmi3ValueReference v[], size_t n, const fmi3Float64 x[])
ABSENT(fmi3SetIntervalFraction, const fmi3ValueReference v[], size_t n, const fmi3UInt64 x[], const fmi3UInt64 y[])
ABSENT(fmi3SetShiftDecimal, const fmi3ValueReference v[], size_t n, const fmi3Float64 x[])
ABSENT(fmi3SetShiftFraction, const fmi3ValueReference v[], size_t n, const fmi3UInt64 x[], const fmi3UInt64 y[])
ABSENT(fmi3EvaluateDiscreteStates)
ABSENT(fmi3UpdateDiscreteStates, fmi3Boolean *a, fmi3Boolean *b, fmi3Boolean *c, fmi3Boolean *d, fmi3Boolean *e, fmi3Float64 *f)
ABSENT(fmi3EnterStepMode)
ABSENT(fmi3EnterContinuousTimeMode)
ABSENT(fmi3CompletedIntegratorStep, fmi3Boolean a, fmi3Boolean *b, fmi3Boolean *c)
ABSENT(fmi3SetTime, fmi3Float64 t)
ABSENT(fmi3SetContinuousStates, const fmi3Float64 x[], size_t n)
ABSENT(fmi3GetContinuousStateDerivatives, fmi3Float64 x[], size_t n)
ABSENT(fmi3GetEventIndicators, fmi3Float64 x[], size_t n)
ABSENT(fmi3GetContinuousStates, fmi3Float64 x[], size_t n)
ABSENT(fmi3GetNominalsOfContinuousStates, fmi3Float64 x[], size_t n)
ABSENT(fmi3GetNumberOfEventIndicators, size_t *n)
ABSENT(fmi3GetNumberOfContinuousStates, size_t *n)
ABSENT(fmi3ActivateModelPartition, fmi3ValueReference v, fmi3Float64 t)
fmi3Instance fmi3InstantiateModelExchange(fmi3String a, fmi3String b, fmi3String c, fmi3Boolean d, fmi3Boolean e,
    fmi3InstanceEnvironment f, fmi3LogMessageCallback g) { return NULL; }
fmi3Instance fmi3InstantiateScheduledExecution(fmi3String a, fmi3String b, fmi3String c, fmi3Boolean d, fmi3Boolean e,
    fmi3InstanceEnvironment f, fmi3LogMessageCallback g, fmi3ClockUpdateCallback h, fmi3LockPreemptionCallback i,
    fmi3UnlockPreemptionCallback j) { return NULL; }
