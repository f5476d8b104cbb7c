"""Another fit of the same data from sums that were kept: another n, eps or family in milliseconds."""

from __future__ import annotations

import time
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.data.recording import Recording
from dehyst.identification.build import build_model
from dehyst.identification.data import DataSet
from dehyst.identification.families import fit_family
from dehyst.identification.fit import Refit
from dehyst.identification.folds import output_knots
from dehyst.identification.levels import settled
from dehyst.identification.polish import polish
from dehyst.identification.regressors import Bank, make_bank
from dehyst.identification.scores import parts, score, simulated
from dehyst.identification.selection import REGULARISATIONS, Choice, threshold_grid
from dehyst.identification.settings import check_settings, paper_eps
from dehyst.identification.sums import NormalEquations, sums_of
from dehyst.identification.threads import single_blas
from dehyst.models import ModelCard

# Sums of more operators than this are made anew when they are asked for: they take more memory than a long log.
KEPT_OPERATORS = 2000
# As many sums are kept.
KEPT_SUMS = 8
# Thresholds this close, as a share of the half range, are the same.
SAME = 1e-12


@dataclass
class Refitter:
    """The data of a fit, scaled, and sums over them.

    Attributes
    ----------
    records, data, choice
        What was fitted, and the settings that won.
    operators, eps, given
        Settings of the fit: n, eps relative to the ratio of the ranges, thresholds or None. [input]
    """

    records: tuple[Recording, ...]
    data: DataSet
    choice: Choice
    operators: int
    eps: float
    given: Array | None
    _kept: list[tuple[Bank, bool, NormalEquations]] = field(default_factory=list)
    _done: dict[tuple[int | None, float | None, str | None] | None, Refit] = field(default_factory=dict)

    def keep(self, bank: Bank, sums: NormalEquations, ramps: bool) -> None:
        """Remember sums over the fitted samples, the last eight of them."""
        if bank.thresholds.size <= KEPT_OPERATORS:
            self._kept = [*self._kept[-KEPT_SUMS + 1 :], (bank, ramps, sums)]

    def __call__(self, n: int | None, eps: float | None, family: str | None, thresholds: npt.ArrayLike | None) -> Refit:
        """Fit once more with some settings changed; see `Fit.refit`."""
        begin = time.perf_counter()
        setting = (n, eps, family) if thresholds is None else None
        if setting in self._done:
            return self._done[setting]
        chosen = self.choice.family if family is None else family
        slope = self.data.amplitude / self.data.half_range if chosen == "pi" else 1.0
        asked = self.eps * slope if eps is None else eps
        given = check_settings(chosen, self.operators if n is None else n, asked, thresholds, self.choice.initial_state)
        if n is None and given is None:
            given = self.given
        operators = given.size if given is not None else int(self.operators if n is None else n)
        if eps is None:
            scaled = self.eps
        else:
            scaled = paper_eps(float(asked), self.records[0], self.data) if chosen == "pi" else float(asked)
        with single_blas():
            found = self._fit(chosen, operators, float(asked), scaled, given, begin)
        if setting is not None:
            self._done[setting] = found
        return found

    def _fit(self, family: str, operators: int, eps: float, scaled: float, given: Array | None, begin: float) -> Refit:
        data, start = self.data, self.choice.initial_state
        regularisation = None
        if family == "modified-pi":
            regularisation = self.choice.regularisation or REGULARISATIONS[-1]
        power = self.choice.power if family == self.choice.family else None
        choice = Choice(family, start, regularisation, power)
        knots = output_knots() if family == "modified-pi" else None
        bank, sums = self._sums(threshold_grid(data, operators, choice, given), knots)
        estimate = fit_family(
            family, sums, scaled, knots, regularisation, triangle=lambda: _triangle(data, bank, knots)
        )
        if knots is not None and regularisation is not None:
            estimate = polish(sums, scaled, knots, regularisation, estimate)
        model = build_model(estimate, data, bank, knots, ModelCard())
        outputs = simulated(self.records, data, settled(data, bank, model), model)
        train, test = (
            score(self.records, outputs, part, data.output_range) for part in parts(self.records, data, start)
        )
        if train is None:
            raise AssertionError("no training samples")  # the fit has checked
        return Refit(
            family, operators, eps, model, train, test, model.inverse_gain, model.nonzero_weights,
            estimate.kkt_residual, estimate.condition, estimate.route, time.perf_counter() - begin,
        )  # fmt: skip

    def _sums(self, grid: Array, knots: Array | None) -> tuple[Bank, NormalEquations]:
        """Sums of a grid: kept ones, those of a finer grid added up, or a pass over the data."""
        wanted = make_bank(self.data, grid, self.choice.initial_state)
        for bank, ramps, sums in reversed(self._kept):
            if knots is not None and not ramps:
                continue
            places = np.searchsorted(bank.thresholds, wanted.thresholds - SAME)
            if places[-1] >= bank.thresholds.size or np.unique(places).size < places.size:
                continue
            if np.max(np.abs(bank.thresholds[places] - wanted.thresholds)) > SAME:
                continue
            kept = np.zeros(bank.thresholds.size, dtype=np.bool_)
            kept[places] = True
            return wanted, sums if kept.all() else sums.coarser(kept)
        sums = sums_of(self.data, wanted, knots)
        self.keep(wanted, sums, knots is not None)
        return wanted, sums


def _triangle(data: DataSet, bank: Bank, knots: Array | None) -> Array:
    from dehyst.identification.orthogonal import reduce  # only where normal equations will not do

    return reduce(data, bank, knots)
