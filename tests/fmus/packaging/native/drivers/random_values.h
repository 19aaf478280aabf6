/* Values and derivatives, right and wrong; a part of random_calls.c. */

#include <limits.h>
#include <stdint.h>

#if FMI == 2
#define ARRAY(values, count) values
#else
#define ARRAY(values, count) values, count
#endif

static int whole(double value)
{
    return value > -2e9 && value < 2e9 ? (int)value : INT_MAX;
}

static void values(int set)
{
    size_t count = some_count(), given = FMI == 3 && one_in(30) ? some_count() : count;
    Reference *references = array(count * sizeof *references);
    double *reals = array(given * sizeof *reals);
    int *integers = array(given * sizeof *integers);
    int64_t *wide = array(given * sizeof *wide);
    Truth *truths = array(given * sizeof *truths);
    unsigned type = draw(FMI + 1);
    for (size_t i = 0; i < count && references; i++) {
        references[i] = some_reference();
        if (references[i] < VARIABLES && !one_in(10))
            type = count == 1 ? (unsigned)WL(variables)[references[i]].kind : type;
    }
    for (size_t i = 0; i < given; i++) {
        double value = value_for(references && i < count ? references[i] : 0);
        if (reals)
            reals[i] = value;
        if (integers)
            integers[i] = whole(value);
        if (wide)
            wide[i] = whole(value);
        if (truths)
            truths[i] = draw(2);
    }
    int there = given == count && (count == 0 || references);
    (void)given;
    if (FMI == 2 && type == ENUMERATION)
        type = INTEGER;
#if FMI == 3
    if (type == ENUMERATION)
        CALL(there && (count == 0 || wide), set ? fmi3SetInt64(driven, references, count, wide, given)
                                                : fmi3GetInt64(driven, references, count, wide, given));
    else
#endif
    if (type == 0)
        CALL(there && (count == 0 || reals),
             set ? F(SetReal, SetFloat64)(driven, references, count, ARRAY(reals, given))
                 : F(GetReal, GetFloat64)(driven, references, count, ARRAY(reals, given)));
    else if (type == 1)
        CALL(there && (count == 0 || integers),
             set ? F(SetInteger, SetInt32)(driven, references, count, ARRAY(integers, given))
                 : F(GetInteger, GetInt32)(driven, references, count, ARRAY(integers, given)));
    else
        CALL(there && (count == 0 || truths),
             set ? F(SetBoolean, SetBoolean)(driven, references, count, ARRAY(truths, given))
                 : F(GetBoolean, GetBoolean)(driven, references, count, ARRAY(truths, given)));
    free(references), free(reals), free(integers), free(wide), free(truths);
}

static void strings(void)
{
    size_t count = some_count();
    CALL(count == 0, F(GetString, GetString)(driven, NULL, count, ARRAY(NULL, count)));
    CALL(count == 0, F(SetString, SetString)(driven, NULL, count, ARRAY(NULL, count)));
#if FMI == 3
    CALL(count == 0, fmi3GetBinary(driven, NULL, count, NULL, NULL, count));
    CALL(count == 0, fmi3SetClock(driven, NULL, count, NULL));
    CALL(count == 0, fmi3GetUInt64(driven, NULL, count, NULL, count));
    CALL(1, fmi3UpdateDiscreteStates(driven, NULL, NULL, NULL, NULL, NULL, NULL));
    CALL(1, fmi3GetAdjointDerivative(driven, NULL, count, NULL, count, NULL, count, NULL, count));
#endif
}

static void derivatives(void)
{
    size_t count = some_count(), seeds = some_count();
    Reference *unknowns = array(count * sizeof *unknowns), *knowns = array(seeds * sizeof *knowns);
    double *result = array(count * sizeof *result), *seed = array(seeds * sizeof *seed);
    int *orders = array(count * sizeof *orders);
    for (size_t i = 0; i < count && unknowns; i++)
        unknowns[i] = WL_OUTPUTS && !one_in(5) ? FIRST_OUTPUT + draw(AT_LEAST_1(WL_OUTPUTS)) : some_reference();
    for (size_t i = 0; i < count && orders; i++)
        orders[i] = one_in(10) ? (int)draw(5) - 2 : 1;
    for (size_t i = 0; i < count && result; i++)
        result[i] = odd_number();
    for (size_t i = 0; i < seeds && knowns; i++)
        knowns[i] = WL_INPUTS && !one_in(5) ? FIRST_INPUT + draw(AT_LEAST_1(WL_INPUTS)) : some_reference();
    for (size_t i = 0; i < seeds && seed; i++)
        seed[i] = odd_number();
    int outputs = count == 0 || (unknowns && result), inputs = seeds == 0 || (knowns && seed);
    CALL(outputs && inputs,
         F(GetDirectionalDerivative, GetDirectionalDerivative)(driven, unknowns, count, knowns, seeds,
                                                               ARRAY(seed, seeds), ARRAY(result, count)));
    CALL(outputs && (count == 0 || orders),
         F(GetRealOutputDerivatives, GetOutputDerivatives)(driven, unknowns, count, orders, ARRAY(result, count)));
#if FMI == 2
    CALL(outputs && (count == 0 || orders),
         fmi2SetRealInputDerivatives(driven, unknowns, count, orders, result));
    if (WL_INPUTS && one_in(3)) {
        Reference input = FIRST_INPUT + draw(AT_LEAST_1(WL_INPUTS));
        int order = 1 + (int)draw(2);
        double slope = odd_number() / 100;
        CALL(1, fmi2SetRealInputDerivatives(driven, &input, 1, &order, &slope));
    }
#endif
    free(unknowns), free(knowns), free(result), free(seed), free(orders);
}
