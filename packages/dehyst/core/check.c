#include "dehyst.h"

/* States follow from differences of rounded numbers: as far as that they may be off. */
#ifdef DEHYST_FLOAT
#define SLACK 1e-4f
#define LEAST_FADE 1e-6f /* of less a switching would never end: 1 - fade must not be 1 */
#else
#define SLACK 1e-9
#define LEAST_FADE 1e-12
#endif

static dehyst_real size(dehyst_real x) { return x < 0 ? -x : x; }

int dehyst_admissible(int32_t n, const dehyst_real *threshold, const dehyst_real *z)
{
    const dehyst_real *r = threshold;
    int good = dehyst_accept(z[0]);
    for (int32_t i = 1; good && i < n; ++i) {
        good = dehyst_accept(z[i]) && size(z[i] - z[i - 1]) <= r[i] - r[i - 1] + SLACK * (size(z[i]) + r[i]);
    }
    return good;
}

static int increases(const dehyst_real *values, int32_t n)
{
    int good = dehyst_accept(values[0]);
    for (int32_t i = 1; good && i < n; ++i) {
        good = dehyst_accept(values[i]) && values[i] > values[i - 1];
    }
    return good;
}

static int decreases(const dehyst_real *values, int32_t n)
{
    int good = dehyst_accept(values[0]);
    for (int32_t i = 1; good && i < n; ++i) {
        good = dehyst_accept(values[i]) && values[i] < values[i - 1];
    }
    return good;
}

static int numbers(const dehyst_real *values, int32_t n)
{
    int good = 1;
    for (int32_t i = 0; i < n; ++i) {
        good = good && dehyst_accept(values[i]);
    }
    return good;
}

static int map_is_good(const dehyst_map *map)
{
    return map->n == 0 || (map->n >= 2 && increases(map->u, map->n) &&
                           (increases(map->v, map->n) || decreases(map->v, map->n)));
}

static int range_is_good(dehyst_real low, dehyst_real high)
{
    return dehyst_accept(low) && dehyst_accept(high) && low <= high;
}

/* The loading curve of the slopes: outputs are read from it. */
static int loading_is_good(const dehyst_pi *pi)
{
    dehyst_real phi = 0;
    dehyst_real most = 0;
    dehyst_real about = 0; /* what rounding is measured by */
    for (int32_t i = 0; i < pi->n; ++i) {
        if (i > 0) {
            const dehyst_real cell = pi->slope[i - 1] * (pi->threshold[i] - pi->threshold[i - 1]);
            phi = pi->loading[i - 1] + cell;
            most += size(cell);
            about = most + size(pi->slope[i - 1]) * pi->threshold[i]; /* thresholds are rounded too */
        }
        if (!(size(pi->loading[i] - phi) <= SLACK * about)) {
            return 0;
        }
    }
    return 1;
}

/* No input within the range leads to states beyond the limit: such could be saved, but not restored. */
static int arguments_are_good(const dehyst_block *block)
{
    const dehyst_real center = block->model.hysteresis.center;
    const dehyst_real low = dehyst_map_value(&block->model.before, block->input_low) - center;
    const dehyst_real high = dehyst_map_value(&block->model.before, block->input_high) - center;
    return dehyst_accept(2 * low) && dehyst_accept(2 * high);
}

static int switching_is_good(dehyst_real slope, dehyst_real offset, dehyst_real fade)
{
    return dehyst_accept(slope) && dehyst_accept(offset) && dehyst_accept(fade) && fade >= LEAST_FADE && fade <= 1;
}

int32_t dehyst_block_check(const dehyst_block *block)
{
    const dehyst_pi *pi = &block->model.hysteresis;
    const int operators = pi->n >= 1 && increases(pi->threshold, pi->n) && pi->threshold[0] >= 0 &&
                          numbers(pi->slope, pi->n) && numbers(pi->loading, pi->n) && loading_is_good(pi) &&
                          dehyst_accept(pi->center) && dehyst_accept(pi->offset) &&
                          dehyst_admissible(pi->n, pi->threshold, block->start);
    const int maps = map_is_good(&block->model.before) && map_is_good(&block->model.after);
    const int ranges = range_is_good(block->input_low, block->input_high) &&
                       range_is_good(block->output_low, block->output_high) &&
                       range_is_good(block->reach_low, block->reach_high);
    const int switching = switching_is_good(block->line_slope, block->line_offset, block->fade);
    const int good = operators && maps && ranges && switching && arguments_are_good(block);
    return good ? DEHYST_IMAGE_GOOD : DEHYST_IMAGE_INVALID;
}

static int element_is_good(const dehyst_element *q, int32_t shares)
{
    const int map = q->map.n == 0 || (q->map.n >= 2 && increases(q->map.u, q->map.n) && numbers(q->map.v, q->map.n));
    const int kind = q->kind >= 0 && q->kind < DEHYST_KINDS && q->schedule >= 0 && q->schedule < shares;
    const int radius = dehyst_accept(q->radius) && q->radius >= 0 && (q->kind != DEHYST_PATH || q->radius > 0);
    const int gain = dehyst_accept(q->gain) && q->gain >= 0 && (q->kind == DEHYST_WIDE ? q->gain < 1 : q->gain <= 1);
    return map && kind && radius && gain && dehyst_accept(q->weight);
}

static int rises(const dehyst_map *map)
{
    return map->n == 0 || (map->n >= 2 && increases(map->u, map->n) && increases(map->v, map->n));
}

int32_t dehyst_elements_check(const dehyst_elements *sum)
{
    int good = sum->n >= 1 && sum->schedules >= 0 && sum->schedules <= DEHYST_SCHEDULES && dehyst_accept(sum->offset) &&
               range_is_good(sum->low, sum->high) && rises(&sum->before) && rises(&sum->after);
    for (int32_t v = 0; good && v < sum->schedules; ++v) {
        good = sum->source[v] >= DEHYST_BY_OUTPUT && sum->source[v] < DEHYST_GIVEN &&
               range_is_good(sum->schedule_low[v], sum->schedule_high[v]) && sum->schedule_low[v] < sum->schedule_high[v];
    }
    for (int32_t k = 0; good && k < sum->n; ++k) {
        const dehyst_element *q = &sum->element[k];
        good = element_is_good(q, 2 * sum->schedules + 1);
        if ((q->kind == DEHYST_PRODUCT) &&
            (((k + 1) == sum->n) || ((q[1].kind != DEHYST_PAST) && (q[1].kind != DEHYST_PRODUCT)))) {
            good = 0; /* there is no lag that it could read */
        }
    }
    return good ? DEHYST_IMAGE_GOOD : DEHYST_IMAGE_INVALID;
}

int32_t dehyst_elements_memory_check(const dehyst_elements *sum, const dehyst_real *z, dehyst_real last)
{
    int good = dehyst_accept(last) && numbers(z, sum->n);
    for (int32_t k = 0; good && k < sum->n; ++k) {
        const dehyst_element *q = &sum->element[k];
        const dehyst_real most = q->radius + SLACK * (size(last) + q->radius);
        const int play = q->kind == DEHYST_PLAY || q->kind == DEHYST_STOP;
        good = !(play && size(z[k] - last) > most) && !(q->kind == DEHYST_PATH && size(z[k]) > most);
    }
    return good ? DEHYST_IMAGE_GOOD : DEHYST_IMAGE_INVALID;
}

int32_t dehyst_element_block_check(const dehyst_element_block *block)
{
    const dehyst_elements *sum = &block->sum;
    const dehyst_real rest[5] = {block->level, block->amplitude, block->center, 2 * sum->low, 2 * sum->high};
    int good = dehyst_elements_check(sum) == DEHYST_IMAGE_GOOD && (block->solves == 0 || block->solves == 1) &&
               block->delay >= 0 && block->echo >= 0 && block->echo <= 1 && numbers(rest, 5) &&
               dehyst_accept(block->origin) &&
               (!block->start || dehyst_elements_memory_check(sum, block->start, block->origin) == DEHYST_IMAGE_GOOD) &&
               size(block->half_range) > 0 && dehyst_accept(block->half_range) &&
               range_is_good(block->input_low, block->input_high) &&
               range_is_good(block->output_low, block->output_high) && block->reach_low <= block->reach_high &&
               switching_is_good(block->line_slope, block->line_offset, block->fade);
    for (int32_t i = 0; good && i < 2; ++i) { /* as in arguments_are_good */
        const dehyst_real end = i == 0 ? block->input_low : block->input_high;
        good = dehyst_accept(2 * dehyst_map_value(&sum->before, (end - block->center) / block->half_range));
    }
    return good ? DEHYST_IMAGE_GOOD : DEHYST_IMAGE_INVALID;
}
