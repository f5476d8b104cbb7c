// Tables of numbers in text: bytes in, columns out.
#include "arrays.h"

#include <Python.h>
#include <nanobind/stl/vector.h>

#include <algorithm>

#include "stoppable.h"
#include "text.h"

namespace {

constexpr int64_t PART = 1 << 15; // rows between two questions whether to go on

using Text = nb::bytes;
using Cells = nb::ndarray<nb::device::cpu, nb::c_contig>;
using Numbers = nb::ndarray<int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

// Python's own conversion, for the few numbers that need it.
double exact(const char *number, size_t length, void *context)
{
    std::string cell(number, length);
    std::replace(cell.begin(), cell.end(), *static_cast<const char *>(context), '.');
    nb::gil_scoped_acquire hold;
    const double value = PyOS_string_to_double(cell.c_str(), nullptr, nullptr);
    if (PyErr_Occurred()) PyErr_Clear();
    return value;
}

nb::tuple read_columns(const Text &text, size_t offset, int64_t line, char delimiter, char decimal,
                       const std::vector<int32_t> &letters, const std::vector<Cells> &columns, const Numbers &rows,
                       bool missing, bool portable)
{
    require(offset <= text.size() && columns.size() == letters.size() && !letters.empty(), "one array a column");
    std::vector<void *> data;
    std::vector<size_t> width;
    for (size_t j = 0; j < columns.size(); ++j) {
        const size_t bytes = letters[j] > 0 ? sizeof(uint32_t) * static_cast<size_t>(letters[j]) : sizeof(double);
        require(letters[j] >= 0 && columns[j].nbytes() >= bytes * rows.size(), "columns are too short");
        data.push_back(columns[j].data());
        width.push_back(bytes);
    }
    const text_format format{delimiter, decimal, missing, portable, static_cast<int32_t>(letters.size()),
                             letters.data(), exact, &decimal};
    text_stop stop{};
    stop.column = -1;
    int64_t count = 0;
    {
        nb::gil_scoped_release free;
        const auto room = static_cast<int64_t>(rows.size());
        for (bool more = room > 0; more;) {
            const int64_t part = std::min(room - count, PART);
            text_stop end{};
            const int64_t found = text_read(&format, text.c_str() + offset + stop.bytes,
                                            text.size() - offset - stop.bytes, line + stop.lines, part,
                                            rows.data() + count, data.data(), &end);
            count += found;
            stop = {stop.lines + end.lines, stop.bytes + end.bytes, end.column, stop.empty | end.empty,
                    stop.odd | end.odd};
            for (size_t j = 0; j < data.size(); ++j) data[j] = static_cast<char *>(data[j]) + width[j] * found;
            more = found == part && count < room && end.column < 0 && engine_asked() == 0;
        }
    }
    raise_if_stopped();
    return nb::make_tuple(count, stop.lines, stop.bytes, stop.column, stop.empty != 0, stop.odd != 0);
}

nb::object one_number(const Text &text, char decimal)
{
    double value = 0.0;
    const size_t used = text_number(text.c_str(), text.size(), decimal, exact, &decimal, &value);
    return used > 0 && used == text.size() ? nb::cast(value) : nb::none();
}

} // namespace

void bind_text(nb::module_ &m)
{
    m.def("text_lines", [](const Text &text, size_t offset) {
        require(offset <= text.size(), "offset behind the text");
        nb::gil_scoped_release free;
        return text_lines(text.c_str() + offset, text.size() - offset);
    }, "text"_a, "offset"_a = 0, "Number of lines.");
    m.def("text_offset", [](const Text &text, int64_t lines, size_t start) {
        const size_t begin = std::min(start, text.size());
        return begin + text_offset(text.c_str() + begin, text.size() - begin, lines);
    }, "text"_a, "lines"_a, "start"_a = 0, "Byte at which the line stands that follows so many lines from start on.");
    m.def("text_whole_lines", [](const Text &text) { return text_whole_lines(text.c_str(), text.size()); }, "text"_a,
          "Length of the longest part that ends with a line end.");
    m.def("text_number", one_number, "text"_a, "decimal"_a = '.', "The number a cell holds, or None.");
    m.def("text_read", read_columns, "text"_a, "offset"_a, "line"_a, "delimiter"_a, "decimal"_a, "letters"_a, "columns"_a,
          "rows"_a, "missing"_a = false, "portable"_a = false,
          "Rows, lines, bytes, column at fault or -1, whether cells are empty, whether cells are infinite.");
}
