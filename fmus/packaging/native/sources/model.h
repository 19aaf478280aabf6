/* The part of a native FMU that FMI 2.0 and FMI 3.0 share.

   starting.c, running.c, deriving.c and variables.c, generated from the component's declaration, give what is
   declared below under WL(...). What runs in every step is a part of fmi2_cs.c or fmi3_cs.c, so that a compiler sees all at
   once; what does not is in model_life.c and model_sentences.c, and in fmi2_rest.c or fmi3_rest.c. Units call each other
   by WL(...) too. */
#ifndef WARMLINK_MODEL_H
#define WARMLINK_MODEL_H

#include "component.h"

#define WL_JOIN_(a, b) a##b
#define WL_JOIN(a, b) WL_JOIN_(a, b)
#define WL(name) WL_JOIN(WL_PREFIX, name)

#define AT_LEAST_1(n) ((n) > 0 ? (n) : 1)

typedef enum { REAL, INTEGER, BOOLEAN, ENUMERATION } Kind;
enum { HAS_MINIMUM = 1, HAS_MAXIMUM = 2, POSITIVE = 4, ACCEPTS_NAN = 8, TUNABLE = 16 };

typedef struct {
    const char *name;
    const char *unit; /* with a space before it; empty for a pure number */
    double start, minimum, maximum, nominal;
    Kind kind;
    int flags;
    int count;           /* values that go with its reference: of an array all with the first's, else 1 */
    int group, position; /* of an output: which outputs it is computed with, and where among all */
} Variable;

typedef struct {
    const char *name;
    int accepts_nan;
} StateVariable;

/* Of a check across parameters, as a format; and which parameters it shows. */
typedef struct {
    const char *text;
    int shown[8];
} Sentence;

/* What is sampled together: the parameter that says how often, and the states. */
typedef struct {
    int sample_time;
    int first, count;
} Clock;

/* A table that is played: the name and first line of its file, whose component it is (with a point before it, or
   empty), where its handle stands among what is settled, and how many columns it has. */
typedef struct {
    const char *file, *head, *part;
    int settled, columns;
} Played;

/* The rows of a table, where they lie in the bytes of its file. */
typedef struct {
    unsigned char *bytes;
    long long rows;
    int columns;
    const double *times, *values[AT_LEAST_1(WL_MOST_COLUMNS)];
    unsigned char constant[AT_LEAST_1(WL_MOST_COLUMNS)], linear[AT_LEAST_1(WL_MOST_COLUMNS)];
    int ended; /* of which it has been said */
} Table;

/* Generated. Vectors: states x, inputs u, parameters p, parameters and what they settle d. */
extern const Variable WL(variables)[];
extern const StateVariable WL(state_variables)[];
extern const Sentence WL(sentences)[];
extern const double WL(nominals)[]; /* of the states, where hosts may integrate them */
extern const int WL(group_starts)[]; /* among all outputs */
extern const Clock WL(clocks)[]; /* in the order of sampling */
extern const Played WL(played)[];

void WL(settle)(const double *p, double *d);
void WL(margins)(const double *p, double *margins);
void WL(outputs)(int group, const double *x, const double *u, const double *d, const double *time, double *y);
void WL(tangent)(const double *x, const double *u, const double *d, const double *time, const double *dx,
                 const double *du, const double *dtime, double *dy);
#if WL_STATES
void WL(begin)(const double *u, const double *d, const double *time, double *x);
void WL(begin_tangent)(const double *u, const double *d, const double *time, const double *du, const double *dtime,
                       double *dx);
#endif
#if WL_CONTINUOUS
/* The states that have rates, which come first. */
void WL(advance)(const double *x, const double *u, const double *later, const double *d, const double *time,
                 const double *step, double *next);
#endif
#if WL_EXCHANGES
void WL(rates)(const double *x, const double *u, const double *d, const double *time, double *slope);
void WL(rates_tangent)(const double *x, const double *u, const double *d, const double *time, const double *dx,
                       const double *du, const double *dtime, double *dslope);
#endif
#if WL_CLOCKS
/* The states that a clock samples. */
void WL(sample)(int clock, const double *x, const double *u, const double *d, const double *time,
                const double *step, double *next);
#endif

#define FIRST_INPUT WL_PARAMETERS
#define FIRST_OUTPUT (WL_PARAMETERS + WL_INPUTS)
#define FIRST_LOCAL (WL_PARAMETERS + WL_INPUTS + WL_OUTPUTS)
#define VARIABLES (FIRST_LOCAL + WL_LOCALS)
/* Of a reference that is known to be one of them; as an int, since there may be none, and none lies below 0. */
#define IS_PARAMETER(reference) ((int)(reference) < FIRST_INPUT)
#define IS_INPUT(reference) (!IS_PARAMETER(reference) && (int)(reference) < FIRST_OUTPUT)
/* After time, for hosts that integrate: the states and their rates. */
#define FIRST_STATE (VARIABLES + 1)
#define FIRST_RATE (FIRST_STATE + WL_STATES)
#define IS_STATE(reference) (WL_EXCHANGES && (reference) >= FIRST_STATE && (reference) < FIRST_RATE)
#define IS_RATE(reference) (WL_EXCHANGES && (reference) >= FIRST_RATE && (reference) < FIRST_RATE + WL_STATES)

/* UPDATING: within a step, while the host is called back; never in a state that was saved.
   EVENTS, CONTINUOUS: of an instance that its host integrates. */
typedef enum { INSTANTIATED, INITIALIZATION, STEPPING, TERMINATED, UPDATING, EVENTS, CONTINUOUS } Phase;

/* All that an instance remembers; an FMU state is a copy of it. */
typedef struct {
    double parameters[AT_LEAST_1(WL_PARAMETERS)];
    double inputs[AT_LEAST_1(WL_INPUTS)];
    double input_slopes[AT_LEAST_1(WL_INPUTS)];     /* first and second derivative by time, */
    double input_curvatures[AT_LEAST_1(WL_INPUTS)]; /* good for the step to come */
    double states[AT_LEAST_1(WL_STATES)];
    double start_time, stop_time, time; /* s; without a stop time it is infinite */
    double samples[AT_LEAST_1(WL_CLOCKS)];
    double phase;
    double interpolates; /* 1: an input has a derivative for the step to come; 2: that step is done */
} Memory;

typedef enum { WARNING, DISCARD, FAILURE } Severity;
typedef enum { REFUSED, DONE, DISCARDED } Outcome; /* DISCARDED: another step, or other inputs, may do */

typedef struct {
    Memory memory;
    double settled[AT_LEAST_1(WL_SETTLED)];
    double outputs[AT_LEAST_1(WL_OUTPUTS + WL_LOCALS)]; /* group after group */
    unsigned long long fresh; /* a bit for each group of outputs that is up to date */
    int begun;                /* before the run: whether `settled` and the states follow the parameters */
    unsigned char clamped[AT_LEAST_1(WL_INPUTS)]; /* of which it has been said */
    Severity severity;                            /* of what is reported next */
    int exchanges;                                /* the host integrates */
    Table tables[AT_LEAST_1(WL_TABLES)];
    const char *name;
    void *host;
} Model;

/* A direction in the space of states, inputs and time, and the derivatives along it once they are computed. */
typedef struct {
    double states[AT_LEAST_1(WL_STATES)], inputs[AT_LEAST_1(WL_INPUTS)], time;
    double outputs[AT_LEAST_1(WL_OUTPUTS)], rates[AT_LEAST_1(WL_STATES)];
    int computed;
} Direction;

/* Called within a step, before a micro step to `time` and after it; the host may bring `*until` forward. */
typedef void (*Between)(void *host, double time, int finished, double *until);

/* What returns an int tells whether it succeeded; if not, a sentence has been reported and nothing has changed. */

/* Tells the host a sentence, in the way of the standard that is spoken. */
#define report WL(report)
void report(void *host, Severity severity, const char *sentence);

/* model_sentences.c and model_life.c */
#define model_report WL(model_report)
#define model_refuse WL(model_refuse)
#define model_mend WL(model_mend)
#define model_tell_ends WL(model_tell_ends)
#define model_reset WL(model_reset)
#define model_begin WL(model_begin)
#define model_initialize WL(model_initialize)
#define model_tune WL(model_tune)
#define model_set_derivative WL(model_set_derivative)
#define model_output_derivative WL(model_output_derivative)
#define model_seed WL(model_seed)
#define model_sensitivity WL(model_sensitivity)
#define parameters_are_well WL(parameters_are_well)
int model_report(Model *model, const char *format, ...);
int model_refuse(Model *model, unsigned reference, Kind kind);
int model_mend(Model *model, int input, double *value);
void model_tell_ends(Model *model);
void model_reset(Model *model);
void model_begin(Model *model);
int model_initialize(Model *model);
int model_tune(Model *model, unsigned reference, double value);
int model_set_derivative(Model *model, unsigned reference, int order, double value);
int model_output_derivative(Model *model, unsigned reference, int order, double *value);
int model_seed(Model *model, unsigned reference, double seed, Direction *direction);
int model_sensitivity(Model *model, unsigned reference, Direction *direction, double *value);
int parameters_are_well(Model *model, const double *p);

/* model_values.h, in the unit that steps */
#define model_set WL(model_set)
#define model_get WL(model_get)
#define model_rates WL(model_rates)
#define model_set_states WL(model_set_states)
int model_set(Model *model, unsigned reference, Kind kind, double value);
int model_get(Model *model, unsigned reference, Kind kind, double *value);
Outcome model_rates(Model *model, double *rates);
Outcome model_set_states(Model *model, const double *states);

#endif
