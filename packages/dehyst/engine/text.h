/* Tables of numbers in plain text, from bytes to columns.
 *
 * A line is a row of `width` cells; lines end with LF, CR LF or CR. Empty lines and comments (#, %, //) are passed over.
 * A number is [+-] digits [. digits] [e [+-] digits], or nan, inf, infinity in any case, as Python's float() reads it,
 * rounded correctly (Lemire 2021; Mushtak and Lemire 2023) without regard to any locale. Blanks around a cell do not
 * count. Whatever is not as plain as this stops the reading: quotes, other cells, lines of another width.
 * Any bytes are safe: nothing is read beyond `size`.
 */
#ifndef DEHYST_ENGINE_TEXT_H
#define DEHYST_ENGINE_TEXT_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Converts a number in ASCII (with a decimal point) that needs more digits than 64 bits and one product can tell; at most
 * one cell in a billion of a measured log. Must round correctly. */
typedef double (*text_exact)(const char *number, size_t length, void *context);

typedef struct text_format {
    char delimiter;         /* , ; | tab, or a blank for one or more blanks */
    char decimal;           /* . or , */
    int missing;            /* whether an empty cell of numbers is a NaN; otherwise it stops the reading */
    int portable;           /* whether to do without vector instructions; the result is the same */
    int32_t width;          /* cells in a line */
    const int32_t *letters; /* (width,) 0: a number; k: a label of fewer than k characters */
    text_exact exact;
    void *context;          /* for exact */
} text_format;

typedef struct text_stop {
    int64_t lines;  /* lines seen; without a fault, all of them unless capacity was short */
    size_t bytes;   /* that the lines seen take */
    int32_t column; /* cell at fault, from 0; -1 if there is none */
    int32_t empty;  /* whether there are empty cells of numbers */
    int32_t odd;    /* whether there are inf, or nan with a minus sign */
} text_stop;

/* Lines of a text; a last one without an end counts. */
int64_t text_lines(const char *text, size_t size);
/* Bytes that so many lines take, or all if there are fewer. */
size_t text_offset(const char *text, size_t size, int64_t lines);
/* Length of the longest part that ends with a line end; 0 if there is none. A CR as last byte may be half of one, so it is
 * not an end. */
size_t text_whole_lines(const char *text, size_t size);

/* Read lines into columns: columns[j] is double (capacity,), or uint32_t (capacity, letters[j]) filled up with 0; row
 * (capacity,) is the number of each row's line, from `line` for the first. Text is UTF-8. Returns the number of rows and
 * stops at the first fault, or when capacity is full. */
int64_t text_read(const text_format *format, const char *text, size_t size, int64_t line, int64_t capacity, int64_t *row,
                  void *const *columns, text_stop *stop);

/* One number: bytes it takes, or 0 if there is none. decimal as above. */
size_t text_number(const char *text, size_t size, char decimal, text_exact exact, void *context, double *value);

#ifdef __cplusplus
}
#endif

#endif
