/* Whole runs of a joined component, LANES side by side; rollout_code.py writes what is called here. */
#define OF_(name, part) name##part##_of
#define OF(name, part) OF_(name, part)

/* What the parts that nothing drives give: GIVEN numbers for each instant, LANES instants at once. */
__attribute__((visibility("default"))) void table(long blocks, const lanes *times, const lanes *settled,
    lanes *result)
{
    for (long i = 0; i < blocks; i++)
        given_of(settled, times + i, result + GIVEN * i);
}

/* Whether any run is given something else from an instant on; each run's next row begins with its instant. */
static int renewed(const double **rows, long instant, lanes *given)
{
    int other = 0;
    for (int run = 0; run < LANES; run++)
        if (rows[run][0] == instant) {
            for (int i = 0; i < GIVEN; i++)
                given[i][run] = rows[run][1 + i];
            rows[run] += 1 + GIVEN;
            other = 1;
        }
    return other;
}

static void advance(int rare, int anew, lanes *x, const lanes *u, const lanes *d, const lanes *time,
    const lanes *step, lanes *held)
{
    lanes next[STATES];
    if (rare) {
        if (anew)
            OF(FULL, _held)(u, d, step, held);
        OF(FULL, )(x, u, d, time, step, held, next);
    } else {
        if (anew)
            OF(USUAL, _held)(u, d, step, held);
        OF(USUAL, )(x, u, d, time, step, held, next);
    }
    memcpy(x, next, CONTINUOUS * sizeof *x);
}

/* Tasks: 0 takes a micro step, 1 records, 2 and so on are the clocks. */
__attribute__((visibility("default"))) void rollout(long count, long points, const signed char *tasks,
    const double *times, const double *steps, const double **tables, const lanes *d, lanes *x,
    double *rows, lanes *refused)
{
    lanes given[GIVEN + 1], u[INPUTS], view[VIEW], held[HELD], sampled[SAMPLED], row[RECORDED + 1], standing;
    double last = NAN, sampled_last[CLOCKS];
    const int rare = RARE;
    int seen = 0;
    long instant = 0, point = 0;
    for (int clock = 0; clock < CLOCKS; clock++)
        sampled_last[clock] = NAN;
    for (long i = 0; i < count; i++) {
        const lanes time = EACH(times[i]), step = EACH(steps[i]);
        const int clock = tasks[i] - 2;
        if ((i == 0 || times[i] != times[i - 1]) && renewed(tables, instant++, given)) {
            inputs_of(given, u);
            standing_of(u, d, &standing);
            last = NAN;
            seen = 0;
        }
        if (tasks[i] != 0 && !seen)
            view_of(x, u, d, &time, view);
        seen = tasks[i] != 0;
        if (tasks[i] == 0) {
            advance(rare, steps[i] != last, x, u, d, &time, &step, held);
            last = steps[i];
        } else if (tasks[i] == 1) {
            record_of(given, x, u, d, &time, view, row);
            *refused += row[RECORDED] + standing;
            for (int run = 0; run < LANES; run++)
                for (int k = 0; k < RECORDED; k++)
                    rows[(RECORDED * run + k) * points + point] = row[k][run];
            point++;
        } else {
            sample(clock, steps[i] != sampled_last[clock], x, u, d, &time, &step, view, sampled);
            sampled_last[clock] = steps[i];
        }
    }
}
