/* Preisach operator by its Everett function: a sample costs a search among the knots and the turns that it wipes out. */
#include "preisach.h"
#include "patience.h"

#include <string.h>

/* Cell of a value, 0 .. n - 1; a value on a knot belongs to the upper one. */
static int32_t cell_of(const engine_preisach *p, double x)
{
    int32_t low = 0, high = p->n;
    while (high - low > 1) {
        const int32_t middle = low + (high - low) / 2;
        if (p->knot[middle] <= x) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

/* A branch that left a turn: half the change of the output up to the k-th knot on its way, k = 0 the first one. */
typedef struct branch {
    const double *from, *to; /* E at the knots on the way, for the two knots around the turn */
    int64_t step;            /* from one knot of the way to the next */
    double part;             /* place of the turn between the two */
    int32_t cell;            /* that it lies in */
    int32_t ahead;           /* knots on the way, >= 1 */
    int sign;                /* 1 rising, -1 falling */
} branch;

static branch branch_of(const engine_preisach *p, const preisach_memory *m)
{
    const preisach_turn turn = m->turn[m->depth - 1];
    const int32_t n = p->n, cell = cell_of(p, turn.x);
    const double part = (turn.x - p->knot[cell]) / (p->knot[cell + 1] - p->knot[cell]);
    const int64_t row = n + 1;
    const double *e = p->everett + row * (cell + 1) + cell;
    const branch up = {e, e + 1, row, part, cell, n - cell, 1}, down = {e - row, e, -1, part, cell, cell + 1, -1};
    return m->depth % 2 ? up : down;
}

/* E between the turn and the k-th knot on the way; beside the diagonal one of the two columns is 0. */
static double at_knot(const branch *b, int32_t k)
{
    const double from = b->sign < 0 && k == 0 ? 0.0 : b->from[k * b->step];
    const double to = b->sign > 0 && k == 0 ? 0.0 : b->to[k * b->step];
    return (1.0 - b->part) * from + b->part * to;
}

static double knot_ahead(const engine_preisach *p, const branch *b, int32_t k)
{
    return p->knot[b->sign > 0 ? b->cell + 1 + k : b->cell - k];
}

/* Output at x on the branch of the last turn. */
static double output_at(const engine_preisach *p, const preisach_memory *m, double x)
{
    const preisach_turn turn = m->turn[m->depth - 1];
    const branch b = branch_of(p, m);
    const int32_t cell = cell_of(p, x);
    int32_t k = b.sign > 0 ? cell - b.cell - 1 : b.cell - cell - 1; /* last knot passed, -1 if none */
    k = k < -1 ? -1 : k;
    double x_0 = turn.x, e_0 = 0.0;
    if (k >= 0) {
        x_0 = knot_ahead(p, &b, k);
        e_0 = at_knot(&b, k);
    }
    const double x_1 = knot_ahead(p, &b, k + 1);
    const double place = x_1 == x_0 ? 0.0 : (x - x_0) / (x_1 - x_0);
    return turn.y + 2.0 * b.sign * (e_0 + place * (at_knot(&b, k + 1) - e_0));
}

/* Input at which the branch of the last turn has a given half change of the output. */
static double input_at(const engine_preisach *p, const preisach_memory *m, double change)
{
    const branch b = branch_of(p, m);
    int32_t low = -1, high = b.ahead - 1;
    while (high - low > 1) {
        const int32_t middle = low + (high - low) / 2;
        if (at_knot(&b, middle) <= change) {
            low = middle;
        } else {
            high = middle;
        }
    }
    const double x_0 = low < 0 ? m->turn[m->depth - 1].x : knot_ahead(p, &b, low), e_0 = low < 0 ? 0.0 : at_knot(&b, low);
    const double x_1 = knot_ahead(p, &b, high), e_1 = at_knot(&b, high);
    if (change >= e_1) {
        return x_1; /* the knot to the bit: the last one is the end of the memory */
    }
    const double x = e_1 > e_0 ? x_0 + (change - e_0) / (e_1 - e_0) * (x_1 - x_0) : x_0;
    return (b.sign > 0 ? x > x_1 : x < x_1) ? x_1 : x;
}

/* Direction of the branch in use: a lowest turn is left rising. */
static int rising(const preisach_memory *m) { return m->depth % 2; }

/* Remember the present sample as a turn if the next one goes the other way. */
static void turn_to(preisach_memory *m, int up)
{
    if (rising(m) != up) {
        m->turn[m->depth++] = m->now;
    }
}

static void move_to(const engine_preisach *p, preisach_memory *m, double x)
{
    if (x == m->now.x) {
        return;
    }
    const int up = x > m->now.x;
    turn_to(m, up);
    while (m->depth >= 2 && (up ? x >= m->turn[m->depth - 2].x : x <= m->turn[m->depth - 2].x)) {
        m->depth -= 2;
        if (m->depth == 0) { /* back at the first knot: all relays are down */
            m->depth = 1;
            m->now = m->turn[0];
            return;
        }
    }
    m->now.x = x;
    m->now.y = output_at(p, m, x);
}

void engine_preisach_run(const engine_preisach *p, preisach_memory *m, int64_t samples, const double *x, double *y)
{
    const double low = p->knot[0], high = p->knot[p->n];
    for (int64_t k = 0, left = ENGINE_BETWEEN; k < samples && !engine_stops(&left, 50); ++k) {
        const double over = x[k] > high ? x[k] - high : 0.0, under = x[k] < low ? x[k] - low : 0.0;
        move_to(p, m, over > 0.0 ? high : under < 0.0 ? low : x[k]);
        y[k] = m->now.y + p->above * over + p->below * under;
    }
}

/* One wanted output; returns the input. */
static double follow(const engine_preisach *p, preisach_memory *m, double y)
{
    const double low = p->knot[0], high = p->knot[p->n];
    if (y == m->now.y) {
        return m->now.x;
    }
    const int up = y > m->now.y;
    if (up && m->now.x == high) {
        return high + (y - m->now.y) / p->above;
    }
    if (!up && m->now.x == low) {
        return low + (y - m->now.y) / p->below;
    }
    turn_to(m, up);
    while (m->depth >= 2 && (up ? y >= m->turn[m->depth - 2].y : y <= m->turn[m->depth - 2].y)) {
        m->depth -= 2;
        if (m->depth == 0) {
            m->depth = 1;
            m->now = m->turn[0];
            return low + (y - m->now.y) / p->below;
        }
    }
    const preisach_turn turn = m->turn[m->depth - 1];
    const double x = input_at(p, m, 0.5 * (up ? y - turn.y : turn.y - y));
    if (x == high && up) { /* the way ends at the last knot */
        m->now.x = high;
        m->now.y = output_at(p, m, high);
        return high + (y > m->now.y ? (y - m->now.y) / p->above : 0.0);
    }
    m->now.x = x;
    m->now.y = y;
    return x;
}

void engine_preisach_invert(const engine_preisach *p, preisach_memory *m, int64_t samples, const double *y, double *x)
{
    for (int64_t k = 0, left = ENGINE_BETWEEN; k < samples && !engine_stops(&left, 200); ++k) {
        x[k] = follow(p, m, y[k]);
    }
}

/* Add weight E(a, b) to the table of factors of E at the knots, (n + 1, n + 1). */
static void add_everett(const engine_preisach *p, double a, double b, double weight, double *factor)
{
    const int32_t i = cell_of(p, a), j = cell_of(p, b), row = p->n + 1;
    const double *knot = p->knot;
    if (i == j) {
        factor[(i + 1) * row + i] += weight * (a - b) / (knot[i + 1] - knot[i]);
        return;
    }
    const double u = (a - knot[i]) / (knot[i + 1] - knot[i]), v = (b - knot[j]) / (knot[j + 1] - knot[j]);
    double *const f = factor + i * row + j;
    f[0] += weight * (1.0 - u) * (1.0 - v);
    f[1] += weight * (1.0 - u) * v; /* on the diagonal E is 0, and no cell reads it */
    f[row] += weight * u * (1.0 - v);
    f[row + 1] += weight * u * v;
}

/* Cell (i, j) is part of E(knot a, knot b) where a > i and b <= j: sums of the factors from the top left corner. */
static void cells_of(int32_t n, double *factor, double *state)
{
    const int32_t row = n + 1;
    for (int32_t i = n - 1; i >= 0; --i) {
        double sum = 0.0;
        double *const now = factor + (i + 1) * row, *const next = i + 2 <= n ? now + row : NULL;
        for (int32_t j = 0; j <= i; ++j) {
            sum += now[j];
            now[j] = sum + (next == NULL ? 0.0 : next[j]);
            state[(int64_t)i * (i + 1) / 2 + j] = now[j] - 1.0;
        }
    }
}

void engine_preisach_cells(const engine_preisach *p, preisach_memory *m, int64_t samples, const double *x,
                           double *scratch, double *out)
{
    const int32_t n = p->n;
    const size_t table = (size_t)(n + 1) * (size_t)(n + 1) * sizeof *scratch;
    const double low = p->knot[0], high = p->knot[n];
    for (int64_t k = 0, left = ENGINE_BETWEEN; k < samples && !engine_stops(&left, 100 + (int64_t)n * n); ++k) {
        move_to(p, m, x[k] > high ? high : x[k] < low ? low : x[k]);
        memset(scratch, 0, table);
        for (int32_t q = 0; q < m->depth; ++q) {
            const double from = m->turn[q].x, to = q + 1 < m->depth ? m->turn[q + 1].x : m->now.x;
            if (q % 2) {
                add_everett(p, from, to, -2.0, scratch);
            } else {
                add_everett(p, to, from, 2.0, scratch);
            }
        }
        cells_of(n, scratch, out + k * ((int64_t)n * (n + 1) / 2));
    }
}
