"""Target ``arduino``: a library folder in float, with a sketch that compares the board with the model."""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any, cast

import numpy as np

from dehyst.export import c, core_files
from dehyst.export.compilers import check_folder, plain_environment, version_of
from dehyst.export.numbers import UnitNumbers
from dehyst.export.rendering import TEMPLATES, render
from dehyst.export.signal import Signal
from dehyst.export.subject import Subject
from dehyst.export.targets import Check
from dehyst.version import RELEASE

SHORT = 64  # samples that the check sketch carries: 640 bytes of flash
UNO_RAM, UNO_FLASH = 1500, 30000  # bytes of an ATmega328P that leave room for a sketch
AVR_FIXED = 128  # bytes of RAM of a model of plays beside 20 n: parameters and state that do not depend on n
BOARDS = {  # compiler -> flags, what it stands for
    # Linked as if it had room for anything: what is too large for an Uno may be right for a Mega, and its size is said.
    "avr-gcc": (
        ("-mmcu=atmega328p", "-Wl,--defsym=__DATA_REGION_LENGTH__=0xf000,--defsym=__TEXT_REGION_LENGTH__=0x20000"),
        "ATmega328P (Uno, Nano)",
    ),
    "arm-none-eabi-gcc": (
        ("-mcpu=cortex-m4", "-mthumb", "-mfpu=fpv4-sp-d16", "-mfloat-abi=hard", "--specs=nosys.specs"),
        "Cortex-M4F (Teensy 3.x, Nano 33 BLE)",
    ),
}


def files(subject: Subject) -> dict[str, str | bytes]:
    """Return the library, its two sketches, and a check that needs no board."""
    core = core_files.needed(subject.numbers.functions)
    sources: dict[str, str | bytes] = {f"src/{file}": text for file, text in core.items()}
    sources |= {f"src/{file}": text for file, text in c.unit_files(subject).items()}
    values = c.template_values(subject) | template_values(subject)
    values["sources"] = sorted(file for file in sources if file.endswith(".c"))
    values["headers"] = sorted(file for file in sources if file.endswith(".h"))
    companions = c.companions(subject)
    sketch = values["sketch"]
    return {
        **sources,
        "library.properties": render("arduino/library.properties.j2", **values),
        "keywords.txt": render("arduino/keywords.txt.j2", **values),
        f"examples/{sketch}/{sketch}.ino": render("arduino/loop.ino.j2", **values),
        f"examples/{sketch}Check/{sketch}Check.ino": render("arduino/check.ino.j2", **values),
        f"examples/{sketch}Check/samples.h": render("arduino/samples.h.j2", **values),
        "check/check.c": companions["check/check.c"],
        "check/expected.h": companions["check/expected.h"],
        "check/stand_in/Arduino.h": _plain("Arduino.h"),
        "check/stand_in/sketch.cpp": _plain("sketch.cpp"),
        "Makefile": render("arduino/Makefile.j2", **values),
        "README.md": c.with_warning(render("arduino/README.md.j2", **values), subject),
    }


def _plain(name: str) -> str:
    return (TEMPLATES / "arduino" / name).read_text(encoding="utf-8")


def template_values(subject: Subject) -> dict[str, Any]:
    """Return what templates of this target are filled with, beside the values of C templates."""
    return {
        "sketch": "".join(word.capitalize() for word in subject.name.split("_")),
        "release": RELEASE,
        "short": short_signal(subject),
        "tolerance": f"{subject.tolerances[0]:.8e}f",
        "avr_ram": avr_ram(cast(UnitNumbers, subject.block)),
        "avr_fixed": AVR_FIXED,
    }


def avr_ram(block: UnitNumbers) -> int:
    """Return bytes of RAM on AVR, where constants are copied there."""
    if block.core == "block":
        return 20 * block.parts + 8 * sum(block.map_points) + AVR_FIXED
    constants, state, _ = block.bytes(4)
    return constants + state


def short_signal(subject: Subject) -> Signal:
    """Return `SHORT` samples with answers: they turn at ever smaller sizes, meet limits, are no number and switch."""
    block = cast(UnitNumbers, subject.block)
    middle, half = 0.5 * (block.input_low + block.input_high), 0.5 * (block.input_high - block.input_low)
    sizes = np.geomspace(1.2, 1e-3, SHORT // 4)
    turns = np.column_stack([0.4 * sizes, sizes, -0.2 * sizes, -sizes]).ravel()[:SHORT]
    columns = [middle + half * turns, *(value * (1.0 + 0.1 * turns) for value in subject.middle[1:])]
    x = np.column_stack(columns).astype(np.float32).astype(np.float64)
    x[17], x[40] = np.nan, np.inf
    on = np.ones(SHORT, dtype=np.int64)
    on[28:36] = 0
    return subject.answer(x, on)


def verify(folder: Path, subject: Subject) -> list[Check]:
    """Compile and run library and sketches here; compile for boards whose compiler is found."""
    return [*check_folder(folder), *(board_check(folder, subject, compiler) for compiler in BOARDS)]


def board_check(folder: Path, subject: Subject, compiler: str) -> Check:
    """Compile library and sketches for a board, link the library and measure it."""
    flags, board = BOARDS[compiler]
    claim = f"compiles for {board}"
    if shutil.which(compiler) is None:
        package = "gcc-avr avr-libc" if compiler == "avr-gcc" else "gcc-arm-none-eabi libnewlib-arm-none-eabi"
        return Check(claim, "skipped", f"no {compiler} on this machine; on Debian: apt-get install {package}")
    with tempfile.TemporaryDirectory(prefix="dehyst-") as place:
        program = Path(place) / "unit.elf"
        main = Path(place) / "main.c"
        main.write_text(MAIN.format(name=subject.name, more=", 0" * len(subject.more)), encoding="utf-8")
        sources = sorted(str(path) for path in (folder / "src").glob("*.c"))
        common = [compiler, *flags, "-Os", "-ffunction-sections", "-fdata-sections", f"-I{folder / 'src'}"]
        sketches = [str(path) for path in sorted((folder / "examples").glob("*/*.ino"))]
        fault = _failed([*common, "-std=gnu11", "-Wl,--gc-sections", str(main), *sources, "-o", str(program)])
        for sketch in sketches:
            stand_in = [f"-I{folder / 'check' / 'stand_in'}", "-include", "Arduino.h"]
            fault = fault or _failed(
                [*common, "-std=gnu++11", "-x", "c++", *stand_in, "-c", sketch, "-o", f"{place}/s.o"]
            )
        if fault:
            return Check(claim, "failed", fault)
        return Check(claim, "passed", f"{_sizes(compiler, program)}; {version_of(compiler)}")


# The smallest program that holds a unit.
MAIN = """#include "{name}.h"
static {name}_state unit;
int main(void)
{{
    static volatile float x, y;
    {name}_reset(&unit);
    for (;;) y = {name}_step(&unit, x{more}, 1);
}}
"""


def _failed(command: list[str]) -> str:
    """Run a compiler; return what it said if it failed."""
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=120, check=False, env=plain_environment()
        )
    except (OSError, subprocess.TimeoutExpired) as fault:
        return str(fault)
    words = [line for line in done.stderr.splitlines() if "error" in line or "undefined" in line]
    return "" if done.returncode == 0 else "; ".join(words[:3]) or f"exit status {done.returncode}"


def _sizes(compiler: str, program: Path) -> str:
    tool = compiler.replace("gcc", "size")
    done = subprocess.run([tool, str(program)], capture_output=True, text=True, timeout=30, check=False)
    numbers = [int(word) for word in re.findall(r"\d+", done.stdout.partition("\n")[2])[:3]]
    if len(numbers) < 3:
        return "size not known"
    text, data, bss = numbers
    flash, ram = text + data, data + bss
    room = ""
    if compiler == "avr-gcc":
        fits = ram <= UNO_RAM and flash <= UNO_FLASH
        room = f" of 2048: {'fits' if fits else 'does not fit with a sketch; take a larger board (README.md)'}"
    return f"{flash} bytes of flash, {ram} bytes of RAM{room}"
