"""Reads a B-H log in whatever units, and tells loss, Hc, Br, Bs and permeabilities of its loops."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.data import Loops, MeasuredLoop, Recording, measure_loops
from dehyst.data import kit as data_kit
from dehyst.errors import ColumnError, RecordingError
from dehyst.findings import Finding
from dehyst.io import read_log
from dehyst.shell import command, visible
from dehyst.units import FIELD_UNITS
from dehyst_targets.columns import columns_of
from dehyst_targets.magnetics._policy import POLICY

MU_0 = 4e-7 * math.pi  # [H/m]
DIMENSIONS = {"field": "magnetic field", "density": "flux density"}
UNITS = {role: FIELD_UNITS[dimension] for role, dimension in DIMENSIONS.items()}
NAMES = {"field": frozenset({"h"}), "density": frozenset({"b"})}


@dataclass(frozen=True, eq=False)
class Core:
    """A measured core: field and flux density in SI, and what its loops say.

    Attributes
    ----------
    recording
        Input H [A/m], output B [T].
    loops
        Of `dehyst.data.measure_loops`.
    bs
        Larger polarisation at the tips of the largest loops, B - mu_0 H; a lower bound of Bs unless `saturated`. [T]
    saturated
        Whether the loop is nearly as flat as vacuum at its tips, as far as its noise can tell.
    frequency
        Of the largest loops, NaN without time. [Hz]
    findings
        Of reading and of the loop.
    """

    recording: Recording
    loops: Loops
    bs: float
    saturated: bool
    frequency: float
    findings: tuple[Finding, ...]

    @property
    def largest(self) -> MeasuredLoop:
        """The loop that models are fitted to."""
        return self.loops.largest[0]

    @cached_property
    def path(self) -> tuple[Array, Array]:
        """H and B of the largest loop as models are driven along it: of `monotone_path`."""
        return monotone_path(*self.largest.path)

    @property
    def smaller(self) -> list[MeasuredLoop]:
        """Loops that go less far than the largest one."""
        # What goes nearly as far as the largest loop is a repeat of it.
        limit = POLICY.smaller * self.largest.depth
        return [loop for loop in self.loops.loops if loop.depth < limit and loop.closes]

    @property
    def centred(self) -> bool:
        """Whether both signals swing about zero, as Hc, Br and Bs ask for."""
        middle, half = _middle(self.path[0])
        about_zero = self.loops.input_reference == self.loops.output_reference == "zero"
        return about_zero and abs(middle) <= POLICY.even * half

    @property
    def loss(self) -> float:
        """Loss of one cycle, the integral of H dB: the largest loops and all smaller ones within their time. [J/m3]"""
        return float(np.mean([self._within(loop) for loop in self.loops.largest]))

    @property
    def intervals(self) -> dict[str, data_kit.LoopEstimate]:
        """Loss, Hc and Br with their intervals of 95 %; that of the loss is that of the largest loops."""
        area = self.loops.estimates["area"]
        inner = self.loss - area.value
        loss = data_kit.LoopEstimate(self.loss, area.low + inner, area.high + inner, "J/m3")
        return {
            "loss_J_per_m3": loss,
            "Hc_A_per_m": self.loops.estimates["coercivity"],
            "Br_T": self.loops.estimates["remanence"],
        }

    @property
    def inner_loss(self) -> float:
        """What of `loss` is that of smaller loops within the largest ones. [J/m3]"""
        return max(0.0, self.loss - float(np.mean([loop.area for loop in self.loops.largest])))

    def _within(self, largest: MeasuredLoop) -> float:
        # A loop is measured less the loops inside of it, as a rainflow count takes them out.
        slack = 1e-9 * (largest.end - largest.start)
        total = 0.0
        for loop in self.loops.loops:
            starts_in = loop.start >= largest.start - slack
            if (
                loop.recording == largest.recording
                and starts_in
                and loop.end <= largest.end + slack
            ):
                # Loops of noise run either way, those of a core one way.
                total += math.copysign(loop.area, enclosed(*loop.path))
        return total

    @property
    def hc(self) -> float:
        """Half the distance of the two fields at which B passes zero. [A/m]"""
        return self.loops.estimates["coercivity"].value

    @property
    def br(self) -> float:
        """Half the distance of the two flux densities at H = 0. [T]"""
        return self.loops.estimates["remanence"].value

    def permeability(self, loop: MeasuredLoop) -> float:
        """Amplitude permeability of a loop: swing of B over mu_0 times swing of H. [-]"""
        return (loop.output_high - loop.output_low) / (MU_0 * loop.depth)

    def as_dict(self) -> dict[str, Any]:
        """Return the figures as plain values; None for what is not known."""
        power = self.loss * self.frequency
        # A loop that drifts open has no swing of its own.
        closed = [loop for loop in self.loops.loops if loop.closes] or [self.largest]
        smallest = min(closed, key=lambda loop: loop.depth)
        return {
            "loss_J_per_m3": self.loss,
            "inner_loss_J_per_m3": self.inner_loss,
            "frequency_Hz": _known(self.frequency),
            "loss_W_per_m3": _known(power),
            "centred": self.centred,
            "Hc_A_per_m": self.hc,
            "Br_T": self.br,
            "intervals_95": {key: [x.low, x.high] for key, x in self.intervals.items()},
            "Bs_T": self.bs,
            "saturated": self.saturated,
            "amplitude_permeability": self.permeability(self.largest),
            "smallest_loop_T": 0.5 * (smallest.output_high - smallest.output_low),
            "smallest_loop_permeability": self.permeability(smallest),
            "maximum_permeability": max(map(self.permeability, closed)),
            "loops": self.loops.count,
        }


def _known(value: float) -> float | None:
    if math.isfinite(value):
        return value
    return None


def monotone_path(h: Array, b: Array) -> tuple[Array, Array]:
    """Return a closed loop (T,) with its field made monotone between its two turns; one that is stays as it is.

    Both signals are smoothed alike, by parabolas over so few samples that the field hardly goes back any more.
    """
    width = 0
    smooth_h, smooth_b = h, b
    while _backward(smooth_h) > POLICY.backward and 2 * (2 * width + 1) < POLICY.widest * h.size:
        width = 2 * width + 1
        smooth_h, smooth_b = _smoothed(h, width), _smoothed(b, width)
    low, high = int(np.argmin(smooth_h)), int(np.argmax(smooth_h))
    path = np.roll(smooth_h, -low)
    top = (high - low) % h.size + 1
    path[:top] = never_falling(path[:top])
    path[top:] = -never_falling(-path[top:])
    return np.roll(path, low), smooth_b


def enclosed(h: Array, b: Array) -> float:
    """Area of a closed path, the integral of H dB: positive where it runs counter-clockwise. [J/m3]"""
    return float(0.5 * (h + np.roll(h, -1)) @ (np.roll(b, -1) - b))


def _backward(h: Array) -> float:
    """How far a closed field goes back between its two turns, share of both ways."""
    way = float(np.abs(np.diff(h, append=h[0])).sum())
    return 0.5 * way / max(float(np.ptp(h)), 1e-300) - 1.0


def _smoothed(values: Array, width: int) -> Array:
    """Middles of parabolas by least squares through 2 width + 1 samples of a closed path."""
    place = np.arange(-width, width + 1)
    weights = 3.0 * width * (width + 1) - 1.0 - 5.0 * place**2
    closed = np.pad(values, width, mode="wrap")
    return np.convolve(closed, weights / weights.sum(), mode="valid")


def never_falling(values: Array) -> Array:
    """The middle of the two bounds that never fall; values that never fall stay as they are."""
    if values.size == 0:
        return values
    upward = np.minimum.accumulate(values[::-1])[::-1]
    return np.asarray(0.5 * (np.maximum.accumulate(values) + upward))


def core_of(recording: Recording, *, symmetric: bool = False) -> Core:
    """Return the figures of a core.

    Parameters
    ----------
    recording
        Input H in `input_unit` (A/m, kA/m, A/cm, Oe), output B in `output_unit` (T, mT, G, kG), at least one cycle.
    symmetric
        As for `dehyst.data.measure_loops`.

    Raises
    ------
    ColumnError
        If the units are those of B and H exchanged, or none.
    RecordingError
        If a signal stands still, B is larger than any core's, or the loop would give energy.
    ExcitationError
        If there is no closed loop.

    Examples
    --------
    Rayleigh's loop, B = (mu + nu Hm) H -+ nu/2 (Hm^2 - H^2), has the area 4/3 nu Hm^3:

    >>> h = 10.0 * np.sin(np.linspace(0.0, 4.0 * np.pi, 4001))
    >>> way = np.sign(np.gradient(h))
    >>> b = (1e-3 + 1e-5 * 10.0) * h - way * 0.5e-5 * (100.0 - h**2)
    >>> core = core_of(Recording(h, b, input_unit="A/m", output_unit="T"))
    >>> round(core.loss / (4.0 / 3.0 * 1e-5 * 1000.0), 3), core.saturated
    (1.0, False)
    """
    record = _in_si(recording)
    # That a fit and a test need more loops is no news of one that was measured.
    findings = [finding for finding in recording.findings if finding.code != "few-loops"]
    for role, values in (("field", record.input), ("density", record.output)):
        if not float(np.ptp(values)) > 0.0:
            raise RecordingError(
                f"the {DIMENSIONS[role]} stands still, so there is no loop. Check the sensor, or name another column: "
                f"--{role} COLUMN."
            )
    most = float(np.abs(record.output).max())
    if most > POLICY.most_density:
        raise RecordingError(
            f"B reaches {most:.3g} T, and no core carries more than 2.4 T: the unit is another one, or H and B are "
            f"exchanged. Type the unit, --density-unit mT or G, or exchange --field and --density.",
            largest=most,
        )
    loops = measure_loops(record, symmetric=symmetric)
    if _falls(loops):
        findings.append(
            Finding(
                "core-reversed",
                "B falls while H rises, which no core does: H or B has the wrong sign, as behind a coil or a probe "
                "that is connected the other way round. B was taken with the other sign.",
            )
        )
        record = replace(record, output=-record.output)
        loops = measure_loops(record, symmetric=symmetric)
    if loops.largest[0].orientation == "clockwise" or _falls(loops):
        raise RecordingError(
            "H and B are not in phase as those of a core: its loop runs counter-clockwise, B behind H, for a core "
            "takes energy and gives none. This one does not, so its loss would mean nothing. Correct the delay "
            "between both channels, or the sign of one, in the log."
        )
    h, b = monotone_path(*loops.largest[0].path)
    middle_h, half_h = _middle(h)
    middle_b, half_b = _middle(b)
    if abs(middle_h) <= POLICY.even * half_h and abs(middle_b) > POLICY.offset * half_b:
        findings.append(
            Finding(
                "core-offset",
                f"B swings about {middle_b:.3g} T although H swings about zero: the integral of a voltage has no zero "
                f"of its own. {middle_b:.3g} T are taken out.",
            )
        )
        record = replace(record, output=record.output - middle_b)
        loops = measure_loops(record, symmetric=symmetric)
    # Once all domains have turned, B rises no faster than in vacuum.
    slope, least = _tip_slope(loops)
    # What noise may make of a flat tip is small against the whole loop.
    large = slope > POLICY.rising * float(np.ptp(b)) / float(np.ptp(h))
    saturated = not large and least < POLICY.saturated * MU_0
    bs = _polarisation(loops, h, b)
    core = Core(record, loops, bs, saturated, _frequency(loops, record), ())
    if not core.centred:
        findings.append(
            Finding(
                "core-biased",
                f"H swings about {middle_h:.3g} A/m and B about {middle_b:.3g} T, not about zero: Hc and Br are those "
                f"of this loop, and none of the material. For a core model log a loop about zero.",
            )
        )
    if not saturated:
        findings.append(
            Finding(
                "core-unsaturated",
                f"at its tips the loop rises {slope / MU_0:.0f} times as steeply as vacuum, so it is not saturated: Bs "
                f"is at least {bs:.3g} T, and Hc and Br grow with the amplitude. Log a larger field, or use the model "
                f"within this one.",
            )
        )
    return replace(core, findings=tuple(findings))


def _middle(values: Array) -> tuple[float, float]:
    low, high = float(values.min()), float(values.max())
    return 0.5 * (low + high), 0.5 * (high - low)


def _falls(loops: Loops) -> bool:
    """Whether B falls while H rises."""
    h, b = loops.largest[0].path
    h, b = h - h.mean(), b - b.mean()
    return float(h @ b) < POLICY.falling * float(np.linalg.norm(h) * np.linalg.norm(b))


def _tip_slope(loops: Loops) -> tuple[float, float]:
    """Rise of B over the last tenth of the field, at the steeper tip, and the low end of its interval. [H/m]"""
    slopes = []
    for end in ("high", "low"):
        # Where B lags, both branches bend upright at the tip; in their mean that cancels.
        to, back = loops.estimates[f"slope_to_{end}"], loops.estimates[f"slope_from_{end}"]
        mean = 0.5 * (to.value + back.value)
        reach = 0.25 * math.hypot(to.high - to.low, back.high - back.low)
        if math.isfinite(mean):
            slopes.append((mean, mean - reach))
    # A loop of a few samples has none near its tips.
    return max(slopes, default=(0.0, 0.0))


def _polarisation(loops: Loops, h: Array, b: Array) -> float:
    """B - mu_0 H at the tip where it is larger: what vacuum would carry is no part of the material's own flux. [T]"""
    sizes = []
    for end, field in (("high", float(h.max())), ("low", float(h.min()))):
        size = abs(loops.estimates[f"saturation_{end}"].value - MU_0 * field)
        if math.isfinite(size):
            sizes.append(size)
    return max(sizes, default=float(np.abs(b - MU_0 * h).max()))


def _frequency(loops: Loops, record: Recording) -> float:
    """Of the cycles that go as far as the largest one: from the middle of one to that of the next. [Hz]"""
    if record.time is None:
        return math.nan
    largest = loops.largest[0]
    length = largest.end - largest.start
    if largest.completed:
        return 0.5 / length
    middle, half = _middle(record.input)
    # Noise moves the turns, where a cycle begins; its steep parts, which weigh here, stay.
    weight = np.maximum(0.0, 1.0 - ((record.input - middle) / (0.5 * half)) ** 2)
    places = []
    for loop in loops.loops:
        inside = weight * ((record.time >= loop.start) & (record.time <= loop.end))
        if loop.depth > POLICY.smaller * largest.depth and inside.any():
            places.append(float(np.average(record.time, weights=inside)))
    periods = np.diff(np.sort(places))
    # Between some of them lie cycles of another size.
    periods = periods[np.abs(periods - length) < 0.2 * length]
    if periods.size:
        length = float(np.mean(periods))
    return 1.0 / length


def _in_si(recording: Recording) -> Recording:
    factors = []
    signals = (("field", "density", recording.input_name, recording.input_unit),
               ("density", "field", recording.output_name, recording.output_unit))  # fmt: skip
    for role, other, name, unit in signals:
        # Only the units can tell: a loop turned on its side is a loop, too.
        if unit in UNITS[other]:
            raise ColumnError(
                f"the column of the {DIMENSIONS[role]}, {visible(name)}, is in {unit}, a unit of the "
                f"{DIMENSIONS[other]}: H and B are exchanged. Exchange --field and --density.",
                unit=unit,
            )
        if unit not in UNITS[role]:
            raise ColumnError(
                f"the unit of the {DIMENSIONS[role]}, {visible(name)}, is not known, and loss and parameters hang on "
                f"it. Type it: --{role}-unit {next(iter(UNITS[role]))}, or another of {', '.join(UNITS[role])}.",
                unit=unit,
            )
        factors.append(UNITS[role][unit])
    return replace(
        recording,
        input=factors[0] * recording.input,
        output=factors[1] * recording.output,
        input_name="H",
        output_name="B",
        input_unit="A/m",
        output_unit="T",
    )


def read_core(
    path: str | PathLike[str],
    *,
    field: str | None = None,
    density: str | None = None,
    field_unit: str | None = None,
    density_unit: str | None = None,
    symmetric: bool = False,
    **reading: Any,
) -> Core:
    """Read a B-H log and return the figures of its core.

    Parameters
    ----------
    path
        Log file of any format that `dehyst.read_log` reads.
    field, density
        Columns of H and B; by default those with a unit of field and of flux density, or called H and B.
    field_unit, density_unit
        Where the log does not say them.
    symmetric
        As for `dehyst.data.measure_loops`.
    **reading
        `time`, `time_unit`, `run`, `start`, `stop`, `dt` and `sheet`, as for `dehyst.read_log`.

    Raises
    ------
    LogError, ColumnError
        If the file cannot be read, or does not say which column is which.
    RecordingError, ExcitationError
        As `core_of`.
    """
    typed = {"field": field, "density": density}
    columns, names = columns_of(path, typed, NAMES, reading, UNITS)
    if len(columns) < 2:
        line = command("magnet", Path(path), field="H", density="B")
        raise ColumnError(
            f"the columns of {visible(Path(path).name)} do not say which one is the field and which one the flux "
            f"density: {', '.join(map(visible, names))}. Name them, as in {line}",
            columns=names,
        )
    record = read_log(path, columns["field"], columns["density"], **reading)
    if field_unit is not None:
        record = replace(record, input_unit=field_unit)
    if density_unit is not None:
        record = replace(record, output_unit=density_unit)
    return core_of(record, symmetric=symmetric)
