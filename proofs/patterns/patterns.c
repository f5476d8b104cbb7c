/* Random patterns of bits through a block's step; compiled without -ffast-math, whatever the core is compiled with.
 *
 *     patterns SEED COUNT        prints samples, rejected, limited, switchings, faults, and a hash of all outputs
 *
 * An output is a fault if its bits are those of no number within the output range. Doubles: random patterns, and after
 * every third of them one of an ordinary size. Floats: pattern number k is k times an odd constant, so that 2^32
 * samples are every pattern there is. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "dehyst.h"
#include "parameters.h"

static uint64_t seed;

static uint64_t random_bits(void) /* splitmix64 */
{
    uint64_t x = seed += UINT64_C(0x9e3779b97f4a7c15);
    x = (x ^ (x >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    x = (x ^ (x >> 27)) * UINT64_C(0x94d049bb133111eb);
    return x ^ (x >> 31);
}

static uint64_t hash_of(uint64_t hash, dehyst_real y)
{
    uint64_t bits = 0;
    memcpy(&bits, &y, sizeof y);
    return (hash ^ bits) * UINT64_C(0x100000001b3);
}

/* Bits as an integer that grows with the number: infinities and NaNs lie outside every range. */
static int64_t rank(dehyst_real y)
{
#ifdef DEHYST_FLOAT
    int32_t bits;
    memcpy(&bits, &y, sizeof y);
    return bits < 0 ? -(int64_t)(bits & INT32_MAX) : bits;
#else
    int64_t bits;
    memcpy(&bits, &y, sizeof y);
    return bits < 0 ? -(bits & INT64_MAX) : bits;
#endif
}

static dehyst_real input(uint64_t k)
{
    dehyst_real x;
#ifdef DEHYST_FLOAT
    const uint32_t bits = (uint32_t)k * UINT32_C(2654435769);
#else
    uint64_t bits = random_bits();
    if (k % 4 == 3) { /* 2^-14 .. 4 */
        bits = (bits & UINT64_C(0x800fffffffffffff)) | ((1009 + ((bits >> 52) & 15)) << 52);
    }
#endif
    memcpy(&x, &bits, sizeof x);
    return x;
}

int main(int argc, char **argv)
{
    if (argc != 3) {
        return 2;
    }
    seed = strtoull(argv[1], 0, 10);
    const uint64_t count = strtoull(argv[2], 0, 10);
    const uint64_t first = seed * count; /* of floats: so that runs with the seeds 0, 1, .. have other patterns */
    const int64_t low = rank(OUTPUT_LOW);
    const int64_t high = rank(OUTPUT_HIGH);
    uint64_t rejected = 0, limited = 0, switched = 0, faults = 0, hash = UINT64_C(0xcbf29ce484222325), coins = 0;
    dehyst_block_state state = {{z, 0, 0}, 0, 0, 0, 0};
    int on = 1;
    dehyst_block_reset(&block, &state);
    for (uint64_t k = 0; k < count; ++k) {
        coins = coins * UINT64_C(6364136223846793005) + 1442695040888963407u;
        if ((coins >> 58) == 0) { /* one in 64 */
            on = !on;
            ++switched;
        }
        const dehyst_real y = dehyst_block_step(&block, &state, input(first + k), on);
        const int64_t place = rank(y);
        faults += place < low || place > high;
        rejected += (state.flags & DEHYST_REJECTED) != 0;
        limited += (state.flags & DEHYST_LIMITED) != 0;
        hash = hash_of(hash, y);
    }
    printf("%" PRIu64 " %" PRIu64 " %" PRIu64 " %" PRIu64 " %" PRIu64 " %016" PRIx64 "\n", count, rejected, limited,
           switched, faults, hash);
    return faults != 0;
}
