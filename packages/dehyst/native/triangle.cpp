// Binding of the engine's operator on the triangle of switching values, Preisach's: no formula.
#include "arrays.h"
#include "preisach.h"
#include "stoppable.h"

namespace {

std::size_t cells_of(std::size_t n) { return n * (n + 1) / 2; }

void require_rising(const In &values)
{
    for (std::size_t k = 1; k < values.size(); ++k) require(values.data()[k - 1] < values.data()[k], "knots must increase");
}

// A model with room for what it remembers: [present input and output | turns and their outputs].
class Preisach {
  public:
    Preisach(const In &knots, const In &everett, double below, double above, const In &memory, std::size_t samples)
        : model_{static_cast<int32_t>(knots.size() - 1), knots.data(), everett.data(), below, above}
    {
        require(knots.size() >= 2 && knots.size() < 4096, "between 2 and 4095 knots are needed");
        require(everett.size() == knots.size() * knots.size(), "everett must be (knots, knots)");
        require(memory.size() >= 4 && memory.size() % 2 == 0, "memory is [input, output, turns and their outputs]");
        require_rising(knots);
        const double *m = memory.data();
        turns_.resize(memory.size() / 2 - 1 + samples);
        for (std::size_t k = 2; k < memory.size(); k += 2) {
            require(m[k] >= knots.data()[0] && m[k] <= knots.data()[knots.size() - 1], "a turn lies outside the knots");
            turns_[k / 2 - 1] = {m[k], m[k + 1]};
        }
        memory_ = {{m[0], m[1]}, static_cast<int32_t>(memory.size() / 2 - 1), turns_.data()};
    }
    Preisach(const Preisach &) = delete;
    Preisach &operator=(const Preisach &) = delete;

    const engine_preisach *model() const { return &model_; }
    preisach_memory *memory() { return &memory_; }
    Out image() const
    {
        std::vector<double> made{memory_.now.x, memory_.now.y};
        for (int32_t k = 0; k < memory_.depth; ++k) {
            made.push_back(memory_.turn[k].x);
            made.push_back(memory_.turn[k].y);
        }
        return own(std::move(made));
    }

  private:
    engine_preisach model_;
    std::vector<preisach_turn> turns_;
    preisach_memory memory_{};
};

template <auto Engine>
nb::tuple preisach(const In &knots, const In &everett, double below, double above, const In &memory, const In &signal)
{
    Preisach found(knots, everett, below, above, memory, signal.size());
    Buffer out(signal.size());
    {
        const nb::gil_scoped_release released;
        Engine(found.model(), found.memory(), static_cast<int64_t>(signal.size()), signal.data(), out.data());
    }
    raise_if_stopped();
    return nb::make_tuple(out.release(), found.image());
}

Matrix preisach_cells(const In &knots, const In &memory, const In &x)
{
    const std::vector<double> zeros(knots.size() * knots.size(), 0.0);
    const In everett(zeros.data(), {zeros.size()}, nb::handle());
    Preisach found(knots, everett, 0.0, 0.0, memory, x.size());
    const std::size_t cells = cells_of(knots.size() - 1);
    std::vector<double> scratch((knots.size() + 1) * (knots.size() + 1));
    Buffer out(x.size() * cells);
    {
        const nb::gil_scoped_release released;
        engine_preisach_cells(found.model(), found.memory(), static_cast<int64_t>(x.size()), x.data(), scratch.data(),
                              out.data());
    }
    raise_if_stopped();
    return out.release(x.size(), cells);
}

}  // namespace

void bind_triangle(nb::module_ &m)
{
    m.def("preisach_run", &preisach<&engine_preisach_run>, "knots"_a, "everett"_a, "below"_a, "above"_a, "memory"_a,
          "x"_a, "(outputs, memory) along x.");
    m.def("preisach_invert", &preisach<&engine_preisach_invert>, "knots"_a, "everett"_a, "below"_a, "above"_a,
          "memory"_a, "y"_a, "(inputs, memory) for the outputs y.");
    m.def("preisach_cells", &preisach_cells, "knots"_a, "memory"_a, "x"_a, "States of the cells, (T, n (n + 1)/2).");
}
