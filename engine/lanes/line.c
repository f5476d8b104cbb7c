/* Evaluation between two events: one line of arithmetic a sample. */
#include "kernels.h"
#include "lanes.h"

int64_t LANES_NAME(engine_line)(int64_t samples, const double *x, double *y, double center, double low, double high,
                                int monotone, double last, double base, double slope, double origin);

int64_t LANES_NAME(engine_line)(int64_t samples, const double *x, double *y, double center, double low, double high,
                                int monotone, double last, double base, double slope, double origin)
{
    int64_t k = 0;
    while (k < samples) {
        const double u = x[k] - center;
        if (!(low <= u && u <= high) || (monotone > 0 && u < last) || (monotone < 0 && u > last)) {
            break;
        }
        y[k] = base + slope * (u - origin);
        last = u;
        ++k;
    }
    return k;
}
