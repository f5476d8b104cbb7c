/* The bits of the core: every part of it driven by random models, parameters, samples, faults and images, all drawn by
 * integers; prints one hash a part. Doubles only; calls nothing whose last digit a machine may choose. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "dehyst.h"

enum { MOST = 24, POINTS = 6, TERMS = 64, ROUNDS = 150, STEPS = 120 };

static uint64_t seed, hash;

static uint64_t bits(void)
{
    seed ^= seed << 13;
    seed ^= seed >> 7;
    seed ^= seed << 17;
    return seed;
}
static int below(int n) { return (int)(bits() % (unsigned)n); }
static double share(void) { return (double)(bits() >> 11) / 9007199254740992.0; }
static double within(double low, double high) { return low + share() * (high - low); }

/* Often a number of size one on a coarse grid, so that numbers meet; sometimes of any size, or no number. */
static double wild(void)
{
    const int kind = below(40);
    uint64_t pattern = bits();
    double x;
    if (kind > 3) return kind & 1 ? within(-1.5, 1.5) : (double)(below(25) - 12) / 8.0;
    if (kind == 3) pattern = (pattern & UINT64_C(0x800fffffffffffff)) | (uint64_t)(1023 - 320 + below(640)) << 52;
    if (kind == 2) pattern = UINT64_C(0x7ff0000000000000) | (pattern & 1) << 63 | (pattern & 2) << 50;
    memcpy(&x, &pattern, sizeof x);
    return x;
}

static void byte_in(const void *data, size_t size)
{
    for (size_t i = 0; i < size; ++i) hash = (hash ^ ((const unsigned char *)data)[i]) * UINT64_C(0x100000001b3);
}
static void in(double x)
{
    byte_in(&x, sizeof x);
}
static void all_in(const double *x, int n)
{
    for (int i = 0; i < n; ++i) in(x[i]);
}
static void whole_in(int64_t x) { byte_in(&x, sizeof x); }

static int order(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}
static void rising(double *x, int n, double low, double high)
{
    for (int i = 0; i < n; ++i) x[i] = below(2) ? within(low, high) : low + (high - low) * below(33) / 32;
    qsort(x, (size_t)n, sizeof *x, order);
    for (int i = 1; i < n; ++i)
        if (!(x[i] > x[i - 1])) x[i] = x[i - 1] + 1.0 / 1024;
}

typedef struct parts {
    double r[MOST], w[MOST], slope[MOST], loading[MOST], start[MOST], u[2][POINTS], v[2][POINTS], z[MOST], other[MOST];
    dehyst_model model;
} parts;

static void make(parts *p)
{
    const int n = 1 + below(MOST - 1), before = below(3) ? 0 : 2 + below(POINTS - 2), after = below(3) ? 0 : 2 + below(POINTS - 2);
    const int count[2] = {before, after}, falling = below(2);
    memset(p, 0, sizeof *p);
    rising(p->r, n, 0, 1);
    if (below(3)) p->r[0] = 0;
    for (int i = 0; i < n; ++i) p->w[i] = i == 0 ? within(0.3, 1) : within(-0.5 / n, 2.0 / n);
    const double from = within(-1, 1), back = from + within(-1, 1);
    for (int i = 0; i < n; ++i) {
        const double first = from > p->r[i] ? from - p->r[i] : from < -p->r[i] ? from + p->r[i] : 0;
        p->start[i] = first < back - p->r[i] ? back - p->r[i] : first > back + p->r[i] ? back + p->r[i] : first;
    }
    for (int k = 0; k < 2; ++k) {
        rising(p->u[k], count[k], -1.5, 1.5);
        rising(p->v[k], count[k], -1.5, 1.5);
        for (int i = 0; k && falling && i < count[k]; ++i) p->v[k][i] = -p->v[k][i];
    }
    dehyst_pi_tables(n, p->r, p->w, p->slope, p->loading);
    const dehyst_model model = {{before, p->u[0], p->v[0]}, {n, p->r, p->slope, p->loading, below(2) ? 0 : wild(), within(-1, 1)},
                                {after, p->u[1], p->v[1]}};
    p->model = model;
    if (!dehyst_accept(p->model.hysteresis.center)) p->model.hysteresis.center = 0.25;
}

static void models(void)
{
    parts p;
    double ri[MOST] = {0}, wi[MOST] = {0}, zi[MOST] = {0};
    make(&p);
    const int n = p.model.hysteresis.n;
    dehyst_state state = {p.z, 0, 0};
    all_in(p.slope, n);
    all_in(p.loading, n);
    whole_in(dehyst_pi_invert(n, p.r, p.w, p.start, ri, wi, zi));
    all_in(ri, n);
    all_in(wi, n);
    all_in(zi, n);
    if (below(4) == 0) p.w[below(n)] = -2;
    whole_in(dehyst_pi_invert(n, p.r, p.w, p.start, ri, wi, zi));
    dehyst_stop_to_play(n, within(0, 1), p.w, wi);
    all_in(wi, n);
    dehyst_model_reset(&p.model, &state, p.start);
    memcpy(p.other, p.start, sizeof p.other);
    for (int k = 0; k < STEPS; ++k) {
        const double x = wild(), low = wild(), high = low + share();
        in(dehyst_model_step(&p.model, &state, x));
        in(dehyst_model_output(&p.model, p.z));
        in(dehyst_map_value(&p.model.after, x));
        in(dehyst_within(x, low, high));
        whole_in(state.flags | (unsigned)dehyst_admissible(n, p.r, p.z) << 8 | (unsigned)dehyst_accept(x) << 9);
        double h = 0;
        if (dehyst_accept(x) && low < high) whole_in(dehyst_pi_step(&p.model.hysteresis, p.other, x, low, high, &h));
        in(h);
        all_in(p.other, n);
        if (dehyst_accept(x)) dehyst_play_step(n, p.r, x, p.z);
        all_in(p.z, n);
        if (below(20) == 0) p.other[below(n)] += 0.3; /* admissible no more */
        if (!dehyst_admissible(n, p.r, p.other)) {
            whole_in(k);
            memcpy(p.other, p.z, sizeof p.other);
        }
    }
}

static void stacks(void)
{
    parts p;
    double r[MOST + 2], slope[MOST + 1], loading[MOST + 1], falling[MOST + 1], up[MOST + 1], start[MOST + 2], sum[MOST + 2];
    dehyst_stack_segment segment[MOST + 1];
    dehyst_stack_model model;
    dehyst_stack_state state = {.segment = segment, .bound = {falling, up}, .start = start, .start_sum = sum};
    make(&p);
    dehyst_stack_prepare(&p.model, r, slope, loading, &model);
    dehyst_stack_reset(&model, &state, p.start);
    whole_in(model.n * 1000 + model.added * 100 + model.half);
    const int calm = below(2); /* a walk leaves deep stacks */
    for (int k = 0; k < 2 * STEPS; ++k) {
        in(dehyst_stack_step(&model, &state, calm ? state.input + model.center + within(-0.3, 0.3) : wild()));
        in(dehyst_stack_output(&model, &state));
        dehyst_stack_play(&model, &state, p.z);
        all_in(p.z, p.model.hysteresis.n);
        whole_in(state.depth * 10000 + state.end * 100 + state.rising * 10 + (int)state.flags);
    }
    const double end = state.input;
    dehyst_stack_begin(&model, &state, p.z);
    dehyst_stack_push(&model, &state, 0, model.n, below(2), end);
    if (model.n > 1) dehyst_stack_push(&model, &state, 1, model.n - 1, below(2), end + 0.125);
    in(dehyst_stack_step(&model, &state, within(-1, 1)));
}

/* Forge an image: a word changed, its checksum right or not, or its length. Returns how many words to offer. */
static int forged(uint32_t *image, int words)
{
    const int at = below(words), kind = below(7);
    if (kind == 0) return below(2) ? words - 1 : below(words < 16 ? words : 16);
    if (kind == 6) image[at] = UINT32_C(0x7ff80000); /* the upper half of a number that is none, every second time */
    if (kind == 1) image[at] ^= UINT32_C(1) << below(32);
    if (kind > 1 && kind < 6) image[below(2) ? at : below(words < 16 ? words : 16)] = below(2) ? (uint32_t)below(40) : (uint32_t)bits();
    if (kind > 2) image[words - 1] = dehyst_image_sum(image, words - 1);
    return words;
}

static void blocks(void)
{
    static uint32_t image[DEHYST_BLOCK_WORDS(MOST, POINTS, POINTS)], kept[DEHYST_STATE_WORDS(MOST)];
    static double memory[DEHYST_BLOCK_REALS(MOST, POINTS, POINTS)];
    parts p;
    make(&p);
    const int n = p.model.hysteresis.n, reals = DEHYST_BLOCK_REALS(n, p.model.before.n, p.model.after.n);
    double limit[6];
    for (int i = 0; i < 6; i += 2) rising(limit + i, 2, -1.25, 1.25);
    dehyst_block block = {p.model, p.start, limit[0], limit[1], limit[2], limit[3], limit[4], limit[5],
                          within(-1, 1), within(-1, 1), below(4) ? within(0.01, 1) : 1.0, (uint32_t)bits()}, loaded;
    if (below(2)) block.reach_low = -DEHYST_INPUT_LIMIT, block.reach_high = DEHYST_INPUT_LIMIT;
    const int words = DEHYST_BLOCK_WORDS(n, p.model.before.n, p.model.after.n);
    whole_in(dehyst_block_check(&block));
    whole_in(dehyst_block_dump(&block, image, words - below(2)));
    whole_in(dehyst_block_dump(&block, image, words));
    byte_in(image, (size_t)words * sizeof *image);
    for (int k = 0; k < 40; ++k) {
        uint32_t copy[DEHYST_BLOCK_WORDS(MOST, POINTS, POINTS)];
        memcpy(copy, image, sizeof copy);
        whole_in(dehyst_block_load(copy, forged(copy, words), memory, reals + 64, &loaded));
    }
    whole_in(dehyst_block_load(image, words, memory, reals - 1, &loaded));
    const int answer = dehyst_block_load(image, words, memory, reals, &loaded);
    whole_in(answer);
    if (answer != DEHYST_IMAGE_GOOD) return;
    dehyst_block_state state = {{p.z, 0, 0}, 0, 0, 0, 0};
    dehyst_block_reset(&loaded, &state);
    int on = 1;
    for (int k = 0; k < STEPS; ++k) {
        on = below(10) ? on : !on;
        in(dehyst_block_step(&loaded, &state, wild(), on));
        in(state.share);
        whole_in(state.flags);
        all_in(p.z, n);
        const int size = DEHYST_STATE_WORDS(n);
        if (below(8) == 0) {
            whole_in(dehyst_block_save(&loaded, &state, kept, size));
            byte_in(kept, (size_t)size * sizeof *kept);
            whole_in(dehyst_block_restore(&loaded, &state, kept, forged(kept, size)));
            whole_in(dehyst_block_save(&loaded, &state, kept, size - 1));
            in(state.output);
        }
        if (below(60) == 0) dehyst_block_reset(&loaded, &state);
    }
}

typedef struct direct_parts {
    double radius[8], length[4], gain[4], weight[6 * TERMS], memory[2][64];
    int32_t group[TERMS];
    dehyst_direct direct;
} direct_parts;

static void make_direct(direct_parts *d, double size)
{
    const int stops = below(7), paths = below(4), creeps = below(4), coefficients = 1 + below(8), schedules = below(4);
    const int terms = DEHYST_DIRECT_TERMS(coefficients, stops, paths, creeps), groups = 1 + below(4);
    memset(d, 0, sizeof *d);
    rising(d->radius, stops, 0.01, 0.6);
    rising(d->length, paths, 0.03, 1);
    for (int i = 0; i < creeps; ++i) d->gain[i] = within(0.0001, 0.5);
    for (int i = 0; i < 6 * terms; ++i) d->weight[i] = size * within(i % terms < coefficients ? -1 : 0, 1);
    for (int i = 0; i < terms; ++i) d->group[i] = below(groups);
    const dehyst_direct made = {coefficients, stops, paths, creeps, schedules, groups, below(3) == 0, d->radius, d->length, d->gain,
                                d->weight, d->group, {below(3) - 1, below(3) - 1, below(3) - 1}, {-1, -0.5, 0}, {1, 1.5, 0.5},
                                within(-0.2, 0.2), -1, 1, -3 * size, 3 * size};
    d->direct = made;
}

static void state_in(const dehyst_direct *direct, const dehyst_direct_state *state)
{
    in(state->last);
    in(state->curve);
    all_in(state->part, direct->groups);
    all_in(state->doubt, direct->groups);
    all_in(state->memory, DEHYST_DIRECT_REALS(direct->stops, direct->paths, direct->creeps));
    whole_in(state->flags);
}

static void directs(void)
{
    direct_parts d;
    make_direct(&d, 1);
    dehyst_direct_state state = {.memory = d.memory[0]}, other = {.memory = d.memory[1]};
    dehyst_direct_block block = {d.direct, within(-1, 1), within(-1, 1), within(0.01, 1)};
    dehyst_direct_block_state inside = {.direct = {.memory = d.memory[1]}};
    dehyst_direct_reset(&d.direct, &state, within(-1, 1));
    dehyst_direct_reset(&d.direct, &other, 0);
    dehyst_direct_follow(&d.direct, &other, &state);
    state_in(&d.direct, &other);
    dehyst_direct_block_reset(&block, &inside);
    int on = 1;
    for (int k = 0; k < STEPS; ++k) {
        const double given[DEHYST_GIVEN] = {wild(), wild(), 0}, scale[8] = {0.5, 2, 1, 0, 1.5, 1, 1, 1}, y = wild(), rate = wild();
        dehyst_direct_step(&d.direct, &state, y, rate, given);
        state_in(&d.direct, &state);
        in(dehyst_direct_output(&d.direct, &state, below(2) ? scale : NULL));
        in(dehyst_direct_doubt(&d.direct, &state, below(2) ? scale : NULL));
        in(dehyst_decay(y < 0 ? -4 * y : 4 * y));
        on = below(10) ? on : !on;
        in(dehyst_direct_block_step(&block, &inside, y, rate, given, on));
        in(inside.share);
        whole_in(inside.flags);
        state_in(&d.direct, &inside.direct);
    }
}

static void sums(int products)
{
    enum { MEMBERS = 12 };
    double knot[MEMBERS][POINTS], value[MEMBERS][POINTS], z[2][MEMBERS], column[MEMBERS], ring[5] = {0};
    double u[2][POINTS], v[2][POINTS], share[DEHYST_SHARES], slope;
    dehyst_element element[MEMBERS];
    dehyst_elements sum = {1 + below(MEMBERS), element, {below(2) ? 0 : POINTS, u[0], v[0]}, {below(2) ? 0 : POINTS, u[1], v[1]},
                           within(-1, 1), -2, 2, below(4), {below(3) - 1, below(3) - 1, below(3) - 1}, {-1, -0.5, 0}, {1, 1.5, 0.5}};
    for (int i = 0; i < POINTS; ++i) {
        u[0][i] = u[1][i] = i - 2.5;
        v[0][i] = v[1][i] = i - 2.5 + 0.25 * (i % 2);
    }
    for (int k = 0; k < sum.n; ++k) {
        const int32_t kind = k == 0 ? DEHYST_INPUT : below(DEHYST_PRODUCT);
        rising(knot[k], POINTS, -1.5, 1.5);
        for (int i = 0; i < POINTS; ++i) {
            knot[k][i] += 0.01 * i;
            value[k][i] = below(9) ? 0.5 * i : 0;
            value[k][i] += within(-0.2, 0.2);
        }
        const dehyst_element made = {kind, k == 0 ? 0 : below(2 * sum.schedules + 1), below(6) ? within(0.05, 0.6) : kind == DEHYST_PATH,
                                     within(0, 0.9), k == 0 ? 1 : within(-0.05, 0.4), {below(2) ? 0 : POINTS, knot[k], value[k]}};
        element[k] = made;
        if (products && k > 0 && k < sum.n - 1) { /* a product reads the lag behind it */
            element[k].kind = k % 2 ? DEHYST_PRODUCT : below(2) ? DEHYST_PAST : DEHYST_PRODUCT;
        } else if (products && k > 0) {
            element[k].kind = DEHYST_PAST;
        }
    }
    whole_in(dehyst_elements_check(&sum));
    dehyst_elements_state state = {.z = z[0]}, back = {.z = z[1]};
    dehyst_delay delay = {below(6), 0, ring};
    dehyst_elements_reset(&sum, &state, 0.25, 0);
    dehyst_elements_reset(&sum, &back, 0.25, 0);
    for (int k = 0; k < STEPS; ++k) {
        const double given[DEHYST_GIVEN] = {wild(), wild(), 0}, x = wild(), y = dehyst_elements_step(&sum, &state, x, given);
        in(y);
        in(dehyst_elements_solve_step(&sum, &back, below(9) ? y : wild(), given));
        whole_in(back.rounds * 1000 + (int)back.flags * 20 + (int)state.flags);
        whole_in(dehyst_elements_memory_check(&sum, z[0], state.last));
        all_in(z[0], sum.n);
        all_in(z[1], sum.n);
        dehyst_elements_shares(&sum, &state, given, share);
        const double probe = within(-2, 2);
        in(dehyst_elements_value(&sum, &state, share, probe, k % 2, &slope));
        in(slope);
        in(dehyst_delay_step(&delay, within(-1, 1)));
    }
    dehyst_elements_columns(&sum, &state, 0.5, column);
    all_in(column, sum.n);
}

static void elements(void) { sums(0); }

static void products(void) { sums(1); }

/* Resets after strokes, within the range and beyond it. */
static void strokes(void)
{
    direct_parts d;
    make_direct(&d, 1);
    dehyst_direct_state state = {.memory = d.memory[0]};
    for (d.direct.past = DEHYST_PAST_RISING; d.direct.past <= DEHYST_PAST_FALLING; ++d.direct.past) {
        dehyst_direct_reset(&d.direct, &state, within(-4, 4));
        state_in(&d.direct, &state);
    }
}

static dehyst_joint joint_of(const dehyst_model *model, const dehyst_direct *direct)
{
    const dehyst_joint joint = {
        .period = 5e-4, .inertia = 4, .pole = 6, .observer_pole = 60, .pressure_gain = 60, .windup_gain = 5,
        .a = {0, -0.0006209, 0, 0.0002313, 0, -3.78e-05}, .b = {0.0003488, 0, -3.88e-05, 0, -1.26e-05}, .c = {0, -4.32, 0, -14.66},
        .volume = {{0.00082, 0.000228, -7.05e-05, 3.3e-06}, {0.00082, -0.000228, -7.05e-05, -3.3e-06}},
        .angle_low = -0.7, .angle_high = 0.7, .pressure_low = 2e4, .pressure_high = 6e5, .ramp = below(4) ? 0.01 : 0, .shear = 1e5,
        .compensator_unit = 1e3, .compensator = model, .direct = direct,
        .adaptation = {30, below(3) ? 0.05 : 0, 0.3, below(2) ? 0 : 0.01, below(2) ? 0.5 : 50, below(3) ? 4 : 0, 1, below(2) ? 0.05 : 120,
                       below(2) ? 0.002 : 0, 0.005, 0.1, 2, below(3) ? 2 : 0, 1},
        .most_acceleration = 50, .least_speed = 0.002, .disturbance_pole = 50,
        .pneumatics = {801300, 101300, 84091, 1.26, 1.185, 2e-08, 0.3, 0.03},
        .angle_jump = below(3) ? 0.05 : 0, .pressure_jump = below(3) ? 3e4 : 0, .angle_step = 4.8e-05,
        .frozen_samples = below(2) ? 10 : 0, .hold_samples = 5 + below(40)};
    return joint;
}

/* One number of the parameters becomes any, or 0: limits hold then too. */
static void spoil(dehyst_joint *joint)
{
    double *const number[] = {
        &joint->period, &joint->inertia, &joint->pole, &joint->observer_pole, &joint->pressure_gain, &joint->windup_gain, joint->b,
        &joint->angle_low, &joint->angle_high, &joint->pressure_low, &joint->pressure_high, &joint->ramp, &joint->shear,
        &joint->compensator_unit, &joint->adaptation.rate, &joint->adaptation.memory, &joint->adaptation.lowest,
        &joint->adaptation.highest, &joint->most_acceleration, &joint->least_speed, &joint->disturbance_pole,
        &joint->pneumatics.supply, &joint->pneumatics.ambient, &joint->pneumatics.gas_temperature, &joint->pneumatics.polytropic,
        &joint->pneumatics.reference_density, &joint->pneumatics.conductance, &joint->pneumatics.ratio,
        &joint->pneumatics.dead_band, &joint->angle_jump, &joint->pressure_jump, &joint->angle_step};
    double *const chosen = number[below((int)(sizeof number / sizeof *number))];
    const double factor = wild();
    const int kind = below(5);
    if (kind > 1 && dehyst_accept(factor)) *chosen *= kind == 2 ? -1 : kind == 3 ? 1e3 * factor : factor;
    if (kind < 2) *chosen = kind;
}

static void joint_state_in(const dehyst_joint_state *s)
{
    all_in(&s->torque_direct, 4);
    all_in(&s->observer.angle, 3);
    all_in(s->desired, 2);
    all_in(s->expected, 2);
    all_in(s->rate, 2);
    in(s->compensator_share);
    in(s->integrator.value);
    whole_in(s->angle.faulty);
    whole_in(s->muscle[0].faulty);
    whole_in(s->muscle[1].faulty);
}

static void joints(void)
{
    static uint32_t image[DEHYST_JOINT_WORDS(MOST, 64)], kept[DEHYST_JOINT_WORDS(MOST, 64)];
    parts p, q;
    direct_parts d;
    make(&p);
    make(&q);
    make_direct(&d, 20);
    const int with_direct = below(2), with_model = !with_direct || below(2);
    dehyst_joint joint = joint_of(with_model ? &p.model : NULL, with_direct ? &d.direct : NULL);
    for (int k = below(4) ? 0 : 1 + below(4); k > 0; --k) spoil(&joint);
    dehyst_joint_state state;
    memset(&state, 0, sizeof state);
    state.compensator.z = p.z;
    state.wanted.memory = d.memory[0];
    state.seen.memory = d.memory[1];
    dehyst_joint_sensors sensors = {below(30) ? 0.05 : wild(), {3e5, below(30) ? 3e5 : wild()}};
    dehyst_joint_reset(&joint, &state, &sensors, p.start);
    dehyst_joint_reference reference = {0, 0, 0, 0, 3e5, 0, 0};
    uint32_t switches = 31;
    double speed = 0;
    int frozen = 0; /* bits: angle, pressures */
    for (int k = 0; k < 4 * STEPS; ++k) {
        dehyst_joint_output out;
        if (below(40) == 0) switches = (uint32_t)below(32);
        if (below(30) == 0) speed = within(-2, 2);
        reference.acceleration = below(20) ? 0 : within(-60, 60);
        reference.velocity = below(10) ? speed : 0;
        reference.angle += 5e-4 * speed;
        reference.load = 4 * reference.angle;
        reference.extra = 1e4 * share();
        reference.pressure_difference = 1e5 * speed;
        dehyst_joint_reference told = reference;
        if (below(60) == 0) {
            double *what = &told.angle + below(7);
            *what = wild();
        }
        if (below(60) == 0) frozen = below(8);
        const double noise = below(4) ? within(-0.01, 0.01) : 0;
        sensors.angle = frozen & 1 ? sensors.angle : reference.angle + noise;
        for (int m = 0; m < 2; ++m) sensors.pressure[m] = frozen & 2 << m ? sensors.pressure[m] : below(30) == 0 ? 0 : below(15) ? 3e5 + 2e5 * (m ? -1 : 1) * reference.angle + within(-300, 300) : sensors.pressure[m];
        dehyst_joint_sensors seen = sensors;
        if (below(25) == 0) {
            double *what = below(2) ? &seen.angle : seen.pressure + below(2);
            *what = wild();
        }
        dehyst_joint_step(&joint, &state, &seen, &told, switches, &out);
        all_in(out.valve, 13);
        whole_in(out.flags);
        joint_state_in(&state);
        if (below(25) == 0) {
            const int words = DEHYST_JOINT_WORDS(joint.compensator ? joint.compensator->hysteresis.n : 0,
                                                 with_direct ? DEHYST_DIRECT_REALS(d.direct.stops, d.direct.paths, d.direct.creeps) : -1);
            whole_in(dehyst_joint_save(&joint, &state, 7, image, words));
            byte_in(image, (size_t)words * sizeof *image);
            whole_in(dehyst_joint_save(&joint, &state, 7, kept, words - 1));
            for (int j = 0; j < 6; ++j) {
                memcpy(kept, image, sizeof kept);
                const int offered = forged(kept, words);
                whole_in(dehyst_joint_restore(&joint, &state, below(8) ? 7 : 8, kept, offered));
            }
            joint_state_in(&state);
            whole_in(dehyst_joint_restore(&joint, &state, 7, image, words));
        }
        if (below(120) == 0 && !with_direct) {
            const int other = below(3);
            parts *next = joint.compensator == &p.model ? &q : &p;
            dehyst_joint_exchange(&joint, &state, other ? &next->model : NULL, 1e3, other == 1 ? 1e5 : 0, other ? next->z : NULL, other ? next->start : NULL);
        }
        if (below(200) == 0) dehyst_joint_reset(&joint, &state, &sensors, joint.compensator == &q.model ? q.start : p.start);
    }
}

/* What no run comes to. */
static void corners(void)
{
    const double r[2] = {0, 0.5}, w[2] = {1, 1}, z[2] = {0, 0}, shifted[2] = {0.25, 0.5}, negative[2] = {-0.25, 0.5}, steep[2] = {1e-200, 1e200};
    double a[2] = {0}, b[2] = {0}, c[2] = {0};
    whole_in(dehyst_pi_invert(0, r, w, z, a, b, c));
    whole_in(dehyst_pi_invert(2, shifted, w, z, a, b, c));
    whole_in(dehyst_pi_invert(2, negative, w, z, a, b, c));
    whole_in(dehyst_pi_invert(2, r, steep, z, a, b, c));
    all_in(b, 2);
    for (int k = 0; k < 2; ++k) { /* a count that is full stays full */
        dehyst_sensor sensor = {0.5, INT32_MAX - k, 0};
        whole_in(dehyst_sensor_fault(&sensor, 0.5, 0.5, 0));
        whole_in(sensor.equal);
    }
    const double large[2] = {-1e150, 1e150}, points[2] = {-1, 1};
    parts p;
    make(&p);
    p.model.before.n = 2; /* makes infinity of a good sample */
    p.model.before.u = points;
    p.model.before.v = large;
    dehyst_state state = {p.z, 0, 0};
    dehyst_model_reset(&p.model, &state, p.start);
    double table[3][MOST + 2], reach[2][MOST + 1], floor[2][MOST + 2];
    dehyst_stack_segment segment[MOST + 1];
    dehyst_stack_model model;
    dehyst_stack_state stack = {.segment = segment, .bound = {reach[0], reach[1]}, .start = floor[0], .start_sum = floor[1]};
    dehyst_stack_prepare(&p.model, table[0], table[1], table[2], &model);
    dehyst_stack_reset(&model, &stack, p.start);
    dehyst_block block = {p.model, p.start, -1e90, 1e90, -1, 1, -1e9, 1e9, 0, 0, 1, 0};
    dehyst_block_state inside = {{p.z, 0, 0}, 0, 0, 0, 0};
    dehyst_block_reset(&block, &inside);
    for (int k = 0; k < 8; ++k) {
        const double x = k < 4 ? within(-1, 1) : 1e99 * within(-1, 1);
        in(dehyst_model_step(&p.model, &state, x));
        in(dehyst_stack_step(&model, &stack, x));
        in(dehyst_block_step(&block, &inside, x, 1));
        whole_in(state.flags * 100 + stack.flags * 10 + inside.flags);
    }
    /* Parameters of no block, by each of its numbers. */
    make(&p);
    const dehyst_block good = {p.model, p.start, -1, 1, -1, 1, -1e9, 1e9, 1, 0, 0.5, 0};
    double *const number[] = {&p.r[0], &p.r[p.model.hysteresis.n - 1], &p.slope[0], &p.loading[0], &p.start[0], &p.start[p.model.hysteresis.n - 1],
                              &p.u[0][0], &p.v[0][0], &p.u[1][1], &p.v[1][1]};
    const double strange[] = {0.0, -1.0, 1e120, -1e120, 0.0 * 1e300 * 1e300};
    whole_in(dehyst_block_check(&good));
    for (unsigned k = 0; k < sizeof number / sizeof *number; ++k) {
        const double kept = *number[k];
        for (int j = 0; j < 5; ++j) {
            *number[k] = strange[j];
            whole_in(dehyst_block_check(&good));
        }
        *number[k] = kept;
    }
    for (int k = 0; k < 13; ++k) {
        dehyst_block bad = good;
        double *const field[] = {&bad.model.hysteresis.center, &bad.model.hysteresis.offset, &bad.input_low, &bad.input_high, &bad.output_low,
                                 &bad.output_high, &bad.reach_low, &bad.reach_high, &bad.line_slope, &bad.line_offset, &bad.fade};
        if (k == 11) bad.model.hysteresis.n = 0;
        if (k == 12) bad.model.before.n = 1;
        for (int j = 0; j < 5; ++j) {
            if (k < 11) *field[k] = strange[j];
            whole_in(dehyst_block_check(&bad));
        }
    }
}

static void air(void)
{
    const dehyst_joint joint = joint_of(NULL, NULL);
    dehyst_characteristic at;
    for (int k = 0; k < STEPS; ++k) {
        double volume, slope, pressure[2];
        const double x = wild(), p = within(0.5e5, 9e5), m = within(-2e5, 8e5);
        in(dehyst_root(x));
        in(dehyst_flow_function(x, 0.3));
        in(dehyst_valve_opening(&joint.pneumatics, 0.02 * x, p));
        in(dehyst_valve_command(&joint.pneumatics, x));
        dehyst_volume_at(&joint, below(2), x, &volume, &slope);
        in(volume);
        in(slope);
        in(dehyst_chamber_flow(&joint.pneumatics, volume, slope, p, x));
        in(dehyst_chamber_rate(&joint.pneumatics, volume, slope, p, x));
        dehyst_characteristic_at(&joint, x, &at);
        all_in(&at.a, 3);
        in(dehyst_characteristic_torque(&at, m, x));
        in(dehyst_characteristic_difference(&at, m, x));
        whole_in(dehyst_pressures(&joint, m, 1e6 * x, pressure));
        all_in(pressure, 2);
        in(dehyst_bounded(x, 0.5));
    }
}

static void part(const char *name, void (*run)(void))
{
    seed = UINT64_C(88172645463325252);
    hash = UINT64_C(0xcbf29ce484222325);
    for (int k = 0; k < ROUNDS; ++k) run();
    printf("%s %016llx\n", name, (unsigned long long)hash);
}

int main(void)
{
    part("models", models);
    part("stacks", stacks);
    part("blocks", blocks);
    part("directs", directs);
    part("strokes", strokes);
    part("joints", joints);
    part("air", air);
    part("corners", corners);
    part("elements", elements);
    part("products", products);
    return 0;
}
