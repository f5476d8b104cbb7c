"""The quick way through text logs: the bits of float(), the answers of the careful way, and safe on any bytes."""

import gzip
import math
import random
import re
import shutil
import struct
import subprocess
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dehyst import _native
from dehyst.errors import DehystError
from dehyst.io import _delimited as delimited
from dehyst.io import read_table
from dehyst.io._cells import cell_number
from dehyst.io._delimited import read_delimited
from dehyst.io._plain import Plain, read_part
from places import KERNEL

ENGINE = KERNEL / "engine"
WAYS = pytest.mark.parametrize("portable", [True, False], ids=["portable", "vector"])


def bits(value):
    return struct.pack("<d", value)


def read(text, letters, delimiter=",", decimal=".", missing=False, portable=False, room=None):
    """Rows, line numbers and the answer of the engine for a text."""
    room = room or _native.text_lines(text) + 1
    columns = [np.empty((room, k), np.uint32) if k else np.full(room, 7.25) for k in letters]
    rows = np.zeros(room, np.int64)
    count, *rest = _native.text_read(
        text, 0, 1, delimiter, decimal, list(letters), columns, rows, missing, portable
    )
    return (
        [
            c[:count].view(f"U{k}")[:, 0] if k else c[:count]
            for c, k in zip(columns, letters, strict=True)
        ],
        rows[:count],
        rest,
    )


# ---- One number.

NOTATIONS = [
    repr,
    "%.17g",
    "%.16e",
    "%e",
    "%+.3f",
    "%.20e",
    "%.25g",
    "%g",
    "%.0f",
    "%.1f",
    "%.9f",
    "%015.6f",
    "%.30f",
]
WORDS = ["nan", "NaN", "-nan", "+nan", "inf", "-inf", "+INF", "Infinity", "-infinity", "iNfInItY"]
SPECIAL = [
    *[
        "0",
        "-0",
        "+0",
        "-0.0",
        "0e400",
        "-0e-400",
        "1.",
        ".5",
        "-.5",
        "+.5e-3",
        "5.e2",
        "00012.500",
        "1E5",
        "1e+05",
    ],
    *[
        "1e400",
        "-1e400",
        "1e-400",
        "1e308",
        "1.7976931348623157e308",
        "1.7976931348623159e308",
        "4.9e-324",
        "2.4e-324",
    ],
    *[
        "2.2250738585072011e-308",
        "2.2250738585072014e-308",
        "1e22",
        "1e23",
        "9007199254740993",
        "9007199254740992",
    ],
    *[
        "9007199254740993.0",
        "18446744073709551615",
        "18446744073709551616",
        "99999999999999999999",
        "8.5e-65",
        "1e64",
    ],
    *[
        "1e65",
        "123456789012345678901234567890",
        "0." + "0" * 70 + "123456789",
        "1" + "0" * 60,
        "9" * 19,
        "9" * 20,
    ],
    *[
        "1e99999999999999999999",
        "1e-99999999999999999999",
        "0.1234567",
        "12345678.12345678",
        "1234567.12345678",
    ],
    *[
        "123456789.123456",
        "999999999999999",
        "9999999999999999",
        "99999999999999.9",
        "9" * 400 + "e-400",
    ],
]
NO_NUMBERS = [
    "",
    " ",
    "-",
    "+",
    ".",
    "-.",
    "e5",
    "1e",
    "1e+",
    "1e-x",
    "1 2",
    "0x10",
    "1_000",
    "1,5",
    "1.2.3",
    "--1",
    "na",
]
NO_NUMBERS += [
    "infin",
    "nanny",
    "1d5",
    "1.5f",
    "\xb2",
    "٣",
    "1\n",
    "NULL",
    "1.#INF",
    "(1)",
    "1e5.",
    "+-1",
    "in",
]


def test_special_numbers_are_those_of_float_and_what_is_no_plain_number_is_refused():
    found = {text: _native.text_number(text.encode()) for text in SPECIAL + WORDS + NO_NUMBERS}
    assert [text for text in SPECIAL + WORDS if bits(found[text]) != bits(float(text))] == []
    assert [text for text in NO_NUMBERS if found[text] is not None] == []


@given(st.floats(), st.sampled_from(NOTATIONS), st.sampled_from([".", ","]))
def test_every_float_in_every_notation_is_that_of_float(value, notation, decimal):
    text = notation(value) if callable(notation) else notation % value
    shown = text.replace(".", decimal)
    assert bits(_native.text_number(shown.encode(), decimal)) == bits(float(text))


@given(
    st.from_regex(
        r"[+-]?(\d{1,30}\.?\d{0,30}|\.\d{1,30})([eE][+-]?\d{1,3})?",
        fullmatch=True,
        alphabet="0123456789.eE+-",
    )
)
def test_every_spelling_of_a_number_is_that_of_float(text):
    assert bits(_native.text_number(text.encode())) == bits(float(text))


@given(st.text(alphabet="0123456789.eE+-naifty ,_x", max_size=12))
def test_a_text_is_a_number_if_it_is_one_for_float(text):
    try:
        known = float(text) if not set("_ ") & set(text) else None
    except ValueError:
        known = None
    found = _native.text_number(text.encode())
    assert (found is None) == (known is None)
    assert found is None or bits(found) == bits(known)


@given(st.integers(0, 2**53 - 1), st.integers(-320, 250), st.integers(-1, 1))
def test_decimals_half_way_between_two_doubles_go_to_the_even_one_and_their_neighbours_do_not(
    mantissa, exponent, shift
):
    low = math.ldexp(mantissa, exponent)
    high = math.nextafter(low, math.inf)
    middle = (Fraction(low) + Fraction(high)) / 2
    digits = 0
    while (middle * 10**digits).denominator != 1:
        digits += 64
    whole = middle.numerator * 10**digits // middle.denominator * 10 + shift
    text = f"{whole}e{-digits - 1}"
    assert bits(_native.text_number(text.encode())) == bits(float(text))


def test_the_table_of_powers_of_five_is_exact():
    text = (ENGINE / "powers.h").read_text()
    first, last = (
        int(n) for n in re.search(r"POWERS_FIRST = (-?\d+), POWERS_LAST = (\d+)", text).groups()
    )
    table = re.findall(r"\{0x([0-9a-f]{16}), 0x([0-9a-f]{16})\}", text)
    assert len(table) == last - first + 1
    for q, (high, low) in enumerate(table, first):
        value, exact = int(high + low, 16), Fraction(5) ** q
        scale = 127 - (exact.numerator.bit_length() - exact.denominator.bit_length())
        candidates = [exact * Fraction(2) ** s for s in (scale - 1, scale, scale + 1)]
        real = next(c for c in candidates if 2**127 <= c < 2**128)
        assert value == math.floor(real) + (-27 <= q < 0)


@WAYS
def test_a_hundred_thousand_numbers_in_columns_are_those_of_float(portable):
    draw = random.Random(4)
    rows = []
    for _ in range(12_000):
        value = (
            draw.gauss(0, 1) * 10.0 ** draw.randint(-70, 70)
            if draw.random() < 0.3
            else draw.gauss(0, 50)
        )
        usual = f"{value:.{draw.randint(1, 8)}f}" if abs(value) < 1e7 else "0.5"
        rows.append(
            [
                usual,
                repr(value),
                f"{value:.{draw.randint(0, 22)}e}",
                str(draw.randint(-(10**15), 10**15)),
            ]
        )
    for ending in ("\n", "\r\n", "\r"):
        text = ending.join(",".join(row) for row in rows).encode()
        columns, lines, (seen, used, fault, _, _) = read(text, [0] * 4, portable=portable)
        assert (seen, used, fault) == (len(rows), len(text), -1)
        assert lines.tolist() == list(range(1, len(rows) + 1))
        for column, cells in zip(columns, zip(*rows, strict=True), strict=True):
            assert column.tobytes() == np.array([float(cell) for cell in cells]).tobytes()


# ---- Lines, against an oracle that splits them one by one.


def oracle(text, width, delimiter, decimal, missing):
    """Rows and line numbers up to the first line that is not plain, and whether there was one."""
    lines = re.split("\r\n|\r|\n", text)
    lines = lines[:-1] if lines[-1] == "" else lines
    rows, numbers = [], []
    for k, line in enumerate(lines, 1):
        bare = line.strip(" \t")
        if not bare or bare.startswith(("#", "%", "//")):
            continue
        cells = line.split() if delimiter == " " else line.split(delimiter)
        row = []
        for cell in cells:
            plain = cell.strip(" \t")
            if decimal == ",":
                plain = "x" if "." in plain else plain.replace(",", ".")
            if missing and not cell.strip(" \t"):
                row.append(math.nan)
                continue
            value = _native.text_number(plain.encode())  # itself tested above
            if value is None:
                break
            row.append(value)
        if len(row) != len(cells) or len(cells) != width:
            return rows, numbers, True
        rows.append(row)
        numbers.append(k)
    return rows, numbers, False


PIECES = [
    "1",
    "-2.5",
    "0.125",
    "3e-5",
    ",",
    ";",
    "\t",
    " ",
    "\n",
    "\r\n",
    "\r",
    "#",
    "// ",
    "%",
    '"',
    "nan",
    "x",
    "1,5",
]
PIECES += [
    "",
    "123456789012345678",
    "7,",
    "1;2\n",
    "1,2\n",
    "3.25,-4.5\n",
    "0.1;0.2\n",
    "5,6\n7,8\n" * 20,
    "1 2\n" * 30,
]
PIECES += ["-", "inf"]


@WAYS
@given(
    pieces=st.lists(st.sampled_from(PIECES), max_size=40),
    width=st.integers(1, 3),
    delimiter=st.sampled_from([",", ";", "\t", " "]),
    missing=st.booleans(),
    comma=st.booleans(),
)
def test_lines_are_read_as_one_by_one(portable, pieces, width, delimiter, missing, comma):
    text = "".join(pieces)
    decimal = "," if comma and delimiter != "," else "."
    missing = missing and delimiter != " "
    rows, numbers, stopped = oracle(text, width, delimiter, decimal, missing)
    columns, lines, (seen, used, fault, _, _) = read(
        text.encode(), [0] * width, delimiter, decimal, missing, portable
    )
    assert (fault >= 0) == stopped
    assert lines.tolist() == numbers
    assert np.array(columns).T.tobytes() == np.array(rows, dtype=float).reshape(-1, width).tobytes()
    assert stopped or (used == len(text) and seen == _native.text_lines(text.encode()))


@given(
    data=st.binary(max_size=300),
    width=st.integers(1, 3),
    delimiter=st.sampled_from(",;\t |"),
    text=st.booleans(),
)
def test_any_bytes_are_safe_and_both_ways_agree(data, width, delimiter, text):
    letters = [8 if text and j == 0 else 0 for j in range(width)]
    one, two = (
        read(data, letters, delimiter, missing=delimiter != " ", portable=p) for p in (True, False)
    )
    assert one[2] == two[2]
    assert one[1].tobytes() == two[1].tobytes()
    assert all(a.tobytes() == b.tobytes() for a, b in zip(one[0], two[0], strict=True))
    assert 0 <= one[2][1] <= len(data)


@WAYS
def test_reading_goes_on_where_room_ended(portable):
    text = "".join(
        f"{k}.5,{k * k}\n" + ("# note\n" if k % 7 == 0 else "") for k in range(100)
    ).encode()
    plain = Plain(",", ".", (0, 0))
    offset, line, found, lines = 0, 1, [], []
    while offset < len(text):
        part = read_part(text, offset, line, plain, 13)
        assert part.rows.size <= 13
        offset, line = offset + part.bytes, line + part.lines
        found += part.columns[1].tolist()
        lines += part.rows.tolist()
    assert found == [k * k for k in range(100)]
    assert [text.decode().splitlines()[k - 1].partition(",")[2] for k in lines] == [
        str(k * k) for k in range(100)
    ]


def test_offsets_and_line_counts_agree_at_all_three_line_ends():
    text = b"a\nb\r\nc\rd\n\r\n\re"
    offsets = [_native.text_offset(text, k) for k in range(9)]
    assert [text[a:b].strip() for a, b in pairwise(offsets)] == [
        b"a",
        b"b",
        b"c",
        b"d",
        b"",
        b"",
        b"e",
        b"",
    ]
    assert [_native.text_lines(text[: len(text) - k]) for k in range(4)] == [7, 6, 5, 5]
    assert text[: _native.text_whole_lines(text)] == text[:-1]
    assert _native.text_whole_lines(b"a\nb\r") == 2  # the CR may be half of a line end


def test_labels_keep_their_letters_and_lose_the_blanks_around_them():
    text = "Über, 1\n  a b ,2\n\t,3\n日本𝄞,4\n".encode()
    columns, _, (_, _, fault, _, _) = read(text, [8, 0])
    assert fault == -1
    assert columns[0].tolist() == ["Über", "a b", "", "日本𝄞"]
    for bad in ('"a",1', "abcdefgh,1", "\xa0a,1", "a\u3000,1", "a\x00b,1"):
        assert read(bad.encode(), [8, 0])[2][2] == 0
    assert read(b"\xff,1", [8, 0])[2][2] == 0
    assert read(b"\xed\xa0\x80,1", [8, 0])[2][2] == 0  # half of a pair


@WAYS
def test_no_byte_before_the_text_counts(portable):
    columns, rows = [np.empty(1) for _ in range(3)], np.zeros(1, np.int64)
    answer = _native.text_read(b" \0", 1, 1, " ", ".", [0, 0, 0], columns, rows, True, portable)
    assert answer[3] == 1  # the blank before the offset sets nothing off


@pytest.mark.slow
def test_no_byte_beyond_the_text_is_read(tmp_path):
    compiler = shutil.which("gcc") or shutil.which("clang")
    if not compiler:
        pytest.skip("no compiler")
    main = tmp_path / "main.c"
    main.write_text(HARNESS)
    sources = [
        ENGINE / "text.c",
        ENGINE / "number.c",
        ENGINE / "text_tables.c",
        ENGINE / "lanes" / "text_rows.c",
        main,
    ]
    flags = [
        "-std=c11",
        "-O1",
        "-g",
        "-fsanitize=address,undefined",
        "-fno-sanitize-recover=all",
        f"-I{ENGINE}",
    ]
    for level in ([], ["-mavx2"]):
        vector = bool(level)
        if vector and "avx2" not in (
            Path("/proc/cpuinfo").read_text() if Path("/proc/cpuinfo").exists() else ""
        ):
            continue
        more = [
            f"-DLANES_LEVEL={int(vector)}",
            f"-DREAD={'text_read_avx2' if vector else 'text_read_portable'}",
        ]
        command = [
            compiler,
            *flags,
            *level,
            *more,
            *map(str, sources),
            "-DSTUBS",
            "-lm",
            "-o",
            str(tmp_path / "fuzz"),
        ]
        built = subprocess.run(command, capture_output=True, text=True, timeout=600)
        if re.search(r"cannot find|unsupported", built.stderr):
            pytest.skip("no sanitizers")
        assert built.returncode == 0, built.stderr
        done = subprocess.run([str(tmp_path / "fuzz")], capture_output=True, text=True, timeout=600)
        assert done.returncode == 0, done.stderr[-2000:]


HARNESS = r"""
#include <stdlib.h>
#include <string.h>
#include "text.h"
#include "text_levels.h"
int engine_level(void);
int engine_level(void) { return 0; }
#ifndef __AVX2__
int64_t text_read_avx2(const text_format *f, const char *t, size_t s, int64_t l, int64_t c, int64_t *r, void *const *o,
                       text_stop *p) { return text_read_portable(f, t, s, l, c, r, o, p); }
#else
int64_t text_read_portable(const text_format *f, const char *t, size_t s, int64_t l, int64_t c, int64_t *r,
                           void *const *o, text_stop *p) { return text_read_avx2(f, t, s, l, c, r, o, p); }
#endif
static double exact(const char *s, size_t n, void *c) { (void)c; return n > 0 && s[n - 1] == '1' ? 1.0 : 2.0; }
int main(void)
{
    static const char *const piece[] = {"1.25", "-3", ",", "\n", "\r\n", "\r", "1e9", "nan", "#", " ", "\t", "ab",
                                        "123456789.12345678", "\xc3\xa9", "\xf0", "99999999999999999999.5", "-", "+",
                                        "1.5,2.5\n3.5,-4.5\n0.25,7.125\n", "0.001,1\n", "inf", "1e", "."};
    unsigned long long state = 88172645463325252ull;
    for (int k = 0; k < 40000; k++) {
        char text[400];
        size_t size = 0, limit = (size_t)(k % 397);
        while (size < limit) {
            state ^= state << 13, state ^= state >> 7, state ^= state << 17;
            const char *p = piece[state % (sizeof piece / sizeof *piece)];
            for (; *p && size < limit; p++) text[size++] = *p;
        }
        char *copy = malloc(size ? size : 1);
        memcpy(copy, text, size);
        int64_t capacity = 1 + k % 50;
        int32_t letters[2] = {k % 3 == 0 ? 5 : 0, 0};
        text_format format = {.delimiter = ",; \t"[k % 4], .decimal = k % 5 ? '.' : ',', .missing = k % 2,
                              .width = 1 + k % 2, .letters = letters, .exact = exact};
        void *column[2] = {malloc((size_t)capacity * 20), malloc((size_t)capacity * 8)};
        int64_t *row = malloc((size_t)capacity * sizeof *row);
        text_stop stop;
        int64_t rows = READ(&format, copy, size, 1, capacity, row, column, &stop);
        if (rows < 0 || rows > capacity || stop.bytes > size) return 1;
        if (text_lines(copy, size) < rows || text_offset(copy, size, rows) > size) return 2;
        if (text_whole_lines(copy, size) > size) return 3;
        free(copy), free(column[0]), free(column[1]), free(row);
    }
    return 0;
}
"""


# ---- Whole logs, against the careful way.


def both(data, monkeypatch):
    """Tables of the quick and of the careful way, or what they say; and whether the quick way was taken."""
    taken = []
    quick = delimited._quick

    def watch(*arguments):
        taken.append(quick(*arguments))
        return taken[-1]

    answers = []
    for way in (watch, lambda *_: None):
        monkeypatch.setattr(delimited, "_quick", way)
        try:
            answers.append(read_delimited(data, "log.csv"))
        except DehystError as fault:
            answers.append(f"{type(fault).__name__}: {fault}")
    monkeypatch.setattr(delimited, "_quick", quick)
    return *answers, bool(taken and taken[-1])


def require_same(quick, careful, log=""):
    if isinstance(quick, str) or isinstance(careful, str):
        assert quick == careful, log
        return
    for name in ("name", "units", "row_word", "stamps", "order", "refused", "findings"):
        assert getattr(quick, name) == getattr(careful, name), f"{log}: {name}"
    assert quick.rows.tolist() == careful.rows.tolist()
    assert list(quick.columns) == list(careful.columns)
    assert list(quick.labels) == list(careful.labels)
    for name, values in quick.columns.items():
        assert values.tobytes() == careful.columns[name].tobytes(), name
    for name, labels in quick.labels.items():
        assert labels.tolist() == careful.labels[name].tolist()


def log_text(
    delimiter=",", decimal=".", rows=300, header=True, style="{:.4f}", run=False, extra=()
):
    lines = (
        [delimiter.join([*(["run"] if run else []), "time_s", "pressure [bar]", "angle [deg]"])]
        if header
        else []
    )
    for k in range(rows):
        values = [
            style.format(v).replace(".", decimal)
            for v in (k / 8, 3 * math.sin(k / 9), 20 * math.cos(k / 9))
        ]
        lines.append(delimiter.join([*([f"run {1 + k // 100}"] if run else []), *values]))
        lines += [text for place, text in extra if place == k]
    return "\n".join(lines) + "\n"


QUICK = {
    "comma": log_text(),
    "semicolon, decimal comma": log_text(";", ","),
    "tab": log_text("\t"),
    "blanks": log_text("   "),
    "bar": log_text("|"),
    "no header": log_text(header=False),
    "all digits": log_text(style="{!r}"),
    "exponents": log_text(style="{:.7e}"),
    "run": log_text(run=True),
    "comments and empty lines": "# made by a rig\n\n"
    + log_text(extra=[(3, "# note"), (50, ""), (70, "  "), (90, "% x")]),
    "missing cells": log_text(
        extra=[(k, f"{k}.5,,2") for k in range(0, 200, 3)] + [(7, ",,"), (8, "1,nan,2")]
    ),
    "infinite cells": log_text(extra=[(9, "inf,1,-Infinity"), (10, "1,1e400,2")]),
    "longer than what the layout is found by": log_text(
        rows=12_000, extra=[(11_000, "# late"), (11_500, "1,nan,2")]
    ),
    "one line": "1,2,3\n",
    "run and missing cells": log_text(
        run=True, extra=[(k, f"run 1,{k}.5,,") for k in range(0, 90, 3)]
    ),
    "runs that begin with digits": log_text(run=True)
    .replace("run ", "200g_")
    .replace("200g_,", "run,"),
    "preamble": "Rig 7\nOperator: N. N.\n\n" + log_text(),
    "units row": "t,p,phi\ns,bar,deg\n" + log_text(header=False),
}
CAREFUL = {
    "text in a cell": log_text(extra=[(9, "1,ERR,2")]),
    "runs that are numbers further on": log_text(run=True, extra=[(280, "7,1,,3")]),
    "runs in brackets": log_text(run=True, extra=[(280, "(7),1,,3")]),
    "quotes": log_text(extra=[(9, '"1",2,3')]),
    "short line": log_text(extra=[(9, "1,2")]),
    "missing and infinite": log_text(extra=[(9, "1,,2"), (10, "1,inf,2")]),
    "late text": log_text(rows=9_000, extra=[(8_900, "1,ERR,2")]),
    "late thousands": log_text("\t", ",", style="{:.0f}", extra=[(250, "1,017\t2\t3")]),
    "words for missing": log_text(extra=[(k, "1,NA,-") for k in range(0, 90, 2)]),
    "fortran": log_text(extra=[(20, "1.5d3,2,3")]),
}


@pytest.mark.parametrize("ending", ["\n", "\r\n", "\r"], ids=["lf", "crlf", "cr"])
def test_the_quick_way_answers_as_the_careful_way(ending, monkeypatch):
    for name, text in {**QUICK, **CAREFUL}.items():
        quick, careful, taken = both(text.replace("\n", ending).encode(), monkeypatch)
        assert taken == (name in QUICK), name
        if (
            name == "infinite cells"
        ):  # the only thing that the careful way keeps as well if all other cells are plain
            assert np.isinf(quick.columns["time_s"]).sum() == 1
        require_same(quick, careful, name)


@pytest.mark.slow
@pytest.mark.parametrize(
    "encoding", ["utf-8", "utf-8-sig", "latin-1", "utf-16", "utf-16-le", "utf-16-be"]
)
@pytest.mark.parametrize("late", [False, True], ids=["header", "label"])
def test_every_encoding_goes_the_quick_way_with_the_same_answer(encoding, late, monkeypatch):
    lines = ["run;Zeit [s];Druck [bar];Winkel [°]"]
    lines += [f"{'Übung' if late and k > 8000 else 'x'};{k};{k % 7}.5;{k % 5}" for k in range(9000)]
    quick, careful, taken = both("\n".join(lines).encode(encoding), monkeypatch)
    assert taken
    assert list(quick.columns) == ["Zeit [s]", "Druck [bar]", "Winkel [°]"]
    assert set(quick.labels["run"].tolist()) == ({"x", "Übung"} if late else {"x"})
    require_same(quick, careful)


CELLS = st.one_of(
    st.floats(width=32).map(repr),
    st.integers(-9999, 9999).map(str),
    st.sampled_from(
        [
            "",
            " ",
            "nan",
            "inf",
            "x",
            "1,5",
            '"2"',
            "12:00:00",
            "NA",
            "1.5 ",
            "3 bar",
            "+.5",
            "-0",
            "1e400",
        ]
    ),
)
PLAIN_CELLS = st.floats(-1e6, 1e6).map("{:.4f}".format)


@given(
    rows=st.lists(
        st.lists(st.one_of(PLAIN_CELLS, PLAIN_CELLS, PLAIN_CELLS, CELLS), min_size=2, max_size=2),
        max_size=40,
    ),
    delimiter=st.sampled_from([",", ";", "\t", " "]),
    between=st.sampled_from(["", "# c", "  ", "\t", "//", "/", "\x0b"]),
    place=st.integers(0, 40),
)
def test_generated_logs_are_read_as_by_the_careful_way(rows, delimiter, between, place):
    lines = [delimiter.join(row) for row in rows]
    lines.insert(place, between)
    text = "\n".join(
        [delimiter.join(["p", "q"]), *[delimiter.join(["1.5", "2.5"])] * 3, *lines]
    ).encode()
    with pytest.MonkeyPatch.context() as patch:
        quick, careful, _ = both(text, patch)
    require_same(quick, careful)


def test_a_packed_log_and_its_fingerprint_are_the_same(tmp_path):
    text = log_text(rows=40_000).encode()
    (tmp_path / "log.csv").write_bytes(text)
    (tmp_path / "log.csv.gz").write_bytes(gzip.compress(text))
    plain, packed = read_table(tmp_path / "log.csv"), read_table(tmp_path / "log.csv.gz")
    assert plain.columns["angle [deg]"].tobytes() == packed.columns["angle [deg]"].tobytes()
    assert len(plain.sha256) == 64
    assert plain.sha256 != packed.sha256
    assert cell_number("1.5") == 1.5
