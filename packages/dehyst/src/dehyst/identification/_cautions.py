"""Warnings about data and fit, each with its numbers and a cure."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from dehyst.data import Recording
from dehyst.findings import Finding
from dehyst.identification._conditions import at_one_speed, steeper, wider
from dehyst.identification._data import DataSet, all_timed
from dehyst.identification._families import STATIC, is_high
from dehyst.identification._fit import Certificate, ComparedSetting, LoopFacts, codes_of
from dehyst.identification._policy import POLICY
from dehyst.identification._residual import spectral_peak
from dehyst.identification._scores import Measured
from dehyst.identification._selection import AFFORDABLE
from dehyst.identification._settings import PAPER_EPS
from dehyst.models import Resonance
from dehyst.models import kit as models_kit
from dehyst.shell import command, quoted
from dehyst.units import parse_unit

# Findings that a model is poor, and those that may be why.
POOR = ("poor-fit", "inverse-misses")
REASONS = (
    "butterfly-loop", "rate-dependent", "drift", "two-actuators", "mixed-loop", "clockwise", "few-loops",
    "never-turns", "unknown-memory", "recordings-differ", "swapped-columns", "output-unrelated", "output-stopped",
    "output-late", "output-early", "held-out-worse", "extrapolation", "one-loop-size", "spectral-peak", "outlier",
    "saturated-input", "saturated-output", "held-input", "held-output", "undetermined-operators",
)  # fmt: skip
NO_REASON = (
    "No other finding says why. Something that was not logged may move the output too (load, temperature, supply), or "
    "no model here has a loop of this kind: the residual in the report shows where it misses."
)
# What hides a loop: while it is there, that a curve is as good says nothing about hysteresis.
HIDES = ("output-unrelated", "recordings-differ", "drift", "two-actuators")


@dataclass(frozen=True)
class Knows:
    """What a family can show beside plain hysteresis."""

    leads: bool = False  # Loops whose output leads the input
    crosses: bool = False  # Loops that lead in one part of the input and lag in another
    time: bool = False  # Rate and creep
    turns: bool = False  # Outputs that turn along a stroke


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
    if 10.0 <= times < 1e6:
        return f"{times:.0f} times"
    return f"{times:.2g} times"


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
        cure = " Identify with --family stop or auto."
        if knows.leads:
            cure = ""
        yield Finding(
            "clockwise",
            f"the loop runs clockwise (opening {loop.width_percent:.2g} % of the output's range): the output leads the "
            f"input, as force against displacement does. A Prandtl-Ishlinskii model with non-negative weights lags and "
            f"cannot show it; the stop form can. If this is an actuator's response, check that input and output are "
            f"not swapped.{cure}",
        )
    if loop.butterfly is not None:
        up, down = loop.butterfly
        cure = (
            "No model whose output rises with its input follows that. Identify with --family butterfly, and give its "
            "inverse one wing (--wing)."
        )
        if knows.turns:
            cure = (
                "This model follows that; it has an inverse on one wing alone, and compensates where the output need "
                "not turn: --wing upper or --wing lower of dehyst compensate."
            )
        words = (
            f"the loop is a butterfly: the output turns while the input goes on, near {up:.1g} on the way up and "
            f"near {down:.1g} on the way down, as the strain of a ferroelectric or a magnetostrictive rod does"
        )
        if loop.orientation == "none":
            words = (
                f"the output turns near {0.5 * (up + down):.1g} while the input goes on, without a loop: it is a "
                f"function of the input, but two inputs give one output"
            )
        yield Finding("butterfly-loop", f"{words}. {cure}")
    elif loop.orientation == "mixed" and not knows.crosses:
        yield Finding(
            "mixed-loop",
            "the loop runs clockwise over one part of the input and counter-clockwise over another. No "
            "Prandtl-Ishlinskii model does that; look at the loop in the report, and for a second moving part, a "
            "lagging sensor, or swapped columns.",
        )
    if (loop.rate_dependence_percent or 0.0) >= 100.0 * POLICY.rate_size and not knows.time:
        lacking = loop.lacking(*span)
        if lacking:
            lacking = f" {lacking[0].upper()}{lacking[1:]}."
        yield Finding(
            "rate-dependent",
            f"{' and '.join(loop.depends)}, on blocks held out: damping, creep, or a lagging sensor, which no "
            f"rate-independent model can follow. Take a family that knows them (--family auto looks for one), identify "
            f"at the speed of use, or align the delay of a sensor.{lacking}",
        )
    if drifts(data, change, doubt):
        yield Finding(
            "drift",
            f"the output drifts by {abs(loop.drift_percent):.1f} % of its range from the first to the last cycle at "
            f"the same input: warming, leakage or creep. The model is an average over it. Warm up before logging, or "
            f"leave out the first cycles (--from).",
        )
        if change > POLICY.other_actuator * data.output_range:
            yield Finding(
                "two-actuators",
                f"the output at the same input changes by {abs(loop.drift_percent):.0f} % of its range within the log: "
                f"no single model is both what the actuator was and what it became. Look at the residual in the "
                f"report, and identify the part of the log that is like the use (--from, --to).",
            )
    # A larger part can be fitted only where some of the log was held out.
    all_of_it = all(piece.split >= piece.x.size for piece in data.pieces)
    if loop.turns == 0:
        cure = "Fit all of it (--train-fraction 1), or log"
        if all_of_it:
            cure = "Log"
        yield Finding(
            "never-turns",
            "the input never turns within the training part: one branch of a loop cannot show hysteresis, and "
            f"what looks like memory is made up. {cure} complete loops, at least two if one is to be held out.",
        )
    elif loop.loops < 2:
        count = f"{loop.loops} complete loops"
        if loop.loops == 1:
            count = "1 complete loop"
        cure = ", or fit a larger part (--train-fraction)"
        if all_of_it:
            cure = ""
        yield Finding(
            "few-loops",
            f"the training part holds {count}: one loop cannot tell "
            f"hysteresis from drift or noise. Log at least three, of different size{cure}.",
        )
    if loop.motion.one_size:
        line = command("design", range=(f"{span[0]:.3g}", f"{span[1]:.3g}"))
        sizes = [f"{loop.motion.smallest:.0f}"]
        if f"{loop.motion.largest:.0f}" != sizes[0]:
            sizes.append(f"{loop.motion.largest:.0f}")
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
    return (
        change > POLICY.drift_size * data.output_range and change > POLICY.drift_certainty * doubt
    )


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
        unit = ""
        if first.input_unit:
            unit = f" {first.input_unit}"
        yield Finding(
            "undetermined-operators",
            f"{len(certificate.undetermined)} of {certificate.operators} operators never moved in the training part "
            f"(thresholds from {certificate.undetermined[0]:.4g}{unit} on): their weights are unknown and left zero. "
            f"Sweep the input further than that, or give fewer thresholds.",
        )
    if measured.beyond > POLICY.beyond:
        yield Finding(
            "extrapolation",
            f"the held-out input leaves the range that was fitted by {100 * measured.beyond:.0f} %: the test measures "
            f"extrapolation there. Fit a part that covers the whole range (--train-fraction, --from, --to).",
        )
    if measured.test is not None:
        pairs = zip(records, measured.test_masks, strict=True)
        held_out = np.concatenate([record.input[mask] for record, mask in pairs])
        covered = float(np.ptp(held_out)) / (2.0 * data.half_range)
        if covered < POLICY.small_test:
            yield Finding(
                "small-test",
                f"the {held_out.size} samples held out cover {100 * covered:.2g} % of the input's range: no loop, so "
                f"the error on them says little. Log more, without gaps, or fit a smaller part (--train-fraction).",
            )
    told_apart = [*_held_out(measured, turns), *_recordings_differ(data, measured, knows, leads)]
    yield from told_apart
    masks, scored, curve = measured.train_masks, measured.train, measured.static_train
    if measured.test:
        masks, scored = measured.test_masks, measured.test
    if measured.static_test:
        curve = measured.static_test
    peak = spectral_peak(records, measured.predictions, masks)
    if peak is not None and scored.rmse_percent * peak.share**0.5 > POLICY.peak_size:
        timed, shape = all_timed(records), ""
        if timed:
            shape = f" Or type it, if the actuator rings: --resonance {peak.frequency:.4g},0.02 shapes its references."
        yield Finding(
            "spectral-peak",
            f"{peak.words(timed)}, where the input hardly moves: a resonance that the motion rings, or a disturbance "
            f"of that frequency. No model of hysteresis follows it. Smooth the reference, filter that frequency out of "
            f"the measured output, or damp it.{shape}",
        )
    error = scored.rmse
    bar = curve.rmse
    # One branch is no loop: of that a curve is as good, and it says nothing.
    if turns and certificate.operators and error > POLICY.static_as_good * bar:
        hidden = codes_of(told_apart)
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
    # An inverse that misses should not be used at all, so its gain need not be spoken of. One without a bound is none.
    misses = certificate.inverse_miss_percent > POLICY.inverse_misses
    if np.isfinite(gain) and is_high(gain) and not misses:
        units = ""
        if paper:
            units = _of_units(slope)
        cure = _cure_of_gain(certificate)
        if knows.crosses:
            cure = _cure_of_terms(measured, leads, slope)
        yield Finding(
            "high-inverse-gain",
            f"right after a reversal the inverse may ask for {certificate.inverse_gain:.4g}{unit_of_gain(first)} "
            f"({gain:.0f} times as much as over the whole range): noise on its input becomes steps of its output. "
            f"{units}{cure}",
        )
    if np.isfinite(gain) and gain > POLICY.useless_gain and not misses:
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
    if percent > POLICY.poor_percent:
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


def _recordings_differ(
    data: DataSet, measured: Measured, knows: Knows, leads: bool
) -> Iterator[Finding]:
    """What differs between recordings beside their motion, and which columns may say why."""
    records, compared = measured.recordings, measured.conditions
    apart = measured.levels_apart / data.output_range
    differences = []
    # A model that goes with another signal was told why its gain and its loop change.
    scheduled = bool(records[0].schedules)
    if apart > POLICY.levels_apart:
        differences.append(
            f"their outputs lie up to {100 * apart:.0f} % of range apart at the same input"
        )
    if steeper(compared) and not scheduled:
        least = min(compared, key=lambda condition: condition.gain)
        most = max(compared, key=lambda condition: condition.gain)
        differences.append(
            f"the gain of {most.name} is {most.gain / max(least.gain, 1e-9):.2g} times that of {least.name}"
        )
    # Speed widens a loop too, unless the model knows of it.
    if wider(compared) and not scheduled and (knows.time or at_one_speed(records)):
        least = min(compared, key=lambda condition: condition.width)
        most = max(compared, key=lambda condition: condition.width)
        differences.append(
            f"the branches of the loop are {most.width_percent:.2g} % of range apart in {most.name} and "
            f"{least.width_percent:.2g} % in {least.name}, in the mean over the input that they share"
        )
    if not differences:
        return
    held_out = []
    for record, mask in zip(records, measured.test_masks, strict=True):
        if mask.all():
            held_out.append(record.name)
    tested = ""
    if held_out:
        tested = f" Held out: {', '.join(held_out)}."
    yield Finding(
        "recordings-differ",
        f"the recordings are not of one condition: {'; '.join(differences)}. A zero, a load, a temperature or another "
        f"signal that {'this model does not go with' if scheduled else 'no model was told'} does that, and one model "
        f"averages over it.{tested} {_schedule(records)}",
    )


def _schedule(records: Sequence[Recording]) -> str:
    """Which columns differ between recordings and stand still within, and what can be done with them."""
    stills = [record.provenance.get("stills") or {} for record in records]
    apart = "Identify each recording by itself, or align the zeros where only the level differs."
    ranges = []
    options = []
    for name in stills[0]:
        if parse_unit(name)[0] in records[0].schedules or name in records[0].schedules:
            continue
        values = [still[name] for still in stills if name in still]
        # A column that one recording lacks, or that is the same in all of them, explains nothing.
        if len(values) < len(stills) or len(set(values)) == 1:
            continue
        ranges.append(f"{name} ({min(values):.4g} to {max(values):.4g})")
        options.append(f"--schedule {quoted(name)}")
    if not ranges:
        return f"If a column of the logs says what it is, look there. {apart}"
    differ = "differ"
    if len(ranges) == 1:
        differ = "differs"
    looks = f"Between them {', '.join(ranges)} {differ}."
    return f"{looks} A model whose weights go with it: {options[0]}."


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
    elif (
        turns
        and test.rmse > POLICY.worse * train.rmse
        and test.rmse_percent > POLICY.worse_percent
        and measured.beyond <= POLICY.beyond
    ):
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
    reasons = dict.fromkeys(finding.code for finding in findings if finding.code in REASONS)
    why = NO_REASON
    if reasons:
        why = f"What may be the reason: {', '.join(reasons)}."
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
    return min(test.nrmse, static.nrmse) > 1.0 and measured.train.nrmse > POLICY.unrelated


def _levels(data: DataSet, start: str) -> Iterator[Finding]:
    """Pieces that count with a level of their own."""
    pieces = [piece for piece in data.pieces if piece.unknown_level(start)]
    fitted = held_out = 0
    for piece in pieces:
        for_fit, for_test = piece.fitted(start), piece.held_out(start)
        fitted += max(for_fit.stop - for_fit.start, 0)
        held_out += max(for_test.stop - for_test.start, 0)
    if fitted + held_out:
        count = f"{len(pieces)} pieces after gaps go"
        if len(pieces) == 1:
            count = "a piece after a gap goes"
        yield Finding(
            "unknown-level",
            f"{count} over the whole range of the input late or never. What the actuator remembers of wider loops is "
            f"unknown there, and shifts the output by a constant. Of {fitted} fitted and {held_out} held-out samples "
            f"the mean error of their piece was taken off, as far as the model's memory can explain it. A zero that "
            f"shifted may hide in that constant. Log without gaps, or begin each piece with a full loop.",
        )


def late(time: float, unit: str, percent: tuple[float, float], taken: float) -> Finding:
    """What to say where one column is late: by how much, what sums err as logged and shifted, percent of range.

    `taken`: so much of it the model has as its dead time, in the same unit.
    """
    shifted = (
        f"with it shifted by that the model misses blocks left out by {percent[1]:.2g} % of range, as logged by "
        f"{percent[0]:.2g} %"
    )
    if time < 0.0:
        return Finding(
            "output-early",
            f"the output column is about {_span(-time, unit)} early: {shifted}. No actuator answers before it is "
            f"asked, so the input was logged late, by a filter, a bus or another clock. Log both by one clock and "
            f"unfiltered, or move the input column ahead by that time and identify again.",
        )
    cure = "If the logging does it, log both by one clock and unfiltered, or move the column."
    if taken > 0.0:
        part = "" if taken >= time else f" {_span(taken, unit)} of"
        cure = (
            f"The model has{part} it as its dead time: `dehyst compensate` sends each value that much before its time, "
            f"and an exported compensator wants its reference that much ahead. If a sensor is late and not the "
            f"actuator, keep the model and send nothing ahead (`dehyst compensate --ahead 0`). If the actuator is, and "
            f"nobody knows the reference before it is due, identify with --ahead 0."
        )
    elif unit != "s":
        cure = (
            "The model has no dead time, since the log has no time: name the time column (--time), or the seconds "
            "from row to row (--dt). If the logging does it, move the column."
        )
    return Finding(
        "output-late",
        f"the output column is about {_span(time, unit)} late: {shifted}. A dead time (transport, a bus, two clocks) "
        f"does that, and a lag of a sensor or a filter; the log does not tell which. {cure}",
    )


def rings(resonance: Resonance, percent: float) -> Finding:
    """What to say of a resonance that the residual shows, of a size in percent of the output's range, rms."""
    return Finding(
        "resonance",
        f"the output rings at {resonance.frequency:.4g} Hz (damping {resonance.damping:.2g}, {percent:.2g} % of range "
        f"rms) while the input moves, and no model of hysteresis follows that. The compensator does not excite it: it "
        f"splits its reference into two parts, {_span(resonance.half_swing, 's')} apart, whose swings cancel. `dehyst "
        f"compensate` does that, and so does an exported compensator, which wants its reference "
        f"{_span(resonance.lead, 's')} ahead. If it is known better, type --resonance HZ,DAMPING; to leave the "
        f"reference as it is, --resonance none.",
    )


def not_shaped(resonance: Resonance, family: str) -> Finding:
    """What to say of a resonance where the model's family has no place for one."""
    return Finding(
        "resonance-not-shaped",
        f"the actuator rings at {resonance.frequency:.4g} Hz (damping {resonance.damping:.2g}), and a {family} model "
        f"does not know it: its compensator excites it at every corner of the reference. Smooth the reference over "
        f"{_span(2.0 * resonance.half_swing, 's')}, or take a row of elements (--family full-sum), which does.",
    )


def _span(time: float, unit: str) -> str:
    """A time in two digits, with its unit."""
    if unit == "s" and time < 1.0:
        return f"{float(f'{1000.0 * time:.2g}'):g} ms"
    return f"{float(f'{time:.2g}'):g} {unit}"


def plays_only(cause: str, cure: str) -> Finding:
    """Say that auto chose among plays alone, why, and what to do for more."""
    return Finding(
        "plays-only",
        f"auto chose among plays and the curve only, as {cause}: models with creep, rate or maps, which often err "
        f"less, were not tried. {cure}.",
    )


def no_hysteresis(
    candidates: tuple[ComparedSetting, ...],
    span: tuple[float, float],
    codes: Collection[str],
    loop: LoopFacts,
) -> Finding:
    """What to say where a curve is the answer, on a log whose input has the range `span`.

    `codes` are those of the other findings, one of which may be why.
    """
    curves = []
    with_memory = []
    for setting in candidates:
        if setting.family == STATIC:
            curves.append(setting)
        else:
            with_memory.append(setting)
    curve = curves[0]
    best = min(with_memory, key=lambda setting: setting.error_percent)
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
            f"a loop is there, opening {loop.width_percent:.2g} % of range, but no model foretells the parts of it "
            f"that were left out, so the model is the curve: too little of the loop repeats, or it is of another kind. "
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
    unit = ""
    if first.output_unit and first.input_unit:
        unit = f" {first.output_unit}/{first.input_unit}"
    return Finding(
        "paper-bound",
        f"the paper's bound w_1 >= 0.001{unit} is {of_range(100 * PAPER_EPS / slope)} the mean slope of this log, "
        f"{slope:.3g}{unit}, and makes the error of the fit {1.0 + strain:.3g} times as large as a bound of a "
        f"thousandth of that slope does: it is absolute, so the model depends on the units. Identify with --eps auto, "
        f"which is relative, or with --eps {0.001 * slope:.1g}.",
    )


def unit_of_gain(record: Recording) -> str:
    """Return the unit of the inverse's slope behind a space, or nothing."""
    if record.input_unit and record.output_unit:
        return f" {record.input_unit}/{record.output_unit}"
    return ""


def _of_units(slope: float) -> str:
    return (
        f"The paper's bound w_1 >= 0.001 is absolute; in the units of this log it is "
        f"{of_range(100 * PAPER_EPS / slope)} the mean slope. "
    )


def _cure_of_terms(measured: Measured, leads: bool, slope: float) -> str:
    """What lowers the gain of a sum of elements, which has no eps: plays, where they can show the loop."""
    depends = [evidence.words for evidence in measured.evidence if evidence.there]
    depends += measured.recordings[0].schedules
    if leads or depends:
        lacks = "this loop runs clockwise"
        if depends:
            lacks = f"this log depends on {' and '.join(depends)}"
        return f"Smooth the reference. Plays, whose gain can be bounded, do not help: {lacks}."
    return (
        f"Smooth the reference, or take plays, whose gain can be bounded, and which may err more: --family auto "
        f"--max-inverse-gain {0.9 * models_kit.POLICY.high_gain / slope:.2g}."
    )


def _cure_of_gain(certificate: Certificate) -> str:
    if certificate.affordable_eps is not None:
        # Right after a reversal the inverse's gain is at most this many times the ratio of the ranges.
        left = 1.0 / certificate.affordable_eps
        still = ""
        if is_high(left):
            still = f" It leaves up to {left:.0f} times."
        return (
            f"Identify with --eps {certificate.affordable_eps:.3g}, or --eps auto: it costs less than 5 % of the "
            f"accuracy of the fit.{still}"
        )
    if certificate.enough_eps is not None:
        bound = f"--eps {certificate.enough_eps:.3g} would keep it below {models_kit.POLICY.high_gain:g} times"
        cost = f"{100 * certificate.enough_eps_cost:.0f} %"
        return (
            f"{bound}, but raises the error of the fit by {cost}: take it where you can accept that, or smooth the "
            f"reference."
        )
    return (
        "No eps lowers it, the loop is as flat as that somewhere: stay clear of its flat end, or smooth the "
        "reference."
    )
