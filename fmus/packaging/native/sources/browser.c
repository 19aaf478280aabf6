/* A web page around the shared model part: one instance, which runs many steps in one call. */
#include "identity.h"
#include "model.h"

#include <stdlib.h>
#include <string.h>

#define EXPORTED(name) __attribute__((export_name(#name))) name

static Model model;
static char reported[1024];

/* The first fault is the cause of the others. */
static void report(void *host, Severity severity, const char *sentence)
{
    if (severity != WARNING && !*reported)
        strncpy(reported, sentence, sizeof reported - 1);
}

/* What went wrong since the reset; empty where nothing did. */
const char *EXPORTED(fault)(void)
{
    return reported;
}

void EXPORTED(reset)(void)
{
    model.name = WL_NAME;
    model.report = report;
    memset(reported, 0, sizeof reported);
    model_reset(&model);
}

int EXPORTED(set)(unsigned reference, double value)
{
    return model_set(&model, reference, reference < VARIABLES ? WL(variables)[reference].kind : REAL, value);
}

int EXPORTED(initialize)(void)
{
    return model_initialize(&model);
}

/* The values at a communication point, each in its own row of `points` values. */
static void record(const unsigned *references, int count, int points, double *values)
{
    for (int i = 0; i < count; i++)
        model_get(&model, references[i], WL(variables)[references[i]].kind, &values[(size_t)i * (size_t)points]);
}

/* `values` takes a row for each reference, with one value for the start and one for each step. Returns whether all steps
   were done. */
int EXPORTED(run)(int steps, double step, const unsigned *references, int count, double *values)
{
    double reached;
    record(references, count, steps + 1, values);
    for (int i = 0; i < steps; i++) {
        if (model_step(&model, i * step, step, NULL, &reached) != DONE)
            return 0;
        record(references, count, steps + 1, values + i + 1);
    }
    return 1;
}

/* Room for what the page exchanges; the one given before is gone. */
void *EXPORTED(room)(size_t bytes)
{
    static void *given;
    free(given);
    return given = malloc(bytes);
}
