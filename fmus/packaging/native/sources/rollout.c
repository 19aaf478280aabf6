/* Whole runs of a joined component, LANES side by side; rollout_code.py writes what is called here.

   Gains: studies; an hour of the cell in 4 ms, and in 0.9 of eight lanes, not in 20 as FMUs under loop.c
   (python -m benchmarks.cores). */
#include <string.h>

/* `known` is what was computed before: held for micro steps, or the view, which samples and records share. */
typedef void Change(const lanes *x, const lanes *u, const lanes *known, const lanes *d, const lanes *time,
    const lanes *step, lanes *next);
Change WL(advance);
void WL(held)(const lanes *u, const lanes *d, const lanes *step, lanes *held);

/* What changes states: where those begin that it changes, and how many they are. The micro step, the clocks. */
static const struct {
    Change *change;
    int first, size;
} changes[] = {CHANGES};

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

/* Tasks: 0 takes a micro step, 1 records, 2 and so on are the clocks. */
__attribute__((visibility("default"))) void rollout(long count, long points, const signed char *tasks,
    const double *times, const double *steps, const double **tables, const lanes *d, lanes *x,
    double *rows, lanes *refused)
{
    lanes given[GIVEN + 1], u[LONGEST], held[LONGEST], view[LONGEST], next[LONGEST], row[RECORDED + 1];
    double held_for = NAN;
    long instant = 0, point = 0;
    for (long i = 0; i < count; i++) {
        const lanes time = EACH(times[i]), step = EACH(steps[i]);
        const int later = i == 0 || times[i] != times[i - 1];
        if (later && renewed(tables, instant++, given)) {
            inputs_of(given, u);
            held_for = NAN;
        }
        if (tasks[i] == 0 && held_for != steps[i]) {
            WL(held)(u, d, &step, held);
            held_for = steps[i];
        }
        if (tasks[i] != 0 && (later || tasks[i - 1] == 0))
            view_of(x, u, d, &time, view);
        if (tasks[i] == 1) {
            record_of(x, u, view, d, &time, row);
            *refused += row[RECORDED];
            for (int run = 0; run < LANES; run++)
                for (int k = 0; k < RECORDED; k++)
                    rows[(RECORDED * run + k) * points + point] = row[k][run];
            point++;
        } else {
            const int change = tasks[i] == 0 ? 0 : tasks[i] - 1;
            changes[change].change(x, u, tasks[i] == 0 ? held : view, d, &time, &step, next);
            memcpy(x + changes[change].first, next, changes[change].size * sizeof *x);
        }
    }
}
