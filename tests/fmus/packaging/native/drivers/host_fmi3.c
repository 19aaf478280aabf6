/* A host of FMI 3.0 with no Python in it: runs an FMU's library with inputs that vary.

   host_fmi3 LIBRARY TOKEN STEPS STEP INPUTS OUTPUTS: INPUTS and OUTPUTS are value references, as 3,4,5.
   Input k is given as reference:s:a: s + a sin(t / 600 s + k), held over each step.
   Prints the outputs at the end, and the microseconds that a step took. */
#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "fmi3FunctionTypes.h"

static void logger(fmi3InstanceEnvironment env, fmi3Status status, fmi3String category, fmi3String message)
{
    (void)env;
    fprintf(stderr, "status %d, %s: %s\n", status, category, message);
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

static void must(fmi3Status status, const char *what)
{
    if (status != fmi3OK) {
        fprintf(stderr, "%s: status %d\n", what, status);
        exit(1);
    }
}

int main(int count, char **arguments)
{
    fmi3ValueReference inputs[64], outputs[64];
    double start[64], amplitude[64], value[64], result[64], reached;
    size_t input_count = 0, output_count = 0;
    fmi3Boolean event, end, early;
    if (count != 7 || !(library = dlopen(arguments[1], RTLD_NOW | RTLD_LOCAL))) {
        fprintf(stderr, "%s\n", count == 7 ? dlerror() : "host_fmi3 LIBRARY TOKEN STEPS STEP INPUTS OUTPUTS");
        return 2;
    }
    long steps = atol(arguments[3]);
    double step = atof(arguments[4]);
    for (char *word = strtok(arguments[5], ","); word; word = strtok(NULL, ","), input_count++)
        if (sscanf(word, "%u:%lf:%lf", &inputs[input_count], &start[input_count], &amplitude[input_count]) != 3)
            return 2;
    for (char *word = strtok(arguments[6], ","); word; word = strtok(NULL, ","))
        outputs[output_count++] = (fmi3ValueReference)atoi(word);

    fmi3InstantiateCoSimulationTYPE *instantiate = find("fmi3InstantiateCoSimulation");
    fmi3EnterInitializationModeTYPE *enter = find("fmi3EnterInitializationMode");
    fmi3ExitInitializationModeTYPE *leave = find("fmi3ExitInitializationMode");
    fmi3SetFloat64TYPE *set = find("fmi3SetFloat64");
    fmi3GetFloat64TYPE *get = find("fmi3GetFloat64");
    fmi3DoStepTYPE *do_step = find("fmi3DoStep");
    fmi3TerminateTYPE *terminate = find("fmi3Terminate");
    fmi3FreeInstanceTYPE *release = find("fmi3FreeInstance");
    char resources[4096]; /* from the library's path, binaries/PLATFORM/NAME.so inside the FMU */
    int length = (int)strlen(arguments[1]);
    while (length > 1 && arguments[1][length - 1] != '/' && arguments[1][length - 1] != '\\')
        length--;
    snprintf(resources, sizeof resources, "%.*s../../resources/", length, arguments[1]);
    fmi3Instance instance = instantiate("host", arguments[2], resources, 0, 0, 0, 0, NULL, 0, NULL, logger, NULL);
    if (!instance)
        return 1;
    must(enter(instance, 0, 0, 0, 0, 0), "fmi3EnterInitializationMode");
    must(leave(instance), "fmi3ExitInitializationMode");

    struct timespec from, to;
    clock_gettime(CLOCK_MONOTONIC, &from);
    for (long i = 0; i < steps; i++) {
        for (size_t k = 0; k < input_count; k++)
            value[k] = amplitude[k] == 0 ? start[k] : start[k] + amplitude[k] * sin(i * step / 600 + k);
        must(set(instance, inputs, input_count, value, input_count), "fmi3SetFloat64");
        must(do_step(instance, i * step, step, 1, &event, &end, &early, &reached), "fmi3DoStep");
        must(get(instance, outputs, output_count, result, output_count), "fmi3GetFloat64");
    }
    clock_gettime(CLOCK_MONOTONIC, &to);
    for (size_t k = 0; k < output_count; k++)
        printf("%.17g\n", result[k]);
    printf("%.6g\n", ((to.tv_sec - from.tv_sec) * 1e6 + (to.tv_nsec - from.tv_nsec) / 1e3) / steps);
    must(terminate(instance), "fmi3Terminate");
    release(instance);
    return 0;
}
