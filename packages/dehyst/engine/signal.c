#include "signal.h"
#include "patience.h"

/* ---- Turning points. */
typedef struct swings {
    const double *x;
    double swing;
    int64_t low, high; /* extremes since the last turn */
    int direction;     /* of the present swing, 0 before the first */
    int64_t *point;
    int64_t count;
} swings;

static void add_point(swings *s, int64_t k)
{
    if (s->count == 0 || s->point[s->count - 1] < k) s->point[s->count++] = k;
}

/* Look at a sample at which the signal changes its direction. */
static void look(swings *s, int64_t k)
{
    const double v = s->x[k];
    if (v > s->x[s->high]) s->high = k;
    if (v < s->x[s->low]) s->low = k;
    if (s->direction >= 0 && s->x[s->high] - v > s->swing) {
        if (s->direction > 0) add_point(s, s->high); /* before the first swing that counts, nothing has turned yet */
        s->direction = -1;
    } else if (s->direction <= 0 && v - s->x[s->low] > s->swing) {
        if (s->direction < 0) add_point(s, s->low);
        s->direction = 1;
    } else {
        return;
    }
    s->low = s->high = k;
}

int64_t engine_turning_points(int64_t samples, const double *x, double swing, int64_t *point)
{
    if (samples <= 0) return 0;
    swings s = {x, swing, 0, 0, 0, point, 0};
    add_point(&s, 0);
    int rising = -1; /* unknown yet */
    if (swing > 0.0) {
        for (int64_t k = 1, end; (end = engine_until(k, samples, 2)) > k;) {
            for (; k < end; ++k) {
                if (x[k] == x[k - 1]) continue;
                const int up = x[k] > x[k - 1];
                if (rising >= 0 && up != rising) look(&s, k - 1);
                rising = up;
            }
        }
        if (rising >= 0) look(&s, samples - 1);
    }
    add_point(&s, samples - 1);
    return s.count;
}

/* ---- Samples that decide the states. */

/* Put sample k on top of the kept ones; those from `floor` on may give way.
 *
 * a <= b <= v: b is passed on the way to v. p0, p1, p2, v with v at or beyond p1: the swing to p1 is repeated by the one
 * to v. If p2 lies between p0 and p1 the loop p1, p2 is closed and leaves nothing; otherwise p2 has wiped out what p1
 * left behind and only p2 stays. */
static int64_t push(const double *x, int64_t *kept, int64_t count, int64_t floor, int64_t k)
{
    const double v = x[k];
    for (;;) {
        if (count > floor && count >= 2) {
            const double a = x[kept[count - 2]], b = x[kept[count - 1]];
            if ((a <= b && b <= v) || (a >= b && b >= v)) {
                --count;
                continue;
            }
        }
        if (count >= floor + 2 && count >= 3) {
            const double p0 = x[kept[count - 3]], p1 = x[kept[count - 2]], p2 = x[kept[count - 1]];
            if (p1 > p2 ? v >= p1 : v <= p1) {
                if (p1 > p2 ? p2 >= p0 : p2 <= p0) {
                    count -= 2;
                } else {
                    kept[count - 2] = kept[count - 1];
                    --count;
                }
                continue;
            }
        }
        kept[count] = k;
        return count + 1;
    }
}

int64_t engine_essential(const double *x, int64_t rows, const int64_t *row, int64_t *kept, int64_t *place)
{
    int64_t count = 0, floor = 0, next = 0;
    int64_t left = ENGINE_BETWEEN;
    for (int64_t j = 0; j < rows; ++j) {
        for (; next <= row[j]; ++next) {
            if (engine_stops(&left, 10)) return count;
            /* Within a run that rises or falls only its end can stay; of a plateau, its first sample. */
            if (next > 0 && next < row[j] &&
                ((x[next - 1] <= x[next] && x[next] < x[next + 1]) || (x[next - 1] >= x[next] && x[next] > x[next + 1])))
                continue;
            count = push(x, kept, count, floor, next);
            if (next == 0) floor = 1; /* any state may come before the first sample */
        }
        place[j] = count - 1;
        floor = count;
    }
    return count;
}

/* ---- Sums over bins. */
void engine_bin_sums(int64_t samples, const double *x, const double *y, const double *weight, int32_t bins, double low,
                     double high, double *sums)
{
    const double scale = bins / (high - low), last = bins;
    for (int64_t k = 0, end; (end = engine_until(k, samples, 5)) > k;) {
        for (; k < end; ++k) {
            double place = (x[k] - low) * scale;
            place = place > 0.0 ? place : 0.0;
            place = place < last ? place : last;
            int32_t bin = (int32_t)place;
            bin = bin < bins ? bin : bins - 1;
            const double w = weight ? weight[k] : 1.0, t = place - bin;
            double *sum = sums + 5 * (int64_t)bin;
            sum[0] += w;
            sum[1] += w * t;
            sum[2] += w * t * t;
            sum[3] += w * y[k];
            sum[4] += w * t * y[k];
        }
    }
}
