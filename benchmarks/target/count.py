"""Instructions of single steps: qemu traces one instruction at a time, or callgrind dumps its counters at every call.

What is counted is all that happens below a step's function, its first and its last instruction included; the call is
its caller's. Of a Cortex-M a skipped instruction of a conditional block counts, as it takes a cycle too.
"""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import IO

from target.machines import Machine, start

CALLER = "steps"  # the function of a driver that calls the step, and nothing else does


def symbols(machine: Machine, program: Path) -> dict[str, tuple[int, int]]:
    """Return address and size of every function."""
    tool = machine.compiler.replace("gcc", "nm") if machine.board else "nm"
    listed = subprocess.run(
        [tool, "-S", str(program)], capture_output=True, text=True, check=True
    ).stdout
    rows = re.findall(r"(?m)^([0-9a-f]+) ([0-9a-f]+) [tTwW] (\S+)$", listed)
    return {name: (int(address, 16) & ~1, int(size, 16)) for address, size, name in rows}


def traced(lines: IO[str], caller: tuple[int, int], function: int) -> Iterator[int]:
    """Yield the number of instructions of every call of a function from a trace of program counters."""
    begin, end = caller[0], sum(caller)
    count, inside = 0, False
    for line in lines:
        pc = int(line.split("/", 2)[1], 16)  # Trace 0: host address [flags/pc/...] function
        if begin <= pc < end:
            if inside:
                yield count
            inside = False
        elif inside:
            count += 1
        elif pc == function:
            count, inside = 1, True


def count_by_trace(
    machine: Machine, program: Path, job: bytes, folder: Path, function: str
) -> list[int]:
    """Count on a microcontroller. Functions before the driver's in memory, which copy bytes, are left out."""
    (folder / "job.bin").write_bytes(job)
    found = symbols(machine, program)
    first, last = (
        min(found[CALLER][0], found[function][0]),
        max(address + size for address, size in found.values()),
    )
    trace = (
        "-singlestep",
        "-d",
        "exec,nochain",
        "-D",
        "/dev/stdout",
        "-dfilter",
        f"{first:#x}..{last:#x}",
    )
    command = start(machine, program, *trace)
    with subprocess.Popen(
        command, cwd=folder, stdout=subprocess.PIPE, text=True, bufsize=1 << 20
    ) as running:
        assert running.stdout is not None
        counts = list(traced(running.stdout, found[CALLER], found[function][0]))
    if running.returncode != 0:
        raise RuntimeError(f"{machine.name}: status {running.returncode}")
    return counts


def count_by_callgrind(program: Path, job: bytes, folder: Path, function: str) -> list[int]:
    """Count on this computer."""
    (folder / "job.bin").write_bytes(job)
    for old in folder.glob("callgrind.*"):
        old.unlink()
    tool = ["valgrind", "--tool=callgrind", "--callgrind-out-file=callgrind", "--combine-dumps=no"]
    tool += [f"--toggle-collect={function}", f"--dump-before={function}"]
    subprocess.run([*tool, str(program)], cwd=folder, capture_output=True, check=True)
    dumps = sorted(folder.glob("callgrind.*"), key=lambda path: int(path.suffix[1:]))
    dumps += [folder / "callgrind"]  # what came after the last call
    totals = [re.search(r"(?m)^totals: (\d+)", path.read_text()) for path in dumps]
    return [
        int(match[1]) for match in totals[1:] if match
    ]  # the first dump is what came before the first call


def count(machine: Machine, program: Path, job: bytes, folder: Path, function: str) -> list[int]:
    """Return the instructions of every call of a function while a program does a job."""
    if machine.board:
        return count_by_trace(machine, program, job, folder, function)
    return count_by_callgrind(program, job, folder, function)
