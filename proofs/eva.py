"""Frama-C EVA: abstract interpretation of whole runs, for every input there is.

A run is any number of steps, each with any reals as inputs, NaN and the infinities among them. EVA follows intervals
that hold every value a variable can take; "0 alarms" means no undefined behaviour, no access outside of memory, no
overflow of an integer on any of these runs, and the assertions of eva/*.c are bounds that it derived.
"""

from __future__ import annotations

import re
import tempfile
from dataclasses import dataclass
from pathlib import Path

from outcome import CORE, HERE, Failed, Proof, said, tool, version
from parameters import SETS, Block, inverse

from dehyst import ModifiedPrandtlIshlinskii, MonotoneMap, PrandtlIshlinskii
from dehyst.export import Subject, subject_of
from dehyst.export.c import unit_files
from dehyst.export.core_files import CONFIG
from dehyst.models import ModelCard, SignalCard

CURE = "on Debian: apt-get install frama-c-base"
BLOCK = ("block.c", "model.c", "pi.c", "map.c")
ELEMENTS = (*BLOCK, "elements.c", "element_inverse.c", "direct.c")
JOINT = (
    *BLOCK,
    "joint.c",
    "bounds.c",
    "characteristic.c",
    "fault.c",
    "observer.c",
    "pressure.c",
    "sense.c",
    "start.c",
    "direct.c",
    "learning.c",
    "estimate.c",
    "fit.c",
)
# Functions whose conditions must be kept apart: a reading that is good in one state is used in another place.
APART = ("take_reference:300", "dehyst_sensor_fault:100", "take_pressures:100", "dehyst_joint_reset:100",
         "dehyst_bounded:20", "take_angle:100")  # fmt: skip
TUNED = ("unit_tuned:200", "dehyst_within:20")
WITHIN, COMPARED = "block.c", "return x >= low ?"
PRECISIONS: tuple[tuple[str, ...], ...] = ((), ("DEHYST_FLOAT",))
ALARMS = re.compile(r"(\d+) alarms? generated")
ASSERTIONS = re.compile(r"Assertions\s+(\d+) valid\s+(\d+) unknown\s+(\d+) invalid")


def analysed(
    harness: str, block: Block | Exported, files: tuple[str, ...], precision: int, defines: tuple[str, ...] = (),
    apart: tuple[str, ...] = (),
) -> int:  # fmt: skip
    """Run EVA on a harness with a block's parameters; return the number of assertions it proved.

    The conditions of functions that are `apart` are kept apart.

    Raises
    ------
    Failed
        If there is an alarm, or an assertion is not proved.
    """
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "parameters.h").write_text(
            '#include "dehyst.h"\n' + block.declarations(), encoding="utf-8"
        )
        macros = " ".join(f"-D{name}" for name in defines)
        includes = f"-I{folder} -I{CORE} -I{HERE} -include {HERE / 'eva' / 'accept.h'} {macros}"
        options = [
            "-eva-precision",
            str(precision),
            "-warn-special-float",
            "none",
            "-eva-split-return",
            "auto",
        ]
        apart = APART if "joint.c" in files else apart
        options += ["-eva-slevel-function", ",".join(apart)] if apart else []
        sources = [HERE / "eva" / harness, *(CORE / name for name in files if name != WITHIN)]
        sources.append(_within(Path(folder)))
        told = said(
            [tool(CURE, "frama-c"), f"-cpp-extra-args={includes}", "-eva", *options, *sources]
        )
    alarms, proved = ALARMS.search(told), ASSERTIONS.search(told)
    if not alarms or not proved:
        raise Failed(f"EVA said:\n{told[-1500:]}")
    if alarms[1] != "0" or proved[2] != "0" or proved[3] != "0":
        lines = [line for line in told.splitlines() if "alarm" in line or "assert" in line]
        raise Failed(
            f"{block.name}: {alarms[1]} alarms, assertions {proved[0]}: {'; '.join(lines[:5])}"
        )
    return int(proved[1])


def _within(folder: Path) -> Path:
    """Return block.c with dehyst_within as the analyser understands it.

    A NaN fails every comparison: ``x == x && x >= low`` is ``x >= low``; EVA draws the conclusion from the first.
    """
    text = (CORE / WITHIN).read_text(encoding="utf-8")
    if text.count(COMPARED) != 1:
        raise Failed(f"dehyst_within in {WITHIN} is another than it was: mend proofs/eva.py")
    path = folder / WITHIN
    path.write_text(text.replace(COMPARED, "return x == x && x >= low ?"), encoding="utf-8")
    return path


def block_step(quick: bool) -> tuple[str, str, str]:
    """Blocks of both directions, in both precisions, from a reset and from any state."""
    sets = SETS[3:] if quick else SETS
    runs = [
        (block, defines)
        for block in sets
        for defines in ((), ("ANY_STATE",), ("ANY_STATE", "DEHYST_FLOAT"))
    ]
    assertions = sum(analysed("block.c", block, BLOCK, 2, defines) for block, defines in runs)
    return (
        _tool(),
        f"{len(sets)} blocks, {len(runs)} runs",
        (f"0 alarms, {assertions} bounds proved: output within its range, states and share finite"),
    )


def joint_step(quick: bool) -> tuple[str, str, str]:
    """The whole joint controller with a compensator."""
    assertions = analysed("joint.c", inverse(8), JOINT, 1)
    return (
        _tool(),
        "1 controller with a compensator of 8 operators",
        (
            f"0 alarms, {assertions} bounds proved: valves within -1..1, pressures within their limits, all finite"
        ),
    )


def direct_step(quick: bool) -> tuple[str, str, str]:
    """A direct inverse and its learning on their own, and in the joint controller."""
    files = ("direct.c", "learning.c", "block.c", "model.c", "pi.c", "map.c", "bounds.c")
    assertions = sum(
        analysed("direct.c", inverse(2), files, 1, defines) for defines in ((), ("DEHYST_FLOAT",))
    )
    assertions += analysed("joint.c", inverse(2), JOINT, 1, ("DIRECT",))
    return (
        _tool(),
        "a direct inverse with all kinds of terms, 3 runs",
        (
            f"0 alarms, {assertions} bounds proved: its answer, learned scales and offset within their limits, finite"
        ),
    )


def elements_step(quick: bool) -> tuple[str, str, str]:
    """A sum of elements of every kind, forward and inverse, with maps, schedules and a dead time."""
    runs = PRECISIONS[: 1 if quick else 2]
    assertions = sum(analysed("elements.c", inverse(2), ELEMENTS, 1, defines) for defines in runs)
    return (
        _tool(),
        f"a sum of elements of every kind, {len(runs)} run{'s' if len(runs) > 1 else ''}",
        (
            f"0 alarms, {assertions} bounds proved: solutions within their range, in a bounded number of rounds"
        ),
    )


def element_block_step(quick: bool) -> tuple[str, str, str]:
    """A block of all kinds of elements: evaluated, also within a reach, and solved; any state leads to such a state."""
    files = (*ELEMENTS, "element_block.c")
    kinds = [
        ("SOLVES=0", "REACH=DEHYST_FAR"),
        ("SOLVES=0", "REACH=2"),
        ("SOLVES=1", "REACH=DEHYST_FAR"),
    ]
    runs = [(*kind, *precision) for kind in kinds for precision in PRECISIONS[: 1 if quick else 2]]
    assertions = sum(analysed("element_block.c", inverse(2), files, 1, defines) for defines in runs)
    return (
        _tool(),
        f"blocks of every kind of element, {len(runs)} runs",
        (
            f"0 alarms, {assertions} bounds proved: output within its range, memory, share and flags within theirs"
        ),
    )


def pair_step(quick: bool) -> tuple[str, str, str]:
    """Two inputs and two outputs with all kinds of elements on every path, evaluated and solved."""
    kinds = PRECISIONS[: 1 if quick else 2]
    runs = [(f"SOLVES={solves}", *defines) for solves in (0, 1) for defines in kinds]
    files = (*ELEMENTS, "pair.c")
    assertions = sum(analysed("pair.c", inverse(2), files, 1, defines) for defines in runs)
    return (
        _tool(),
        f"two inputs and two outputs with every kind of element, {len(runs)} runs",
        f"0 alarms, {assertions} bounds proved: inputs within their limits, in a bounded number of rounds",
    )


def offset_step(quick: bool) -> tuple[str, str, str]:
    """An offset that follows the last cycle: any state leads to such a state."""
    files = ("offset.c", "image.c", "block.c", "model.c", "pi.c", "map.c")
    assertions = sum(analysed("offset.c", inverse(2), files, 2, defines) for defines in PRECISIONS)
    return (
        _tool(),
        "an offset that follows the last cycle, 2 runs",
        (
            f"0 alarms, {assertions} bounds proved: offset within its limit, all finite, counts within theirs"
        ),
    )


@dataclass(frozen=True)
class Exported:
    """An export whose numbers may be changed while it runs, with the text of its sources."""

    subject: Subject

    @property
    def name(self) -> str:
        return f"tunable {self.subject.what} in {self.subject.real}"

    def declarations(self) -> str:
        """Return header and source of the unit, and the range that no page may leave."""
        block = self.subject.block
        assert block is not None  # only they are tunable
        files = {path: text for path, text in unit_files(self.subject).items() if path != CONFIG}
        include = '#include "unit.h"\n'
        limits = (("LOW", block.output_low), ("HIGH", block.output_high))
        defines = [
            f"#define OUTPUT_{end} ((dehyst_real)({value.hex()}))\n" for end, value in limits
        ]
        return "".join([files["unit.h"], files["unit.c"].replace(include, ""), *defines])


def tunable_step(quick: bool) -> tuple[str, str, str]:
    """Exports with tunable numbers, whatever another thread writes into both pages and their number at any time."""
    card = ModelCard(SignalCard("u", "bar", -1.0, 1.5), SignalCard("y", "deg", -2.0, 3.0))
    plays = PrandtlIshlinskii([0.0, 0.1, 0.4], [1.0, 0.5, 0.3], 0.2, None, 0.5, card=card)
    after, before = (
        MonotoneMap([-3.0, 0.0, 4.0], [-2.0, 0.5, 3.0]),
        MonotoneMap([-1.0, 0.3, 1.5], [-1.2, 0.0, 1.4]),
    )
    model = ModifiedPrandtlIshlinskii(plays, after, before).with_card(card)
    cases = [(model, "inverse", real) for real in ("double", "float")]
    cases = (
        cases[:1] if quick else [*cases, (model, "forward", "double"), (plays, "inverse", "double")]
    )
    assertions = 0
    for one, what, real in cases:
        unit = Exported(subject_of(one, what, name="unit", real=real, tunable=True))
        defines = ("DEHYST_FLOAT",) if real == "float" else ()
        assertions += analysed("tunable.c", unit, BLOCK, 2, defines, TUNED)
    return (
        _tool(),
        f"{len(cases)} exports, from any state, with any page",
        f"0 alarms, {assertions} bounds proved: answer within the exported range, page 0, 1 or 2, states finite",
    )


def _tool() -> str:
    return f"Frama-C {version(tool(CURE, 'frama-c'))}, EVA"


PROOFS = (
    Proof(
        "eva-block",
        "a block's step, for every input: no undefined behaviour, output within its range",
        block_step,
    ),
    Proof(
        "eva-joint",
        "the joint controller's step, for every input: no undefined behaviour, valves within -1..1",
        joint_step,
    ),
    Proof(
        "eva-direct",
        "a direct inverse that learns, for every input: no undefined behaviour, answer and learning within limits",
        direct_step,
    ),
    Proof(
        "eva-elements",
        "a sum of elements, forward and inverse, for every input: no undefined behaviour, solutions within their range",
        elements_step,
    ),
    Proof(
        "eva-element-block",
        "a block of elements, for every input and state: no undefined behaviour, output within its range",
        element_block_step,
    ),
    Proof(
        "eva-pair",
        "two inputs that act on two outputs, for every input: no undefined behaviour, inputs within their limits",
        pair_step,
    ),
    Proof(
        "eva-offset",
        "an offset that follows the last cycle, for every input and state: no undefined behaviour, within its limit",
        offset_step,
    ),
    Proof(
        "eva-tunable",
        "an export with tunable numbers, for every input, state and page: no undefined behaviour, answer within range",
        tunable_step,
    ),
)
