// Binding of the engine: long signals on a host, no formula.
#include <memory>
#include <mutex>

#include "arrays.h"
#include "dehyst.h"
#include "engine.h"
#include "evaluator_handle.h"
#include "stoppable.h"

namespace {

using Writable = nb::ndarray<double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

// One operator with its state. Calls from several threads take turns; the interpreter is free meanwhile. A run that is
// stopped leaves the state of a sample on its way.
class Evaluator {
  public:
    Evaluator(const In &r, const In &w, double center, double offset, const In &z) : n_(r.size())
    {
        require(n_ > 0 && w.size() == n_ && z.size() == n_, "thresholds, weights and state differ in length");
        require(engine_takes(n_, r.data(), w.data(), center, offset, z.data()),
                "not an operator with an admissible state: thresholds must increase from 0 or more, and neighbouring "
                "states differ by no more than their thresholds");
        handle_ = make_evaluator(n_, r.data(), w.data(), center, offset, z.data());
    }

    nb::object run(const In &x, nb::object out)
    {
        if (out.is_none()) {
            Buffer y(x.size());
            advance(x, y.data());
            return nb::cast(y.release());
        }
        Writable y;
        if (!nb::try_cast(out, y, false))
            throw nb::type_error("out must be a writable contiguous float64 array (T,)");
        require(y.size() == x.size(), "out has another length than x");
        const auto from = reinterpret_cast<std::uintptr_t>(x.data()), to = reinterpret_cast<std::uintptr_t>(y.data());
        const std::uintptr_t bytes = x.size() * sizeof(double);
        require(from == to || from + bytes <= to || to + bytes <= from,
                "out overlaps x: pass x itself or an array of its own");
        advance(x, y.data());
        return out;
    }

    void method(int32_t m)
    {
        const Turn turn(turn_);
        require(engine_evaluator_method(handle_.get(), m) == 0,
                "no such method: -1 automatic, 0 events, a multiple of 8 below n, or ENGINE_DENSE");
    }

    Out state()
    {
        Buffer z(n_);
        {
            const Turn turn(turn_);
            engine_evaluator_state(handle_.get(), z.data());
        }
        return z.release();
    }

    int64_t events() { return engine_evaluator_events(handle_.get()); }
    int64_t rejected() const { return rejected_; }

  private:
    void advance(const In &x, double *y)
    {
        {
            const Turn turn(turn_);
            rejected_ += engine_evaluator_run(handle_.get(), static_cast<int64_t>(x.size()), x.data(), y);
        }
        raise_if_stopped();
    }

    std::size_t n_;
    EvaluatorHandle handle_;
    std::mutex turn_;
    int64_t rejected_ = 0;
};

}  // namespace

void bind_engine(nb::module_ &m)
{
    m.attr("ENGINE_DENSE") = static_cast<int32_t>(ENGINE_DENSE);
    m.def("engine_level", &engine_level, "Instruction set in use: 0 portable, 1 AVX2, 2 AVX-512.");
    m.def("engine_best_level", &engine_best_level, "Highest level that this build and processor can run.");
    m.def("engine_use_level", [](int level) { require(engine_use_level(level) == 0, "this level cannot run here"); },
          "level"_a, "Choose the instruction set; for tests and benchmarks, not thread safe.");
    nb::class_<Evaluator>(m, "Evaluator", "A Prandtl-Ishlinskii operator for long signals, with its state.")
        .def(nb::init<const In &, const In &, double, double, const In &>(), "thresholds"_a, "weights"_a, "center"_a,
             "offset"_a, "state"_a)
        .def("run", &Evaluator::run, "x"_a, "out"_a.none() = nb::none(),
             "Outputs (T,), continuing from the present state; into `out` if given, which may be x. Ctrl-C leaves the state of "
             "a sample on the way, and `out` half written: what goes on needs a new one.")
        .def("method", &Evaluator::method, "method"_a, "-1 automatic, 0 events, a dense prefix, or ENGINE_DENSE.")
        .def_prop_ro("state", &Evaluator::state, nb::rv_policy::move, "Play states (n,).")
        .def_prop_ro("events", &Evaluator::events, "Events so far: what a sample costs follows them.")
        .def_prop_ro("rejected", &Evaluator::rejected, "Samples rejected so far.");
}
