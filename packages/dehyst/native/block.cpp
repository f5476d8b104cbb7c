// Binding of blocks, a model or its inverse as a function block of a machine: no formula.
#include <nanobind/stl/vector.h>

#include "arrays.h"
#include "dehyst.h"
#include "model_parameters.h"
#include "no_pickle.h"
#include "sample.h"
#include "stoppable.h"

namespace {

using Image = nb::ndarray<const uint32_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Words = nb::ndarray<nb::numpy, uint32_t, nb::ndim<1>>;
using Switch = nb::ndarray<const bool, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

Words own_words(std::vector<uint32_t> &&values)
{
    auto *kept = new std::vector<uint32_t>(std::move(values));
    nb::capsule owner(kept, [](void *p) noexcept { delete static_cast<std::vector<uint32_t> *>(p); });
    return Words(kept->data(), {kept->size()}, owner);
}

// Parameters in one piece of memory, as dehyst_block_load lays them out, with the state.
class Block {
  public:
    explicit Block(const Image &image) : memory_(image.size())
    {
        const int32_t fault = dehyst_block_load(image.data(), length(image), memory_.data(), length(memory_), &block_);
        if (fault != DEHYST_IMAGE_GOOD) throw std::invalid_argument(std::to_string(fault));
        z_.resize(static_cast<std::size_t>(block_.model.hysteresis.n));
        state_.model.z = z_.data();
        reset();
    }
    Block(const Block &) = delete;
    Block &operator=(const Block &) = delete;

    void reset() { dehyst_block_reset(&block_, &state_); }

    double step(nb::handle x, bool on) { return dehyst_block_step(&block_, &state_, sample_of(x), on ? 1 : 0); }

    nb::tuple run(const In &x, const Switch &on)
    {
        require(x.size() == on.size(), "inputs and switches differ in length");
        Buffer y(x.size());
        std::vector<uint32_t> flags(x.size());
        Patience patience(20 + z_.size());
        for (std::size_t k = 0; k < x.size(); ++k) {
            patience.go_on();
            y.data()[k] = dehyst_block_step(&block_, &state_, x.data()[k], on.data()[k] ? 1 : 0);
            flags[k] = state_.flags;
        }
        return nb::make_tuple(y.release(), own_words(std::move(flags)));
    }

    Words save() const
    {
        std::vector<uint32_t> image(static_cast<std::size_t>(DEHYST_STATE_WORDS(block_.model.hysteresis.n)));
        (void)dehyst_block_save(&block_, &state_, image.data(), length(image));
        return own_words(std::move(image));
    }

    int32_t restore(const Image &image) { return dehyst_block_restore(&block_, &state_, image.data(), length(image)); }

    Words dump() const { return own_words(dumped(block_)); }

    static std::vector<uint32_t> dumped(const dehyst_block &block)
    {
        const dehyst_model &model = block.model;
        std::vector<uint32_t> image(
            static_cast<std::size_t>(DEHYST_BLOCK_WORDS(model.hysteresis.n, model.before.n, model.after.n)));
        (void)dehyst_block_dump(&block, image.data(), length(image));
        return image;
    }

    // Every parameter by its name in dehyst.h, with the bits that are used.
    nb::dict parameters() const
    {
        const dehyst_model &model = block_.model;
        const dehyst_pi &pi = model.hysteresis;
        nb::dict values;
        values["threshold"] = array(pi.threshold, pi.n);
        values["slope"] = array(pi.slope, pi.n);
        values["loading"] = array(pi.loading, pi.n);
        values["center"] = pi.center;
        values["offset"] = pi.offset;
        values["before_u"] = array(model.before.u, model.before.n);
        values["before_v"] = array(model.before.v, model.before.n);
        values["after_u"] = array(model.after.u, model.after.n);
        values["after_v"] = array(model.after.v, model.after.n);
        values["start"] = array(block_.start, pi.n);
        values["input_low"] = block_.input_low;
        values["input_high"] = block_.input_high;
        values["output_low"] = block_.output_low;
        values["output_high"] = block_.output_high;
        values["reach_low"] = block_.reach_low;
        values["reach_high"] = block_.reach_high;
        values["line_slope"] = block_.line_slope;
        values["line_offset"] = block_.line_offset;
        values["fade"] = block_.fade;
        values["fingerprint"] = block_.fingerprint;
        return values;
    }

    Out play_states() const { return own(std::vector<double>(z_)); }
    double output() const { return state_.output; }
    double share() const { return state_.share; }
    uint32_t flags() const { return state_.flags; }

  private:
    template <class T>
    static int32_t length(const T &values)
    {
        require(values.size() <= static_cast<std::size_t>(INT32_MAX), "an image has at most 2^31 - 1 words");
        return static_cast<int32_t>(values.size());
    }

    static Out array(const double *values, int32_t n)
    {
        return own(n > 0 ? std::vector<double>(values, values + n) : std::vector<double>());
    }

    std::vector<double> memory_, z_;
    dehyst_block block_{};
    dehyst_block_state state_{};
};

// Image of the parameters of a block, tables made of the model's weights; they are checked when a block is made of it.
Words block_image(const In &r, const In &w, double center, double offset, const In &bu, const In &bv, const In &au,
                  const In &av, const In &start, const std::vector<double> &limits, uint32_t fingerprint)
{
    const ModelParameters model(r, w, center, offset, bu, bv, au, av);
    require(start.size() == r.size(), "state and thresholds differ in length");
    require(limits.size() == 9, "a block has 9 limits");
    const dehyst_block block = {model.view, start.data(), limits[0], limits[1], limits[2], limits[3],  limits[4],
                                limits[5],  limits[6],    limits[7], limits[8], fingerprint};
    return own_words(Block::dumped(block));
}

}  // namespace

void bind_block(nb::module_ &m)
{
    m.attr("BLOCK_REJECTED") = static_cast<uint32_t>(DEHYST_REJECTED);
    m.attr("BLOCK_REJECTED_EVER") = static_cast<uint32_t>(DEHYST_REJECTED_EVER);
    m.attr("BLOCK_LIMITED") = static_cast<uint32_t>(DEHYST_LIMITED);
    m.attr("BLOCK_LIMITED_EVER") = static_cast<uint32_t>(DEHYST_LIMITED_EVER);
    m.def("block_image", &block_image, "thresholds"_a, "weights"_a, "center"_a, "offset"_a, "before_u"_a, "before_v"_a,
          "after_u"_a, "after_v"_a, "state"_a, "limits"_a, "fingerprint"_a,
          "Parameters of a block as dehyst_block_dump writes them; limits: input, output and reach low and high, slope "
          "and offset of the line, fade.");
    nb::class_<Block> bound(m, "Block", "A model as a function block, with its state.");
    refuse_pickling(bound);
    bound
        .def(nb::init<const Image &>(), "image"_a, "Of an image of parameters; ValueError with the answer if it is bad.")
        .def("reset", &Block::reset, "Back to the start state, flags cleared.")
        .def("step", &Block::step, "x"_a.none(), "on"_a, "Output for the next sample.")
        .def("run", &Block::run, "x"_a, "on"_a, "(outputs (T,), flags (T,)).")
        .def("save", &Block::save, "Image of the state.")
        .def("restore", &Block::restore, "image"_a, "Go on from an image; the answer of the core, 0 if it was good.")
        .def("dump", &Block::dump, "Image of the parameters.")
        .def_prop_ro("parameters", &Block::parameters, "By name.")
        .def_prop_ro("state", &Block::play_states, nb::rv_policy::move, "Play states z (n,).")
        .def_prop_ro("output", &Block::output, "Last good output.")
        .def_prop_ro("share", &Block::share, "0 off .. 1 on.")
        .def_prop_ro("flags", &Block::flags, "Of the last sample.");
}
