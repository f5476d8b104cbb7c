/* Where cells end, 64 bytes at a time, ahead of the digits between the ends. */
#ifndef DEHYST_ENGINE_TEXT_ENDS_H
#define DEHYST_ENGINE_TEXT_ENDS_H

#include <stdint.h>
#include <string.h>

#include "number.h"

#if LANES_LEVEL > 0
#include <immintrin.h>
#endif

#if LANES_LEVEL == 0
/* Bit 0x80 of each byte of a word that equals c. */
static inline uint64_t text_equal(uint64_t word, char c)
{
    const uint64_t low = UINT64_C(0x7F7F7F7F7F7F7F7F);
    const uint64_t x = word ^ (UINT64_C(0x0101010101010101) * (unsigned char)c);
    return ~(((x & low) + low) | x | low);
}
#endif

/* Which of the 64 bytes at block are the delimiter or a line end. */
static inline uint64_t text_ends(const char *block, char delimiter)
{
#if LANES_LEVEL > 0
    const __m256i mark = _mm256_set1_epi8(delimiter), feed = _mm256_set1_epi8('\n'), back = _mm256_set1_epi8('\r');
    uint64_t mask = 0;
    for (int k = 0; k < 2; k++) {
        const __m256i b = _mm256_loadu_si256((const __m256i *)(const void *)(block + 32 * k));
        const __m256i lines = _mm256_or_si256(_mm256_cmpeq_epi8(b, feed), _mm256_cmpeq_epi8(b, back));
        const __m256i found = _mm256_or_si256(_mm256_cmpeq_epi8(b, mark), lines);
        mask |= (uint64_t)(unsigned)_mm256_movemask_epi8(found) << (32 * k);
    }
    return mask;
#else
    uint64_t mask = 0;
    for (int k = 0; k < 8; k++) {
        const uint64_t word = number_load8(block + 8 * k);
        const uint64_t found = text_equal(word, delimiter) | text_equal(word, '\n') | text_equal(word, '\r');
        mask |= ((found >> 7) * UINT64_C(0x0102040810204080) >> 56) << (8 * k);
    }
    return mask;
#endif
}

#endif
