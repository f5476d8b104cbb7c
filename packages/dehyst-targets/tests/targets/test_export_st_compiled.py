"""A compiler made of parts of others (a grammar, gcc) finds the same in the text as the own checker and the core."""

import shutil
import struct

import numpy as np
import pytest

from dehyst.export import subject_of
from dehyst_targets import st as target
from dehyst_targets.iec import load_program
from dehyst_targets.st import Ports, structured_text
from dehyst_targets.st._verification import run_blocks
from st_by_grammar import Compiled
from test_export_st import random_model

pytest.importorskip(
    "tree_sitter_iec61131_3_st", reason="pip install tree-sitter tree-sitter-iec61131-3-st"
)
pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")


def compare(subject, folder):
    """Run the test signal in both; return outputs of the checker."""
    unit = target.function_block_of(subject, "Unit1")
    text, ports = structured_text(unit), Ports.of(unit)
    compiled, signal = Compiled(text, folder), subject.test
    found, flags = run_blocks(load_program(text).new("Unit1"), ports, signal)
    for k in range(signal.samples):
        row = {name: float(x) for name, x in zip(ports.inputs, signal.inputs[k], strict=True)}
        row |= {name: int(bool(signal.switch[k] & bit)) for name, bit in ports.switches.items()}
        out = compiled.call((*ports.outputs, "FlagWord"), **row, Restart=0)
        assert [struct.pack("d", out[name]) for name in ports.outputs] == [
            struct.pack("d", y) for y in found[k]
        ], k
        assert out["FlagWord"] == flags[k]
    return found


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("real", ["double", "float"])
@pytest.mark.parametrize("what", ["inverse", "forward"])
def test_blocks(tmp_path, what, real, seed):
    model = random_model(np.random.default_rng(seed), maps=real == "double")
    subject = subject_of(model, what, name="unit", real=real, range=(-1.2, 1.5), ramp=30)
    found = compare(subject, tmp_path)
    if real == "double":
        assert np.array_equal(found.view(np.uint64), subject.test.outputs.view(np.uint64))


def test_the_comparison_can_fail(tmp_path):
    subject = subject_of(
        random_model(np.random.default_rng(0)), "inverse", name="unit", range=(-1.2, 1.5)
    )
    text = structured_text(target.function_block_of(subject, "Unit1"))
    wrong = Compiled(text.replace("Present - Threshold", "Present + Threshold"), tmp_path)
    outputs = [
        wrong.call(("OutputValue",), InputValue=float(x), Enable=1, Restart=0)["OutputValue"]
        for x in subject.test.inputs[:200, 0]
    ]
    assert outputs != subject.test.outputs[:200, 0].tolist()
