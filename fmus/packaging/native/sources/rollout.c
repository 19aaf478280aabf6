/* Whole runs of a joined component, LANES side by side; rollout_code.py writes what is called here. */
typedef void Held(const lanes *u, const lanes *d, const lanes *step, lanes *kept);
typedef void Rest(const lanes *x, const lanes *u, const lanes *d, const lanes *time, const lanes *step,
    const lanes *kept, lanes *next);
typedef void Inputs(const lanes *x, const lanes *u, const lanes *d, const lanes *time, const lanes *view,
    lanes *inputs);
#define DECLARE(name) Held name##_held_lanes; Rest name##_lanes;
DECLARED

/* What changes states: what of it depends on held values alone, its inputs (0: those of the whole), the rest;
   where its states, its settled values and what it keeps begin, and how many states it has. */
static const struct {
    Held *held;
    Inputs *inputs;
    Rest *rest;
    int x, d, size, kept;
}
#define CHANGE(name, inputs, x, d, size, kept) {name##_held_lanes, inputs, name##_lanes, x, d, size, kept}
changes[] = {CHANGES};
enum {COUNT = sizeof changes / sizeof *changes};

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

/* Tasks: 0 takes a micro step, 1 records, 2 and so on are the clocks. Changes: the usual step, the full one,
   the clocks. */
__attribute__((visibility("default"))) void rollout(long count, long points, const signed char *tasks,
    const double *times, const double *steps, const double **tables, const lanes *d, lanes *x,
    double *rows, lanes *refused)
{
    lanes given[GIVEN + 1], kept[KEPT + 1], u[LONGEST], own[LONGEST], view[LONGEST], next[LONGEST];
    lanes row[RECORDED + 1], standing;
    double last[COUNT];
    const int step_as = RARE;
    int seen = 0;
    long instant = 0, point = 0;
    for (int change = 0; change < COUNT; change++)
        last[change] = NAN;
    for (long i = 0; i < count; i++) {
        const lanes time = EACH(times[i]), step = EACH(steps[i]);
        if ((i == 0 || times[i] != times[i - 1]) && renewed(tables, instant++, given)) {
            inputs_of(given, u);
            standing_of(u, d, &standing);
            last[0] = last[1] = NAN;
            seen = 0;
        }
        if (tasks[i] != 0 && !seen)
            view_of(x, u, d, &time, view);
        seen = tasks[i] != 0;
        if (tasks[i] == 1) {
            record_of(x, u, d, &time, view, row);
            *refused += row[RECORDED] + standing;
            for (int run = 0; run < LANES; run++)
                for (int k = 0; k < RECORDED; k++)
                    rows[(RECORDED * run + k) * points + point] = row[k][run];
            point++;
        } else {
            const int change = tasks[i] == 0 ? step_as : tasks[i];
            const int first = changes[change].x;
            const lanes *settled = d + changes[change].d, *inputs = u;
            lanes *held = kept + changes[change].kept;
            if (changes[change].inputs) {
                changes[change].inputs(x, u, d, &time, view, own);
                inputs = own;
            }
            if (steps[i] != last[change])
                changes[change].held(u, settled, &step, held);
            last[change] = steps[i];
            changes[change].rest(x + first, inputs, settled, &time, &step, held, next);
            memcpy(x + first, next, changes[change].size * sizeof *x);
        }
    }
}
