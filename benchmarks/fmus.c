/* Times an FMU's step: through FMI 2.0 as a host calls it, and the generated step alone in a loop.

   bench_fmus LIBRARY GUID STEPS STEP: prints both in microseconds. Compiled together with the FMU's
   sources, of which the second figure uses the generated functions directly. */
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "fmi2FunctionTypes.h"
#include "model.h"

static void logger(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                   fmi2String message, ...)
{
    (void)environment, (void)status, (void)category;
    fprintf(stderr, "%s: %s\n", name, message);
}

static double now(void)
{
    struct timespec clock;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &clock);
    return clock.tv_sec * 1e6 + clock.tv_nsec / 1e3;
}

/* Microseconds a step: inputs set, step, first output got. */
static double through_fmi(const char *path, const char *guid, long steps, double step)
{
    void *library = dlopen(path, RTLD_NOW);
    if (!library) {
        fprintf(stderr, "%s\n", dlerror());
        exit(1);
    }
    fmi2InstantiateTYPE *instantiate = dlsym(library, "fmi2Instantiate");
    fmi2SetupExperimentTYPE *setup = dlsym(library, "fmi2SetupExperiment");
    fmi2EnterInitializationModeTYPE *enter = dlsym(library, "fmi2EnterInitializationMode");
    fmi2ExitInitializationModeTYPE *leave = dlsym(library, "fmi2ExitInitializationMode");
    fmi2DoStepTYPE *do_step = dlsym(library, "fmi2DoStep");
    fmi2SetRealTYPE *set = dlsym(library, "fmi2SetReal");
    fmi2GetRealTYPE *get = dlsym(library, "fmi2GetReal");

    fmi2CallbackFunctions callbacks = {logger, calloc, free, NULL, NULL};
    fmi2Component instance = instantiate("bench", fmi2CoSimulation, guid, "", &callbacks, 0, 0);
    fmi2ValueReference inputs[AT_LEAST_1(WL_INPUTS)], output = FIRST_OUTPUT;
    double values[AT_LEAST_1(WL_INPUTS)], result;
    size_t count = 0;
    for (unsigned i = FIRST_INPUT; i < FIRST_OUTPUT; i++)
        if (WL(variables)[i].kind == REAL) {
            values[count] = WL(variables)[i].start;
            inputs[count++] = i;
        }
    fmi2Status status = fmi2OK;
    if (!instance || setup(instance, 0, 0, 0, 0, 0) || enter(instance) || leave(instance))
        exit(1);
    double from = now();
    for (long i = 0; i < steps; i++) {
        status |= set(instance, inputs, count, values);
        status |= do_step(instance, i * step, step, 1);
        status |= get(instance, &output, 1, &result);
    }
    double spent = (now() - from) / steps;
    if (status != fmi2OK)
        exit(1);
    return spent;
}

/* Microseconds a step of the generated function, without anything around it. */
static double alone(long steps, double step)
{
#if WL_STATES
    static double p[AT_LEAST_1(WL_PARAMETERS)], u[AT_LEAST_1(WL_INPUTS)], d[AT_LEAST_1(WL_SETTLED)];
    static double x[2][WL_STATES];
    for (int i = 0; i < WL_PARAMETERS; i++)
        p[i] = WL(variables)[i].start;
    for (int i = 0; i < WL_INPUTS; i++)
        u[i] = WL(variables)[FIRST_INPUT + i].start;
    WL(settle)(p, d);
    WL(begin)(u, d, &(double){0}, x[0]);
    double from = now();
    for (long i = 0; i < steps; i++) {
        double time = i * step;
        double *now = x[i % 2], *next = x[1 - i % 2];
#if WL_CONTINUOUS
        WL(advance)(now, u, u, d, &time, &step, next);
#endif
#if WL_CLOCKS
        for (int clock = 0; clock < WL_CLOCKS; clock++)
            WL(sample)(clock, now, u, d, &time, &step, next + WL(clocks)[clock].first);
#endif
    }
    return (now() - from) / steps;
#else
    (void)steps, (void)step;
    return 0;
#endif
}

int main(int count, char **arguments)
{
    if (count != 5)
        return 2;
    long steps = atol(arguments[3]);
    double step = atof(arguments[4]), fmi = 1e300, bare = 1e300;
    for (int repeat = 0; repeat < 7; repeat++) {
        double each = through_fmi(arguments[1], arguments[2], steps, step), loop = alone(steps, step);
        fmi = each < fmi ? each : fmi;
        bare = loop < bare ? loop : bare;
    }
    printf("%.6f %.6f\n", fmi, bare);
    return 0;
}
