r"""Finds the resonance of an actuator in what a model of its loop leaves unexplained.

Smooth strokes hardly excite a resonance, so that no fit of one to input and output would tell it. But whatever is
rough on the way (relays that switch, corners, stick-slip) makes the output ring a little, and the spectrum of the
residual has a peak there:

.. math::

    P(f) = \frac{A}{(1 - f^2/f_0^2)^2 + (2 \zeta f/f_0)^2} + B + C \frac{f_0^2}{f^2}

Frequency and damping are those with the largest likelihood of the mean spectrum (P. Whittle 1953), noise and the slow
part of the residual beside them. Where the peak is what the resonance makes of the model's own output (corners of
triangles do that), they are those of the least squares through it.

A disturbance from outside (mains, a pump) makes a peak as well, but it does not care whether the actuator moves: only
what the model's output explains is a resonance, or what is clearly larger while the input moves or turns, or shortly
after. Nor is one what is smaller than the steps of the sensor, which make peaks where it is passed at constant speed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, Mask
from dehyst.data import POLICY as DATA_POLICY
from dehyst.data import Recording, range_over, turning_points
from dehyst.families import kit as families_kit
from dehyst.findings import Finding
from dehyst.identification._cautions import not_shaped, rings
from dehyst.identification._facts import spread
from dehyst.identification._fit import Fit
from dehyst.identification._policy import POLICY
from dehyst.models import Resonance

LONGEST_SEGMENT, SHORTEST_SEGMENT = 4096, 128  # samples
MOST_SEGMENTS = 200
PARTS = 8  # of a log, at least, have a spectrum of their own
HIGHEST = 4  # samples in a period of the highest frequency: two in half a swing, as a shaper needs
FASTER = 6.0  # than the strokes: slower peaks are harmonics of the strokes themselves
# A peak stands out of what lies between these times its frequency, on either side.
NEAR, FAR = 1.2, 1.6
SWINGS = 32  # in a segment that tells frequency and damping; longer ones would show the repetition of the strokes
FREQUENCIES = np.linspace(0.9, 1.1, 81)
DAMPINGS = np.geomspace(0.002, 0.4, 25)
HANN = np.array([1.0, 4.0, 1.0]) / 6.0  # power of the taper of a segment in neighbouring lines
WINDOW = 4.0  # swings, tapered, over which their size is a mean
FEWEST_WINDOWS = 16
UNEVEN = 0.1  # of a step of time
TINY = 1e-300


class Ringing(NamedTuple):
    """A resonance that a residual shows.

    Attributes
    ----------
    resonance
        Frequency and damping.
    size
        Of the swings, root mean square. [output]
    """

    resonance: Resonance
    size: float


def with_resonance(fit: Fit, resonance: Resonance | str | None) -> Fit:
    """Return a fit whose model knows the resonance of the actuator: one that is given, or what the fitted part shows.

    Parameters
    ----------
    fit
        As judged.
    resonance
        "auto": what the residual shows; None: none.
    """
    if resonance is None:
        return fit
    if isinstance(resonance, Resonance):
        peak = fit.residual.peak
        if peak is None or not peak.low <= resonance.frequency <= peak.high:
            return _knowing(fit, resonance, fit.warnings)
        return _knowing(fit, resonance, _without_peak(fit))
    shown = ringing(fit.recordings, fit.predictions, fit.train_masks)
    if shown is None:
        return fit
    low, high = range_over([record.output for record in fit.recordings])
    percent = 100.0 * shown.size / (high - low)
    return _knowing(fit, shown.resonance, _without_peak(fit), rings(shown.resonance, percent))


def _without_peak(fit: Fit) -> tuple[Finding, ...]:
    """What is known of a resonance takes the place of what was seen of a peak."""
    return tuple(finding for finding in fit.warnings if finding.code != "spectral-peak")


def _knowing(fit: Fit, resonance: Resonance, warnings: tuple[Finding, ...], *more: Finding) -> Fit:
    """Return a fit whose model knows a resonance, or that says why it does not; `more` is said where it does."""
    if not isinstance(fit.model, families_kit.ElementModel):
        return replace(fit, warnings=(*warnings, not_shaped(resonance, fit.family)))
    model = replace(fit.model, resonance=resonance)
    return replace(fit, model=model, warnings=(*warnings, *more))


class _Span(NamedTuple):
    """Residual, prediction and input (T,) of samples in succession."""

    error: Array
    predicted: Array
    x: Array


def ringing(
    recordings: Sequence[Recording], predictions: Sequence[Array], masks: Sequence[Mask]
) -> Ringing | None:
    """Return the resonance that the residual of a model shows; None where none is clear.

    Parameters
    ----------
    recordings
        The data; without time stamps, or unevenly sampled, nothing is told.
    predictions
        Output of the model for each, (T,). [output]
    masks
        Samples that count, (T,) each.
    """
    period = _period(recordings)
    spans = []
    for record, prediction, mask in zip(recordings, predictions, masks, strict=True):
        spans += _spans(record, prediction, mask)
    if not period or not spans:
        return None
    frequency = _peak(spans, period)
    if frequency is None:
        return None
    resonance, explained = _resonance(spans, period, frequency)
    if resonance.damping > POLICY.resonance_damping:
        return None
    sizes, by_motion = _sizes(spans, period, resonance)
    if not (explained or by_motion):
        return None
    size = float(np.sqrt(2.0 * np.mean(sizes)))
    steps = max(_step(record.output[mask]) for record, mask in zip(recordings, masks, strict=True))
    if size < steps * POLICY.resonance_step:
        return None
    return Ringing(resonance, size)


def _step(values: Array) -> float:
    """Return the step of a sensor: the usual difference of neighbouring values, 0 where most are met once. [output]"""
    levels = np.unique(values)
    if 2 * levels.size > values.size or levels.size < 2:
        return 0.0
    return float(np.median(np.diff(levels)))


def _period(recordings: Sequence[Recording]) -> float:
    """Return the time between samples, 0 where there is none or it changes. [s]"""
    steps = []
    for record in recordings:
        if record.time is None or record.time.size < SHORTEST_SEGMENT:
            return 0.0
        differences = np.diff(record.time)
        step = float(np.median(differences))
        # Breaks have steps of their own, and are few.
        if np.quantile(np.abs(differences - step), 0.99) > UNEVEN * step:
            return 0.0
        steps.append(step)
    if max(steps) - min(steps) > UNEVEN * min(steps):
        return 0.0
    return float(np.median(steps))


def _spans(record: Recording, prediction: Array, mask: Mask) -> list[_Span]:
    spans = []
    for piece in record.pieces:
        counted = np.concatenate([[False], mask[piece], [False]])
        edges = np.flatnonzero(counted[1:] != counted[:-1]) + piece.start
        for begin, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
            if end - begin >= 2 * SHORTEST_SEGMENT:
                part = slice(begin, end)
                error = record.output[part] - prediction[part]
                spans.append(_Span(error, prediction[part], record.input[part]))
    return spans


class _Spectra(NamedTuple):
    """Mean power of residual and prediction, and of the one times the conjugate of the other, (F,), of segments."""

    error: Array
    predicted: Array
    cross: npt.NDArray[np.complex128]
    segments: int


def _spectra(spans: Sequence[_Span], size: int) -> _Spectra:
    """Return mean spectra of tapered segments at whole numbers of cycles."""
    taper = _taper(size)
    whole = [span for span in spans if span.error.size >= size]
    most = MOST_SEGMENTS // max(1, len(whole)) + 1
    lines = size // 2 + 1
    error, predicted, number = np.zeros(lines), np.zeros(lines), 0
    cross = np.zeros(lines, dtype=np.complex128)
    for span in whole:
        for begin in spread(0, span.error.size - size + 1, most).tolist():
            part = slice(begin, begin + size)
            error_part, prediction = span.error[part], span.predicted[part]
            e = np.fft.rfft((error_part - error_part.mean()) * taper)
            # The slow motion is far larger than its corners: a line through its ends keeps it out of their spectrum.
            w = np.fft.rfft((prediction - np.linspace(prediction[0], prediction[-1], size)) * taper)
            error += np.abs(e) ** 2
            predicted += np.abs(w) ** 2
            cross += e * np.conj(w)
            number += 1
    per = 1.0 / max(1, number)
    return _Spectra(per * error, per * predicted, per * cross, number)


def _taper(size: int) -> Array:
    """Hann's window."""
    return np.asarray(0.5 - 0.5 * np.cos(2.0 * np.pi * (np.arange(size) + 0.5) / size))


def _peak(spans: Sequence[_Span], period: float) -> float | None:
    """Return the frequency of the highest peak above what lies beside it; None where none is clear. [Hz]"""
    samples = sum(span.error.size for span in spans)
    size = min(LONGEST_SEGMENT, max(span.error.size for span in spans) // PARTS)
    if size < SHORTEST_SEGMENT:
        return None
    spectra = _spectra(spans, size)
    power = spectra.error
    width = max(float(np.ptp(span.x)) for span in spans)
    turns = sum(turning_points(span.x, DATA_POLICY.turn_fraction * width).size for span in spans)
    strokes_frequency = 0.5 * (turns + 1) / samples  # cycles a sample
    lowest = max(4, int(np.ceil(FASTER * strokes_frequency * size)))
    highest = size // HIGHEST
    if spectra.segments < PARTS or lowest >= highest or not power.sum() > 0.0:
        return None
    log = np.log(power + TINY * power.max())
    best, top = -np.inf, 0
    for k in range(lowest, highest):
        height = float(log[k] - np.median(log[int(k / FAR) : int(k / NEAR) + 1]))
        # A median takes long, and few frequencies stand out of those below them.
        if height > best:
            above = log[int(k * NEAR) : int(k * FAR) + 1]
            height = min(height, float(log[k] - np.median(above)))
        if height > best:
            best, top = height, k
    if best < np.log(POLICY.resonance_peak):
        return None
    return top / (size * period)


def _resonance(spans: Sequence[_Span], period: float, near: float) -> tuple[Resonance, bool]:
    """Return frequency and damping of a peak, and whether the prediction explains it.

    Where it does, by least squares through it, else by the likelihood of the power alone.
    """
    enough = 2 ** int(np.ceil(np.log2(SWINGS / (near * period))))
    size = min(max(enough, SHORTEST_SEGMENT), max(span.error.size for span in spans) // 2)
    spectra = _spectra(spans, size)
    frequencies = np.arange(spectra.error.size) / (size * period)
    around = (frequencies > near / FAR) & (frequencies < near * FAR)
    at, power = frequencies[around], spectra.error[around] + TINY
    predicted, cross = spectra.predicted[around], spectra.cross[around]
    best, resonance = np.inf, Resonance(near, 0.0)
    for candidate, ratio in _candidates(near, at):
        added = _response(candidate, ratio) - 1.0
        missed = float(
            np.sum(power - 2.0 * np.real(np.conj(added) * cross) + np.abs(added) ** 2 * predicted)
        )
        if missed < best:
            best, resonance = missed, candidate
    if 1.0 - best / float(np.sum(power)) > POLICY.resonance_explained:
        return resonance, True
    best = np.inf
    for candidate, ratio in _candidates(near, at):
        misfit = _misfit(np.abs(_response(candidate, ratio)) ** 2, ratio, power)
        if misfit < best:
            best, resonance = misfit, candidate
    return resonance, False


def _candidates(near: float, at: Array) -> Iterator[tuple[Resonance, Array]]:
    """Resonances around a frequency, each with the ratios of frequencies (F,) to its own."""
    for frequency in near * FREQUENCIES:
        ratio = at / frequency
        for damping in DAMPINGS:
            yield Resonance(float(frequency), float(damping)), ratio


def _response(resonance: Resonance, ratio: Array) -> npt.NDArray[np.complex128]:
    """G at ratios (F,) of a frequency to that of the resonance."""
    return np.asarray(1.0 / (1.0 - ratio**2 + 2j * resonance.damping * ratio))


def _misfit(swing: Array, ratio: Array, power: Array) -> float:
    """Return Whittle's misfit of a swing, noise and a slow part to a power: a line has an exponential distribution."""
    smeared = np.convolve(np.concatenate([swing[:1], swing, swing[-1:]]), HANN, "valid")
    columns = np.stack([smeared, np.ones(ratio.size), 1.0 / ratio**2], axis=1)
    shares = np.linalg.lstsq(columns / power[:, None], np.ones(ratio.size), rcond=None)[0]
    model = columns @ np.maximum(shares, 0.0)
    if not np.all(model > 0.0):
        return np.inf
    return float(np.sum(np.log(model) + power / model))


def _sizes(spans: Sequence[_Span], period: float, resonance: Resonance) -> tuple[Array, bool]:
    """Return the squared size of the swings in windows, and whether it cares that the input moves."""
    window = int(np.ceil(WINDOW / (resonance.frequency * period)))
    decay = np.exp(-2.0 * np.pi * resonance.frequency * resonance.damping * window * period)
    swing = _taper(window) * np.exp(-2j * np.pi * resonance.frequency * period * np.arange(window))
    swing /= np.sum(_taper(window))
    sizes: list[Array] = []
    speeds: list[Array] = []
    turnings: list[Array] = []
    for span in spans:
        count = span.error.size // window
        if count < 2:
            continue
        error = span.error[: count * window].reshape(count, window)
        sizes.append(np.abs((error - error.mean(axis=1)[:, None]) @ swing) ** 2)
        speed = np.diff(span.x, prepend=span.x[0])
        turning = np.diff(speed, prepend=speed[0])
        for activity, change in ((speeds, speed), (turnings, turning)):
            moved = np.abs(change[: count * window]).reshape(count, window).mean(axis=1)
            activity.append(_lasting(moved, decay))
    size = np.concatenate([np.zeros(0), *sizes])
    if size.size < FEWEST_WINDOWS:
        return np.zeros(1), False
    for activity in (speeds, turnings):
        moved = np.concatenate(activity)
        # Logs rest for more than half of their time, or never: the stillest quarter, and what moves more than the mean.
        still, moving = moved <= np.quantile(moved, 0.25), moved > moved.mean()
        if not np.any(moving):
            continue
        if size[moving].mean() > POLICY.resonance_moves * max(float(size[still].mean()), TINY):
            return size, True
    return size, False


def _lasting(moved: Array, decay: float) -> Array:
    """Return what moves a swing in windows, (n,), or moved it before and is not damped out yet."""
    lasting = moved.copy()
    # What rings at the beginning of a window was moved in the one before.
    for k in range(1, moved.size):
        lasting[k] = max(moved[k], moved[k - 1], lasting[k - 1] * decay)
    return lasting
