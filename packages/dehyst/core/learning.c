#include "dehyst.h"

#define SURE ((dehyst_real)0.1)    /* time of large errors in a row that are no twitch, [s] */
#define TENFOLD ((dehyst_real)10)  /* how much more than a usual error a large one counts against being settled */
#define TRY ((dehyst_real)5)        /* over which a term that is larger than before counts as tried, [s] */
#define FARTHER ((dehyst_real)1.25) /* a term that is larger by this than it was while errors were usual has not been tried */

static dehyst_real square_within(dehyst_real x)
{
    const dehyst_real size = dehyst_bounded(x, (dehyst_real)1e7); /* its square is within DEHYST_INPUT_LIMIT */
    return size * size;
}

void dehyst_learning_forget(const dehyst_adaptation *adaptation, dehyst_learning *learning)
{
    for (int32_t g = 0; g < DEHYST_GROUPS; ++g) {
        learning->scale[g] = 1;
    }
    learning->offset = 0;
    learning->error = 0;
    learning->error_before = 0;
    learning->usual = square_within(adaptation->first_error);
    learning->resting = 0;
    dehyst_learning_unsettle(learning);
}

void dehyst_learning_reset(const dehyst_adaptation *adaptation, dehyst_learning *learning)
{
    dehyst_learning_forget(adaptation, learning);
    for (int32_t g = 0; g < DEHYST_GROUPS; ++g) {
        learning->applied[g] = 1;
    }
    learning->curve = 1;
    learning->applied_offset = 0;
}

static dehyst_real part_of(dehyst_real period, dehyst_real time)
{
    return time > period ? period / time : (dehyst_real)1;
}

void dehyst_learning_unsettle(dehyst_learning *learning)
{
    for (int32_t g = 0; g < DEHYST_GROUPS; ++g) {
        learning->tried[g] = 0;
    }
    learning->settled = 0;
    learning->large = 0;
    learning->held = 0;
}

/* Time goes on without a large error. */
static void calm(dehyst_learning *learning, dehyst_real period)
{
    learning->large = 0;
    learning->held = learning->held > period ? learning->held - period : (dehyst_real)0;
}

/* Whether a term is larger than it was while errors were usual: then the model may be wrong there. */
static int is_new(const dehyst_adaptation *adaptation, const dehyst_learning *learning, int32_t groups, const dehyst_real *part)
{
    int larger = 0;
    for (int32_t g = 0; g < groups; ++g) {
        const dehyst_real size = part[g] < 0 ? -part[g] : part[g];
        larger = larger || size > FARTHER * learning->tried[g] + adaptation->noise;
    }
    return larger;
}

/* How long errors have been usual ones, at most twice `settling`; where they were so for `settling`, a large one is held: no
 * actuator changes at once. Short ones, as where the motion turns, neither hold nor unsettle, nor does a term that is larger
 * for a moment, as a hand may make one. */
static void settle(const dehyst_adaptation *adaptation, dehyst_learning *learning, int32_t groups, dehyst_real period,
                   const dehyst_real *part, int large)
{
    const dehyst_real most = 2 * adaptation->settling;
    const int settled = adaptation->settling > 0 && learning->settled >= adaptation->settling;
    if (!large) {
        calm(learning, period);
        if (!(learning->resting > 0)) {
            learning->settled = dehyst_within(learning->settled + period, 0, most);
            for (int32_t g = 0; g < groups; ++g) {
                const dehyst_real size = dehyst_bounded(part[g] < 0 ? -part[g] : part[g], (dehyst_real)1e7);
                const dehyst_real more = size > learning->tried[g] ? size - learning->tried[g] : (dehyst_real)0;
                learning->tried[g] += part_of(period, TRY) * more; /* one stroke that grows is no trial yet */
            }
        }
    } else if (settled && !is_new(adaptation, learning, groups, part)) {
        learning->settled = dehyst_within(learning->settled + period, 0, most);
        learning->large = dehyst_within(learning->large + period, 0, SURE);
        learning->held = learning->large >= SURE || learning->held > 0 ? adaptation->rest + SURE : learning->held;
    } else {
        learning->settled = dehyst_within(learning->settled - TENFOLD * period, 0, most);
        learning->large = 0;
        learning->held = settled ? learning->held : (dehyst_real)0;
    }
}

/* Whether an error is another's doing, not the model's: far beyond what is usual, or was so a moment ago. */
static int is_contact(const dehyst_adaptation *adaptation, dehyst_learning *learning, int32_t groups, dehyst_real period,
                      const dehyst_real *part, dehyst_real error)
{
    const dehyst_real square = square_within(error);
    const dehyst_real always = square_within(adaptation->most_error);
    const dehyst_real ratio = dehyst_bounded(adaptation->contact_ratio, (dehyst_real)1e3);
    const dehyst_real grown = ratio * ratio * learning->usual;
    const dehyst_real most = grown > always ? grown : always;
    const int large = square > most;
    learning->resting = large ? adaptation->rest : learning->resting - period;
    learning->resting = learning->resting > 0 ? learning->resting : (dehyst_real)0;
    settle(adaptation, learning, groups, period, part, large);
    if (!(learning->held > 0)) { /* what is held never becomes usual */
        const dehyst_real share = part_of(period, square > learning->usual ? adaptation->patience : adaptation->memory);
        learning->usual += share * ((large ? dehyst_within(most, 0, square) : square) - learning->usual);
    }
    return large || learning->resting > 0;
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
static void apply(dehyst_learning *learning, int32_t groups, dehyst_real part_of_it, dehyst_real fitting)
{
    /* of a model that does not fit little is left to be learned: with care, the more the less it fits */
    const dehyst_real care = fitting < 1 ? (dehyst_real)0.5 * fitting : (dehyst_real)1;
    const int better = learning->error < care * learning->error_before;
    const dehyst_real quick = dehyst_within(10 * part_of_it, 0, 1);
    const dehyst_real shared = !better && fitting < 1 ? quick : part_of_it;
    for (int32_t g = 0; g < groups; ++g) {
        const dehyst_real target = better ? learning->scale[g] : fitting;
        learning->applied[g] += shared * (target - learning->applied[g]);
    }
    const dehyst_real target = better ? learning->offset : (dehyst_real)0;
    learning->applied_offset += shared * (target - learning->applied_offset);
    learning->curve += shared * ((better ? (dehyst_real)1 : fitting) - learning->curve);
}

int dehyst_learning_step(const dehyst_adaptation *adaptation, dehyst_learning *learning, int32_t groups,
                         dehyst_real period, dehyst_real curve, const dehyst_real *part, dehyst_real measured,
                         dehyst_real fitting, int frozen)
{
    dehyst_real before = measured - fitting * curve;
    before -= fitting < 1 ? learning->offset : (dehyst_real)0; /* scales alone are compared */
    dehyst_real error = measured - curve - learning->offset;
    for (int32_t g = 0; g < groups; ++g) {
        before -= fitting * part[g];
        error -= learning->scale[g] * part[g];
    }
    const dehyst_real part_of_it = part_of(period, adaptation->memory);
    const int blind = frozen || !dehyst_accept(error);
    if (blind) {
        calm(learning, period);
    }
    if (blind || is_contact(adaptation, learning, groups, period, part, error)) {
        apply(learning, groups, part_of_it, fitting);
        return 0;
    }
    learning->error += part_of_it * (square_within(error) - learning->error);
    learning->error_before += part_of_it * (square_within(before) - learning->error_before);
    const dehyst_real most = adaptation->rate * period;
    learn(adaptation, learning, groups, most < 1 ? most : (dehyst_real)1, part, error);
    apply(learning, groups, part_of_it, fitting);
    return 1;
}
