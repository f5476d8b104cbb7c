/* A block of elements of every kind: from a reset, and from any memory within DEHYST_INPUT_LIMIT, one sample leads to
 * such a state, be it stepped or observed. So does any sequence of them, each of them any real, NaN and the infinities among them, and any
 * switching. Only the last input is kept to a range, farther than any input of this block: the analyser does not see
 * that 0 times a power of the way is 0 where that power may be infinite. */
#include "elements.h"

#include "__fc_builtin.h"

/*@ assigns \result \from \nothing; */
extern dehyst_real any_real(void);

#define DELAY 3
#ifdef DEHYST_FLOAT
#define FAR 0x1p50f
#else
#define FAR 0x1p333
#endif /* a power of two just beyond DEHYST_INPUT_LIMIT */
#ifndef LAST
#define LAST 0x1p20
#endif
#define LATE 2 /* what the ring holds lies between: -(1.5 - 0.5)/2 .. (2 + 0.5)/2 */
#define OUTPUT_LOW ((dehyst_real)-3)
#define OUTPUT_HIGH ((dehyst_real)2.5)

static const dehyst_real start[ELEMENTS] = {0, RADIUS, -RADIUS, 0, 0, 0, RADIUS, 0};
static const dehyst_element_block block = {
    SUM, SOLVES, DELAY, start,
    (dehyst_real)0.375, 0,                        /* echo, origin */
    (dehyst_real)0.5, -2,                         /* center, half range */
    (dehyst_real)0.25, 3,                         /* level, amplitude */
    -2, (dehyst_real)1.5, OUTPUT_LOW, OUTPUT_HIGH, -REACH, REACH,
    (dehyst_real)-0.5, (dehyst_real)0.25,         /* line */
    (dehyst_real)0.0625, 1};
static dehyst_real ring[DELAY];
static dehyst_element_block_state state;

static dehyst_real any_within(dehyst_real low, dehyst_real high)
{
    const dehyst_real x = any_real();
    //@ admit \is_finite(x) && low <= x <= high;
    return x;
}

int main(void)
{
    state.sum.z = memory;
    state.delay.ring = ring;
    dehyst_element_block_reset(&block, &state);
    if (Frama_C_nondet(0, 1)) {
        for (int32_t k = 0; k < ELEMENTS; ++k) {
            memory[k] = any_within(-FAR, FAR);
        }
        for (int32_t i = 0; i < DELAY; ++i) {
            ring[i] = any_within(-LATE, LATE);
        }
        state.delay.at = Frama_C_interval(0, DELAY - 1);
        state.sum.last = any_within(-LAST, LAST);
        state.sum.step = any_within(-FAR, FAR);
        state.share = any_within(0, 1);
        state.output = any_within(OUTPUT_LOW, OUTPUT_HIGH);
        state.least = any_within(-LAST, LAST);
        state.most = any_within(-LAST, LAST);
        state.flags = Frama_C_unsigned_int_interval(0, 15);
        state.started = Frama_C_interval(0, 1);
    }
    const dehyst_real given[DEHYST_GIVEN] = {any_real(), any_real(), any_real()};
    if (Frama_C_nondet(0, 1)) {
        dehyst_element_block_observe(&block, &state, any_real(), any_real(), given);
    } else {
        const dehyst_real y = dehyst_element_block_step(&block, &state, any_real(), given, Frama_C_nondet(0, 1));
        //@ assert output: \is_finite(y) && OUTPUT_LOW <= y <= OUTPUT_HIGH;
    }
    //@ assert held: \is_finite(state.output) && OUTPUT_LOW <= state.output <= OUTPUT_HIGH;
    //@ assert share: \is_finite(state.share) && 0 <= state.share <= 1;
    //@ assert last: \is_finite(state.sum.last) && -LAST <= state.sum.last <= LAST;
    //@ assert known: \is_finite(state.least) && \is_finite(state.most) && -LAST <= state.least && state.most <= LAST;
    //@ assert step: \is_finite(state.sum.step) && -FAR <= state.sum.step <= FAR;
    for (int32_t k = 0; k < ELEMENTS; ++k) {
        //@ assert memory: \is_finite(memory[k]) && -FAR <= memory[k] <= FAR;
    }
    for (int32_t i = 0; i < DELAY; ++i) {
        //@ assert ring: \is_finite(ring[i]) && -LATE <= ring[i] <= LATE;
    }
    //@ assert place: 0 <= state.delay.at < DELAY;
    //@ assert flags: state.flags <= 15;
    //@ assert begun: 0 <= state.started <= 1;
    return 0;
}
