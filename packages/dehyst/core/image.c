#include "dehyst.h"

#ifdef DEHYST_FLOAT
#define BITS uint32_t
#else
#define BITS uint64_t
#endif

typedef union pattern {
    dehyst_real real;
    BITS bits;
} pattern;

uint32_t dehyst_image_sum(const uint32_t *words, int32_t count)
{
    uint32_t sum = UINT32_C(0xffffffff);
    for (int32_t i = 0; i < count; ++i) {
        sum ^= words[i];
        for (int32_t bit = 0; bit < 32; ++bit) {
            sum = (sum >> 1) ^ ((sum & 1u) ? UINT32_C(0xedb88320) : 0u);
        }
    }
    return ~sum;
}

uint32_t *dehyst_image_put(uint32_t *at, const dehyst_real *values, int32_t n)
{
    for (int32_t i = 0; i < n; ++i) {
        pattern value;
        value.real = values[i];
        *at++ = (uint32_t)(value.bits & UINT32_C(0xffffffff));
#ifndef DEHYST_FLOAT
        *at++ = (uint32_t)(value.bits >> 32);
#endif
    }
    return at;
}

const uint32_t *dehyst_image_get(const uint32_t *at, dehyst_real *values, int32_t n)
{
    int good = 1;
    for (int32_t i = 0; i < n; ++i) {
        pattern value;
        value.bits = *at++;
#ifndef DEHYST_FLOAT
        value.bits |= (uint64_t)*at++ << 32;
#endif
        good = good && dehyst_accept(value.real);
        values[i] = value.real;
    }
    return good ? at : 0;
}
