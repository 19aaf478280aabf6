/* A slave of FMI 3.0 that handles events outside its steps: level rises by `slope` a second and is halved at each
 * whole second, where its step ends early; slope is discrete and may be set in event mode alone. `rises` counts
 * the rounds of events, `foretells` makes it tell the time of the next one in place of returning early. */
#include "fmi3Functions.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LEVEL, SLOPE, ROUNDS, FORETELLS, NUMBER };
enum { INITIAL, EVENT, STEP };
typedef struct { double r[NUMBER], time, next; int mode, due; } Slave;

fmi3Status fmi3SetDebugLogging(fmi3Instance i, fmi3Boolean on, size_t n, const fmi3String c[]) { return 0; }
fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String path, fmi3Boolean visible,
    fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early, const fmi3ValueReference required[], size_t n,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update)
{
    Slave *s = calloc(1, sizeof *s);
    s->next = s->r[SLOPE] = 1;
    return events && early ? s : NULL;
}
void fmi3FreeInstance(fmi3Instance i) { free(i); }
fmi3Status fmi3EnterInitializationMode(fmi3Instance i, fmi3Boolean d, double tolerance, double t, fmi3Boolean s, double e) { return 0; }
fmi3Status fmi3ExitInitializationMode(fmi3Instance i) { return ((Slave *)i)->mode = EVENT, 0; }
fmi3Status fmi3Terminate(fmi3Instance i) { return 0; }
fmi3Status fmi3EnterEventMode(fmi3Instance i) { return ((Slave *)i)->mode == STEP ? ((Slave *)i)->mode = EVENT, 0 : 3; }
fmi3Status fmi3EnterStepMode(fmi3Instance i) { return ((Slave *)i)->mode == EVENT ? ((Slave *)i)->mode = STEP, 0 : 3; }
fmi3Status fmi3GetFloat64(fmi3Instance i, const fmi3ValueReference v[], size_t n, double x[], size_t m)
{
    for (size_t k = 0; k < n; k++)
        x[k] = ((Slave *)i)->r[v[k]];
    return 0;
}
fmi3Status fmi3SetFloat64(fmi3Instance i, const fmi3ValueReference v[], size_t n, const double x[], size_t m)
{
    for (size_t k = 0; k < n; k++)
        ((Slave *)i)->r[v[k]] = x[k];
    return ((Slave *)i)->mode == STEP ? 3 : 0;
}
fmi3Status fmi3UpdateDiscreteStates(fmi3Instance i, fmi3Boolean *again, fmi3Boolean *ends, fmi3Boolean *nominals,
                                    fmi3Boolean *states, fmi3Boolean *defined, double *next)
{
    Slave *s = i;
    *ends = *nominals = *states = 0;
    *again = s->due && s->time > s->next - 1e-9;
    if (*again)
        s->r[LEVEL] *= 0.5, s->r[ROUNDS]++, s->next++, s->due = 0;
    *defined = s->r[FORETELLS] != 0, *next = s->next;
    return s->mode == EVENT ? 0 : 3;
}
fmi3Status fmi3DoStep(fmi3Instance i, double t, double h, fmi3Boolean forward, fmi3Boolean *event, fmi3Boolean *terminate,
                      fmi3Boolean *early, double *last)
{
    Slave *s = i;
    double end = t + h;
    if (s->mode != STEP || (s->r[FORETELLS] != 0 && end > s->next + 1e-9))
        return 3;
    *early = end > s->next + 1e-9, *terminate = 0;
    end = *early ? s->next : end;
    *event = s->due = end > s->next - 1e-9;
    s->r[LEVEL] += s->r[SLOPE] * (end - t);
    *last = s->time = end;
    return 0;
}
