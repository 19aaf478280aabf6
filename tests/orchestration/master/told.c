/* A slave that shows what its master tells it: y is the parameter k, which is 1 again after the setup of the
 * experiment (FMI 2.0); then the tolerance, whether time goes forward only, the steps of all instances of this
 * process, its own time. It takes steps of only_step alone, discards long steps from discard_at on, and asks
 * to end the simulation at end_at. With flag 1 it stands still where time does not go forward only. */
#if FMI == 3
#include "fmi3Functions.h"
#else
#include "fmi2Functions.h"
#endif
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { K, Y, TOLERANCE, FORWARD, STEPS, TIME, ONLY_STEP, DISCARD_AT, END_AT, STUBBORN, COUNT };
typedef struct { double r[COUNT]; int ends; } Slave;
static double steps_of_all;

static Slave *begun(void)
{
    Slave *s = calloc(1, sizeof *s);
    s->r[K] = 1, s->r[TOLERANCE] = -1;
    s->r[DISCARD_AT] = s->r[END_AT] = 1e300;
    return s;
}
static int get(const Slave *s, const unsigned *v, size_t n, double *x)
{
    for (size_t i = 0; i < n; i++)
        x[i] = v[i] == Y ? s->r[K] : s->r[v[i]];
    return 0;
}
static int set(Slave *s, const unsigned *v, size_t n, const double *x)
{
    for (size_t i = 0; i < n; i++)
        s->r[v[i]] = x[i];
    return 0;
}
static int advance(Slave *s, double t, double h, int forward)
{
    if (s->r[ONLY_STEP] > 0 && fabs(h - s->r[ONLY_STEP]) > 1e-9)
        return 3;
    if (t >= s->r[DISCARD_AT] && h > 0.3)
        return 2;
    s->r[FORWARD] = forward;
    s->r[STEPS] = ++steps_of_all;
    if (forward || !s->r[STUBBORN])
        s->r[TIME] = t + h;
    s->ends = t + h > s->r[END_AT] - 1e-9;
    if (s->ends && FMI == 2)
        s->r[TIME] = s->r[END_AT];
    return 0;
}
static int save(Slave *s, void **state)
{
    *state = *state ? *state : malloc(sizeof *s);
    memcpy(*state, s, sizeof *s);
    return 0;
}

#if FMI == 3
fmi3Status fmi3SetDebugLogging(fmi3Instance i, fmi3Boolean on, size_t n, const fmi3String c[]) { return 0; }
fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String path, fmi3Boolean visible,
    fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early, const fmi3ValueReference required[], size_t n,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update)
{
    return begun();
}
void fmi3FreeInstance(fmi3Instance i) { free(i); }
fmi3Status fmi3EnterInitializationMode(fmi3Instance i, fmi3Boolean d, double tolerance, double t, fmi3Boolean s, double e)
{
    ((Slave *)i)->r[TOLERANCE] = d ? tolerance : -1;
    return 0;
}
fmi3Status fmi3ExitInitializationMode(fmi3Instance i) { return 0; }
fmi3Status fmi3Terminate(fmi3Instance i) { return 0; }
fmi3Status fmi3GetFloat64(fmi3Instance i, const fmi3ValueReference v[], size_t n, double x[], size_t m) { return get(i, v, n, x); }
fmi3Status fmi3SetFloat64(fmi3Instance i, const fmi3ValueReference v[], size_t n, const double x[], size_t m) { return set(i, v, n, x); }
fmi3Status fmi3GetFMUState(fmi3Instance i, fmi3FMUState *state) { return save(i, state); }
fmi3Status fmi3SetFMUState(fmi3Instance i, fmi3FMUState state) { memcpy(i, state, sizeof(Slave)); return 0; }
fmi3Status fmi3FreeFMUState(fmi3Instance i, fmi3FMUState *state) { free(*state); return 0; }
fmi3Status fmi3DoStep(fmi3Instance i, double t, double h, fmi3Boolean forward, fmi3Boolean *event, fmi3Boolean *terminate,
                      fmi3Boolean *early, double *last)
{
    int status = advance(i, t, h, forward);
    *event = *early = 0;
    *terminate = ((Slave *)i)->ends;
    *last = t + h;
    return status;
}
#else
fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String k[]) { return 0; }
fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
    const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging)
{
    return begun();
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean d, double tolerance, double t, fmi2Boolean s, double e)
{
    Slave *slave = c;
    slave->r[K] = 1;
    slave->r[TOLERANCE] = d ? tolerance : -1;
    return 0;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return 0; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return 0; }
fmi2Status fmi2Terminate(fmi2Component c) { return 0; }
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference v[], size_t n, double x[]) { return get(c, v, n, x); }
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference v[], size_t n, const double x[]) { return set(c, v, n, x); }
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) { return save(c, state); }
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) { memcpy(c, state, sizeof(Slave)); return 0; }
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) { free(*state); return 0; }
fmi2Status fmi2DoStep(fmi2Component c, double t, double h, fmi2Boolean forward)
{
    int status = advance(c, t, h, forward);
    return status ? status : ((Slave *)c)->ends ? fmi2Discard : fmi2OK;
}
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *x)
{
    *x = kind == fmi2Terminated && ((Slave *)c)->ends;
    return 0;
}
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, double *x)
{
    *x = ((Slave *)c)->r[TIME];
    return 0;
}
#endif
