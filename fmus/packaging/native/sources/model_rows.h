/* The rows of a table from the bytes of its file; a part of the units that a host gives tables to. */
#include "model_table.h"

typedef unsigned long long Count;

static Count whole_at(const unsigned char *bytes)
{
    Count whole = 0;
    for (int k = 0; k < 8; k++)
        whole |= (Count)bytes[k] << 8 * k;
    return whole;
}

static unsigned crc_32(const unsigned char *bytes, size_t size)
{
    unsigned table[256], crc = 0xffffffffu;
    for (unsigned i = 0; i < 256; i++) {
        table[i] = i;
        for (int k = 0; k < 8; k++)
            table[i] = table[i] & 1 ? 0xedb88320u ^ table[i] >> 1 : table[i] >> 1;
    }
    for (size_t i = 0; i < size; i++)
        crc = table[(crc ^ bytes[i]) & 255] ^ crc >> 8;
    return crc ^ 0xffffffffu;
}

/* Puts the rows in place, from bytes that stay where they are; says what is wrong with them, NULL where all is well. */
static const char *table_taken(Table *table, const Played *played, unsigned char *bytes, size_t size)
{
    const Count one = 1;
    const size_t head = strlen(played->head), columns = (size_t)played->columns, numbers = 1 + 2 * columns;
    if (*(const unsigned char *)&one != 1)
        return "holds numbers whose lowest byte comes first, as this machine's does not";
    if (size < head + 8 * (numbers + 1) || memcmp(bytes, played->head, head) != 0)
        return "is no table of these columns";
    const Count rows = whole_at(bytes + head);
    Count room = (size - head) / 8 - numbers - 1, used = rows;
    int fits = rows > 0 && rows <= room && size % 8 == 0;
    for (size_t k = 0; fits && k < columns; k++) {
        Count own = whole_at(bytes + head + 8 * (2 + 2 * k));
        fits = (own == 1 || own == rows) && own <= room - used;
        used += own;
    }
    if (!fits || used != room)
        return "does not hold its rows";
    if (whole_at(bytes + size - 8) != crc_32(bytes, size - 8))
        return "is damaged, its checksum differs";
    const double *next = (const double *)(const void *)(bytes + head + 8 * numbers);
    table->times = next;
    next += rows;
    for (size_t k = 0; k < columns; k++) {
        Count own = whole_at(bytes + head + 8 * (2 + 2 * k));
        table->linear[k] = whole_at(bytes + head + 8 * (1 + 2 * k)) == 1;
        table->constant[k] = own == 1;
        table->values[k] = next;
        next += own;
    }
    for (Count i = 0; i < used; i++)
        if (table->times[i] - table->times[i] != 0)
            return "holds a number that is not finite";
    for (Count i = 1; i < rows; i++)
        if (!(table->times[i] > table->times[i - 1]))
            return "holds times that do not increase";
    table->bytes = bytes;
    table->columns = played->columns;
    table->rows = (long long)rows;
    return NULL;
}
