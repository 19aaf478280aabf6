/* Steps an instance of FMI 3.0 and has its rates integrated, and prints how often memory was asked for meanwhile.

   Linked with --wrap, so that each request of the FMU comes by here. */
#include "fmi3Functions.h"
#include "identity.h"
#include "model.h"

#include <stdio.h>

static long requests;

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *memory, size_t size);

void *__wrap_malloc(size_t size)
{
    requests++;
    return __real_malloc(size);
}

void *__wrap_calloc(size_t count, size_t size)
{
    requests++;
    return __real_calloc(count, size);
}

void *__wrap_realloc(void *memory, size_t size)
{
    requests++;
    return __real_realloc(memory, size);
}

static void values(fmi3Instance instance, double value)
{
    for (fmi3ValueReference i = 0; i < VARIABLES; i++)
        if (WL(variables)[i].kind == REAL) {
            double one = WL(variables)[i].start, seed = 1, slope;
            fmi3ValueReference by = FIRST_INPUT + (i - FIRST_OUTPUT) % AT_LEAST_1(WL_INPUTS);
            if (i >= FIRST_INPUT && i < FIRST_OUTPUT)
                one += value;
            if (i < FIRST_OUTPUT)
                fmi3SetFloat64(instance, &i, 1, &one, 1);
            fmi3GetFloat64(instance, &i, 1, &one, 1);
            if (i >= FIRST_OUTPUT)
                fmi3GetDirectionalDerivative(instance, &i, 1, &by, 1, &seed, 1, &slope, 1);
        }
}

int main(void)
{
    fmi3Instance stepped = fmi3InstantiateCoSimulation("stepped", WL_TOKEN, RESOURCES, false, false, false, false, NULL, 0,
                                                       NULL, NULL, NULL);
    fmi3Instance integrated = fmi3InstantiateModelExchange("integrated", WL_TOKEN, RESOURCES, false, false, NULL, NULL);
    double states[AT_LEAST_1(WL_STATES)], rates[AT_LEAST_1(WL_STATES)], reached;
    bool event, end, early;
    long before, steps = 0;
    fmi3EnterInitializationMode(stepped, false, 0, 0, false, 0);
    fmi3ExitInitializationMode(stepped);
    if (integrated) {
        fmi3EnterInitializationMode(integrated, false, 0, 0, false, 0);
        fmi3ExitInitializationMode(integrated);
        fmi3EnterContinuousTimeMode(integrated);
    }
    before = requests;
    for (int i = 0; i < 100; i++) {
        values(stepped, i / 1e4);
        steps += fmi3DoStep(stepped, i, 1, false, &event, &end, &early, &reached) == fmi3OK;
        if (!integrated)
            continue;
        fmi3SetTime(integrated, i);
        fmi3GetContinuousStates(integrated, states, WL_STATES);
        fmi3GetContinuousStateDerivatives(integrated, rates, WL_STATES);
        for (int k = 0; k < WL_STATES; k++)
            states[k] += 1e-3 * rates[k];
        fmi3SetContinuousStates(integrated, states, WL_STATES);
        values(integrated, i / 1e4);
    }
    printf("%ld steps, %ld requests, %ld before\n", steps, requests - before, before);
    fmi3FreeInstance(stepped);
    fmi3FreeInstance(integrated);
    return 0;
}
