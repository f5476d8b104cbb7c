/* A small direct inverse with every kind of term and a schedule by pressure and angle, and how it learns. */
#ifndef PROOF_DIRECT_H
#define PROOF_DIRECT_H

#define STOPS 2
#define PATHS 1
#define CREEPS 1
#define MEMORY DEHYST_DIRECT_REALS(STOPS, PATHS, CREEPS)
#define TERMS DEHYST_DIRECT_TERMS(2, STOPS, PATHS, CREEPS)

static const dehyst_real radius[STOPS] = {(dehyst_real)0.01, (dehyst_real)0.3};
static const dehyst_real length[PATHS] = {(dehyst_real)0.1};
static const dehyst_real gain[CREEPS] = {(dehyst_real)0.01};
static const dehyst_real weight[4 * TERMS] = {
    1, 2, 20, 5, 3, 2, 1, -1, 4, 25, 8, 5, 1, 2, (dehyst_real)0.5, 1, 2, 1, 0, 0, 0, 0, 1, 3, 2, 1, 1, 0,
};
static const int32_t group[TERMS - 2] = {0, 1, 0, 2, 3};
static const dehyst_direct direct = {
    2, STOPS, PATHS, CREEPS, 2, 4, 0, radius, length, gain, weight, group, {0, DEHYST_BY_OUTPUT, 0},
    {(dehyst_real)2e5, (dehyst_real)-0.4, 0}, {(dehyst_real)4e5, (dehyst_real)0.4, 0},
    (dehyst_real)0.02, (dehyst_real)-0.5, (dehyst_real)0.5, -60, 60,
};
#define ADAPTATION                                                                                                    \
    {(dehyst_real)0.3, 5, (dehyst_real)0.3, 0, (dehyst_real)0.5, 4, 1, 60, 1, 20, 0, 2, 2, 1}

#endif
