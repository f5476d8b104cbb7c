// Binding of the core's step in O(log n): no formula.
#include <cmath>
#include <memory>

#include "arrays.h"
#include "dehyst.h"
#include "model_parameters.h"
#include "no_pickle.h"
#include "sample.h"
#include "stoppable.h"

namespace {

// Tables and memory of a stack for n operators and one more.
struct Stack {
    std::vector<dehyst_stack_segment> segment;
    std::vector<double> falling, rising, start, start_sum;
    dehyst_stack_state state{};

    explicit Stack(std::size_t n) : segment(n + 1), falling(n + 1), rising(n + 1), start(n + 2), start_sum(n + 2)
    {
        state.segment = segment.data();
        state.bound[0] = falling.data();
        state.bound[1] = rising.data();
        state.start = start.data();
        state.start_sum = start_sum.data();
    }
    Stack(const Stack &) = delete;
    Stack &operator=(const Stack &) = delete;
};

// A model with its state: one call a sample in real time, at a cost that hardly knows the number of operators.
class StackStepper {
  public:
    StackStepper(const In &r, const In &w, double center, double offset, const In &bu, const In &bv, const In &au,
                 const In &av, const In &z0)
        : parameters_(r, w, center, offset, bu, bv, au, av), start_(copy(z0)), threshold_(start_.size() + 2),
          slope_(start_.size() + 1), loading_(start_.size() + 1), stack_(std::make_unique<Stack>(start_.size()))
    {
        require(start_.size() == parameters_.threshold.size(), "state and thresholds differ in length");
        dehyst_stack_prepare(&parameters_.view, threshold_.data(), slope_.data(), loading_.data(), &tables_);
        reset();
    }
    StackStepper(const StackStepper &) = delete;
    StackStepper &operator=(const StackStepper &) = delete;

    double step(double x) { return dehyst_stack_step(&tables_, &stack_->state, x); }
    nb::tuple simulate(const In &x)
    {
        Buffer y(x.size());
        std::size_t rejected = 0;
        Patience patience(50);
        for (std::size_t k = 0; k < x.size(); ++k) {
            patience.go_on();
            y.data()[k] = step(x.data()[k]);
            rejected += stack_->state.flags & DEHYST_REJECTED;
        }
        return nb::make_tuple(y.release(), rejected);
    }

    void reset() { dehyst_stack_reset(&tables_, &stack_->state, start_.data()); }

    // Play states; turning point and end of each segment from the lowest to the top, the end negative if the input
    // fell; output and flags.
    Out save() const
    {
        const dehyst_stack_state &now = stack_->state;
        std::vector<double> image = plays(now);
        const auto put = [&image](double turn, int32_t end, int32_t rising) {
            image.push_back(turn);
            image.push_back(rising ? end : -end);
        };
        for (int32_t k = 1; k < now.depth; ++k) put(now.segment[k].turn, now.segment[k].end, now.segment[k].side > 0);
        put(now.input, now.end, now.rising);
        image.push_back(now.output);
        image.push_back(static_cast<double>(now.flags));
        return own(std::move(image));
    }

    void restore(const In &image)
    {
        const std::size_t n = start_.size(), size = image.size();
        require(size >= n + 4 && (size - n) % 2 == 0 && size <= 3 * n + 4,
                "saved state belongs to a model with another number of operators, or to a dense stepper");
        for (std::size_t i = 0; i < size; ++i)
            require(dehyst_accept(image.data()[i]) != 0, "saved state is not finite");
        const double *z = image.data(), *segment = z + n, output = z[size - 2], flags = z[size - 1];
        require(flags == 0.0 || flags == 2.0 || flags == 3.0, "saved state carries unknown flags");
        require_admissible(z, segment[size - n - 4]);
        auto next = std::make_unique<Stack>(n);
        dehyst_stack_begin(&tables_, &next->state, z);
        const auto depth = static_cast<int32_t>((size - n) / 2 - 1);
        for (int32_t k = 0, most = tables_.n; k < depth; ++k) {
            const double end = segment[2 * k + 1], length = std::fabs(end);
            require(length >= 1 && length <= most && length == std::floor(length), "saved state is damaged");
            most = static_cast<int32_t>(length) - 1;
            dehyst_stack_push(&tables_, &next->state, k, static_cast<int32_t>(length), end > 0, segment[2 * k]);
        }
        // Segments, play states and the held output belong together, bit for bit: this finds images of another model.
        const std::vector<double> found = plays(next->state);
        bool same = output == next->state.output;
        for (std::size_t i = 0; i < n; ++i) same = same && found[i] == z[i];
        require(same, "saved state belongs to another model");
        next->state.flags = static_cast<uint32_t>(flags);
        stack_ = std::move(next);
    }

    nb::tuple parameters() const { return parameters_.as_tuple(start_); }
    Out state() const { return own(plays(stack_->state)); }
    double output() const { return stack_->state.output; }
    bool rejected() const { return (stack_->state.flags & DEHYST_REJECTED) != 0; }
    bool rejected_ever() const { return (stack_->state.flags & DEHYST_REJECTED_EVER) != 0; }

  private:
    std::vector<double> plays(const dehyst_stack_state &state) const
    {
        std::vector<double> z(start_.size());
        dehyst_stack_play(&tables_, &state, z.data());
        return z;
    }

    // |z_i - z_{i+1}| <= r_{i+1} - r_i; the operator before the first is the input itself, with threshold 0.
    void require_admissible(const double *z, double input) const
    {
        const double *r = parameters_.threshold.data();
        for (std::size_t i = 0; i < start_.size(); ++i) {
            const double before = i == 0 ? input : z[i - 1], from = i == 0 ? 0 : r[i - 1];
            require(std::fabs(z[i] - before) <= r[i] - from + 1e-9 * (std::fabs(z[i]) + r[i]),
                    "saved state is not admissible: no input leaves it");
        }
    }

    ModelParameters parameters_;
    std::vector<double> start_, threshold_, slope_, loading_;
    dehyst_stack_model tables_{};
    std::unique_ptr<Stack> stack_;
};

}  // namespace

void bind_stack(nb::module_ &m)
{
    nb::class_<StackStepper> bound(m, "StackStepper",
                                      "A model with its state, one call a sample, in O(log n).");
    bound
        .def(nb::init<const In &, const In &, double, double, const In &, const In &, const In &, const In &,
                      const In &>(),
             "thresholds"_a, "weights"_a, "center"_a, "offset"_a, "before_u"_a, "before_v"_a, "after_u"_a,
             "after_v"_a, "state"_a)
        .def("simulate", &StackStepper::simulate, "x"_a, "(outputs (T,), number of rejected samples).")
        .def("reset", &StackStepper::reset, "Back to the model's start state, flags cleared.")
        .def("save", &StackStepper::save, "Image of the state for `restore`; it grows with what is remembered.")
        .def("restore", &StackStepper::restore, "image"_a, "Continue from a saved image, to the bit.")
        .def_prop_ro("method", [](const StackStepper &) { return "logarithmic"; }, "How it steps.")
        .def_prop_ro("parameters", &StackStepper::parameters,
                     "What it was made of, for a joint controller's compensator.")
        .def_prop_ro("state", &StackStepper::state, nb::rv_policy::move, "Play states z (n,).")
        .def_prop_ro("output", &StackStepper::output, "Last good output.")
        .def_prop_ro("rejected", &StackStepper::rejected, "The last sample was rejected.")
        .def_prop_ro("rejected_ever", &StackStepper::rejected_ever, "Some sample since the last reset was rejected.");
    refuse_pickling(bound);
    bind_call(bound);
}
