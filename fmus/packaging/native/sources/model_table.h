/* Tables over time: the row that holds at a time, and the rows in the bytes of a file. A handle is the address of a
   table in place of a number. */
#include <math.h>
#include <string.h>

/* By which rounding, also that of a host that adds its steps up, may miss the time of a row [s]. */
#define EARLY 1e-6

/* The last row that has begun; -1 before the first. From where it would be if rows came evenly, so that a step costs
   the same in a table of any length. */
static inline long long row_at(const Table *table, double now)
{
    const double *times = table->times;
    long long count = table->rows, low = -1, high = count, reach = 1, guess = 0;
    double share = (now - times[0]) / (times[count - 1] - times[0]) * (double)(count - 1);
    if (share > 0)
        guess = share < (double)(count - 1) ? (long long)share : count - 1;
    if (times[guess] <= now) {
        for (low = guess, high = guess + 1; high < count && times[high] <= now; reach *= 2) {
            low = high;
            high = high + reach < count ? high + reach : count;
        }
    } else {
        for (high = guess, low = guess - 1; low >= 0 && times[low] > now; reach *= 2) {
            high = low;
            low = low - reach > -1 ? low - reach : -1;
        }
    }
    while (high - low > 1) {
        long long middle = low + (high - low) / 2;
        if (times[middle] <= now)
            low = middle;
        else
            high = middle;
    }
    return low;
}

/* Time of the row that holds; the columns' values in it; their rates until the next. */
static inline void table_row(double handle, double time, double *row)
{
    const Table *table;
    memcpy(&table, &handle, sizeof table);
    const int columns = table->columns;
    if (!table->rows) { /* none was given */
        row[0] = NAN;
        for (int k = 1; k < 1 + 2 * columns; k++)
            row[k] = NAN;
        return;
    }
    const long long begun = row_at(table, time + EARLY), i = begun < 0 ? 0 : begun;
    const int between = begun >= 0 && begun + 1 < table->rows;
    row[0] = table->times[i];
    for (int k = 0; k < columns; k++) {
        const double *values = table->values[k];
        const int moves = between && table->linear[k] && !table->constant[k];
        row[1 + k] = values[table->constant[k] ? 0 : i];
        row[1 + columns + k] = moves ? (values[i + 1] - values[i]) / (table->times[i + 1] - table->times[i]) : 0;
    }
}
