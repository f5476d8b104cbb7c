#include "dehyst.h"

void dehyst_learning_reset(dehyst_learning *learning)
{
    for (int32_t g = 0; g < DEHYST_GROUPS; ++g) {
        learning->scale[g] = 1;
        learning->applied[g] = 1;
    }
    learning->offset = 0;
    learning->applied_offset = 0;
    learning->error = 0;
    learning->error_before = 0;
}

static dehyst_real square_within(dehyst_real x)
{
    const dehyst_real size = dehyst_bounded(x, (dehyst_real)1e12); /* its square overflows in no precision */
    return size * size;
}

/* What is taken of an error: nothing below the dead zone. */
static dehyst_real beyond(dehyst_real error, dehyst_real dead_zone)
{
    return error > dead_zone ? error - dead_zone : (error < -dead_zone ? error + dead_zone : (dehyst_real)0);
}

static void learn(const dehyst_adaptation *adaptation, dehyst_learning *learning, int32_t groups, dehyst_real part_of_it,
                  const dehyst_real *part, dehyst_real error)
{
    const dehyst_real unit = adaptation->offset_limit > 0 ? adaptation->unit : (dehyst_real)0;
    dehyst_real size = adaptation->noise * adaptation->noise + unit * unit;
    for (int32_t g = 0; g < groups; ++g) {
        size += square_within(part[g]);
    }
    const dehyst_real step = part_of_it * beyond(error, adaptation->dead_zone) / size;
    for (int32_t g = 0; g < groups; ++g) {
        learning->scale[g] =
            dehyst_within(learning->scale[g] + step * part[g], adaptation->lowest, adaptation->highest);
    }
    learning->offset = dehyst_bounded(learning->offset + step * (unit * unit), adaptation->offset_limit);
}

/* What is in use goes towards what is better. */
static void apply(dehyst_learning *learning, int32_t groups, dehyst_real part_of_it)
{
    const int better = learning->error < learning->error_before;
    for (int32_t g = 0; g < groups; ++g) {
        const dehyst_real target = better ? learning->scale[g] : (dehyst_real)1;
        learning->applied[g] += part_of_it * (target - learning->applied[g]);
    }
    const dehyst_real target = better ? learning->offset : (dehyst_real)0;
    learning->applied_offset += part_of_it * (target - learning->applied_offset);
}

int dehyst_learning_step(const dehyst_adaptation *adaptation, dehyst_learning *learning, int32_t groups,
                         dehyst_real period, dehyst_real curve, const dehyst_real *part, dehyst_real measured,
                         int frozen)
{
    dehyst_real before = measured - curve;
    dehyst_real error = before - learning->offset;
    for (int32_t g = 0; g < groups; ++g) {
        before -= part[g];
        error -= learning->scale[g] * part[g];
    }
    const dehyst_real part_of_it = adaptation->memory > period ? period / adaptation->memory : (dehyst_real)1;
    if (frozen || !dehyst_accept(error) || error > adaptation->most_error || error < -adaptation->most_error) {
        apply(learning, groups, part_of_it);
        return 0;
    }
    learning->error += part_of_it * (square_within(error) - learning->error);
    learning->error_before += part_of_it * (square_within(before) - learning->error_before);
    const dehyst_real most = adaptation->rate * period;
    learn(adaptation, learning, groups, most < 1 ? most : (dehyst_real)1, part, error);
    apply(learning, groups, part_of_it);
    return 1;
}
