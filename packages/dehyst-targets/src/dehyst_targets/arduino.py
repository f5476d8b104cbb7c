"""Target ``arduino``: a library folder in float, with a sketch that compares the board with the model."""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any, cast

import numpy as np

from dehyst.export import Check, Signal, Subject, UnitNumbers, c
from dehyst.export import kit as export_kit
from dehyst.version import RELEASE

SHORT = 64  # samples that the check sketch carries: 640 bytes of flash
UNO_RAM, UNO_FLASH = 1500, 30000  # bytes of an ATmega328P that leave room for a sketch
AVR_FIXED = 128  # bytes of RAM of a model of plays beside 20 n: parameters and state that do not depend on n
BOARDS = {  # compiler -> flags, what it stands for
    # Linked as if it had room for anything: what is too large for an Uno may be right for a Mega, and its size is said.
    "avr-gcc": (
        (
            "-mmcu=atmega328p",
            "-Wl,--defsym=__DATA_REGION_LENGTH__=0xf000,--defsym=__TEXT_REGION_LENGTH__=0x20000",
        ),
        "ATmega328P (Uno, Nano)",
    ),
    "arm-none-eabi-gcc": (
        (
            "-mcpu=cortex-m4",
            "-mthumb",
            "-mfpu=fpv4-sp-d16",
            "-mfloat-abi=hard",
            "--specs=nosys.specs",
        ),
        "Cortex-M4F (Teensy 3.x, Nano 33 BLE)",
    ),
}
_PACKAGES = {
    "avr-gcc": "gcc-avr avr-libc",
    "arm-none-eabi-gcc": "gcc-arm-none-eabi libnewlib-arm-none-eabi",
}


def _files(subject: Subject) -> dict[str, str | bytes]:
    """Return the library, its two sketches, and a check that needs no board."""
    sources = c.source_files(subject)
    values = c.template_values(subject) | arduino_values(subject)
    values["sources"] = c.names_ending(sources, ".c")
    values["headers"] = c.names_ending(sources, ".h")
    companions = c.companions(subject)
    sketch = values["sketch"]
    check = f"examples/{sketch}Check"

    def text_of(template: str) -> str:
        return export_kit.render(f"arduino/{template}.j2", **values)

    return {
        **sources,
        "library.properties": text_of("library.properties"),
        "keywords.txt": text_of("keywords.txt"),
        f"examples/{sketch}/{sketch}.ino": text_of("loop.ino"),
        f"{check}/{sketch}Check.ino": text_of("check.ino"),
        f"{check}/samples.h": text_of("samples.h"),
        "check/check.c": companions["check/check.c"],
        "check/expected.h": companions["check/expected.h"],
        # A stand-in for the board's own header lets a compiler of this computer run the sketches.
        "check/stand_in/Arduino.h": export_kit.plain_template("arduino/Arduino.h"),
        "check/stand_in/sketch.cpp": export_kit.plain_template("arduino/sketch.cpp"),
        "Makefile": text_of("Makefile"),
        "README.md": c.with_warning(text_of("README.md"), subject),
    }


def arduino_values(subject: Subject) -> dict[str, Any]:
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
    middle = 0.5 * (block.input_low + block.input_high)
    half = 0.5 * (block.input_high - block.input_low)
    # Loops that shrink from beyond the range to a thousandth of it turn every operator.
    sizes = np.geomspace(1.2, 1e-3, SHORT // 4)
    turns = np.column_stack([0.4 * sizes, sizes, -0.2 * sizes, -sizes]).ravel()[:SHORT]
    columns = [middle + half * turns]
    for value in subject.middle[1:]:
        columns.append(value * (1.0 + 0.1 * turns))
    # The board computes in float: the model must answer the same rounded numbers.
    x = np.column_stack(columns).astype(np.float32).astype(np.float64)
    x[17], x[40] = np.nan, np.inf
    on = np.ones(SHORT, dtype=np.int64)
    on[28:36] = 0
    return subject.answer(x, on)


def _verify(folder: Path, subject: Subject) -> list[Check]:
    """Compile and run library and sketches here; compile for boards whose compiler is found."""
    checks = export_kit.check_folder(folder)
    for compiler in BOARDS:
        checks.append(board_check(folder, subject, compiler))
    return checks


def board_check(folder: Path, subject: Subject, compiler: str) -> Check:
    """Compile library and sketches for a board, link the library and measure it."""
    flags, board = BOARDS[compiler]
    claim = f"compiles for {board}"
    if shutil.which(compiler) is None:
        why = f"no {compiler} on this machine; on Debian: apt-get install {_PACKAGES[compiler]}"
        return Check(claim, "skipped", why)
    with tempfile.TemporaryDirectory(prefix="dehyst-") as place:
        program = Path(place) / "unit.elf"
        main = Path(place) / "main.c"
        text = MAIN.format(name=subject.name, more=", 0" * len(subject.more))
        main.write_text(text, encoding="utf-8")
        sources = sorted(map(str, (folder / "src").glob("*.c")))
        common = [
            compiler,
            *flags,
            "-Os",
            "-ffunction-sections",
            "-fdata-sections",
            f"-I{folder / 'src'}",
        ]
        link = ["-std=gnu11", "-Wl,--gc-sections", str(main), *sources, "-o", str(program)]
        fault = _fault_of([*common, *link])
        for sketch in sorted((folder / "examples").glob("*/*.ino")):
            # A sketch is C++ that the tools of a board put behind their own header.
            stand_in = [f"-I{folder / 'check' / 'stand_in'}", "-include", "Arduino.h"]
            compile_it = ["-std=gnu++11", "-x", "c++", *stand_in, "-c", str(sketch)]
            fault = fault or _fault_of([*common, *compile_it, "-o", f"{place}/s.o"])
        if fault:
            return Check(claim, "failed", fault)
        detail = f"{_sizes(compiler, program)}; {export_kit.version_of(compiler)}"
        return Check(claim, "passed", detail)


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


def _fault_of(command: list[str]) -> str:
    """Run a compiler; return what it said if it failed, "" if it did not."""
    try:
        run = subprocess.run(
            command,
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
            env=export_kit.plain_environment(),
        )
    except (OSError, subprocess.TimeoutExpired) as fault:
        return str(fault)
    if run.returncode == 0:
        return ""
    # A linker complains of an undefined reference and does not call it an error.
    lines = [line for line in run.stderr.splitlines() if "error" in line or "undefined" in line]
    return "; ".join(lines[:3]) or f"exit status {run.returncode}"


def _sizes(compiler: str, program: Path) -> str:
    tool = compiler.replace("gcc", "size")
    run = subprocess.run(
        [tool, str(program)], capture_output=True, text=True, timeout=30, check=False
    )
    # The second line has text, data and bss: what is initialized takes flash and RAM.
    numbers = list(map(int, re.findall(r"\d+", run.stdout.partition("\n")[2])[:3]))
    if len(numbers) < 3:
        return "size not known"
    text, data, bss = numbers
    flash = text + data
    ram = data + bss
    size = f"{flash} bytes of flash, {ram} bytes of RAM"
    if compiler != "avr-gcc":
        return size
    if ram <= UNO_RAM and flash <= UNO_FLASH:
        return f"{size} of 2048: fits"
    return f"{size} of 2048: does not fit with a sketch; take a larger board (README.md)"


WRITER = export_kit.Writer(_files, _verify)
