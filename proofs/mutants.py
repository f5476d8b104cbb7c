"""Mutation testing: small faults are put into files, one at a time, and the tests must find them.

    python proofs/mutants.py OUT.json --files packages/dehyst/core/*.c --count 300 \\
        --build 'cmake --build build --target _native' --artefact 'build/_native*.so' \\
        --test '{python} -m pytest -x -q packages/dehyst/tests/core/test_core_pi.py'
    python proofs/mutants.py OUT.json --files packages/dehyst/src/dehyst/data/_loops.py --count 20 \\
        --test 'pytest -x -q packages/dehyst/tests/data'

Works on a copy of the files that git knows, below --work, with the built extension beside it; {python} is this Python,
so that it imports the copy. A --test that begins with the word pytest runs in a fork of this process instead, which has
imported numpy, scipy and hypothesis already: seconds less for each mutant. A mutant is one changed operator, comparison
or constant, or one statement removed; they are drawn with a seed, from every file in proportion. Outcomes: killed (the
tests failed), timeout (they took ten times longer than without it), same (the build made the same machine code: no
fault), survived. Run again, it goes on where it stopped; a survivor's "why", written into OUT.json by hand, stays.
"""

from __future__ import annotations

import argparse
import ast
import io
import json
import os
import random
import re
import shlex
import shutil
import subprocess
import sys
import sysconfig
import time
import tokenize
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
SOURCES = ("packages/dehyst/src", "packages/dehyst-robot/src", "packages/dehyst-targets/src")
SWAPS = {
    "<": ("<=", ">="), "<=": ("<", ">"), ">": (">=", "<="), ">=": (">", "<"), "==": ("!=",), "!=": ("==",),
    "+": ("-",), "-": ("+",), "*": ("/",), "/": ("*",), "%": ("*",), "//": ("*",), "**": ("*",),
    "+=": ("-=",), "-=": ("+=",), "*=": ("/=",), "/=": ("*=",), "|=": ("&=",), "&=": ("|=",),
    "++": ("--",), "--": ("++",),
    "&&": ("||",), "||": ("&&",), "and": ("or",), "or": ("and",), "!": ("",), "not": ("",), "~": ("",),
    "&": ("|",), "|": ("&",), "<<": (">>",), ">>": ("<<",), "True": ("False",), "False": ("True",),
}  # fmt: skip
NUMBER = re.compile(r"(0[xX][0-9a-fA-F]+|\d+\.?\d*(?:[eE][+-]?\d+)?)([uUlL]*)$")
C_TOKEN = re.compile(
    r"(?P<skip>/\*.*?\*/|//[^\n]*|^[ \t]*\#(?:\\\n|[^\n])*|\"(?:\\.|[^\"\\])*\"|'(?:\\.|[^'\\])*'|\s+)"
    r"|(?P<token>[A-Za-z_]\w*|(?:0[xX][0-9a-fA-F]+|\d+\.?\d*(?:[eE][+-]?\d+)?)[uUlL]*|->|\+\+|--|<<=|>>=|<<|>>|[-+*/%&|^<>=!]=|&&|\|\||.)",
    re.DOTALL | re.MULTILINE,
)
C_STATEMENT = re.compile(
    r"^[ \t]+((?:\+\+|--)?[A-Za-z_*(][\w>.\[\]*-]*(?: [-+*/|&]?= |\(|;|\+\+;|--;)[^;{}]*;)[ \t]*(?:/\*.*)?$",
    re.M,
)
C_NO_STATEMENT = re.compile(
    r"(return|break|continue|goto|case|typedef|const|static|else|if|for|while|do)\b"
)


class Mutant(NamedTuple):
    """Characters start .. end of a file become `after`."""

    file: str
    start: int
    end: int
    before: str
    after: str


def changes(token: str) -> tuple[str, ...]:
    """Return what a token can become."""
    number = NUMBER.match(token)
    if not number:
        return SWAPS.get(token, ())
    if token.lower().startswith("0x") or token.rstrip("uUlL").isdigit():
        return (
            f"{int(number[1], 0) + 1}{number[2]}",
            *(("0" + number[2],) if int(number[1], 0) == 1 else ()),
        )
    return (f"({token} * 1.5)", "0.0") if float(number[1]) else ("1.0",)


def of_c(name: str, text: str) -> Iterator[Mutant]:
    before = ""
    for found in C_TOKEN.finditer(text):
        token = found["token"]
        if token is None:
            continue
        operand = bool(re.match(r"[\w)\]]", before)) and before not in ("return", "case")
        pointer = token == "*" and (
            not operand or (re.match(r"[A-Za-z_]\w*$", before) and text[found.end()].isalpha())
        )
        if not (pointer or (token == "&" and not operand)):
            for after in changes(token):
                yield Mutant(name, found.start(), found.end(), token, after)
        before = token
    for found in C_STATEMENT.finditer(text):
        if not C_NO_STATEMENT.match(found[1]) and not re.match(r"\w+ \*?\w+( =|;)", found[1]):
            yield Mutant(name, found.start(1), found.end(1), found[1], ";")


def of_python(name: str, text: str) -> Iterator[Mutant]:
    tree, starts = ast.parse(text), [0]
    for line in text.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))

    def span(node: ast.AST) -> tuple[int, int]:
        lines = text.splitlines()
        first, last = (len(lines[row - 1].encode()[:column].decode()) for row, column in (
            (node.lineno, node.col_offset), (node.end_lineno, node.end_col_offset)))  # fmt: skip
        return starts[node.lineno - 1] + first, starts[node.end_lineno - 1] + last

    idle = []
    for node in ast.walk(tree):
        idle += [
            span(n)
            for n in (getattr(node, "annotation", None), getattr(node, "returns", None))
            if n is not None
        ]
        idle += [span(n) for n in getattr(node, "decorator_list", [])]
        if isinstance(node, ast.Raise | ast.ImportFrom | ast.Import):
            idle.append(span(node))  # the words of an error are no arithmetic
    if_checking = [
        span(n)
        for n in ast.walk(tree)
        if isinstance(n, ast.If) and "TYPE_CHECKING" in ast.unparse(n.test)
    ]
    made = []
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type in (tokenize.OP, tokenize.NUMBER, tokenize.NAME):
            at = starts[token.start[0] - 1] + token.start[1]
            made += [
                Mutant(name, at, at + len(token.string), token.string, after)
                for after in changes(token.string)
            ]
    for node in ast.walk(tree):
        stored = isinstance(node, ast.Assign) and not isinstance(
            node.targets[0], ast.Name
        )  # others end as NameError
        called = isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)
        if stored or called or isinstance(node, ast.AugAssign | ast.Raise):
            at, end = span(node)
            made.append(Mutant(name, at, end, text[at:end], "pass"))
    for mutant in made:
        inside = [s for s in (*idle, *if_checking) if s[0] <= mutant.start and mutant.end <= s[1]]
        if inside and not (mutant.after == "pass" and mutant.before.startswith("raise")):
            continue
        try:
            compile(mutated(text, mutant), name, "exec")
        except SyntaxError:
            continue
        yield mutant


def mutated(text: str, mutant: Mutant) -> str:
    return text[: mutant.start] + mutant.after + text[mutant.end :]


def draw(files: list[str], count: int, seed: int) -> list[Mutant]:
    """Return `count` mutants of these files, every file with its share of them."""
    every = []
    for name in files:
        text = (ROOT / name).read_text(encoding="utf-8")
        every += list((of_python if name.endswith(".py") else of_c)(name, text))
    if count >= len(every):
        return every
    # Equal steps through the list from a random start, then shuffled: each file gets its share to one mutant.
    chance = random.Random(seed)
    step, begin = len(every) / count, chance.random()
    chosen = [every[int((begin + k) * step)] for k in range(count)]
    chance.shuffle(chosen)
    return chosen


def copy_tree(work: Path) -> None:
    """Put what git knows below `work`, with the built extension in its place."""
    listed = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True, text=True
    ).stdout
    for name in filter(None, listed.split("\0")):
        if (ROOT / name).is_file():
            (work / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, work / name)
    where = [*map(Path, sys.path), *(ROOT / folder for folder in SOURCES)]
    for built in (p for folder in where for p in (folder / "dehyst").glob("_native*.so")):
        shutil.copy(built, work / "packages" / "dehyst" / "src" / "dehyst")
        return


def environment(work: Path) -> dict[str, str]:
    """Return one where `python -S` imports the copy first and this Python's packages behind it."""
    sources = [str(work / folder) for folder in SOURCES]
    paths = [*sources, *(p for p in sys.path[1:] if p), sysconfig.get_paths()["purelib"]]
    return os.environ | {"PYTHONPATH": os.pathsep.join(paths), "PYTHONDONTWRITEBYTECODE": "1"}


def forked(arguments: list[str], work: Path, seconds: float) -> bool | None:
    """Return whether pytest succeeded in the copy, in a fork of this process; None if it took too long."""
    import hypothesis  # noqa: F401
    import pytest
    import scipy.optimize
    import scipy.signal  # noqa: F401

    child = os.fork()
    if child == 0:
        os.setsid()
        os.chdir(work)
        sys.stdout = sys.stderr = (work / "said.txt").open("w")
        sys.dont_write_bytecode = True
        sys.meta_path = [
            finder for finder in sys.meta_path if isinstance(finder, type)
        ]  # no editable install
        sys.path[:0] = [str(work / folder) for folder in SOURCES]
        status = pytest.main([*arguments, "-p", "no:cacheprovider"])
        sys.stdout.flush()
        os._exit(int(status))
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return status == 0
        time.sleep(0.05)
    os.killpg(child, 9)
    os.waitpid(child, 0)
    return None


def ran(command: str, work: Path, seconds: float) -> bool | None:
    """Return whether a command succeeded; None if it took too long."""
    if command.startswith("pytest "):
        return forked(shlex.split(command)[1:], work, seconds)
    with subprocess.Popen(
        command.replace("{python}", f"{sys.executable} -S"), shell=True, cwd=work, env=environment(work),
        stdout=(work / "said.txt").open("wb"), stderr=subprocess.STDOUT, start_new_session=True,
    ) as child:  # fmt: skip
        try:
            return child.wait(seconds) == 0
        except subprocess.TimeoutExpired:
            os.killpg(child.pid, 9)
            return None


def tried(
    mutant: Mutant, work: Path, a: argparse.Namespace, unchanged: bytes, seconds: float
) -> str:
    path = work / mutant.file
    text = path.read_text(encoding="utf-8")
    path.write_text(mutated(text, mutant), encoding="utf-8")
    try:
        if a.build:
            if not ran(a.build, work, 600):
                return "no mutant"  # the compiler refuses it
            if a.artefact and artefact(work, a.artefact) == unchanged:
                return "same"
        good = ran(a.test, work, seconds)
        return "timeout" if good is None else "survived" if good else "killed"
    finally:
        path.write_text(text, encoding="utf-8")


def artefact(work: Path, pattern: str) -> bytes:
    return b"".join(p.read_bytes() for p in sorted(work.glob(pattern))) if pattern else b""


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("out", type=Path)
    parser.add_argument("--files", nargs="+", required=True)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seed", type=int, default=15)
    parser.add_argument("--test", required=True, help="a command that fails if the tests do")
    parser.add_argument(
        "--build", default="", help="a command that builds the copy before each test"
    )
    parser.add_argument(
        "--artefact", default="", help="what the build makes; equal bytes mean no fault"
    )
    parser.add_argument("--work", type=Path, default=ROOT / "build" / "mutants")
    a = parser.parse_args()
    work = a.work.resolve()
    copy_tree(work)
    start = time.perf_counter()
    if (a.build and not ran(a.build, work, 3600)) or not ran(a.test, work, 3600):
        sys.exit(
            f"without any mutant the build or the tests fail:\n{(work / 'said.txt').read_text()[-3000:]}"
        )
    unchanged = artefact(work, a.artefact)
    begin = time.perf_counter()
    ran(a.test, work, 3600)
    seconds = 10 * (time.perf_counter() - begin) + 5
    print(f"ready after {begin - start:.0f} s; the tests take {seconds / 10:.1f} s", flush=True)

    names = ("file", "line", "column", "before", "after")
    known = json.loads(a.out.read_text(encoding="utf-8"))["mutants"] if a.out.exists() else []
    done = {tuple(m[name] for name in names): m for m in known}
    entries = []
    for number, mutant in enumerate(draw(a.files, a.count, a.seed), 1):
        above = (ROOT / mutant.file).read_text(encoding="utf-8")[: mutant.start]
        line, column = above.count("\n") + 1, mutant.start - above.rfind("\n")
        key = (mutant.file, line, column, mutant.before, mutant.after)
        if key not in done or done[key]["outcome"] == "survived":  # more tests may kill it now
            entry = dict(zip(names, key, strict=True)) | {
                "outcome": tried(mutant, work, a, unchanged, seconds)
            }
            if entry["outcome"] == "survived" and "why" in done.get(key, {}):
                entry["why"] = done[key]["why"]
            done[key] = entry
            print(
                f"[{number}] {mutant.file}:{line}: {mutant.before} -> {mutant.after}: {entry['outcome']}",
                flush=True,
            )
            write(a, [*entries, *(m for m in done.values() if m not in entries)])
        entries.append(done[key])
    write(a, entries)
    return 1 if any(m["outcome"] == "survived" and "why" not in m for m in entries) else 0


def write(a: argparse.Namespace, entries: list[dict[str, object]]) -> None:
    totals = Counter(str(m["outcome"]) for m in entries)
    head = {
        "files": a.files,
        "seed": a.seed,
        "build": a.build,
        "test": a.test,
        "totals": dict(sorted(totals.items())),
    }
    lines = ",\n".join(json.dumps(m, ensure_ascii=False) for m in entries)
    text = json.dumps(head, indent=1)[:-2] + ',\n "mutants": [\n' + lines + "\n]}\n"
    a.out.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
