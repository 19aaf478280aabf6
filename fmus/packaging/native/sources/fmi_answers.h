/* What FMI 2.0 and FMI 3.0 have alike; a part of fmi2_host.h and of fmi3_host.h.

   F(a, b) is a in FMI 2.0 and b in 3.0; Host is that of the file around. */
#include "identity.h"
#include "model.h"
#include "model_checks.h"

#define FUNCTION(name) WL_JOIN(F(fmi2, fmi3), name)
typedef FUNCTION(Status) Answer;
typedef FUNCTION(Boolean) Truth;
typedef FUNCTION(Byte) Byte;
typedef FUNCTION(ValueReference) Reference;
typedef FUNCTION(F(FMUstate, FMUState)) State;
typedef FUNCTION(F(Integer, Int32)) Whole;

typedef struct {
    Model model;
    Host host;
} Instance;

static inline Answer status(int well)
{
    return well == DISCARDED ? FUNCTION(Discard) : well ? FUNCTION(OK) : FUNCTION(Error);
}

/* Whether the host gave the arrays that so many values need; either may be NULL where there are none. */
static inline int given(Instance *instance, size_t count, const void *first, const void *second)
{
    return count == 0 || (first && second)
           || model_report(&instance->model, ": a null pointer in place of an array; give arrays of %lu elements",
                           (unsigned long)count);
}
