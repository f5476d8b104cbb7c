#include <stddef.h>

#include "dehyst.h"

#define KIND (UINT32_C(0x64684a00) + (uint32_t)sizeof(dehyst_real)) /* dhJ */
#define REALS 40
#define COUNTS 10

/* Every number of the state, but for the compensator's plays, in a fixed order. */
#define AT(member) offsetof(dehyst_joint_state, member)
static const size_t where[REALS] = {
    AT(compensator.output), AT(observer.angle), AT(observer.velocity), AT(observer.load), AT(angle.last),
    AT(muscle[0].last), AT(muscle[1].last), AT(travel), AT(travel_most), AT(pressure[0]), AT(pressure[1]),
    AT(desired[0]), AT(desired[1]), AT(feedforward[0]), AT(feedforward[1]), AT(rate[0]), AT(rate[1]),
    AT(expected[0]), AT(expected[1]), AT(at.a), AT(at.b), AT(at.c), AT(torque), AT(pressure_difference),
    AT(compensator_share), AT(integrator.value), AT(integrator.step), AT(difference.value), AT(difference.step),
    AT(mean.value), AT(mean.step), AT(exchanged.value), AT(exchanged.step), AT(reference.angle),
    AT(reference.velocity), AT(reference.acceleration), AT(reference.load), AT(reference.mean_pressure),
    AT(reference.pressure_difference), AT(reference.extra),
};

static void put_counts(const dehyst_joint_state *state, uint32_t *count)
{
    count[0] = (uint32_t)state->angle.equal;
    count[1] = (uint32_t)state->angle.faulty;
    count[2] = (uint32_t)state->muscle[0].equal;
    count[3] = (uint32_t)state->muscle[0].faulty;
    count[4] = (uint32_t)state->muscle[1].equal;
    count[5] = (uint32_t)state->muscle[1].faulty;
    count[6] = state->switches;
    count[7] = state->flags;
    count[8] = (uint32_t)state->started;
    count[9] = state->compensator.flags;
}

static int counts_are_good(const uint32_t *count)
{
    int good = 1;
    for (int32_t i = 0; i < 6; ++i) {
        good = good && count[i] <= (uint32_t)INT32_MAX;
    }
    return good && count[8] <= 1 && (count[7] & ~((uint32_t)DEHYST_FAILED | (uint32_t)DEHYST_FAULT_EVER)) == 0 &&
           (count[9] & ~((uint32_t)DEHYST_REJECTED | (uint32_t)DEHYST_REJECTED_EVER)) == 0;
}

static void take_counts(dehyst_joint_state *state, const uint32_t *count)
{
    state->angle.equal = (int32_t)count[0];
    state->angle.faulty = (int32_t)count[1];
    state->muscle[0].equal = (int32_t)count[2];
    state->muscle[0].faulty = (int32_t)count[3];
    state->muscle[1].equal = (int32_t)count[4];
    state->muscle[1].faulty = (int32_t)count[5];
    state->switches = count[6];
    state->flags = count[7];
    state->started = (int32_t)count[8];
    state->compensator.flags = count[9];
}

static int32_t operators(const dehyst_joint *joint)
{
    return joint->compensator ? joint->compensator->hysteresis.n : 0;
}

int32_t dehyst_joint_save(const dehyst_joint *joint, const dehyst_joint_state *state, uint32_t fingerprint,
                          uint32_t *image, int32_t words)
{
    const int32_t n = operators(joint);
    if (words != DEHYST_JOINT_WORDS(n)) {
        return DEHYST_IMAGE_SIZE;
    }
    image[0] = KIND;
    image[1] = (uint32_t)n;
    image[2] = fingerprint;
    put_counts(state, image + 3);
    uint32_t *at = image + 3 + COUNTS;
    for (int32_t i = 0; i < REALS; ++i) {
        at = dehyst_image_put(at, (const dehyst_real *)((const unsigned char *)state + where[i]), 1);
    }
    (void)dehyst_image_put(at, state->compensator.z, n);
    image[words - 1] = dehyst_image_sum(image, words - 1);
    return DEHYST_IMAGE_GOOD;
}

static int32_t checked_head(const uint32_t *image, int32_t words, int32_t n, uint32_t fingerprint)
{
    if (words != DEHYST_JOINT_WORDS(n)) {
        return DEHYST_IMAGE_SIZE;
    }
    if (image[0] != KIND) {
        return DEHYST_IMAGE_KIND;
    }
    if (image[words - 1] != dehyst_image_sum(image, words - 1)) {
        return DEHYST_IMAGE_DAMAGED;
    }
    if (image[1] != (uint32_t)n || image[2] != fingerprint) {
        return DEHYST_IMAGE_FOREIGN;
    }
    return counts_are_good(image + 3) ? DEHYST_IMAGE_GOOD : DEHYST_IMAGE_INVALID;
}

static int reals_are_good(const dehyst_joint *joint, const uint32_t *at)
{
    const dehyst_real low = joint->pressure_low;
    const dehyst_real high = joint->pressure_high > low ? joint->pressure_high : low;
    int good = 1;
    for (int32_t i = 0; i < REALS; ++i) {
        dehyst_real value = 0;
        good = dehyst_image_get(at + i * DEHYST_REAL_WORDS, &value, 1) != 0 && good;
        good = good && (where[i] != AT(compensator_share) || (value >= 0 && value <= 1));
        good = good && (where[i] != AT(at.b) || value > 0);
        const int desired = where[i] == AT(desired[0]) || where[i] == AT(desired[1]);
        good = good && (!desired || (value >= low && value <= high));
    }
    return good;
}

/* A term that fades gets smaller and is gone some day. */
static int fade_is_good(const uint32_t *at)
{
    dehyst_real pair[2] = {0, 0}; /* value, step */
    const int numbers = dehyst_image_get(at, pair, 2) != 0;
    const dehyst_real value = pair[0] < 0 ? -pair[0] : pair[0];
    const dehyst_real step = pair[1] < 0 ? -pair[1] : pair[1];
    return numbers && (step >= value || value - step < value);
}

static int fades_are_good(const uint32_t *at)
{
    static const size_t fades[4] = {AT(integrator.value), AT(difference.value), AT(mean.value), AT(exchanged.value)};
    int good = 1;
    for (int32_t i = 0; i < REALS; ++i) {
        for (int32_t k = 0; k < 4; ++k) {
            good = good && (where[i] != fades[k] || fade_is_good(at + i * DEHYST_REAL_WORDS));
        }
    }
    return good;
}

/* The plays of the image are admissible; looked at two at a time, because there is no memory for all of them. */
static int plays_are_good(const dehyst_joint *joint, const uint32_t *at)
{
    dehyst_real pair[2] = {0, 0};
    for (int32_t i = 0; i < operators(joint); ++i) {
        pair[0] = pair[1];
        if (!dehyst_image_get(at + i * DEHYST_REAL_WORDS, &pair[1], 1)) {
            return 0;
        }
        if (i > 0 && !dehyst_admissible(2, joint->compensator->hysteresis.threshold + (i - 1), pair)) {
            return 0;
        }
    }
    return 1;
}

int32_t dehyst_joint_restore(const dehyst_joint *joint, dehyst_joint_state *state, uint32_t fingerprint,
                             const uint32_t *image, int32_t words)
{
    const int32_t n = operators(joint);
    const int32_t fault = checked_head(image, words, n, fingerprint);
    if (fault != DEHYST_IMAGE_GOOD) {
        return fault;
    }
    const uint32_t *reals = image + 3 + COUNTS;
    const uint32_t *plays = reals + REALS * DEHYST_REAL_WORDS;
    if (!reals_are_good(joint, reals) || !fades_are_good(reals) || !plays_are_good(joint, plays)) {
        return DEHYST_IMAGE_INVALID;
    }
    for (int32_t i = 0; i < REALS; ++i) {
        (void)dehyst_image_get(reals + i * DEHYST_REAL_WORDS, (dehyst_real *)((unsigned char *)state + where[i]), 1);
    }
    (void)dehyst_image_get(plays, state->compensator.z, n);
    take_counts(state, image + 3);
    return DEHYST_IMAGE_GOOD;
}
