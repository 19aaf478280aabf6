/* A slave of FMI 3.0 whose variables are arrays: y = gain u, as it stands after a step. The rows of y and gain are
 * a structural parameter, 3 at first and at most. */
#include "fmi3Functions.h"
#include <stdlib.h>
#include <string.h>

enum { U, GAIN, Y, VARIABLES };
static const size_t places[] = {0, 3, 12};
typedef struct { double values[15]; size_t rows; int configuring; } Slave;
static size_t size_of(const Slave *s, unsigned v) { return v == U ? 3 : v == GAIN ? 3 * s->rows : s->rows; }

const char *fmi3GetVersion(void) { return "3.0"; }
fmi3Status fmi3SetDebugLogging(fmi3Instance i, fmi3Boolean on, size_t n, const fmi3String c[])
{
    return n ? fmi3Error : fmi3OK; /* no category is declared but its own */
}
fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String path, fmi3Boolean visible,
    fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early, const fmi3ValueReference required[], size_t n,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update)
{
    Slave *slave = calloc(1, sizeof *slave);
    for (int i = 0; slave && i < 3; i++)
        slave->values[i] = i + 1, slave->values[3 + 4 * i] = 1;
    slave->rows = 3;
    return slave;
}
void fmi3FreeInstance(fmi3Instance i) { free(i); }
fmi3Status fmi3EnterInitializationMode(fmi3Instance i, fmi3Boolean a, double b, double c, fmi3Boolean d, double e) { return fmi3OK; }
fmi3Status fmi3ExitInitializationMode(fmi3Instance i) { return fmi3OK; }
fmi3Status fmi3Terminate(fmi3Instance i) { return fmi3OK; }

/* All elements of each array, and no more: what else is asked for is an error. */
static fmi3Status exchange(Slave *slave, const fmi3ValueReference v[], size_t n, double *out, const double *in, size_t m)
{
    size_t taken = 0;
    for (size_t k = 0; k < n; taken += size_of(slave, v[k++])) {
        if (v[k] >= VARIABLES || taken + size_of(slave, v[k]) > m || (in && v[k] == Y))
            return fmi3Error;
        double *own = slave->values + places[v[k]];
        memcpy(out ? out + taken : own, out ? own : in + taken, size_of(slave, v[k]) * sizeof *own);
    }
    return taken == m ? fmi3OK : fmi3Error;
}
fmi3Status fmi3GetFloat64(fmi3Instance i, const fmi3ValueReference v[], size_t n, double x[], size_t m)
{
    return exchange(i, v, n, x, NULL, m);
}
fmi3Status fmi3SetFloat64(fmi3Instance i, const fmi3ValueReference v[], size_t n, const double x[], size_t m)
{
    return exchange(i, v, n, NULL, x, m);
}
fmi3Status fmi3DoStep(fmi3Instance i, double t, double h, fmi3Boolean keep, fmi3Boolean *event, fmi3Boolean *terminate,
                      fmi3Boolean *early, double *last)
{
    double *u = ((Slave *)i)->values, *gain = u + places[GAIN], *y = u + places[Y];
    *event = *terminate = *early = 0;
    *last = t + h;
    for (size_t r = 0; r < ((Slave *)i)->rows; r++)
        y[r] = gain[3 * r] * u[0] + gain[3 * r + 1] * u[1] + gain[3 * r + 2] * u[2];
    return fmi3OK;
}
fmi3Status fmi3EnterConfigurationMode(fmi3Instance i) { return ((Slave *)i)->configuring = 1, fmi3OK; }
fmi3Status fmi3ExitConfigurationMode(fmi3Instance i) { return ((Slave *)i)->configuring = 0, fmi3OK; }
fmi3Status fmi3SetUInt64(fmi3Instance i, const fmi3ValueReference v[], size_t n, const fmi3UInt64 x[], size_t m)
{
    return ((Slave *)i)->configuring && x[0] <= 3 ? ((Slave *)i)->rows = x[0], fmi3OK : fmi3Error;
}
