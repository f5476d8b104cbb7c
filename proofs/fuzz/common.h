/* What the fuzzers share: numbers out of bytes, and a claim that stops the run when it is wrong. */
#ifndef COMMON_H
#define COMMON_H

#include <stdint.h>
#include <string.h>

#include "dehyst.h"

#define CLAIM(truth)                                                                                                  \
    do {                                                                                                              \
        if (!(truth)) __builtin_trap();                                                                               \
    } while (0)

typedef struct bytes {
    const uint8_t *at;
    size_t left;
} bytes;

/* The next bytes; zeros when they run out. */
static void take(bytes *from, void *to, size_t count)
{
    const size_t some = from->left < count ? from->left : count;
    memset(to, 0, count);
    memcpy(to, from->at, some);
    from->at += some;
    from->left -= some;
}

static uint8_t take_byte(bytes *from)
{
    uint8_t byte;
    take(from, &byte, 1);
    return byte;
}

/* Every pattern of bits; one byte makes a plain number, so that a short input goes far. */
static dehyst_real take_real(bytes *from)
{
    dehyst_real value;
    const uint8_t kind = take_byte(from);
    if (kind < 248) {
        return ((dehyst_real)kind - 124) / 64;
    }
    take(from, &value, sizeof value);
    return value;
}

static inline int same(dehyst_real a, dehyst_real b) { return memcmp(&a, &b, sizeof a) == 0; }

static inline int within(dehyst_real x, dehyst_real low, dehyst_real high) { return x >= low && x <= high; }

#endif
