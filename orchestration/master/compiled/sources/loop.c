/* The macro-step loop over the functions of FMUs. Tables and buffers are those of loop.py.

   Gains: an hour of the cell's FMUs in 20 ms, not in the 180 of the loop in Python (python -m benchmarks.cores). */
#include <fenv.h>
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { FLOAT64, INT32, UINT8, INT64 };                 /* kinds of values, as buffers hold them */
enum { NOTHING = -1, STEP, READ, WRITE, NOTE };        /* what is done with a slave, and what failed */
enum { WIRES = STEP, CHECKS = NOTE + 1 };              /* rows of the ranges beside those deeds' */

typedef struct {
    int64_t component, step, version, stepping, forward_only;
} Slave;

typedef struct {
    int64_t function, component, references, count, values, version;
} Batch;

typedef struct {
    int64_t deed, slave;
} Job;

typedef struct {
    int64_t kind, index;
} Place;

typedef struct {
    Place source, target;
} Wire;

typedef struct {
    double *doubles;
    int32_t *ints;
    uint8_t *octets;
    int64_t *longs;
} Buffers;

/* What failed at which slave and how, the call under way, the rows recorded, and the slave that asks to end the
   simulation, counted from 1: see under_way.py. */
typedef struct {
    int64_t what, slave, detail, call, rows, asked, batch, ends, turned;
} Cells;

/* What steers arithmetic, without the flags of what has happened. */
static uint32_t controls(void)
{
#if defined(__x86_64__)
    uint32_t registers = 0;
    uint16_t word = 0;
    __asm__ __volatile__("stmxcsr %0" : "=m"(registers));
    __asm__ __volatile__("fnstcw %0" : "=m"(word));
    return (registers & 0xffc0u) | (uint32_t)word << 16;
#elif defined(__aarch64__)
    uint64_t word = 0;
    __asm__ __volatile__("mrs %0, fpcr" : "=r"(word));
    return (uint32_t)word;
#else
    return (uint32_t)fegetround();
#endif
}

typedef int Exchange2(void *, const uint32_t *, size_t, void *);
typedef int Exchange3(void *, const uint32_t *, size_t, void *, size_t);
typedef int Step2(void *, double, double, int);
typedef int Step3(void *, double, double, bool, bool *, bool *, bool *, double *);

#define POINTER(type, address) ((type *)(intptr_t)(address))

static double value_at(const Buffers *held, Place place)
{
    if (place.kind == FLOAT64)
        return held->doubles[place.index];
    if (place.kind == INT64)
        return (double)held->longs[place.index];
    return place.kind == INT32 ? held->ints[place.index] : held->octets[place.index] != 0;
}

/* Gets or sets batches; gives the worst status, and notes the batch that it is of. */
static int exchange(const Batch *batches, int64_t first, int64_t last, Cells *cells)
{
    int status = 0;
    for (const Batch *each = batches + first; each < batches + last && status <= 1; each++) {
        cells->batch = each - batches;
        void *component = POINTER(void, each->component), *values = POINTER(void, each->values);
        const uint32_t *references = POINTER(const uint32_t, each->references);
        size_t count = (size_t)each->count;
        status = each->version == 2
                     ? POINTER(Exchange2, each->function)(component, references, count, values)
                     : POINTER(Exchange3, each->function)(component, references, count, values, count);
    }
    return status;
}

/* Passes outputs on to inputs. */
static void pass_on(const Wire *wires, const double *factors, const Buffers *held, int64_t first, int64_t last)
{
    for (int64_t w = first; w < last; w++) {
        double value = value_at(held, wires[w].source);
        Place target = wires[w].target;
        if (target.kind == FLOAT64) {
            if (factors[2 * w] != 1 || factors[2 * w + 1] != 0)
                value = factors[2 * w] * value + factors[2 * w + 1];
            held->doubles[target.index] = value;
        } else if (target.kind == INT32)
            held->ints[target.index] = (int32_t)value;
        else if (target.kind == INT64)
            held->longs[target.index] = (int64_t)value;
        else
            held->octets[target.index] = value != 0;
    }
}

static int do_step(const Slave *slave, const Buffers *held, double time, double step)
{
    void *component = POINTER(void, slave->component);
    bool *flags = (bool *)held->octets;
    if (slave->version == 2)
        return POINTER(Step2, slave->step)(component, time, step, (int)slave->forward_only);
    return POINTER(Step3, slave->step)(component, time, step, slave->forward_only != 0, flags, flags + 1,
                                       flags + 2, held->doubles);
}

/* Sizes and tables, as loop.py lays them out: all of eight bytes. */
typedef struct {
    int64_t count, width, count_of_jobs, uneven;
    const Job *jobs;
    const Slave *slaves;
    const Batch *batches;
    const Wire *wires;
    const int64_t *checks;
    const Place *columns;
    const int64_t *ranges;
    const double *factors, *times;
    Buffers held;
} Tables;

/* Steps from communication point `first` to `last` by the jobs of the schedule and gives the point reached.
   Each point fills a row, from `row` on; a slave that asks to end the simulation ends it there. */
__attribute__((visibility("default"))) int64_t advance(
    const Tables *t, int64_t first, int64_t last, double *row, Cells *cells)
{
    const int64_t size = t->count + 1;
    const Slave *slaves = t->slaves;
    const uint32_t calculates = controls();
    fenv_t arithmetic;
    fegetenv(&arithmetic);
    for (int64_t point = first; point < last; point++) {
        double time = t->uneven ? t->times[2 + point] : t->times[0] + (double)point * t->times[1];
        double length = t->uneven ? t->times[3 + point] - t->times[2 + point] : t->times[1];
        for (int64_t j = 0; j < t->count_of_jobs; j++) {
            int64_t deed = t->jobs[j].deed, k = t->jobs[j].slave;
            const int64_t *range = t->ranges + k;
            int status = 0;
            bool wrong = false;
            cells->call = slaves[k].stepping + (deed != STEP);
            cells->what = deed;
            cells->slave = k;
            if (deed == STEP) {
                status = do_step(&slaves[k], &t->held, time, length);
                if (slaves[k].version == 3 && t->held.octets[1])
                    cells->ends = k + 1;
            } else {
                if (deed == WRITE)
                    pass_on(t->wires, t->factors, &t->held, range[WIRES * size], range[WIRES * size + 1]);
                status = exchange(t->batches, range[deed * size], range[deed * size + 1], cells);
                for (int64_t c = range[CHECKS * size]; deed == READ && c < range[CHECKS * size + 1]; c++)
                    wrong |= !isfinite(t->held.doubles[t->checks[c]]);
            }
            if (controls() != calculates) {
                fesetenv(&arithmetic);
                cells->turned = k + 1;
            }
            cells->detail = status;
            if (status > 1 || wrong)
                return point;
        }
        cells->what = NOTHING;
        for (int64_t c = 0; c < t->width; c++)
            *row++ = value_at(&t->held, t->columns[c]);
        cells->rows = point + 2;
        if (cells->ends)
            return point + 1;
    }
    return last;
}

/* A slave that plays a log: after a step, its outputs are those of the row in which the step began. */
typedef struct {
    const double *values, *times;
    int64_t points, width, point;
} Log;

__attribute__((visibility("default"))) int log_step(Log *log, double time, double step, int keep)
{
    while (log->point > 0 && log->times[log->point] > time)
        log->point--;
    while (log->point + 1 < log->points && log->times[log->point + 1] <= time)
        log->point++;
    return 0;
}

__attribute__((visibility("default"))) int log_get(
    Log *log, const uint32_t *references, size_t count, double *values)
{
    for (size_t i = 0; i < count; i++)
        values[i] = log->values[log->point * log->width + references[i]];
    return 0;
}
