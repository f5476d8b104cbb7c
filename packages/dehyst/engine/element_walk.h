/* Sums of elements along long signals: the answers of core/elements.c to the bit, with maps whose slopes are known and
 * whose pieces are looked for where the last value was. Host only. */
#ifndef ENGINE_ELEMENT_WALK_H
#define ENGINE_ELEMENT_WALK_H

#include "dehyst.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A piece of a map between two of its points. It is the piece of the values from `low` to `high`, which are those of u but
 * at the ends of the map: what lies beyond belongs to the last piece. */
typedef struct walk_piece {
    double low, high, u[2], v[2], slope;
} walk_piece;

typedef struct element_walk {
    dehyst_elements sum;     /* first, so that the core's Newton can be given one for the other */
    const walk_piece *piece; /* of all maps, one after the other */
    const int32_t *first;    /* (n,) the first piece of each element */
    int32_t *at;             /* (n,) the piece of its last value, from the first one on */
} element_walk;

/* Writes the pieces of a map of n >= 2 points, n - 1 of them. */
void walk_pieces(const dehyst_map *map, walk_piece *piece);
/* As dehyst_elements_step and dehyst_elements_solve_step. */
double walk_step(const element_walk *walk, dehyst_elements_state *state, double u, const double *given);
double walk_solve_step(const element_walk *walk, dehyst_elements_state *state, double y, const double *given);

#ifdef __cplusplus
}
#endif

#endif
