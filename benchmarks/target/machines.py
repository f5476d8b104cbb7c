"""Machines on which the core runs here: how it is compiled for them and how they are started."""

from __future__ import annotations

import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
KERNEL = ROOT / "packages" / "dehyst"
HERE = Path(__file__).resolve().parent
FLAGS = ("-std=c11", "-ffp-contract=off", "-Wall", "-Wextra", "-Wconversion", "-Werror")
ARM = ("-mthumb", "-ffreestanding", "-ffunction-sections", "-fdata-sections")


@dataclass(frozen=True)
class Machine:
    """A processor: its compiler with the flags that name it, and qemu's board; without a board it is this computer."""

    name: str
    title: str
    compiler: str
    flags: tuple[str, ...] = ()
    board: str = ""

    def missing(self) -> str:
        """Name the tool that is not there, or return an empty text."""
        tools = (self.compiler, "qemu-system-arm") if self.board else (self.compiler,)
        return next((tool for tool in tools if shutil.which(tool) is None), "")


MACHINES = {
    machine.name: machine
    for machine in (
        Machine(
            "cortex-m3",
            "Cortex-M3, no FPU",
            "arm-none-eabi-gcc",
            (*ARM, "-mcpu=cortex-m3"),
            "mps2-an385",
        ),
        Machine(
            "cortex-m4f",
            "Cortex-M4F, FPU for float",
            "arm-none-eabi-gcc",
            (*ARM, "-mcpu=cortex-m4", "-mfpu=fpv4-sp-d16", "-mfloat-abi=hard"),
            "mps2-an386",
        ),
        Machine(
            "cortex-m7",
            "Cortex-M7, FPU for double",
            "arm-none-eabi-gcc",
            (*ARM, "-mcpu=cortex-m7", "-mfpu=fpv5-d16", "-mfloat-abi=hard"),
            "mps2-an500",
        ),
        Machine("x86-64", "x86-64", os.environ.get("CC", "cc")),
    )
}


def sources(machine: Machine, driver: Path, core: Path) -> list[Path]:
    """Return the files of a program: core, driver, and what stands in for an operating system."""
    beside = (
        [HERE / "bare" / "start.c", HERE / "bare" / "io.c"]
        if machine.board
        else [HERE / "host_io.c"]
    )
    return [*beside, driver, *sorted(core.glob("*.c"))]


def build(
    machine: Machine,
    folder: Path,
    real: str = "double",
    level: str = "-O2",
    driver: str = "driver.c",
    core: Path | None = None,
    defines: tuple[str, ...] = (),
) -> Path:
    """Compile a driver with the core, or with the sources of an export; return the program."""
    program = folder / f"{Path(driver).stem}.elf"
    place = core or KERNEL / "core"
    command = [machine.compiler, *FLAGS, level, *machine.flags, f"-I{place}", f"-I{HERE}", *defines]
    command += ["-DDEHYST_FLOAT"] if real == "float" and core is None else []
    command += [str(path) for path in sources(machine, HERE / driver, place)]
    if machine.board:
        command += [
            "-nostartfiles",
            "-nostdlib",
            "-Wl,--gc-sections",
            f"-T{HERE / 'bare' / 'target.ld'}",
            "-lgcc",
        ]
    else:
        command += ["-ffunction-sections", "-fdata-sections", "-Wl,--gc-sections"]
    subprocess.run([*command, "-o", str(program)], check=True)
    return program


def start(machine: Machine, program: Path, *options: str) -> list[str]:
    """Return the command that runs a program in the folder of its job."""
    if not machine.board:
        return [str(program)]
    board = [
        "qemu-system-arm",
        "-M",
        machine.board,
        "-nographic",
        "-monitor",
        "none",
        "-serial",
        "none",
    ]
    return [
        *board,
        *options,
        "-semihosting-config",
        "enable=on,target=native",
        "-kernel",
        str(program),
    ]


def run(machine: Machine, program: Path, job: bytes, folder: Path) -> bytes:
    """Run a program on a job; return its answer."""
    (folder / "job.bin").write_bytes(job)
    (folder / "answer.bin").unlink(missing_ok=True)
    done = subprocess.run(
        start(machine, program),
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        timeout=600,
    )
    if done.returncode != 0:
        raise RuntimeError(
            f"{machine.name}: status {done.returncode}: {done.stderr or STATUS.get(done.returncode, '?')}"
        )
    return (folder / "answer.bin").read_bytes()


STATUS = {
    2: "the job is too short",
    3: "the answer cannot be written",
    4: "image too large",
    5: "too many operators",
}
STATUS |= {10 + fault: f"image of the parameters refused: {fault}" for fault in range(1, 6)} | {
    99: "processor fault"
}
