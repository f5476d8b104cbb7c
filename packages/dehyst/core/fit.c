#include "dehyst.h"

/* Whether the compensator's torque h still fits what the observer sees beyond the known load, l: both as the position
 * loop answers to them, and then l regressed on h and on the angle q, stroke by stroke. What is wrong with stiffness,
 * weight and inertia follows the angle, and only hysteresis follows h. */

#define MOST ((dehyst_real)1e3)    /* torque of a joint whose squares are summed, [Nm] */
#define LEAST ((dehyst_real)1e-3)  /* sum of h h that says something, [Nm^2 s] */
#define HIGHEST ((dehyst_real)1e9) /* of a sum */
#define SMALLEST ((dehyst_real)1e-12)
#define KEPT ((dehyst_real)0.8)    /* of the sums when a stroke ends */
#define WHOLE ((dehyst_real)0.1)   /* share of a usual stroke's sum that makes a stroke */
#define STROKES ((dehyst_real)2)   /* before anything is said: three, those before forgotten a little */
#define HOMED ((dehyst_real)3.2)   /* the same where only pressures are applied: five */
#define SWING ((dehyst_real)1)     /* a turning sooner than that under pressures alone ends no stroke: the joint swings, [s] */
#define GROSS ((dehyst_real)2e-3)  /* share of the largest torque, times a second: of h h that shows a loop */
#define OWN ((dehyst_real)0.1)     /* share of h h that does not follow the angle: with less nothing can be said */
#define ALONG ((dehyst_real)2.5)   /* the same of a compensator along q_d: four */
#define FAR ((dehyst_real)0.15)    /* distance of the scale of a direct inverse below 1 that is none of noise */
#define NEAR ((dehyst_real)0.1)    /* and that ends it */
#define WIDE ((dehyst_real)0.25)   /* the same above 1, which changes nothing, and of a compensator along q_d, which misses small loops */
#define CLOSE ((dehyst_real)0.2)
#define LESS ((dehyst_real)0.15)   /* found where there is nothing: a little too much of a compensator costs more than too little */
#define SHIFT ((dehyst_real)0.01)  /* share of the largest torque that is an offset; half of it ends it */

enum { HH, HL, LL, HQ, LQ, QQ };

void dehyst_fit_reset(dehyst_fit *fit)
{
    for (int32_t i = 0; i < DEHYST_FIT_SUMS; ++i) {
        fit->sum[i] = 0;
        fit->stroke[i] = 0;
    }
    for (int32_t i = 0; i < 4; ++i) {
        fit->load[i] = 0;
        fit->torque[i] = 0;
        fit->angle[i] = 0;
    }
    fit->strokes = 0;
    fit->way = 0;
    fit->rest = 0;
    fit->time = 0;
    fit->mean = 0;
    fit->offset = 0;
    fit->shifted = 0;
    fit->found = 1;
    fit->scale = 1;
    fit->stale = 0;
    fit->spoiled = 0;
}

/* L^2 s/(s + L)^3: what a disturbance of the torque does to the angle, but for a factor; `late`, x[0], of the input. */
static dehyst_real answered(dehyst_real *x, dehyst_real late, dehyst_real gain, dehyst_real input)
{
    x[0] += late * (dehyst_bounded(input, MOST) - x[0]);
    x[1] += gain * (x[0] - x[1]);
    x[2] += gain * (x[0] - x[1] - x[2]);
    x[3] += gain * (x[2] - x[3]);
    return x[3];
}

static void forget_stroke(dehyst_fit *fit, const dehyst_compared *seen)
{
    for (int32_t i = 0; i < DEHYST_FIT_SUMS; ++i) {
        fit->stroke[i] = 0;
    }
    fit->rest = 0;
    fit->time = 0;
    fit->spoiled = seen->touched ? (dehyst_real)1 : (dehyst_real)0;
}

/* What the means of two strokes, one each way, have in common is no hysteresis. */
static void end_stroke(dehyst_fit *fit, const dehyst_compared *seen)
{
    const int swings = !seen->position && fit->time < SWING;
    if (swings || !(fit->stroke[HH] > LEAST) || fit->stroke[HH] * fit->strokes < WHOLE * fit->sum[HH]) {
        return;
    }
    if (fit->spoiled > 0) {
        forget_stroke(fit, seen);
        return;
    }
    for (int32_t i = 0; i < DEHYST_FIT_SUMS; ++i) {
        fit->sum[i] = KEPT * fit->sum[i] + fit->stroke[i];
    }
    const dehyst_real mean = fit->time > 0 ? dehyst_bounded(fit->rest / fit->time, 2 * MOST) : (dehyst_real)0;
    forget_stroke(fit, seen);
    fit->strokes = KEPT * fit->strokes + 1;
    fit->offset = (dehyst_real)0.5 * (mean + fit->mean);
    fit->mean = mean;
    const dehyst_real size = fit->offset < 0 ? -fit->offset : fit->offset;
    const dehyst_real limit = SHIFT * seen->largest * (fit->shifted > 0 ? (dehyst_real)0.5 : (dehyst_real)1);
    fit->shifted = fit->strokes > STROKES && size > limit ? (dehyst_real)1 : (dehyst_real)0;
}

static void judge(dehyst_fit *fit, const dehyst_compared *seen, int direct)
{
    dehyst_real sum[DEHYST_FIT_SUMS] = {0, 0, 0, 0, 0, 0};
    for (int32_t i = 0; i < DEHYST_FIT_SUMS; ++i) {
        sum[i] = fit->sum[i] + fit->stroke[i];
    }
    const dehyst_real needed = direct ? STROKES : ALONG;
    const int both_ways = fit->strokes > (seen->position ? needed : HOMED);
    const dehyst_real gross = GROSS * seen->largest;
    const int loud = seen->position && fit->strokes > 1 && sum[HH] > gross * gross; /* quite another loop is seen soon */
    const dehyst_real slope = sum[QQ] > SMALLEST ? dehyst_bounded(sum[HQ] / sum[QQ], HIGHEST) : (dehyst_real)0;
    const dehyst_real elastic = sum[QQ] > SMALLEST ? dehyst_bounded(sum[LQ] / sum[QQ], HIGHEST) : (dehyst_real)0;
    const dehyst_real own = sum[HH] - slope * sum[HQ];
    if ((both_ways || loud) && sum[HH] > LEAST && own > OWN * sum[HH]) {
        const dehyst_real both = sum[HL] - slope * sum[LQ];
        const dehyst_real scale = dehyst_bounded(both / own, 2);
        const dehyst_real rest = sum[LL] - elastic * sum[LQ] - scale * both;
        const dehyst_real doubt = dehyst_root(rest / (own * (fit->strokes + 1)));
        const dehyst_real distance = scale > 1 ? scale - 1 : 1 - scale;
        const int wide = !direct || scale > 1;
        const dehyst_real raised = wide ? WIDE + (dehyst_real)1.25 * doubt : FAR + (dehyst_real)0.5 * doubt;
        const dehyst_real most = both_ways ? raised : (dehyst_real)0.5 + (dehyst_real)1.5 * doubt;
        const dehyst_real cleared = wide ? CLOSE : NEAR;
        fit->found = scale;
        fit->stale = distance > most || (fit->stale > 0 && distance > cleared) ? (dehyst_real)1 : (dehyst_real)0;
    }
}

void dehyst_fit_step(const dehyst_joint *joint, dehyst_fit *fit, const dehyst_compared *seen, int good)
{
    const dehyst_real third = joint->observer_pole > 0 ? joint->observer_pole * joint->period / 3 : (dehyst_real)0;
    const dehyst_real late = 1 - dehyst_decay(third); /* about as late as the observer sees a torque */
    const dehyst_real gain = 1 - dehyst_decay(joint->pole > 0 ? joint->pole * joint->period : (dehyst_real)0);
    const dehyst_real h = answered(fit->torque, late, gain, seen->torque);
    const dehyst_real l = answered(fit->load, 1, gain, seen->load);
    const dehyst_real q = answered(fit->angle, late, gain, seen->angle);
    if (!good) {
        return;
    }
    const dehyst_real elastic = seen->position ? (dehyst_real)0 : q;
    const dehyst_real product[DEHYST_FIT_SUMS] = {h * h, h * l, l * l, h * elastic, l * elastic, elastic * elastic};
    for (int32_t i = 0; i < DEHYST_FIT_SUMS; ++i) {
        fit->stroke[i] = dehyst_bounded(fit->stroke[i] + joint->period * product[i], HIGHEST);
    }
    if (seen->position) { /* without it nothing is known of the load */
        fit->rest = dehyst_bounded(fit->rest + joint->period * (fit->load[0] - fit->scale * fit->torque[0]), HIGHEST);
    }
    fit->time = dehyst_bounded(fit->time + joint->period, HIGHEST);
    fit->spoiled = seen->touched ? (dehyst_real)1 : fit->spoiled;
    const int moves = seen->velocity > joint->least_speed || seen->velocity < -joint->least_speed;
    if (moves) {
        const dehyst_real way = seen->velocity > 0 ? (dehyst_real)1 : (dehyst_real)-1;
        if (fit->way * way < 0) {
            end_stroke(fit, seen);
        }
        fit->way = way;
    }
    if (!(fit->spoiled > 0)) {
        judge(fit, seen, joint->direct ? 1 : 0);
    }
    const dehyst_real careful = (fit->found - LESS) / (1 - LESS);
    const dehyst_real wanted = fit->stale > 0 ? dehyst_within(careful, 0, 1) : (dehyst_real)1;
    fit->scale = dehyst_faded(fit->scale, wanted, dehyst_fade_part(joint));
}
