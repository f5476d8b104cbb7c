"""Frama-C WP over core/pi.c and core/play.c: memory, termination, and that a step is the definition of the plays.

The contracts lie in wp/pi.acsl and are put into a copy of the text as comments: without comments, copy and core are
the same. Real numbers stand for floating ones (-wp-model real).
"""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

from outcome import CORE, HERE, Failed, Missing, Proof, said, tool, version

CONTRACTS = HERE / "wp" / "pi.acsl"
FILES = ("play.c", "pi.c", "block.c")
REST = (
    "bounded_output",
    "dehyst_block_reset",
    "dehyst_faded",
    "switched",
    "reject",
    "dehyst_block_step",
    "dehyst_accumulate",
    "dehyst_pi_tables",
)  # fmt: skip - in these files, without contracts
CURE = "on Debian: apt-get install frama-c-base why3 cvc4 z3, then why3 config detect"
GOALS = re.compile(r"Proved goals:\s+(\d+) / (\d+)")


def contracts() -> dict[str, str]:
    """Return heading -> text of the contracts."""
    parts = re.split(r"^== (.+)$", CONTRACTS.read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]
    return {name.strip(): text.strip() for name, text in zip(parts[::2], parts[1::2], strict=True)}


def annotated(text: str, wanted: dict[str, str]) -> str:
    """Return a C text with the contracts of its functions and loops as comments, and nothing else changed."""
    inserts: list[tuple[int, str]] = []
    for heading, contract in wanted.items():
        name, _, loop = heading.partition(" loop ")
        place = re.search(rf"^(?!#)[\w ]*\b{name}\([^;{{]*\)\n{{", text, re.MULTILINE)
        if place is None:
            continue
        at = place.start()
        if loop:
            body = text.index("\n}", place.end())
            loops = [found.start() for found in re.finditer(r"\b(for|while) \(", text[:body])][0:]
            at = [start for start in loops if start > place.end()][int(loop) - 1]
        inserts.append((at, f"/*@ {contract} */\n"))
    for at, comment in sorted(inserts, reverse=True):
        text = text[:at] + comment + text[at:]
    return text


def without_comments(text: str) -> str:
    """Return a C text without its comments and spaces."""
    return re.sub(r"\s+", " ", re.sub(r"/\*.*?\*/", " ", text, flags=re.DOTALL)).strip()


def written(folder: Path) -> Path:
    """Write the annotated copy of the files, one after the other, into a folder."""
    wanted = contracts()
    texts = ['#include "dehyst.h"\n', f"/*@ {wanted.pop('file')} */\n"]
    headings = set(wanted)
    for name in FILES:
        text = (CORE / name).read_text(encoding="utf-8")
        copy = annotated(text, wanted)
        if without_comments(copy) != without_comments(text):
            raise Failed(f"the annotated copy of {name} is not the same program")
        headings -= {heading for heading, contract in wanted.items() if contract in copy}
        texts.append(copy)
    if headings:
        raise Failed(
            f"no place in {', '.join(FILES)} for the contracts of {', '.join(sorted(headings))}"
        )
    texts.append((HERE / "wp" / "theorems.c").read_text(encoding="utf-8"))
    path = folder / "annotated.c"
    path.write_text("\n".join(texts), encoding="utf-8")
    return path


def prove(seconds: int = 60) -> tuple[int, int, str]:
    """Return goals proved, goals, and everything said."""
    frama = tool(CURE, "frama-c")
    provers = [name for name in ("cvc4", "z3") if _there(name)]
    if not provers:
        raise Missing(f"no prover; {CURE}")
    said([tool(CURE, "why3"), "config", "detect"])
    with tempfile.TemporaryDirectory() as folder:
        path = written(Path(folder))
        options = [
            "-wp",
            "-wp-rte",
            "-wp-model",
            "Typed+real",
            "-wp-prover",
            ",".join(provers),
            "-wp-par",
            "2",
        ]
        options += ["-wp-timeout", str(seconds), f"-cpp-extra-args=-I{CORE}"]
        parts = (
            ["-wp-skip-fct", ",".join(REST)],
            ["-wp-prop=@lemma"],
        )  # a run of functions leaves lemmas out
        told = [said([frama, *options, *part, path]) for part in parts]
    found = [GOALS.search(part) for part in told]
    if None in found:
        raise Failed(f"WP said:\n{told[found.index(None)][-1500:]}")
    return sum(int(f[1]) for f in found if f), sum(int(f[2]) for f in found if f), "".join(told)


def _there(name: str) -> bool:
    try:
        tool(CURE, name)
    except Missing:
        return False
    return True


def run(quick: bool) -> tuple[str, str, str]:
    """Prove every goal."""
    proved, goals, told = prove()
    if proved < goals:
        open_goals = re.findall(r"Goal (\S+) : (?!Valid|trivial)", told)
        raise Failed(f"{proved} of {goals} goals proved; not {', '.join(open_goals)}")
    names = f"Frama-C {version(tool(CURE, 'frama-c'))}, WP with CVC4 {version('cvc4')}"
    return names, "10 functions, any number of operators", f"{proved} of {goals} goals proved"


PROOFS = (
    Proof(
        "wp",
        "plays move as defined, keep to their band, stay admissible; no access outside memory (reals)",
        run,
    ),
)
