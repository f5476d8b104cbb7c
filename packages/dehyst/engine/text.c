/* Counting lines; reading them is in lanes/text_rows.c. */
#include "text.h"

#include "engine.h"
#include "text_levels.h"
#include "text_lines.h"

int64_t text_lines(const char *text, size_t size)
{
    int64_t count = 0;
    for (size_t first = 1; first < size; first += 255) {
        uint8_t some = 0; /* a byte wide, so that many of them are counted at once */
        const size_t last = size - first < 255 ? size : first + 255;
        for (size_t k = first; k < last; k++) { /* a line ends at LF, and at a CR without one */
            some = (uint8_t)(some + ((text[k - 1] == '\n') | ((text[k - 1] == '\r') & (text[k] != '\n'))));
        }
        count += some;
    }
    return count + (size > 0); /* the last byte ends a line, whatever it is */
}

size_t text_offset(const char *text, size_t size, int64_t lines)
{
    const char *p = text, *end = text + size;
    for (; lines > 0 && p < end; lines--) {
        p = find_end(p, end);
        p = p < end ? behind_end(p, end) : p;
    }
    return (size_t)(p - text);
}

size_t text_whole_lines(const char *text, size_t size)
{
    size_t k = size > 0 && text[size - 1] == '\r' ? size - 1 : size;
    while (k > 0 && !is_end(text[k - 1])) {
        k--;
    }
    return k;
}

int64_t text_read(const text_format *format, const char *text, size_t size, int64_t line, int64_t capacity, int64_t *row,
                  void *const *columns, text_stop *stop)
{
#ifdef ENGINE_HAS_AVX2
    if (!format->portable && engine_level() >= ENGINE_AVX2) {
        return text_read_avx2(format, text, size, line, capacity, row, columns, stop);
    }
#endif
    return text_read_portable(format, text, size, line, capacity, row, columns, stop);
}
