/* The trivial slave's functions of FMI 2.0. */
#define S ((Slave *)c)
#define D (&S->data)
const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }
fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String k[]) { return OK; }
fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
    const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging) {
    Slave *s = callbacks->allocateMemory(1, sizeof *s);
    while (!strcmp(name, "endless")) ;
    if (!s) return NULL;
    initial(&s->data);
    s->callbacks = *callbacks;
    snprintf(s->name, sizeof s->name, "%s", name);
    return s;
}
void fmi2FreeInstance(fmi2Component c) {
    if (!c) return;
    if (!strcmp(D->label, "crash in free")) raise(SIGSEGV);
    if (!strcmp(D->label, "hang in free")) for (;;) ;
    S->callbacks.freeMemory(c);
}
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean a, fmi2Real b, fmi2Real s, fmi2Boolean d, fmi2Real e) { return OK; }
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return OK; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return OK; }
fmi2Status fmi2Terminate(fmi2Component c) {
    if (!strcmp(D->label, "crash in terminate")) raise(SIGSEGV);
    return OK;
}
fmi2Status fmi2Reset(fmi2Component c) { initial(D); return OK; }
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference v[], size_t n, fmi2Real x[])
    EACH(get_real(D, v[k], &x[k]))
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference v[], size_t n, const fmi2Real x[])
    EACH(set_real(D, v[k], x[k]))
fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference v[], size_t n, fmi2Integer x[])
    EACH(get_integer(D, v[k], &x[k]))
fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference v[], size_t n, const fmi2Integer x[])
    EACH(set_integer(D, v[k], x[k]))
fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference v[], size_t n, fmi2Boolean x[])
    EACH(get_boolean(D, v[k], &x[k]))
fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference v[], size_t n, const fmi2Boolean x[])
    EACH(set_boolean(D, v[k], x[k]))
fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference v[], size_t n, fmi2String x[])
    EACH(get_string(D, v[k], &x[k]))
fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference v[], size_t n, const fmi2String x[])
    EACH(set_string(D, v[k], x[k]))
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    return strcmp(D->label, "no state") ? save(D, state) : OK;
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    if (!strcmp(D->label, "crash in restore")) raise(SIGSEGV);
    if (!strcmp(D->label, "hang in restore")) for (;;) ;
    if (!strcmp(D->label, "exit in restore")) exit(0);
    if (!strcmp(D->label, "discard in restore")) return DISCARD;
    memcpy(D, state, sizeof(Data));
    return OK;
}
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) { free(*state); *state = NULL; return OK; }
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate s, size_t *n) { *n = sizeof(Data); return OK; }
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate s, fmi2Byte b[], size_t n) { memcpy(b, s, n); return OK; }
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte b[], size_t n, fmi2FMUstate *state) { return save(b, state); }
fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference a[], size_t b, const fmi2ValueReference d[], size_t e, const fmi2Real f[], fmi2Real g[]) { return ERROR; }
fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference v[], size_t n, const fmi2Integer order[], const fmi2Real x[]) {
    for (size_t k = 0; k < n; k++) {
        if (v[k] != U || order[k] < 1 || order[k] > 2) return ERROR;
        if (order[k] == 1) D->slope = x[k]; else D->curvature = x[k];
    }
    return OK;
}
fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference v[], size_t n, const fmi2Integer order[], fmi2Real x[]) {
    for (size_t k = 0; k < n; k++) { if (v[k] != Y || order[k] != 1) return ERROR; x[k] = D->r[RATE] * D->r[U]; }
    return OK;
}
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean keep) { return advance(S, t, h); }
fmi2Status fmi2CancelStep(fmi2Component c) { return ERROR; }
fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind k, fmi2Status *v) { return DISCARD; }
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind k, fmi2Real *v) { return DISCARD; }
fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind k, fmi2Integer *v) { return DISCARD; }
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind k, fmi2Boolean *v) { *v = 0; return OK; }
fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind k, fmi2String *v) { return DISCARD; }
