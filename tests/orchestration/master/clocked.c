/* A slave of FMI 3.0 for scheduled execution. Clock 1 is periodic, clock 2 counts down 0.1 s from each third tick of
 * clock 1, clock 3 is like clock 1 but comes first; `ticks` counts those of 1, `late` is the time of the last one of
 * 2, `order` is 1 if 1 ticked before 3 at any time. A step is no function of it. */
#include "fmi3Functions.h"
#include <stdlib.h>

enum { TICKS = 10, LATE, ORDER, NUMBER };
typedef struct { double r[NUMBER - TICKS], first; int counting; } Slave;

fmi3Status fmi3SetDebugLogging(fmi3Instance i, fmi3Boolean on, size_t n, const fmi3String c[]) { return 0; }
fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String path, fmi3Boolean visible,
    fmi3Boolean logging, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, fmi3ClockUpdateCallback update,
    fmi3LockPreemptionCallback lock, fmi3UnlockPreemptionCallback unlock)
{
    Slave *s = update && lock && unlock ? calloc(1, sizeof *s) : NULL;
    if (s)
        s->first = -1;
    return s;
}
void fmi3FreeInstance(fmi3Instance i) { free(i); }
fmi3Status fmi3EnterInitializationMode(fmi3Instance i, fmi3Boolean d, double tolerance, double t, fmi3Boolean s, double e) { return 0; }
fmi3Status fmi3ExitInitializationMode(fmi3Instance i) { return 0; }
fmi3Status fmi3Terminate(fmi3Instance i) { return 0; }
fmi3Status fmi3GetFloat64(fmi3Instance i, const fmi3ValueReference v[], size_t n, double x[], size_t m)
{
    for (size_t k = 0; k < n; k++)
        x[k] = ((Slave *)i)->r[v[k] - TICKS];
    return 0;
}
fmi3Status fmi3GetIntervalDecimal(fmi3Instance i, const fmi3ValueReference v[], size_t n, fmi3Float64 x[], fmi3IntervalQualifier q[])
{
    Slave *s = i;
    x[0] = v[0] == 2 ? 0.1 : 0.5;
    q[0] = v[0] == 2 && s->counting ? fmi3IntervalChanged : fmi3IntervalUnchanged;
    if (v[0] == 2)
        s->counting = 0;
    return 0;
}
fmi3Status fmi3ActivateModelPartition(fmi3Instance i, fmi3ValueReference clock, fmi3Float64 t)
{
    Slave *s = i;
    if (clock == 1) {
        s->counting = (long)++s->r[0] % 3 == 0;
        if (s->first != t)
            s->r[ORDER - TICKS] = 1;
    }
    if (clock == 2)
        s->r[LATE - TICKS] = t;
    if (clock == 3)
        s->first = t;
    return clock <= 3 ? 0 : 3;
}
