/* A sum of elements of every kind, with maps and two schedules. */
#ifndef PROOF_ELEMENTS_H
#define PROOF_ELEMENTS_H

#include "dehyst.h"

#define ELEMENTS DEHYST_KINDS
#define RADIUS ((dehyst_real)0.25)
#define LOW ((dehyst_real)-2)
#define HIGH ((dehyst_real)2)

static const dehyst_real u[3] = {-1, 0, 1};
static const dehyst_real v[3] = {-1, (dehyst_real)0.25, 1};
static const dehyst_element element[ELEMENTS] = {{DEHYST_INPUT, 0, 0, 0, 1, {0, 0, 0}},
                                                 {DEHYST_PLAY, 1, RADIUS, 0, 1, {3, u, v}},
                                                 {DEHYST_STOP, 2, RADIUS, 0, 1, {0, 0, 0}},
                                                 {DEHYST_CREEP, 0, RADIUS, (dehyst_real)0.5, 1, {0, 0, 0}},
                                                 {DEHYST_RELAX, 0, 0, (dehyst_real)0.5, 1, {3, u, v}},
                                                 {DEHYST_PRODUCT, 0, 1, (dehyst_real)0.5, 1, {3, u, v}},
                                                 {DEHYST_PAST, 0, 0, (dehyst_real)0.5, 1, {0, 0, 0}},
                                                 {DEHYST_PATH, 0, RADIUS, 0, 1, {0, 0, 0}},
                                                 {DEHYST_WIDE, 0, RADIUS, (dehyst_real)0.5, 1, {0, 0, 0}}};
#define SUM                                                                                                           \
    {ELEMENTS, element, {3, u, v}, {3, u, v}, 0, LOW, HIGH, 2, {DEHYST_BY_OUTPUT, 1, 0}, {-1, 0, 0}, {1, 1, 0}}

static dehyst_real memory[ELEMENTS];

#endif
