/* text_read, compiled once per instruction set; AVX-512 has nothing to add to AVX2 here. */
#ifndef DEHYST_ENGINE_TEXT_LEVELS_H
#define DEHYST_ENGINE_TEXT_LEVELS_H

#include "text.h"

int64_t text_read_portable(const text_format *format, const char *text, size_t size, int64_t line, int64_t capacity,
                           int64_t *row, void *const *columns, text_stop *stop);
int64_t text_read_avx2(const text_format *format, const char *text, size_t size, int64_t line, int64_t capacity,
                       int64_t *row, void *const *columns, text_stop *stop);

#endif
