/* Values that move an FMU's inputs from step to step, within their limits; readings are missing now and then. */
#include <math.h>

#include "model.h"

static double moved_real(int input, int index)
{
    const Variable *variable = &WL(variables)[input];
    double value = variable->start + 0.37 * ((index * 5 + input * 3) % 7);
    if ((variable->flags & HAS_MAXIMUM) && value > variable->maximum)
        value = variable->maximum;
    return (variable->flags & ACCEPTS_NAN) && index % 5 == 4 ? NAN : value;
}

static int moved_whole(int input, int index)
{
    const Variable *variable = &WL(variables)[input];
    int whole = (variable->flags & HAS_MAXIMUM) ? index % (1 + (int)variable->maximum) : index % 3;
    return (variable->flags & HAS_MINIMUM) && whole < variable->minimum ? (int)variable->minimum : whole;
}
