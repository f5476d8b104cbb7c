#include "dehyst.h"

#define STATE (UINT32_C(0x64684F00) + (uint32_t)sizeof(dehyst_real)) /* dhO, with the precision */
#define HEAD 6
#define REALS 6
#define MOST 1000000000 /* samples of a stroke: counts stay far from those of an int32_t */
#define SPOILT 7        /* a stroke counts if its good samples are so many times the others */

enum { /* phases */
    NOTHING_SEEN,
    NEVER_TURNED, /* nor moved by `turn` */
    FALLING,
    RISING
};

static dehyst_real size_of(dehyst_real x)
{
    return x < 0 ? -x : x;
}

static dehyst_real limited(dehyst_real x, dehyst_real most)
{
    return dehyst_within(x, -most, most);
}

void dehyst_offset_reset(dehyst_offset_state *state)
{
    state->target = 0;
    state->applied = 0;
    state->last = 0;
    state->extreme = 0;
    state->mean[0] = 0;
    state->mean[1] = 0;
    state->good[0] = 0;
    state->good[1] = 0;
    state->bad = MOST; /* what comes before the first turning point is no whole stroke */
    state->phase = NOTHING_SEEN;
}

dehyst_real dehyst_offset_next(const dehyst_offset *offset, const dehyst_offset_state *state, dehyst_real x, int on)
{
    if (state->phase == NOTHING_SEEN || !on || !dehyst_accept(x)) {
        return state->applied;
    }
    return dehyst_faded(state->applied, state->target, offset->part * size_of(x - state->last));
}

/* The stroke is over. With the one before it is a cycle, and that decides what is followed. */
static void end_stroke(const dehyst_offset *offset, dehyst_offset_state *state)
{
    const int whole = state->bad <= state->good[0] / SPOILT && state->good[0] > 0;
    if (whole && state->good[1] > 0) {
        const dehyst_real present = (dehyst_real)state->good[0];
        const dehyst_real before = (dehyst_real)state->good[1];
        const dehyst_real part = present / (present + before);
        state->target = limited(state->mean[1] + part * (state->mean[0] - state->mean[1]), offset->limit);
    }
    state->mean[1] = state->mean[0];
    state->good[1] = whole ? state->good[0] : 0;
    state->mean[0] = 0;
    state->good[0] = 0;
    state->bad = 0;
}

static void turn(const dehyst_offset *offset, dehyst_offset_state *state, dehyst_real x)
{
    const dehyst_real way = x - state->extreme;
    if (state->phase == NOTHING_SEEN) {
        state->extreme = x;
        state->phase = NEVER_TURNED;
    } else if (state->phase == NEVER_TURNED) {
        if (size_of(way) > offset->turn) {
            state->phase = way > 0 ? RISING : FALLING;
            state->extreme = x;
        }
    } else {
        const dehyst_real ahead = state->phase == RISING ? way : -way;
        const int on = ahead >= 0;
        const int turned = -ahead > offset->turn;
        if (turned) {
            end_stroke(offset, state);
            state->phase = state->phase == RISING ? FALLING : RISING;
        }
        state->extreme = (on || turned) ? x : state->extreme;
    }
}

dehyst_real dehyst_offset_step(const dehyst_offset *offset, dehyst_offset_state *state, dehyst_real x,
                               dehyst_real said, dehyst_real measured, dehyst_real share, uint32_t flags,
                               int on)
{
    if ((flags & (uint32_t)DEHYST_REJECTED) != 0u || !dehyst_accept(x) || !dehyst_accept(said)) {
        return state->applied;
    }
    const dehyst_real applied = dehyst_offset_next(offset, state, x, on);
    const int good = on && share >= 1 && (flags & (uint32_t)DEHYST_LIMITED) == 0u && dehyst_accept(measured);
    if (good && state->good[0] < MOST) {
        state->good[0] += 1;
        const dehyst_real more = (measured - said - state->mean[0]) / (dehyst_real)state->good[0];
        state->mean[0] = limited(state->mean[0] + more, DEHYST_INPUT_LIMIT);
    }
    state->bad += !good && state->bad < MOST ? 1 : 0;
    turn(offset, state, x);
    state->applied = applied;
    state->last = x;
    return applied;
}

void dehyst_offset_save(const dehyst_offset *offset, const dehyst_offset_state *state, uint32_t *image)
{
    const dehyst_real rest[REALS] = {state->target,  state->applied, state->last,
                                     state->extreme, state->mean[0], state->mean[1]};
    image[0] = STATE;
    image[1] = offset->fingerprint;
    image[2] = (uint32_t)state->phase;
    image[3] = (uint32_t)state->good[0];
    image[4] = (uint32_t)state->good[1];
    image[5] = (uint32_t)state->bad;
    (void)dehyst_image_put(image + HEAD, rest, REALS);
    image[DEHYST_OFFSET_WORDS - 1] = dehyst_image_sum(image, DEHYST_OFFSET_WORDS - 1);
}

int32_t dehyst_offset_restore(const dehyst_offset *offset, dehyst_offset_state *state, const uint32_t *image)
{
    dehyst_real rest[REALS];
    if (image[0] != STATE) {
        return DEHYST_IMAGE_KIND;
    }
    if (image[DEHYST_OFFSET_WORDS - 1] != dehyst_image_sum(image, DEHYST_OFFSET_WORDS - 1)) {
        return DEHYST_IMAGE_DAMAGED;
    }
    if (image[1] != offset->fingerprint) {
        return DEHYST_IMAGE_FOREIGN;
    }
    if (!dehyst_image_get(image + HEAD, rest, REALS) || size_of(rest[0]) > offset->limit ||
        size_of(rest[1]) > offset->limit || image[2] > RISING || image[3] > MOST || image[4] > MOST || image[5] > MOST) {
        return DEHYST_IMAGE_INVALID;
    }
    state->target = rest[0];
    state->applied = rest[1];
    state->last = rest[2];
    state->extreme = rest[3];
    state->mean[0] = rest[4];
    state->mean[1] = rest[5];
    state->phase = (int32_t)image[2];
    state->good[0] = (int32_t)image[3];
    state->good[1] = (int32_t)image[4];
    state->bad = (int32_t)image[5];
    return DEHYST_IMAGE_GOOD;
}
