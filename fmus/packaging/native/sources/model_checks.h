/* What may be wrong with values, and the sentence for it; a part of model_instance.h. */

/* Share of its nominal value by which an input may miss a bound, as sums and means of hosts do. */
#define BOUND_TOLERANCE 1e-9

#define SENTENCE_SIZE 512

/* Tells the host, and returns 0. */
static int model_report(Model *model, const char *format, ...)
{
    char sentence[SENTENCE_SIZE];
    int used = snprintf(sentence, sizeof sentence, "%s", model->name);
    va_list arguments;
    va_start(arguments, format);
    if (used >= 0 && (size_t)used < sizeof sentence)
        vsnprintf(sentence + used, sizeof sentence - (size_t)used, format, arguments);
    va_end(arguments);
    report(model->host, model->severity, sentence);
    return 0;
}

/* What is wrong with one value, with %s for bound and unit; NULL where it is well. */
static const char *fault(const Variable *variable, double value, double *bound)
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

/* A number with six digits, or as many more as tell it from every other. */
static const char *shown(double value, char *text)
{
    for (int digits = 6; digits <= 17; digits++) {
        snprintf(text, 40, "%.*g", digits, value);
        if (strtod(text, NULL) == value)
            break;
    }
    return isnan(value) ? "nan" : text;
}

/* Whether a value lies within its variable's range; if not, the reason is reported. */
static int within(Model *model, const Variable *variable, double value)
{
    double bound = 0;
    const char *what = fault(variable, value, &bound);
    char reason[SENTENCE_SIZE], number[40], limit[40];
    if (!what)
        return 1;
    snprintf(reason, sizeof reason, what, shown(bound, limit), variable->unit);
    return model_report(model, ".%s: %s%s%s", variable->name, shown(value, number), variable->unit, reason);
}

static int parameters_are_well(Model *model, const double *p)
{
    int well = 1;
    double margins[AT_LEAST_1(WL_CHECKS)];
    for (int i = 0; i < WL_PARAMETERS; i++)
        well &= within(model, &WL(variables)[i], p[i]);
    if (!well)
        return 0;
    WL(margins)(p, margins);
    for (int i = 0; i < WL_CHECKS; i++) {
        const char *text = WL(sentences)[i].text;
        const int *at = WL(sentences)[i].shown;
        if (!(margins[i] >= 0))
            well = model_report(model, text, p[at[0]], p[at[1]], p[at[2]], p[at[3]], p[at[4]], p[at[5]], p[at[6]],
                                p[at[7]]);
    }
    return well;
}

/* Takes an input to its bound where it misses it by a rounding error only, and says so once. */
static void clamp(Model *model, int input, double *value)
{
    const Variable *variable = &WL(variables)[FIRST_INPUT + input];
    double low = variable->flags & HAS_MINIMUM ? variable->minimum : -HUGE_VAL;
    double high = variable->flags & HAS_MAXIMUM ? variable->maximum : HUGE_VAL;
    double bound = *value < low ? low : *value > high ? high : *value;
    char number[40], limit[40];
    if (*value == bound || !(fabs(*value - bound) <= BOUND_TOLERANCE * variable->nominal))
        return;
    if (!model->clamped[input]) {
        Severity before = model->severity;
        model->severity = WARNING;
        model_report(model, ".%s: %s%s is taken for %s%s, here and from now on", variable->name,
                     shown(*value, number), variable->unit, shown(bound, limit), variable->unit);
        model->severity = before;
        model->clamped[input] = 1;
    }
    *value = bound;
}

static int inputs_are_well(Model *model, double *inputs)
{
    int well = 1;
    for (int i = 0; i < WL_INPUTS; i++) {
        const Variable *variable = &WL(variables)[FIRST_INPUT + i];
        double bound;
        if (fault(variable, inputs[i], &bound)) {
            clamp(model, i, &inputs[i]);
            well &= within(model, variable, inputs[i]);
        }
    }
    return well;
}

/* The first state that is not finite, and NaN where it may not be; -1 where all are well. */
static int wild_state(const double *states)
{
    double a = 0, b = 0, c = 0, d = 0; /* a finite number less itself is 0; in fours, for the processor's sake */
    int i = 0;
    for (const double *x = states; i + 4 <= WL_STATES; i += 4, x += 4) {
        a += x[0] - x[0];
        b += x[1] - x[1];
        c += x[2] - x[2];
        d += x[3] - x[3];
    }
    for (i = (a + b) + (c + d) == 0 ? i : 0; i < WL_STATES; i++)
        if (!(fabs(states[i]) < HUGE_VAL) && !(isnan(states[i]) && WL(state_variables)[i].accepts_nan))
            return i;
    return -1;
}

static int states_are_well(Model *model, double since)
{
    int wild = wild_state(model->memory.states);
    return wild < 0 || model_report(model, ": %s is not finite after %g s; look for inputs and parameters far from "
                                           "their nominal values", WL(state_variables)[wild].name, since);
}
