// Binding of the hysteresis models: no formula.
#include <algorithm>
#include <cmath>

#include "arrays.h"
#include "dehyst.h"
#include "evaluator_handle.h"
#include "long_signal.h"
#include "model_parameters.h"
#include "no_pickle.h"
#include "sample.h"
#include "stoppable.h"

namespace {

// A model with its state: one call a sample in real time, or a whole array at once.
class Stepper {
  public:
    Stepper(const In &r, const In &w, double center, double offset, const In &bu, const In &bv, const In &au,
            const In &av, const In &z0)
        : parameters_(r, w, center, offset, bu, bv, au, av), start_(copy(z0)), z_(start_)
    {
        require(start_.size() == parameters_.threshold.size(), "state and thresholds differ in length");
        state_.z = z_.data();
        reset();
    }
    Stepper(const Stepper &) = delete;
    Stepper &operator=(const Stepper &) = delete;

    double step(double x) { return dehyst_model_step(&parameters_.view, &state_, x); }

    // Long signals go through the engine, which agrees with the steps to rounding; short ones are stepped.
    nb::tuple simulate(const In &x)
    {
        const std::size_t samples = x.size();
        Buffer y(samples);
        std::size_t rejected = 0, k = 0;
        const bool with_engine = engine_pays(samples, z_.size()) && takes_engine();
        Patience patience(20 + z_.size());
        for (; k < samples && (!with_engine || !dehyst_accept(x.data()[k])); ++k) {
            patience.go_on();
            y.data()[k] = step(x.data()[k]);
            rejected += state_.flags & DEHYST_REJECTED;
        }
        if (k < samples) rejected += run_engine(x.data() + k, y.data() + k, samples - k);
        return nb::make_tuple(y.release(), rejected);
    }

    void reset() { dehyst_model_reset(&parameters_.view, &state_, start_.data()); }

    Out save() const
    {
        std::vector<double> image(z_);
        image.push_back(state_.output);
        image.push_back(static_cast<double>(state_.flags));
        return own(std::move(image));
    }

    void restore(const In &image)
    {
        require(image.size() == z_.size() + 2, "saved state belongs to a model with another number of operators");
        for (std::size_t i = 0; i < image.size(); ++i)
            require(dehyst_accept(image.data()[i]) != 0, "saved state is not finite");
        const double *z = image.data(), output = z[z_.size()], flags = z[z_.size() + 1];
        require(flags == 0.0 || flags == 2.0 || flags == 3.0, "saved state carries unknown flags");
        require(dehyst_admissible(static_cast<int32_t>(z_.size()), parameters_.threshold.data(), z) != 0,
                "saved state is not admissible: no input leaves it");
        require(belongs(output, z), "saved state belongs to another model");
        z_.assign(z, z + z_.size());
        state_.z = z_.data();
        state_.output = output;
        state_.flags = static_cast<uint32_t>(flags);
    }

    nb::tuple parameters() const { return parameters_.as_tuple(start_); }
    Out state() const { return own(std::vector<double>(z_)); }
    double output() const { return state_.output; }
    bool rejected() const { return (state_.flags & DEHYST_REJECTED) != 0; }
    bool rejected_ever() const { return (state_.flags & DEHYST_REJECTED_EVER) != 0; }

  private:
    // Whether the output is that of the states, but for the order of the sum: this finds images of another model.
    bool belongs(double output, const double *z) const
    {
        const std::vector<double> &slope = parameters_.slope;
        double size = std::fabs(output) + std::fabs(parameters_.view.hysteresis.offset);
        for (std::size_t i = 0; i < slope.size(); ++i)
            size += std::fabs(slope[i] * (z[i] - (i + 1 < slope.size() ? z[i + 1] : 0.0)));
        return std::fabs(output - dehyst_model_output(&parameters_.view, z)) <= 1e-9 * size;
    }

    bool takes_engine() const
    {
        const dehyst_pi &pi = parameters_.view.hysteresis;
        return engine_takes(z_.size(), pi.threshold, parameters_.weight.data(), pi.center, pi.offset, z_.data());
    }

    // Samples by the engine, the first of which is good. It works on a copy of the state: the interpreter is free meanwhile.
    std::size_t run_engine(const double *x, double *y, std::size_t samples)
    {
        std::vector<double> z(z_);
        const std::size_t rejected = run_model(parameters_.view, parameters_.weight.data(), x, y, samples, z.data());
        std::copy(z.begin(), z.end(), z_.begin());
        state_.output = dehyst_model_output(&parameters_.view, z_.data());
        state_.flags &= ~static_cast<uint32_t>(DEHYST_REJECTED);
        if (rejected > 0) state_.flags |= DEHYST_REJECTED_EVER;
        if (!dehyst_accept(x[samples - 1])) state_.flags |= DEHYST_REJECTED;
        return rejected;
    }

    ModelParameters parameters_;
    std::vector<double> start_, z_;
    dehyst_state state_{};
};

// The same by the definition: for states that no input leaves, which the engine does not hold.
void step_plays(const In &x, const In &r, const Rows &rows, std::vector<double> &z, double *bank)
{
    const std::size_t n = r.size();
    std::size_t next = 0;
    Patience patience(10 + 2 * n);
    for (std::size_t k = 0; k < x.size(); ++k) {
        patience.go_on();
        if (dehyst_accept(x.data()[k])) dehyst_play_step(static_cast<int32_t>(n), r.data(), x.data()[k], z.data());
        if (next < rows.size() && rows.data()[next] == static_cast<int64_t>(k))
            std::copy(z.begin(), z.end(), bank + n * next++);
    }
}

// Play outputs at chosen samples only: a long log is fitted in pieces that fit into memory.
nb::tuple play_bank(const In &x, const In &r, const In &z0, const Rows &rows)
{
    require(r.size() == z0.size() && r.size() > 0, "thresholds and state differ in length");
    const std::size_t samples = x.size(), n = r.size(), kept = rows.size();
    for (std::size_t j = 0; j < kept; ++j)
        require(rows.data()[j] >= (j == 0 ? 0 : rows.data()[j - 1] + 1) &&
                    rows.data()[j] < static_cast<int64_t>(samples),
                "rows must increase strictly and lie within the signal");
    Buffer bank(kept * n);
    std::vector<double> z = copy(z0);
    if (engine_takes(n, r.data(), r.data(), 0.0, 0.0, z.data())) {
        int failed = 0;
        {
            const nb::gil_scoped_release release;
            failed = engine_plays(static_cast<int32_t>(n), r.data(), z.data(), static_cast<int64_t>(samples), x.data(),
                                  static_cast<int64_t>(kept), rows.data(), bank.data());
        }
        raise_if_stopped();
        if (failed != 0) throw std::bad_alloc();
    } else {
        step_plays(x, r, rows, z, bank.data());
    }
    return nb::make_tuple(bank.release(kept, n), own(std::move(z)));
}

nb::tuple pi_invert(const In &r, const In &w, const In &z)
{
    require(r.size() == w.size() && r.size() == z.size() && r.size() > 0, "arrays differ in length");
    std::vector<double> ri(r.size()), wi(r.size()), zi(r.size());
    const int32_t fault = dehyst_pi_invert(static_cast<int32_t>(r.size()), r.data(), w.data(), z.data(), ri.data(),
                                           wi.data(), zi.data());
    return nb::make_tuple(fault, own(std::move(ri)), own(std::move(wi)), own(std::move(zi)));
}

Out stop_to_play(double slope, const In &s)
{
    require(s.size() > 0, "no stop weights");
    std::vector<double> w(s.size());
    dehyst_stop_to_play(static_cast<int32_t>(s.size()), slope, s.data(), w.data());
    return own(std::move(w));
}

Out map_values(const In &u, const In &v, const In &x)
{
    require(u.size() == v.size() && u.size() != 1, "map is not a list of pairs");
    const dehyst_map map = {static_cast<int32_t>(u.size()), u.data(), v.data()};
    std::vector<double> y(x.size());
    Patience patience(20);
    for (std::size_t k = 0; k < x.size(); ++k) {
        patience.go_on();
        y[k] = dehyst_map_value(&map, x.data()[k]);
    }
    return own(std::move(y));
}

}  // namespace

void bind_models(nb::module_ &m)
{
    m.attr("INPUT_LIMIT") = DEHYST_INPUT_LIMIT;
    m.def("accept", [](double x) { return dehyst_accept(x) != 0; }, "x"_a);
    m.def("play_bank", &play_bank, "x"_a, "thresholds"_a, "state"_a, "rows"_a,
          "Outputs (m, n) of n play operators at the samples `rows` (m,), and their states (n,) after the signal.");
    m.def("pi_invert", &pi_invert, "thresholds"_a, "weights"_a, "state"_a,
          "(fault, r', w', z') of the closed inverse; fault 0, or the index of the offending partial sum.");
    m.def("stop_to_play", &stop_to_play, "slope"_a, "stop_weights"_a, "Play weights of a stop form.");
    m.def("map_values", &map_values, "u"_a, "v"_a, "x"_a, "Values of a piecewise linear map.");
    nb::class_<Stepper> bound(m, "Stepper",
                                 "A model with its state, one call a sample.");
    bound
        .def(nb::init<const In &, const In &, double, double, const In &, const In &, const In &, const In &,
                      const In &>(),
             "thresholds"_a, "weights"_a, "center"_a, "offset"_a, "before_u"_a, "before_v"_a, "after_u"_a,
             "after_v"_a, "state"_a)
        .def("simulate", &Stepper::simulate, "x"_a, "(outputs (T,), number of rejected samples).")
        .def("reset", &Stepper::reset, "Back to the model's start state, flags cleared.")
        .def("save", &Stepper::save, "Image (n + 2,) of the state for `restore`.")
        .def("restore", &Stepper::restore, "image"_a, "Continue from a saved image.")
        .def_prop_ro("method", [](const Stepper &) { return "dense"; }, "How it steps.")
        .def_prop_ro("parameters", &Stepper::parameters, "What it was made of, for a joint controller's compensator.")
        .def_prop_ro("state", &Stepper::state, nb::rv_policy::move, "Play states z (n,).")
        .def_prop_ro("output", &Stepper::output, "Last good output.")
        .def_prop_ro("rejected", &Stepper::rejected, "The last sample was rejected.")
        .def_prop_ro("rejected_ever", &Stepper::rejected_ever, "Some sample since the last reset was rejected.");
    refuse_pickling(bound);
    bind_call(bound);
}
