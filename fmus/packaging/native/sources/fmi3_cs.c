/* FMI 3.0 in every step: the step, and real numbers in and out; all else is in fmi3_rest.c and the model's own files. */
#include "fmi3_host.h"
#include "fmi_values.h"
#include "model_values.h"
#include "model_step.h"

static void between(void *to, double time, int finished, double *until)
{
    const Host *host = to;
    fmi3Boolean wanted = fmi3False, early = finished && host->may_return_early;
    fmi3Float64 earlier = time;
    host->update(host->environment, time, !finished, finished, finished, early, &wanted, &earlier);
    if (early && wanted && earlier < *until)
        *until = earlier > time ? earlier : time;
}

fmi3Status fmi3DoStep(fmi3Instance handle, fmi3Float64 time, fmi3Float64 step, fmi3Boolean no_return,
                      fmi3Boolean *event_needed, fmi3Boolean *terminate, fmi3Boolean *early_return,
                      fmi3Float64 *last_time)
{
    (void)no_return;
    Instance *instance = handle;
    double reached = time;
    if (!instance)
        return fmi3Error;
    Outcome outcome = model_step(&instance->model, time, step, instance->host.update ? between : NULL, &reached);
    if (event_needed)
        *event_needed = fmi3False;
    if (terminate)
        *terminate = fmi3False;
    if (early_return)
        *early_return = outcome == DONE && reached < time + step;
    if (last_time)
        *last_time = instance->model.memory.time;
    return status(outcome);
}

GETTER(F(GetReal, GetFloat64), double, REAL, value)
SETTER(F(SetReal, SetFloat64), double, REAL, values[i])
