"""The proofs of `make proofs`, in small: they run, they speak about the core as it is, and they can fail."""

import ctypes
import re
import shutil
import struct
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from dehyst.export import subject_of
from export_samples import play_model
from places import ROOT

PROOFS = ROOT / "proofs"
sys.path.insert(0, str(PROOFS))

import eva  # noqa: E402 - found through the path above
import misra  # noqa: E402
import parameters  # noqa: E402
import patterns  # noqa: E402
import weakest  # noqa: E402
from outcome import CORE, Failed, Missing  # noqa: E402

WITH_C = pytest.mark.skipif(not shutil.which("gcc"), reason="gcc is not installed")
FILES = ("block.c", "model.c", "pi.c", "play.c", "map.c", "guard.c")
BLOCKS = (parameters.mapped(parameters.inverse(5)), parameters.forward(3))


def samples(count):
    """Inputs of ordinary size, and patterns of bits of any kind."""
    rng = np.random.default_rng(7)
    bits = [struct.unpack("<d", rng.bytes(8))[0] for _ in range(count // 4)]
    return [*rng.uniform(-2, 2, count - len(bits)), *bits]


@pytest.mark.slow
@WITH_C
@pytest.mark.parametrize("block", BLOCKS, ids=["inverse", "forward"])
def test_the_interpreter_of_the_c_text_has_the_bits_of_the_compiled_core(block, tmp_path):
    pytest.importorskip("pycparser", reason="pycparser is not installed")
    from solver.interpreter import Machine, Program, Struct
    from solver.numbers import Numbers

    def struct_of(table):
        return Struct(
            n=len(table[0]),
            u=[np.float64(x) for x in table[0]],
            v=[np.float64(x) for x in table[1]],
        )

    machine = Machine(Program(*FILES), Numbers())
    rows = {
        name: [np.float64(x) for x in getattr(block, name)]
        for name in ("threshold", "slope", "loading")
    }
    n = len(block.threshold)
    pi = Struct(n=n, center=np.float64(block.center), offset=np.float64(block.offset), **rows)
    ranges = {f"{name}_{end}": np.float64(getattr(block, name)[side])
              for name in ("input", "output", "reach") for side, end in enumerate(("low", "high"))}  # fmt: skip
    given = Struct(
        model=Struct(before=struct_of(block.before), hysteresis=pi, after=struct_of(block.after)),
        start=[np.float64(x) for x in block.start],
        line_slope=np.float64(block.line[0]), line_offset=np.float64(block.line[1]), fade=np.float64(block.fade),
        fingerprint=0, **ranges,
    )  # fmt: skip
    zero = np.float64(0)
    inner = Struct(z=[zero] * n, output=zero, flags=0)
    state = Struct(model=inner, share=zero, output=zero, flags=0, started=0)
    machine.call("dehyst_block_reset", given, state)
    library = compiled(block, tmp_path)
    library.reset()
    for k, x in enumerate(samples(200)):
        on = k % 50 < 35
        mine, theirs = (
            machine.call("dehyst_block_step", given, state, np.float64(x), on),
            library.step(x, on),
        )
        assert struct.pack("<d", mine) == struct.pack("<d", theirs)


def compiled(block, folder):
    text = '#include "dehyst.h"\n' + block.declarations()
    text += "static dehyst_block_state s;\nvoid reset(void){s.model.z = z; dehyst_block_reset(&block, &s);}\n"
    text += "double step(double x, int on){return dehyst_block_step(&block, &s, x, on);}\n"
    (folder / "one.c").write_text(text)
    options = ["-std=c11", "-O1", "-ffp-contract=off", "-shared", "-fPIC", f"-I{CORE}"]
    subprocess.run(
        [
            "gcc",
            *options,
            folder / "one.c",
            *(CORE / name for name in FILES),
            "-o",
            folder / "one.so",
        ],
        check=True,
    )
    library = ctypes.CDLL(str(folder / "one.so"))
    library.step.restype, library.step.argtypes = ctypes.c_double, [ctypes.c_double, ctypes.c_int]
    return library


def test_every_contract_has_its_place_and_nothing_but_comments_is_added(tmp_path):
    text = weakest.written(tmp_path).read_text()
    assert text.count("/*@") == len(weakest.contracts()) + 1
    core = "".join((CORE / name).read_text() for name in weakest.FILES)
    assert weakest.without_comments(core) in weakest.without_comments(text)


@WITH_C
@pytest.mark.parametrize("level", patterns.LEVELS, ids=["strict", "fast"])
def test_no_pattern_of_bits_leads_out_of_the_range(level, tmp_path):
    counts = patterns.counted(
        patterns.built(tmp_path, "gcc", level, parameters.inverse(14)), 100_000
    )
    assert all(count.faults == 0 and count.rejected and count.limited for count in counts)


@WITH_C
def test_the_count_of_patterns_sees_an_output_out_of_range(tmp_path):
    class Tight(parameters.Block):
        def declarations(self):
            return (
                super().declarations()
                + "#undef OUTPUT_HIGH\n#define OUTPUT_HIGH (dehyst_real)0.5\n"
            )

    block = Tight(**vars(parameters.inverse(4)))
    counts = patterns.counted(patterns.built(tmp_path, "gcc", ("-O2",), block), 10_000)
    assert all(count.faults for count in counts)


def test_every_deviation_from_misra_has_a_reason():
    """That there is no other is for the proof itself, `python proofs/run.py misra`."""
    assert len(misra.listed()) > 5 and all(entry["reason"] for entry in misra.listed().values())


@pytest.mark.parametrize(
    ("number", "fault", "message"),
    [
        ("2.10", Missing, "2.10 counts otherwise than"),
        (misra.VERSION, Failed, "rule 9.9 in pi.c: 1 places, not in"),
    ],
)
def test_deviations_are_counted_by_the_version_that_made_the_list_and_by_no_other(
    number, fault, message, monkeypatch
):
    monkeypatch.setattr(misra, "tool", lambda *_: "cppcheck")
    monkeypatch.setattr(misra, "version", lambda _: number)
    monkeypatch.setattr(misra, "said", lambda *_, **__: "pi.c:1:1:misra-c2012-9.9\n")
    with pytest.raises(fault, match=re.escape(message)):
        misra.run(True)


@pytest.mark.slow
def test_eva_derives_the_bound_of_a_small_block_and_no_tighter_one():
    block = parameters.dead_zone(4)
    tight = replace(block, name="tight", reach=(-0.1, 0.1))
    try:
        assert eva.analysed("block.c", block, eva.BLOCK, 1) == 3
    except Missing as missing:
        pytest.skip(str(missing))

    class Wrong(parameters.Block):
        def declarations(self):
            return super().declarations() + "#undef OUTPUT_HIGH\n#define OUTPUT_HIGH 1.0\n"

    with pytest.raises(Failed, match="assertions"):
        eva.analysed("block.c", Wrong(**vars(tight)), eva.BLOCK, 1)


@pytest.mark.slow
def test_eva_derives_the_range_of_a_tunable_export_whatever_its_pages_hold_and_no_tighter_one():
    unit = eva.Exported(subject_of(play_model(), name="unit", tunable=True))
    asked = ("tunable.c", unit, eva.BLOCK, 2, (), eva.TUNED)
    try:
        assert eva.analysed(*asked) == 5
    except Missing as missing:
        pytest.skip(str(missing))

    class Tight(eva.Exported):
        def declarations(self):
            return super().declarations() + "#undef OUTPUT_HIGH\n#define OUTPUT_HIGH 0.1\n"

    with pytest.raises(Failed, match="answer"):
        eva.analysed("tunable.c", Tight(unit.subject), *asked[2:])


@pytest.mark.slow
def test_eva_derives_how_far_an_element_block_moves_and_that_it_moves():
    files, evaluated = (*eva.ELEMENTS, "element_block.c"), ("SOLVES=0", "REACH=DEHYST_FAR")
    try:
        assert eva.analysed("element_block.c", BLOCKS[0], files, 1, evaluated) == 11
    except Missing as missing:
        pytest.skip(str(missing))
    with pytest.raises(Failed, match="'last'"):
        eva.analysed("element_block.c", BLOCKS[0], files, 1, (*evaluated, "LAST=0.5"))


@pytest.mark.slow
def test_the_guard_is_proved_for_every_pattern_and_a_wrong_claim_is_not():
    pytest.importorskip("bitwuzla", reason="bitwuzla is not installed")
    pytest.importorskip("pycparser", reason="pycparser is not installed")
    from bitwuzla import Kind
    from solver.claims import Bench
    from solver.proofs import guard

    assert guard(True)[2] == "proved"
    bench = Bench("double")
    x = bench.real("x")
    with pytest.raises(Failed):
        bench.prove(
            [],
            lambda machine: machine.call("dehyst_accept", x),
            lambda taken: bench.theory.term(Kind.EQUAL, taken.term, bench.at_most(x, bench.limit)),
        )


def test_a_result_of_another_core_is_told(tmp_path):
    import json

    import run as proofs

    path = tmp_path / "results.json"
    entries = [
        {"name": "wp", "core": proofs.core_checksum()},
        {"name": "guard", "core": "0", "date": "2026-01-31"},
    ]
    path.write_text(json.dumps({"proofs": entries}))
    assert "1 of 2" in proofs.stale(path) and "guard (2026-01-31)" in proofs.stale(path)
    assert "wp (" not in proofs.stale(path)
    path.write_text(json.dumps({"proofs": entries[:1]}))
    assert proofs.stale(path) == "proofs: all 1 results are of this core"
