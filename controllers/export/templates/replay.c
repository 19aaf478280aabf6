
static void settle(double *u, const double *given, int size, double drift, int seen)
{
    int i;
    for (i = 0; i < size; i++)
        u[i] = given[i];
    u[DRIFT] = seen ? drift : 0;
    u[VALID] = seen;
}

/* A law that samples at each of `count` rows of inputs; `measured` is the growth where it was seen, else NaN,
   from which a camera sees what the law's own correction has left. */
#ifdef _WIN32
__declspec(dllexport)
#else
__attribute__((visibility("default")))
#endif
void replay(long count, const double *inputs, const double *measured, const double *design, double period,
    double *outputs)
{
    double u[INPUTS], x[STATES + 1], next[STATES + 1], drift = 0;
    int i, seen = 0;
    long k;
    for (k = 0; k < count; k++) {
        const double time = (double)k * period;
        double *y = outputs + k * OUTPUTS;
        if (k && measured[k] == measured[k]) {
            drift = measured[k] - y[CORRECTION - OUTPUTS];
            seen = 1;
        }
        settle(u, inputs + k * INPUTS, INPUTS, drift, seen);
#if STATES
        if (k) {
            sample_0_of(x, u, design, &time, &period, next);
            for (i = 0; i < STATES; i++)
                x[i] = next[i];
        } else
            begin_of(u, design, &time, x);
#else
        (void)i;
        (void)next;
#endif
        outputs_of(x, u, design, &time, y);
    }
}
