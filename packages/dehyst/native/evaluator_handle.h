// The engine's evaluator as the binding owns it.
#ifndef DEHYST_NATIVE_EVALUATOR_HANDLE_H
#define DEHYST_NATIVE_EVALUATOR_HANDLE_H

#include <cmath>
#include <memory>
#include <new>

#include "dehyst.h"
#include "engine.h"

struct FreeEvaluator {
    void operator()(engine_evaluator *evaluator) const noexcept { engine_evaluator_free(evaluator); }
};
using EvaluatorHandle = std::unique_ptr<engine_evaluator, FreeEvaluator>;

// True if |z_i - z_{i+1}| <= r_{i+1} - r_i up to rounding: the engine's stack holds no other state.
inline bool engine_takes_state(std::size_t n, const double *r, const double *z)
{
    for (std::size_t i = 0; i < n; ++i) {
        if (!dehyst_accept(z[i])) return false;
        if (i > 0) {
            const double slack = 0x1p-50 * (std::fabs(z[i]) + std::fabs(z[i - 1]) + r[i]);
            if (std::fabs(z[i] - z[i - 1]) > r[i] - r[i - 1] + slack) return false;
        }
    }
    return true;
}

// True for finite parameters with thresholds that increase from 0 or more.
inline bool engine_takes_operator(std::size_t n, const double *r, const double *w, double center, double offset)
{
    bool good = n > 0 && n < (std::size_t{1} << 30) && dehyst_accept(center) && dehyst_accept(offset) && r[0] >= 0;
    for (std::size_t i = 0; good && i < n; ++i)
        good = dehyst_accept(r[i]) && dehyst_accept(w[i]) && (i == 0 || r[i] > r[i - 1]);
    return good;
}

inline bool engine_takes(std::size_t n, const double *r, const double *w, double center, double offset, const double *z)
{
    return engine_takes_operator(n, r, w, center, offset) && engine_takes_state(n, r, z);
}

inline EvaluatorHandle make_evaluator(std::size_t n, const double *r, const double *w, double center, double offset,
                                      const double *z)
{
    EvaluatorHandle handle(engine_evaluator_new(static_cast<int32_t>(n), r, w, center, offset, z));
    if (!handle) throw std::bad_alloc();
    return handle;
}

#endif
