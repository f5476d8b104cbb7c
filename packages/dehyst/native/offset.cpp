// Binding of an offset that follows the last cycle: no formula.
#include "arrays.h"
#include "dehyst.h"
#include "no_pickle.h"

namespace {

using Image = nb::ndarray<const uint32_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Words = nb::ndarray<nb::numpy, uint32_t, nb::ndim<1>>;

class Offset {
  public:
    Offset(double limit, double turn, double part, uint32_t fingerprint) : offset_{limit, turn, part, fingerprint}
    {
        require(limit >= 0 && turn > 0 && part >= 0 && dehyst_accept(limit) && dehyst_accept(turn) &&
                    dehyst_accept(part),
                "numbers that are those of no offset");
        reset();
    }
    Offset(const Offset &) = delete;
    Offset &operator=(const Offset &) = delete;

    void reset() { dehyst_offset_reset(&state_); }
    double applied() const { return state_.applied; }
    double next(double x, bool on) const { return dehyst_offset_next(&offset_, &state_, x, on ? 1 : 0); }
    double step(double x, double said, double measured, double share, uint32_t flags, bool on)
    {
        return dehyst_offset_step(&offset_, &state_, x, said, measured, share, flags, on ? 1 : 0);
    }

    Out run(const In &x, const In &said, const In &measured)
    {
        require(said.size() == x.size() && measured.size() == x.size(), "signals differ in length");
        std::vector<double> applied(x.size());
        for (std::size_t k = 0; k < x.size(); ++k)
            applied[k] = step(x.data()[k], said.data()[k], measured.data()[k], 1, 0, true);
        return own(std::move(applied));
    }

    Words save() const
    {
        auto *image = new uint32_t[DEHYST_OFFSET_WORDS];
        nb::capsule owner(image, [](void *p) noexcept { delete[] static_cast<uint32_t *>(p); });
        dehyst_offset_save(&offset_, &state_, image);
        return Words(image, {static_cast<std::size_t>(DEHYST_OFFSET_WORDS)}, owner);
    }

    int32_t restore(const Image &image)
    {
        if (image.size() != static_cast<std::size_t>(DEHYST_OFFSET_WORDS)) return DEHYST_IMAGE_SIZE;
        return dehyst_offset_restore(&offset_, &state_, image.data());
    }

  private:
    dehyst_offset offset_;
    dehyst_offset_state state_{};
};

}  // namespace

void bind_offset(nb::module_ &m)
{
    m.attr("OFFSET_WORDS") = static_cast<int32_t>(DEHYST_OFFSET_WORDS);
    nb::class_<Offset> bound(m, "Offset", "An offset that follows the last cycle (packages/dehyst/core/offset.c), with its state.");
    refuse_pickling(bound);
    bound
        .def(nb::init<double, double, double, uint32_t>(), "limit"_a, "turn"_a, "part"_a, "fingerprint"_a)
        .def("reset", &Offset::reset, "Nothing seen, no offset.")
        .def("next", &Offset::next, "x"_a, "on"_a, "Offset for a sample, before its measurement.")
        .def("step", &Offset::step, "x"_a, "said"_a, "measured"_a, "share"_a, "flags"_a, "on"_a,
             "The same, and then the measurement is taken in.")
        .def("run", &Offset::run, "x"_a, "said"_a, "measured"_a, "Offsets (T,) of samples that are on.")
        .def("save", &Offset::save, "Image of the state.")
        .def("restore", &Offset::restore, "image"_a, "Go on from an image; the core's answer, 0 if it was good.")
        .def_prop_ro("applied", &Offset::applied, "In use.");
}
