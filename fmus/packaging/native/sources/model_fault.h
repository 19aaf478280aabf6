/* What is wrong with one value by itself. */
#ifndef WARMLINK_MODEL_FAULT_H
#define WARMLINK_MODEL_FAULT_H

#include "model.h"

#include <math.h>
#include <stddef.h>

/* What is wrong with one value, with %s for bound and unit; NULL where it is well. */
static inline const char *fault(const Variable *variable, double value, double *bound)
{
    if (isnan(value))
        return variable->flags & ACCEPTS_NAN ? NULL : " is not a number; give a value";
    if (isinf(value))
        return " is not finite; give a finite value";
    *bound = 0;
    if ((variable->flags & POSITIVE) && value <= 0)
        return " is not positive; give a value above %s%s";
    *bound = variable->minimum;
    if ((variable->flags & HAS_MINIMUM) && value < variable->minimum)
        return " is too low; give at least %s%s";
    *bound = variable->maximum;
    if ((variable->flags & HAS_MAXIMUM) && value > variable->maximum)
        return " is too high; give at most %s%s";
    if (variable->kind != REAL && value != nearbyint(value))
        return " is not a whole number; give one";
    return NULL;
}

#endif
