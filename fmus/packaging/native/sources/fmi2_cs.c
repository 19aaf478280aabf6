/* FMI 2.0 in every step: the step, and real numbers in and out; all else is in fmi2_rest.c and the model's own files. */
#include "fmi2_host.h"
#include "fmi_values.h"
#include "model_values.h"
#include "model_step.h"

fmi2Status fmi2DoStep(fmi2Component component, fmi2Real time, fmi2Real step, fmi2Boolean no_return)
{
    (void)no_return;
    Instance *instance = component;
    double reached;
    return instance ? status(model_step(&instance->model, time, step, NULL, &reached)) : fmi2Error;
}

GETTER(F(GetReal, GetFloat64), double, REAL, value)
SETTER(F(SetReal, SetFloat64), double, REAL, values[i])
