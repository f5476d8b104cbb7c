"""Reads charge and open-circuit voltage of an electrode, and brings the charge to a stoichiometry."""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, Mask
from dehyst.data import turning_points
from dehyst.errors import ColumnError, ExcitationError, ParameterError, RecordingError
from dehyst.findings import Finding
from dehyst.io import read_columns
from dehyst.shell import command, visible
from dehyst.units import words
from dehyst_targets.batteries._policy import POLICY
from dehyst_targets.columns import columns_of

UNITS = {
    "charge": {"Ah": 1.0, "mAh": 1e-3, "C": 1.0 / 3600.0, "A.h": 1.0, "mA.h": 1e-3, "%": 1e-2},
    "voltage": {"V": 1.0, "mV": 1e-3},
}
NAMES = {
    "charge": frozenset(words("charge capacity soc q x sto stoichiometry")),
    "voltage": frozenset(words("voltage ocv ocp v u potential")),
}
CURRENT = frozenset(words("current i"))


@dataclass(frozen=True, eq=False)
class OcvLog:
    """Stoichiometry and voltage of an electrode in slow cycles.

    Attributes
    ----------
    x
        Stoichiometry of lithium, (T,): the voltage falls as it rises.
    voltage
        Against lithium, (T,). [V]
    turns
        Samples where x turns, with the first and the last.
    name
        Of the log.
    findings
        Of reading.
    """

    x: Array
    voltage: Array
    turns: tuple[int, ...]
    name: str
    findings: tuple[Finding, ...] = ()

    def outer(self, lithiation: bool) -> list[slice]:
        """Return the strokes over nearly the whole range in one direction."""
        strokes = []
        for first, last in zip(self.turns[:-1], self.turns[1:], strict=True):
            way = float(self.x[last] - self.x[first])
            if abs(way) >= POLICY.outer * float(np.ptp(self.x)) and (way > 0.0) is lithiation:
                strokes.append(slice(first, last + 1))
        return strokes

    @property
    def minor(self) -> Mask:
        """Samples in no stroke of the outer loop, (T,)."""
        outside = np.ones(self.x.size, dtype=np.bool_)
        for lithiation in (True, False):
            for stroke in self.outer(lithiation):
                outside[stroke] = False
        return outside


def ocv_of(
    charge: npt.ArrayLike,
    voltage: npt.ArrayLike,
    *,
    stoichiometry: tuple[float, float] = (0.0, 1.0),
    name: str = "the log",
    findings: tuple[Finding, ...] = (),
) -> OcvLog:
    """Return a log of open-circuit voltage.

    Parameters
    ----------
    charge
        Charge or stoichiometry, (T,), any unit, counted up or down: where it rises with the voltage, it counts what
        leaves the electrode.
    voltage
        (T,). [V]
    stoichiometry
        x at the delithiated and at the lithiated end.
    name
        In messages.
    findings
        Of the reading of a file.

    Raises
    ------
    ParameterError
        If the stoichiometries are none.
    RecordingError
        If a signal stands still, is no voltage of a cell, or the counter of the charge was reset.
    ExcitationError
        If the outer loop has only one branch.

    Examples
    --------
    >>> x = np.abs(np.linspace(-1.0, 1.0, 401))
    >>> ocv_of(2.5 * x, 0.4 - 0.3 * x).turns
    (0, 200, 400)
    """
    q, u = np.asarray(charge, dtype=np.float64), np.asarray(voltage, dtype=np.float64)
    low, high = stoichiometry
    if not 0.0 <= low < high <= 1.0:
        raise ParameterError(
            f"--stoichiometry {low:g} {high:g} are no stoichiometries: they lie between 0 and 1, the delithiated end "
            f"first. Type e.g. --stoichiometry 0.02 0.95."
        )
    for role, values in (("charge", q), ("voltage", u)):
        if (
            values.shape != q.shape
            or q.size < POLICY.fewest_minor
            or not np.all(np.isfinite(values))
        ):
            raise RecordingError(
                f"the {role} of {name} has {values.size} values: {POLICY.fewest_minor} or more numbers are needed, as "
                f"many of the charge as of the voltage."
            )
        if not float(np.ptp(values)) > 0.0:
            raise RecordingError(
                f"the {role} of {name} stands still. Name another column: --{role}."
            )
    if float(np.abs(u).max()) > POLICY.most_voltage:
        raise RecordingError(
            f"the voltage of {name} reaches {np.abs(u).max():.4g} V, which no cell does: it is in mV, or it is the "
            f"other column. Name it with its unit in brackets, or exchange --charge and --voltage."
        )
    # A slow cycle moves little between two samples.
    jump = float(np.abs(np.diff(q)).max()) / float(np.ptp(q))
    if jump > POLICY.reset:
        raise RecordingError(
            f"the charge of {name} jumps by {100.0 * jump:.0f} % of its range from one sample to the next: cyclers "
            f"count each half cycle from 0, or the log has a gap, and then nobody knows how the electrode went there. "
            f"Name a column of the net charge, or add the half cycles up with their signs.",
            jump=jump,
        )
    share = (q - q.min()) / np.ptp(q)
    # Lithium that enters lowers the voltage.
    if float(np.corrcoef(share, u)[0, 1]) > 0.0:
        share = 1.0 - share
    x = low + (high - low) * share
    # What a counter's noise does is no turn.
    turns = turning_points(x, POLICY.turn * float(np.ptp(x)))
    log = OcvLog(x, u, tuple(int(k) for k in turns), name, findings)
    lithiations, delithiations = len(log.outer(True)), len(log.outer(False))
    if not lithiations or not delithiations:
        raise ExcitationError(
            f"{name} has {lithiations} lithiations and {delithiations} delithiations over {100 * POLICY.outer:g} % of "
            f"the charge, and a loop needs both. Log one slow full cycle, there and back.",
            lithiations=lithiations,
            delithiations=delithiations,
        )
    return log


def read_ocv(
    path: str | PathLike[str],
    *,
    charge: str | None = None,
    voltage: str | None = None,
    stoichiometry: tuple[float, float] | None = None,
    **reading: Any,
) -> OcvLog:
    """Read a log of open-circuit voltage.

    Parameters
    ----------
    path
        Log file of any format that `dehyst.read_log` reads.
    charge, voltage
        Columns; by default by their units, then by their names.
    stoichiometry
        As for `ocv_of`; (0, 1) without it.
    **reading
        `time`, `time_unit`, `run`, `start`, `stop`, `dt` and `sheet`, as for `dehyst.read_log`.

    Raises
    ------
    LogError, ColumnError
        If the file cannot be read, or does not say which column is which.
    ParameterError, RecordingError, ExcitationError
        As `ocv_of`.
    """
    typed = {"charge": charge, "voltage": voltage}
    columns, names = columns_of(path, typed, NAMES, reading, UNITS)
    currents = [name for name in names if CURRENT & set(words(name))]
    if "charge" not in columns and currents:
        raise ColumnError(
            f"{visible(Path(path).name)} has a current, {visible(currents[0])}, and no charge, over which the branches "
            f"are drawn. The charge in Ah is the running sum of current in A times time step in s, over 3600: write it "
            f"into the log as a column, charge [Ah].",
            columns=names,
        )
    if len(columns) < 2:
        line = command("battery", Path(path), charge="Q", voltage="V")
        raise ColumnError(
            f"the columns of {visible(Path(path).name)} do not say which one is the charge and which one the voltage: "
            f"{', '.join(map(visible, names))}. Name them, as in {line}",
            columns=names,
        )
    read = read_columns(path, columns, **reading)
    for role, other in (("charge", "voltage"), ("voltage", "charge")):
        if read.units[role] in UNITS[other]:
            raise ColumnError(
                f"the column of the {role} is in {read.units[role]}, a unit of the {other}: they are exchanged. "
                f"Exchange --charge and --voltage."
            )
    # A column without a unit is taken for volts, and refused above where that cannot be.
    factor = UNITS["voltage"].get(read.units["voltage"], 1.0)
    values = factor * read.values["voltage"]
    return ocv_of(
        read.values["charge"],
        values,
        stoichiometry=stoichiometry or (0.0, 1.0),
        name=read.name,
        findings=tuple(read.findings),
    )
