/* The host of an FMU of FMI 2.0; a part of fmi2_cs.c and of fmi2_rest.c. */
#include "fmi2Functions.h"

typedef struct {
    fmi2CallbackFunctions callbacks;
    const char *name;
} Host;

#define F(two, three) two
#define SIZED(values, size) values
#include "fmi_answers.h"
