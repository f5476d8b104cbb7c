/* What the core says of itself, each with the answer that its text promises: no recorded bits. Prints what does not hold.
 * Rows of numbers are as long as they must be, so that a sanitizer sees who reads beyond. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "dehyst.h"

static int wrong;

#define CLAIM(holds) ((holds) ? (void)0 : (void)(++wrong, fprintf(stderr, "line %d: %s\n", __LINE__, #holds)))

static int near(double a, double b) { return fabs(a - b) <= 1e-12 * (1 + fabs(b)); }

/* A block of two operators, H = 0.75 P_0 + 0.25 P_0.5. */
static double r[2] = {0, 0.5}, w[2] = {0.75, 0.25}, slope[2], loading[2], start[2];
static dehyst_block block_of(void)
{
    dehyst_pi_tables(2, r, w, slope, loading);
    const dehyst_block block = {{{0, NULL, NULL}, {2, r, slope, loading, 0, 0}, {0, NULL, NULL}}, start, -1, 1, -2, 2, -2, 2, 1, 0, 0.5, 7};
    return block;
}

static void maps_and_models(void)
{
    dehyst_block block = block_of();
    double z[2] = {0.25, 0.125}, plays[2] = {0, 0};
    dehyst_state state = {z, 9, 3};
    dehyst_model_reset(&block.model, &state, start);
    CLAIM(state.flags == 0 && z[0] == 0 && z[1] == 0 && state.output == 0);
    double *one = malloc(sizeof *one), *its = malloc(sizeof *its); /* nothing behind them */
    if (one == NULL || its == NULL) exit(2);
    *one = 0.5;
    *its = 0;
    dehyst_play_step(1, one, 2, its);
    CLAIM(*its == 1.5);
    free(one);
    free(its);
    CLAIM(dehyst_bounded(0, -1) == 0 && dehyst_bounded(2, 1) == 1 && dehyst_bounded(-2, 1) == -1 && dehyst_bounded(NAN, 1) == 0);
    /* Its output is at the limit, not beyond: nothing holds it back, and all operators have moved. */
    double h = 0;
    CLAIM(dehyst_pi_step(&block.model.hysteresis, plays, 1, -0.875, 0.875, &h) == DEHYST_MOVED && h == 0.875);
    CLAIM(plays[0] == 1 && plays[1] == 0.5);
    CLAIM(dehyst_block_check(&block) == DEHYST_IMAGE_GOOD);
    block.fade = 1e-12; /* as the header allows */
    CLAIM(dehyst_block_check(&block) == DEHYST_IMAGE_GOOD);
    block.fade = 0.99e-12;
    CLAIM(dehyst_block_check(&block) == DEHYST_IMAGE_INVALID);
    block.fade = 1;
    for (int low = 0; low < 2; ++low) { /* an argument of half the limit is the largest */
        double far[2] = {-1, 1};
        const double points[2] = {-1, 1};
        const dehyst_map map = {2, points, far};
        block.model.before = map;
        far[low] = low ? 0.45e100 : -0.45e100;
        CLAIM(dehyst_block_check(&block) == DEHYST_IMAGE_GOOD);
        far[low] *= 1.2;
        CLAIM(dehyst_block_check(&block) == DEHYST_IMAGE_INVALID);
    }
}

/* w'_1 = 1/S_1 and w'_i = -w_i / (S_i S_{i-1}) to ten digits, however small a weight is beside the first. */
static void inverses(void)
{
    const double thresholds[3] = {0, 0.25, 1}, z[3] = {0, 0, 0};
    double none[9];
    for (int at = 0; at < 3; ++at) { /* a slope of 0 has no inverse, and which it is is told */
        const double flat[3] = {at == 0 ? 0 : 0.5, at == 1 ? -0.5 : 0.25, at == 2 ? -0.75 : 0.25};
        CLAIM(dehyst_pi_invert(3, thresholds, flat, z, none, none + 3, none + 6) == at + 1);
    }
    for (int k = 0; k < 200; ++k) {
        const double weights[3] = {0.001 + 1e-5 * k, (k % 2 ? -1 : 1) * pow(10, -2 - 0.07 * k), 0.3};
        double ri[3], wi[3], zi[3], sum = weights[0];
        CLAIM(dehyst_pi_invert(3, thresholds, weights, z, ri, wi, zi) == (sum + weights[1] > 0 ? 0 : 2));
        for (int i = 1; i < 3 && sum + weights[i] > 0; sum += weights[i], ++i) {
            const double exact = -weights[i] / sum / (sum + weights[i]);
            CLAIM(fabs(wi[i] - exact) <= 1.01e-10 * fabs(exact));
        }
    }
}

static void stacks(void)
{
    const double u[2] = {-1, 1}, v[2] = {-1e250, 1e250}, thresholds[3] = {0, 0.25, 0.5}, weights[3] = {1, 1, 1}, zero[3] = {0, 0, 0};
    double slopes[3], loadings[3], table[3][4], bound[2][3], floor[2][4], z[3];
    dehyst_stack_segment segment[3];
    dehyst_stack_model model;
    dehyst_stack_state state = {.segment = segment, .bound = {bound[0], bound[1]}, .start = floor[0], .start_sum = floor[1]};
    dehyst_pi_tables(3, thresholds, weights, slopes, loadings);
    dehyst_model plain = {{0, NULL, NULL}, {3, thresholds, slopes, loadings, 0, 0}, {0, NULL, NULL}};
    dehyst_stack_prepare(&plain, table[0], table[1], table[2], &model);
    CLAIM(model.added == 0 && memcmp(table[2], loadings, sizeof loadings) == 0);
    dehyst_stack_reset(&model, &state, zero);
    CLAIM(dehyst_stack_step(&model, &state, 0.25) == 0.25);
    dehyst_stack_play(&model, &state, z);
    CLAIM(z[0] == 0.25 && z[1] == 0 && z[2] == 0 && state.end == 1); /* at the edge of the second: it does not move yet */
    CLAIM(dehyst_stack_step(&model, &state, 1) == 1 + 0.75 + 0.5 && state.end == 3);
    CLAIM(dehyst_stack_step(&model, &state, 0.5) == 0.5 + 0.75 + 0.5 && state.end == 1);
    /* Where the map leads beyond every input a sample is rejected and the output held. */
    const dehyst_map map = {2, u, v};
    plain.before = map;
    dehyst_stack_prepare(&plain, table[0], table[1], table[2], &model);
    dehyst_stack_reset(&model, &state, zero);
    const double before = state.output;
    CLAIM(dehyst_stack_step(&model, &state, 1e90) == before && state.flags == (DEHYST_REJECTED | DEHYST_REJECTED_EVER));
}

static double number_at(const uint32_t *image, int at)
{
    double x;
    memcpy(&x, image + at, sizeof x);
    return x;
}

static void put_number(uint32_t *image, int words, int at, double x)
{
    memcpy(image + at, &x, sizeof x);
    image[words - 1] = dehyst_image_sum(image, words - 1);
}

/* An image is taken back if a block can have made it: off it has no share, and a share lies within 0 .. 1. */
static void images_of_blocks(void)
{
    enum { WORDS = DEHYST_STATE_WORDS(2), SHARE = 5 + 2 * DEHYST_REAL_WORDS };
    const dehyst_block block = block_of();
    uint32_t image[WORDS];
    double z[2];
    dehyst_block_state state = {{z, 0, 0}, 0, 0, 0, 0};
    const double share[] = {0, 1, 0.5, -0.5, 1.5, NAN};
    dehyst_block_reset(&block, &state);
    for (uint32_t started = 0; started < 3; ++started) {
        for (int k = 0; k < 6; ++k) {
            CLAIM(dehyst_block_save(&block, &state, image, WORDS) == DEHYST_IMAGE_GOOD);
            image[4] = started;
            put_number(image, WORDS, SHARE, share[k]);
            const int good = k == 0 ? started < 2 : k < 3 && started == 1;
            dehyst_block_state taken = state;
            CLAIM(dehyst_block_restore(&block, &taken, image, WORDS) == (good ? DEHYST_IMAGE_GOOD : DEHYST_IMAGE_INVALID));
            CLAIM(!good || (taken.share == share[k] && taken.started == (int32_t)started));
        }
    }
}

static void directs(void)
{
    const double length[1] = {0.5}, gain[1] = {0.25}, weight[3] = {1, 0.5, 0.25};
    const int32_t group[2] = {0, 0};
    double memory[4];
    dehyst_direct direct = {1, 0, 1, 1, 0, 1, 0, NULL, length, gain, weight, group, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, 0, -1, 3, -9, 9};
    dehyst_direct_state state = {.memory = memory};
    dehyst_direct_reset(&direct, &state, 0); /* what crept before may have been at the farther end */
    CLAIM(memory[0] == 0 && memory[1] == 0.5 && memory[2] == 0 && memory[3] == 3);
    direct.past = DEHYST_PAST_REST;
    dehyst_direct_reset(&direct, &state, 2);
    CLAIM(state.last == 2 && memory[0] == 0 && memory[1] == 0 && memory[2] == 2 && memory[3] == 0);
    for (int rising = 0; rising < 2; ++rising) { /* a reset after strokes is the strokes, but for what creeps */
        const double radius[2] = {0.25, 5}, weights[5] = {1, 1, 1, 1, 0};
        const int32_t groups[4] = {0, 0, 0, 0};
        const double given[DEHYST_GIVEN] = {0, 0, 0};
        double driven[6], begun[6];
        dehyst_direct stops = {1, 2, 1, 0, 0, 1, DEHYST_PAST_REST, radius, length, NULL, weights, groups, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, 0, -1, 3, -9, 9};
        dehyst_direct_state one = {.memory = driven}, other = {.memory = begun};
        dehyst_direct_reset(&stops, &one, rising ? 3 : -1);
        dehyst_direct_step(&stops, &one, rising ? -1 : 3, 0, given);
        dehyst_direct_step(&stops, &one, 2, 0, given);
        stops.past = rising ? DEHYST_PAST_RISING : DEHYST_PAST_FALLING;
        dehyst_direct_reset(&stops, &other, 2);
        for (int i = 0; i < 6; ++i) CLAIM(driven[i] == begun[i]);
        CLAIM(begun[0] == (rising ? 1.75 : 2.25) && begun[1] == (rising ? 3 : -1) && begun[2] == begun[0] && begun[5] == 0);
        CLAIM(rising == (begun[4] > 0) && dehyst_direct_doubt(&stops, &other, NULL) == 0);
    }
    direct.past = DEHYST_PAST_UNKNOWN;
    direct.input_low = direct.input_high = 1; /* a range of one point leaves no doubt */
    dehyst_direct_reset(&direct, &state, 5);
    CLAIM(state.last == 1 && memory[2] == 1 && memory[3] == 0);
    const dehyst_direct_block block = {direct, 2, 1, 0.5};
    dehyst_direct_block_state inside = {{.memory = memory}, 0.75, 8, 3, 1};
    dehyst_direct_block_reset(&block, &inside);
    CLAIM(inside.share == 0 && inside.output == 3 && inside.flags == 0 && inside.started == 0);
}

static void learning(void)
{
    const dehyst_adaptation slow = {.rate = 1, .memory = 1, .noise = 1, .dead_zone = 0.5, .most_error = 100, .first_error = 1,
                                    .patience = 1, .lowest = 0, .highest = 9, .unit = 1};
    dehyst_adaptation adaptation = slow;
    dehyst_learning state;
    double *part = malloc(2 * sizeof *part); /* nothing behind it */
    if (part == NULL) exit(2);
    part[0] = 2;
    part[1] = 0;
    for (int error = -1; error < 2; ++error) { /* within the dead zone nothing is learned */
        dehyst_learning_reset(&adaptation, &state);
        CLAIM(dehyst_learning_step(&adaptation, &state, 2, 0.25, 3, part, 5 + 0.4 * error, 1, 0) == 1);
        CLAIM(state.scale[0] == 1 && state.scale[1] == 1 && state.offset == 0);
    }
    for (int sign = -1; sign < 2; sign += 2) { /* beyond it the step of a projection, at most a whole one */
        for (int whole = 0; whole < 2; ++whole) {
            adaptation.rate = whole ? 30 : 1;
            dehyst_learning_reset(&adaptation, &state);
            CLAIM(dehyst_learning_step(&adaptation, &state, 2, 0.25, 3, part, 5 + sign, 1, 0) == 1);
            CLAIM(near(state.scale[0], 1 + (whole ? 1 : 0.25) * sign * 0.5 * 2 / (1 + 4)) && state.scale[1] == 1);
        }
    }
    const dehyst_learning before = state; /* what is no number teaches nothing and is no contact */
    CLAIM(dehyst_learning_step(&adaptation, &state, 2, 0.25, 3, part, NAN, 1, 0) == 0);
    CLAIM(state.scale[0] == before.scale[0] && state.error == before.error && state.usual == before.usual && state.resting == before.resting);
    for (int settling = 0; settling < 2; ++settling) { /* contact is held for as long as it lasts where errors were usual before */
        adaptation = slow;
        adaptation.noise = 2;
        adaptation.most_error = 10;
        adaptation.contact_ratio = 4;
        adaptation.rest = 0.5;
        adaptation.settling = settling;
        dehyst_learning_reset(&adaptation, &state);
        double tried = 0;
        for (int k = 0; k < 4; ++k) {
            CLAIM(state.settled == (settling ? 0.25 * k : 0) && state.held == 0 && near(state.tried[0], tried));
            CLAIM(dehyst_learning_step(&adaptation, &state, 2, 0.25, 3, part, 5, 1, 0) == 1);
            tried += 0.25 / 5 * (2 - tried);
        }
        const double usual = state.usual;
        for (int k = 0; k < 50; ++k) {
            CLAIM(dehyst_learning_step(&adaptation, &state, 2, 0.25, 3, part, 25, 1, 0) == 0 || !settling);
            CLAIM(near(state.held, 0.6 * settling) && (state.usual == usual || !settling));
        }
        CLAIM((state.scale[0] == 1) == settling);
        if (settling) { /* it ends with time, whether that teaches or not */
            CLAIM(dehyst_learning_step(&adaptation, &state, 2, 0.25, 3, part, 5, 1, 0) == 0 && near(state.held, 0.35));
            CLAIM(dehyst_learning_step(&adaptation, &state, 2, 0.25, 3, part, 5, 1, 1) == 0 && near(state.held, 0.1));
            CLAIM(dehyst_learning_step(&adaptation, &state, 2, 0.25, 3, part, 5, 1, 0) == 1 && state.held == 0 && state.settled == 2);
            part[0] = 20; /* where the model has not been tried a large error is its own */
            CLAIM(dehyst_learning_step(&adaptation, &state, 2, 0.25, 3, part, 50, 1, 0) == 0 && state.held == 0 && state.settled == 0);
            part[0] = 2;
            dehyst_learning_unsettle(&state);
            CLAIM(state.settled == 0 && state.held == 0 && state.large == 0 && state.tried[0] == 0);
        }
    }
    free(part);
}

/* A joint whose torque is dp / 1000. */
static dehyst_joint joint_of(const dehyst_direct *direct)
{
    const dehyst_joint joint = {
        .period = 1.0 / 2048, .inertia = 4, .pole = 6, .observer_pole = 60, .pressure_gain = 60, .b = {0.001},
        .volume = {{0.001}, {0.001}}, .angle_low = -0.5, .angle_high = 0.5, .pressure_low = 2e4, .pressure_high = 6e5,
        .compensator_unit = 1, .direct = direct, .adaptation = {1, 1, 1, 0, 9, 0, 1, 1, 1, 0, 2, 3, 1, 1},
        .pneumatics = {801300, 101300, 84091, 1.26, 1.185, 2e-08, 0.3, 0}, .angle_step = 1e-4, .frozen_samples = 3, .hold_samples = 5};
    return joint;
}

static void observers(void)
{
    dehyst_joint joint = joint_of(NULL);
    joint.inertia = 0;
    dehyst_observer seen = {0, 0, 0};
    dehyst_observer_predict(&joint, &seen, 1e-9); /* as that of 1e-9 kg m^2 */
    CLAIM(near(seen.velocity, joint.period) && near(seen.angle, joint.period * joint.period / 2));
}

/* A reset leaves nothing of what was before, whatever it is, and without good readings it is a failure at rest. */
static void resets(void)
{
    enum { WORDS = DEHYST_JOINT_WORDS(0, -1) };
    const dehyst_joint joint = joint_of(NULL);
    static uint32_t image[2][WORDS];
    dehyst_joint_state state[2];
    const dehyst_joint_sensors good = {0.25, {3e5, 2e5}};
    for (int k = 0; k < 2; ++k) {
        memset(&state[k], 0x3f * k, sizeof state[k]);
        dehyst_joint_reset(&joint, &state[k], &good, NULL);
        CLAIM(state[k].mean.value == 0 && state[k].difference.value == 0 && state[k].integrator.value == 0 && state[k].exchanged.value == 0);
        CLAIM(state[k].flags == 0 && state[k].observer.angle == 0.25 && state[k].observer.load == 0 && state[k].pressure[1] == 2e5);
        CLAIM(dehyst_joint_save(&joint, &state[k], 1, image[k], WORDS) == DEHYST_IMAGE_GOOD);
    }
    CLAIM(memcmp(image[0], image[1], sizeof image[0]) == 0);
    for (int k = 0; k < 3; ++k) {
        dehyst_joint_sensors bad = good;
        *(k == 0 ? &bad.angle : &bad.pressure[k - 1]) = k == 1 ? INFINITY : NAN;
        dehyst_joint_reset(&joint, &state[0], &bad, NULL);
        CLAIM(state[0].flags == (DEHYST_FAILED | DEHYST_FAULT_EVER));
        CLAIM(state[0].observer.angle == 0 && state[0].pressure[0] == 0 && state[0].pressure[1] == 0);
    }
}

static void senses(void)
{
    dehyst_joint joint = joint_of(NULL);
    const dehyst_joint_sensors at_rest = {-0.25, {3e5, 3e5}};
    dehyst_joint_state state;
    for (int k = 0; k < 3; ++k) { /* an observer that is beyond all physics begins again at the last good reading */
        memset(&state, 0, sizeof state);
        dehyst_joint_reset(&joint, &state, &at_rest, NULL);
        joint.period = 0;
        state.started = 1;
        *(k == 0 ? &state.observer.angle : k == 1 ? &state.observer.velocity : &state.observer.load) = 1e120;
        const dehyst_joint_sensors none = {NAN, {3e5, 3e5}};
        CLAIM(dehyst_joint_sense(&joint, &state, &none) & DEHYST_ANGLE_FAULT);
        CLAIM(state.observer.angle == -0.25 && state.observer.velocity == 0 && state.observer.load == 0);
        joint = joint_of(NULL);
    }
    /* At the ends of its range a joint is stopped by something the observer does not know: no way is missed there. */
    for (int end = -1; end < 2; ++end) {
        const double speed = end < 0 ? -1 : 1, there = end == 0 ? 0.25 : 0.5 * end;
        const dehyst_joint_sensors stopped = {there, {3e5, 3e5}};
        memset(&state, 0, sizeof state);
        dehyst_joint_reset(&joint, &state, &stopped, NULL);
        state.started = 1;
        state.observer.velocity = speed;
        state.observer.angle = there - speed * joint.period; /* exactly: the prediction leads to the end */
        (void)dehyst_joint_sense(&joint, &state, &stopped);
        CLAIM(end == 0 ? state.travel == joint.period : state.travel == 0 && state.travel_most == 0);
    }
}

/* Every number of a joint comes back; a learned scale outside its bounds does not, and 1 is always inside. */
static void images_of_joints(void)
{
    const double weight[1] = {1};
    dehyst_direct direct = {.coefficients = 1, .groups = 1, .weight = weight, .input_low = -1, .input_high = 1, .output_low = -9, .output_high = 9};
    enum { WORDS = DEHYST_JOINT_WORDS(0, 0), SCALE = 4 + 2 * DEHYST_GROUPS + 2 * DEHYST_GROUPS + 3 + 3 * DEHYST_GROUPS + DEHYST_FIT_REALS };
    static uint32_t image[WORDS], again[WORDS];
    double none[1] = {0};
    dehyst_joint joint = joint_of(&direct);
    dehyst_joint_state state, other;
    const dehyst_joint_sensors good = {0.25, {3e5, 2e5}}, elsewhere = {-0.125, {2e5, 4e5}};
    memset(&state, 0, sizeof state);
    state.wanted.memory = state.seen.memory = none;
    dehyst_joint_reset(&joint, &state, &good, NULL);
    state.compensator.output = 0.375;
    state.angle.equal = INT32_MAX; /* of a joint that has stood still for long */
    other = state;
    dehyst_joint_reset(&joint, &other, &elsewhere, NULL);
    CLAIM(dehyst_joint_save(&joint, &state, 1, image, WORDS) == DEHYST_IMAGE_GOOD);
    CLAIM(dehyst_joint_restore(&joint, &other, 1, image, WORDS) == DEHYST_IMAGE_GOOD);
    CLAIM(dehyst_joint_save(&joint, &other, 1, again, WORDS) == DEHYST_IMAGE_GOOD);
    CLAIM(memcmp(image, again, sizeof image) == 0 && other.compensator.output == 0.375);
    const int at = 15 + DEHYST_REAL_WORDS * (40 + SCALE);
    const double scale[] = {0.25, 1, 1.5, 2.5, 3.5}, lowest[] = {0.5, 2, 2}, highest[] = {2, 3, 0.5};
    CLAIM(number_at(image, at) == 1);
    for (int k = 0; k < 3; ++k) { /* an adaptation that is off may have any bounds */
        joint.adaptation.lowest = lowest[k];
        joint.adaptation.highest = highest[k];
        for (int j = 0; j < 5; ++j) {
            const double low = fmin(lowest[k], 1), high = fmax(highest[k], 1);
            put_number(image, WORDS, at, scale[j]);
            const int taken = dehyst_joint_restore(&joint, &other, 1, image, WORDS) == DEHYST_IMAGE_GOOD;
            CLAIM(taken == (scale[j] >= low && scale[j] <= high));
        }
    }
}

/* Parameters and memory of a sum of elements: taken as they are, and refused for each number that is wrong, one at a time. */
static dehyst_element part[3];
static dehyst_elements sum;

static void whole_sum(void)
{
    static const double u[3] = {-1, 0, 1}, v[3] = {-2, 0, 1};
    const dehyst_map map = {3, u, v}, none = {0, NULL, NULL};
    const dehyst_element input = {DEHYST_INPUT, 0, 0, 0, 1, none}, path = {DEHYST_PATH, 1, 0.5, 0, 0.25, map},
                         wide = {DEHYST_WIDE, 2, 0.5, 0.5, 0.25, none};
    const dehyst_elements whole = {3, part, map, map, 0, -1, 1, 1, {DEHYST_BY_OUTPUT, 0, 0}, {0, 0, 0}, {1, 0, 0}};
    part[0] = input, part[1] = path, part[2] = wide, sum = whole;
}

#define REFUSED(wrong_number) \
    (whole_sum(), CLAIM(dehyst_elements_check(&sum) == DEHYST_IMAGE_GOOD), (void)(wrong_number), \
     CLAIM(dehyst_elements_check(&sum) == DEHYST_IMAGE_INVALID))

static void sums_of_elements(void)
{
    static const double turns[3] = {-1, 2, 1}, far[3] = {0, NAN, 1};
    const dehyst_map falls = {3, turns, turns}, back = {3, (const double[3]){-1, 0, 1}, turns}, lost = {3, (const double[3]){-1, 0, 1}, far};
    REFUSED(sum.n = 0);
    REFUSED(sum.schedules = -1);
    REFUSED(sum.schedules = DEHYST_SCHEDULES + 1);
    REFUSED(sum.offset = NAN);
    REFUSED(sum.low = 2);
    REFUSED(sum.before.n = 1);
    REFUSED(sum.before = falls);
    REFUSED(sum.after = back);
    REFUSED(sum.source[0] = DEHYST_BY_OUTPUT - 1);
    REFUSED(sum.source[0] = DEHYST_GIVEN);
    REFUSED(sum.schedule_low[0] = NAN);
    REFUSED(sum.schedule_high[0] = 0); /* no width */
    REFUSED(part[2].kind = DEHYST_PRODUCT); /* no lag behind it */
    REFUSED(part[0].kind = DEHYST_PRODUCT);
    whole_sum(), part[1].kind = DEHYST_PRODUCT, part[2].kind = DEHYST_PAST;
    CLAIM(dehyst_elements_check(&sum) == DEHYST_IMAGE_GOOD);
    part[0].kind = DEHYST_PRODUCT; /* one product behind the other */
    CLAIM(dehyst_elements_check(&sum) == DEHYST_IMAGE_GOOD);
    for (int k = 0; k < 3; ++k) {
        REFUSED(part[k].kind = -1);
        REFUSED(part[k].kind = DEHYST_KINDS);
        REFUSED(part[k].schedule = -1);
        REFUSED(part[k].schedule = 3);
        REFUSED(part[k].radius = NAN);
        REFUSED(part[k].radius = -0.5);
        REFUSED(part[k].gain = NAN);
        REFUSED(part[k].gain = -0.5);
        REFUSED(part[k].gain = 1.5);
        REFUSED(part[k].weight = INFINITY);
    }
    REFUSED(part[1].radius = 0); /* a way of no length */
    REFUSED(part[1].map.n = 1);
    REFUSED(part[1].map = falls);
    REFUSED(part[1].map = lost);
    REFUSED(part[2].gain = 1); /* its edge would stand still */
    whole_sum();
    sum.schedules = 0; /* then none of its numbers counts */
    part[1].schedule = part[2].schedule = 0;
    sum.source[0] = 9;
    CLAIM(dehyst_elements_check(&sum) == DEHYST_IMAGE_GOOD);
    const double good[3] = {7, 0.5, 7}, astray[3] = {7, 0.6, 7}, numberless[3] = {7, NAN, 7};
    CLAIM(dehyst_elements_memory_check(&sum, good, 0) == DEHYST_IMAGE_GOOD);
    CLAIM(dehyst_elements_memory_check(&sum, good, NAN) == DEHYST_IMAGE_INVALID);
    CLAIM(dehyst_elements_memory_check(&sum, astray, 0) == DEHYST_IMAGE_INVALID);
    CLAIM(dehyst_elements_memory_check(&sum, numberless, 0) == DEHYST_IMAGE_INVALID);
    for (int32_t kind = DEHYST_PLAY; kind <= DEHYST_STOP; ++kind) { /* a play is no further from its input than its radius */
        part[1].kind = kind;
        CLAIM(dehyst_elements_memory_check(&sum, good, 1) == DEHYST_IMAGE_GOOD);
        CLAIM(dehyst_elements_memory_check(&sum, good, 1.1) == DEHYST_IMAGE_INVALID);
    }
}

/* A block of a sum of elements: parameters, steps and images. */
static double element_start[7] = {0, 0, 0, 0, 0, 0.1, 0};
static dehyst_element block_part[7];
static dehyst_element_block element_block;

static void whole_block(int32_t solves, int32_t delay)
{
    static const int32_t kinds[7] = {DEHYST_INPUT, DEHYST_PLAY, DEHYST_STOP, DEHYST_WIDE, DEHYST_CREEP, DEHYST_PATH, DEHYST_RELAX};
    const dehyst_map none = {0, NULL, NULL};
    for (int k = 0; k < 7; ++k) {
        const dehyst_element one = {kinds[k], k == 1 ? 1 : k == 2 ? 2 : 0, 0.25, 0.25, k == 0 ? 1 : 0.125, none};
        block_part[k] = one;
    }
    const dehyst_elements whole = {7, block_part, none, none, 0, -1, 1, 1, {0, 0, 0}, {0, 0, 0}, {1, 0, 0}};
    const dehyst_element_block block = {whole, solves, delay, element_start, solves ? 0.375 : 1, 0, 0, 1, 0, 1, -2, 2, -1.5, 1.5,
                                        -1.25, 1.25, 0.5, 0, 0.25, 77};
    element_block = block;
}

#define REFUSED_BLOCK(wrong_number) \
    (whole_block(0, 2), CLAIM(dehyst_element_block_check(&element_block) == DEHYST_IMAGE_GOOD), (void)(wrong_number), \
     CLAIM(dehyst_element_block_check(&element_block) == DEHYST_IMAGE_INVALID), element_start[0] = 0)

static double random_part(uint32_t *seed)
{
    *seed = *seed * UINT32_C(1664525) + UINT32_C(1013904223);
    return (double)(*seed >> 8) / 8388608 - 1;
}

static void element_blocks(void)
{
    REFUSED_BLOCK(element_block.sum.n = 0);
    REFUSED_BLOCK(element_block.solves = -1);
    REFUSED_BLOCK(element_block.solves = 2);
    REFUSED_BLOCK(element_block.delay = -1);
    REFUSED_BLOCK(element_block.echo = NAN);
    REFUSED_BLOCK(element_block.echo = -0.1);
    REFUSED_BLOCK(element_block.echo = 1.1);
    REFUSED_BLOCK(element_block.origin = NAN);
    REFUSED_BLOCK(element_block.level = NAN);
    REFUSED_BLOCK(element_block.amplitude = NAN);
    REFUSED_BLOCK(element_block.center = NAN);
    REFUSED_BLOCK(element_start[0] = NAN);
    REFUSED_BLOCK(element_block.half_range = 0);
    REFUSED_BLOCK(element_block.half_range = INFINITY);
    REFUSED_BLOCK(element_block.input_low = 3);
    REFUSED_BLOCK(element_block.output_low = 3);
    REFUSED_BLOCK(element_block.reach_low = 3);
    REFUSED_BLOCK(element_block.line_slope = NAN);
    REFUSED_BLOCK(element_block.line_offset = NAN);
    REFUSED_BLOCK(element_block.fade = NAN);
    REFUSED_BLOCK(element_block.fade = 0);
    REFUSED_BLOCK(element_block.fade = 2);
    REFUSED_BLOCK(element_block.half_range = 1e-101); /* inputs would be infinite */
    REFUSED_BLOCK(element_block.sum.high = 0.9 * DEHYST_INPUT_LIMIT); /* from end to end is a step that no image holds */
    REFUSED_BLOCK(element_start[5] = 0.26); /* nor a memory that no way leaves */
    element_start[5] = 0.1;
    enum { N = 7, RING = 3, WORDS = DEHYST_ELEMENT_WORDS(N, RING) };
    uint32_t seed = 5, image[WORDS], other_image[WORDS];
    for (int form = 0; form < 8; ++form) { /* solved or not, late or not, a start or rest; some are never held back */
        const int32_t solves = form & 1, delay = form & 2 ? RING : 0, words = DEHYST_ELEMENT_WORDS(N, delay);
        double z[N], ring[RING], other_z[N], other_ring[RING];
        dehyst_element_block_state state, other;
        whole_block(solves, delay);
        element_block.start = form & 4 ? NULL : element_start;
        CLAIM(dehyst_element_block_check(&element_block) == DEHYST_IMAGE_GOOD);
        element_block.reach_high = form == 0 || form == 6 ? 1.25 : DEHYST_FAR;
        state.sum.z = z, state.delay.ring = ring, other.sum.z = other_z, other.delay.ring = other_ring;
        for (int sign = -1; sign <= 1; sign += 2) { /* the first sample is reached upwards and downwards */
            const double given[DEHYST_GIVEN] = {0.25, 0, 0};
            dehyst_element_block_reset(&element_block, &state);
            CLAIM(dehyst_element_block_save(&element_block, &state, image, words) == DEHYST_IMAGE_GOOD);
            CLAIM(dehyst_element_block_restore(&element_block, &state, image, words) == DEHYST_IMAGE_GOOD);
            CLAIM(state.output == 0 && dehyst_element_block_step(&element_block, &state, NAN, given, 1) == 0);
            (void)dehyst_element_block_step(&element_block, &state, 0.5 * sign, given, sign > 0);
            CLAIM(state.started && state.share == (sign > 0));
        }
        for (int k = 0; k < 4000; ++k) {
            const double rejected = k % 101 == 7 ? NAN : 0, x = (k % 500 < 20 ? 3.0 : 1.4) * random_part(&seed);
            const double given[DEHYST_GIVEN] = {random_part(&seed) + (k % 103 == 3 ? NAN : 0), k % 107 == 5 ? NAN : 0, k % 109 == 5 ? NAN : 0};
            const double held = state.output;
            const double output = dehyst_element_block_step(&element_block, &state, x + rejected, given, k % 40 > 10);
            CLAIM(output >= -1.5 && output <= 1.5);
            CLAIM(!(state.flags & DEHYST_REJECTED) || output == held);
            CLAIM(!(x < -2 || x > 2) || (state.flags & (DEHYST_LIMITED | DEHYST_REJECTED)));
        }
        CLAIM(state.flags & DEHYST_LIMITED_EVER);
        for (int k = 0; k < 2000; ++k) { /* something else drives it */
            const double rejected = k % 13 == 7 ? NAN : 0, missing = k % 7 == 3 ? NAN : 0;
            const double given[DEHYST_GIVEN] = {random_part(&seed) + (k % 103 == 3 ? NAN : 0), 0, 0};
            const double held = state.output, came_out = 2 * random_part(&seed) + missing;
            dehyst_element_block_observe(&element_block, &state, 3 * random_part(&seed) + rejected, came_out, given);
            CLAIM(state.output >= -1.5 && state.output <= 1.5 && state.started);
            CLAIM(!(state.flags & DEHYST_REJECTED) || state.output == held);
            CLAIM((state.flags & DEHYST_REJECTED) || !(fabs(came_out) <= 1.5) || state.output == came_out);
            CLAIM(k % 103 != 3 || (state.flags & DEHYST_REJECTED));
            CLAIM(state.least <= state.sum.last && state.sum.last <= state.most && state.share == 1);
            CLAIM(dehyst_elements_memory_check(&element_block.sum, z, state.sum.last) == DEHYST_IMAGE_GOOD);
        }
        CLAIM(dehyst_element_block_save(&element_block, &state, image, words - 1) == DEHYST_IMAGE_SIZE);
        CLAIM(dehyst_element_block_save(&element_block, &state, image, words) == DEHYST_IMAGE_GOOD);
        CLAIM(dehyst_element_block_restore(&element_block, &other, image, words) == DEHYST_IMAGE_GOOD);
        for (int k = 0; k < 50; ++k) {
            const double x = random_part(&seed), given[DEHYST_GIVEN] = {0.5, 0, 0};
            CLAIM(dehyst_element_block_step(&element_block, &state, x, given, 1) ==
                  dehyst_element_block_step(&element_block, &other, x, given, 1));
        }
        CLAIM(dehyst_element_block_restore(&element_block, &other, image, words - 1) == DEHYST_IMAGE_SIZE);
        memcpy(other_image, image, sizeof image);
        const int at_rest = 5 + 2 * (N + delay);
        const struct { int word; uint32_t value; int32_t answer; } wrong_words[] = {
            {0, 1, DEHYST_IMAGE_KIND}, {1, 1, DEHYST_IMAGE_FOREIGN}, {2, 1, DEHYST_IMAGE_FOREIGN}, {3, 16, DEHYST_IMAGE_INVALID},
            {4, 2, DEHYST_IMAGE_INVALID}, {5 + 1, 0x7ff00000, DEHYST_IMAGE_INVALID}, {5 + 3, 0x40400000, DEHYST_IMAGE_INVALID},
            {at_rest + 1, 0x7ff00000, DEHYST_IMAGE_INVALID}, {at_rest + 5, 0xbff00000, DEHYST_IMAGE_INVALID},
            {at_rest + 5, 0x40400000, DEHYST_IMAGE_INVALID}, {at_rest + 7, 0xc0400000, DEHYST_IMAGE_INVALID},
            {at_rest + 7, 0x40400000, DEHYST_IMAGE_INVALID}, {at_rest + 9, 0x40400000, DEHYST_IMAGE_INVALID},
            {at_rest + 11, 0xc0400000, DEHYST_IMAGE_INVALID}, {at_rest + 9, 0xfff00000, DEHYST_IMAGE_INVALID}, {at_rest - 1, 0x7ff00000, DEHYST_IMAGE_INVALID}};
        for (size_t i = 0; i < sizeof wrong_words / sizeof *wrong_words; ++i) {
            memcpy(image, other_image, sizeof image);
            image[wrong_words[i].word] = wrong_words[i].value;
            image[words - 1] = dehyst_image_sum(image, words - 1);
            CLAIM(dehyst_element_block_restore(&element_block, &other, image, words) == wrong_words[i].answer);
        }
        memcpy(image, other_image, sizeof image);
        image[4] = 0, image[at_rest + 5] = 0x3fe00000; /* it has not begun, but is half on */
        image[words - 1] = dehyst_image_sum(image, words - 1);
        CLAIM(dehyst_element_block_restore(&element_block, &other, image, words) == DEHYST_IMAGE_INVALID);
        image[7] ^= 1u;
        CLAIM(dehyst_element_block_restore(&element_block, &other, image, words) == DEHYST_IMAGE_DAMAGED);
    }
}

/* Two inputs and two outputs: what one way gives the other takes back; limits, samples that are no number, refusals. */
static dehyst_pair pair;
static double pair_z[2][4][2];

static void whole_pair(double across, double back)
{
    static dehyst_element own[2], other[2], third[2];
    const dehyst_map none = {0, NULL, NULL};
    const dehyst_element input = {DEHYST_INPUT, 0, 0, 0, 1, none}, play = {DEHYST_PLAY, 0, 0.25, 0, 0.5, none};
    dehyst_elements sum_of_two = {2, own, none, none, 0.125, -1, 1, 0, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
    const dehyst_pair whole = {{{sum_of_two, sum_of_two}, {sum_of_two, sum_of_two}}, {1, 0}, {2, -1}, {0, 1}, {1, -2},
                               {0.25, 0}, 0};
    own[0] = other[0] = third[0] = input, own[1] = other[1] = third[1] = play;
    other[0].weight = across, other[1].weight = 0.5 * across, third[0].weight = back, third[1].weight = 0.5 * back;
    pair = whole;
    pair.path[0][1].element = other, pair.path[1][0].element = third;
}

static void begin_pair(dehyst_pair_state *state, int which, int32_t solves)
{
    for (int p = 0; p < 4; ++p) {
        state->path[p / 2][p % 2].z = pair_z[which][p];
    }
    pair.solves = solves;
    dehyst_pair_reset(&pair, state);
}

#define NO_PAIR(wrong_number) \
    (whole_pair(0.1, 0.1), CLAIM(dehyst_pair_check(&pair) == DEHYST_IMAGE_GOOD), (void)(wrong_number), \
     CLAIM(dehyst_pair_check(&pair) == DEHYST_IMAGE_INVALID))

static void pairs(void)
{
    static const double shares[5][2] = {{0.1, 0.1}, {-0.9, 0.8}, {0.9, -0.8}, {0, 0.5}, {-0.2, -0.2}};
    static const double points[2] = {-1, 1};
    static const dehyst_map map = {2, points, points};
    for (int k = 0; k < 5; ++k) {
        dehyst_pair_state forward, inverse;
        double worst = 0;
        whole_pair(shares[k][0], shares[k][1]);
        CLAIM(dehyst_pair_check(&pair) == DEHYST_IMAGE_GOOD);
        begin_pair(&inverse, 1, 1);
        CLAIM(inverse.answer[0] == 1.5 && inverse.answer[1] == 0); /* the inputs at rest */
        begin_pair(&forward, 0, 0);
        for (int i = 0; i < 400; ++i) {
            const double u[2] = {1 + 1.9 * sin(0.1 * i) * cos(0.017 * i), 0.9 * sin(0.13 * i + 1)};
            double y[2], found[2];
            pair.solves = 0;
            dehyst_pair_step(&pair, &forward, u, y);
            pair.solves = 1;
            dehyst_pair_step(&pair, &inverse, y, found);
            worst = fmax(worst, fmax(fabs(found[0] - u[0]), fabs(found[1] - u[1])));
            CLAIM(inverse.rounds <= 12 + DEHYST_HALVINGS && !(inverse.flags & DEHYST_LIMITED));
        }
        CLAIM(worst < 1e-12);
        const double last[2] = {inverse.answer[0], inverse.answer[1]}, bad[2] = {0, NAN}, far[2] = {90, -90}, low[2] = {-90, 90};
        double held[2];
        dehyst_pair_step(&pair, &inverse, bad, held);
        CLAIM(held[0] == last[0] && held[1] == last[1] && (inverse.flags & DEHYST_REJECTED));
        dehyst_pair_step(&pair, &inverse, (const double[2]){NAN, 0}, held);
        CLAIM(held[0] == last[0] && held[1] == last[1] && (inverse.flags & DEHYST_REJECTED));
        dehyst_pair_step(&pair, &inverse, far, held);
        CLAIM(fabs(held[0] - 1) <= 2 && fabs(held[1]) <= 1 && (inverse.flags & DEHYST_LIMITED));
        dehyst_pair_step(&pair, &inverse, low, held);
        CLAIM(fabs(held[0] - 1) <= 2 && fabs(held[1]) <= 1 && (inverse.flags & DEHYST_LIMITED));
        pair.solves = 0;
        dehyst_pair_step(&pair, &forward, far, held);
        CLAIM((forward.flags & DEHYST_LIMITED) && fabs(held[0]) < 9 && fabs(held[1]) < 9);
        dehyst_pair_step(&pair, &forward, low, held);
        CLAIM(forward.flags & DEHYST_LIMITED);
    }
    for (int k = 0; k < 2; ++k) {
        NO_PAIR(pair.center[k] = NAN);
        NO_PAIR(pair.half_range[k] = 0);
        NO_PAIR(pair.half_range[k] = INFINITY);
        NO_PAIR(pair.level[k] = NAN);
        NO_PAIR(pair.amplitude[k] = 0);
        NO_PAIR(pair.amplitude[k] = NAN);
        NO_PAIR(pair.rest[k] = NAN);
        for (int i = 0; i < 2; ++i) {
            NO_PAIR(pair.path[k][i].n = 0);
            NO_PAIR(pair.path[k][i].schedules = 1);
            NO_PAIR((pair.path[k][i].schedules = 1, pair.path[k][i].schedule_high[0] = 1));
            NO_PAIR(pair.path[k][i].before = map);
            NO_PAIR(pair.path[k][i].after = map);
        }
    }
}

int main(void)
{
    maps_and_models();
    inverses();
    stacks();
    images_of_blocks();
    directs();
    learning();
    observers();
    resets();
    senses();
    images_of_joints();
    sums_of_elements();
    element_blocks();
    pairs();
    printf("%d claims do not hold\n", wrong);
    return wrong > 0;
}
