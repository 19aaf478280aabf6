/* A host of FMI 2.0 with no Python in it: runs an FMU's library for an hour with inputs that vary.

   host_fmi2 LIBRARY GUID STEPS STEP INPUTS OUTPUTS: INPUTS and OUTPUTS are value references, as 3,4,5.
   Input k is amplitude a and start s given as reference:s:a: s + a sin(t / 600 s + k), held over each step.
   Prints the outputs at the end, and the microseconds that a step took. */
#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "fmi2FunctionTypes.h"

static void logger(fmi2ComponentEnvironment env, fmi2String name, fmi2Status status, fmi2String category,
                   fmi2String message, ...)
{
    (void)env;
    fprintf(stderr, "%s: status %d, %s: %s\n", name, status, category, message);
}

static void *library;

static void *find(const char *name)
{
    void *function = dlsym(library, name);
    if (!function) {
        fprintf(stderr, "%s: %s\n", name, dlerror());
        exit(2);
    }
    return function;
}

static void must(fmi2Status status, const char *what)
{
    if (status != fmi2OK) {
        fprintf(stderr, "%s: status %d\n", what, status);
        exit(1);
    }
}

int main(int count, char **arguments)
{
    fmi2CallbackFunctions callbacks = {logger, calloc, free, NULL, NULL};
    fmi2ValueReference inputs[64], outputs[64];
    double start[64], amplitude[64], value[64], result[64];
    size_t input_count = 0, output_count = 0;
    if (count != 7 || !(library = dlopen(arguments[1], RTLD_NOW | RTLD_LOCAL))) {
        fprintf(stderr, "%s\n", count == 7 ? dlerror() : "host_fmi2 LIBRARY GUID STEPS STEP INPUTS OUTPUTS");
        return 2;
    }
    long steps = atol(arguments[3]);
    double step = atof(arguments[4]);
    for (char *word = strtok(arguments[5], ","); word; word = strtok(NULL, ","), input_count++)
        if (sscanf(word, "%u:%lf:%lf", &inputs[input_count], &start[input_count], &amplitude[input_count]) != 3)
            return 2;
    for (char *word = strtok(arguments[6], ","); word; word = strtok(NULL, ","))
        outputs[output_count++] = (fmi2ValueReference)atoi(word);

    fmi2InstantiateTYPE *instantiate = find("fmi2Instantiate");
    fmi2SetupExperimentTYPE *setup = find("fmi2SetupExperiment");
    fmi2EnterInitializationModeTYPE *enter = find("fmi2EnterInitializationMode");
    fmi2ExitInitializationModeTYPE *leave = find("fmi2ExitInitializationMode");
    fmi2SetRealTYPE *set = find("fmi2SetReal");
    fmi2GetRealTYPE *get = find("fmi2GetReal");
    fmi2DoStepTYPE *do_step = find("fmi2DoStep");
    fmi2TerminateTYPE *terminate = find("fmi2Terminate");
    fmi2FreeInstanceTYPE *release = find("fmi2FreeInstance");
    char resources[4096]; /* from the library's path, binaries/PLATFORM/NAME.so inside the FMU */
    int length = (int)strlen(arguments[1]);
    while (length > 1 && arguments[1][length - 1] != '/' && arguments[1][length - 1] != '\\')
        length--;
    snprintf(resources, sizeof resources, "%.*s../../resources/", length, arguments[1]);
    fmi2Component instance = instantiate("host", fmi2CoSimulation, arguments[2], resources, &callbacks, 0, 0);
    if (!instance)
        return 1;
    must(setup(instance, 0, 0, 0, 0, 0), "fmi2SetupExperiment");
    must(enter(instance), "fmi2EnterInitializationMode");
    must(leave(instance), "fmi2ExitInitializationMode");

    struct timespec from, to;
    clock_gettime(CLOCK_MONOTONIC, &from);
    for (long i = 0; i < steps; i++) {
        for (size_t k = 0; k < input_count; k++)
            value[k] = amplitude[k] == 0 ? start[k] : start[k] + amplitude[k] * sin(i * step / 600 + k);
        must(set(instance, inputs, input_count, value), "fmi2SetReal");
        must(do_step(instance, i * step, step, fmi2True), "fmi2DoStep");
        must(get(instance, outputs, output_count, result), "fmi2GetReal");
    }
    clock_gettime(CLOCK_MONOTONIC, &to);
    for (size_t k = 0; k < output_count; k++)
        printf("%.17g\n", result[k]);
    printf("%.6g\n", ((to.tv_sec - from.tv_sec) * 1e6 + (to.tv_nsec - from.tv_nsec) / 1e3) / steps);
    must(terminate(instance), "fmi2Terminate");
    release(instance);
    return 0;
}
