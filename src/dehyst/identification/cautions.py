"""Warnings about data and fit, each with its numbers and a cure."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from dehyst.data.recording import Recording
from dehyst.findings import Finding
from dehyst.identification.conditions import at_one_speed, steeper, wider
from dehyst.identification.data import DataSet
from dehyst.identification.families import HIGH_GAIN, STATIC, is_high
from dehyst.identification.fit import Candidate, Certificate, LoopFacts
from dehyst.identification.residual import spectral_peak
from dehyst.identification.scores import Measured
from dehyst.identification.selection import AFFORDABLE, STATIC_AS_GOOD
from dehyst.identification.settings import PAPER_EPS
from dehyst.shell import command
from dehyst.units import dimension, mass_unit, parse_unit

# What follows rate or time counts when it is no smaller than this share of the range.
RATE_SIZE = 0.007
DRIFT_SIZE = 0.02
DRIFT_CERTAINTY = 3.0
BEYOND = 0.02
# An inverse that turns a two-thousandth of the output's range into the whole of the input's is of no use; the least
# eps alone keeps it at half of that ...
USELESS_GAIN = 2e3
# ... nor is a model of an actuator that became another one.
OTHER_ACTUATOR = 0.25
POOR_PERCENT = 10.0
# Findings that a model is poor, and those that may be why.
POOR = ("poor-fit", "inverse-misses")
REASONS = (
    "rate-dependent", "drift", "two-actuators", "mixed-loop", "clockwise", "few-loops", "never-turns", "unknown-memory",
    "recordings-differ", "swapped-columns", "output-unrelated", "output-stopped", "output-late", "output-early",
    "held-out-worse", "extrapolation", "one-loop-size", "spectral-peak", "outlier", "saturated-input",
    "saturated-output", "held-input", "held-output", "undetermined-operators",
)  # fmt: skip
NO_REASON = (
    "No other finding says why. Something that was not logged may move the output too (load, temperature, supply), or "
    "no model here has a loop of this kind: the residual in the report shows where it misses."
)
# A compensator that is off by a quarter of its range does harm.
INVERSE_MISSES = 25.0
# Recordings fitted together whose mean residuals differ by more than this share of the output's range.
LEVELS_APART = 0.05
# Of a peak of the residual's spectrum, percent of range: as little as that is rounding of a converter.
PEAK_SIZE = 0.1
# The output does not follow the input: held out, even its mean is nearer than model and curve, and of the fitted
# samples the model leaves more than this share of the deviation.
UNRELATED = 0.3
# Held-out samples that are missed by more than so many times the error of the fitted ones, and this percent of range.
WORSE = 5.0
WORSE_PERCENT = 1.0
# What hides a loop: while it is there, that a curve is as good says nothing about hysteresis.
HIDES = ("output-unrelated", "recordings-differ", "drift", "two-actuators")
# Held-out samples whose input covers less than this share of the fitted range hold no loops.
SMALL_TEST = 0.1


@dataclass(frozen=True)
class Knows:
    """What a family can show beside plain hysteresis."""

    leads: bool = False  # Loops whose output leads the input
    crosses: bool = False  # Loops that lead in one part of the input and lag in another
    time: bool = False  # Rate and creep


def of_range(percent: float) -> str:
    """Return a share of a range in words: percent, or how many times the range.

    Examples
    --------
    >>> of_range(0.274), of_range(31.2), of_range(7540.0)
    ('0.27 % of', '31 % of', '75 times')
    """
    if not percent >= 100.0:
        return f"{percent:.2g} % of"
    times = float(f"{percent / 100.0:.2g}")
    return f"{times:.0f} times" if 10.0 <= times < 1e6 else f"{times:.2g} times"


def about_data(
    data: DataSet,
    loop: LoopFacts,
    change: float,
    doubt: float,
    knows: Knows,
    span: tuple[float, float],
) -> Iterator[Finding]:
    """Yield what in the data limits any model: orientation, rate, drift, too few loops, gaps.

    `span` is the range of the whole log's input, which a motion that tells more should use.
    """
    if loop.orientation == "clockwise":
        cure = "" if knows.leads else " Identify with --family stop or auto."
        yield Finding(
            "clockwise",
            f"the loop runs clockwise ({loop.width_percent:.0f} % of the output's range wide): the output leads the "
            f"input, as force against displacement does. A Prandtl-Ishlinskii model with non-negative weights lags and "
            f"cannot show it; the stop form can. If this is an actuator's response, check that input and output are "
            f"not swapped.{cure}",
        )
    if loop.orientation == "mixed" and not knows.crosses:
        yield Finding(
            "mixed-loop",
            "the loop runs clockwise over one part of the input and counter-clockwise over another. No "
            "Prandtl-Ishlinskii model does that; look at the loop in the report, and for a second moving part, a "
            "lagging sensor, or swapped columns.",
        )
    if (loop.rate_dependence_percent or 0.0) >= 100.0 * RATE_SIZE and not knows.time:
        lacking = loop.lacking(*span)
        yield Finding(
            "rate-dependent",
            f"{' and '.join(loop.depends)}, on blocks held out: damping, creep, or a lagging sensor, which no "
            f"rate-independent model can follow. Take a family that knows them (--family auto looks for one), identify "
            f"at the speed of use, or align the delay of a sensor."
            + (f" {lacking[0].upper()}{lacking[1:]}." if lacking else ""),
        )
    if drifts(data, change, doubt):
        yield Finding(
            "drift",
            f"the output drifts by {abs(loop.drift_percent):.1f} % of its range from the first to the last cycle at "
            f"the same input: warming, leakage or creep. The model is an average over it. Warm up before logging, or "
            f"leave out the first cycles (--from).",
        )
        if change > OTHER_ACTUATOR * data.output_range:
            yield Finding(
                "two-actuators",
                f"the output at the same input changes by {abs(loop.drift_percent):.0f} % of its range within the log: "
                f"no single model is both what the actuator was and what it became. Look at the residual in the "
                f"report, and identify the part of the log that is like the use (--from, --to).",
            )
    all_of_it = all(piece.split >= piece.x.size for piece in data.pieces)
    if loop.turns == 0:
        yield Finding(
            "never-turns",
            "the input never turns within the training part: one branch of a loop cannot show hysteresis, and "
            f"what looks like memory is made up. {'' if all_of_it else 'Fit all of it (--train-fraction 1), or l'}"
            f"{'L' if all_of_it else ''}og complete loops, at least two if one is to be held out.",
        )
    elif loop.loops < 2:
        yield Finding(
            "few-loops",
            f"the training part holds {loop.loops} complete loop{'' if loop.loops == 1 else 's'}: one loop cannot tell "
            f"hysteresis from drift or noise. Log at least three, of different size"
            f"{'' if all_of_it else ', or fit a larger part (--train-fraction)'}.",
        )
    if loop.motion.one_size:
        line = command("design", range=(f"{span[0]:.3g}", f"{span[1]:.3g}"))
        sizes = dict.fromkeys(f"{size:.0f}" for size in (loop.motion.smallest, loop.motion.largest))
        yield Finding(
            "one-loop-size",
            f"all {loop.loops} loops are of one size ({' to '.join(sizes)} % of the input's range): smaller ones were "
            f"neither fitted nor tested, and what the model says of them follows from the shape of one branch. Where "
            f"the input will turn within its range, log loops of other sizes; `{line}` plans them, "
            f"with holds that show creep.",
        )
    masked = sum(int(piece.known) for piece in data.pieces if piece.after_break)
    if masked:
        yield Finding(
            "unknown-memory",
            f"{masked} samples after gaps do not count: until both extremes were visited again, of the range or of the "
            f"piece, the output depends on what happened within the gap. Log without gaps, or begin each piece with a "
            f"full loop.",
        )


def drifts(data: DataSet, change: float, doubt: float) -> bool:
    """Whether a change of the output from the first to the last cycle, above 0, is large and certain."""
    return change > DRIFT_SIZE * data.output_range and change > DRIFT_CERTAINTY * doubt


def hidden_by(codes: Collection[str]) -> str:
    """Which of these findings hide a loop, in words, "" if none does.

    Examples
    --------
    >>> hidden_by(["gap", "recordings-differ"])
    'recordings-differ'
    """
    return " and ".join(code for code in HIDES if code in codes)


def about_fit(
    data: DataSet,
    measured: Measured,
    certificate: Certificate,
    paper: bool,
    asked_test: bool,
    knows: Knows,
    turns: int,
    leads: bool = False,
) -> Iterator[Finding]:
    """Yield what limits this fit: undetermined operators, extrapolation, no gain over a curve, high gain.

    `leads`: the loop runs clockwise.
    """
    records = measured.recordings
    first = records[0]
    yield from _levels(data, certificate.initial_state)
    if certificate.undetermined:
        unit = f" {first.input_unit}" if first.input_unit else ""
        yield Finding(
            "undetermined-operators",
            f"{len(certificate.undetermined)} of {certificate.operators} operators never moved in the training part "
            f"(thresholds from {certificate.undetermined[0]:.4g}{unit} on): their weights are unknown and left zero. "
            f"Sweep the input further than that, or give fewer thresholds.",
        )
    if measured.beyond > BEYOND:
        yield Finding(
            "extrapolation",
            f"the held-out input leaves the range that was fitted by {100 * measured.beyond:.0f} %: the test measures "
            f"extrapolation there. Fit a part that covers the whole range (--train-fraction, --from, --to).",
        )
    if measured.test is not None:
        pairs = zip(records, measured.test_masks, strict=True)
        held_out = np.concatenate([record.input[mask] for record, mask in pairs])
        covered = float(np.ptp(held_out)) / (2.0 * data.half_range)
        if covered < SMALL_TEST:
            yield Finding(
                "small-test",
                f"the {held_out.size} samples held out cover {100 * covered:.2g} % of the input's range: no loop, so "
                f"the error on them says little. Log more, without gaps, or fit a smaller part (--train-fraction).",
            )
    told_apart = [*_held_out(measured, turns), *_recordings_differ(data, measured, knows, leads)]
    yield from told_apart
    peak = spectral_peak(records, measured.predictions, measured.test_masks if measured.test else measured.train_masks)
    judged = (measured.test or measured.train).rmse_percent
    if peak is not None and judged * peak.share**0.5 > PEAK_SIZE:
        yield Finding(
            "spectral-peak",
            f"{peak.words(all(record.time is not None for record in records))}, where the input hardly moves: a "
            f"resonance that the motion rings, or a disturbance of that frequency. No model of hysteresis follows it. "
            f"Smooth the reference, filter that frequency out of the measured output, or damp it.",
        )
    error = (measured.test or measured.train).rmse
    bar = (measured.static_test or measured.static_train).rmse
    if turns and certificate.operators and error > STATIC_AS_GOOD * bar:  # one branch is no loop
        hidden = {finding.code for finding in told_apart}
        if drifts(data, abs(measured.drift[0]), measured.drift[1]):
            hidden.add("drift")
        yield Finding(
            "static-as-good",
            f"a curve without hysteresis is as good: it misses by {100 * bar / data.output_range:.2f} % of range, the "
            f"model by {100 * error / data.output_range:.2f} %. {_why_as_good(hidden)}",
        )
    slope = data.amplitude / data.half_range
    if certificate.strain > AFFORDABLE:
        yield _bound_of_paper(first, slope, certificate.strain)
    gain = certificate.inverse_gain * slope
    misses = certificate.inverse_miss_percent > INVERSE_MISSES  # then nobody should use the inverse at all
    if np.isfinite(gain) and is_high(gain) and not misses:  # without a bound there is no inverse
        yield Finding(
            "high-inverse-gain",
            f"right after a reversal the inverse may ask for {certificate.inverse_gain:.4g}{unit_of_gain(first)} "
            f"({gain:.0f} times as much as over the whole range): noise on its input becomes steps of its output. "
            f"{_of_units(slope) if paper else ''}"
            f"{_cure_of_terms(measured, leads, slope) if knows.crosses else _cure_of_gain(certificate)}",
        )
    if np.isfinite(gain) and gain > USELESS_GAIN and not misses:
        yield Finding(
            "inverse-useless",
            f"a change of the wanted output by 0.01 % of its range may ask for {0.01 * gain:.0f} % of the input's: the "
            f"inverse turns any noise into full strokes. Do not compensate with this model; raise --eps.",
        )
    if misses:
        yield Finding(
            "inverse-misses",
            f"to reach the measured output the inverse asks for an input that is off by "
            f"{of_range(certificate.inverse_miss_percent)} the input's range (rms): a compensator would drive the "
            f"actuator astray. Use the model for simulation only.",
        )
    percent = 100.0 * error / data.output_range
    if percent > POOR_PERCENT:
        yield Finding(
            "poor-fit",
            f"the model misses by {of_range(percent)} the output's range: too much for compensation.",
        )
    if measured.test is None and asked_test:
        yield no_held_out()


def _why_as_good(codes: Collection[str]) -> str:
    hidden = hidden_by(codes)
    if hidden:
        return (
            f"What the warning {hidden} says is larger than any loop here, so this says nothing about hysteresis: mend "
            f"that first."
        )
    return (
        "It does not tell why: there is no hysteresis at this scale, the loop is of a kind this model cannot show, or "
        "something else moves the output. Use the curve (--family static), or look at the loop in the report."
    )


def _recordings_differ(data: DataSet, measured: Measured, knows: Knows, leads: bool) -> Iterator[Finding]:
    """What differs between recordings beside their motion, and which columns may say why."""
    records, found = measured.recordings, measured.conditions
    apart = measured.levels_apart / data.output_range
    seen = []
    if apart > LEVELS_APART:
        seen.append(f"their outputs lie up to {100 * apart:.0f} % of range apart at the same input")
    if steeper(found):
        least, most = min(found, key=lambda each: each.gain), max(found, key=lambda each: each.gain)
        seen.append(f"the gain of {most.name} is {most.gain / max(least.gain, 1e-9):.2g} times that of {least.name}")
    if wider(found) and (knows.time or at_one_speed(records)):
        least, most = min(found, key=lambda each: each.width), max(found, key=lambda each: each.width)
        seen.append(
            f"the loop is {most.width_percent:.2g} % of range wide in {most.name} and {least.width_percent:.2g} % in "
            f"{least.name}"
        )
    if not seen:
        return
    held = [record.name for record, mask in zip(records, measured.test_masks, strict=True) if mask.all()]
    tested = f" Held out: {', '.join(held)}." if held else ""
    yield Finding(
        "recordings-differ",
        f"the recordings are not of one condition: {'; '.join(seen)}. A zero, a load, a temperature or another signal "
        f"that no model was told does that, and one model averages over it.{tested} {_schedule(records, leads)}",
    )


def _schedule(records: Sequence[Recording], leads: bool) -> str:
    """Which columns differ between recordings and stand still within, and what can be done with them."""
    stills = [record.provenance.get("stills") or {} for record in records]
    names = [name for name in stills[0] if all(name in each for each in stills)]
    moved = [name for name in names if len({each[name] for each in stills}) > 1]
    apart = "Identify each recording by itself, or align the zeros where only the level differs."
    if not moved:
        return f"If a column of the logs says what it is, look there. {apart}"
    ranges = [f"{name} ({min(e[name] for e in stills):.4g} to {max(e[name] for e in stills):.4g})" for name in moved]
    looks = f"Between them {', '.join(ranges)} differ{'s' if len(moved) == 1 else ''}."
    options = [option for name in moved if (option := _option(name))]
    if leads or not options:
        return f"{looks} No family here takes a schedule by that. {apart}"
    return f"{looks} A model with a schedule: --family direct-inverse {options[0]}."


def _option(name: str) -> str:
    """The option that makes a schedule of a column, "" if none does."""
    unit = parse_unit(name)[1]
    kind = dimension(unit)
    if kind in ("force", "torque") or mass_unit(name, unit):
        return f"--load {name}"
    return f"--mean-pressure {name}" if kind == "pressure" else ""


def _held_out(measured: Measured, turns: int) -> Iterator[Finding]:
    """What the held-out samples show that the fitted ones did not; a branch that never turns was to be worse there."""
    test, static, train = measured.test, measured.static_test, measured.train
    if test is None or static is None:
        return
    if unrelated(measured):
        mean = test.rmse_percent / test.nrmse
        yield Finding(
            "output-unrelated",
            f"the output does not follow this input: on held-out samples the model misses by "
            f"{of_range(test.rmse_percent)} the output's range, the best curve without hysteresis by "
            f"{of_range(static.rmse_percent)} it, and the mean of these samples by {of_range(mean)} it only. It is "
            f"another column, or something else moves it: look at the log (dehyst inspect LOG), and log what else "
            f"drives the actuator.",
        )
    elif turns and test.rmse > WORSE * train.rmse and test.rmse_percent > WORSE_PERCENT and measured.beyond <= BEYOND:
        yield Finding(
            "held-out-worse",
            f"the model misses the held-out samples by {of_range(test.rmse_percent)} the output's range, "
            f"{test.rmse / train.rmse:.2g} times as much as the fitted ones ({of_range(train.rmse_percent)} it): what "
            f"was held out is not like what was fitted, in gain, offset, speed or load, or the model knows the fitted "
            f"loops by heart. Look at the residual in the report; if both parts are like the use, fit all of it "
            f"(--train-fraction 1) and test on another log.",
        )


def with_reasons(findings: tuple[Finding, ...]) -> tuple[Finding, ...]:
    """Findings; those that a model is poor name the others that may be why, or say that there is none."""
    others = [finding.code for finding in findings if finding.code in REASONS]
    names = ", ".join(dict.fromkeys(others))
    why = f"What may be the reason: {names}." if names else NO_REASON
    reasoned = []
    for finding in findings:
        if finding.code in POOR:
            finding = replace(finding, message=f"{finding.message} {why}")
        reasoned.append(finding)
    return tuple(reasoned)


def unrelated(measured: Measured) -> bool:
    """Whether the output does not follow the input on held-out samples, and hardly on the fitted ones."""
    test, static = measured.test, measured.static_test
    if test is None or static is None:
        return False
    return min(test.nrmse, static.nrmse) > 1.0 and measured.train.nrmse > UNRELATED


def _levels(data: DataSet, start: str) -> Iterator[Finding]:
    """Pieces that count with a level of their own."""
    pieces = [piece for piece in data.pieces if piece.unknown_level(start)]
    fitted, held_out = (
        sum(max(span.stop - span.start, 0) for span in spans)
        for spans in ((piece.fitted(start) for piece in pieces), (piece.held_out(start) for piece in pieces))
    )
    if fitted + held_out:
        count = "a piece after a gap goes" if len(pieces) == 1 else f"{len(pieces)} pieces after gaps go"
        yield Finding(
            "unknown-level",
            f"{count} over the whole range of the input late or never. What the actuator remembers of wider loops is "
            f"unknown there, and shifts the output by a constant. Of {fitted} fitted and {held_out} held-out samples "
            f"the mean error of their piece was taken off, as far as the model's memory can explain it. A zero that "
            f"shifted may hide in that constant. Log without gaps, or begin each piece with a full loop.",
        )


def late(time: float, unit: str, percent: tuple[float, float], used: bool) -> Finding:
    """What to say where one column is late: by how much, what sums err as logged and shifted, percent of range.

    `used`: the model knows it.
    """
    size = f"{1000.0 * abs(time):.2g} ms" if unit == "s" and abs(time) < 1.0 else f"{abs(time):.2g} {unit}"
    shifted = (
        f"with it shifted by that the model misses blocks left out by {percent[1]:.2g} % of range, as logged by "
        f"{percent[0]:.2g} %"
    )
    if time < 0.0:
        return Finding(
            "output-early",
            f"the output column is about {size} early: {shifted}. No actuator answers before it is asked, so the input "
            f"was logged late, by a filter, a bus or another clock. Log both by one clock and unfiltered, or move the "
            f"input column ahead by that time and identify again.",
        )
    cure = (
        "The model knows it; its inverse says which input belongs to an output: give it the reference that much ahead."
        if used
        else "If the logging does it, log both by one clock and unfiltered, or move the column. If the actuator does, "
        "identify with --for simulate, which takes the dead time into the model, and then give its inverse the "
        "reference that much ahead. Do both: the reference ahead of this model may make it worse."
    )
    return Finding(
        "output-late",
        f"the output column is about {size} late: {shifted}. A dead time (transport, a bus, two clocks) does "
        f"that, and a lag of a sensor or a filter; the log does not tell which. {cure}",
    )


def plays_only(cause: str, cure: str) -> Finding:
    """Say that auto chose among plays alone, why, and what to do for more."""
    return Finding(
        "plays-only",
        f"auto chose among plays and the curve only, as {cause}: models with creep, rate or maps, which often err "
        f"less, were not tried. {cure}.",
    )


def no_hysteresis(
    candidates: tuple[Candidate, ...], span: tuple[float, float], codes: Collection[str], loop: LoopFacts
) -> Finding:
    """What to say where a curve is the answer, on a log whose input has the range `span`.

    `codes` are those of the other findings, one of which may be why.
    """
    curve = next(each for each in candidates if each.family == STATIC)
    best = min((each for each in candidates if each.family != STATIC), key=lambda each: each.error_percent)
    line = command("design", range=(f"{span[0]:.3g}", f"{span[1]:.3g}"))
    hidden = hidden_by(codes)
    log_more = f"log more of it, warmed up and under one load (`{line}` plans the motion)"
    if hidden:
        why = (
            f"a loop may be hidden by what the warning {hidden} says, so the model is the curve for now. Mend that "
            f"first"
        )
    elif loop.has_loop:
        why = (
            f"a loop is there, {loop.width_percent:.0f} % of range wide, but no model foretells the parts of it that "
            f"were left out, so the model is the curve: too little of the loop repeats, or it is of another kind. "
            f"{log_more[0].upper()}{log_more[1:]}, see what other families do (dehyst compare)"
        )
    else:
        why = (
            "hysteresis was not found at this scale, or does not repeat, so the model is the curve. If the loop in "
            f"the report is open, {log_more}"
        )
    return Finding(
        "no-hysteresis",
        f"on loops held out within the fitted part a curve without memory misses by {curve.error_percent:.2f} % of "
        f"range, the best model with memory ({best.family}) by {best.error_percent:.2f} %: {why}, or insist with "
        f"--family {best.family}.",
    )


def no_held_out() -> Finding:
    """What to say where a part was to be held out, and none of it counts."""
    return Finding(
        "no-held-out",
        "no sample of the part that was held out counts, since its memory is unknown, so the errors are those of the "
        "fit itself and flatter it. Log without gaps, or fit another part (--train-fraction).",
    )


def _bound_of_paper(first: Recording, slope: float, strain: float) -> Finding:
    """The paper's bound decides the model, which in other units would be another one."""
    unit = f" {first.output_unit}/{first.input_unit}" if first.output_unit and first.input_unit else ""
    return Finding(
        "paper-bound",
        f"the paper's bound w_1 >= 0.001{unit} is {of_range(100 * PAPER_EPS / slope)} the mean slope of this log, "
        f"{slope:.3g}{unit}, and makes the error of the fit {1.0 + strain:.3g} times as large as a bound of a "
        f"thousandth of that slope does: it is absolute, so the model depends on the units. Identify with --eps auto, "
        f"which is relative, or with --eps {0.001 * slope:.1g}.",
    )


def unit_of_gain(record: Recording) -> str:
    """Return the unit of the inverse's slope behind a space, or nothing."""
    return f" {record.input_unit}/{record.output_unit}" if record.input_unit and record.output_unit else ""


def _of_units(slope: float) -> str:
    return (
        f"The paper's bound w_1 >= 0.001 is absolute; in the units of this log it is "
        f"{of_range(100 * PAPER_EPS / slope)} the mean slope. "
    )


def _cure_of_terms(measured: Measured, leads: bool, slope: float) -> str:
    """What lowers the gain of a sum of elements, which has no eps: plays, where they can show the loop."""
    depends = [evidence.words for evidence in measured.evidence if evidence.there]
    if leads or depends:
        lacks = f"this log depends on {' and '.join(depends)}" if depends else "this loop runs clockwise"
        return f"Smooth the reference. Plays, whose gain can be bounded, do not help: {lacks}."
    return (
        f"Smooth the reference, or take plays, whose gain can be bounded, and which may err more: --max-inverse-gain "
        f"{0.9 * HIGH_GAIN / slope:.2g}."
    )


def _cure_of_gain(certificate: Certificate) -> str:
    if certificate.affordable_eps is not None:
        left = 1.0 / certificate.affordable_eps  # of the ratio of the ranges, right after a reversal
        still = f" It leaves up to {left:.0f} times." if is_high(left) else ""
        return (
            f"Identify with --eps {certificate.affordable_eps:.3g}, or --eps auto: it costs less than 5 % of the "
            f"accuracy of the fit.{still}"
        )
    if certificate.enough_eps is not None:
        return (
            f"--eps {certificate.enough_eps:.3g} would keep it below {HIGH_GAIN:g} times, but raises the error of the "
            f"fit by {100 * certificate.enough_eps_cost:.0f} %: take it where you can accept that, or smooth the "
            f"reference."
        )
    return (
        "No eps lowers it, the loop is as flat as that somewhere: stay clear of its flat end, or smooth the reference."
    )
