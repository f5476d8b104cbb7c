/* Blocks of random parameters, sane or wild but accepted by dehyst_block_check, driven by random bit patterns.
 *
 *   block_random BLOCKS SEED
 *
 * Prints a line and ends with status 1 if an output leaves its range, a state is one that no input leaves, an image of
 * the block's own state is refused, or a restored block goes on with other bits. Prints how many blocks were accepted. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "dehyst.h"

#define MOST 12
#define STEPS 60
#ifdef DEHYST_FLOAT
#define LARGE 14
#else
#define LARGE 99
#endif

static uint64_t seed;

static uint64_t bits(void)
{
    seed ^= seed << 13;
    seed ^= seed >> 7;
    seed ^= seed << 17;
    return seed;
}

static int one_in(int n) { return (int)(bits() % (unsigned)n) == 0; }
static double share(void) { return (double)(bits() >> 11) / 9007199254740992.0; }

/* Of any size and sign, often 0 or a small whole number, so that numbers meet. */
static dehyst_real wild(void)
{
    if (one_in(8)) return 0;
    if (one_in(8)) return (dehyst_real)((int)(bits() % 9) - 4);
    const double exponent = one_in(2) ? 2 : LARGE;
    const double size = pow(10, (2 * share() - 1) * exponent);
    return (dehyst_real)(one_in(2) ? size : -size);
}

static dehyst_real number(int sane) { return sane ? (dehyst_real)(2 * share() - 1) : wild(); }

static int order(const void *a, const void *b)
{
    const dehyst_real x = *(const dehyst_real *)a, y = *(const dehyst_real *)b;
    return x < y ? -1 : x > y;
}

static void sorted(dehyst_real *values, int n, int falling)
{
    for (int i = 0; i < n; ++i) values[i] = wild();
    qsort(values, (size_t)n, sizeof *values, order);
    for (int i = 0; falling && i < n / 2; ++i) {
        const dehyst_real kept = values[i];
        values[i] = values[n - 1 - i];
        values[n - 1 - i] = kept;
    }
}

typedef struct made {
    dehyst_real r[MOST], w[MOST], slope[MOST], loading[MOST], start[MOST], bu[8], bv[8], au[8], av[8], limit[6];
    dehyst_block block;
} made;

static void make(made *m)
{
    const int sane = one_in(2);
    const int n = 1 + (int)(bits() % MOST);
    const int before = one_in(4) ? 2 + (int)(bits() % 6) : 0, after = one_in(4) ? 2 + (int)(bits() % 6) : 0;
    for (int i = 0; i < n; ++i) {
        m->r[i] = number(sane);
        if (m->r[i] < 0) m->r[i] = -m->r[i];
        m->w[i] = number(sane) + (dehyst_real)(sane ? 0.4 : 0);
    }
    qsort(m->r, (size_t)n, sizeof *m->r, order);
    if (!one_in(4)) m->r[0] = 0;
    const dehyst_real from = number(sane);
    for (int i = 0; i < n; ++i) m->start[i] = from > m->r[i] ? from - m->r[i] : (from < -m->r[i] ? from + m->r[i] : 0);
    dehyst_pi_tables(n, m->r, m->w, m->slope, m->loading);
    sorted(m->bu, before, 0);
    sorted(m->bv, before, one_in(2));
    sorted(m->au, after, 0);
    sorted(m->av, after, one_in(2));
    for (int i = 0; i < 6; i += 2) {
        m->limit[i] = number(sane);
        m->limit[i + 1] = number(sane);
        qsort(m->limit + i, 2, sizeof *m->limit, order);
    }
    const dehyst_block block = {
        {{before, m->bu, m->bv}, {n, m->r, m->slope, m->loading, number(sane), number(sane)}, {after, m->au, m->av}},
        m->start, m->limit[0], m->limit[1], m->limit[2], m->limit[3], m->limit[4], m->limit[5],
        wild(), wild(), (dehyst_real)share(), (uint32_t)bits()};
    m->block = block;
}

static dehyst_real input(const dehyst_block *block)
{
    if (one_in(4)) {
        dehyst_real x;
        const uint64_t pattern = bits();
        memcpy(&x, &pattern, sizeof x);
        return x;
    }
    const dehyst_real low = block->input_low, high = block->input_high;
    return one_in(4) ? wild() : low + (dehyst_real)share() * (high - low);
}

/* Whether a block restored from an image makes the same next step. */
static int goes_on(const dehyst_block *block, const dehyst_block_state *state)
{
    static uint32_t image[DEHYST_STATE_WORDS(MOST)];
    const int32_t n = block->model.hysteresis.n, words = DEHYST_STATE_WORDS(n);
    dehyst_real z[2][MOST];
    dehyst_block_state other[2] = {*state};
    memcpy(z[0], state->model.z, (size_t)n * sizeof **z);
    other[0].model.z = z[0];
    other[1].model.z = z[1];
    dehyst_block_reset(block, &other[1]);
    if (dehyst_block_save(block, state, image, words) != 0) return 0;
    if (dehyst_block_restore(block, &other[1], image, words) != 0) return 0;
    const dehyst_real x = input(block);
    const dehyst_real y[2] = {dehyst_block_step(block, &other[0], x, 1), dehyst_block_step(block, &other[1], x, 1)};
    return memcmp(&y[0], &y[1], sizeof *y) == 0 && other[0].flags == other[1].flags &&
           memcmp(z[0], z[1], (size_t)n * sizeof **z) == 0;
}

static const char *fault(const dehyst_block *block)
{
    dehyst_real z[MOST];
    dehyst_block_state state;
    state.model.z = z;
    dehyst_block_reset(block, &state);
    for (int k = 0; k < STEPS; ++k) {
        const dehyst_real y = dehyst_block_step(block, &state, input(block), !one_in(3));
        if (!(y >= block->output_low && y <= block->output_high)) return "an output leaves its range";
        if (!dehyst_admissible(block->model.hysteresis.n, block->model.hysteresis.threshold, z)) return "a state is one that no input leaves";
        if (!goes_on(block, &state)) return "a restored block does not go on";
    }
    return 0;
}

int main(int count, char **words)
{
    static uint32_t image[DEHYST_BLOCK_WORDS(MOST, 8, 8)];
    static dehyst_real memory[DEHYST_BLOCK_REALS(MOST, 8, 8)];
    if (count != 3) return 2;
    seed = UINT64_C(88172645463325252) + (uint64_t)atol(words[2]) * 7919;
    long accepted = 0;
    for (long tries = atol(words[1]); tries > 0; --tries) {
        made m;
        dehyst_block loaded;
        make(&m);
        if (dehyst_block_check(&m.block) != DEHYST_IMAGE_GOOD) continue;
        ++accepted;
        const dehyst_model *model = &m.block.model;
        const int32_t size = DEHYST_BLOCK_WORDS(model->hysteresis.n, model->before.n, model->after.n);
        const int lost = dehyst_block_dump(&m.block, image, size) != 0 ||
                         dehyst_block_load(image, size, memory, (int32_t)(sizeof memory / sizeof *memory), &loaded) != 0;
        const char *found = lost ? "dumped parameters are refused" : fault(&loaded);
        if (found) {
            printf("block %ld of seed %s: %s\n", accepted, words[2], found);
            return 1;
        }
    }
    printf("%ld\n", accepted);
    return 0;
}
