/* Krasnosel'skii-Pokrovskii operator: a sample costs the ridges of all lines and a comparison a kernel. */
#include "krasnoselskii.h"
#include "patience.h"

#include <string.h>

/* Ridges of all lines at an input, (n,); they fall with the line. */
static void ridges(const engine_kernels *p, double x, double *r)
{
    for (int32_t i = 0; i < p->n; ++i) {
        const double u = (x - p->line[i]) / p->ridge;
        r[i] = u <= 0.0 ? -1.0 : u >= 1.0 ? 1.0 : 2.0 * u - 1.0;
    }
}

static double limited(double z, double low, double high)
{
    const double most = z < high ? z : high;
    return most > low ? most : low;
}

/* Output beyond the ridges: reversible straight lines. */
static double beyond(const engine_kernels *p, double x)
{
    const double low = p->line[0], high = p->line[p->n - 1] + p->ridge;
    return x > high ? p->above * (x - high) : x < low ? p->below * (x - low) : 0.0;
}

static void move_all(const engine_kernels *p, const double *r, double *z)
{
    for (int32_t i = 0, c = 0; i < p->n; ++i) {
        for (int32_t j = 0; j <= i; ++j, ++c) {
            z[c] = limited(z[c], r[i], r[j]);
        }
    }
}

void engine_kernels_run(const engine_kernels *p, double *z, int64_t samples, const double *x, double *r, double *y)
{
    for (int64_t k = 0, left = ENGINE_BETWEEN; k < samples && !engine_stops(&left, 10 + (int64_t)p->n * p->n); ++k) {
        double sum = p->offset;
        ridges(p, x[k], r);
        for (int32_t i = 0, c = 0; i < p->n; ++i) {
            for (int32_t j = 0; j <= i; ++j, ++c) {
                z[c] = limited(z[c], r[i], r[j]);
                sum += p->weight[c] * z[c];
            }
        }
        y[k] = sum + beyond(p, x[k]);
    }
}

void engine_kernels_states(const engine_kernels *p, double *z, int64_t samples, const double *x, double *r, double *out)
{
    const int64_t kernels = (int64_t)p->n * (p->n + 1) / 2;
    for (int64_t k = 0, left = ENGINE_BETWEEN; k < samples && !engine_stops(&left, 10 + kernels); ++k) {
        ridges(p, x[k], r);
        move_all(p, r, z);
        memcpy(out + k * kernels, z, (size_t)kernels * sizeof *z);
    }
}

/* Output at an input if it came next. */
static double value(const engine_kernels *p, const double *z, double x, double *r)
{
    double even = p->offset, odd = 0.0; /* two sums at once: neither waits for the other */
    ridges(p, x, r);
    for (int32_t i = 0, c = 0; i < p->n; ++i) {
        const double low = r[i];
        int32_t j = 0;
        for (; j < i; j += 2, c += 2) {
            even += p->weight[c] * limited(z[c], low, r[j]);
            odd += p->weight[c + 1] * limited(z[c + 1], low, r[j + 1]);
        }
        if (j == i) {
            even += p->weight[c] * low;
            ++c;
        }
    }
    return even + odd + beyond(p, x);
}

/* The same and the slope there. */
static double value_and_slope(const engine_kernels *p, const double *z, double x, double *r, double *slope)
{
    const double steep = 2.0 / p->ridge;
    double sum = p->offset, moving = 0.0;
    ridges(p, x, r);
    for (int32_t i = 0, c = 0; i < p->n; ++i) {
        const double on_i = r[i] > -1.0 && r[i] < 1.0 ? steep : 0.0;
        for (int32_t j = 0; j <= i; ++j, ++c) {
            sum += p->weight[c] * limited(z[c], r[i], r[j]);
            if (z[c] < r[i] || i == j) {
                moving += p->weight[c] * on_i;
            } else if (z[c] > r[j]) {
                moving += r[j] > -1.0 && r[j] < 1.0 ? p->weight[c] * steep : 0.0;
            }
        }
    }
    *slope = moving;
    return sum + beyond(p, x);
}

typedef struct bracket {
    double low, high;    /* inputs around the wanted one */
    double under, over;  /* outputs there, under <= wanted <= over */
} bracket;

/* Newton's steps on a rising function of straight pieces: exact once on the right piece; halves where they leave the bracket. */
static double root(const engine_kernels *p, const double *z, double y, bracket b, double *r)
{
    double x = b.over > b.under ? b.low + (y - b.under) / (b.over - b.under) * (b.high - b.low) : b.low;
    for (int step = 0; step < 100; ++step) {
        double slope;
        const double f = value_and_slope(p, z, x, r, &slope);
        if (f == y) {
            return x;
        }
        if (f < y) {
            b.low = x;
        } else {
            b.high = x;
        }
        double next = slope > 0.0 ? x + (y - f) / slope : b.low;
        if (!(next > b.low && next < b.high)) {
            const double size = (x < 0.0 ? -x : x) + 1.0;
            const double off = next - x < 0.0 ? x - next : next - x;
            if (slope > 0.0 && off <= 4e-16 * size) { /* rounding pushed it out */
                return x;
            }
            next = 0.5 * (b.low + b.high);
        }
        if (next == x || !(next > b.low && next < b.high)) {
            return next;
        }
        x = next;
    }
    return x;
}

/* Where line k begins; k = n is where the last ridge ends. */
static double edge(const engine_kernels *p, int32_t k) { return k < p->n ? p->line[k] : p->line[p->n - 1] + p->ridge; }

static double follow(const engine_kernels *p, const double *z, double y, double *r)
{
    int32_t low = 0, high = p->n;
    bracket b = {edge(p, low), edge(p, high), 0.0, 0.0};
    b.under = value(p, z, b.low, r);
    b.over = value(p, z, b.high, r);
    if (y <= b.under) {
        return b.low + (y - b.under) / p->below;
    }
    if (y >= b.over) {
        return b.high + (y - b.over) / p->above;
    }
    while (high - low > 1) {
        const int32_t middle = low + (high - low) / 2;
        const double x = edge(p, middle), f = value(p, z, x, r);
        if (f <= y) {
            low = middle;
            b.low = x;
            b.under = f;
        } else {
            high = middle;
            b.high = x;
            b.over = f;
        }
    }
    return root(p, z, y, b, r);
}

void engine_kernels_invert(const engine_kernels *p, double *z, int64_t samples, const double *y, double *r, double *x)
{
    for (int64_t k = 0, left = ENGINE_BETWEEN; k < samples && !engine_stops(&left, 100 + 20 * (int64_t)p->n * p->n); ++k) {
        x[k] = follow(p, z, y[k], r);
        ridges(p, x[k], r);
        move_all(p, r, z);
    }
}
