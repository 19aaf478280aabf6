/* What comes by chance, and what a call may answer; a part of random_calls.c. */

static unsigned long long chance;

static unsigned draw(unsigned below)
{
    chance ^= chance << 13, chance ^= chance >> 7, chance ^= chance << 17;
    return (unsigned)((chance >> 11) % below);
}

static int one_in(unsigned n)
{
    return draw(n) == 0;
}

static double odd_number(void)
{
    static const double odd[] = {0, -0.0, 1, -1, 0.5, 1e-300, 5e-324, 1e-9, 2147483648.0, -4e9, 1e18, 9e15, 1e300, -1e300};
    unsigned which = draw(sizeof odd / sizeof *odd + 4);
    return which == 0 ? NAN : which == 1 ? HUGE_VAL : which == 2 ? -HUGE_VAL
           : which == 3 ? (draw(2001) - 1000.0) / 8 : odd[which - 4];
}

/* Mostly what the variable may be, so that runs get on. */
static double value_for(Reference reference)
{
    const Variable *variable = &WL(variables)[reference % VARIABLES];
    if (one_in(30))
        return odd_number();
    if (one_in(4) && (variable->flags & HAS_MINIMUM))
        return variable->minimum;
    if (one_in(8) && (variable->flags & HAS_MAXIMUM))
        return variable->maximum;
    return one_in(3) && variable->kind == REAL ? variable->start * (1 + draw(100) / 1e3) : variable->start;
}

static Reference some_reference(void)
{
    static const Reference wrong[] = {VARIABLES + 1 + 2 * WL_STATES, 99999, 0x7fffffff, 0x80000000, 0xffffffff};
    return one_in(20) ? wrong[draw(5)] : draw(VARIABLES + 1 + (WL_EXCHANGES ? 2 * WL_STATES : 0));
}

static size_t some_count(void)
{
    return one_in(6) ? 0 : one_in(5) ? 1 + draw(8) : 1;
}

/* An array of exactly that size, so that reading beyond it is seen; now and then none at all. */
static void *array(size_t bytes)
{
    return one_in(20) ? NULL : malloc(bytes ? bytes : 1);
}

static void judge(Status status, long before, int possible)
{
    FAULTY(status == ERROR && sentences == before, "an error without a sentence");
    FAULTY(status != ERROR && !possible, "a null pointer was followed");
}

/* One call: what it answers, and whether it could be answered at all. */
#define CALL(possible, call) \
    do { \
        long before_ = sentences; \
        Status status_ = (call); \
        judge(status_, before_, possible); \
    } while (0)
