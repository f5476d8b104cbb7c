// Parameters of a hysteresis model as the binding owns them.
#ifndef DEHYST_NATIVE_MODEL_PARAMETERS_H
#define DEHYST_NATIVE_MODEL_PARAMETERS_H

#include "arrays.h"
#include "dehyst.h"

// Parameters of a model, owned; `view` is what the core reads.
struct ModelParameters {
    std::vector<double> before_u, before_v, threshold, weight, slope, loading, after_u, after_v;
    dehyst_model view{};

    ModelParameters(const In &r, const In &w, double center, double offset, const In &bu, const In &bv, const In &au,
               const In &av)
        : before_u(copy(bu)), before_v(copy(bv)), threshold(copy(r)), weight(copy(w)), slope(w.size()),
          loading(w.size()), after_u(copy(au)), after_v(copy(av))
    {
        require(!threshold.empty() && threshold.size() == weight.size(), "thresholds and weights differ in length");
        require(before_u.size() == before_v.size() && before_u.size() != 1, "map 'before' is not a list of pairs");
        require(after_u.size() == after_v.size() && after_u.size() != 1, "map 'after' is not a list of pairs");
        view.before = {static_cast<int32_t>(before_u.size()), before_u.data(), before_v.data()};
        const int32_t n = static_cast<int32_t>(threshold.size());
        dehyst_pi_tables(n, threshold.data(), weight.data(), slope.data(), loading.data());
        view.hysteresis = {n, threshold.data(), slope.data(), loading.data(), center, offset};
        view.after = {static_cast<int32_t>(after_u.size()), after_u.data(), after_v.data()};
    }
    // What a stepper shows as its parameters, and a compensator is made of.
    nb::tuple as_tuple(const std::vector<double> &start) const
    {
        const auto array = [](const std::vector<double> &values) { return own(std::vector<double>(values)); };
        return nb::make_tuple(array(threshold), array(weight), view.hysteresis.center, view.hysteresis.offset,
                              array(before_u), array(before_v), array(after_u), array(after_v), array(start));
    }

    ModelParameters(const ModelParameters &) = delete;
    ModelParameters &operator=(const ModelParameters &) = delete;
};

#endif
