/* A model for model exchange: a ball that falls under g and a wind u, and bounces with restitution 1/2; a clock
 * that counts whole seconds; the simulation ends when it has counted to `last`. With flag 1 its discrete states
 * never agree; with flag 2 it asks for an event after every step of the solver. */
#if FMI == 1
#include <stddef.h>
typedef char Flag;
typedef int Status;
#elif FMI == 3
#include "fmi3Functions.h"
typedef fmi3Boolean Flag;
typedef fmi3Status Status;
#else
#include "fmi2Functions.h"
typedef fmi2Boolean Flag;
typedef fmi2Status Status;
#endif
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { TIME, H, FALL, U, COUNT, LAST, FLAW, NUMBER };
typedef struct { double r[NUMBER]; } Model;

static Model *begun(void)
{
    Model *m = calloc(1, sizeof *m);
    m->r[H] = 1, m->r[LAST] = 1e9;
    return m;
}
static int get(const Model *m, const unsigned *v, size_t n, double *x)
{
    for (size_t i = 0; i < n; i++)
        x[i] = m->r[v[i]];
    return 0;
}
static int set(Model *m, const unsigned *v, size_t n, const double *x)
{
    for (size_t i = 0; i < n; i++)
        m->r[v[i]] = x[i];
    return 0;
}
static int rates(Model *m, double *x) { return x[0] = m->r[FALL], x[1] = m->r[U] - 9.81, 0; }
static int round_of_event(Model *m, Flag *again, Flag *ends, Flag *changed, Flag *defined, double *next)
{
    *again = m->r[FLAW] == 1;
    *changed = 0;
    if (m->r[H] <= 0 && m->r[FALL] < 0)
        m->r[H] = 1e-300, m->r[FALL] *= -0.5, *changed = 1;
    if (m->r[TIME] >= m->r[COUNT] + 1)
        m->r[COUNT]++;
    *ends = m->r[COUNT] >= m->r[LAST];
    *defined = 1, *next = m->r[COUNT] + 1;
    return 0;
}
static int save(Model *m, void **state)
{
    *state = *state ? *state : malloc(sizeof *m);
    memcpy(*state, m, sizeof *m);
    return 0;
}
static int states(Model *m, double *x) { return x[0] = m->r[H], x[1] = m->r[FALL], 0; }
static int move(Model *m, const double *x) { return m->r[H] = x[0], m->r[FALL] = x[1], 0; }
static int ones(double *x) { return x[0] = x[1] = 1, 0; }

#if FMI == 1
typedef void *C;
typedef struct { void *functions[4]; } Callbacks;
typedef struct { char converged, references, states, ends, defined; double next; } Info;
#define NAMED(name) Exchange_fmi##name
const char *Exchange_fmiGetModelTypesPlatform(void) { return "standard32"; }
const char *Exchange_fmiGetVersion(void) { return "1.0"; }
int Exchange_fmiSetDebugLogging(C c, char on) { return 0; }
C Exchange_fmiInstantiateModel(const char *name, const char *guid, Callbacks callbacks, char logging) { return begun(); }
void Exchange_fmiFreeModelInstance(C c) { free(c); }
int Exchange_fmiGetReal(C c, const unsigned v[], size_t n, double x[]) { return get(c, v, n, x); }
int Exchange_fmiSetReal(C c, const unsigned v[], size_t n, const double x[]) { return set(c, v, n, x); }
int Exchange_fmiEventUpdate(C c, char between, Info *e)
{
    Flag again;
    int status = round_of_event(c, &again, &e->ends, &e->states, &e->defined, &e->next);
    return e->converged = !again, status;
}
int Exchange_fmiInitialize(C c, char d, double tolerance, Info *e) { return Exchange_fmiEventUpdate(c, 0, e); }
int Exchange_fmiGetDerivatives(C c, double x[], size_t n) { return rates(c, x); }
int Exchange_fmiGetNominalContinuousStates(C c, double x[], size_t n) { return ones(x); }
int Exchange_fmiGetStateValueReferences(C c, unsigned v[], size_t n) { return v[0] = H, v[1] = FALL, 0; }
int Exchange_fmiGetInteger(void) { return 3; }
int Exchange_fmiSetInteger(void) { return 3; }
int Exchange_fmiGetBoolean(void) { return 3; }
int Exchange_fmiSetBoolean(void) { return 3; }
int Exchange_fmiGetString(void) { return 3; }
int Exchange_fmiSetString(void) { return 3; }
#elif FMI == 3
typedef fmi3Instance C;
#define NAMED(name) fmi3##name
fmi3Status fmi3SetDebugLogging(C c, fmi3Boolean on, size_t n, const fmi3String k[]) { return 0; }
C fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String path, fmi3Boolean visible,
    fmi3Boolean logging, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log) { return begun(); }
fmi3Status fmi3EnterInitializationMode(C c, fmi3Boolean d, double tolerance, double t, fmi3Boolean s, double e) { return 0; }
fmi3Status fmi3GetFloat64(C c, const unsigned v[], size_t n, double x[], size_t m) { return get(c, v, n, x); }
fmi3Status fmi3SetFloat64(C c, const unsigned v[], size_t n, const double x[], size_t m) { return set(c, v, n, x); }
fmi3Status fmi3GetFMUState(C c, fmi3FMUState *state) { return save(c, state); }
fmi3Status fmi3SetFMUState(C c, fmi3FMUState state) { memcpy(c, state, sizeof(Model)); return 0; }
fmi3Status fmi3FreeFMUState(C c, fmi3FMUState *state) { free(*state); return 0; }
fmi3Status fmi3UpdateDiscreteStates(C c, Flag *again, Flag *ends, Flag *nominals, Flag *changed, Flag *defined, double *next)
{
    return *nominals = 0, round_of_event(c, again, ends, changed, defined, next);
}
fmi3Status fmi3GetContinuousStateDerivatives(C c, double x[], size_t n) { return rates(c, x); }
fmi3Status fmi3GetNumberOfEventIndicators(C c, size_t *n) { return *n = 1, 0; }
fmi3Status fmi3GetNumberOfContinuousStates(C c, size_t *n) { return *n = 2, 0; }
#else
typedef fmi2Component C;
#define NAMED(name) fmi2##name
fmi2Status fmi2SetDebugLogging(C c, fmi2Boolean on, size_t n, const fmi2String k[]) { return 0; }
C fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
    const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging)
{
    return type == fmi2ModelExchange ? begun() : NULL;
}
fmi2Status fmi2SetupExperiment(C c, fmi2Boolean d, double tolerance, double t, fmi2Boolean s, double e) { return 0; }
fmi2Status fmi2EnterInitializationMode(C c) { return 0; }
fmi2Status fmi2GetReal(C c, const unsigned v[], size_t n, double x[]) { return get(c, v, n, x); }
fmi2Status fmi2SetReal(C c, const unsigned v[], size_t n, const double x[]) { return set(c, v, n, x); }
fmi2Status fmi2GetFMUstate(C c, fmi2FMUstate *state) { return save(c, state); }
fmi2Status fmi2SetFMUstate(C c, fmi2FMUstate state) { memcpy(c, state, sizeof(Model)); return 0; }
fmi2Status fmi2FreeFMUstate(C c, fmi2FMUstate *state) { free(*state); return 0; }
fmi2Status fmi2NewDiscreteStates(C c, fmi2EventInfo *e)
{
    e->nominalsOfContinuousStatesChanged = 0;
    return round_of_event(c, &e->newDiscreteStatesNeeded, &e->terminateSimulation, &e->valuesOfContinuousStatesChanged,
                          &e->nextEventTimeDefined, &e->nextEventTime);
}
fmi2Status fmi2GetDerivatives(C c, double x[], size_t n) { return rates(c, x); }
#endif
#if FMI == 1
int Exchange_fmiCompletedIntegratorStep(C c, Flag *event) { return *event = ((Model *)c)->r[FLAW] == 2, 0; }
#else
void NAMED(FreeInstance)(C c) { free(c); }
Status NAMED(CompletedIntegratorStep)(C c, Flag kept, Flag *event, Flag *ends)
{
    return *event = ((Model *)c)->r[FLAW] == 2, *ends = 0, 0;
}
#endif
Status NAMED(ExitInitializationMode)(C c) { return 0; }
Status NAMED(Terminate)(C c) { return 0; }
Status NAMED(EnterEventMode)(C c) { return 0; }
Status NAMED(EnterContinuousTimeMode)(C c) { return 0; }
Status NAMED(SetTime)(C c, double t) { return ((Model *)c)->r[TIME] = t, 0; }
Status NAMED(SetContinuousStates)(C c, const double x[], size_t n) { return move(c, x); }
Status NAMED(GetContinuousStates)(C c, double x[], size_t n) { return states(c, x); }
Status NAMED(GetNominalsOfContinuousStates)(C c, double x[], size_t n) { return ones(x); }
Status NAMED(GetEventIndicators)(C c, double z[], size_t n) { return z[0] = ((Model *)c)->r[H], 0; }
