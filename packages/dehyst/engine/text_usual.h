/* The usual cell of a log, without a step that waits for the digits of another cell. */
#ifndef DEHYST_ENGINE_TEXT_USUAL_H
#define DEHYST_ENGINE_TEXT_USUAL_H

#include "number.h"

#if LANES_LEVEL > 0
#include <immintrin.h>

#include "text_tables.h"

enum { USUAL_ROOM = 16 };

static inline __m128i usual_load(const void *p) { return _mm_loadu_si128((const __m128i *)p); }

/* [-] digits with or without a point, at most 15 characters, from p to last exactly; USUAL_ROOM bytes before last can be
 * read. Returns 0 if it is another cell. */
static inline int number_usual(const char *p, const char *last, char decimal, double *value)
{
    const text_tables *tables = &text_usual_tables;
    const size_t negative = *p == '-';
    const size_t length = (size_t)(last - p) - negative;
    if (length - 2 > 13) {
        const unsigned digit = (unsigned)(unsigned char)last[-1] - '0';
        *value = negative ? -(double)digit : (double)digit;
        return length == 1 && digit <= 9;
    }
    const __m128i bytes = _mm_sub_epi8(usual_load(last - 16), usual_load(tables->zero));
    const __m128i digits = _mm_and_si128(bytes, usual_load(tables->cell + length)); /* zeros before the cell */
    const unsigned others = (unsigned)_mm_movemask_epi8(_mm_adds_epu8(digits, usual_load(tables->high)));
    const size_t place = number_lowest(others | 0x10000);
    if ((others & (others - 1)) != 0 || (last[(ptrdiff_t)place - 16] != decimal && others != 0)) {
        return 0;
    }
    const __m128i moved = _mm_shuffle_epi8(digits, usual_load(tables->place[place].order));
    const __m128i fours = _mm_madd_epi16(_mm_maddubs_epi16(moved, usual_load(tables->pair)), usual_load(tables->four));
    const __m128i eights = _mm_madd_epi16(_mm_packus_epi32(fours, fours), usual_load(tables->eight));
    /* At most 15 digits: sum and power of ten are exact, and there is one rounding. */
    const __m128d parts = _mm_mul_pd(_mm_cvtepi32_pd(eights), _mm_loadu_pd(tables->upper));
    const __m128d sum = _mm_add_sd(parts, _mm_unpackhi_pd(parts, parts));
    const __m128d size = _mm_div_sd(sum, _mm_load_sd(&tables->place[place].power));
    *value = _mm_cvtsd_f64(_mm_or_pd(size, _mm_load_sd(&tables->sign[negative])));
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
