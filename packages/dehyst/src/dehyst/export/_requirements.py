"""What an exported C unit promises, with the claims of its own check, the tests and the proofs that show it."""

from __future__ import annotations

import re
from dataclasses import dataclass

from dehyst.export._subject import Subject


@dataclass(frozen=True)
class Requirement:
    """One requirement. Lines that the check of an export prints begin with `claims`; `of` is the kind of unit."""

    key: str
    text: str
    claims: tuple[str, ...] = ()
    tests: tuple[str, ...] = ()
    proofs: tuple[str, ...] = ()
    of: str = "all"

    def claims_in(self, check: str) -> list[str]:
        """Return the claims that stand in the text of a check program."""
        printed = re.findall(r'report\("([^"]+)"', check)
        # Behind its beginning a claim says how many samples were compared.
        return [claim for claim in printed if claim.startswith(self.claims)]


REQUIREMENTS = (
    Requirement(
        "answers", "It answers what the model answers: in double to the bit, in float within its tolerance.",
        ("test signal", "the state after", "your log", "recorded run"),
        ("test_export_bits.py", "test_export_float.py", "test_export_direct_block.py", "test_export_elements.py"),
    ),
    Requirement(
        "range", "Every output lies within its range for every input, whatever its bits.",
        ("200000 random", "100000 random"),
        ("test_block_hostile.py", "test_block_limits.py", "test_element_block.py", "test_joint_hostile.py"),
        ("eva-block", "eva-direct", "eva-element-block", "eva-joint", "limits", "patterns-double", "patterns-float"),
    ),
    Requirement(
        "rejection", "A sample that is no number is rejected: the last good output is held, no state moves.",
        ("200000 random",), ("test_block_limits.py", "test_element_block.py", "test_export_direct_block.py"),
        ("guard", "rejected"), "block",
    ),
    Requirement(
        "memory at a limit", "Where the output meets its limit, memory stays that of an actuator that got the answer.",
        (), ("test_block_limits.py", "test_element_block.py"), ("wp",), "inverse",
    ),
    Requirement(
        "sensor faults", "A sensor that is no number, jumps or freezes is bridged; if it lasts, the valves close.",
        ("recorded run",), ("test_joint_faults.py",), (), "joint",
    ),
    Requirement(
        "switching", "Switching on and off makes no jump: the output fades over the ramp.",
        ("test signal", "recorded run"),
        ("test_block_switching.py", "test_element_block.py", "test_joint_bumpless.py"),
    ),
    Requirement(
        "reset", "After a reset it starts again with the same answers.", ("reset starts",), ("test_export_verify.py",)
    ),
    Requirement(
        "saved state", "A saved state goes on elsewhere; an image that is damaged or of another model is refused.",
        ("save in the middle", "a damaged image"), ("test_block_images.py", "test_state_hostile.py"), ("fuzz",),
        "saved",
    ),
    Requirement(
        "several units", "A state is plain data; units do not meet, and a copied state goes on.", ("a copied state",),
        ("test_export_c.py", "test_export_traps.py", "test_export_pair.py"),
    ),
    Requirement(
        "tunable numbers", "A page of them counts whole, from the sample that finds its number; none that cannot be.",
        ("a page of", "a page that"), ("test_export_calibration.py",), ("eva-tunable",), "tunable",
    ),
    Requirement(
        "resources", "Nothing is allocated, no library is called, loops have bounds; the rest is in manifest.json.", (),
        ("test_export_c.py", "test_export_budget.py"), ("wp",),
    ),
    Requirement(
        "defined behaviour", "No input leads to undefined behaviour.", (),
        ("test_block_hostile.py", "test_joint_hostile.py"),
        ("eva-block", "eva-direct", "eva-elements", "eva-element-block", "eva-joint", "wp", "fuzz", "analyzer"),
    ),
    Requirement(
        "language", "C99, C11 and C++17 without a warning; MISRA C 2012 with the deviations of misra.md.", (),
        ("test_export_c.py",), ("misra",),
    ),
    Requirement(
        "identity", "The sources of the core are those that were tested; every file is the one that was exported.", (),
        ("test_export_c.py", "test_export_verify.py", "test_export_signoff.py"),
    ),
)  # fmt: skip


def required(subject: Subject) -> list[Requirement]:
    """Return the requirements that this unit has."""
    kinds = {"all", subject.what}
    # Every controller can save its state, but not every block.
    if subject.joint:
        kinds |= {"joint", "saved"}
    if subject.block:
        kinds.add("block")
        if subject.block.saved:
            kinds.add("saved")
    if subject.tunable:
        kinds.add("tunable")
    return [requirement for requirement in REQUIREMENTS if requirement.of in kinds]
