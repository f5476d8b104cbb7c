"""Error of a ferrite's H from B over 105 sequences of which the first part is known, each fold foretold by the other.

    python benchmarks/sequences.py ../shared/data/magnet_3c90/sequences.npz

The file holds B [T], H [A/m], a row a sequence of 1000 samples, T [degC], and lstm_H, NaN where H is given: 3C90 of the
MagNet Challenge 2. It has no licence and stays outside of the project. The error of a sequence is rms(model - H) /
rms(H) over what is to be foretold. Steps: `identify`, which estimates starts, with and without relative errors; then
`model.after`; then eight terms in B and the sign of its rate, fitted to what the model misses in the known part, with a
prior. The size of the prior is the one that is best for the sequences that were fitted. The table of
docs/decisions/0074-starts-of-pieces.md; five minutes.
"""

from __future__ import annotations

import argparse
import time as clock
import warnings
from pathlib import Path

import numpy as np
import numpy.typing as npt

import dehyst
from dehyst.models.kit import known_past

Array = npt.NDArray[np.float64]
PRIORS = (0.02, 0.05, 0.1, 0.2)  # sizes of the eight terms, of rms(H) in the known part
NOISE = 0.03  # of rms(H); samples of a sequence are worth INDEPENDENT ones
INDEPENDENT = 20


def answers(model: dehyst.Model, b: Array, h: Array, warm: float, known: int) -> Array:
    """Return H along a sequence from the past that its known part tells, (T,)."""

    def signals(size: int) -> dict[str, Array]:
        return {name: np.full(size, warm) for name in model.needs}

    past = known_past(model, b[:known], h[:known], None, signals(known))
    first = past.before.simulate(b[:known], **signals(known))
    return np.concatenate([first, past.model.simulate(b[known:], **signals(b.size - known))])


def corrected(answer: Array, b: Array, h: Array, known: int, prior: float) -> Array:
    """Return the answer less what a line of eight terms explains of its miss in the known part."""
    u = 2.0 * (b - b.mean()) / np.ptp(b)
    rate = np.gradient(b)
    rate /= np.sqrt(np.mean(rate**2))
    side = np.tanh(rate)
    terms = prior * np.column_stack(
        [np.ones(b.size), u, side, rate, u**2, u**3, side * u, side * u**2]
    )
    size = float(np.sqrt(np.mean(h[:known] ** 2)))
    of_known = terms[:known]
    worth = INDEPENDENT / known / NOISE**2
    normal = worth * of_known.T @ of_known + np.eye(terms.shape[1])
    miss = (h - answer)[:known] / size
    return answer + size * (terms @ np.linalg.solve(normal, worth * of_known.T @ miss))


def error(answer: Array, h: Array, known: int) -> float:
    """Return the error of a sequence, percent."""
    miss = answer[known:] - h[known:]
    return 100.0 * float(np.sqrt(np.mean(miss**2) / np.mean(h[known:] ** 2)))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("data", type=Path)
    parser.add_argument("--family", default="full-sum")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    data = np.load(options.data)
    b, h, warm = data["B"], data["H"], data["T"]
    known = np.isfinite(data["lstm_H"]).argmax(axis=1)
    count, samples = b.shape
    print(
        "| errors | correction | mean | median | 95 % | numbers | s |\n|---|---|---|---|---|---|---|"
    )
    of_lstm = [error(data["lstm_H"][k], h[k], known[k]) for k in range(count)]
    print(row("LSTM", "", of_lstm, "", 0.0))
    for relative in (False, True):
        plain = np.zeros(count)
        trimmed = np.zeros(count)
        numbers = []
        begun = clock.perf_counter()
        for fold in (0, 1):
            records = []
            for k in range(fold, count, 2):
                schedules = {"T": np.full(samples, warm[k])}
                records.append(dehyst.Recording(b[k], h[k], schedules=schedules))
            fit = dehyst.identify(
                records, options.family, purpose="simulate", train_fraction=1.0, relative=relative
            )
            numbers.append(str(fit.model.free_parameters))
            of_fitted = dict.fromkeys(PRIORS, 0.0)
            foretold = {}
            for k in range(count):
                answer = answers(fit.model, b[k], h[k], float(warm[k]), known[k])
                if k % 2 != fold:
                    foretold[k] = answer
                    continue
                for prior in PRIORS:
                    better = corrected(answer, b[k], h[k], known[k], prior)
                    of_fitted[prior] += error(better, h[k], known[k])
            prior = min(PRIORS, key=lambda size: of_fitted[size])
            for k, answer in foretold.items():
                plain[k] = error(answer, h[k], known[k])
                better = corrected(answer, b[k], h[k], known[k], prior)
                trimmed[k] = error(better, h[k], known[k])
            numbers[-1] += f" (prior {prior:g})"
        seconds = clock.perf_counter() - begun
        name = "relative" if relative else "plain"
        print(row(name, "none", plain, ", ".join(numbers), seconds))
        print(row(name, "eight terms", trimmed, ", ".join(numbers), seconds), flush=True)


def row(name: str, correction: str, errors: npt.ArrayLike, numbers: str, seconds: float) -> str:
    """Return a row of the table."""
    mean, median, high = np.mean(errors), np.median(errors), np.percentile(errors, 95)
    cells = [
        name,
        correction,
        f"{mean:.2f}",
        f"{median:.2f}",
        f"{high:.1f}",
        numbers,
        f"{seconds:.0f}",
    ]
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    main()
