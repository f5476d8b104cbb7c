"""The joint controller in Structured Text has the bits of the core, in use, under faults and when it is switched."""

import math
import struct

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import dehyst
from dehyst import _native
from dehyst.control import JointController, JointControllerParameters, JointReference
from dehyst.export import export, joint_subject, verify
from dehyst.export.iec import load
from dehyst.export.joint import compensator_numbers
from dehyst.export.joint_run import ANSWERS
from dehyst.export.st.joint import joint_block
from dehyst.export.st.pou import siemens_scl, structured_text
from dehyst.export.st.programs import Ports

MODEL = dehyst.PrandtlIshlinskii(np.linspace(0, 0.5, 6), [1, 0.2, 0.15, 0.1, 0.08, 0.05], center=0.1, offset=0.02)


def random_parameters(rng):
    return JointControllerParameters(
        pole=rng.uniform(2, 20),
        observer_pole=rng.uniform(20, 120),
        ramp=float(rng.choice([1e-4, 5e-3, 0.05])),
        angle_jump=float(rng.choice([0.0, 0.05])),
        pressure_jump=float(rng.choice([0.0, 3e4])),
        frozen_samples=int(rng.choice([0, 5, 30])),
        hold_samples=int(rng.integers(1, 40)),
        windup_gain=rng.uniform(0, 100),
    )


def random_period(rng, k):
    """Readings, reference, switches: a motion, faults of every kind, values beyond all limits."""
    q = 0.6 * math.sin(0.02 * k) + 1e-3 * rng.normal()
    p = 3e5 + 2e5 * math.sin(0.013 * k) * np.array([1.0, -1.0]) + 100 * rng.normal(size=2)
    readings = [q, *p] if rng.random() < 0.97 else rng.choice([math.nan, math.inf, 1e300, 0.0, -1e5, q], 3).tolist()
    reference = JointReference(
        q + 0.05 * rng.normal() * rng.choice([1, 1, 20]),
        rng.normal(),
        5 * rng.normal(),
        10 * rng.normal(),
        3e5 + 1e5 * rng.normal() * rng.choice([1, 30]),
        3e5 * rng.normal() * rng.choice([1, 30]),
        1e4 * rng.normal(),
    )
    return [float(x) for x in readings], JointReference(angle=math.nan) if rng.random() < 0.02 else reference


@pytest.mark.slow
@settings(max_examples=12, deadline=None)
@given(st.integers(0, 2**32 - 1), st.booleans(), st.sampled_from([structured_text, siemens_scl]))
def test_every_output_has_the_bits_of_the_core(seed, compensated, form):
    rng = np.random.default_rng(seed)
    parameters = random_parameters(rng)
    inverse = MODEL.inverse() if compensated else None
    controller = JointController(parameters, inverse)
    tables = compensator_numbers(inverse) if inverse else None
    block = joint_block("Elbow", "LREAL", parameters, tables, "")
    unit, ports = load(form(block)).new("Elbow"), Ports.of(block)
    switches, readings = 0, [0.1, 3e5, 3e5]
    for k in range(250):
        frozen = readings
        readings, reference = random_period(rng, k)
        readings = frozen if rng.random() < 0.3 else readings
        switches = int(rng.integers(0, 8)) if rng.random() < 0.05 else switches
        restart = k == 0 or rng.random() < 0.02
        if restart:
            controller.reset(*readings)
        out = controller.step(*readings, reference, switches)
        row = dict(zip(ports.inputs, [*readings, *reference.as_tuple()], strict=True))
        row |= {name: bool(switches & bit) for name, bit in ports.switches.items()}
        found = unit.call(**row, Restart=restart)
        expected = [getattr(out, name) for name in ANSWERS]
        assert [struct.pack("d", found[name]) for name in ports.outputs] == [struct.pack("d", y) for y in expected]
        assert found["FlagWord"] == out.flags


def test_the_random_run_reaches_every_flag():
    rng = np.random.default_rng(5)
    controller = JointController(JointControllerParameters(hold_samples=30, frozen_samples=30), MODEL.inverse())
    controller.reset(0.1, 3e5, 3e5)
    seen = 0
    for k in range(600):
        readings, reference = random_period(rng, k)
        seen |= controller.step(*readings, reference, 7 if k % 100 < 80 else 0).flags
        if k % 97 == 0:
            controller.reset(0.1, 3e5, 3e5)
    assert seen == 255


CONSTANTS_OF_ROOT = [
    "Zero",
    "One",
    "Two",
    "Four",
    "Half",
    "Quarter",
    "InputLimitPart",
    "SmallestRootPart",
    "ScaleUp",
    "ScaleDown",
    "RootBias",
    "LastDigit",
    "FarUp",
    "FarUpRoot",
    "FarDown",
    "FarDownRoot",
]


def _root_unit():
    """The root as it stands in the joint controller, on its own."""
    text = structured_text(joint_block("Elbow", "LREAL", JointControllerParameters(), None, ""))
    begin, end = text.index("Root := Zero;"), text.index("Psi := Root;")
    body = text[begin:end]
    large = [text[at : text.index("\n", at)] for at in (text.index("SmallestRoot :="), text.index("InputLimit :="))]
    body = "\n".join([*large, body])
    names = ["Mantissa", "Factor", "MantissaPart", "Rounded", "SmallestRoot", "InputLimit"]
    constants = {name: text.split(f"    {name} : LREAL := ")[1].partition(";")[0] for name in CONSTANTS_OF_ROOT}
    return load(
        "FUNCTION_BLOCK RootOf VAR_INPUT Radicand : LREAL; END_VAR VAR_OUTPUT Root : LREAL; END_VAR VAR "
        + " ".join(f"{name} : LREAL;" for name in names)
        + " Power : DINT; Odd : BOOL; END_VAR VAR CONSTANT "
        + " ".join(f"{name} : LREAL := {value};" for name, value in constants.items())
        + f" END_VAR {body} END_FUNCTION_BLOCK"
    ).new("RootOf")


ROOT = _root_unit()


@settings(max_examples=300)
@given(st.floats(allow_nan=True, allow_infinity=True))
@example(1.0)
@example(2.0)
@example(4.0)
@example(math.nextafter(1.0, 0.0))
@example(math.nextafter(2.0, 0.0))
@example(math.nextafter(4.0, 0.0))
@example(1e-300)
@example(math.nextafter(1e-300, 1.0))
@example(1e100)
def test_the_root_without_bit_patterns_has_the_bits_of_the_one_with_them(x):
    assert struct.pack("d", ROOT.call(Radicand=x)["Root"]) == struct.pack("d", _native.root(x))


@settings(max_examples=300)
@given(st.floats(1e-12, 1.0))
def test_the_root_of_what_a_valve_asks_for(x):
    assert struct.pack("d", ROOT.call(Radicand=x)["Root"]) == struct.pack("d", _native.root(x))


@pytest.mark.slow
@pytest.mark.parametrize("real", ["double", "float"])
def test_an_exported_controller_verifies(tmp_path, real):
    subject = joint_subject(MODEL, JointControllerParameters(), name="elbow", real=real)
    export(subject, "st", tmp_path / "out")
    checks = verify(tmp_path / "out")
    assert [check.status for check in checks] == ["passed"] * len(checks), checks
    assert "Compensating" in (tmp_path / "out" / "README.md").read_text()


def test_a_parser_of_others_reads_the_controller():
    tree_sitter = pytest.importorskip("tree_sitter", reason="pip install tree-sitter tree-sitter-iec61131-3-st")
    grammar = pytest.importorskip("tree_sitter_iec61131_3_st", reason="pip install tree-sitter-iec61131-3-st")
    text = structured_text(joint_block("Elbow", "LREAL", JointControllerParameters(), None, ""))
    parser = tree_sitter.Parser(tree_sitter.Language(grammar.language()))
    assert not parser.parse(text.encode()).root_node.has_error
    assert parser.parse(text.replace("END_IF;", "", 1).encode()).root_node.has_error
