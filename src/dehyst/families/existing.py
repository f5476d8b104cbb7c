"""The families that `dehyst identify` knows, as rows of a comparison; and the curve without memory."""

from __future__ import annotations

import time

from dehyst.families.entry import Entry
from dehyst.families.registry import family
from dehyst.identification import Fit, identify, identify_direct
from dehyst.identification.scores import Part, score
from dehyst.recording import Recording

TITLES = {
    "static": "curve without memory",
    "pi": "Prandtl-Ishlinskii (the paper)",
    "pi-cumulative": "Prandtl-Ishlinskii, partial sums",
    "modified-pi": "modified Prandtl-Ishlinskii",
    "stop": "stop operators",
    "direct-inverse": "direct inverse",
}


def existing(
    name: str,
    records: tuple[Recording, ...],
    part: tuple[Part, Part],
    output_range: float,
    train_fraction: float | None,
) -> Entry:
    """Identify one of these families and score it on the samples of the comparison.

    Raises
    ------
    DehystError
        If it cannot be identified.
    """
    begun = time.thread_time()
    if name == "direct-inverse":
        return _direct(records, part, output_range, train_fraction, begun)
    fit = identify(records, name, train_fraction=train_fraction)
    return entry_of(fit, part, output_range, time.thread_time() - begun)


def entry_of(fit: Fit, part: tuple[Part, Part], output_range: float, seconds: float) -> Entry:
    """Return the row of a fit."""
    curve = sum(each.v.size for each in fit.model.maps if each is not None) or 1
    return Entry(
        family=fit.family,
        title=TITLES.get(fit.family) or family(fit.family).title,
        model=fit.model,
        predictions=fit.predictions,
        train=score(fit.recordings, fit.predictions, part[0], output_range),
        test=score(fit.recordings, fit.predictions, part[1], output_range),
        inverse_percent=fit.certificate.inverse_miss_percent,
        parameters=fit.certificate.nonzero_weights + curve,
        invertible=True,
        seconds=seconds,
        start=fit.certificate.initial_state,
    )


def static_of(fit: Fit, part: tuple[Part, Part], output_range: float) -> Entry:
    """Return the row of the curve without memory that every fit carries; it takes no time of its own."""
    curve = fit.static
    outputs = tuple(curve.simulate(record.input) for record in fit.recordings)
    demands = tuple(curve.inverse().simulate(record.output) for record in fit.recordings)
    inputs = [record.input for record in fit.recordings]
    low, high = min(float(x.min()) for x in inputs), max(float(x.max()) for x in inputs)
    seen = part[1] if part[1] else part[0]
    return Entry(
        family="static",
        title=TITLES["static"],
        model=curve,
        predictions=outputs,
        train=score(fit.recordings, outputs, part[0], output_range),
        test=score(fit.recordings, outputs, part[1], output_range),
        inverse_percent=100.0 * seen.moments(demands, inputs).rms / (high - low),
        parameters=curve.curve.v.size,
        invertible=True,
    )


def _direct(
    records: tuple[Recording, ...],
    part: tuple[Part, Part],
    output_range: float,
    train_fraction: float | None,
    begun: float,
) -> Entry:
    fit = identify_direct(records, train_fraction=train_fraction)
    return Entry(
        family="direct-inverse",
        title=TITLES["direct-inverse"],
        model=fit.model,
        predictions=fit.outputs,
        train=score(records, fit.outputs, part[0], output_range),
        test=score(records, fit.outputs, part[1], output_range),
        inverse_percent=(fit.test or fit.train).rmse_percent,
        parameters=fit.certificate.nonzero_weights + fit.model.polynomial.size,
        invertible=True,
        seconds=time.thread_time() - begun,
        start=fit.certificate.initial_state,
    )
