"""The own checker of Structured Text: it runs the language as it is defined and refuses what tools do not agree on."""

import math
import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dehyst_targets.iec import TextError, load_program
from dehyst_targets.iec._machine import ProgramError

DOUBLES = st.floats(allow_nan=True, allow_infinity=True)
SINGLES = st.floats(width=32)


def block(body, variables="", real="LREAL"):
    return (
        f"FUNCTION_BLOCK Fb\nVAR_INPUT a : {real}; b : {real}; END_VAR\nVAR_OUTPUT y : {real}; END_VAR\n"
        f"VAR c : {real}; i : DINT; k : UDINT; z : ARRAY[0..3] OF {real}; flag : BOOL; {variables} END_VAR\n"
        f"c := a; c := b; i := 0; k := 0; z[0] := a; flag := FALSE; y := c;\n{body}\nEND_FUNCTION_BLOCK"
    )


def bits(value, form="d"):
    return struct.pack(form, value) if not math.isnan(value) else "nan"


def run(body, variables="", real="LREAL", **inputs):
    return load_program(block(body, variables, real)).new("fb").call(**inputs)["y"]


@given(DOUBLES, DOUBLES, st.sampled_from("+-*/"))
def test_lreal_is_ieee_double(a, b, sign):
    with np.errstate(all="ignore"):
        expected = {"+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide}[sign](a, b)
    assert bits(run(f"y := a {sign} b;", a=a, b=b)) == bits(float(expected))


@given(SINGLES, SINGLES, st.sampled_from("+-*/"))
def test_real_is_ieee_single(a, b, sign):
    with np.errstate(all="ignore"):
        f = {"+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide}[sign]
        expected = f(np.float32(a), np.float32(b))
    assert bits(run(f"y := a {sign} b;", real="REAL", a=a, b=b), "f") == bits(float(expected), "f")


@given(DOUBLES, DOUBLES, st.sampled_from(["<", "<=", ">", ">=", "=", "<>"]))
def test_comparisons_are_those_of_ieee_and_false_for_nan(a, b, sign):
    python = {"=": "==", "<>": "!="}.get(sign, sign)
    expected = a if eval(f"a {python} b", {"a": a, "b": b}) else b
    assert bits(run(f"IF a {sign} b THEN y := a; ELSE y := b; END_IF;", a=a, b=b)) == bits(expected)


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("a - b - a", -3.0),  # from the left
        ("a + b * a", 8.0),
        ("(a + b) * a", 10.0),
        ("-a * b", -6.0),
        ("a / b / a", 2 / 3 / 2),
    ],
)
def test_signs_bind_as_in_the_standard(expression, value):
    assert run(f"y := {expression};", a=2.0, b=3.0) == value


def test_loops_count_and_leave_as_in_the_standard():
    body = "WHILE i <= 3 DO z[i] := a; a2 := a2 + b; IF i >= 2 THEN EXIT; END_IF; i := i + 1; END_WHILE; y := a2;"
    assert run(body, "a2 : LREAL;", a=1.0, b=1.5) == 4.5
    assert run("WHILE i > 0 DO y := a; END_WHILE;", a=7.0, b=1.0) == 1.0
    assert run("i := 3; WHILE i > 0 DO i := i - 1; y := y + a; END_WHILE;", a=2.0, b=1.0) == 7.0


def test_branches_are_tried_in_order_and_comments_are_skipped():
    body = "IF a > b THEN y := a; (* IF *) ELSIF NOT flag AND (a < b) THEN\n(* y := \n*) y := b; ELSE y := c; END_IF;"
    assert run(body, a=1.0, b=2.0) == 2.0
    assert run(body, a=3.0, b=2.0) == 3.0


def test_an_instance_keeps_its_variables_and_blocks_can_be_called():
    text = block("z[1] := z[1] + a; y := z[1];") + (
        "\nPROGRAM Main VAR first : fb; other : FB; END_VAR VAR_OUTPUT one : LREAL; two : LREAL; END_VAR\n"
        "first(a := 1.5, b := 0.0); first(a := 1.0); other(a := 4.0, b := 1.0); one := first.y; two := other.y;"
        "END_PROGRAM"
    )
    assert load_program(text).new("MAIN").call() == {"one": 2.5, "two": 4.0}


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("y := d;", "d is not declared"),
        ("y := i;", "LREAL expected, DINT found"),
        ("y := a + i;", "LREAL expected, DINT found"),
        ("i := k;", "DINT expected, UDINT found"),
        ("y := a + 1.0;", "declare it as a constant"),
        ("y := 1;", "1 is no LREAL"),
        ("i := 3000000000;", "beyond DINT"),
        ("i := 1.5;", "1.5 is no DINT"),
        ("a := y;", "a cannot be assigned"),
        ("z := a;", "z is ARRAY"),
        ("y := z;", "z is ARRAY"),
        ("y := a[0];", "a is LREAL"),
        ("y := z[k];", "DINT expected"),
        ("IF a THEN y := b; END_IF;", "BOOL expected"),
        ("IF a AND flag THEN y := b; END_IF;", "BOOL expected"),
        ("flag := NOT a;", "BOOL expected"),
        ("flag := flag = flag;", "cannot be compared"),
        ("flag := flag + flag;", "no . of BOOL"),
        ("flag := a = b", "; expected"),
        ("EXIT;", "EXIT outside a loop"),
        ("FOR i := 0 TO 3 DO y := a; END_FOR;", "if its ends are equal, write WHILE"),
        ("flag := NOT (flag AND (a < b));", "some tools take it for one of bits"),
        ("flag := NOT ((a < b) OR flag);", "some tools take it for one of bits"),
        ("y := 1.0E39;", "1.0E39 is no ordinary REAL"),
        ("y := -1.0E-38;", "-1.0E-38 is no ordinary REAL"),
        ("y := 1.0E999;", "1.0E999 is beyond LREAL"),
        ("y := -2.0E308;", "-2.0E308 is beyond LREAL"),
        ("IF a > b THEN y := a;", "END_FUNCTION_BLOCK"),
        ("y := SQRT(a);", "not free"),
        ("y := a ** b;", "not free"),
        ("y := a % b;", "no word"),
        ("y := a.b;", "has no parts"),
        ("{attribute} y := a;", "not free"),
        ("c(a := b);", "no function block"),
        ("(* ä *) y := a;", "no word"),
        ("y := " + "(" * 40 + "a" + ")" * 40 + ";", "nested"),
        ("IF flag THEN " * 40 + "y := a;" + "END_IF;" * 40, "nested"),
    ],
)
def test_what_breaks_a_rule_is_refused_with_its_line(body, message):
    with pytest.raises(TextError, match=message) as caught:
        load_program(block(body))
    assert caught.value.facts["line"] >= 5


@pytest.mark.parametrize(
    ("variables", "message"),
    [
        ("A : LREAL;", "declared twice"),  # case does not count
        ("FB : LREAL;", "declared twice"),
        ("d : LREAL;", "never used"),
        ("d : ARRAY[0..2] OF LREAL := [1.0, 2.0];", "2 initial values for 3"),
        ("d : LREAL := 1;", "d: 1 is no LREAL"),
        ("d : LREAL := -1.0E309;", "d: -1.0E309 is beyond LREAL"),
        ("d : REAL := 3.5E38;", "d: 3.5E38 is beyond REAL"),
        ("d : ARRAY[0..1] OF REAL := [1.0, -1.0E39];", "d: -1.0E39 is beyond REAL"),
        ("d : DINT := TRUE;", "TRUE is no DINT"),
        ("d : Thing;", "no type Thing"),
        ("d : ARRAY[0..2000000000] OF LREAL;", "not known"),
        ("Limit : LREAL;", "not free"),
        ("d__e : LREAL;", "underscores"),
        ("d_ : LREAL;", "underscores"),
        ("a23456789012345678901234567890123 : LREAL;", "33 characters"),
    ],
)
def test_declarations_that_some_tool_refuses_are_refused(variables, message):
    with pytest.raises(TextError, match=message):
        load_program(block("", variables))


def test_a_constant_must_have_a_value_and_keeps_it():
    head = "FUNCTION_BLOCK Fb VAR_OUTPUT y : LREAL; END_VAR VAR CONSTANT c : LREAL{}; END_VAR {} END_FUNCTION_BLOCK"
    assert load_program(head.format(" := 2.5E-1", "y := c;")).new("Fb").call() == {"y": 0.25}
    for value, body in (("", "y := c;"), (" := 1.0", "c := y;")):
        with pytest.raises(TextError):
            load_program(head.format(value, body))


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("i := 4; y := z[i];", "index 4 is outside 0..3"),
        ("i := -1; z[i] := a;", "index -1 is outside"),
        (
            "i := 4; IF (i < 4) AND (z[i] > a) THEN y := a; END_IF;",
            "index 4",
        ),  # both sides are evaluated
        ("i := 2147483647; i := i + 1;", "beyond DINT"),
        ("k := k - 1;", "beyond UDINT"),
        ("i := 1 / i;", "division by zero"),
        ("WHILE NOT flag DO y := a; END_WHILE;", "no end"),
    ],
)
def test_what_a_plc_would_stop_at_stops_the_run(body, message):
    with pytest.raises(ProgramError, match=message):
        run(body, a=1.0, b=1.0)


def test_an_array_may_begin_anywhere():
    declared = "d : ARRAY[-1..1] OF DINT := [5, 6, -7];"
    assert (
        run(
            "i := -1; IF d[i] = 5 THEN IF d[1] = -7 THEN y := a; END_IF; END_IF;",
            declared,
            a=4.0,
            b=1.0,
        )
        == 4.0
    )


SCL = (
    'FUNCTION_BLOCK "Fb" VERSION : 0.1 VAR_OUTPUT y : LREAL; END_VAR VAR b : {0}; END_VAR '
    "BEGIN {1} END_FUNCTION_BLOCK\n"
)


def test_siemens_scl_marks_variables_and_blocks():
    first = SCL.format("LREAL", "#y := #b;")
    second = SCL.format('"Fb"', "#b(); #y := #b.y;").replace('K "Fb"', 'K "Other"')
    assert load_program(first + second).new("Other").call() == {"y": 0.0}
    for wrong in ("y := #b;", "#y := b;", '"y" := #b;', "#y := #b; #IF"):
        with pytest.raises(TextError):
            load_program(SCL.format("LREAL", wrong))
    with pytest.raises(TextError, match="SCL marks"):
        load_program(block("#y := a;"))
    with pytest.raises(TextError, match="SCL marks"):
        load_program(second.replace('b : "Fb"', "b : Fb") + first)


@pytest.mark.parametrize(
    "body",
    [
        "WHILE i < 2147483647 DO i := i + 1; END_WHILE;",
        "WHILE TRUE DO i := 3; WHILE i > 0 DO i := i - 1; END_WHILE; END_WHILE;",
    ],
)
def test_a_text_without_end_is_stopped(body):
    with pytest.raises(ProgramError, match="no end"):
        run(body, a=1.0, b=1.0)


def test_the_budget_of_rounds_begins_anew_with_each_call():
    unit = load_program(block("WHILE i < 100000 DO y := y + a; i := i + 1; END_WHILE;")).new("fb")
    for _ in range(12):
        assert unit.call(a=1.0, b=0.0)["y"] == 100000.0
