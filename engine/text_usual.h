/* The usual cell of a log, without a step that waits for the digits of another cell. */
#ifndef DEHYST_ENGINE_TEXT_USUAL_H
#define DEHYST_ENGINE_TEXT_USUAL_H

#include "number.h"

#if LANES_LEVEL > 0
#include <immintrin.h>

enum { USUAL_ROOM = 16 };

/* By the place of the point among 16 bytes, 16 for none: bytes without it, moved up, and the power of ten behind it. */
#define WITHOUT(a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p) {a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p}
static const signed char usual_without[17][16] = {
    WITHOUT(-1, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15),
    WITHOUT(-1, 0, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15),
    WITHOUT(-1, 0, 1, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15),
    WITHOUT(-1, 0, 1, 2, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15),
    WITHOUT(-1, 0, 1, 2, 3, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15),
    WITHOUT(-1, 0, 1, 2, 3, 4, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15),
    WITHOUT(-1, 0, 1, 2, 3, 4, 5, 7, 8, 9, 10, 11, 12, 13, 14, 15),
    WITHOUT(-1, 0, 1, 2, 3, 4, 5, 6, 8, 9, 10, 11, 12, 13, 14, 15),
    WITHOUT(-1, 0, 1, 2, 3, 4, 5, 6, 7, 9, 10, 11, 12, 13, 14, 15),
    WITHOUT(-1, 0, 1, 2, 3, 4, 5, 6, 7, 8, 10, 11, 12, 13, 14, 15),
    WITHOUT(-1, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 11, 12, 13, 14, 15),
    WITHOUT(-1, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 13, 14, 15),
    WITHOUT(-1, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 13, 14, 15),
    WITHOUT(-1, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 14, 15),
    WITHOUT(-1, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 15),
    WITHOUT(-1, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14),
    WITHOUT(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15),
};
#undef WITHOUT
static const double usual_power[17] = {1e15, 1e14, 1e13, 1e12, 1e11, 1e10, 1e9, 1e8, 1e7,
                                       1e6,  1e5,  1e4,  1e3,  1e2,  1e1,  1e0, 1e0};

/* [-] digits with or without a point, at most 16 characters and 15 digits, from p to last exactly; USUAL_ROOM bytes before
 * last can be read. Returns 0 if it is another cell. */
static inline int number_usual(const char *p, const char *last, char decimal, double *value)
{
    static const signed char behind[32] = {0,  0,  0,  0,  0,  0,  0,  0,  0,  0,  0,  0,  0,  0,  0,  0,
                                           -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1};
    const uint64_t negative = *p == '-';
    const size_t length = (size_t)(last - p) - negative;
    if (length > 16) {
        return 0;
    }
    const __m128i bytes = _mm_loadu_si128((const __m128i *)(const void *)(last - 16));
    const __m128i cell = _mm_loadu_si128((const __m128i *)(const void *)(behind + length));
    const __m128i digits = _mm_and_si128(_mm_sub_epi8(bytes, _mm_set1_epi8('0')), cell);
    /* Outside the cell are zeros, which count as digits. */
    const __m128i good = _mm_cmpeq_epi8(_mm_min_epu8(digits, _mm_set1_epi8(9)), digits);
    const __m128i point = _mm_and_si128(_mm_cmpeq_epi8(bytes, _mm_set1_epi8(decimal)), cell);
    const unsigned others = (unsigned)_mm_movemask_epi8(good) ^ 0xFFFF, points = (unsigned)_mm_movemask_epi8(point);
    /* At most one point, and 1 to 15 digits. */
    if (others != points || (others & (others - 1)) != 0 || length + (others == 0) - 2 > 14) {
        return 0;
    }
    const unsigned place = number_lowest(others | 0x10000);
    const __m128i order = _mm_loadu_si128((const __m128i *)(const void *)usual_without[place]);
    const __m128i pairs = _mm_maddubs_epi16(_mm_shuffle_epi8(digits, order), _mm_set1_epi16(0x010A));
    const __m128i fours = _mm_madd_epi16(pairs, _mm_set1_epi32(0x00010064));
    const __m128i eights = _mm_madd_epi16(_mm_packus_epi32(fours, fours), _mm_set1_epi32(0x00012710));
    const uint64_t both = (uint64_t)_mm_cvtsi128_si64(eights);
    const uint64_t mantissa = (both & UINT32_MAX) * 100000000 + (both >> 32);
    /* Mantissa and power of ten are exact, and there is one rounding. */
    const double v = (double)(int64_t)mantissa / usual_power[place];
    uint64_t bits;
    memcpy(&bits, &v, sizeof bits);
    bits |= negative << 63;
    memcpy(value, &bits, sizeof bits);
    return 1;
}

#else

enum { USUAL_ROOM = 8 };

/* The usual cell of a log, [-] d.f with 1 to 7 digits before the point and 1 to 8 behind it, from p to last exactly; USUAL_ROOM
 * bytes before last and behind p can be read. Returns 0 if it is another one. No step waits for the digits of another cell. */
static inline int number_usual(const char *p, const char *last, char decimal, double *value)
{
    const uint64_t zeros = UINT64_C(0x3030303030303030), eighth = UINT64_C(1) << 63;
    const uint64_t negative = *p == '-';
    p += negative;
    const uint64_t head = number_load8(p) ^ zeros;
    const unsigned whole = number_lowest(number_others(head) | eighth) / 8;
    const size_t fraction = (size_t)(last - p) - whole - 1;
    if (whole == 0 || fraction - 1 > 7 || p[whole] != decimal || FLT_EVAL_METHOD != 0) {
        return 0;
    }
    const unsigned spare = 64 - 8 * (unsigned)fraction;
    const uint64_t tail = (number_load8(last - 8) ^ zeros) >> spare << spare; /* zeros before the fraction */
    if (number_others(tail) != 0) {
        return 0;
    }
    const uint64_t mantissa = number_eight(head << (64 - 8 * whole)) * number_tens[fraction] + number_eight(tail);
    /* At most 15 digits: mantissa and power of ten are exact, and there is one rounding. */
    const double v = (double)(int64_t)mantissa / number_ten[fraction];
    uint64_t bits;
    memcpy(&bits, &v, sizeof bits);
    bits |= negative << 63;
    memcpy(value, &bits, sizeof bits);
    return 1;
}

#endif

#endif
