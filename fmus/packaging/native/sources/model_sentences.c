/* The sentences for what is wrong with values and parameters; nothing here runs in a sound step. */
#include "model_fault.h"
#include "model_table.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

/* Share of its nominal value by which an input may miss a bound, as sums and means of hosts do. */
#define BOUND_TOLERANCE 1e-9

#define SENTENCE_SIZE 512

/* Tells the host, and returns 0. */
int model_report(Model *model, const char *format, ...)
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

/* Says why there is no variable of a kind. */
int model_refuse(Model *model, unsigned reference, Kind kind)
{
    static const char *const kinds[] = {"a real number", "an integer", "a boolean", "an enumeration"};
    if (reference >= VARIABLES)
        return model_report(model, ": value reference %u is unknown; " WL_NAME " has 0 to %d", reference, VARIABLES - 1);
    const Variable *found = &WL(variables)[reference];
    return model_report(model, ".%s: is %s, not %s", found->name, kinds[found->kind], kinds[kind]);
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

int parameters_are_well(Model *model, const double *p)
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

int model_mend(Model *model, int input, double *value)
{
    clamp(model, input, value);
    return within(model, &WL(variables)[FIRST_INPUT + input], *value);
}

void model_tell_ends(Model *model)
{
    for (int i = 0; i < WL_TABLES; i++) {
        Table *table = &model->tables[i];
        double end = table->rows > 1 ? table->times[table->rows - 1] : HUGE_VAL; /* one row is for ever */
        if (table->ended || !(model->memory.time > end + EARLY))
            continue;
        Severity before = model->severity;
        model->severity = WARNING;
        model_report(model, "%s: its table ends at %g s; the last row holds from then on", WL(played)[i].part, end);
        model->severity = before;
        table->ended = 1;
    }
}
