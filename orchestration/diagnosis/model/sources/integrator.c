/* ROS2 over the steps of a run, see `integrator.py`: the states are column 0, their sensitivities the others.

   Gains: an hour with its sensitivities in 2.7 ms, not in the 20 of CasADi's machine (python -m benchmarks.cores). */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("O3")
#endif

/* Rates, their Jacobian and their derivatives by slot, from CasADi: what is not zero, row by row. */
int linear(const double **arguments, double **results, long long *integers, double *reals, int memory);

typedef struct {
    int64_t states, columns, inputs;
    int64_t arguments, results, integers, reals; /* that `linear` works with */
    int64_t nodes;
    const int64_t *jacobian_rows, *jacobian_columns, *slot_rows, *slot_columns;
    const double *slots, *parameters;
    const double *node_times;
    const int64_t *course_of_slot;
} System;

typedef struct {
    int64_t below, above; /* of the diagonal: how far entries lie, of the Jacobian and of its factors */
} Band;

typedef struct {
    const double *times;
    const int64_t *begins, *levels; /* of the inputs that act in each step */
    const double *shares, *table;
} Steps;

typedef struct {
    const double **arguments;
    double **results;
    long long *integers;
    double *reals;
    double *at, *rates, *jacobian, *by_slot;                /* at one point on one level of the inputs */
    double *mean_rates, *mean_jacobian, *mean_by_slot;      /* over the levels that act in a step */
    double *matrix, *ahead, *first, *second;
    int64_t *pivots;
} Work;

static inline void add(double *to, const double *each, double share, int64_t count)
{
    for (int64_t i = 0; i < count; i++)
        to[i] += share * each[i];
}

/* A function whose loops over columns are compiled twice: for any number of them, and for states alone. */
#if defined(__GNUC__)
#define FOR_COLUMNS static inline __attribute__((always_inline))
#else
#define FOR_COLUMNS static inline
#endif

FOR_COLUMNS void slopes_of(
    const System *system, Work *work, const Steps *steps, int64_t step, double time, const double *at, double *slopes,
    int64_t m)
{
    int64_t n = system->states;
    int64_t entries = system->jacobian_rows[n], slot_entries = system->slot_rows[n];
    for (int64_t i = 0; i < n; i++)
        work->at[i] = at[i * m];
    memset(work->mean_rates, 0, n * sizeof(double));
    memset(work->mean_jacobian, 0, entries * sizeof(double));
    memset(work->mean_by_slot, 0, slot_entries * sizeof(double));
    for (int64_t i = steps->begins[step]; i < steps->begins[step + 1]; i++) {
        const double *given[] = {
            work->at, system->slots, system->parameters, steps->table + steps->levels[i] * system->inputs, &time};
        double *found[] = {work->rates, work->jacobian, work->by_slot};
        memcpy(work->arguments, given, sizeof given);
        memcpy(work->results, found, sizeof found);
        linear(work->arguments, work->results, work->integers, work->reals, 0);
        add(work->mean_rates, work->rates, steps->shares[i], n);
        add(work->mean_jacobian, work->jacobian, steps->shares[i], entries);
        add(work->mean_by_slot, work->by_slot, steps->shares[i], slot_entries);
    }
    int64_t node = 0;
    double later = 0.0; /* share of the node after it */
    if (system->nodes > 1) {
        const double *nodes = system->node_times;
        while (node < system->nodes - 2 && nodes[node + 1] < time)
            node++;
        later = (time - nodes[node]) / (nodes[node + 1] - nodes[node]);
    }
    for (int64_t i = 0; i < n; i++) {
        double *row = slopes + i * m;
        memset(row, 0, m * sizeof(double));
        for (int64_t k = system->jacobian_rows[i]; k < system->jacobian_rows[i + 1]; k++)
            add(row, at + system->jacobian_columns[k] * m, work->mean_jacobian[k], m);
        row[0] = work->mean_rates[i];
        for (int64_t k = system->slot_rows[i]; k < system->slot_rows[i + 1]; k++) {
            int64_t course = system->course_of_slot[system->slot_columns[k]];
            if (course < 0)
                continue;
            double *column = row + 1 + course * system->nodes + node;
            column[0] += (1 - later) * work->mean_by_slot[k];
            if (later != 0.0)
                column[1] += later * work->mean_by_slot[k];
        }
    }
}

/* Slopes of states and sensitivities at a time, averaged over the inputs that act in a step. */
static void slopes_at(
    const System *system, Work *work, const Steps *steps, int64_t step, double time, const double *at, double *slopes)
{
    if (system->columns == 1)
        slopes_of(system, work, steps, step, time, at, slopes, 1);
    else
        slopes_of(system, work, steps, step, time, at, slopes, system->columns);
}

/* Where the Jacobian has entries; exchanges of rows move those above the diagonal further out. */
static Band band_of(const System *system)
{
    Band band = {0, 0};
    for (int64_t i = 0; i < system->states; i++)
        for (int64_t k = system->jacobian_rows[i]; k < system->jacobian_rows[i + 1]; k++) {
            int64_t beside = system->jacobian_columns[k] - i;
            band.above = beside > band.above ? beside : band.above;
            band.below = -beside > band.below ? -beside : band.below;
        }
    band.above += band.below;
    return band;
}

static int64_t least(int64_t one, int64_t other)
{
    return one < other ? one : other;
}

/* LU factors of I - scale J with row exchanges, within the band; a chain of cells has a narrow one. */
static void factorise(const System *system, Band band, Work *work, double scale)
{
    int64_t n = system->states;
    double *matrix = work->matrix;
    for (int64_t i = 0; i < n; i++) {
        int64_t first = i - least(i, band.below), end = least(n, i + band.above + 1);
        memset(matrix + i * n + first, 0, (end - first) * sizeof(double));
        matrix[i * n + i] = 1.0;
        for (int64_t k = system->jacobian_rows[i]; k < system->jacobian_rows[i + 1]; k++)
            matrix[i * n + system->jacobian_columns[k]] -= scale * work->mean_jacobian[k];
    }
    for (int64_t j = 0; j < n; j++) {
        int64_t pivot = j, last = least(n, j + band.below + 1), end = least(n, j + band.above + 1);
        for (int64_t i = j + 1; i < last; i++)
            if (fabs(matrix[i * n + j]) > fabs(matrix[pivot * n + j]))
                pivot = i;
        work->pivots[j] = pivot;
        for (int64_t c = j; pivot != j && c < end; c++) {
            double kept = matrix[j * n + c];
            matrix[j * n + c] = matrix[pivot * n + c];
            matrix[pivot * n + c] = kept;
        }
        for (int64_t i = j + 1; i < last; i++) {
            double factor = matrix[i * n + j];
            if (factor == 0.0)
                continue;
            matrix[i * n + j] = factor /= matrix[j * n + j];
            add(matrix + i * n + j + 1, matrix + j * n + j + 1, -factor, end - j - 1);
        }
    }
}

FOR_COLUMNS void solution_of(const System *system, Band band, const Work *work, double *right, int64_t columns)
{
    int64_t n = system->states;
    for (int64_t j = 0; j < n; j++) {
        int64_t pivot = work->pivots[j], last = least(n, j + band.below + 1);
        for (int64_t c = 0; pivot != j && c < columns; c++) {
            double kept = right[j * columns + c];
            right[j * columns + c] = right[pivot * columns + c];
            right[pivot * columns + c] = kept;
        }
        for (int64_t i = j + 1; i < last; i++)
            if (work->matrix[i * n + j] != 0.0)
                add(right + i * columns, right + j * columns, -work->matrix[i * n + j], columns);
    }
    for (int64_t i = n - 1; i >= 0; i--) {
        int64_t end = least(n, i + band.above + 1);
        for (int64_t j = i + 1; j < end; j++)
            if (work->matrix[i * n + j] != 0.0)
                add(right + i * columns, right + j * columns, -work->matrix[i * n + j], columns);
        for (int64_t c = 0; c < columns; c++)
            right[i * columns + c] /= work->matrix[i * n + i];
    }
}

/* Solution for all columns, in place of the right-hand side. */
static void solve(const System *system, Band band, const Work *work, double *right)
{
    if (system->columns == 1)
        solution_of(system, band, work, right, 1);
    else
        solution_of(system, band, work, right, system->columns);
}

/* Numbers of a buffer, one after another; the first call counts them. */
static double *taken(double *buffer, int64_t *used, int64_t count)
{
    double *found = buffer ? buffer + *used : NULL;
    *used += count;
    return found;
}

static int64_t shared_out(const System *system, Work *work, double *buffer)
{
    int64_t used = 0, n = system->states, table = n * system->columns;
    int64_t entries = system->jacobian_rows[n], slot_entries = system->slot_rows[n];
    work->reals = taken(buffer, &used, system->reals);
    work->at = taken(buffer, &used, n);
    work->rates = taken(buffer, &used, n);
    work->mean_rates = taken(buffer, &used, n);
    work->jacobian = taken(buffer, &used, entries);
    work->mean_jacobian = taken(buffer, &used, entries);
    work->by_slot = taken(buffer, &used, slot_entries);
    work->mean_by_slot = taken(buffer, &used, slot_entries);
    work->matrix = taken(buffer, &used, n * n);
    work->ahead = taken(buffer, &used, table);
    work->first = taken(buffer, &used, table);
    work->second = taken(buffer, &used, table);
    return used;
}

/* Whether a step begins on the one level of the inputs that the step before it ends on. */
static int follows(const Steps *steps, int64_t step, int64_t together)
{
    int64_t before = steps->begins[step - 1], first = steps->begins[step];
    return step % together && first - before == 1 && steps->begins[step + 1] - first == 1
        && steps->levels[before] == steps->levels[first];
}

/*
 * Fill `states` after the first of each group of steps that follow one another, and the slopes at both ends of
 * each of `count` steps. Gives 1 where there is no memory.
 */
__attribute__((visibility("default"))) int integrate(
    const System *system, const Steps *steps, int64_t count, int64_t together, double gamma, double *states,
    double *left, double *right)
{
    int64_t n = system->states, size = n * system->columns;
    Band band = band_of(system);
    Work work = {0};
    double *buffer = malloc((shared_out(system, &work, NULL) + 1) * sizeof(double));
    work.arguments = malloc((system->arguments + 1) * sizeof(double *));
    work.results = malloc((system->results + 1) * sizeof(double *));
    work.integers = malloc((system->integers + 1) * sizeof(long long));
    work.pivots = malloc(n * sizeof(int64_t));
    int missing = !buffer || !work.arguments || !work.results || !work.integers || !work.pivots;
    if (!missing)
        shared_out(system, &work, buffer);
    for (int64_t k = 0; k < count && !missing; k++) {
        int64_t point = k + k / together;
        double start = steps->times[point], end = steps->times[point + 1], length = end - start;
        double *at = states + point * size, *after = at + size, *slopes = left + k * size;
        slopes_at(system, &work, steps, k, start, at, slopes);
        if (k > 0 && follows(steps, k, together))
            memcpy(right + (k - 1) * size, slopes, size * sizeof(double));
        factorise(system, band, &work, gamma * length);
        memcpy(work.first, slopes, size * sizeof(double));
        solve(system, band, &work, work.first);
        for (int64_t i = 0; i < size; i++)
            work.ahead[i] = at[i] + length * work.first[i];
        slopes_at(system, &work, steps, k, end, work.ahead, work.second);
        add(work.second, work.first, -2.0, size);
        solve(system, band, &work, work.second);
        for (int64_t i = 0; i < size; i++)
            after[i] = at[i] + length * (1.5 * work.first[i] + 0.5 * work.second[i]);
        if (k + 1 == count || !follows(steps, k + 1, together))
            slopes_at(system, &work, steps, k, end, after, right + k * size);
    }
    free(buffer);
    free(work.arguments);
    free(work.results);
    free(work.integers);
    free(work.pivots);
    return missing;
}
