#include "dehyst.h"

/* A comparison with a constant is deleted by -ffast-math; an integer test of the exponent is not. */
#ifdef DEHYST_FLOAT
#define BITS uint32_t
#define MAGNITUDE UINT32_C(0x7fffffff)
#else
#define BITS uint64_t
#define MAGNITUDE UINT64_C(0x7fffffffffffffff)
#endif

typedef union pattern {
    dehyst_real real;
    BITS bits;
} pattern;

/* Magnitudes of IEEE numbers order like their bits; infinities and NaNs lie above all others. */
static inline int accepted(dehyst_real x)
{
    pattern value;
    pattern limit;
    value.real = x;
    limit.real = DEHYST_INPUT_LIMIT;
    return (value.bits & MAGNITUDE) <= limit.bits;
}

int dehyst_accept(dehyst_real x) { return accepted(x); }

int dehyst_accept_given(const dehyst_real given[DEHYST_GIVEN])
{
    return accepted(given[0]) && accepted(given[1]) && accepted(given[2]);
}
