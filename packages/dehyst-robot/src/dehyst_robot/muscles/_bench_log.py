"""A test-bench log of a muscle: contraction, pressure and force, with or without time."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import ParameterError, RecordingError
from dehyst.findings import Finding
from dehyst.models import kit as models_kit
from dehyst_robot.muscles._policy import POLICY


@dataclass(frozen=True, eq=False)
class BenchLog:
    """Samples of a test bench, in SI units.

    Attributes
    ----------
    contraction
        (T,), (l_0 - l)/l_0.
    pressure
        (T,), gauge. [Pa]
    force
        (T,), pull. [N]
    time
        (T,), increasing [s]; None: each sample is a point at rest, independent of its neighbours.
    name
        Of the log.
    findings
        Findings of its reader.

    Raises
    ------
    RecordingError
        If lengths differ, a value is not finite, or there are too few samples.

    Examples
    --------
    >>> log = BenchLog([0.0, 0.1, 0.2, 0.0, 0.1, 0.2], [2e5] * 3 + [4e5] * 3, [500, 250, 0, 1000, 600, 200])
    >>> int(log.slack.sum()), log.covers["pressure"]
    (1, (200000.0, 400000.0))
    """

    contraction: Array
    pressure: Array
    force: Array
    time: Array | None = None
    name: str = "bench log"
    findings: tuple[Finding, ...] = field(default=())

    def __post_init__(self) -> None:
        # The record is frozen for others: only here are its columns replaced by arrays of floats.
        for key in ("contraction", "pressure", "force"):
            object.__setattr__(self, key, _finite(getattr(self, key), key))
        if self.time is not None:
            object.__setattr__(self, "time", _finite(self.time, "time"))
        sizes = {self.contraction.size, self.pressure.size, self.force.size}
        if self.time is not None:
            sizes.add(self.time.size)
        if len(sizes) != 1:
            raise RecordingError(
                f"columns of {self.name} have {sorted(sizes)} samples; they must be of one log."
            )
        fewest = POLICY.fewest
        if self.force.size < fewest:
            raise RecordingError(
                f"{self.name} has {self.force.size} samples, but a fit takes {fewest} at least."
            )
        _refuse_backward(self.time, self.name)

    def __len__(self) -> int:
        return self.force.size

    @property
    def slack(self) -> npt.NDArray[np.bool_]:
        """(T,) where the muscle hangs loose: less than half a percent of the largest force."""
        return np.asarray(self.force <= POLICY.slack * float(self.force.max()))

    @property
    def covers(self) -> dict[str, tuple[float, float]]:
        """Range of contraction, pressure and force of the samples that pull."""
        pulls = ~self.slack
        ranges = {}
        for key in ("contraction", "pressure", "force"):
            values = getattr(self, key)[pulls]
            ranges[key] = (float(values.min()), float(values.max()))
        return ranges

    def at_rest(self) -> BenchLog:
        """Return the same points without time."""
        return BenchLog(self.contraction, self.pressure, self.force, None, self.name, self.findings)


def _refuse_backward(time: Array | None, name: str) -> None:
    if time is None:
        return
    back = np.flatnonzero(np.diff(time) <= 0)
    if back.size:
        raise RecordingError(
            f"time of {name} does not increase after sample {back[0]}, nor at {back.size - 1} other places: speeds "
            f"would be infinite. Cut one recording out of it (--from, --to), or take its rows as points at "
            f"rest (--at-rest).",
            index=int(back[0]),
        )


def _finite(values: npt.ArrayLike, name: str) -> Array:
    try:
        signal = models_kit.signal_array(values, name)
    except ParameterError as fault:  # of a log it is the recording that is wrong
        raise RecordingError(str(fault)) from None
    bad = np.flatnonzero(~np.isfinite(signal))
    if bad.size:
        raise RecordingError(
            f"{name} has {bad.size} samples that are not finite, the first at index {bad[0]}. Leave these rows out.",
            index=int(bad[0]),
        )
    return signal
