// Binding of the core's sums of elements: runs, solutions and columns over arrays; gains follow the steps of time.
#include <algorithm>
#include <cmath>

#include <nanobind/stl/optional.h>

#include <optional>

#include "arrays.h"
#include "dehyst.h"
#include "stoppable.h"

namespace {

using Whole = nb::ndarray<const int32_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Pairs = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>; // (2, n): arguments, values
using Given = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

constexpr std::size_t kHead = 2;             // last x and last step, in front of the memory of the elements
constexpr double kMostGrowth = 15.0 / 16.0;  // of a radius with x: below 1, so that every play still moves with x

struct Map {
    std::vector<double> u, v;
    explicit Map(const Pairs &pairs)
    {
        require(pairs.shape(0) == 2, "a map is a row of arguments and a row of values");
        const std::size_t n = pairs.shape(1);
        u.assign(pairs.data(), pairs.data() + n);
        v.assign(pairs.data() + n, pairs.data() + 2 * n);
    }
    dehyst_map view() const { return {static_cast<int32_t>(u.size()), u.data(), v.data()}; }
};

// The elements of one call, whose gains follow the steps of time.
class Timed {
  public:
    Timed(const dehyst_elements &sum, const std::vector<double> &time)
        : view(sum), element_(sum.element, sum.element + sum.n), time_(time)
    {
        view.element = element_.data();
    }
    Timed(const Timed &) = delete;
    Timed &operator=(const Timed &) = delete;

    // A step of no length [s] moves nothing that takes time, and widens nothing.
    void pass(double dt)
    {
        if (dt == passed_) return;
        passed_ = dt;
        for (std::size_t k = 0; k < element_.size(); ++k) {
            dehyst_element &q = element_[k];
            if (q.kind == DEHYST_WIDE)
                q.gain = dt > 0.0 ? std::min(time_[k] / dt, kMostGrowth) : 0.0;
            else
                q.gain = time_[k] > 0.0 ? -std::expm1(-std::max(dt, 0.0) / time_[k]) : 1.0;
        }
    }

    dehyst_elements view;

  private:
    std::vector<dehyst_element> element_;
    const std::vector<double> &time_;
    double passed_ = -1.0;
};

class ElementSum {
  public:
    ElementSum(const Whole &kind, const Whole &schedule, const In &radius, const In &time, const In &weight,
               const Whole &points, const Pairs &map, double offset, const Pairs &before, const Pairs &after,
               double low, double high, const Whole &source, const Pairs &range)
        : time_(copy(time)), map_(map), before_(before), after_(after), element_(kind.size())
    {
        const std::size_t n = kind.size(), schedules = source.size();
        require(schedule.size() == n && radius.size() == n && time.size() == n && weight.size() == n &&
                    points.size() == n,
                "one schedule, radius, time, weight and number of points for each element");
        require(schedules <= DEHYST_SCHEDULES && range.shape(0) == 2 && range.shape(1) == schedules,
                "at most 3 schedules, each with a source and a range");
        std::size_t at = 0;
        for (std::size_t k = 0; k < n; ++k) {
            const int32_t size = points.data()[k];
            require(size == 0 || size >= 2, "a map has no point, or two and more");
            require(static_cast<std::size_t>(size) <= map_.u.size() - at, "fewer points than the maps have");
            require(std::isfinite(time_[k]) && time_[k] >= 0.0, "a time is negative or no number");
            element_[k] = {kind.data()[k],      schedule.data()[k], radius.data()[k],
                           0.0,                 weight.data()[k],   {size, map_.u.data() + at, map_.v.data() + at}};
            at += static_cast<std::size_t>(size);
        }
        require(at == map_.u.size(), "more points than the maps have");
        view_.n = static_cast<int32_t>(n);
        view_.element = element_.data();
        view_.before = before_.view();
        view_.after = after_.view();
        view_.offset = offset;
        view_.low = low;
        view_.high = high;
        view_.schedules = static_cast<int32_t>(schedules);
        for (std::size_t v = 0; v < schedules; ++v) {
            view_.source[v] = source.data()[v];
            view_.schedule_low[v] = range.data()[v];
            view_.schedule_high[v] = range.data()[schedules + v];
        }
        require(dehyst_elements_check(&view_) == DEHYST_IMAGE_GOOD, "parameters are not those of a sum of elements");
    }
    ElementSum(const ElementSum &) = delete;
    ElementSum &operator=(const ElementSum &) = delete;

    Out rest(double x) const
    {
        std::vector<double> memory(kHead + element_.size());
        dehyst_elements_state state{};
        state.z = memory.data() + kHead;
        require(dehyst_accept(x), "no elements rest at an input that is not finite or far out");
        dehyst_elements_reset(&view_, &state, dehyst_map_value(&view_.before, x), 0.0);
        end(state, memory);
        return own(std::move(memory));
    }

    nb::tuple run(const In &x, const std::optional<In> &dt, const std::optional<Given> &given, const In &memory) const
    {
        return over(&dehyst_elements_step, x, dt, given, memory);
    }

    nb::tuple solve(const In &y, const std::optional<In> &dt, const std::optional<Given> &given, const In &memory) const
    {
        return over(&dehyst_elements_solve_step, y, dt, given, memory);
    }

    nb::tuple columns(const In &x, const std::optional<In> &dt, const In &memory) const
    {
        const std::size_t n = element_.size();
        Buffer rows(x.size() * n);
        std::vector<double> after = copy(memory);
        dehyst_elements_state state = begin(x, dt, after);
        for (std::size_t k = 0; k < x.size(); ++k)
            require(dehyst_accept(x.data()[k]), "a sample is not finite or far out");
        Timed timed(view_, time_);
        {
            const nb::gil_scoped_release released;
            Patience patience(20 + 10 * n);
            for (std::size_t k = 0; k < x.size() && !patience.stops(); ++k) {
                timed.pass(dt ? dt->data()[k] : 0.0);
                dehyst_elements_columns(&timed.view, &state, dehyst_map_value(&view_.before, x.data()[k]),
                                        rows.data() + k * n);
            }
        }
        raise_if_stopped();
        end(state, after);
        return nb::make_tuple(rows.release(x.size(), n), own(std::move(after)));
    }

  private:
    using Step = double (*)(const dehyst_elements *, dehyst_elements_state *, double, const double *);

    // Answers (T,), memory after them, number of rejected samples, largest number of rounds of a solution.
    nb::tuple over(Step step, const In &signal, const std::optional<In> &dt, const std::optional<Given> &given,
                   const In &memory) const
    {
        std::vector<double> after = copy(memory);
        dehyst_elements_state state = begin(signal, dt, after);
        const bool outside = std::any_of(view_.source, view_.source + view_.schedules,
                                         [](int32_t source) { return source != DEHYST_BY_OUTPUT; });
        require(given || !outside, "a schedule follows a signal that is not given");
        require(!given || (given->shape(0) == signal.size() && given->shape(1) == DEHYST_GIVEN),
                "two scheduling variables for each sample");
        Buffer answer(signal.size());
        Timed timed(view_, time_);
        std::size_t rejected = 0;
        int32_t rounds = 0;
        {
            const nb::gil_scoped_release released;
            Patience patience(20 + 40 * element_.size());
            for (std::size_t k = 0; k < signal.size() && !patience.stops(); ++k) {
                timed.pass(dt ? dt->data()[k] : 0.0);
                answer.data()[k] =
                    step(&timed.view, &state, signal.data()[k], given ? given->data() + DEHYST_GIVEN * k : nullptr);
                rejected += state.flags & DEHYST_REJECTED;
                rounds = std::max(rounds, state.rounds);
            }
        }
        raise_if_stopped();
        end(state, after);
        return nb::make_tuple(answer.release(), own(std::move(after)), rejected, rounds);
    }

    dehyst_elements_state begin(const In &signal, const std::optional<In> &dt, std::vector<double> &memory) const
    {
        require(!dt || dt->size() == signal.size(), "signal and dt differ in length");
        require(memory.size() == kHead + element_.size(), "memory belongs to other elements");
        dehyst_elements_state state{};
        state.last = memory[0];
        state.step = memory[1];
        state.z = memory.data() + kHead;
        const int32_t answer = dehyst_elements_memory_check(&view_, state.z, state.last);
        require(dehyst_accept(state.step) && answer == DEHYST_IMAGE_GOOD, "memory that no input leaves");
        return state;
    }

    static void end(const dehyst_elements_state &state, std::vector<double> &memory)
    {
        memory[0] = state.last;
        memory[1] = state.step;
    }

    std::vector<double> time_;
    Map map_, before_, after_;
    std::vector<dehyst_element> element_;
    dehyst_elements view_{};
};

}  // namespace

void bind_element_sum(nb::module_ &m)
{
    m.attr("ELEMENT_KINDS") = nb::make_tuple("input", "play", "stop", "creep", "relax", "past", "path", "wide");
    nb::class_<ElementSum>(m, "ElementSum", "A sum of elements (core/elements.c); the memory is given and returned.")
        .def(nb::init<const Whole &, const Whole &, const In &, const In &, const In &, const Whole &, const Pairs &,
                      double, const Pairs &, const Pairs &, double, double, const Whole &, const Pairs &>(),
             "kind"_a, "schedule"_a, "radius"_a, "time"_a, "weight"_a, "points"_a, "map"_a, "offset"_a, "before"_a,
             "after"_a, "low"_a, "high"_a, "source"_a, "range"_a)
        .def("rest", &ElementSum::rest, "x"_a, "Memory (2 + n,) at rest at x: x, the last step, elements.")
        .def("run", &ElementSum::run, "x"_a, "dt"_a.none(), "given"_a.none(), "memory"_a,
             "(y (T,), memory, number of rejected samples, 0).")
        .def("solve", &ElementSum::solve, "y"_a, "dt"_a.none(), "given"_a.none(), "memory"_a,
             "(x (T,), memory, number of rejected samples, most rounds of a sample).")
        .def("columns", &ElementSum::columns, "x"_a, "dt"_a.none(), "memory"_a,
             "(each element without map and weight (T, n), memory).");
}
