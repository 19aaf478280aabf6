/* A trivial slave of plain C, for tests and benchmarks of masters:
 *     dx/dt = rate u,   y = x,   z = gain u (at once).
 * It misbehaves on request: from time fail_at on, doStep does what fail_status says
 * (2 discard, 3 error, 4 fatal, 5 crash, 6 never return, 7 NaN, 8 exit, 9 another folder,
 * 10 another rounding, 11 another locale, 12 print, 13 fork, 14 take all memory), and a step longer
 * than largest_step is discarded. An FMI 2.0 instance whose label is "crash in terminate", "crash in
 * free" or "hang in free" does so, and one named "endless" is never instantiated.
 * Compiled with -DFMI3 it speaks FMI 3.0, else FMI 2.0. */
#include <fenv.h>
#include <locale.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifndef _WIN32
#include <unistd.h>
#else
#include <direct.h>
#endif

#ifdef FMI3
#include "fmi3Functions.h"
typedef fmi3Status Status;
typedef fmi3ValueReference Reference;
enum { OK = fmi3OK, DISCARD = fmi3Discard, ERROR = fmi3Error };
#else
#include "fmi2Functions.h"
typedef fmi2Status Status;
typedef fmi2ValueReference Reference;
enum { OK = fmi2OK, DISCARD = fmi2Discard, ERROR = fmi2Error };
#endif

enum { U, Y, Z, RATE, GAIN, FAIL_AT, LARGEST_STEP, REALS };
enum { FAIL_STATUS = REALS, STEPS, SWITCHED, ON, OFF, LABEL };

typedef struct {
    double r[REALS];
    double slope, curvature;
    int fail_status, steps, switched, on;
    char label[64];
} Data;

typedef struct {
    Data data;
    char name[64];
#ifdef FMI3
    fmi3LogMessageCallback log;
    fmi3IntermediateUpdateCallback update;
    void *environment;
#else
    fmi2CallbackFunctions callbacks;
#endif
} Slave;

static void initial(Data *d) {
    memset(d, 0, sizeof *d);
    d->r[U] = d->r[RATE] = d->r[GAIN] = 1.0;
    d->r[FAIL_AT] = d->r[LARGEST_STEP] = 1e300;
    strcpy(d->label, "none");
}

static void complain(Slave *s, int status, const char *text, double value) {
#ifdef FMI3
    char line[200];
    snprintf(line, sizeof line, "%s %g", text, value);
    s->log(s->environment, status, "logStatus", line);
#else
    s->callbacks.logger(s->callbacks.componentEnvironment, s->name, status, "logStatus", "%s %g", text, value);
#endif
}

static int get_real(const Data *d, Reference v, double *value) {
    if (v >= REALS) return 0;
    *value = v == Z ? d->r[GAIN] * d->r[U] : d->r[v];
    return 1;
}

static int set_real(Data *d, Reference v, double value) {
    if (v >= REALS) return 0;
    d->r[v] = value;
    if (v == U) d->slope = d->curvature = 0.0;
    return 1;
}

static int advance(Slave *s, double t, double h) {
    Data *d = &s->data;
    if (h > d->r[LARGEST_STEP] * (1 + 1e-12)) {
        complain(s, DISCARD, "the step is above", d->r[LARGEST_STEP]);
        return DISCARD;
    }
    if (t + h > d->r[FAIL_AT]) {
        switch (d->fail_status) {
        case 5: raise(SIGSEGV); break;
        case 6: for (;;) ; break;
        case 7: d->r[Y] = NAN; return OK;
        case 8: exit(0);
        case 9: if (chdir("/")) return ERROR; break;
        case 10: fesetround(FE_UPWARD); break;
        case 11: setlocale(LC_ALL, "C"); break;
        case 12: printf("printed by the FMU\n"); break;
#ifndef _WIN32
        case 13: fork(); break;
#endif
        case 14: for (;;) { char *p = malloc(1 << 24); if (!p) abort(); memset(p, 1, 1 << 24); }
        default: complain(s, d->fail_status, "it fails from", d->r[FAIL_AT]); return d->fail_status;
        }
    }
    d->r[Y] += d->r[RATE] * h * (d->r[U] + h * (d->slope / 2 + h * d->curvature / 6));
    d->r[U] += h * (d->slope + h * d->curvature / 2);
    d->slope = d->curvature = 0.0;
    d->steps++;
    return OK;
}

#ifdef FMI3
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
fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference v[], size_t n, fmi3Float64 x[], size_t m) {
    for (size_t k = 0; k < n; k++) if (!get_real(D, v[k], &x[k])) return ERROR;
    return OK;
}
fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference v[], size_t n, const fmi3Float64 x[], size_t m) {
    for (size_t k = 0; k < n; k++) if (!set_real(D, v[k], x[k])) return ERROR;
    return OK;
}
fmi3Status fmi3GetInt32(fmi3Instance instance, const fmi3ValueReference v[], size_t n, fmi3Int32 x[], size_t m) {
    for (size_t k = 0; k < n; k++) {
        if (v[k] == FAIL_STATUS) x[k] = D->fail_status; else if (v[k] == STEPS) x[k] = D->steps;
        else if (v[k] == SWITCHED) x[k] = D->switched; else return ERROR;
    }
    return OK;
}
fmi3Status fmi3SetInt32(fmi3Instance instance, const fmi3ValueReference v[], size_t n, const fmi3Int32 x[], size_t m) {
    for (size_t k = 0; k < n; k++) {
        if (v[k] == FAIL_STATUS) D->fail_status = x[k]; else if (v[k] == SWITCHED) D->switched = x[k]; else return ERROR;
    }
    return OK;
}
fmi3Status fmi3GetBoolean(fmi3Instance instance, const fmi3ValueReference v[], size_t n, fmi3Boolean x[], size_t m) {
    for (size_t k = 0; k < n; k++) {
        if (v[k] == ON) x[k] = D->on != 0; else if (v[k] == OFF) x[k] = !D->on; else return ERROR;
    }
    return OK;
}
fmi3Status fmi3SetBoolean(fmi3Instance instance, const fmi3ValueReference v[], size_t n, const fmi3Boolean x[], size_t m) {
    for (size_t k = 0; k < n; k++) { if (v[k] != ON) return ERROR; D->on = x[k]; }
    return OK;
}
fmi3Status fmi3GetString(fmi3Instance instance, const fmi3ValueReference v[], size_t n, fmi3String x[], size_t m) {
    for (size_t k = 0; k < n; k++) { if (v[k] != LABEL) return ERROR; x[k] = D->label; }
    return OK;
}
fmi3Status fmi3SetString(fmi3Instance instance, const fmi3ValueReference v[], size_t n, const fmi3String x[], size_t m) {
    for (size_t k = 0; k < n; k++) { if (v[k] != LABEL) return ERROR; snprintf(D->label, sizeof D->label, "%s", x[k]); }
    return OK;
}
fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *state) {
    if (!*state) *state = malloc(sizeof(Data));
    memcpy(*state, D, sizeof(Data));
    return OK;
}
fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state) { memcpy(D, state, sizeof(Data)); return OK; }
fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *state) { free(*state); *state = NULL; return OK; }
fmi3Status fmi3SerializedFMUStateSize(fmi3Instance i, fmi3FMUState s, size_t *n) { *n = sizeof(Data); return OK; }
fmi3Status fmi3SerializeFMUState(fmi3Instance i, fmi3FMUState s, fmi3Byte b[], size_t n) { memcpy(b, s, n); return OK; }
fmi3Status fmi3DeserializeFMUState(fmi3Instance i, const fmi3Byte b[], size_t n, fmi3FMUState *state) {
    if (!*state) *state = malloc(sizeof(Data));
    memcpy(*state, b, n);
    return OK;
}
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
#else
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
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference v[], size_t n, fmi2Real x[]) {
    for (size_t k = 0; k < n; k++) if (!get_real(D, v[k], &x[k])) return ERROR;
    return OK;
}
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference v[], size_t n, const fmi2Real x[]) {
    for (size_t k = 0; k < n; k++) if (!set_real(D, v[k], x[k])) return ERROR;
    return OK;
}
fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference v[], size_t n, fmi2Integer x[]) {
    for (size_t k = 0; k < n; k++) {
        if (v[k] == FAIL_STATUS) x[k] = D->fail_status; else if (v[k] == STEPS) x[k] = D->steps;
        else if (v[k] == SWITCHED) x[k] = D->switched; else return ERROR;
    }
    return OK;
}
fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference v[], size_t n, const fmi2Integer x[]) {
    for (size_t k = 0; k < n; k++) {
        if (v[k] == FAIL_STATUS) D->fail_status = x[k]; else if (v[k] == SWITCHED) D->switched = x[k]; else return ERROR;
    }
    return OK;
}
fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference v[], size_t n, fmi2Boolean x[]) {
    for (size_t k = 0; k < n; k++) {
        if (v[k] == ON) x[k] = D->on; else if (v[k] == OFF) x[k] = !D->on; else return ERROR;
    }
    return OK;
}
fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference v[], size_t n, const fmi2Boolean x[]) {
    for (size_t k = 0; k < n; k++) { if (v[k] != ON) return ERROR; D->on = x[k]; }
    return OK;
}
fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference v[], size_t n, fmi2String x[]) {
    for (size_t k = 0; k < n; k++) { if (v[k] != LABEL) return ERROR; x[k] = D->label; }
    return OK;
}
fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference v[], size_t n, const fmi2String x[]) {
    for (size_t k = 0; k < n; k++) { if (v[k] != LABEL) return ERROR; snprintf(D->label, sizeof D->label, "%s", x[k]); }
    return OK;
}
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    if (!*state) *state = malloc(sizeof(Data));
    memcpy(*state, D, sizeof(Data));
    return OK;
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) { memcpy(D, state, sizeof(Data)); return OK; }
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) { free(*state); *state = NULL; return OK; }
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate s, size_t *n) { *n = sizeof(Data); return OK; }
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate s, fmi2Byte b[], size_t n) { memcpy(b, s, n); return OK; }
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte b[], size_t n, fmi2FMUstate *state) {
    if (!*state) *state = malloc(sizeof(Data));
    memcpy(*state, b, n);
    return OK;
}
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
#endif
