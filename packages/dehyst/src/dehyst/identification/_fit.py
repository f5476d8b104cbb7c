"""The result of an identification: model, scores, optimality check, findings."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, Mask
from dehyst.data import Loops, Plotted, Recording
from dehyst.errors import DehystError, ParameterError
from dehyst.families import dead_band
from dehyst.families.kit import DeadBand, LinearForm
from dehyst.findings import Finding, Grade
from dehyst.identification._evidence import CREEP, LEAST, RATE, Evidence
from dehyst.identification._facts import Motion
from dehyst.identification._intervals import LEVEL, Draws, Interval, draws_of
from dehyst.identification._policy import POLICY
from dehyst.identification._residual import Residual, residual_structure
from dehyst.identification._threads import single_blas
from dehyst.models import (
    HysteresisModel,
    ModelCard,
    PrandtlIshlinskii,
    ShearedPrandtlIshlinskii,
    StaticCurve,
)
from dehyst.shell import command

# A log whose fastest strokes are less than so many times faster than its slowest ones has one speed.
SPEEDS = 1.5
WITHOUT_SIGNALS = " without signals"  # ends the name of the best row that goes with no other signal
DRAWN_SAMPLES = 500  # of half a way: what tells the dead band of a draw
ROUNDING = 5e-3  # of a dead band: it is read from samples of a motion


@dataclass(frozen=True, slots=True)
class Score:
    """How far a model is from data.

    Attributes
    ----------
    rmse
        Root of the mean squared error. [output]
    rmse_percent
        RMSE in percent of the range of the output over the whole log.
    nrmse
        RMSE over the standard deviation of the scored output: 1 is what a constant reaches.
    max
        Largest absolute error. [output]
    """

    rmse: float
    rmse_percent: float
    nrmse: float
    max: float

    def as_dict(self) -> dict[str, float]:
        """Return the four figures as printed by ``--json``."""
        return {
            "rmse": self.rmse,
            "rmse_percent": self.rmse_percent,
            "nrmse": self.nrmse,
            "max": self.max,
        }


# What is left of an output that its input does not move follows whatever does.
UNRELATED_INPUT = (
    "The output does not follow this input, so what the error follows says nothing about an actuator. Log what moves "
    "this output, and take that for the input."
)


@dataclass(frozen=True, slots=True)
class InputError:
    """How far the input that an inverse asks for is from the one that was applied, percent of the input's range.

    What it asks for is kept within the range that was applied, as an actuator would.

    Attributes
    ----------
    rms_percent
        Root of the mean square.
    bias_percent
        Mean: an offset of the log, such as warming, is no error of the loop.
    """

    rms_percent: float
    bias_percent: float

    @property
    def without_bias_percent(self) -> float:
        """Root mean square of what is not the mean."""
        return float(np.sqrt(max(self.rms_percent**2 - self.bias_percent**2, 0.0)))

    def times(self, ratio: float) -> InputError:
        """Return the same error as a share of another range."""
        return InputError(ratio * self.rms_percent, ratio * self.bias_percent)

    def as_dict(self) -> dict[str, float]:
        """Return both figures as printed by ``--json``."""
        return {"rms_percent": self.rms_percent, "bias_percent": self.bias_percent}


def codes_of(findings: Iterable[Finding]) -> set[str]:
    """Return the codes of findings, each once."""
    return {finding.code for finding in findings}


UNKNOWN = InputError(float("nan"), float("nan"))


@dataclass(frozen=True, slots=True)
class Certificate:
    """What proves, or limits, the trust in a fit.

    Attributes
    ----------
    kkt_residual
        Largest violation of the optimality conditions of the quadratic program, relative to |H_j| |y|:
        the gradient on free weights and its negative part on weights at their bound.
    round_trip_error
        Larger of max |inverse(model(x)) - x| and max |model(inverse(y)) - y| over the log's input x and y = model(x),
        relative to their ranges.
    inverse_gain
        Largest slope of the inverse. [input/output]
    inverse_miss_percent
        RMS of the input that the inverse asks for to reach the measured output, less the input that was applied;
        over held-out samples (fitted ones if none were held out), percent of the input's range.
    affordable_eps
        Where the inverse's gain is high: the firmer eps that lowers it, as far as the error of the fit grows by no more
        than 5 %, in the units of the call. None if there is none, or it was chosen.
    enough_eps, enough_eps_cost
        Where the gain is high with the smallest eps: the eps that is enough for it not to be, and by which share that
        one raises the error of the fit.
    strain
        By which share the paper's bound, w_1 >= 0.001, raises the error of the fit beside one of a thousandth of the
        ratio of the ranges: where this is more than nothing, the unit decides the model. 0 for other bounds.
    nonzero_weights
        Number of operators with weight.
    operators
        Number n of operators offered to the optimisation.
    undetermined
        Thresholds of operators that never moved in the training samples: the data says nothing about them,
        and they carry no weight. [input]
    initial_state
        Memory assumed before the first sample: "zero", "rest", "rising", "falling" or "unknown".
    route
        How the quadratic program was solved: "normal equations" of the cells, refined on the data, or "orthogonal
        factors" of all samples, where the condition number exceeds 1e6.
    condition
        Condition number of the scaled cells whose slopes are free; infinite where a pivot vanished.
    """

    kkt_residual: float
    inverse_gain: float
    nonzero_weights: int
    operators: int
    initial_state: str
    undetermined: tuple[float, ...] = ()
    round_trip_error: float = float("nan")
    inverse_miss_percent: float = float("nan")
    affordable_eps: float | None = None
    route: str = "orthogonal factors"
    condition: float = float("inf")
    enough_eps: float | None = None
    enough_eps_cost: float = 0.0
    strain: float = 0.0


@dataclass(frozen=True, slots=True)
class ComparedSetting:
    """One family and setting that ``family="auto"`` compared.

    Attributes
    ----------
    family
        Model family.
    initial_state
        Memory assumed before the first sample.
    smoothing
        Smoothing of the output map, or None for families without one.
    error_percent
        Score by the RMSE on what was left out of the training part, percent of the output's range: the geometric mean
        of the mean error on spread fifths of the way and of that on fifths in one piece.
    uncertainty_percent
        Standard error of it.
    chosen
        Whether this one became the model.
    """

    family: str
    initial_state: str
    smoothing: float | None
    error_percent: float
    uncertainty_percent: float
    chosen: bool = False


@dataclass(frozen=True, slots=True)
class Option:
    """One row of the table from which a model was chosen.

    Attributes
    ----------
    family, direction
        Of the model.
    test_percent
        RMS error of the output on held-out samples, fitted ones if none were held out; percent of range.
    input_percent
        The same of the input that the inverse asks for.
    tracking_percent
        Predicted error of open-loop tracking, percent of the output's range; None where it was not asked for.
    exportable
        Whether it runs on a target.
    chosen
        Whether this is the model.
    """

    family: str
    direction: str
    test_percent: float
    input_percent: float
    tracking_percent: float | None
    exportable: bool
    chosen: bool

    def as_dict(self) -> dict[str, Any]:
        """Return the row as printed by ``--json``."""
        return asdict(self)


@dataclass(frozen=True, slots=True)
class LoopFacts:
    """What the data shows by itself, before any model.

    Attributes
    ----------
    orientation
        "counter-clockwise" (the output lags, as in muscles and piezos), "clockwise" (force against
        displacement), "mixed" or "none". For falling curves the output is mirrored first.
    trend
        +1 if the output rises with the input, -1 if it falls.
    width_percent
        Largest opening: distance of the two branches of the largest loops where they lie farthest apart, percent of the
        output's range.
    loops
        Input cycles over the training part, two swings each.
    turns
        Turning points of the input within the training part.
    drift_percent
        Change of the output from the first to the last loop at the same input, percent of range.
    motion
        Sizes and speeds of the loops over the training part, and whether the input rests.
    evidence
        Of rate and creep; empty without time stamps, or with less than 200 samples that have them.
    numbers
        Width, area, coercivity and others of the largest loops, as `dehyst.data.measure_loops` returns them; None if
        no loop is closed.
    butterfly
        Inputs at which the output turns on the way up and on the way down; None if the loop is no butterfly. [input]
    """

    orientation: str
    trend: int
    width_percent: float
    loops: int
    turns: int
    drift_percent: float
    motion: Motion = field(default_factory=Motion)
    evidence: tuple[Evidence, ...] = ()
    numbers: Loops | None = field(default=None, repr=False, compare=False)
    butterfly: tuple[float, float] | None = None

    @property
    def has_loop(self) -> bool:
        """Whether the branches of the loop are further apart than noise."""
        return self.orientation != "none"

    @property
    def loop_words(self) -> str:
        """The loop in a few words."""
        opening = f"{float(f'{self.width_percent:.2g}'):g} % of range"
        if self.butterfly is not None and self.has_loop:
            return f"butterfly loop, opening {opening}"
        if not self.has_loop:
            return f"no loop (branches at most {opening} apart)"
        mirrored = ""
        # Drawn as it was logged it runs the other way round, as `dehyst loops` says.
        if self.trend < 0:
            mirrored = " with the falling output mirrored"
        return f"loop {self.orientation}{mirrored}, opening {opening}"

    @property
    def rate_dependence_percent(self) -> float | None:
        """What follows rate or creeps, percent of range (rms), 0 where neither is found; None if it was not tested."""
        return max((term.size_percent for term in self.evidence), default=None)

    @property
    def depends(self) -> tuple[str, ...]:
        """What depends on rate or time, percent of range; in one where the log cannot tell which of the two."""
        sentences = []
        largest = 0.0
        told_apart = True
        for term in self.evidence:
            if term.there:
                sentences.append(f"{term.size_percent:.2g} % of range depend on {term.words}")
                largest = max(largest, term.size_percent)
                told_apart = told_apart and term.told
        if told_apart:
            return tuple(sentences)
        return (f"{largest:.2g} % of range depend on rate or time",)

    def lacking(self, low: float, high: float) -> str:
        """What this log cannot tell of rate and creep, why, and the line that plans a motion that does; "" if nothing.

        `low` and `high` are the range of the input.
        """
        untold = []
        unclear = False
        for term in self.evidence:
            if not term.told:
                untold.append(term.words)
                unclear = unclear or term.there
        if self.evidence and not untold:
            return ""
        gap = f"dependence on {' and '.join(untold) or 'rate and time (creep)'} cannot be told from hysteresis"
        if unclear:
            gap = "rate and creep cannot be told apart"
        reasons = []
        if not self.evidence:
            reasons.append(f"no time stamps, or fewer than {LEAST} samples that have them")
        if self.motion.rests is False:
            reasons.append("no holds")
        if self.motion.speeds < SPEEDS:
            reasons.append("one speed only")
        why = ""
        if reasons:
            why = f" ({', '.join(reasons)})"
        line = command("design", range=(f"{low:.3g}", f"{high:.3g}"))
        return f"{gap} in this log{why}; {line} plans a motion that tells"


@dataclass(frozen=True, slots=True)
class Refit:
    """Another fit of the same data, from kept sums.

    Attributes
    ----------
    family, n, eps
        Its settings; the others are those of the fit it was made from.
    model
        The model, with the names, units and ranges of the fit and its own settings and scores as provenance.
    train, test
        Scores on the same fitted and held-out samples; test is None when nothing was held out.
    inverse_gain
        Largest slope of the inverse. [input/output]
    nonzero_weights
        Number of operators with weight.
    kkt_residual, condition, route
        As in the `Certificate`, without the step of refinement on the data.
    seconds
        Time that it took.

    Examples
    --------
    >>> import dehyst
    >>> from dehyst.io import example_recording
    >>> refit = dehyst.identify(example_recording(), family="pi").refit(n=20)
    >>> refit.n, round(refit.test.rmse_percent, 2)
    (20, 1.76)
    """

    family: str
    n: int
    eps: float
    model: HysteresisModel
    train: Score
    test: Score | None
    inverse_gain: float
    nonzero_weights: int
    kkt_residual: float
    condition: float
    route: str
    seconds: float


# What `Fit.refit` calls: n, eps, family, thresholds.
Refitting = Callable[[int | None, float | None, str | None, npt.ArrayLike | None], Refit]


@dataclass(frozen=True)
class Fit(Plotted):
    """An identified model with everything needed to judge it.

    Attributes
    ----------
    family
        Family of the model: "pi", "pi-cumulative", "modified-pi", "stop", "static".
    model
        The model; ``model.inverse()`` is the compensator. With a shear, `recordings`, `predictions` and the scores are
        those of the sheared loop, whose input is u + k y; `model`, the inverse's gain and its miss are those of the
        log's own input u.
    recordings
        The data, one per log.
    predictions
        Output of the model for each recording, (T,). [output]
    inverse_predictions
        Input that the inverse asks for to reach the measured output of each recording, (T,): what a compensator
        would have done. [input]
    train_masks, test_masks
        Which samples of each recording were fitted, which were held out, (T,). Samples whose memory was
        unknown belong to neither.
    train, test
        Scores on fitted and on held-out samples; test is None when nothing was held out.
    input_train, input_test
        Error of the input that the inverse asks for, on the same samples.
    curve_input
        The same of the curve's inverse, on those held out if there are any.
    static
        The best curve without hysteresis.
    static_train, static_test
        Its scores on the same samples.
    certificate
        Optimality, round trip, gain, undetermined operators.
    facts
        Orientation, rate dependence and drift of the data.
    candidates
        What "auto" compared, best first; empty for a named family.
    warnings
        Findings of reading and identification, each with a code and a cure.
    settings
        Settings of the call, as plain values.
    verdict
        The judgement in one sentence.
    grade
        How far the model can be trusted as a compensator; None for a fit made by hand, which nobody judged.
    refitter
        What `refit` calls; None for a fit that was not made by `identify`.
    table
        From what the model was chosen, or what it is to be compared with; the curve among them.
    details
        What only this family says of itself, by the name under which ``--json`` shows it.
    form
        Makes what `interval` draws from; None where weights cannot be drawn anew.

    Examples
    --------
    >>> import numpy as np, dehyst
    >>> x = 2 * np.sin(np.linspace(0, 20, 400)) * np.linspace(1, 0.3, 400)
    >>> y = dehyst.PrandtlIshlinskii([0.0, 0.6], [1.0, 0.5]).simulate(x)
    >>> fit = dehyst.identify(dehyst.Recording(input=x, output=y), family="pi")
    >>> bool(fit.test.rmse_percent < 0.1)
    True
    """

    family: str
    model: Any
    recordings: tuple[Recording, ...]
    predictions: tuple[Array, ...]
    inverse_predictions: tuple[Array, ...]
    train_masks: tuple[Mask, ...]
    test_masks: tuple[Mask, ...]
    train: Score
    test: Score | None
    static: StaticCurve
    static_train: Score
    static_test: Score | None
    certificate: Certificate
    facts: LoopFacts
    candidates: tuple[ComparedSetting, ...]
    warnings: tuple[Finding, ...]
    settings: Mapping[str, Any] = field(default_factory=dict)
    verdict: str = ""
    grade: Grade | None = None
    refitter: Refitting | None = field(default=None, repr=False, compare=False)
    input_train: InputError = UNKNOWN
    input_test: InputError | None = None
    curve_input: InputError = UNKNOWN
    table: tuple[Option, ...] = ()
    details: Mapping[str, Any] = field(default_factory=dict)
    form: Callable[[Any], LinearForm] | None = field(default=None, repr=False, compare=False)

    @property
    def direction(self) -> str:
        """ "forward", or "inverse" where the input was identified as a function of the output."""
        return str(self.model.direction)

    @property
    def size(self) -> str:
        """How many of the operators or terms that were offered carry weight, or of parameters; "" for a curve."""
        offered = self.certificate.operators
        if not offered:
            return ""
        return size_of(self.model, self.certificate.nonzero_weights, offered)

    @property
    def word(self) -> str:
        """What the model is a sum of: "operators" where these are plays or stops alone, else "terms"."""
        return term_word(self.model)

    @property
    def evidence(self) -> tuple[Evidence, ...]:
        """What the log shows of rate and creep; empty without time stamps."""
        return self.facts.evidence

    @property
    def evidence_words(self) -> tuple[str, ...]:
        """What the log shows of rate and creep, a sentence each, and what the model has of them where that differs."""
        sentences = []
        for term in self.facts.evidence:
            sentences.append(f"{term}{_about_term(term, self.has_terms(term))}")
        return tuple(sentences)

    def has_terms(self, evidence: Evidence) -> bool:
        """Whether the model has terms of that on which there is evidence."""
        return not TERMS[evidence.group].isdisjoint(self.model.kinds)

    @property
    def lacking(self) -> str:
        """What this log cannot tell of rate and creep, and the line that plans a motion that does; "" if nothing."""
        card = self.model.card.input
        if card.low is None or card.high is None:
            return ""
        return self.facts.lacking(card.low, card.high)

    @property
    def output_error(self) -> Score:
        """Error of the output, over held-out samples if there are any."""
        return self.test or self.train

    @property
    def tracking(self) -> float | None:
        """Predicted error of open-loop tracking with the model, percent of the output's range; None where unknown."""
        return next((row.tracking_percent for row in self.table if row.chosen), None)

    @property
    def passed_over(self) -> str:
        """Which row of the table errs far less on held-out samples, and why it was not taken; "" if there is none."""
        if not self.test or not self.candidates:
            return ""
        for row in self.table:
            if row.family.endswith(WITHOUT_SIGNALS) and row.test_percent < self.test.rmse_percent:
                return (
                    f"{row.family} errs {row.test_percent:.3g} % on held-out samples, {self.family} with signals "
                    f"{self.test.rmse_percent:.3g} %. It was not taken: on what was left out of the fitted part it "
                    f"erred more. Something that was not logged may have changed, too. To take it leave --schedule out."
                )
        best = min(self.table, key=lambda row: row.test_percent, default=None)
        if best is None or not best.test_percent * POLICY.far_better <= self.test.rmse_percent:
            return ""
        left_out: dict[str, float] = {}
        for setting in self.candidates:
            left_out.setdefault(setting.family, setting.error_percent)
        reason = "the choice was made without these samples"
        if best.family in left_out and self.family in left_out:
            reason = (
                f"on what was left out of the fitted part it erred {left_out[best.family]:.3g} %, and "
                f"{self.family} {left_out[self.family]:.3g} %"
            )
        return (
            f"{best.family} errs {best.test_percent:.3g} % on held-out samples, {self.family} "
            f"{self.test.rmse_percent:.3g} %. It was not taken: {reason}. To take it: --family {best.family}."
        )

    @cached_property
    def dead_band(self) -> DeadBand | None:
        """How far the input moves behind a turn before the model's output does; None if it has no dead band."""
        try:
            return dead_band(self.model)
        # A model that cannot be run over its whole range has none that could be told.
        except DehystError:
            return None

    @cached_property
    def draws(self) -> Draws | None:
        """Models with weights drawn anew, from which intervals are made; None for a family without them."""
        if self.form is None:
            return None
        with single_blas():
            return draws_of(self.form(self.model))

    def interval(self, function: Callable[[Any], npt.ArrayLike], level: float = 0.95) -> Interval:
        r"""Return the interval of anything that is computed from the model: weights, predictions, figures of a loop.

        100 models are drawn as they would be identified from other logs with the same input, and the function of
        each is computed. With the estimate u, the normal equations G, the columns A and errors r of a block of rows,
        and one random number h for each block, a draw is the solution d of the same program::

            minimise  1/2 d' (G + penalty) d - d' sum over blocks of h_b A_b' r_b,    u + d >= lower

        The interval of f is f(u) - t s to f(u) + t s, where s is the root mean square of f(u + d) - f(u), and t is
        that of Student's distribution for the number of blocks. It does not cross 0 where no draw does: that of
        a weight that may be 0 begins there.

        Parameters
        ----------
        function
            Of a model of this family: returns a number or an array. It is called 101 times.
        level
            Share of such logs whose intervals hold the value of the best model of this structure.

        Returns
        -------
        interval
            ``value``, ``low`` and ``high``, numbers, or arrays of the function's shape, each place by itself.

        Raises
        ------
        ParameterError
            If the family has none: a curve, a family that is fitted by a search, the direct inverse; or for a level
            that is no share.
        IdentificationError
            If more than a tenth of the draws have no such value.

        Notes
        -----
        Structure, start state and input are fixed. Noise, whether white or lasting, and what a model of this structure
        cannot explain are in the interval; another actuator, drift, and motions that the log does not have are not. The
        noise of a new measurement comes on top. How often intervals hold what they should:
        docs/decisions/0069-intervals.md.

        Examples
        --------
        >>> import numpy as np, dehyst
        >>> rng = np.random.default_rng(0)
        >>> x = 2 * np.sin(np.linspace(0, 40, 2000)) * np.linspace(1, 0.3, 2000)
        >>> y = dehyst.PrandtlIshlinskii([0.0, 0.6], [1.0, 0.5]).simulate(x) + 0.05 * rng.normal(size=2000)
        >>> fit = dehyst.identify(dehyst.Recording(input=x, output=y), family="pi", n=10)
        >>> at_the_tip = fit.interval(lambda model: model.simulate([0.0, 2.0])[-1])
        >>> bool(at_the_tip.low < 2.7 < at_the_tip.high), bool(at_the_tip.half_width < 0.02)
        (True, True)
        """
        if self.draws is None:
            raise ParameterError(
                f"there are no intervals for '{self.family}': its numbers are no weights of a sum with memory that one "
                f"program finds, so they cannot be drawn anew. Take plays (pi, modified-pi, stop) or a row of elements "
                f"(play-sum, full-sum)."
            )
        return self.draws.interval(function, level)

    @cached_property
    def dead_band_interval(self) -> Interval | None:
        """Interval of the width of the dead band, 95 %; None without one. [input]

        A play between two thresholds is shared among both, and the lower one is seen first: so the interval reaches to
        the next threshold at least.
        """
        if self.dead_band is None or self.draws is None:
            return None
        interval = self.interval(_dead_width)
        widths = 2.0 * np.unique(np.concatenate([_radii(model) for model in self.draws.models]))
        wider = widths[widths > self.dead_band.width * (1.0 + ROUNDING)]
        high = interval.high
        if wider.size:
            high = max(high, float(wider[0]))
        return replace(interval, value=self.dead_band.width, high=high)

    @property
    def _dead_band_dict(self) -> dict[str, float] | None:
        if self.dead_band is None:
            return None
        interval = self.dead_band_interval
        if interval is None:
            return asdict(self.dead_band)
        return {**asdict(self.dead_band), "low": interval.low, "high": interval.high}

    @property
    def _intervals_dict(self) -> dict[str, Any] | None:
        if self.draws is None:
            return None
        weights = []
        if self.weight_interval is not None:
            low, high = self.weight_interval.low.tolist(), self.weight_interval.high.tolist()
            weights = [list(pair) for pair in zip(low, high, strict=True)]
        return {
            "level": LEVEL,
            "blocks": self.draws.blocks,
            "output": self.output_certain,
            "weights": weights,
        }

    @property
    def output_certain(self) -> float | None:
        """Half the width of the 95 % interval of the output along the fitted part, rms; None if unknown. [output]"""
        if self.draws is None or self.draws.band is None:
            return None
        return float(np.sqrt(np.mean(self.draws.band.half_width**2)))

    @cached_property
    def weight_interval(self) -> Interval | None:
        """Interval of each weight of plays or stops that the model has, 95 %; None for models without them."""
        core = self.model.play_core
        if core is None or self.draws is None:
            return None
        # The draws have every operator that was offered.
        offered = self.draws.form.estimate.play_core.thresholds
        places = np.searchsorted(offered, core.thresholds)
        return self.interval(lambda model: model.operators[1][places])

    @property
    def input_error(self) -> InputError:
        """Error of the input that the inverse asks for, over held-out samples if there are any."""
        return self.input_test or self.input_train

    @cached_property
    def residual(self) -> Residual:
        """What the residual follows on held-out samples, on fitted ones if none were held out, and what is noise."""
        part, masks, score = "fitted", self.train_masks, self.train
        if self.test:
            part, masks, score = "held-out", self.test_masks, self.test
        # The range of the output, by which the score was divided.
        output_range = 1.0
        if score.rmse_percent > 0.0:
            output_range = 100.0 * score.rmse / score.rmse_percent
        structure = residual_structure(
            self.recordings,
            self.predictions,
            masks,
            output_range,
            part=part,
            knows_time=self.model.rate_dependent,
            confirmed=self._confirmed,
            excluded=self._excluded,
            resonance=self.model.resonance,
        )
        if "output-unrelated" in codes_of(self.warnings):
            return replace(structure, suggestions=(UNRELATED_INPUT,))
        return structure

    @property
    def _confirmed(self) -> set[str]:
        """Causes of a residual that tests of their own have shown: rate, creep, one column late."""
        causes = set()
        for term in self.facts.evidence:
            if term.there and term.told:
                causes.add(CAUSES[term.group])
        for finding in self.warnings:
            if finding.code in ("output-late", "output-early"):
                causes.add("delay")
        return causes

    @property
    def _excluded(self) -> set[str]:
        """Causes of a residual for which the log could tell, and its test did not show them."""
        return {CAUSES[term.group] for term in self.facts.evidence if term.told and not term.there}

    def refit(
        self,
        *,
        n: int | None = None,
        eps: float | None = None,
        family: str | None = None,
        thresholds: npt.ArrayLike | None = None,
    ) -> Refit:
        """Fit the same samples again with some settings changed; the start state stays.

        Sums over the samples are kept with the fit, so another eps or a part of the thresholds needs no data at all,
        and other thresholds one pass over them. The model is evaluated once for its scores.

        Parameters
        ----------
        n
            Number of operators, on the grid that `identify` would take.
        eps
            Smallest slope right after a reversal, a number as `identify` takes it for the family; by default that of
            the fit, relative to the ratio of the ranges.
        family
            Model family.
        thresholds
            Thresholds instead of a grid. [input]

        Raises
        ------
        ParameterError
            If a setting lies outside what its formula allows, or the fit was not made by `identify`.

        Examples
        --------
        >>> import numpy as np, dehyst
        >>> x = np.interp(np.linspace(0, 8, 1601), range(9), [0, 2, -2, 1.6, -1.2, 0.8, -2, 2, 0])
        >>> y = dehyst.PrandtlIshlinskii([0.0, 0.5, 1.0], [1.0, 0.5, 0.5]).simulate(x)
        >>> fit = dehyst.identify(dehyst.Recording(input=x, output=y), family="pi")
        >>> [fit.refit(n=n).nonzero_weights for n in (2, 4, 8)]
        [2, 3, 3]
        """
        if self.refitter is None:
            raise ParameterError(
                "this fit holds no sums over its data: fits of plays by dehyst.identify do, curves without memory do "
                "not. Identify again with the other settings."
            )
        if isinstance(n, str):
            raise ParameterError(
                f"n = {n!r}: a refit takes a whole number. Numbers are compared by identify(recording, n='auto')."
            )
        if n is not None and thresholds is not None:
            raise ParameterError(
                f"n = {n} and thresholds were both given; thresholds are their own number. Pass one."
            )
        refit = self.refitter(n, eps, family, thresholds)
        if self.model.shear is not None:
            refit = _sheared(refit, self.model.shear)
        return replace(refit, model=refit.model.with_card(self._card_of(refit)))

    def _card_of(self, refit: Refit) -> ModelCard:
        """Card of this fit with the settings and scores of another one."""
        card: ModelCard = self.model.card
        provenance = dict(card.provenance)
        provenance |= {
            "settings": {
                **dict(provenance.get("settings", {})),
                "family": refit.family,
                "n": refit.n,
                "eps": refit.eps,
            },
            "identified_family": refit.family,
            "train": refit.train.as_dict(),
            "test": _score_dict(refit.test),
            "verdict": "a refit, which is not judged; see the scores",
        }
        provenance.pop("grade", None)
        return replace(card, provenance=provenance)

    def __repr__(self) -> str:
        """One line: family, operators and the error that counts."""
        scored_on = "held out"
        if self.test is None:
            scored_on = "fitted"
        count = f"{len(self.warnings)} warnings"
        if len(self.warnings) == 1:
            count = "1 warning"
        return (
            f"<Fit {self.family!r}: {self.size or 'a curve'}, {self.output_error.rmse_percent:.2f} % of range rms "
            f"{scored_on}, {count}>"
        )

    def __str__(self) -> str:
        """Verdict, scores, model and the codes of the warnings."""
        unit = self.recordings[0].output_unit
        lines = [self.verdict or repr(self)]
        for name, score in (("fitted", self.train), ("held out", self.test)):
            if score is not None:
                rms = f"{score.rmse:.4g} {unit}".rstrip()
                lines.append(
                    f"{name}: rms {rms}, {score.rmse_percent:.2f} % of range, max {score.max:.4g} {unit}".rstrip()
                )
        lines.append(f"model: {self.model!r}")
        codes = dict.fromkeys(finding.code for finding in self.warnings)
        lines.append(f"warnings: {', '.join(codes) or 'none'}")
        return "\n".join(lines)

    def as_dict(self) -> dict[str, Any]:
        """Return the verdict as plain values, the content of ``dehyst identify --json``."""
        return {
            "family": self.family,
            "n": self.certificate.operators,
            "nonzero_weights": self.certificate.nonzero_weights,
            "train": self.train.as_dict(),
            "test": _score_dict(self.test),
            "static_train": self.static_train.as_dict(),
            "static_test": _score_dict(self.static_test),
            "kkt_residual": self.certificate.kkt_residual,
            "round_trip_error": self.certificate.round_trip_error,
            "inverse_gain": self.certificate.inverse_gain,
            "inverse_miss_percent": self.certificate.inverse_miss_percent,
            "purpose": str(self.settings.get("purpose", "compensate")),
            "direction": self.direction,
            "schedules": list(self.model.needs),
            "elements": list(self.model.kinds),
            "loop": {
                "orientation": self.facts.orientation,
                "width_percent": self.facts.width_percent,
                "loops": self.facts.loops,
                "numbers": self.facts.numbers and self.facts.numbers.summary,
            },
            "dead_band": self._dead_band_dict,
            "intervals": self._intervals_dict,
            "dead_time_s": self.model.dead_time,
            "resonance": self.model.resonance and asdict(self.model.resonance),
            "residual": self.residual.as_dict(),
            "input_error": {
                "train": self.input_train.as_dict(),
                "test": _score_dict(self.input_test),
            },
            "tracking_percent": self.tracking,
            "table": [row.as_dict() for row in self.table],
            "grade": None if self.grade is None else str(self.grade),
            "initial_state": self.certificate.initial_state,
            "route": self.certificate.route,
            "condition": self.certificate.condition,
            "shear": self.model.shear,
            "verdict": self.verdict,
            "evidence": [term.as_dict() for term in self.facts.evidence],
            "warnings": [finding.as_dict() for finding in self.warnings],
            **self.details,
        }


def size_of(model: Any, nonzero: int, offered: int) -> str:
    """How large a model is: of so many operators of a sum of plays, or terms of another sum, those with weight.

    A family fitted by its name tells the number of its parameters alone, as the table of `dehyst compare` does.
    """
    word = term_word(model)
    if word == "terms" and nonzero == offered:
        return f"{offered} parameters"
    return f"{nonzero} of {offered} {word}"


def term_word(model: Any) -> str:
    """What a model is a sum of: "operators" where these are plays or stops alone, else "terms"."""
    if model.play_core is None:
        return "terms"
    return "operators"


def _dead_width(model: Any) -> float:
    band = dead_band(model, samples=DRAWN_SAMPLES)
    return 0.0 if band is None else band.width


def _radii(model: Any) -> Array:
    """Thresholds of the plays of a model. [input]"""
    if model.play_core is not None:
        return np.asarray(model.play_core.thresholds)
    radii = [q.radius for q in model.elements if q.kind in ("play", "creep", "wide", "stop")]
    return np.asarray(abs(model.scaling.half_range) * np.array(radii, dtype=np.float64))


def _score_dict(score: Score | InputError | None) -> dict[str, float] | None:
    if score is None:
        return None
    return score.as_dict()


TERMS = {RATE: {"viscous", "rate"}, CREEP: {"creep", "relax"}}  # kinds of elements that follow it
CAUSES = {RATE: "rate", CREEP: "time-since-turn"}  # their names among the causes of a residual


def _about_term(term: Evidence, has_term: bool) -> str:
    """What to add where a model has a term that was not found, or lacks one that was."""
    if has_term == term.there:
        return ""
    if has_term:
        return "; the model has a term of it, which made the fit better"
    if term.told:
        return "; not in the model, whose other terms do as well there"
    return ""


def _sheared(refit: Refit, k: float) -> Refit:
    """The same refit, with k y subtracted again."""
    if not isinstance(refit.model, PrandtlIshlinskii):
        raise ParameterError(
            f"a sheared loop is refitted with the families pi and pi-cumulative, not with '{refit.family}': its "
            f"inverse less k y is no sum of plays."
        )
    model = ShearedPrandtlIshlinskii(refit.model, k)
    return replace(refit, model=model, inverse_gain=model.inverse_gain)
