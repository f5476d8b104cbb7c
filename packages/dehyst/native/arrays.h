// What all binding files share: arrays in, arrays out.
#ifndef DEHYST_NATIVE_ARRAYS_H
#define DEHYST_NATIVE_ARRAYS_H

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace nb = nanobind;
using namespace nb::literals;

using In = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Rows = nb::ndarray<const int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Out = nb::ndarray<nb::numpy, double, nb::ndim<1>>;
using Matrix = nb::ndarray<nb::numpy, double, nb::ndim<2>>;
using Matrices = nb::ndarray<nb::numpy, double, nb::ndim<3>>;

inline Out own(std::vector<double> &&values)
{
    auto *kept = new std::vector<double>(std::move(values));
    nb::capsule owner(kept, [](void *p) noexcept { delete static_cast<std::vector<double> *>(p); });
    return Out(kept->data(), {kept->size()}, owner);
}

// Room for outputs that need no zeros first; in huge pages where the system offers them, as numpy does.
class Buffer {
  public:
    explicit Buffer(std::size_t size)
        : size_(size), data_(static_cast<double *>(std::malloc(size > 0 ? size * sizeof(double) : 1)))
    {
        if (data_ == nullptr) throw std::bad_alloc();
#ifdef __linux__
        const std::uintptr_t page = 4096, from = reinterpret_cast<std::uintptr_t>(data_), large = std::uintptr_t{1} << 22;
        const std::uintptr_t start = (from + page - 1) & ~(page - 1), bytes = size * sizeof(double);
        if (bytes >= large) madvise(reinterpret_cast<void *>(start), bytes - (start - from), MADV_HUGEPAGE);
#endif
    }
    ~Buffer() { std::free(data_); }
    Buffer(const Buffer &) = delete;
    Buffer &operator=(const Buffer &) = delete;

    double *data() { return data_; }
    Out release()
    {
        double *given = std::exchange(data_, nullptr);
        nb::capsule owner(given, [](void *p) noexcept { std::free(p); });
        return Out(given, {size_}, owner);
    }

    Matrix release(std::size_t rows, std::size_t columns)
    {
        double *given = std::exchange(data_, nullptr);
        nb::capsule owner(given, [](void *p) noexcept { std::free(p); });
        return Matrix(given, {rows, columns}, owner);
    }

    Matrices release(std::size_t matrices, std::size_t rows, std::size_t columns)
    {
        double *given = std::exchange(data_, nullptr);
        nb::capsule owner(given, [](void *p) noexcept { std::free(p); });
        return Matrices(given, {matrices, rows, columns}, owner);
    }

  private:
    std::size_t size_;
    double *data_;
};

inline std::vector<double> copy(const In &array) { return {array.data(), array.data() + array.size()}; }

inline void require(bool holds, const char *message)
{
    if (!holds) throw std::invalid_argument(message);
}

void bind_stoppable();
void bind_models(nb::module_ &m);
void bind_block(nb::module_ &m);
void bind_direct(nb::module_ &m);
void bind_direct_block(nb::module_ &m);
void bind_gram(nb::module_ &m);

void bind_text(nb::module_ &m);
void bind_solver(nb::module_ &m);
void bind_ramps(nb::module_ &m);
void bind_engine(nb::module_ &m);
void bind_element_sum(nb::module_ &m);
void bind_stack(nb::module_ &m);
void bind_signal(nb::module_ &m);
void bind_direct_forward(nb::module_ &m);
void bind_friction(nb::module_ &m);
void bind_triangle(nb::module_ &m);
void bind_oscillator(nb::module_ &m);
void bind_offset(nb::module_ &m);

#endif
