/* A slave of FMI 3.0 that counts beyond what a double holds: n from 2^53, u down from 2^64 - 1, and back below 0. */
#include "fmi3Functions.h"
#include <stdlib.h>

typedef struct { int64_t n, negative; uint64_t u; } Slave;

const char *fmi3GetVersion(void) { return "3.0"; }
fmi3Status fmi3SetDebugLogging(fmi3Instance i, fmi3Boolean on, size_t n, const fmi3String c[]) { return fmi3OK; }
fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String path, fmi3Boolean visible,
    fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early, const fmi3ValueReference required[], size_t n,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update)
{
    Slave *slave = calloc(1, sizeof *slave);
    if (slave)
        slave->n = 9007199254740992, slave->negative = -4503599627370490, slave->u = UINT64_MAX;
    return slave;
}
void fmi3FreeInstance(fmi3Instance i) { free(i); }
fmi3Status fmi3EnterInitializationMode(fmi3Instance i, fmi3Boolean a, double b, double c, fmi3Boolean d, double e) { return fmi3OK; }
fmi3Status fmi3ExitInitializationMode(fmi3Instance i) { return fmi3OK; }
fmi3Status fmi3Terminate(fmi3Instance i) { return fmi3OK; }
fmi3Status fmi3GetInt64(fmi3Instance i, const fmi3ValueReference v[], size_t n, fmi3Int64 x[], size_t m)
{
    for (size_t k = 0; k < n; k++)
        x[k] = v[k] ? ((Slave *)i)->negative : ((Slave *)i)->n;
    return fmi3OK;
}
fmi3Status fmi3GetUInt64(fmi3Instance i, const fmi3ValueReference v[], size_t n, fmi3UInt64 x[], size_t m)
{
    x[0] = ((Slave *)i)->u;
    return fmi3OK;
}
fmi3Status fmi3DoStep(fmi3Instance i, double t, double h, fmi3Boolean keep, fmi3Boolean *event, fmi3Boolean *terminate,
                      fmi3Boolean *early, double *last)
{
    Slave *slave = i;
    *event = *terminate = *early = 0;
    *last = t + h;
    slave->n++, slave->u--, slave->negative--;
    return fmi3OK;
}
