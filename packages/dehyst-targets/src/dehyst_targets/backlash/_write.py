"""Makes the table of a machine from lost motion, reads it back, and says what it leaves."""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import OutputError
from dehyst.files import write_atomically
from dehyst.findings import Finding
from dehyst_targets.backlash._compensation import Compensation
from dehyst_targets.backlash._lost_motion import LostMotion
from dehyst_targets.backlash._machines import desired, machine_named, read_compensation


@dataclass(frozen=True, eq=False)
class BacklashTable:
    """What a machine is to read, or why there is nothing for it.

    Attributes
    ----------
    files
        Name -> text; empty if no table is right.
    reason
        Why there are no files; None if there are.
    compensation
        As the machine reads it, in the unit of the readings; None without files.
    read_back
        Largest difference between what was meant and what the machine reads, its rounding. [unit]
    rising, falling
        Errors that are left at the points of the measurement, (n,). Without files those that were measured. [unit]
    """

    files: dict[str, str]
    reason: Finding | None
    compensation: Compensation | None
    read_back: float
    rising: Array
    falling: Array

    @property
    def lost_motion(self) -> Array:
        """Lost motion that is left, (n,). [unit]"""
        return self.falling - self.rising

    @property
    def middle(self) -> Array:
        """Mean of both directions that is left, (n,). [unit]"""
        return 0.5 * (self.rising + self.falling)


def checked_table(text: str, lost: LostMotion, machine: str, axis: str) -> BacklashTable:
    """Return what a table that is there already leaves of a measurement.

    Raises
    ------
    RecordingError
        If the machine would not read it, or not all of it.
    """
    unit = machine_named(machine, axis).table_unit(lost.unit)
    compensation = read_compensation(text, machine, axis).converted(unit, lost.unit or unit)
    return BacklashTable({}, None, compensation, 0.0, *compensation.left(lost))


def make_table(
    lost: LostMotion, machine: str, axis: str = "X", *, smoothing: float = 0.0
) -> BacklashTable:
    """Make the files of a machine, and read them back as it does.

    Parameters
    ----------
    lost
        From `lost_motion`.
    machine
        A key of `MACHINES`.
    axis
        Its letter.
    smoothing
        Marlin: way over which the correction is spread; 0 is the most accurate. [mm]

    Returns
    -------
    BacklashTable
        Without files if the lost motion is within the repeatability or negative, or the machine compensates none.

    Raises
    ------
    ParameterError
        If machine or axis are not known, or the machine does not take the unit.

    Examples
    --------
    >>> make_table(LostMotion.example(), "grblhal", "Y").files
    {'y.settings': '$161=0.040\\n'}
    """
    form = machine_named(machine, axis)
    reason = _reason_for_none(lost, machine, axis)
    unit = form.table_unit(lost.unit)
    if form.files is None or reason is not None:
        return BacklashTable({}, reason, None, 0.0, lost.rising, lost.falling)
    meant = desired(lost, form)
    files = form.files(meant, unit, axis, smoothing)
    compensation = read_compensation(files[f"{axis.lower()}{form.main}"], machine, axis)
    read_back = 0.0
    for rising in (True, False):
        difference = compensation.added(meant.nominal, rising=rising)
        difference -= meant.added(meant.nominal, rising=rising)
        read_back = max(read_back, float(np.abs(difference).max()))
    compensation = compensation.converted(unit, lost.unit or unit)
    return BacklashTable(files, None, compensation, read_back, *compensation.left(lost))


def write_table(
    lost: LostMotion,
    machine: str,
    axis: str,
    folder: str | PathLike[str],
    *,
    smoothing: float = 0.0,
) -> BacklashTable:
    """Write the files of a machine into a folder, which is made if it is not there.

    Parameters, what is returned and what is refused are those of `make_table`.

    Raises
    ------
    OutputError
        If a file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> write_table(LostMotion.example(), "marlin", "X", tempfile.mkdtemp()).files["x.gcode"]
    'G21\\nM425 X0.0398 F1 S0\\n'
    """
    table = make_table(lost, machine, axis, smoothing=smoothing)
    if table.files:
        try:
            Path(folder).mkdir(parents=True, exist_ok=True)
        except OSError as fault:
            raise OutputError(
                f"cannot make the folder '{folder}': {fault.strerror}. Name another one.",
                path=str(folder),
            ) from None
    for name, text in table.files.items():
        write_atomically(Path(folder) / name, text)
    return table


def _reason_for_none(lost: LostMotion, machine: str, axis: str) -> Finding | None:
    """Why no table is written: the machine has none, nothing is worth it, or it would double the error."""
    form = machine_named(machine, axis)
    size = f"{lost.mean:+.2g} ± {lost.mean_interval:.2g} {lost.unit}"
    if lost.is_reversed:
        return Finding(
            "backlash-sign",
            f"the lost motion is {size}, and no play makes an axis go further when it rises than when it falls. The "
            f"directions in the sheet are exchanged, the gauge counts against the axis, or a compensation was switched "
            f"on and is too large. A table of it would double the error; none is written.",
        )
    if form.files is None:
        return Finding("backlash-no-table", f"{form.install}. No table is written.")
    worth = lost.is_mean_significant
    if not form.one_number:
        worth = lost.is_significant or lost.is_pitch_significant
    if not worth:
        return Finding(
            "backlash-within",
            f"the lost motion, {size}, is within the repeatability ({lost.spread:.2g} {lost.unit} a reading): chance "
            f"alone shows so much. A table of it would add noise; none is written. More repeats would show a smaller "
            f"one.",
        )
    if not form.one_number:
        return None
    meant = desired(lost, form)
    text = form.files(meant, "mm", axis, 0.0)[f"{axis.lower()}{form.main}"]
    if 2.0 * form.read(text, axis).rising[0] > form.smallest:
        return None
    return Finding(
        "backlash-within",
        f"the lost motion of {2.0 * meant.rising[0]:.2g} {form.table_unit(lost.unit)} is below the smallest that "
        f"{form.title} takes; none is written.",
    )
