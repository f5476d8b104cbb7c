// Binding of the streaming normal equations: arrays in, a matrix out, no formula.
#include <cmath>
#include <cstdio>
#include <memory>
#include <mutex>
#include <optional>

#include <nanobind/stl/optional.h>

#include "arrays.h"
#include "dehyst.h"
#include "engine.h"
#include "stoppable.h"

namespace {

using Columns = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

class Gram {
  public:
    Gram(const In &thresholds, const In &state, int32_t targets) : n_(thresholds.size()), targets_(0)
    {
        require(n_ > 0 && n_ < (1u << 24), "thresholds: from 1 to 2^24 operators");
        require(state.size() == n_, "state and thresholds differ in length");
        require(targets >= 0 && targets < 4096, "targets: from 0 to 4095 columns");
        check(thresholds.data(), state.data());
        targets_ = static_cast<std::size_t>(targets);
        gram_.reset(engine_gram_new(static_cast<int32_t>(n_), thresholds.data(), state.data(), targets));
        if (gram_ == nullptr) throw std::bad_alloc();
    }

    void add(const In &x, const Columns &targets, const std::optional<In> &weights)
    {
        const std::size_t samples = x.size();
        if (targets.shape(0) != targets_ || targets.shape(1) != samples)
            throw std::invalid_argument("targets must have the shape (" + std::to_string(targets_) + ", " +
                                        std::to_string(samples) + "): a row each, a column a sample; they have (" +
                                        std::to_string(targets.shape(0)) + ", " + std::to_string(targets.shape(1)) + ")");
        require(!weights || weights->size() == samples, "weights and x differ in length");
        std::vector<const double *> column(targets_ + 1);
        for (std::size_t j = 0; j < targets_; ++j) column[j] = targets.data() + j * samples;
        const double *weight = weights ? weights->data() : nullptr;
        std::size_t done = 0;
        {
            const Turn alone(busy_);
            done = static_cast<std::size_t>(engine_gram_add(gram_.get(), static_cast<int64_t>(samples), x.data(),
                                                            column.data(), weight));
        }
        raise_if_stopped();
        if (done < samples) refuse(done, x.data(), column, weight);
    }

    void skip(const In &x)
    {
        std::size_t done = 0;
        {
            const Turn alone(busy_);
            done = static_cast<std::size_t>(engine_gram_skip(gram_.get(), static_cast<int64_t>(x.size()), x.data()));
        }
        raise_if_stopped();
        if (done < x.size()) bad("x", done, x.data()[done]);
    }

    Matrix take()
    {
        const std::size_t size = 1 + n_ + targets_;
        std::unique_ptr<double[]> sums(new double[size * size]);
        {
            const Turn alone(busy_);
            engine_gram_take(gram_.get(), sums.get());
        }
        raise_if_stopped();
        nb::capsule owner(sums.get(), [](void *p) noexcept { delete[] static_cast<double *>(p); });
        return Matrix(sums.release(), {size, size}, owner);
    }

    void method(int32_t prefix)
    {
        const Turn alone(busy_);
        if (engine_gram_method(gram_.get(), prefix) != 0)
            throw std::invalid_argument("method " + std::to_string(prefix) +
                                        " does not apply: -1 (the signal decides), 0 (events only), a dense prefix (a "
                                        "multiple of 4, up to 64 and up to what holds all operators), or ENGINE_DENSE (up "
                                        "to 64 operators)");
    }

    void only_targets(bool only)
    {
        const Turn alone(busy_);
        engine_gram_only_targets(gram_.get(), only ? 1 : 0);
    }

    Out state()
    {
        std::vector<double> z(n_);
        {
            const Turn alone(busy_);
            engine_gram_state(gram_.get(), z.data());
        }
        return own(std::move(z));
    }

    int64_t events()
    {
        const Turn alone(busy_);
        return engine_gram_events(gram_.get());
    }

    int32_t prefix()
    {
        const Turn alone(busy_);
        return engine_gram_prefix(gram_.get());
    }

  private:
    struct Free {
        void operator()(engine_gram *gram) const { engine_gram_free(gram); }
    };

    [[noreturn]] static void bad(const char *what, std::size_t k, double value)
    {
        char number[32];
        std::snprintf(number, sizeof number, "%g", value);
        throw std::invalid_argument("sample " + std::to_string(k) + " of " + what + " is " + number +
                                    ": the samples before it are in the sums, none from it on; drop or repair it");
    }

    [[noreturn]] static void refuse(std::size_t k, const double *x, const std::vector<const double *> &column,
                                    const double *weight)
    {
        const auto usable = [](double value) { return dehyst_accept(value) != 0; };
        if (!usable(x[k])) bad("x", k, x[k]);
        if (weight != nullptr && !(usable(weight[k]) && weight[k] >= 0.0)) bad("the weights", k, weight[k]);
        for (std::size_t j = 0; j + 1 < column.size(); ++j)
            if (!usable(column[j][k])) bad(("target " + std::to_string(j)).c_str(), k, column[j][k]);
        throw std::runtime_error("sample " + std::to_string(k) + " was refused");
    }

    void check(const double *r, const double *z) const
    {
        for (std::size_t i = 0; i < n_; ++i)
            require(dehyst_accept(r[i]) != 0 && dehyst_accept(z[i]) != 0, "thresholds or state are not finite");
        require(r[0] == 0.0, "the first threshold must be 0: its operator is the input, which drives all others");
        for (std::size_t i = 1; i < n_; ++i) {
            require(r[i] > r[i - 1], "thresholds must increase strictly");
            require(std::isfinite(1 / (r[i] - r[i - 1])), "thresholds are too close: one over their distance overflows");
            const double gap = std::fabs(z[i] - z[i - 1]), size = std::fabs(z[i]);
            require(gap <= r[i] - r[i - 1] + 1e-9 * (size + r[i]), "the state is not admissible: no input leaves it");
        }
    }

    std::size_t n_, targets_;
    std::unique_ptr<engine_gram, Free> gram_;
    std::mutex busy_;
};

}  // namespace

void bind_gram(nb::module_ &m)
{
    nb::class_<Gram>(m, "Gram", "Streaming normal equations of [1 | cells | targets]: memory does not depend on T.")
        .def(nb::init<const In &, const In &, int32_t>(), "thresholds"_a, "state"_a, "targets"_a)
        .def("add", &Gram::add, "x"_a, "targets"_a, "weights"_a.none() = nb::none(),
             "Add the samples x (T,) with targets (m, T) and weights (T,) >= 0, ones if None. Ctrl-C during a call leaves part "
             "of its samples in the sums, or of the sums taken: what goes on needs a new one.")
        .def("skip", &Gram::skip, "x"_a, "Advance the state by x without adding anything; Ctrl-C as with add.")
        .def("take", &Gram::take,
             "Sums (1 + n + m, 1 + n + m) since the last take; the state goes on. Ctrl-C as with add.")
        .def("method", &Gram::method, "prefix"_a, "-1: the signal decides; 0: events only; a dense prefix of 4, 8, ..., or ENGINE_DENSE.")
        .def("only_targets", &Gram::only_targets, "only"_a, "Leave out sums of cells with cells and with ones.")
        .def_prop_ro("events", &Gram::events, "Events so far, behind the dense prefix of the time.")
        .def_prop_ro("prefix", &Gram::prefix, "Operators taken one by one at present.")
        .def_prop_ro("state", &Gram::state, nb::rv_policy::move, "Play states z (n,).");
}
