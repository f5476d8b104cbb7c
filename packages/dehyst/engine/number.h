/* A decimal number in text to the nearest double: digits eight at a time, then one exact operation or one product. */
#ifndef DEHYST_ENGINE_NUMBER_H
#define DEHYST_ENGINE_NUMBER_H

#include <float.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "text.h"

/* For what is rare, so that it does not take registers from what is not. */
#ifdef __GNUC__
#define NUMBER_APART __attribute__((noinline))
#else
#define NUMBER_APART
#endif

/* Largest power of ten that is a double, and largest integer below which all are. */
enum { NUMBER_EXACT_POWER = 22, NUMBER_MOST_DIGITS = 19 };
#define NUMBER_EXACT_INTEGER (UINT64_C(1) << 53)

static const double number_ten[NUMBER_EXACT_POWER + 1] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                                         1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                                         1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
static const uint64_t number_tens[9] = {1, 10, 100, 1000, 10000, 100000, 1000000, 10000000, 100000000};

/* What is known of a number once its digits are read: mantissa 10^exponent, wrong if there are more than 19 digits. */
typedef struct number_parts {
    const char *start, *first, *end; /* with sign, first digit or point, behind the number */
    uint64_t mantissa;
    int64_t exponent;
    ptrdiff_t digits;
    int negative;
} number_parts;

/* Numbers that the short way cannot tell: many digits, large exponents. */
double number_hard(const number_parts *parts, char decimal, text_exact exact, void *context);
/* Numbers with an exponent: returns behind it, or a null pointer. */
const char *number_exponent(const char *p, const char *end, int64_t *exponent);
/* nan, inf, infinity without sign: returns behind it, or a null pointer. */
const char *number_word(const char *p, const char *end, double *value);

/* Eight bytes, the first one lowest. */
static inline uint64_t number_load8(const char *p)
{
#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
    uint64_t word;
    memcpy(&word, p, sizeof word);
    return word;
#else
    const unsigned char *b = (const unsigned char *)p;
    return (uint64_t)b[0] | (uint64_t)b[1] << 8 | (uint64_t)b[2] << 16 | (uint64_t)b[3] << 24 | (uint64_t)b[4] << 32 |
           (uint64_t)b[5] << 40 | (uint64_t)b[6] << 48 | (uint64_t)b[7] << 56;
#endif
}

/* Index of the lowest bit that is set. */
static inline unsigned number_lowest(uint64_t bits)
{
#ifdef __GNUC__
    return (unsigned)__builtin_ctzll(bits);
#else
    unsigned n = 0;
    for (; (bits & 1) == 0; bits >>= 1) {
        n++;
    }
    return n;
#endif
}

/* The same with 0 behind the end. */
static inline uint64_t number_load(const char *p, const char *end)
{
    if (end - p >= 8) {
        return number_load8(p);
    }
    uint64_t word = 0;
    for (int shift = 0; p < end; p++, shift += 8) {
        word |= (uint64_t)(unsigned char)*p << shift;
    }
    return word;
}

/* Value of eight digits 0..9, the first one in the lowest byte. */
static inline uint64_t number_eight(uint64_t digits)
{
    const uint64_t pairs = digits * 10 + (digits >> 8);
    const uint64_t mask = UINT64_C(0x000000FF000000FF);
    return ((pairs & mask) * UINT64_C(0x000F424000000064) + ((pairs >> 16) & mask) * UINT64_C(0x0000271000000001)) >> 32;
}

/* Bit 0x80 of the bytes of a word, xor 0x3030303030303030, that are no digits: right up to the first of them; above it a
 * carry may have gone astray. */
static inline uint64_t number_others(uint64_t x)
{
    return ((x + UINT64_C(0x7676767676767676)) | x) & UINT64_C(0x8080808080808080);
}

/* Append the digits at p to the mantissa (modulo 2^64); returns behind them. */
static inline const char *number_digits(const char *p, const char *end, uint64_t *mantissa)
{
    uint64_t m = *mantissa;
    for (;;) {
        const uint64_t x = number_load(p, end) ^ UINT64_C(0x3030303030303030);
        const uint64_t others = number_others(x);
        if (others != 0) {
            const unsigned n = number_lowest(others) / 8;
            *mantissa = m * number_tens[n] + number_eight(x << (56 - 8 * n) << 8);
            return p + n;
        }
        m = m * 100000000 + number_eight(x);
        p += 8;
    }
}

/* Read a number; returns behind it, or a null pointer. */
static inline const char *number_read(const char *p, const char *end, char decimal, text_exact exact, void *context,
                                      double *value)
{
    number_parts n = {.start = p};
    n.negative = p < end && *p == '-';
    p += n.negative || (p < end && *p == '+');
    n.first = p;
    p = number_digits(p, end, &n.mantissa);
    n.digits = p - n.first;
    if (p < end && *p == decimal) {
        const char *fraction = p + 1;
        p = number_digits(fraction, end, &n.mantissa);
        n.exponent = fraction - p;
        n.digits += p - fraction;
    }
    if (n.digits == 0) {
        p = p == n.first ? number_word(p, end, value) : NULL;
        if (p != NULL && n.negative) {
            *value = -*value;
        }
        return p;
    }
    if (p < end && (*p == 'e' || *p == 'E')) {
        p = number_exponent(p + 1, end, &n.exponent);
        if (p == NULL) {
            return NULL;
        }
    }
    double v;
    if (n.digits <= NUMBER_MOST_DIGITS && n.mantissa <= NUMBER_EXACT_INTEGER && n.exponent <= NUMBER_EXACT_POWER &&
        n.exponent >= -NUMBER_EXACT_POWER && FLT_EVAL_METHOD == 0) {
        v = (double)(int64_t)n.mantissa; /* exact, as is the power of ten: one rounding */
        v = n.exponent < 0 ? v / number_ten[-n.exponent] : v * number_ten[n.exponent];
    } else {
        n.end = p;
        v = number_hard(&n, decimal, exact, context);
    }
    *value = n.negative ? -v : v;
    return p;
}

#endif
