"""What each machine reads: the format of its compensation, how it is written and read back, and its G-code.

Formats are those of the machines' own documentation and sources:

LinuxCNC
    INI configuration, section ``[JOINT_n]``: COMP_FILE, COMP_FILE_TYPE, at most 256 triplets, nominal rising, values in
    machine units, type 0: nominal, actual position moving up, actual position moving down; BACKLASH is not used beside
    it. ``usrmotLoadComp`` turns a triplet into nominal - actual and ends at the first line that holds no three numbers,
    so that such a file has no comments. ``compute_screw_comp`` adds the correction of the direction of motion to the
    command, straight between points and constant beyond them.
grblHAL
    Core, ``settings.h``: axis settings begin at 100, 10 a kind, backlash is kind 6: ``$160`` for X, ``$161`` for Y, ...
    in mm (rotary axes: degrees), three decimals; in builds with ENABLE_BACKLASH_COMPENSATION. ``mc_line`` inserts a
    move of this length where an axis turns. Values up to 0.0001 switch it off.
Marlin
    G-code reference, M425: X, Y, Z distance in mm, F correction from 0 to 1, S way over which it is spread;
    ``Configuration_adv.h``: BACKLASH_COMPENSATION, BACKLASH_DISTANCE_MM, BACKLASH_CORRECTION, BACKLASH_GCODE. Steps are
    added to the first move after a turn, at most as many as that move has.
Klipper
    Configuration reference: no section for it. Issues 2040 and 5702 were closed; pull request 7259 is an open draft.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from dehyst.errors import ParameterError, RecordingError
from dehyst.units import dimension
from dehyst_targets.backlash._compensation import Compensation, compensation_for
from dehyst_targets.backlash._lost_motion import LostMotion

Files = dict[str, str]  # name -> text
MOST_TRIPLETS = 256  # EMCMOT_COMP_SIZE of LinuxCNC
LINE = 254  # characters of a line that LinuxCNC reads at once, LINELEN less the end
TRIPLET_DECIMALS, SETTING_DECIMALS, M425_DECIMALS = 6, 3, 4
SMALLEST_SETTING = 0.0001  # grblHAL compensates only more than this
BACKLASH_SETTING = 160  # of the first axis of grblHAL
LINUXCNC_AXES, GRBLHAL_AXES, MARLIN_AXES = "XYZABCUVW", "XYZABCUV", "XYZ"
WITHOUT = (
    "Klipper compensates no backlash: its configuration has no section for it (pull requests 7157 and 7259, which add "
    "one, were not merged when this was written). Take the play out of the mechanics: tension the belt, preload the "
    "nut. Or try the branch of pull request 7259 at your own risk"
)


@dataclass(frozen=True)
class Dialect:
    """Words of a machine's G-code.

    Attributes
    ----------
    units
        Units that programs may have.
    preamble, ending
        First and last lines; ``{length_word}`` stands for G20 or G21.
    prefix
        Before a move in machine coordinates.
    settle
        What waits for the end of moves.
    dwell, pause
        A rest, and a stop until the user goes on.
    """

    units: tuple[str, ...]
    preamble: tuple[str, ...]
    dwell: str
    pause: str = "M0"
    prefix: str = ""
    settle: tuple[str, ...] = ()
    ending: tuple[str, ...] = ()


@dataclass(frozen=True)
class MachineFormat:
    """A machine: what it reads, and how it is told to move.

    Attributes
    ----------
    title
        Its name.
    axes
        Letters of its axes, in their order.
    dialect
        Its G-code.
    switched_off
        How compensation is switched off for a measurement.
    install
        What to do with the files; why there are none, where `files` is None.
    read
        What reads the main file back, as the machine does.
    files
        What writes the files of a compensation: it takes that, its unit, the axis and the smoothing way. None where the
        machine compensates nothing.
    main
        Ending of the main file.
    one_number
        Whether it knows one lost motion for the whole axis.
    table_units
        Units that its table may have.
    smallest
        A lost motion that is not larger switches compensation off. [unit]
    limit
        What the way in which it compensates leaves.
    """

    title: str
    axes: str
    dialect: Dialect
    switched_off: str
    install: str
    read: Callable[[str, str], Compensation]
    files: Callable[[Compensation, str, str, float], Files] | None = None
    main: str = ""
    one_number: bool = True
    table_units: tuple[str, ...] = ("mm",)
    smallest: float = 0.0
    limit: str = ""

    def table_unit(self, unit: str) -> str:
        """Return the unit in which the machine takes a table of lengths in another unit.

        Raises
        ------
        ParameterError
            If it takes no angles.
        """
        if unit in self.table_units:
            return unit
        # Readings that were made in Python may name none.
        if not unit or dimension(unit) == "length":
            return "mm"
        if "deg" not in self.table_units:
            raise ParameterError(
                f"{self.title} compensates lengths, and the readings are in {unit}. Type another --machine: "
                f"grblhal and linuxcnc compensate rotary axes too."
            )
        return "deg"


def number(value: float, decimals: int = 5) -> str:
    """Return a number without an exponent and without zeros at its end, as G-code takes it.

    Examples
    --------
    >>> number(25.0), number(-1e-9), number(0.123456789)
    ('25', '0', '0.12346')
    """
    text = f"{value:.{decimals}f}".rstrip("0").rstrip(".")
    if text == "-0":
        return "0"
    return text


def machine_named(machine: str, axis: str) -> MachineFormat:
    """Return a machine; refuse one that is not known, and an axis that it does not have."""
    if machine not in MACHINES:
        raise ParameterError(
            f"--machine {machine:.30} is not known. Type one of: {', '.join(MACHINES)}."
        )
    form = MACHINES[machine]
    if len(axis) != 1 or axis not in form.axes:
        raise ParameterError(
            f"--axis {axis:.10}: {form.title} compensates {', '.join(form.axes)}. Type one of these letters."
        )
    return form


def read_compensation(text: str, machine: str, axis: str = "X") -> Compensation:
    """Read a compensation as the machine does, by its documented format.

    Parameters
    ----------
    text
        Of the file: triplets of LinuxCNC, settings of grblHAL, G-code with M425 of Marlin.
    machine
        A key of `MACHINES`.
    axis
        Its letter.

    Returns
    -------
    Compensation
        In the unit of the file.

    Raises
    ------
    ParameterError
        If the machine is not known, has no such axis or compensates nothing.
    RecordingError
        If the machine would not read it, or not all of it.

    Examples
    --------
    >>> read_compensation("0 -0.02 0.02\\n100 -0.03 0.03\\n", "linuxcnc").rising.round(6).tolist()
    [0.02, 100.03]
    >>> read_compensation("$160=0.035", "grblhal").rising.tolist()
    [0.0175]
    """
    return machine_named(machine, axis).read(text, axis)


def desired(lost: LostMotion, form: MachineFormat) -> Compensation:
    """Return the compensation of a measurement in the unit and with the points that a machine takes."""
    ideal = compensation_for(lost, one_number=form.one_number)
    # Of more points than the machine takes some are left out, at equal distances.
    points = np.arange(ideal.nominal.size)
    if points.size > MOST_TRIPLETS:
        points = np.linspace(0, points.size - 1, MOST_TRIPLETS).round().astype(np.int64)
    chosen = Compensation(ideal.nominal[points], ideal.rising[points], ideal.falling[points])
    unit = form.table_unit(lost.unit)
    return chosen.converted(lost.unit or unit, unit)


def _linuxcnc_files(made: Compensation, unit: str, axis: str, smoothing: float) -> Files:
    lines = []
    for nominal, rising, falling in zip(made.nominal, made.rising, made.falling, strict=True):
        # Actual positions: what is added has their sign turned.
        triplet = (nominal, nominal - rising, nominal - falling)
        lines.append(" ".join(f"{value:.{TRIPLET_DECIMALS}f}" for value in triplet))
    stem = axis.lower()
    words = {"in": "inch", "deg": "degree"}.get(unit, unit)
    kind = "LINEAR"
    if dimension(unit) == "angle":
        kind = "ANGULAR"
    ini = (
        f"# [TRAJ]{kind}_UNITS must be {words}. BACKLASH is not used beside COMP_FILE.\n"
        f"# Of steppers, STEPGEN_MAXACCEL must be 1.5 to 2 times MAX_ACCELERATION.\n"
        f"[JOINT_{LINUXCNC_AXES.index(axis)}]\nCOMP_FILE = {stem}.comp\nCOMP_FILE_TYPE = 0\n"
    )
    return {f"{stem}.comp": "\n".join(lines) + "\n", f"{stem}.ini": ini}


def _read_linuxcnc(text: str, axis: str) -> Compensation:
    rows: list[list[float]] = []
    lines = text.splitlines()
    for count, line in enumerate(lines, start=1):
        # LinuxCNC reads with sscanf: what follows the third number is ignored.
        cells = line.split()[:3]
        try:
            values = [float(cell) for cell in cells]
        except ValueError:
            values = []
        if len(values) < 3 or not all(map(math.isfinite, values)) or len(line) > LINE:
            raise RecordingError(
                f"line {count}, '{line[:40]}': LinuxCNC reads three numbers a line and stops at the first other line, "
                f"so that {len(lines) - count + 1} of {len(lines)} lines would be lost. Take it out."
            )
        if rows and values[0] <= rows[-1][0]:
            raise RecordingError(
                f"line {count}: the nominal position {values[0]:g} is not above {rows[-1][0]:g} of the line before, "
                f"and LinuxCNC leaves such a triplet out. Sort the lines by their first number."
            )
        rows.append(values)
    if not 1 <= len(rows) <= MOST_TRIPLETS:
        raise RecordingError(
            f"{len(rows)} triplets, and LinuxCNC takes 1 to {MOST_TRIPLETS} a joint. Leave some out."
        )
    nominal, forward, reverse = np.array(rows).T
    return Compensation(nominal, nominal - forward, nominal - reverse)


def _grblhal_files(made: Compensation, unit: str, axis: str, smoothing: float) -> Files:
    # The setting is the whole lost motion, of which `rising` holds one half.
    setting = BACKLASH_SETTING + GRBLHAL_AXES.index(axis)
    value = f"{2.0 * made.rising[0]:.{SETTING_DECIMALS}f}"
    return {f"{axis.lower()}.settings": f"${setting}={value}\n"}


def _read_grblhal(text: str, axis: str) -> Compensation:
    wanted = BACKLASH_SETTING + GRBLHAL_AXES.index(axis)
    for line in text.split("\n"):
        match = re.fullmatch(r"\s*\$(\d+)\s*=\s*(\d+(?:\.\d*)?)\s*", line)
        if match is None and line.strip():
            raise RecordingError(
                f"'{line[:40]}' is no setting of grblHAL. A setting is a line like ${wanted}=0.035."
            )
        if match is not None and int(match[1]) == wanted:
            return _constant(float(match[2]))
    raise RecordingError(
        f"there is no line ${wanted}=..., which is the backlash of axis {axis}. Write ${wanted}=0 if it is to be off."
    )


def _marlin_files(made: Compensation, unit: str, axis: str, smoothing: float) -> Files:
    value = f"{2.0 * made.rising[0]:.{M425_DECIMALS}f}"
    # M425 takes the whole lost motion, of which `rising` holds one half.
    distances = ["0"] * len(MARLIN_AXES)
    distances[MARLIN_AXES.index(axis)] = value
    configuration = (
        "// Configuration_adv.h; distances of other axes are 0 here.\n"
        "#define BACKLASH_COMPENSATION\n"
        "#if ENABLED(BACKLASH_COMPENSATION)\n"
        f"  #define BACKLASH_DISTANCE_MM {{ {', '.join(distances)} }} // (mm)\n"
        "  #define BACKLASH_CORRECTION    1.0\n"
        f"  #define BACKLASH_SMOOTHING_MM {number(smoothing)} // (mm)\n"
        "  #define BACKLASH_GCODE\n"
        "#endif\n"
    )
    gcode = f"G21\nM425 {axis}{value} F1 S{number(smoothing)}\n"
    return {f"{axis.lower()}.gcode": gcode, f"{axis.lower()}_configuration.h": configuration}


def _read_marlin(text: str, axis: str) -> Compensation:
    distance, correction = None, 0.0
    for line in text.split("\n"):
        words = line.partition(";")[0].split()
        if words[:1] != ["M425"]:
            continue
        for word in words[1:]:
            match = re.fullmatch(r"([A-Z])(-?\d+(?:\.\d*)?)", word)
            if match is None:
                raise RecordingError(
                    f"'{word[:20]}' in '{line[:60]}' is no word of M425. Write e.g. M425 {axis}0.035 F1 S0."
                )
            if match[1] == axis:
                distance = float(match[2])
            elif match[1] == "F":
                correction = float(match[2])
    if distance is None:
        raise RecordingError(
            f"there is no M425 with a distance of {axis}. Write e.g. M425 {axis}0.035 F1 S0."
        )
    if not 0.0 <= correction <= 1.0:
        raise RecordingError(
            f"M425 F{correction:g}: F lies between 0 (none) and 1 (all). Write F1."
        )
    return _constant(correction * distance)


def _constant(backlash: float) -> Compensation:
    """A lost motion for the whole axis, half of it to either side: where the axis is homed decides the rest."""
    half = np.array([0.5 * backlash])
    return Compensation(np.zeros(1), half, -half)


def _read_klipper(text: str, axis: str) -> Compensation:
    raise ParameterError(f"there is nothing to read: {WITHOUT}")


RS274 = Dialect(
    units=("mm", "in", "deg"),
    preamble=("G90 G94 {length_word}",),
    prefix="G53 ",
    dwell="G4 P{seconds:g}",
    ending=("M2",),
)
MACHINES = MappingProxyType(
    {
        "linuxcnc": MachineFormat(
            title="LinuxCNC",
            axes=LINUXCNC_AXES,
            dialect=RS274,
            switched_off="Take COMP_FILE and BACKLASH of this joint out of the INI file before.",
            install="copy both files beside your INI file, add the lines of the second one to it, start LinuxCNC, home",
            read=_read_linuxcnc,
            files=_linuxcnc_files,
            main=".comp",
            one_number=False,
            table_units=("mm", "in", "deg"),
            limit="the moment of a turn, in which the correction is ramped with half of the joint's acceleration",
        ),
        "grblhal": MachineFormat(
            title="grblHAL",
            axes=GRBLHAL_AXES,
            dialect=RS274,
            switched_off="Set the backlash of this axis ($160 for X, $161 for Y, ...) to 0 before.",
            install="send the line and home; only firmware built with ENABLE_BACKLASH_COMPENSATION has the setting",
            read=_read_grblhal,
            files=_grblhal_files,
            main=".settings",
            limit="what a rapid move of its own, in which the lost motion is taken up, does to a cut",
            table_units=("mm", "deg"),
            smallest=SMALLEST_SETTING,
        ),
        "marlin": MachineFormat(
            title="Marlin",
            axes=MARLIN_AXES,
            dialect=Dialect(
                units=("mm", "in"),
                preamble=("M425 F0", "G90", "{length_word}"),
                settle=("M400",),
                dwell="G4 S{seconds:g}",
            ),
            switched_off="M425 F0 switches compensation off; M425 F1 switches it on again.",
            install="send the G-code, then M500; or put the lines of the second file into Configuration_adv.h. The "
            "firmware must have BACKLASH_COMPENSATION and BACKLASH_GCODE",
            read=_read_marlin,
            files=_marlin_files,
            main=".gcode",
            limit="a first move after a turn that is shorter than the lost motion, which takes up no more than its own "
            "length",
        ),
        "klipper": MachineFormat(
            title="Klipper",
            axes="XYZ",
            dialect=Dialect(
                units=("mm",),
                preamble=("G90", "{length_word}"),
                settle=("M400",),
                dwell="G4 P{milliseconds:g}",
                pause="PAUSE",
            ),
            switched_off="Home before, and set neither G92 nor SET_GCODE_OFFSET: then positions are the machine's.",
            install=WITHOUT,
            read=_read_klipper,
        ),
    }
)
