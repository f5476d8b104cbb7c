// Binding of the core's sums of elements: runs, solutions and columns over arrays; gains follow the steps of time.
#include <algorithm>
#include <array>
#include <cmath>

#include <nanobind/stl/optional.h>

#include <optional>

#include "arrays.h"
#include "dehyst.h"
#include "element_walk.h"
#include "no_pickle.h"
#include "sample.h"
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

// What a step of time [s] makes of the memory. One of no length moves nothing that takes time, and widens nothing.
double gain_of(int32_t kind, double time, double dt)
{
    if (kind == DEHYST_WIDE) return dt > 0.0 ? std::min(time / dt, kMostGrowth) : 0.0;
    return time > 0.0 ? -std::expm1(-std::max(dt, 0.0) / time) : 1.0;
}

// The pieces of all maps of a sum, one after the other.
struct Pieces {
    std::vector<walk_piece> piece;
    std::vector<int32_t> first;

    explicit Pieces(const dehyst_elements &sum)
    {
        for (int32_t k = 0; k < sum.n; ++k) {
            const dehyst_map &map = sum.element[k].map;
            first.push_back(static_cast<int32_t>(piece.size()));
            if (map.n < 2) continue;
            piece.resize(piece.size() + static_cast<std::size_t>(map.n - 1));
            walk_pieces(&map, piece.data() + first.back());
        }
    }
};

// The elements of one call, whose gains follow the steps of time. Time stamps are rounded, so that steps of one period
// have a few lengths that come back: the elements of the last ones are kept.
class Timed {
  public:
    Timed(const dehyst_elements &sum, const Pieces &pieces, const std::vector<double> &time)
        : at_(static_cast<std::size_t>(sum.n)), time_(time),
          walk_{sum, pieces.piece.data(), pieces.first.data(), at_.data()}
    {
        for (Passed &passed : passed_) passed.element.assign(sum.element, sum.element + sum.n);
        walk_.sum.element = passed_[0].element.data();
    }
    Timed(const Timed &) = delete;
    Timed &operator=(const Timed &) = delete;

    void pass(double dt)
    {
        if (dt == passed_[present_].dt) return;
        const auto same = std::find_if(passed_.begin(), passed_.end(), [dt](const Passed &p) { return p.dt == dt; });
        if (same != passed_.end()) {
            present_ = static_cast<std::size_t>(same - passed_.begin());
        } else {
            present_ = oldest_;
            oldest_ = (oldest_ + 1) % passed_.size();
            Passed &passed = passed_[present_];
            passed.dt = dt;
            for (std::size_t k = 0; k < passed.element.size(); ++k)
                passed.element[k].gain = gain_of(passed.element[k].kind, time_[k], dt);
        }
        walk_.sum.element = passed_[present_].element.data();
    }

    const element_walk &walk() const { return walk_; }

  private:
    struct Passed {
        double dt = -1.0;
        std::vector<dehyst_element> element;
    };

    std::array<Passed, 8> passed_;
    std::size_t present_ = 0, oldest_ = 0;
    std::vector<int32_t> at_;
    const std::vector<double> &time_;
    element_walk walk_;
};

// The core's own steps, against which the walk is tested.
double core_step(const element_walk *walk, dehyst_elements_state *state, double u, const double *given)
{
    return dehyst_elements_step(&walk->sum, state, u, given);
}

double core_solve_step(const element_walk *walk, dehyst_elements_state *state, double y, const double *given)
{
    return dehyst_elements_solve_step(&walk->sum, state, y, given);
}

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
        pieces_.emplace(view_);
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

    nb::tuple run(const In &x, const std::optional<In> &dt, const std::optional<Given> &given, const In &memory,
                  bool core) const
    {
        return over(core ? &core_step : &walk_step, x, dt, given, memory);
    }

    nb::tuple solve(const In &y, const std::optional<In> &dt, const std::optional<Given> &given, const In &memory,
                    bool core) const
    {
        return over(core ? &core_solve_step : &walk_solve_step, y, dt, given, memory);
    }

    nb::tuple columns(const In &x, const std::optional<In> &dt, const In &memory) const
    {
        const std::size_t n = element_.size();
        Buffer rows(x.size() * n);
        std::vector<double> after = copy(memory);
        dehyst_elements_state state = begin(x, dt, after);
        for (std::size_t k = 0; k < x.size(); ++k)
            require(dehyst_accept(x.data()[k]), "a sample is not finite or far out");
        Timed timed(view_, *pieces_, time_);
        {
            const nb::gil_scoped_release released;
            Patience patience(20 + 10 * n);
            for (std::size_t k = 0; k < x.size() && !patience.stops(); ++k) {
                timed.pass(dt ? dt->data()[k] : 0.0);
                dehyst_elements_columns(&timed.walk().sum, &state, dehyst_map_value(&view_.before, x.data()[k]),
                                        rows.data() + k * n);
            }
        }
        raise_if_stopped();
        end(state, after);
        return nb::make_tuple(rows.release(x.size(), n), own(std::move(after)));
    }

    const dehyst_elements &view() const { return view_; }
    const Pieces &pieces() const { return *pieces_; }

    // (n,) gains at a period of the samples.
    std::vector<double> gains(double period) const
    {
        std::vector<double> gain(element_.size());
        for (std::size_t k = 0; k < gain.size(); ++k) gain[k] = gain_of(element_[k].kind, time_[k], period);
        return gain;
    }

    using Step = double (*)(const element_walk *, dehyst_elements_state *, double, const double *);

    const std::vector<double> &time() const { return time_; }

    // The state in a memory, which it refers to.
    dehyst_elements_state begin(std::vector<double> &memory) const
    {
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

  private:
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
                "three scheduling variables for each sample");
        Buffer answer(signal.size());
        Timed timed(view_, *pieces_, time_);
        std::size_t rejected = 0;
        int32_t rounds = 0;
        {
            const nb::gil_scoped_release released;
            Patience patience(20 + 40 * element_.size());
            for (std::size_t k = 0; k < signal.size() && !patience.stops(); ++k) {
                timed.pass(dt ? dt->data()[k] : 0.0);
                answer.data()[k] =
                    step(&timed.walk(), &state, signal.data()[k], given ? given->data() + DEHYST_GIVEN * k : nullptr);
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
        return begin(memory);
    }

    std::vector<double> time_;
    Map map_, before_, after_;
    std::vector<dehyst_element> element_;
    dehyst_elements view_{};
    std::optional<Pieces> pieces_;
};

// The sum, or its solution, sample by sample in the units of the log: the memory stays here between two samples.
class ElementSteps {
  public:
    ElementSteps(const ElementSum &sum, bool solves, double center, double half_range, double level, double amplitude)
        : sum_(sum), timed_(sum.view(), sum.pieces(), sum.time()), step_(solves ? &walk_solve_step : &walk_step),
          center_(center), half_range_(half_range), level_(level), amplitude_(amplitude)
    {
        for (int32_t v = 0; v < sum.view().schedules; ++v)
            require(sum.view().source[v] == DEHYST_BY_OUTPUT, "a schedule follows a signal that is not given");
    }
    ElementSteps(const ElementSteps &) = delete;
    ElementSteps &operator=(const ElementSteps &) = delete;

    void begin(const In &memory)
    {
        std::vector<double> fresh = copy(memory);
        const dehyst_elements_state state = sum_.begin(fresh);
        memory_ = std::move(fresh);
        state_ = state;
    }

    double step(double value, double passed)
    {
        const double scaled = (value - center_) / half_range_;
        require(state_.z != nullptr, "no memory to begin with");
        require(dehyst_accept(scaled), "a sample is not finite or far out");
        timed_.pass(passed);
        return level_ + amplitude_ * step_(&timed_.walk(), &state_, scaled, nullptr);
    }

    Out memory() const
    {
        require(state_.z != nullptr, "no memory to begin with");
        std::vector<double> values = memory_;
        ElementSum::end(state_, values);
        return own(std::move(values));
    }

  private:
    const ElementSum &sum_;
    Timed timed_;
    ElementSum::Step step_;
    double center_, half_range_, level_, amplitude_;
    std::vector<double> memory_;
    dehyst_elements_state state_{};
};

using Words = nb::ndarray<nb::numpy, uint32_t, nb::ndim<1>>;
using Image = nb::ndarray<const uint32_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Switch = nb::ndarray<const bool, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

Words own(std::vector<uint32_t> &&values)
{
    auto *kept = new std::vector<uint32_t>(std::move(values));
    nb::capsule owner(kept, [](void *p) noexcept { delete static_cast<std::vector<uint32_t> *>(p); });
    return Words(kept->data(), {kept->size()}, owner);
}

// A sum of elements at a fixed period as a function block, with its memory. `numbers`: those of dehyst_element_block from
// echo to fade, in its order.
class ElementBlock {
  public:
    ElementBlock(const ElementSum &sum, double period, bool solves, int32_t delay, const In &start, const In &numbers,
                 uint32_t fingerprint)
        : element_(sum.view().element, sum.view().element + sum.view().n),
          start_(copy(start)),
          z_(element_.size()),
          ring_(static_cast<std::size_t>(std::max(delay, 1)))
    {
        require(numbers.size() == 15 && (start.size() == 0 || start.size() == z_.size()),
                "15 numbers, and a start for each element or none");
        const double *at = numbers.data();
        const std::vector<double> gain = sum.gains(period);
        for (std::size_t k = 0; k < gain.size(); ++k) element_[k].gain = gain[k];
        block_ = {sum.view(), solves ? 1 : 0, delay, start_.empty() ? nullptr : start_.data(), at[0], at[1], at[2],
                  at[3],      at[4],          at[5], at[6],                                     at[7], at[8], at[9],
                  at[10],     at[11],         at[12], at[13],                                   at[14], fingerprint};
        block_.sum.element = element_.data();
        require(dehyst_element_block_check(&block_) == DEHYST_IMAGE_GOOD, "numbers that are those of no block");
        state_.sum.z = z_.data();
        state_.delay.ring = ring_.data();
        reset();
    }
    ElementBlock(const ElementBlock &) = delete;
    ElementBlock &operator=(const ElementBlock &) = delete;

    void reset() { dehyst_element_block_reset(&block_, &state_); }

    double step(nb::handle x, nb::handle first, nb::handle second, nb::handle third, bool on)
    {
        const double given[DEHYST_GIVEN] = {sample_of(first), sample_of(second), sample_of(third)};
        return dehyst_element_block_step(&block_, &state_, sample_of(x), given, on ? 1 : 0);
    }

    void observe(nb::handle input, nb::handle output, nb::handle first, nb::handle second, nb::handle third)
    {
        const double given[DEHYST_GIVEN] = {sample_of(first), sample_of(second), sample_of(third)};
        dehyst_element_block_observe(&block_, &state_, sample_of(input), sample_of(output), given);
    }

    nb::tuple run(const In &x, const Given &given, const Switch &on)
    {
        const std::size_t samples = x.size();
        require(given.shape(0) == samples && given.shape(1) == DEHYST_GIVEN && on.size() == samples,
                "signals differ in length");
        Buffer answer(samples);
        std::vector<uint32_t> flags(samples);
        {
            const nb::gil_scoped_release released;
            Patience patience(20 + 40 * z_.size());
            for (std::size_t k = 0; k < samples && !patience.stops(); ++k) {
                const double *row = given.data() + DEHYST_GIVEN * k;
                answer.data()[k] = dehyst_element_block_step(&block_, &state_, x.data()[k], row, on.data()[k] ? 1 : 0);
                flags[k] = state_.flags;
            }
        }
        raise_if_stopped();
        return nb::make_tuple(answer.release(), own(std::move(flags)));
    }

    Words save() const
    {
        std::vector<uint32_t> image(static_cast<std::size_t>(DEHYST_ELEMENT_WORDS(block_.sum.n, block_.delay)));
        (void)dehyst_element_block_save(&block_, &state_, image.data(), static_cast<int32_t>(image.size()));
        return own(std::move(image));
    }

    int32_t restore(const Image &image)
    {
        if (image.size() > INT32_MAX) return DEHYST_IMAGE_SIZE;
        return dehyst_element_block_restore(&block_, &state_, image.data(), static_cast<int32_t>(image.size()));
    }

    double output() const { return state_.output; }
    double share() const { return state_.share; }
    uint32_t flags() const { return state_.flags; }

  private:
    std::vector<dehyst_element> element_;
    std::vector<double> start_, z_, ring_;
    dehyst_element_block block_{};
    dehyst_element_block_state state_{};
};

// Two inputs that act on two outputs, along arrays; the memory of the four paths is given and returned, one behind the
// other. `numbers` (14,): center, half range, level, amplitude, rest, low and high, two each.
class ElementPair {
  public:
    ElementPair(const ElementSum &own, const ElementSum &from_second, const ElementSum &from_first,
                const ElementSum &second_own, const In &numbers, bool solves)
        : path_{&own, &from_second, &from_first, &second_own}
    {
        require(numbers.size() == 14, "14 numbers: center, half range, level, amplitude, rest, low, high");
        const double *at = numbers.data();
        for (std::size_t k = 0; k < 2; ++k) {
            pair_.center[k] = at[k];
            pair_.half_range[k] = at[2 + k];
            pair_.level[k] = at[4 + k];
            pair_.amplitude[k] = at[6 + k];
            pair_.rest[k] = at[8 + k];
        }
        pair_.solves = solves ? 1 : 0;
        for (std::size_t p = 0; p < 4; ++p) {
            dehyst_elements &sum = pair_.path[p / 2][p % 2];
            sum = path_[p]->view();
            sum.low = at[10 + p % 2];
            sum.high = at[12 + p % 2];
        }
        require(dehyst_pair_check(&pair_) == DEHYST_IMAGE_GOOD, "parameters are not those of a pair");
    }
    ElementPair(const ElementPair &) = delete;
    ElementPair &operator=(const ElementPair &) = delete;

    // The memory after a reset.
    Out rest() const
    {
        std::vector<double> memory(size());
        dehyst_pair_state state{};
        std::size_t at = 0;
        for (std::size_t p = 0; p < 4; ++p) {
            state.path[p / 2][p % 2].z = memory.data() + at + kHead;
            at += memory_size(p);
        }
        dehyst_pair_reset(&pair_, &state);
        end(state, memory);
        return ::own(std::move(memory));
    }

    // Answers (T, 2), memory after them, flags (T,), largest number of rounds of a solution.
    nb::tuple run(const Pairs &samples, const std::optional<In> &dt, const In &memory) const
    {
        require(samples.shape(1) == 2 && (!dt || dt->size() == samples.shape(0)), "two signals, and a dt a sample");
        require(memory.size() == size(), "memory belongs to another pair");
        const std::size_t count = samples.shape(0);
        std::vector<double> after = copy(memory);
        std::vector<std::vector<double>> memories;
        std::size_t at = 0;
        dehyst_pair_state state{};
        for (std::size_t p = 0; p < 4; ++p) {
            memories.emplace_back(after.begin() + static_cast<std::ptrdiff_t>(at),
                                  after.begin() + static_cast<std::ptrdiff_t>(at + memory_size(p)));
            state.path[p / 2][p % 2] = path_[p]->begin(memories.back());
            state.path[p / 2][p % 2].z = after.data() + at + kHead;
            at += memory_size(p);
        }
        Buffer answer(2 * count);
        std::vector<uint32_t> flags(count);
        dehyst_pair pair = pair_;
        Timed timed[4] = {{path_[0]->view(), path_[0]->pieces(), path_[0]->time()},
                          {path_[1]->view(), path_[1]->pieces(), path_[1]->time()},
                          {path_[2]->view(), path_[2]->pieces(), path_[2]->time()},
                          {path_[3]->view(), path_[3]->pieces(), path_[3]->time()}};
        int32_t rounds = 0;
        {
            const nb::gil_scoped_release released;
            Patience patience(20 + 40 * size());
            for (std::size_t k = 0; k < count && !patience.stops(); ++k) {
                for (std::size_t p = 0; p < 4; ++p) {
                    timed[p].pass(dt ? dt->data()[k] : 0.0);
                    pair.path[p / 2][p % 2].element = timed[p].walk().sum.element;
                }
                dehyst_pair_step(&pair, &state, samples.data() + 2 * k, answer.data() + 2 * k);
                flags[k] = state.flags;
                rounds = std::max(rounds, state.rounds);
            }
        }
        raise_if_stopped();
        end(state, after);
        return nb::make_tuple(answer.release(count, 2), ::own(std::move(after)), own(std::move(flags)), rounds);
    }

  private:
    std::size_t memory_size(std::size_t p) const { return kHead + static_cast<std::size_t>(path_[p]->view().n); }
    std::size_t size() const { return memory_size(0) + memory_size(1) + memory_size(2) + memory_size(3); }

    void end(const dehyst_pair_state &state, std::vector<double> &memory) const
    {
        std::size_t at = 0;
        for (std::size_t p = 0; p < 4; ++p) {
            memory[at] = state.path[p / 2][p % 2].last;
            memory[at + 1] = state.path[p / 2][p % 2].step;
            at += memory_size(p);
        }
    }

    std::array<const ElementSum *, 4> path_;
    dehyst_pair pair_{};
};

}  // namespace

void bind_element_sum(nb::module_ &m)
{
    m.attr("ELEMENT_KINDS") = nb::make_tuple("input", "play", "stop", "creep", "relax", "past", "path", "wide",
                                             "product");
    nb::class_<ElementSum>(m, "ElementSum", "A sum of elements (packages/dehyst/core/elements.c); the memory is given and returned.")
        .def(nb::init<const Whole &, const Whole &, const In &, const In &, const In &, const Whole &, const Pairs &,
                      double, const Pairs &, const Pairs &, double, double, const Whole &, const Pairs &>(),
             "kind"_a, "schedule"_a, "radius"_a, "time"_a, "weight"_a, "points"_a, "map"_a, "offset"_a, "before"_a,
             "after"_a, "low"_a, "high"_a, "source"_a, "range"_a)
        .def("gains", [](const ElementSum &sum, double period) { return own(sum.gains(period)); }, "period"_a,
             "(n,) gains at a period of the samples.")
        .def("rest", &ElementSum::rest, "x"_a, "Memory (2 + n,) at rest at x: x, the last step, elements.")
        .def("run", &ElementSum::run, "x"_a, "dt"_a.none(), "given"_a.none(), "memory"_a, "core"_a = false,
             "(y (T,), memory, number of rejected samples, 0); of the core's own functions, if asked for.")
        .def("solve", &ElementSum::solve, "y"_a, "dt"_a.none(), "given"_a.none(), "memory"_a, "core"_a = false,
             "(x (T,), memory, number of rejected samples, most rounds of a sample); likewise.")
        .def("columns", &ElementSum::columns, "x"_a, "dt"_a.none(), "memory"_a,
             "(each element without map and weight (T, n), memory).");
    nb::class_<ElementSteps> steps(m, "ElementSteps", "A sum of elements, or its solution, sample by sample.");
    refuse_pickling(steps);
    steps
        .def(nb::init<const ElementSum &, bool, double, double, double, double>(), "sum"_a, "solves"_a, "center"_a,
             "half_range"_a, "level"_a, "amplitude"_a, nb::keep_alive<1, 2>())
        .def("begin", &ElementSteps::begin, "memory"_a, "Go on from a memory (2 + n,).")
        .def("step", &ElementSteps::step, "value"_a, "passed"_a, "Output for the next sample, `passed` [s] later.")
        .def("memory", &ElementSteps::memory, "Memory (2 + n,), of its own.");
    nb::class_<ElementBlock> block(m, "ElementBlock",
                                   "A sum of elements as a function block at a fixed period, with its memory.");
    refuse_pickling(block);
    block
        .def(nb::init<const ElementSum &, double, bool, int32_t, const In &, const In &, uint32_t>(), "sum"_a, "period"_a,
             "solves"_a, "delay"_a, "start"_a, "numbers"_a, "fingerprint"_a, nb::keep_alive<1, 2>())
        .def("reset", &ElementBlock::reset, "Nothing remembered, flags cleared.")
        .def("step", &ElementBlock::step, "x"_a.none(), "first"_a.none(), "second"_a.none(), "third"_a.none(), "on"_a,
             "Output for the next sample.")
        .def("observe", &ElementBlock::observe, "input"_a.none(), "output"_a.none(), "first"_a.none(), "second"_a.none(),
             "third"_a.none(), "Follow a sample that something else makes.")
        .def("run", &ElementBlock::run, "x"_a, "given"_a, "on"_a, "(outputs (T,), flags (T,)).")
        .def("save", &ElementBlock::save, "Image of the state.")
        .def("restore", &ElementBlock::restore, "image"_a, "Go on from an image; the core's answer, 0 if it was good.")
        .def_prop_ro("output", &ElementBlock::output, "Last good output.")
        .def_prop_ro("share", &ElementBlock::share, "0 off .. 1 on.")
        .def_prop_ro("flags", &ElementBlock::flags, "Of the last sample.");
    nb::class_<ElementPair> pair(m, "ElementPair", "Two inputs that act on two outputs (packages/dehyst/core/pair.c).");
    refuse_pickling(pair);
    pair.def(nb::init<const ElementSum &, const ElementSum &, const ElementSum &, const ElementSum &, const In &, bool>(),
             "own"_a, "from_second"_a, "from_first"_a, "second_own"_a, "numbers"_a, "solves"_a, nb::keep_alive<1, 2>(),
             nb::keep_alive<1, 3>(), nb::keep_alive<1, 4>(), nb::keep_alive<1, 5>())
        .def("rest", &ElementPair::rest, "Memory after a reset: that of the four paths, one behind the other.")
        .def("run", &ElementPair::run, "samples"_a, "dt"_a.none(), "memory"_a,
             "(answers (T, 2), memory, flags (T,), most rounds of a sample).");
}
