// Oscillators with hysteresis: a force in, motion and hysteretic force out.
#include "arrays.h"

#include <algorithm>

#include "oscillator.h"
#include "stoppable.h"

// (mass, damping, stiffness, cubic), (alpha, beta, gamma, delta, nu) or empty, slopes with (first, spacing), stops.
static nb::tuple oscillate(const In &linear, const In &bouc_wen, const In &slope, const In &grid, const In &threshold,
                           const In &weight, const In &square, const In &force, int32_t steps, double dt,
                           const In &state)
{
    require(linear.size() == 4 && linear.data()[0] > 0.0, "linear is (mass > 0, damping, stiffness, cubic)");
    require(bouc_wen.size() == 0 || bouc_wen.size() == 5, "bouc_wen is (alpha, beta, gamma, delta, nu) or empty");
    require(slope.size() == 0 || (slope.size() >= 2 && grid.size() == 2 && grid.data()[1] > 0.0),
            "slopes need at least two values and a grid (first, spacing > 0)");
    require(slope.size() == 0 || bouc_wen.size() == 0, "one law of the slope at a time");
    require(threshold.size() == weight.size() && threshold.size() == square.size(),
            "thresholds and weights differ in length");
    require(state.size() == 3 + threshold.size(), "state is (y, y', z, stops)");
    require(steps >= 1 && dt > 0.0, "steps must be positive, and so must dt");
    const std::size_t part = 2 * static_cast<std::size_t>(steps);
    require(force.size() >= 1 && (force.size() - 1) % part == 0, "force has 2 steps (samples - 1) + 1 values");
    const std::size_t samples = (force.size() - 1) / part + 1;
    engine_oscillator o = {};
    o.mass = linear.data()[0];
    o.damping = linear.data()[1];
    o.stiffness = linear.data()[2];
    o.cubic = linear.data()[3];
    o.law = bouc_wen.size() > 0 ? ENGINE_BOUC_WEN : slope.size() > 0 ? ENGINE_SLOPES : ENGINE_NO_LAW;
    if (o.law == ENGINE_BOUC_WEN) {
        o.alpha = bouc_wen.data()[0];
        o.beta = bouc_wen.data()[1];
        o.gamma = bouc_wen.data()[2];
        o.delta = bouc_wen.data()[3];
        o.nu = bouc_wen.data()[4];
    }
    o.knots = static_cast<int32_t>(slope.size());
    o.slope = slope.data();
    if (o.law == ENGINE_SLOPES) {
        o.first = grid.data()[0];
        o.spacing = grid.data()[1];
    }
    o.stops = static_cast<int32_t>(threshold.size());
    o.threshold = threshold.data();
    o.weight = weight.data();
    o.square = square.data();
    std::vector<double> after = copy(state);
    Buffer rows(3 * samples);
    int64_t finite = 0;
    {
        nb::gil_scoped_release released;
        finite = engine_oscillate(&o, static_cast<int64_t>(samples), steps, dt, force.data(), after.data(), rows.data());
        std::fill(rows.data() + 3 * static_cast<std::size_t>(finite), rows.data() + 3 * samples, 0.0);
    }
    raise_if_stopped();
    return nb::make_tuple(rows.release(samples, 3), own(std::move(after)), finite);
}

void bind_oscillator(nb::module_ &m)
{
    m.def("oscillate", &oscillate, "linear"_a, "bouc_wen"_a, "slope"_a, "grid"_a, "threshold"_a, "weight"_a,
          "square"_a, "force"_a, "steps"_a, "dt"_a, "state"_a,
          "(rows (samples, 3) of y, y', hysteretic force; state at the end; number of finite samples).");
}
