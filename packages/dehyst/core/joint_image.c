#include <stddef.h>

#include "dehyst.h"

#define KIND (UINT32_C(0x64684a00) + (uint32_t)sizeof(dehyst_real)) /* dhJ */
#define REALS 40
#define COUNTS 12

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

/* Those of a direct inverse: where, and how many in a row. */
typedef struct span {
    size_t offset;
    int32_t count;
} span;
#define SPANS 27
static const span fit_reals = {AT(fit), DEHYST_FIT_REALS};
static const span direct_reals[SPANS] = {
    {AT(wanted.last), 1}, {AT(wanted.curve), 1}, {AT(wanted.part), DEHYST_GROUPS}, {AT(wanted.doubt), DEHYST_GROUPS},
    {AT(seen.last), 1}, {AT(seen.curve), 1}, {AT(seen.part), DEHYST_GROUPS}, {AT(seen.doubt), DEHYST_GROUPS},
    {AT(delayed.curve), 3}, {AT(delayed.part), 3 * DEHYST_GROUPS}, {AT(learning.scale), DEHYST_GROUPS}, {AT(learning.applied), DEHYST_GROUPS},
    {AT(learning.curve), 1},
    {AT(learning.offset), 1}, {AT(learning.applied_offset), 1}, {AT(learning.error), 1},
    {AT(learning.error_before), 1}, {AT(learning.usual), 1}, {AT(learning.resting), 1}, {AT(torque_direct), 1},
    {AT(learning.settled), 1}, {AT(learning.large), 1}, {AT(learning.held), 1}, {AT(learning.tried), DEHYST_GROUPS},
    {AT(contact), 1}, {AT(disturbance), 1},
    {AT(disturbance_share), 1},
};

static dehyst_real *member(dehyst_joint_state *state, size_t place)
{
    return (dehyst_real *)((unsigned char *)state + place);
}

static const dehyst_real *member_of(const dehyst_joint_state *state, size_t place)
{
    return (const dehyst_real *)((const unsigned char *)state + place);
}

static void put_counts(const dehyst_joint *joint, const dehyst_joint_state *state, uint32_t *count)
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
    count[10] = joint->direct ? state->wanted.flags : 0u;
    count[11] = joint->direct ? state->seen.flags : 0u;
}

static int counts_are_good(const uint32_t *count)
{
    const uint32_t sample = (uint32_t)DEHYST_REJECTED | (uint32_t)DEHYST_REJECTED_EVER | (uint32_t)DEHYST_LIMITED |
                            (uint32_t)DEHYST_LIMITED_EVER;
    int good = (count[10] & ~sample) == 0 && (count[11] & ~sample) == 0;
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
    state->wanted.flags = count[10];
    state->seen.flags = count[11];
}

static int32_t operators(const dehyst_joint *joint)
{
    return joint->compensator ? joint->compensator->hysteresis.n : 0;
}

/* Memory of one of the two, -1 without a direct inverse. */
static int32_t direct_memory(const dehyst_joint *joint)
{
    const dehyst_direct *direct = joint->direct;
    return direct ? DEHYST_DIRECT_REALS(direct->stops, direct->paths, direct->creeps) : -1;
}

static uint32_t *put_direct(const dehyst_joint *joint, const dehyst_joint_state *state, uint32_t *at)
{
    if (joint->direct) {
        for (int32_t i = 0; i < SPANS; ++i) {
            at = dehyst_image_put(at, member_of(state, direct_reals[i].offset), direct_reals[i].count);
        }
        at = dehyst_image_put(at, state->wanted.memory, direct_memory(joint));
        at = dehyst_image_put(at, state->seen.memory, direct_memory(joint));
    }
    return at;
}

int32_t dehyst_joint_save(const dehyst_joint *joint, const dehyst_joint_state *state, uint32_t fingerprint,
                          uint32_t *image, int32_t words)
{
    const int32_t n = operators(joint);
    if (words != DEHYST_JOINT_WORDS(n, direct_memory(joint))) {
        return DEHYST_IMAGE_SIZE;
    }
    image[0] = KIND;
    image[1] = (uint32_t)n;
    image[2] = fingerprint;
    put_counts(joint, state, image + 3);
    uint32_t *at = image + 3 + COUNTS;
    for (int32_t i = 0; i < REALS; ++i) {
        at = dehyst_image_put(at, member_of(state, where[i]), 1);
    }
    at = dehyst_image_put(at, member_of(state, fit_reals.offset), fit_reals.count);
    at = dehyst_image_put(at, state->compensator.z, n);
    (void)put_direct(joint, state, at);
    image[words - 1] = dehyst_image_sum(image, words - 1);
    return DEHYST_IMAGE_GOOD;
}

static int32_t checked_head(const uint32_t *image, int32_t words, int32_t n, int32_t memory, uint32_t fingerprint)
{
    if (words != DEHYST_JOINT_WORDS(n, memory)) {
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

/* The next number of an image, which must lie within low .. high; something else, or what is none, is a fault. */
static int next_within(const uint32_t **at, dehyst_real low, dehyst_real high)
{
    dehyst_real value = 0;
    const int number = dehyst_image_get(*at, &value, 1) != 0;
    *at += DEHYST_REAL_WORDS;
    return number && value >= low && value <= high;
}

/* Memory that some y can have left: plays within a radius of y, the lowest not above the highest; R within its length. */
static int memory_is_good(const dehyst_direct *direct, dehyst_real last, const uint32_t *at)
{
    const dehyst_real slack = 1 + (dehyst_real)1e-5; /* rounding of y -+ r */
    const uint32_t *highest = at + direct->stops * DEHYST_REAL_WORDS;
    const dehyst_real rounding = (slack - 1) * (last < 0 ? -last : last);
    int good = 1;
    for (int32_t i = 0; i < direct->stops; ++i) {
        const dehyst_real r = slack * direct->radius[i] + rounding;
        dehyst_real low = 0;
        good = dehyst_image_get(at, &low, 1) != 0 && good;
        good = next_within(&at, last - r, last + r) && good;
        good = next_within(&highest, low, last + r) && good;
    }
    at = highest;
    for (int32_t k = 0; k < 2 * direct->paths; ++k) {
        const dehyst_real x = slack * direct->length[k < direct->paths ? k : k - direct->paths];
        good = next_within(&at, k < direct->paths ? -x : (dehyst_real)0, x) && good;
    }
    for (int32_t j = 0; j < 2 * direct->creeps; ++j) {
        good = next_within(&at, j < direct->creeps ? -DEHYST_INPUT_LIMIT : (dehyst_real)0, DEHYST_INPUT_LIMIT) && good;
    }
    return good;
}

/* All of them are numbers, and the scale in use is one. */
static int fit_is_good(const uint32_t *at)
{
    int good = 1;
    for (int32_t i = 0; i < DEHYST_FIT_REALS; ++i) {
        const int scale = AT(fit) + (size_t)i * sizeof(dehyst_real) == AT(fit.scale);
        good = next_within(&at, scale ? (dehyst_real)0 : -DEHYST_INPUT_LIMIT, scale ? (dehyst_real)1 : DEHYST_INPUT_LIMIT) && good;
    }
    return good;
}

static int direct_is_good(const dehyst_joint *joint, const uint32_t *at)
{
    if (!joint->direct) {
        return 1;
    }
    const dehyst_adaptation *learning = &joint->adaptation;
    dehyst_real last[2] = {0, 0};
    int good = 1;
    for (int32_t i = 0; i < SPANS; ++i) {
        const size_t place = direct_reals[i].offset;
        dehyst_real low = -DEHYST_INPUT_LIMIT;
        dehyst_real high = DEHYST_INPUT_LIMIT;
        if (place == AT(learning.scale) || place == AT(learning.applied)) {
            low = learning->lowest < 1 ? learning->lowest : (dehyst_real)1; /* an adaptation that is off has no bounds */
            low = place == AT(learning.applied) && low > 0 ? (dehyst_real)0 : low; /* a model that does not fit */
            high = learning->highest > 1 ? learning->highest : (dehyst_real)1;
        } else if (place == AT(learning.offset) || place == AT(learning.applied_offset)) {
            low = -learning->offset_limit;
            high = learning->offset_limit;
        } else if (place == AT(disturbance_share) || place == AT(learning.curve)) {
            low = 0;
            high = 1;
        } else if (place == AT(learning.error) || place == AT(learning.error_before) || place == AT(learning.usual) ||
                   place == AT(learning.large) || place == AT(learning.held) || place == AT(learning.tried)) {
            low = 0;
        } else if (place == AT(learning.resting)) {
            low = 0;
            high = learning->rest;
        } else if (place == AT(learning.settled)) {
            low = 0;
            high = 2 * learning->settling;
        } else if (place == AT(torque_direct) || place == AT(disturbance)) {
            low = -DEHYST_TORQUE_LIMIT;
            high = DEHYST_TORQUE_LIMIT;
        } else if (place == AT(wanted.last) || place == AT(seen.last)) {
            good = dehyst_image_get(at, &last[place == AT(seen.last)], 1) != 0 && good;
        }
        for (int32_t k = 0; k < direct_reals[i].count; ++k) {
            good = next_within(&at, low, high) && good;
        }
    }
    const int32_t words = direct_memory(joint) * DEHYST_REAL_WORDS;
    return good && memory_is_good(joint->direct, last[0], at) && memory_is_good(joint->direct, last[1], at + words);
}

static void take_direct(const dehyst_joint *joint, dehyst_joint_state *state, const uint32_t *at)
{
    if (joint->direct) {
        for (int32_t i = 0; i < SPANS; ++i) {
            (void)dehyst_image_get(at, member(state, direct_reals[i].offset), direct_reals[i].count);
            at += direct_reals[i].count * DEHYST_REAL_WORDS;
        }
        (void)dehyst_image_get(at, state->wanted.memory, direct_memory(joint));
        at += direct_memory(joint) * DEHYST_REAL_WORDS;
        (void)dehyst_image_get(at, state->seen.memory, direct_memory(joint));
    }
}

int32_t dehyst_joint_restore(const dehyst_joint *joint, dehyst_joint_state *state, uint32_t fingerprint,
                             const uint32_t *image, int32_t words)
{
    const int32_t n = operators(joint);
    const int32_t fault = checked_head(image, words, n, direct_memory(joint), fingerprint);
    if (fault != DEHYST_IMAGE_GOOD) {
        return fault;
    }
    const uint32_t *reals = image + 3 + COUNTS;
    const uint32_t *fit = reals + REALS * DEHYST_REAL_WORDS;
    const uint32_t *plays = fit + fit_reals.count * DEHYST_REAL_WORDS;
    const uint32_t *direct = plays + n * DEHYST_REAL_WORDS;
    if (!reals_are_good(joint, reals) || !fit_is_good(fit) || !fades_are_good(reals) || !plays_are_good(joint, plays) ||
        !direct_is_good(joint, direct)) {
        return DEHYST_IMAGE_INVALID;
    }
    for (int32_t i = 0; i < REALS; ++i) {
        (void)dehyst_image_get(reals + i * DEHYST_REAL_WORDS, member(state, where[i]), 1);
    }
    (void)dehyst_image_get(fit, member(state, fit_reals.offset), fit_reals.count);
    (void)dehyst_image_get(plays, state->compensator.z, n);
    take_direct(joint, state, direct);
    take_counts(state, image + 3);
    return DEHYST_IMAGE_GOOD;
}
