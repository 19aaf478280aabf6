/* A web page around the shared model part: one instance. */
#include "identity.h"
#include "model.h"
#include "model_checks.h"
#include "model_values.h"
#include "model_step.h"
#include <stdlib.h>

#define EXPORTED(name) __attribute__((export_name(#name))) exported_##name

static Model model;
static char reported[1024];

/* The first fault is the cause of the others. */
void report(void *host, Severity severity, const char *sentence)
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
    memset(reported, 0, sizeof reported);
    model_reset(&model);
}

#if WL_TABLES
#include "model_rows.h"

/* Room for so many bytes of a table's file; what was there before is gone. */
unsigned char *EXPORTED(room)(int table, unsigned size)
{
    free(model.tables[table].bytes);
    memset(&model.tables[table], 0, sizeof model.tables[table]);
    return model.tables[table].bytes = malloc(size);
}

/* What is wrong with the bytes that were put there; empty where all is well. */
const char *EXPORTED(take)(int table, unsigned size)
{
    const char *problem = table_taken(&model.tables[table], &WL(played)[table], model.tables[table].bytes, size);
    return problem ? problem : "";
}
#endif

int EXPORTED(set)(unsigned reference, double value)
{
    return model_set(&model, reference, reference < VARIABLES ? WL(variables)[reference].kind : REAL, value);
}

int EXPORTED(initialize)(void)
{
    return model_initialize(&model);
}

double EXPORTED(get)(unsigned reference)
{
    double value;
    model_get(&model, reference, WL(variables)[reference].kind, &value);
    return value;
}

int EXPORTED(step)(double time, double size)
{
    double reached;
    return model_step(&model, time, size, NULL, &reached) == DONE;
}
