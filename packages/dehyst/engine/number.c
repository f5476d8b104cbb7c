/* Decimal to binary where one exact operation is not enough (Lemire, Number parsing at a gigabyte per second, 2021; that no
 * more is needed for a mantissa of 64 bits: Mushtak and Lemire, Fast number parsing without fallback, 2023). */
#include "number.h"

#include <math.h>
#include <string.h>

#include "powers.h"

/* More zeros than any text has bytes: beyond it everything is 0 or infinite. */
#define FAR_EXPONENT INT64_C(1000000000000000)

typedef struct wide {
    uint64_t high, low;
} wide;

static inline wide multiply(uint64_t a, uint64_t b)
{
#ifdef __SIZEOF_INT128__
    __extension__ typedef unsigned __int128 uint128;
    const uint128 product = (uint128)a * b;
    return (wide){(uint64_t)(product >> 64), (uint64_t)product};
#else
    const uint64_t mask = UINT32_MAX;
    const uint64_t ll = (a & mask) * (b & mask), lh = (a & mask) * (b >> 32);
    const uint64_t hl = (a >> 32) * (b & mask), hh = (a >> 32) * (b >> 32);
    const uint64_t middle = (ll >> 32) + (lh & mask) + (hl & mask);
    return (wide){hh + (lh >> 32) + (hl >> 32) + (middle >> 32), middle << 32 | (ll & mask)};
#endif
}

static inline int leading_zeros(uint64_t word)
{
#ifdef __GNUC__
    return __builtin_clzll(word);
#else
    int n = 0;
    for (; word >> 63 == 0; word <<= 1) {
        n++;
    }
    return n;
#endif
}

/* Nearest double to mantissa 10^exponent, mantissa > 0, exponent within the table: always a normal number. */
static double nearest(uint64_t mantissa, int exponent)
{
    const int zeros = leading_zeros(mantissa);
    const uint64_t *power = powers_of_five[exponent - POWERS_FIRST];
    wide product = multiply(mantissa << zeros, power[0]);
    if ((product.high & 0x1FF) == 0x1FF) { /* the lower half of the power may carry into the bits that count */
        const wide rest = multiply(mantissa << zeros, power[1]);
        product.low += rest.high;
        product.high += product.low < rest.high;
    }
    const int top = (int)(product.high >> 63);
    const int shift = top + 64 - 52 - 3;
    uint64_t bits = product.high >> shift; /* 54 bits: those of the double and one to round by */
    int binary = (((152170 + 65536) * exponent) >> 16) + 63 + top - zeros + 1023;
    /* Exactly half way only where 5^exponent, or its inverse, fits the mantissa: then to even. */
    if (product.low <= 1 && exponent >= -4 && exponent <= 23 && (bits & 3) == 1 && bits << shift == product.high) {
        bits &= ~UINT64_C(1);
    }
    bits = (bits + (bits & 1)) >> 1;
    if (bits >> 53 != 0) { /* rounded up to the next power of two */
        bits >>= 1;
        binary++;
    }
    bits = (bits & ((UINT64_C(1) << 52) - 1)) | (uint64_t)binary << 52;
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* The first 19 significant digits; returns how many behind them are not all 0, as 0 or 1. */
static int shorten(const number_parts *parts, char decimal, uint64_t *mantissa, int64_t *exponent)
{
    uint64_t m = 0;
    int64_t shift = 0;
    int kept = 0, cut = 0, fraction = 0;
    for (const char *p = parts->first; p < parts->end && *p != 'e' && *p != 'E'; p++) {
        if (*p == decimal) {
            fraction = 1;
            continue;
        }
        const int digit = *p - '0';
        if (kept == NUMBER_MOST_DIGITS) {
            cut |= digit != 0;
            shift += !fraction;
            continue;
        }
        m = m * 10 + (uint64_t)digit;
        kept += m != 0;
        shift -= fraction;
    }
    *mantissa = m;
    *exponent = shift;
    return cut;
}

double number_hard(const number_parts *parts, char decimal, text_exact exact, void *context)
{
    uint64_t mantissa = parts->mantissa;
    int64_t exponent = parts->exponent;
    int cut = 0;
    if (parts->digits > NUMBER_MOST_DIGITS) {
        const char *p = parts->first;
        int64_t written = 0;
        for (; p < parts->end && *p != 'e' && *p != 'E'; p++) {
        }
        if (p < parts->end) {
            number_exponent(p + 1, parts->end, &written);
        }
        cut = shorten(parts, decimal, &mantissa, &exponent);
        exponent += written;
    }
    if (mantissa == 0) {
        return 0.0;
    }
    if (exponent >= POWERS_FIRST && exponent <= POWERS_LAST) {
        const double value = nearest(mantissa, (int)exponent);
        /* Digits cut off lie between this mantissa and the next. */
        if (!cut || value == nearest(mantissa + 1, (int)exponent)) {
            return value;
        }
    }
    return fabs(exact(parts->start, (size_t)(parts->end - parts->start), context));
}

const char *number_exponent(const char *p, const char *end, int64_t *exponent)
{
    const int negative = p < end && *p == '-';
    p += negative || (p < end && *p == '+');
    if (p == end || *p < '0' || *p > '9') {
        return NULL;
    }
    int64_t e = 0;
    for (; p < end && *p >= '0' && *p <= '9'; p++) {
        e = e < FAR_EXPONENT ? 10 * e + (*p - '0') : e;
    }
    *exponent += negative ? -e : e;
    return p;
}

/* Whether the word (in small letters) stands at p, in any case; returns behind it, or a null pointer. */
static const char *match(const char *p, const char *end, const char *word)
{
    for (; *word != '\0'; p++, word++) {
        if (p == end || (*p | 0x20) != *word) {
            return NULL;
        }
    }
    return p;
}

const char *number_word(const char *p, const char *end, double *value)
{
    const char *behind = match(p, end, "nan");
    *value = behind != NULL ? (double)NAN : (double)INFINITY;
    if (behind != NULL) {
        return behind;
    }
    behind = match(p, end, "inf");
    const char *longer = behind != NULL ? match(behind, end, "inity") : NULL;
    return longer != NULL ? longer : behind;
}

size_t text_number(const char *text, size_t size, char decimal, text_exact exact, void *context, double *value)
{
    const char *behind = number_read(text, text + size, decimal, exact, context, value);
    return behind == NULL ? 0 : (size_t)(behind - text);
}
