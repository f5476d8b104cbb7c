// What all binding files share: arrays in, arrays out.
#ifndef DEHYST_NATIVE_ARRAYS_H
#define DEHYST_NATIVE_ARRAYS_H

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace nb = nanobind;
using namespace nb::literals;

using In = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Rows = nb::ndarray<const int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Out = nb::ndarray<nb::numpy, double, nb::ndim<1>>;
using Matrix = nb::ndarray<nb::numpy, double, nb::ndim<2>>;

inline Out own(std::vector<double> &&values)
{
    auto *kept = new std::vector<double>(std::move(values));
    nb::capsule owner(kept, [](void *p) noexcept { delete static_cast<std::vector<double> *>(p); });
    return Out(kept->data(), {kept->size()}, owner);
}

inline std::vector<double> copy(const In &array) { return {array.data(), array.data() + array.size()}; }

inline void require(bool holds, const char *message)
{
    if (!holds) throw std::invalid_argument(message);
}

void bind_models(nb::module_ &m);
void bind_joint(nb::module_ &m);
void bind_plant(nb::module_ &m);
void bind_robot(nb::module_ &m);
void bind_solver(nb::module_ &m);

#endif
