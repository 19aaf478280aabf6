/* The host of an FMU of FMI 3.0; a part of fmi3_cs.c and of fmi3_rest.c. */
/* The standard's header declares two callbacks by (). */
#ifdef __GNUC__
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wstrict-prototypes"
#endif
#include "fmi3Functions.h"
#ifdef __GNUC__
#pragma GCC diagnostic pop
#endif

typedef struct {
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
    const char *name;
    fmi3IntermediateUpdateCallback update;
    bool may_return_early;
} Host;

#define F(two, three) three
#define SIZED(values, size) values, size_t size
#include "fmi_answers.h"
