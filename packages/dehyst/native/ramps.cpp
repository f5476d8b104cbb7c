// Binding of the columns of sums of elements: arrays in, an array filled, no formula.
#include "arrays.h"
#include "engine.h"

namespace {

using Table = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Filled = nb::ndarray<double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

void ramps(const Table &e, const Rows &cell, const Table &numbers, Filled out)
{
    const std::size_t n = cell.size(), cells = e.shape(1);
    require(numbers.shape(0) == 5 && numbers.shape(1) == n, "numbers must be (5, p) for cell (p,)");
    require(out.shape(0) == e.shape(0) && out.shape(1) == n, "out must be (T, p) for e (T, cells) and cell (p,)");
    for (std::size_t j = 0; j < n; ++j)
        require(cell.data()[j] >= 0 && static_cast<std::size_t>(cell.data()[j]) < cells, "cell names a column of e");
    const double *row = numbers.data();
    const engine_ramp_table table{static_cast<int64_t>(n), cell.data(), row, row + n, row + 2 * n, row + 3 * n, row + 4 * n};
    nb::gil_scoped_release released;
    engine_ramps(static_cast<int64_t>(e.shape(0)), static_cast<int64_t>(cells), e.data(), &table, out.data());
}

}  // namespace

void bind_ramps(nb::module_ &m)
{
    m.def("ramps", &ramps, "e"_a, "cell"_a, "numbers"_a, "out"_a,
          "Fill out (T, p) with ramps of cells e (T, cells) and of the first cell; numbers: gain, low, high, x_low, x_high.");
}
