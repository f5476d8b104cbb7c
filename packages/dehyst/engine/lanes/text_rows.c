/* Lines of cells to columns; see text.h. */
#include <math.h>
#include <string.h>

#if LANES_LEVEL < 2

#include "lanes.h"
#include "number.h"
#include "text_ends.h"
#include "text_levels.h"
#include "text_lines.h"
#include "text_usual.h"

/* First byte behind an empty line or a comment, or a null pointer if the line holds data. */
static NUMBER_APART const char *pass_over(const char *p, const char *end)
{
    while (p < end && is_blank(*p)) {
        p++;
    }
    if (p < end && !is_end(*p) && *p != '#' && *p != '%' && !(*p == '/' && end - p > 1 && p[1] == '/')) {
        return NULL;
    }
    p = find_end(p, end);
    return p < end ? behind_end(p, end) : p;
}

/* One character of UTF-8; returns behind it, or a null pointer. */
static const char *character(const char *p, const char *end, uint32_t *code)
{
    const unsigned char lead = (unsigned char)*p;
    const int more = lead < 0x80 ? 0 : lead >= 0xF0 ? 3 : lead >= 0xE0 ? 2 : 1;
    static const uint32_t smallest[4] = {0, 0x80, 0x800, 0x10000};
    uint32_t c = more == 0 ? lead : lead & (0x3Fu >> more);
    if ((lead >= 0x80 && lead < 0xC2) || lead > 0xF4 || end - p <= more) {
        return NULL;
    }
    p++;
    for (int k = 0; k < more; k++, p++) {
        if (((unsigned char)*p & 0xC0) != 0x80) {
            return NULL;
        }
        c = c << 6 | ((unsigned char)*p & 0x3F);
    }
    *code = c;
    return c < smallest[more] || c > 0x10FFFF || (c >= 0xD800 && c < 0xE000) ? NULL : p;
}

/* White space of other scripts, which may have to be stripped. */
static int is_wide_blank(uint32_t c)
{
    return c == 0x85 || c == 0xA0 || c == 0x1680 || (c >= 0x2000 && c <= 0x200A) || c == 0x2028 || c == 0x2029 ||
           c == 0x202F || c == 0x205F || c == 0x3000;
}

/* How cells are set off: a blank as delimiter stands for any number of blanks, also around the line. */
typedef struct layout {
    char delimiter; /* 0 for blanks */
    int blanks;
} layout;

static inline const char *skip_blanks(const char *p, const char *end, layout cells)
{
    while (p < end && is_blank(*p) && *p != cells.delimiter) {
        p++;
    }
    return p;
}

/* A label without the blanks around it; returns behind it and them, or a null pointer. */
static const char *label(const char *p, const char *end, layout cells, int32_t letters, uint32_t *out)
{
    int32_t n = 0, kept = 0;
    p = skip_blanks(p, end, cells);
    while (p < end && *p != cells.delimiter && !is_end(*p) && !(cells.blanks && is_blank(*p))) {
        uint32_t c = 0;
        p = character(p, end, &c);
        if (p == NULL || c == '"' || (c < 0x20 && c != '\t') || (n == 0 && is_wide_blank(c))) {
            return NULL;
        }
        const int blank = c == ' ' || c == '\t';
        if (n < letters - 1) {
            out[n++] = c;
            kept = blank ? kept : n;
        } else if (!blank) {
            return NULL; /* longer than there is room for */
        }
    }
    memset(out + kept, 0, sizeof *out * (size_t)(letters - kept));
    if ((kept == 0 && cells.blanks) || (kept > 0 && is_wide_blank(out[kept - 1]))) {
        return NULL;
    }
    return skip_blanks(p, end, cells);
}

/* A number, or nothing where that is allowed; returns behind it and the blanks around it, or a null pointer. */
static inline const char *number(const char *p, const char *end, layout cells, const text_format *format, double *value,
                                 text_stop *stop)
{
    p = skip_blanks(p, end, cells);
    const char *behind = number_read(p, end, format->decimal, format->exact, format->context, value);
    if (behind == NULL) {
        if (!format->missing || (p < end && *p != cells.delimiter && !is_end(*p))) {
            return NULL;
        }
        *value = (double)NAN;
        stop->empty = 1;
        return p;
    }
    if (behind[-1] > '9') { /* a word, not a digit or point */
        stop->odd |= *value == *value || *p == '-';
    }
    return skip_blanks(behind, end, cells);
}

/* A line whose cells are set off by blanks; returns its end, or a null pointer with the column at fault. */
static NUMBER_APART const char *blank_row(const text_format *format, layout cells, const char *p, const char *end, int64_t k,
                             void *const *columns, text_stop *stop)
{
    const char *const line = p;
    for (int32_t j = 0; j < format->width; j++) {
        const int32_t letters = format->letters[j];
        const char *behind = j > 0 && (p == line || !is_blank(p[-1])) ? NULL
                             : letters > 0
                                 ? label(p, end, cells, letters, (uint32_t *)columns[j] + (size_t)k * (size_t)letters)
                                 : number(p, end, cells, format, (double *)columns[j] + k, stop);
        if (behind == NULL || (j == format->width - 1 && behind < end && !is_end(*behind))) {
            stop->column = j;
            return NULL;
        }
        p = behind;
    }
    return p;
}

/* A line whose cells are set off by a delimiter; returns its end, or a null pointer with the column at fault. */
static NUMBER_APART const char *marked_row(const text_format *format, layout cells, const char *p, const char *end, int64_t k,
                                           void *const *columns, text_stop *stop)
{
    for (int32_t j = 0;; j++, p++) {
        const int32_t letters = format->letters[j];
        p = letters > 0 ? label(p, end, cells, letters, (uint32_t *)columns[j] + (size_t)k * (size_t)letters)
                        : number(p, end, cells, format, (double *)columns[j] + k, stop);
        const int more = p != NULL && p < end && *p == cells.delimiter;
        if (p == NULL || more != (j < format->width - 1) || (!more && p < end && !is_end(*p))) {
            stop->column = j;
            return NULL;
        }
        if (!more) {
            return p;
        }
    }
}

/* A number in any notation up to its end; not what may begin a comment or be an empty line. */
static NUMBER_APART int odd_number(const text_format *format, const char *p, const char *last, int first, double *value,
                                   text_stop *stop)
{
    const layout cells = {format->delimiter, 0};
    return (!first || *p >= '+') && *p != '/' && number(p, last, cells, format, value, stop) == last;
}

/* Lines of nothing but numbers, most of them of the usual kind, away from the ends of the text. Returns the first line that
 * has to be looked at more closely, and counts those before it in *rows. */
static const char *usual_rows(const text_format *format, const char *p, const char *end, int64_t line, int64_t capacity,
                              int64_t *row, void *const *columns, int64_t *rows, text_stop *stop)
{
    const char delimiter = format->delimiter, decimal = format->decimal;
    const int32_t final = format->width - 1;
    const char *start = p, *block = p;
    uint64_t mask = end - block < 64 + USUAL_ROOM ? 0 : text_ends(block, delimiter);
    int64_t k = *rows;
    line -= k;
    for (; k < capacity; k++, start = p) {
        const char *last = p;
        for (int32_t j = 0;; j++) {
            while (mask == 0) {
                block += 64;
                if (end - block < 64 + USUAL_ROOM) {
                    goto out;
                }
                mask = text_ends(block, delimiter);
            }
            last = block + number_lowest(mask);
            mask &= mask - 1;
            double value;
            if (!number_usual(p, last, decimal, &value)) {
                double odd;
                if (!odd_number(format, p, last, j == 0, &odd, stop)) {
                    goto out;
                }
                value = odd;
            }
            ((double *)columns[j])[k] = value;
            p = last + 1;
            if (j == final) {
                break;
            }
            if (*last != delimiter) {
                goto out;
            }
        }
        if (*last == delimiter) {
            goto out;
        }
        row[k] = line + k;
        if (*p == '\n' && p[-1] == '\r') {
            block = ++p;
            mask = end - block < 64 + USUAL_ROOM ? 0 : text_ends(block, delimiter);
        }
    }
out:
    *rows = k;
    return start;
}

int64_t LANES_NAME(text_read)(const text_format *format, const char *text, size_t size, int64_t line, int64_t capacity,
                              int64_t *row, void *const *columns, text_stop *stop)
{
    const layout cells = {format->delimiter == ' ' ? '\0' : format->delimiter, format->delimiter == ' '};
    const char *p = text, *end = text + size;
    text_stop now = {.column = -1};
    int64_t k = 0;
    int plain = !cells.blanks;
    for (int32_t j = 0; j < format->width; j++) {
        plain = plain && format->letters[j] == 0;
    }
    for (; p < end && k < capacity; now.lines++) {
        if (plain && p - text >= USUAL_ROOM && end - p >= 64 + USUAL_ROOM) {
            const int64_t before = k;
            p = usual_rows(format, p, end, line + now.lines, capacity, row, columns, &k, &now);
            now.lines += k - before;
            if (k == capacity) {
                break;
            }
        }
        const char *next = pass_over(p, end);
        if (next != NULL) {
            p = next;
            continue;
        }
        next = cells.blanks ? blank_row(format, cells, p, end, k, columns, &now)
                            : marked_row(format, cells, p, end, k, columns, &now);
        if (next == NULL) {
            break;
        }
        row[k++] = line + now.lines;
        p = next < end ? behind_end(next, end) : next;
    }
    now.bytes = (size_t)(p - text);
    *stop = now;
    return k;
}

#else
typedef int text_rows_none; /* a file must not be empty */
#endif
