"""Results of the paper's experiment: logs, identifications, trials and their figures.

One object for the report, the logs on disk and ``--json`` alike; nothing in it is computed twice. SI units.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Annotated, Any, cast

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.data import Plotted
from dehyst.identification import Fit
from dehyst.models import DirectInverse, HysteresisModel
from dehyst_robot.arm import kit as arm_kit
from dehyst_robot.control import FLAGS
from dehyst_robot.control import kit as control_kit
from dehyst_robot.experiments._policy import POLICY
from dehyst_robot.fields import Key, entries

BAR = 1e5  # [Pa]
TRIALS = ("fast", "slow", "slow_no_integrator")


@dataclass(frozen=True)
class RunSettings:
    """Settings of a run that are no parameters of the robot, in the units of their keys.

    Attributes
    ----------
    load
        Constant torque on the joint during the trials, which the plant knows and the controller does not.
    initial_state
        Of the hysteresis when a trial begins: "homed"; "unknown", no homing before the trials but a random history, the
        compensator begins as if homed; "ramped", the same, and it answers with the middle of what is possible.
    identified_on
        "here", or "default": calibrated, identified and controlled as the robot without changes of single keys of the
        plant: supply, valves and payload as they were too.
    run_mean_pressure
        Of the trials, whatever it was in the identification; 0 for the same.
    time_constants_factor
        Of the creep that a compensator is offered.
    passes
        Repetitions from which an "ilc" learns; -1 for those of its recipe.
    controller
        Of the trials, see `dehyst_robot.control._reviewed`.
    conditions
        Of the packaged arm, "realistic" or "kind"; see `load_robot`.
    """

    load: Annotated[float, Key("Nm", -1000.0, 1000.0)] = 0.0
    initial_state: Annotated[str, Key(choices=("homed", "unknown", "ramped"))] = "homed"
    identified_on: Annotated[str, Key(choices=("here", "default"))] = "here"
    run_mean_pressure: Annotated[float, Key("bar", 0.0, 10.0)] = 0.0
    time_constants_factor: Annotated[float, Key("", 1e-3, 1000.0)] = 1.0
    passes: Annotated[int, Key("", -1, 1000)] = -1
    controller: Annotated[str, Key(choices=control_kit.CONTROLLERS)] = control_kit.PAPER
    conditions: Annotated[str, Key(choices=tuple(arm_kit.CONDITIONS))] = arm_kit.DEFAULT


RUN_SETTINGS: Mapping[str, Any] = MappingProxyType(
    {key: getattr(RunSettings, entry.field) for key, entry in entries(RunSettings).items()}
)  # key -> what it is if nothing is said


@dataclass(frozen=True, eq=False)
class Characteristic:
    """Static joint characteristic Q = A(q) p_m + B(q) dp + C(q), calibrated by quasi-static sweeps.

    Attributes
    ----------
    a, b, c
        Coefficients of A [Nm/Pa], B [Nm/Pa], C [Nm] in powers of q, lowest first.
    low, high
        Range of angles of the sweeps. [rad]
    residual
        RMS of Q - A p_m - B dp - C over all sweeps, most of it hysteresis. [Nm]
    sweeps
        For figures: one (T, 4) array a sweep, columns q [rad], dp [Pa], p_m [Pa], known torque Q [Nm].
    """

    a: Array
    b: Array
    c: Array
    low: float
    high: float
    residual: float
    sweeps: tuple[Array, ...] = ()

    def difference(self, angle: Array, mean: float | Array, torque: float | Array = 0.0) -> Array:
        """dp = (Q - A p_m - C)/B that holds torque Q [Nm] at `angle` and mean pressure [Pa]. [Pa]"""
        a, b, c = self._at(angle)
        return np.asarray((torque - a * mean - c) / b)

    def torque(self, angle: Array, mean: float | Array, difference: float | Array) -> Array:
        """Q = A p_m + B dp + C at `angle`, mean pressure and pressure difference [Pa]. [Nm]"""
        a, b, c = self._at(angle)
        return np.asarray(a * mean + b * difference + c)

    def slope(self, angle: Array) -> Array:
        """B, the torque of a pressure difference at `angle`. [Nm/Pa]"""
        return self._at(angle)[1]

    def stiffness(self, mean: float) -> float:
        """k = -dQ/dq at the middle of the range with both pressures equal to `mean` [Pa], at least 1. [Nm/rad]"""
        q = 0.5 * (self.low + self.high) + 0.05 * (self.high - self.low) * np.array([-1.0, 1.0])
        low, high = self.torque(q, mean, 0.0)
        return max(float((low - high) / (q[1] - q[0])), 1.0)

    def _at(self, angle: Array) -> tuple[Array, Array, Array]:
        """A, B, C, held beyond the calibrated range."""
        q = np.clip(angle, self.low, self.high)
        a, b, c = (
            np.asarray(np.polynomial.polynomial.polyval(q, k), np.float64)
            for k in (self.a, self.b, self.c)
        )
        return a, b, c


@dataclass(frozen=True, eq=False)
class JointIdentification:
    """A compensator of one joint, from a log of its motions, and its test on loops that the log does not have.

    Attributes
    ----------
    joint
        Number of the joint.
    characteristic
        The calibrated backbone.
    log
        Signals of the identification run by column name, as written to its CSV: ``time_s``, ``pressure_1_bar``,
        ``pressure_2_bar``, ``pressure_difference_bar`` (dp), ``nominal_difference_bar`` (dp_nom), ``sheared_bar``
        (x = dp - dp_nom + k q), ``angle_rad`` (q), ``mean_pressure_bar`` (p_m), ``torque_Nm`` (A p_m + B dp + C - Q,
        what the muscles gave beyond the known load Q: the hysteresis as a torque), ``sheared_torque_Nm`` (the same and
        k q with the joint's stiffness k, so that it rises with the angle).
    fit
        What `dehyst.identify` returns for the written log: the paper's model, input
        ``sheared_bar``, output ``angle_rad``; or a direct inverse, input ``sheared_torque_Nm``.
    shear
        k. [bar/rad]
    unseen
        Loops not used in the fit: ``time_s``, ``angle_rad``, ``hysteresis_bar`` (dp - dp_nom) and ``inverse_bar``
        (what the compensator says it is).
    inverse_rms_ratio
        rms(hysteresis - inverse)/rms(hysteresis) over the unseen loops.
    unexplained
        The same without the means: std(hysteresis - inverse)/std(hysteresis). Of a direct inverse what its stops and
        path lags alone leave of the loops: creep and viscosity are no hysteresis.
    direct
        The direct inverse, output ``angle_rad``, input ``torque_Nm``: the fitted one less k q; None for the paper's
        model.
    modelled_bar
        What the compensator says the hysteresis is along the log, (T,); None if it was not fitted to all of it.
    """

    joint: int
    characteristic: Characteristic
    log: Mapping[str, Array]
    fit: Fit
    shear: float
    unseen: Mapping[str, Array]
    inverse_rms_ratio: float
    unexplained: float
    direct: DirectInverse | None = None
    modelled_bar: Array | None = None

    @property
    def plays(self) -> Fit | None:
        """The fit, unless it is that of a direct inverse."""
        return self.fit if self.direct is None else None

    @property
    def missed(self) -> float:
        """Largest torque that the compensator missed on the unseen loops, on which nothing touched the joint. [Nm]"""
        missed_bar = self.unseen["hysteresis_bar"] - self.unseen["inverse_bar"]
        slope = BAR * self.characteristic.slope(self.unseen["angle_rad"])
        return float(np.abs(slope * missed_bar).max())

    @property
    def accepted(self) -> bool:
        """Whether the compensator may be switched on: `acceptable` of the hysteresis, at most, is left unexplained.

        A joint without hysteresis has loops too, of creep and viscosity; a rate-independent model of them explains
        little of other loops, and what it would add at every reversal is worse than nothing.
        """
        return self.unexplained <= POLICY.acceptable

    @property
    def nonzero_weights(self) -> int:
        """Number of operators with weight."""
        return self.fit.certificate.nonzero_weights

    @property
    def model(self) -> HysteresisModel | DirectInverse:
        """What was identified, without operators of zero weight: the same output, in a tenth of the time."""
        return (self.fit.model if self.direct is None else self.direct).pruned()

    @property
    def compensator(self) -> HysteresisModel | DirectInverse:
        """What runs in the controller: the inverse of the model, or the direct inverse itself."""
        return cast(HysteresisModel | DirectInverse, self.model.compensator())


@dataclass(frozen=True, eq=False)
class TrialRun(Plotted):
    """One run of the arm along its path, homing left out.

    Attributes
    ----------
    trial
        "fast", "slow" or "slow_no_integrator".
    compensator
        "off" or the compensator's name.
    seed
        Of the sensors' noise and of the muscles' tolerances.
    time
        (T,) from the start of the path. [s]
    desired, angle
        (T, n) angles of all n joints. [rad]
    integrator
        (T, n) torque of the position loop's integrator; zero for electric joints. [Nm]
    torque_error
        (T, n) torque of the inverse dynamics along the desired motion, less that of the measured pressures by
        characteristic and compensator: what is left to the feedback; zero for electric joints. [Nm]
    pressure_difference
        (T, n) dp, desired. [Pa]
    compensation
        (T, n) the compensator's part of it. [Pa]
    pressure
        (T, n, 2) measured gauge pressures. [Pa]
    tool_desired, tool
        (T, 3) of the tool centre point in the frame of the base: x forward, y left, z up. [m]
    figure
        (T,) which figure of the path is being followed: index into `figures`.
    figures
        Names of the path's figures in order: "line", "large circle", "small circle", "rectangle".
    cycle
        (T,) number of the cycle, from 0.
    flags
        (T, n) flags of the joint controllers (see packages/dehyst/core/dehyst.h).
    contact, doubt
        (T, n) torque that a direct inverse does not explain, and what its own torque can be wrong by. [Nm]
    hysteresis, offset, scale, scales
        (T, n) what there is of the hysteresis over that of the compensator's model; torque beyond the model that is the
        same both ways [Nm]; scale of a compensator whose model does not fit, else 1; (T, n, groups) scales of the
        groups of a direct inverse, in use.
    frames
        (K, n + 1, 3) for the picture: where the joints and the tool centre point were at about 120 moments of the first
        cycle, in the same frame as `tool`. Empty for a run without the arm. [m]
    frame_time
        (K,) those moments, as in `time`. [s]
    missed
        Joint number -> largest torque that its compensator missed on loops on which nothing touched the joint. [Nm]
    """

    trial: str
    compensator: str
    seed: int
    time: Array
    desired: Array
    angle: Array
    integrator: Array
    torque_error: Array
    pressure_difference: Array
    compensation: Array
    pressure: Array
    tool_desired: Array
    tool: Array
    figure: npt.NDArray[np.int64]
    figures: tuple[str, ...]
    cycle: npt.NDArray[np.int64]
    flags: npt.NDArray[np.int64]
    contact: Array = field(default_factory=lambda: np.zeros((0, 7)))
    doubt: Array = field(default_factory=lambda: np.zeros((0, 7)))
    hysteresis: Array = field(default_factory=lambda: np.zeros((0, 7)))
    offset: Array = field(default_factory=lambda: np.zeros((0, 7)))
    scale: Array = field(default_factory=lambda: np.zeros((0, 7)))
    scales: Array = field(default_factory=lambda: np.zeros((0, 7, 0)))
    frames: Array = field(default_factory=lambda: np.zeros((0, 8, 3)))
    frame_time: Array = field(default_factory=lambda: np.zeros(0))
    missed: Mapping[int, float] = field(default_factory=dict)

    def _figure(self) -> Any:
        """Tracking error of every joint over time."""
        from dehyst.report import (  # only who draws loads matplotlib
            PageFigure,
            Panel,
            PanelLine,
            chart,
        )
        from dehyst.report import kit as report_kit

        error = np.degrees(self.error)
        lines = []
        for k in range(error.shape[1]):
            colour = report_kit.CYCLE[k % len(report_kit.CYCLE)]
            lines.append(PanelLine(self.time, error[:, k], colour, f"joint {k + 1}"))
        panel = Panel(
            "",
            chart("time [s]", "tracking error [deg]", lines, zero=True),
            "Tracking error over time.",
        )
        return PageFigure("trial", f"{self.trial}, compensator {self.compensator}", "", (panel,))

    @property
    def error(self) -> Array:
        """q_d - q, (T, n). [rad]"""
        return self.desired - self.angle

    @property
    def warnings(self) -> tuple[str, ...]:
        """What the joint controllers found out about their models while the compensators were on, a line each."""
        lines: list[str] = []
        if self.compensator == "off":
            return ()
        for j in range(self.flags.shape[1]):
            # A moment of contact is no news of the model.
            moment = POLICY.touched * self.time.size
            flag_words = (
                ("stale", self._stale, 0.0),
                ("shifted", self._shifted, 0.0),
                ("touched", self._touched, moment),
            )
            for name, text, least in flag_words:
                when = np.flatnonzero(self.flags[:, j] & FLAGS[name])
                if name == "touched" and not self._beyond_model(j):
                    continue
                if when.size > least:
                    # The first sample says since when, the last one how much by now.
                    since, words = self.time[when[0]], text(j, int(when[-1]))
                    lines.append(f"joint {j + 1}, from {since:.1f} s: {words}")
        return tuple(lines)

    def _stale(self, j: int, last: int) -> str:
        return (
            f"the compensator's model does not fit: {self.hysteresis[last, j]:.2f} of its hysteresis is there. "
            f"It is scaled by {self.scale[last, j]:.2f} to do no harm. Identify again, as warm "
            f"and at the pressure at which it runs."
        )

    def _shifted(self, j: int, last: int) -> str:
        return (
            f"{self.offset[last, j]:.1f} Nm are missing that are the same both ways, so no hysteresis: a pressure "
            f"sensor with an offset, or a weight that the controller does not know. Scales are learned without it. "
            f"Vent the muscles and read both sensors, then weigh the tool."
        )

    def _beyond_model(self, j: int) -> bool:
        """Whether more came than the model's own errors are: those that it made where nothing touched the joint."""
        return self._largest_contact(j) > POLICY.beyond_model * self.missed.get(j + 1, 0.0)

    def _largest_contact(self, j: int) -> float:
        raised = self.flags[:, j] & FLAGS["touched"] != 0
        return float(np.abs(self.contact[raised, j]).max(initial=0.0))

    def _touched(self, j: int, last: int) -> str:
        share = np.mean(self.flags[:, j] & FLAGS["touched"] != 0)
        beyond = ""
        if j + 1 in self.missed:
            beyond = (
                f" (it missed {self.missed[j + 1]:.1f} Nm at most where nothing touched the joint)"
            )
        return (
            f"up to {self._largest_contact(j):.1f} Nm came that the model does not explain{beyond}, in "
            f"{100 * share:.0f} % of the trial: a hand, a wall, a load; if nothing touched the joint, a calibration or "
            f"a hysteresis that is not as it was identified. Nothing was learned from it."
        )


@dataclass(frozen=True, eq=False)
class PlantResult:
    """Everything measured on one plant.

    Attributes
    ----------
    plant
        Name of the hysteresis mechanism.
    identifications
        Joint number -> identification of the compensator that the report is about, of the first seed.
    runs
        All trial runs of the first seed.
    figures
        Seed -> the nested dict that ``--json`` shows for a plant: ``{"joints": {J: {"identification": {...},
        "identifications": {COMPENSATOR: {...}}, "trials": {TRIAL: {COMPENSATOR: {"rms_deg", "max_deg"}}}}},
        "tool": {TRIAL: {COMPENSATOR: {"AT_mm", ...}}}}``.
    real_time_factor
        Simulated time over wall time of a trial on one core.
    identified
        Compensator -> joint number -> identification, of the first seed.
    remarks
        What joints met in the trials of all seeds, a sentence each: trials without figures, lost because a joint left
        its range or a controller failed safe; ranges left; models that did not fit.
    """

    plant: str
    identifications: Mapping[int, JointIdentification]
    runs: tuple[TrialRun, ...]
    figures: Mapping[int, Mapping[str, Any]]
    real_time_factor: float
    identified: Mapping[str, Mapping[int, JointIdentification]] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Reproduction:
    """The paper's experiment on one plant or several.

    Attributes
    ----------
    plants
        Plant name -> result.
    compensator
        Name of the compensator that the report is about: the last of `compensators`.
    settings
        Everything that was set: the parameter file's values with their changes, seeds, joints.
    studies
        Name -> small table of a study for its own section of the report ("rest", "smaller hysteresis", "double
        compensation", "high gains"): columns by name, (N,) each; a column of words is a sequence of str.
    compensators
        Names of all that were run beside "off".
    alone
        Plant name -> result of the first joint, the others locked: no figures of the tool.

    Examples
    --------
    Returned by `dehyst_robot.reproduce`, read like this:

    >>> result = Reproduction(plants={}, compensator="paper", settings={"seeds": [0]})
    >>> for name, plant in result.plants.items():
    ...     print(name, plant.figures[0]["joints"]["1"]["trials"]["slow"])
    """

    plants: Mapping[str, PlantResult]
    compensator: str
    settings: Mapping[str, Any]
    studies: Mapping[str, Mapping[str, Array | Sequence[str]]] = field(default_factory=dict)
    compensators: tuple[str, ...] = ()
    alone: Mapping[str, PlantResult] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not self.compensators:
            object.__setattr__(self, "compensators", (self.compensator,))

    @property
    def everything(self) -> Mapping[str, PlantResult]:
        """Results of `plants` and, with "alone" behind the name, of `alone`."""
        return {**self.plants, **{f"{name} alone": plant for name, plant in self.alone.items()}}
