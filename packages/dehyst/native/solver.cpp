// Binding of the engine's bounded least squares: arrays in, arrays out, no formula.
#include <nanobind/stl/optional.h>

#include <cmath>
#include <optional>

#include "arrays.h"
#include "engine.h"
#include "stoppable.h"

namespace {

using Square = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Marks = nb::ndarray<const bool, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Marked = nb::ndarray<nb::numpy, bool, nb::ndim<1>>;

const double *square_of(const Square &matrix, std::size_t n, const char *message)
{
    require(matrix.shape(0) == n && matrix.shape(1) == n, message);
    return matrix.data();
}

const double *vector_of(const In &vector, std::size_t n, const char *message)
{
    require(vector.size() == n, message);
    for (std::size_t i = 0; i < n; ++i) require(std::isfinite(vector.data()[i]), "all numbers must be finite");
    return vector.data();
}

nb::tuple solve(const Square &gram, const In &rhs, const In &lower, int64_t free_unknowns, int64_t plays, int basis,
                const std::optional<Square> &extra, const std::optional<In> &extra_rhs,
                const std::optional<Marks> &passive, double target_norm)
{
    const std::size_t n = rhs.size();
    require(n >= 1 && n < 46341, "between 1 and 46340 unknowns can be solved");
    require(free_unknowns >= 0 && plays >= 0 && free_unknowns <= static_cast<int64_t>(n) &&
                plays <= static_cast<int64_t>(n) - free_unknowns,
            "free and plays exceed the number of unknowns");
    require(basis >= ENGINE_SLOPES && basis <= ENGINE_STOPS, "basis is 0 (slopes), 1 (weights) or 2 (stops)");
    require(std::isfinite(target_norm) && target_norm >= 0.0, "target_norm must be finite and not negative");
    engine_program program{};
    program.unknowns = static_cast<int32_t>(n);
    program.free = static_cast<int32_t>(free_unknowns);
    program.plays = static_cast<int32_t>(plays);
    program.basis = basis;
    program.gram = square_of(gram, n, "gram must be (N, N) for rhs (N,)");
    program.rhs = vector_of(rhs, n, "rhs has no length");
    program.lower = vector_of(lower, n, "lower and rhs differ in length");
    program.target_norm = target_norm;
    if (extra) program.extra = square_of(*extra, n, "extra must be (N, N) for rhs (N,)");
    if (extra_rhs) program.extra_rhs = vector_of(*extra_rhs, n, "extra_rhs and rhs differ in length");
    require(!passive || passive->size() == n, "passive and rhs differ in length");

    for (std::size_t j = 0; j < n; ++j) require(std::isfinite(program.gram[j * n + j]), "all numbers must be finite");

    std::vector<double> u(n);
    auto *marks = new std::vector<uint8_t>(n, 0);
    nb::capsule owner(marks, [](void *p) noexcept { delete static_cast<std::vector<uint8_t> *>(p); });
    for (std::size_t j = 0; passive && j < n; ++j) (*marks)[j] = passive->data()[j] ? 1 : 0;
    engine_solution solution{};
    int failed;
    {
        nb::gil_scoped_release released;
        failed = engine_solve(&program, u.data(), marks->data(), &solution);
    }
    raise_if_stopped();
    if (failed) throw std::bad_alloc();
    return nb::make_tuple(own(std::move(u)), Marked(marks->data(), {n}, owner), solution.kkt, solution.condition,
                          solution.iterations, solution.status);
}

using Written = nb::ndarray<double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

void triangle(const Square &matrix, Written out)
{
    const std::size_t n = matrix.shape(0);
    square_of(matrix, n, "a triangle is taken of a square matrix");
    require(n < 46341 && out.size() == n * (n + 1) / 2, "out must have n (n + 1) / 2 numbers");
    engine_triangle(static_cast<int32_t>(n), matrix.data(), out.data());
}

Matrices sums_of_triangles(const Square &triangles, const Square &factors, const Rows &chosen)
{
    const std::size_t n = chosen.size(), size = triangles.shape(1), sums = factors.shape(0), most = 46340;
    require(triangles.shape(0) == factors.shape(1), "triangles (M, size) and factors (sums, M) differ");
    require(factors.shape(1) <= most && sums <= most && n <= most, "at most 46340 matrices, sums and rows");
    int64_t last = -1;
    for (std::size_t k = 0; k < n; last = chosen.data()[k++])
        require(chosen.data()[k] > last && chosen.data()[k] < static_cast<int64_t>(most), "chosen must increase, from 0 on");
    require(static_cast<std::size_t>((last + 1) * (last + 2) / 2) <= size, "chosen rows lie outside the triangles");
    Buffer out(sums * n * n);
    int failed;
    {
        nb::gil_scoped_release released;
        failed = engine_sums_of_triangles(static_cast<int32_t>(factors.shape(1)), static_cast<int64_t>(size), triangles.data(),
                                          static_cast<int32_t>(sums), factors.data(), static_cast<int32_t>(n), chosen.data(),
                                          out.data());
    }
    if (failed) throw std::bad_alloc();
    return out.release(sums, n, n);
}

}  // namespace

void bind_solver(nb::module_ &m)
{
    m.attr("SLOPES") = static_cast<int>(ENGINE_SLOPES);
    m.attr("WEIGHTS") = static_cast<int>(ENGINE_WEIGHTS);
    m.attr("STOPS") = static_cast<int>(ENGINE_STOPS);
    m.def("solve_bounded", &solve, "gram"_a, "rhs"_a, "lower"_a, "free"_a, "plays"_a, "basis"_a,
          "extra"_a = nb::none(), "extra_rhs"_a = nb::none(), "passive"_a = nb::none(), "target_norm"_a = 0.0,
          "Bounded least squares on normal equations of the cells: (u, passive, kkt, condition, iterations, status).");
    m.def("triangle", &triangle, "matrix"_a, "out"_a, "Write the lower triangle of a matrix (n, n), row by row.");
    m.def("sums_of_triangles", &sums_of_triangles, "triangles"_a, "factors"_a, "chosen"_a,
          "Weighted sums (sums, n, n) of symmetric matrices at some rows and columns; their lower triangles are stored.");
}
