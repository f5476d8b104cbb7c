/* The kernels of one level; compiled once per level. */
#include "kernels.h"
#include "lanes.h"

int64_t LANES_NAME(engine_line)(int64_t samples, const double *x, double *y, double center, double low, double high,
                                int monotone, double last, double base, double slope, double origin);

const engine_kernels LANES_NAME(engine_kernels) = {LANES_NAME(engine_line)};
