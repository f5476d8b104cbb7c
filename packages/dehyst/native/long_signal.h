// A whole model, maps included, over a long signal by the engine.
#ifndef DEHYST_NATIVE_LONG_SIGNAL_H
#define DEHYST_NATIVE_LONG_SIGNAL_H

#include <algorithm>
#include <limits>

#include "arrays.h"
#include "evaluator_handle.h"
#include "stoppable.h"

// Tables cost about 10 ns an operator and 1 us, a step of the core about 1 ns an operator and 5 ns: measured.
inline bool engine_pays(std::size_t samples, std::size_t n) { return samples >= 64 && samples * (n + 5) >= 4096 + 64 * n; }

// y (samples,) = after(H[before(x)]) from states z (n,), which it advances; returns the number of rejected samples.
inline std::size_t run_model(const dehyst_model &model, const double *weight, const double *x, double *y,
                             std::size_t samples, double *z)
{
    const dehyst_pi &pi = model.hysteresis;
    const auto engine = make_evaluator(static_cast<std::size_t>(pi.n), pi.threshold, weight, pi.center, pi.offset, z);
    int64_t rejected = 0;
    {
        const nb::gil_scoped_release release;
        if (model.before.n == 0 && model.after.n == 0) {
            rejected = engine_evaluator_run(engine.get(), static_cast<int64_t>(samples), x, y);
        } else {
            double block[1024];
            Patience patience(100 * std::size(block));
            for (std::size_t k = 0; k < samples && !patience.stops();) {
                const std::size_t part = std::min(samples - k, std::size(block));
                for (std::size_t j = 0; j < part; ++j)
                    block[j] = dehyst_accept(x[k + j]) ? dehyst_map_value(&model.before, x[k + j])
                                                       : std::numeric_limits<double>::quiet_NaN();
                rejected += engine_evaluator_run(engine.get(), static_cast<int64_t>(part), block, y + k);
                for (const std::size_t end = k + part; k < end; ++k) y[k] = dehyst_map_value(&model.after, y[k]);
            }
        }
    }
    raise_if_stopped();
    engine_evaluator_state(engine.get(), z);
    return static_cast<std::size_t>(rejected);
}

#endif
