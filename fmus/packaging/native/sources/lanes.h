/* What the C of c_code.py needs where each number is a vector of LANES runs. */
#include <math.h>
#define WL(name) name##_lanes
typedef double lanes __attribute__((vector_size(8 * LANES)));
typedef long long masks __attribute__((vector_size(8 * LANES)));
#define EACH(number) ((number) - (lanes){0})
#define TRUTH(condition) ((lanes)((masks)(condition) & (masks)EACH(1.0)))
#define IF(condition, value) ((lanes)((masks)((condition) != 0.0) & (masks)(value)))
#define EITHER(condition, one, other) \
    ((lanes)(((masks)((condition) != 0.0) & (masks)(one)) | ((masks)((condition) == 0.0) & (masks)(other))))
/* Whether a condition holds in any lane: what is idle at 0 is run for all of them. */
static inline int any_of(lanes condition)
{
    int any = 0;
    for (int i = 0; i < LANES; i++)
        any |= condition[i] != 0;
    return any;
}
/* Rounded by adding 1.5 2^52, and one less where that went up; larger numbers are whole as they are. */
static inline lanes lanes_floor(lanes x)
{
    const masks sign = (masks){0} + (-0x7fffffffffffffffLL - 1);
    lanes whole = (x + 0x1.8p52) - 0x1.8p52, size = (lanes)((masks)x & ~sign);
    masks small = size < 0x1p51;
    whole -= (lanes)((whole > x) & (masks)EACH(1));
    return (lanes)((((masks)whole | ((masks)x & sign)) & small) | ((masks)x & ~small));
}
#define LANE_BY_LANE_AS(own, name) \
    static inline lanes own(lanes x) \
    { double *each = (double *)&x; for (int i = 0; i < LANES; i++) each[i] = name(each[i]); return x; }
#define LANE_BY_LANE(name) LANE_BY_LANE_AS(lanes_##name, name)
#define LANE_BY_LANE_2(name) \
    static inline lanes lanes_##name(lanes x, lanes y) \
    { for (int i = 0; i < LANES; i++) x[i] = name(x[i], y[i]); return x; }
#define OF_ONE(form) \
    form(fabs) form(sqrt) form(ceil) form(exp) form(expm1) form(log1p) form(sin) form(tan) form(asin) form(acos) \
    form(atan) form(sinh) form(cosh) form(tanh) form(asinh) form(acosh) form(atanh) form(erf)
#define OF_TWO(form) \
    form(pow) form(fmod) form(remainder) form(atan2) form(hypot) form(copysign) form(fmin) form(fmax)
OF_ONE(LANE_BY_LANE)
OF_TWO(LANE_BY_LANE_2)
LANE_BY_LANE_AS(slow_log, log)
LANE_BY_LANE_AS(slow_cos, cos)
static inline lanes lanes_sign(lanes x)
{
    return TRUTH(x > 0) - TRUTH(x < 0) + IF(TRUTH(x != x), x);
}

/* The two functions that noise needs for each reading; what they are not made for is done lane by lane. */
static int all_between(lanes x, double low, double high)
{
    int well = 1;
    for (int i = 0; i < LANES; i++)
        well &= x[i] >= low && x[i] <= high;
    return well;
}
/* x = 2^n m with m about 1, and log m = 2 artanh((m - 1) / (m + 1)) by its series. */
static inline lanes lanes_log(lanes x)
{
    if (!all_between(x, 1e-300, 1e300))
        return slow_log(x);
    masks n = ((masks)x - 0x3fe6a09e667f3bcdLL) >> 52;
    lanes m = (lanes)((masks)x - (n << 52)), s = (m - 1.0) / (m + 1.0), z = s * s, sum = EACH(1.0 / 25);
#pragma GCC unroll 16
    for (int k = 23; k > 1; k -= 2)
        sum = 1.0 / k + z * sum;
    lanes whole = __builtin_convertvector(n, lanes);
    return whole * 0x1.62e42feep-1 + (2.0 * s + (2.0 * s * z * sum + whole * 0x1.a39ef35793c76p-33));
}
/* x = n pi / 2 + r, and the series of the cosine or the sine of r. */
static inline lanes lanes_cos(lanes x)
{
    if (!all_between(x, -1e3, 1e3))
        return slow_cos(x);
    lanes whole = lanes_floor(x * 0x1.45f306dc9c883p-1 + 0.5);
    lanes r = x - whole * 0x1.921fb544p+0 - whole * 0x1.0b4611a626331p-34, z = r * r;
    lanes c = EACH(1), s = EACH(1);
#pragma GCC unroll 16
    for (int k = 18; k > 0; k -= 2) {
        c = 1.0 - z * (1.0 / (k * (k - 1))) * c;
        s = 1.0 - z * (1.0 / (k * (k + 1))) * s;
    }
    masks n = __builtin_convertvector(whole, masks), odd = -(n & 1);
    return (lanes)((((masks)c & ~odd) | ((masks)(r * s) & odd)) ^ (((n + 1) & 2) << 62));
}
