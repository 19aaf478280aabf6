/* A slave of FMI 3.0 that gives, after a step, its bytes backwards and its text twice. */
#include "fmi3Functions.h"
#include <stdlib.h>
#include <string.h>

enum { BYTES, BACKWARDS, TEXT, TWICE, WORDS };
typedef struct { unsigned char bytes[2][64]; size_t sizes[2]; char texts[2][64]; } Slave;

fmi3Status fmi3SetDebugLogging(fmi3Instance i, fmi3Boolean on, size_t n, const fmi3String c[]) { return 0; }
fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String path, fmi3Boolean visible,
    fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early, const fmi3ValueReference required[], size_t n,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update)
{
    return calloc(1, sizeof(Slave));
}
void fmi3FreeInstance(fmi3Instance i) { free(i); }
fmi3Status fmi3EnterInitializationMode(fmi3Instance i, fmi3Boolean d, double tolerance, double t, fmi3Boolean s, double e) { return 0; }
fmi3Status fmi3ExitInitializationMode(fmi3Instance i) { return 0; }
fmi3Status fmi3Terminate(fmi3Instance i) { return 0; }
fmi3Status fmi3GetBinary(fmi3Instance i, const fmi3ValueReference v[], size_t n, size_t sizes[], fmi3Binary x[], size_t m)
{
    for (size_t k = 0; k < n; k++)
        x[k] = ((Slave *)i)->bytes[v[k]], sizes[k] = ((Slave *)i)->sizes[v[k]];
    return 0;
}
fmi3Status fmi3SetBinary(fmi3Instance i, const fmi3ValueReference v[], size_t n, const size_t sizes[], const fmi3Binary x[], size_t m)
{
    for (size_t k = 0; k < n; k++)
        memcpy(((Slave *)i)->bytes[v[k]], x[k], ((Slave *)i)->sizes[v[k]] = sizes[k]);
    return 0;
}
fmi3Status fmi3GetString(fmi3Instance i, const fmi3ValueReference v[], size_t n, fmi3String x[], size_t m)
{
    for (size_t k = 0; k < n; k++)
        x[k] = ((Slave *)i)->texts[v[k] - TEXT];
    return 0;
}
fmi3Status fmi3SetString(fmi3Instance i, const fmi3ValueReference v[], size_t n, const fmi3String x[], size_t m)
{
    for (size_t k = 0; k < n; k++)
        strcpy(((Slave *)i)->texts[v[k] - TEXT], x[k]);
    return 0;
}
fmi3Status fmi3GetInt64(fmi3Instance i, const fmi3ValueReference v[], size_t n, fmi3Int64 x[], size_t m)
{
    Slave *s = i;
    return x[0] = 1000 * (long long)s->sizes[1] + s->bytes[1][0] + 100000 * (long long)strlen(s->texts[1]), 0;
}
fmi3Status fmi3DoStep(fmi3Instance i, double t, double h, fmi3Boolean forward, fmi3Boolean *event, fmi3Boolean *terminate,
                      fmi3Boolean *early, double *last)
{
    Slave *s = i;
    s->sizes[1] = s->sizes[0];
    for (size_t k = 0; k < s->sizes[0]; k++)
        s->bytes[1][k] = s->bytes[0][s->sizes[0] - 1 - k];
    strcat(strcpy(s->texts[1], s->texts[0]), s->texts[0]);
    return *event = *terminate = *early = 0, *last = t + h, 0;
}
