// Binding of a direct inverse as a function block of a machine: no formula.
#include "direct_parameters.h"
#include "sample.h"
#include "stoppable.h"

namespace {

using Table = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Switch = nb::ndarray<const bool, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

class DirectBlock {
  public:
    DirectBlock(const nb::tuple &parameters, double slope, double offset, double fade) : direct_(parameters)
    {
        require(dehyst_accept(slope) && dehyst_accept(offset) && fade >= 1e-12 && fade <= 1.0, "a line that is none");
        block_.direct = direct_.view;
        block_.line_slope = slope;
        block_.line_offset = offset;
        block_.fade = fade;
        state_.direct.memory = direct_.memory.data();
        reset();
    }
    DirectBlock(const DirectBlock &) = delete;
    DirectBlock &operator=(const DirectBlock &) = delete;

    void reset() { dehyst_direct_block_reset(&block_, &state_); }

    double step(nb::handle y, nb::handle rate, nb::handle first, nb::handle second, nb::handle third, bool on)
    {
        const double given[DEHYST_GIVEN] = {sample_of(first), sample_of(second), sample_of(third)};
        return dehyst_direct_block_step(&block_, &state_, sample_of(y), sample_of(rate), given, on ? 1 : 0);
    }

    // y (T,), rate and scheduling variables (T, 4), on (T,) -> u and flags, (T,).
    nb::tuple run(const In &y, const Table &more, const Switch &on)
    {
        const std::size_t samples = y.size();
        require(more.shape(0) == samples && more.shape(1) == 1 + DEHYST_GIVEN && on.size() == samples,
                "signals differ in length");
        std::vector<double> u(samples);
        auto *flags = new std::vector<uint32_t>(samples);
        nb::capsule owner(flags, [](void *p) noexcept { delete static_cast<std::vector<uint32_t> *>(p); });
        Patience patience(100 + 10 * direct_.memory.size());
        for (std::size_t k = 0; k < samples; ++k) {
            patience.go_on();
            const double *row = more.data() + (1 + DEHYST_GIVEN) * k;
            u[k] = dehyst_direct_block_step(&block_, &state_, y.data()[k], row[0], row + 1, on.data()[k] ? 1 : 0);
            (*flags)[k] = state_.flags;
        }
        nb::ndarray<nb::numpy, uint32_t, nb::ndim<1>> words(flags->data(), {samples}, owner);
        return nb::make_tuple(own(std::move(u)), words);
    }

    double output() const { return state_.output; }
    double share() const { return state_.share; }
    uint32_t flags() const { return state_.flags; }
    double doubt() const { return dehyst_direct_doubt(&block_.direct, &state_.direct, nullptr); }

  private:
    Direct direct_;
    dehyst_direct_block block_{};
    dehyst_direct_block_state state_{};
};

}  // namespace

void bind_direct_block(nb::module_ &m)
{
    nb::class_<DirectBlock>(m, "DirectBlock", "A direct inverse as a function block, with its memory.")
        .def(nb::init<const nb::tuple &, double, double, double>(), "parameters"_a, "line_slope"_a, "line_offset"_a,
             "fade"_a)
        .def("reset", &DirectBlock::reset, "Nothing remembered, flags cleared.")
        .def("step", &DirectBlock::step, "y"_a.none(), "rate"_a.none(), "first"_a.none(), "second"_a.none(),
             "third"_a.none(), "on"_a,
             "u for the next sample.")
        .def("run", &DirectBlock::run, "y"_a, "more"_a, "on"_a, "(u (T,), flags (T,)).")
        .def_prop_ro("output", &DirectBlock::output, "Last good u.")
        .def_prop_ro("share", &DirectBlock::share, "0 off .. 1 on.")
        .def_prop_ro("flags", &DirectBlock::flags, "Of the last sample.")
        .def_prop_ro("doubt", &DirectBlock::doubt, "Guaranteed half width of u.");
}
