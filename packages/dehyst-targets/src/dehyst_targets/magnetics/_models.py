"""Core models of the literature and of simulators: Jiles and Atherton, Tellinen, Chan; their fits to a measured loop.

Jiles and Atherton, with the anhysteretic magnetisation M_an of the effective field H + alpha M::

    dM/dH = [ D + c dM_an/dH ] / (1 + c)        D = d (M_an - M)+ / (k - alpha |M_an - M|),  d = sgn dH
    M_an = M_s (coth x - 1/x), x = (H + alpha M)/a;   in PSpice M_an = M_s H/(|H| + a) and alpha = 0

D is zero where M would move against the field. Source: D. C. Jiles and D. L. Atherton, Theory of ferromagnetic
hysteresis, J. Magn. Magn. Mater. 61 (1986) 48-60. Tellinen: the slope of a branch of the limiting loop, times how far
the other branch is::

    dB/dH = mu_0 + (B_f - B)/(B_f - B_r) (B_r' - mu_0)  rising,  mu_0 + (B - B_r)/(B_f - B_r) (B_f' - mu_0)  falling

Source: S. Tellinen, A simple scalar model for magnetic hysteresis, IEEE Trans. Magn. 34 (1998) 2200-2206. Chan::

    B = B_s (H +- H_c)/(|H +- H_c| + H_c (B_s/B_r - 1)) + mu_0 H

Source: J. H. Chan et al., Nonlinear transformer model for circuit simulation, IEEE Trans. CAD 10 (1991) 476-482.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import IdentificationError
from dehyst_targets.magnetics._loop import MU_0, Core, enclosed, monotone_path, never_falling

STEPS = 100  # of an integration over the range of the field, at least
SAMPLES = 250  # of a loop for the search
STARTS = 24  # of the search
ROUNDS, BEST = (10, 30), 4  # of Levenberg and Marquardt: with all starts, with so many of the best
WEIGHT = 0.1  # a loss that is wrong by 10 % counts as much as B by 1 % of its range
NUDGE = 1e-5  # of a parameter's logarithm
LIMITS = np.log(  # of M_s, a, k, c and alpha M_s/3a, in shares of the largest M and H
    [[0.5, 100.0], [0.003, 50.0], [0.001, 20.0], [1e-4, 0.99], [1e-5, 0.97]]
)
ROWS = 100  # of a table


@dataclass(frozen=True)
class JilesAtherton:
    """Jiles' and Atherton's model.

    Attributes
    ----------
    ms, a, k
        Saturation magnetisation, shape and pinning. [A/m]
    c, alpha
        Reversible share and coupling. [-]
    pspice
        Whether the anhysteretic curve is that of PSpice; alpha is then 0.

    Examples
    --------
    >>> h = 200.0 * np.sin(np.linspace(0.0, 4.5 * np.pi, 2001))
    >>> b = JilesAtherton(3.5e5, 15.0, 20.0, 0.1, 5e-5).simulate(h, 0.0)
    >>> bool(0.38 < b.max() < 0.44)
    True
    """

    ms: float
    a: float
    k: float
    c: float
    alpha: float = 0.0
    pspice: bool = False

    def simulate(self, field: Array, first: float) -> Array:
        """Return B (T,) along H (T,), from a first B on. [T]"""
        parameters = np.array([[self.ms], [self.a], [self.k], [self.c], [self.alpha]])
        return _run(field, first, parameters, self.pspice)[:, 0]


def _run(field: Array, first: float, parameters: Array, pspice: bool) -> Array:
    """B (T, P) of many parameters (5, P) at once: Heun's method on steps that are short against the range."""
    fine, places = _finer(field)
    m = np.full(parameters.shape[1], first / MU_0 - fine[0])
    path = np.empty((fine.size, m.size))
    path[0] = m
    for i, step in enumerate(np.diff(fine).tolist()):
        # Pinning resists either way, so that its sign is that of the step.
        way = 1.0 if step >= 0.0 else -1.0
        slope = _slope(fine[i], m, way, parameters, pspice)
        after = _slope(fine[i + 1], m + step * slope, way, parameters, pspice)
        m = m + 0.5 * step * (slope + after)
        path[i + 1] = m
    return np.asarray(MU_0 * (field[:, None] + path[places]))


def _finer(field: Array) -> tuple[Array, Array]:
    """Return the field with further samples between, and where its own are."""
    longest = max(float(np.ptp(field)), 1e-300) / STEPS
    counts = np.maximum(np.ceil(np.abs(np.diff(field)) / longest), 1.0).astype(np.int64)
    places = np.concatenate(([0], np.cumsum(counts)))
    return np.interp(np.arange(places[-1] + 1), places, field), places


def _slope(h: float, m: Array, way: float, parameters: Array, pspice: bool) -> Array:
    """dM/dH, (P,)."""
    ms, a, k, c, alpha = parameters
    # Magnetised neighbours add to the field.
    effective = h + alpha * m
    if pspice:
        far = np.abs(effective) + a
        bent, rise = ms * effective / far, ms * a / far**2
    else:
        x = np.clip(effective / a, -300.0, 300.0)
        # Near zero coth x - 1/x is the small difference of two large numbers; x/3 is its first term.
        near = np.abs(x) < 1e-2
        x = np.where(near, 1.0, x)
        small = effective / a
        bent = ms * np.where(near, small / 3.0, 1.0 / np.tanh(x) - 1.0 / x)
        rise = ms / a * np.where(near, 1.0 / 3.0, 1.0 / x**2 - 1.0 / np.sinh(x) ** 2)
    # M never moves against the field: the susceptibility would be negative.
    away = np.maximum(way * (bent - m), 0.0)
    pull = away / np.maximum(k - alpha * away, 0.02 * k)
    return np.asarray((pull + c * rise) / (1.0 + c - c * alpha * rise))


@dataclass(frozen=True)
class Tellinen:
    """Tellinen's model, its limiting loop as tables of the polarisation B - mu_0 H.

    Attributes
    ----------
    field
        Increasing, (n,). [A/m]
    rising, falling
        Polarisation on both branches, (n,) each. [T]
    """

    field: Array
    rising: Array
    falling: Array

    @classmethod
    def of(cls, h: Array, b: Array) -> Tellinen:
        """Return the model whose limiting loop is a measured one, (T,) each, less smaller loops in it."""
        # A measured path may begin anywhere; its branches begin at the tips.
        start = int(np.argmin(h))
        h, j = np.roll(h, -start), np.roll(b - MU_0 * h, -start)
        top = int(np.argmax(h))
        up = _envelope(h[: top + 1], j[: top + 1])
        down = _envelope(-h[top:], -j[top:])
        # Rows are dense where a branch is steep.
        place = np.linspace(h.min(), h.max(), 20 * ROWS)
        rising, falling = np.interp(place, *up), -np.interp(-place, *down)
        size = max(float(np.ptp(j)), 1e-300)
        way = np.abs(np.diff(rising)) + np.abs(np.diff(falling))
        along = np.concatenate(([0.0], np.cumsum(way / size + 2.0 / place.size)))
        field = np.interp(np.linspace(0.0, along[-1], ROWS), along, place)
        lower = np.interp(field, place, rising)
        upper = np.maximum(np.interp(field, place, falling), lower)
        return cls(field, lower, upper)

    @property
    def gap(self) -> float:
        """What Modelica's element adds at either side, so that branches that meet stay apart. [T]

        It takes a thousandth of the last row, which is half of the swing where the loop is about zero.
        """
        return 5e-4 * float(np.ptp(self.rising))

    def simulate(self, field: Array, first: float) -> Array:
        """Return B (T,) along H (T,), from a first B on. [T]"""
        fine, places = _finer(field)
        low = np.interp(fine, self.field, self.rising) - self.gap
        high = np.interp(fine, self.field, self.falling) + self.gap
        rising = np.diff(fine) >= 0.0
        moves = np.where(rising, np.diff(low), np.diff(high))
        path = np.empty(fine.size)
        # A first B outside of the limiting loop would be on no branch.
        j = path[0] = float(np.clip(first - MU_0 * fine[0], low[0], high[0]))
        for i, move in enumerate(moves.tolist()):
            share = self._share(rising[i], j, low[i], high[i])
            after = self._share(rising[i], j + share * move, low[i + 1], high[i + 1])
            j = j + 0.5 * (share + after) * move
            path[i + 1] = j
        return np.asarray(MU_0 * field + path[places])

    @staticmethod
    def _share(rising: bool, j: float, low: float, high: float) -> float:
        if rising:
            return max(0.01, (high - j) / (high - low))
        return max(0.01, (j - low) / (high - low))


def _envelope(h: Array, j: Array) -> tuple[Array, Array]:
    """Return the samples of a rising branch that go farther than all before, their polarisation never falling."""
    farther = np.concatenate(([True], h[1:] > np.maximum.accumulate(h)[:-1]))
    return h[farther], never_falling(j[farther])


@dataclass(frozen=True)
class Chan:
    """Chan's limiting loop, as LTspice draws it: Hc [A/m], Br and Bs [T]."""

    hc: float
    br: float
    bs: float

    def branches(self, h: Array) -> tuple[Array, Array]:
        """Return B on the rising and on the falling branch, (T,) each. [T]"""
        parts = []
        for shifted in (h - self.hc, h + self.hc):
            bent = np.abs(shifted) + self.hc * (self.bs / self.br - 1.0)
            parts.append(self.bs * shifted / bent + MU_0 * h)
        return parts[0], parts[1]

    def simulate(self, field: Array, first: float) -> Array:
        """Return B on the branch that each sample is on; how LTspice leaves the limiting loop is not modelled."""
        rising, falling = self.branches(field)
        way = np.gradient(field)
        # A field that rests stays on its branch.
        moved = np.maximum.accumulate(np.where(way != 0.0, np.arange(way.size), 0))
        return np.where(way[moved] >= 0.0, rising, falling)


@dataclass(frozen=True)
class CoreFit:
    """A model of a core and its errors.

    Attributes
    ----------
    name
        As in tables.
    model
        `JilesAtherton`, `Tellinen` or `Chan`.
    error
        Rms over the largest loop less its noise (`Core.path`), share of the range of B.
    loss_error
        Its loss per cycle against that of the largest loop, a share.
    smaller_error
        Rms over all smaller loops, share of the range of B in each; NaN where there are none or it cannot.
    """

    name: str
    model: JilesAtherton | Tellinen | Chan
    error: float
    loss_error: float
    smaller_error: float


def fit_core(core: Core, *, seed: int = 0) -> dict[str, CoreFit]:
    """Fit every model to the largest loop of a core.

    Parameters
    ----------
    core
        Of `read_core` or `core_of`.
    seed
        Of the starts of the search.

    Returns
    -------
    dict
        "jiles-atherton", "pspice", "tellinen" and, where the loop is about zero, "chan".

    Raises
    ------
    IdentificationError
        If the loop has no width.

    Examples
    --------
    >>> from dehyst.data import Recording
    >>> h = 200.0 * np.sin(np.linspace(0.0, 5.0 * np.pi, 1500))
    >>> b = JilesAtherton(3.5e5, 15.0, 20.0, 0.1, 5e-5).simulate(h, 0.0)
    >>> from dehyst_targets.magnetics import core_of
    >>> fits = fit_core(core_of(Recording(h, b, input_unit="A/m", output_unit="T")))
    >>> fits["jiles-atherton"].error < 0.005, fits["tellinen"].error < 0.01
    (True, True)
    """
    h, b = core.path
    if not core.loss > 0.0:
        raise IdentificationError(
            "the loop encloses no area, so there is no hysteresis to fit. Use the curve of B over H as it is."
        )
    models: dict[str, tuple[str, JilesAtherton | Tellinen | Chan]] = {
        "jiles-atherton": ("Jiles-Atherton", _fitted(h, b, False, seed)),
        "pspice": ("Jiles-Atherton of PSpice", _fitted(h, b, True, seed)),
        "tellinen": ("Tellinen", Tellinen.of(h, b)),
    }
    # Both branches of Chan lie evenly about zero.
    if core.centred and core.hc > 0.0 and core.br > 0.0:
        models["chan"] = ("Chan", _chan(h, b, core))
    fits = {}
    for key, (name, model) in models.items():
        fits[key] = _judged(name, model, core)
    return fits


def _judged(name: str, model: JilesAtherton | Tellinen | Chan, core: Core) -> CoreFit:
    h, b = core.path
    modelled = model.simulate(h, float(b[0]))
    # Driven on, it comes to its own closed loop, which is that of the loss.
    again = model.simulate(np.tile(h, 4), float(b[0]))[-h.size :]
    loss = abs(enclosed(h, again))
    smaller = []
    if not isinstance(model, Chan):
        for loop in core.smaller:
            path = monotone_path(*loop.path)
            left = model.simulate(path[0], float(path[1][0])) - path[1]
            smaller.append(float(np.mean(left**2)) / float(np.ptp(path[1])) ** 2)
    size = float(np.sqrt(np.mean(smaller))) if smaller else float("nan")
    error = float(np.sqrt(np.mean((modelled - b) ** 2))) / float(np.ptp(b))
    return CoreFit(name, model, error, loss / abs(enclosed(h, b)) - 1.0, size)


def _areas(h: Array, b: Array) -> Array:
    """Areas (P,) of closed paths: H (T,), B (T, P)."""
    return np.asarray(0.5 * (h + np.roll(h, -1)) @ (np.roll(b, -1, axis=0) - b))


def _chan(h: Array, b: Array, core: Core) -> Chan:
    """Hc and Br as measured, the Bs that fits best beside them."""
    best = (float("inf"), Chan(core.hc, core.br, 2.0 * core.br))
    # Only one number is left, and a grid cannot miss its best value by much.
    for ratio in np.geomspace(1.02, 30.0, 300).tolist():
        model = Chan(core.hc, core.br, ratio * core.br)
        left = float(np.mean((model.simulate(h, 0.0) - b) ** 2))
        if left < best[0]:
            best = (left, model)
    return best[1]


def _fitted(h: Array, b: Array, pspice: bool, seed: int) -> JilesAtherton:
    """Levenberg and Marquardt over logarithms, from many starts at once; the loop is run on from its first sample."""
    rows = np.unique(np.linspace(0, h.size - 1, min(SAMPLES, h.size)).astype(np.int64))
    # The turning points decide the loop, so they stay.
    rows = np.unique(np.concatenate((rows, [int(np.argmin(h)), int(np.argmax(h))])))
    field, density = h[rows], b[rows]
    sizes = float(np.abs(b / MU_0 - h).max()), float(np.abs(h).max())
    area = float(_areas(field, density[:, None])[0])
    free = 4 if pspice else 5
    limits = LIMITS[:free]
    starts = np.random.default_rng(seed).uniform(limits[:, 0], limits[:, 1], (STARTS, free))

    def left(logs: Array) -> Array:
        """What is left of B (T, P) at logarithms (P, free), scaled."""
        with np.errstate(over="ignore", invalid="ignore"):
            modelled = _run(field, float(density[0]), _natural(logs, sizes), pspice)
        error = (modelled - density[:, None]) / np.ptp(density)
        loss = WEIGHT * np.sqrt(field.size) * (_areas(field, modelled) / area - 1.0)
        # What diverges is as wrong as can be, and still a number.
        return np.asarray(np.clip(np.nan_to_num(np.vstack((error, loss)), nan=1e3), -1e3, 1e3))

    # A few steps show which starts lead anywhere; only those are worth the rest.
    best = marquardt(left, starts, limits, ROUNDS[0])[:BEST]
    logs = marquardt(left, best, limits, ROUNDS[1])[0]
    ms, a, k, c, alpha = _natural(logs[None, :], sizes)[:, 0].tolist()
    return JilesAtherton(ms, a, k, c, alpha, pspice)


def _natural(logs: Array, sizes: tuple[float, float]) -> Array:
    """Parameters (5, P) of logarithms (P, 4 or 5)."""
    largest_m, largest_h = sizes
    values = np.exp(logs).T
    ms, a, k = values[0] * largest_m, values[1] * largest_h, values[2] * largest_h
    alpha = np.zeros_like(ms)
    if len(values) == 5:
        alpha = 3.0 * values[4] * a / ms
    return np.array([ms, a, k, values[3], alpha])


def marquardt(left: Callable[[Array], Array], starts: Array, limits: Array, rounds: int) -> Array:
    """Return where Levenberg's and Marquardt's method comes to from each start, (S, p), the best first.

    Parameters
    ----------
    left
        Residuals (T, P) of parameters (P, p).
    starts
        (S, p).
    limits
        (p, 2).
    rounds
        Steps of each.

    Examples
    --------
    >>> t = np.linspace(0.0, 1.0, 20)[:, None]
    >>> rise = lambda p: p[:, 0] * (1.0 - np.exp(-p[:, 1] * t)) - 2.0 * (1.0 - np.exp(-3.0 * t))
    >>> starts, limits = np.array([[1.0, 1.0], [4.0, 9.0]]), np.array([[0.1, 9.0], [0.1, 9.0]])
    >>> marquardt(rise, starts, limits, 30)[0].round(4).tolist()
    [2.0, 3.0]
    """
    here = np.array(starts)
    count, size = here.shape
    damping = np.full(count, 1e-2)
    residual = left(here)
    least = np.sum(residual**2, axis=0)
    for _ in range(rounds):
        nudged = (here[:, None, :] + NUDGE * np.eye(size)).reshape(-1, size)
        slopes = (left(nudged).reshape(-1, count, size) - residual[:, :, None]) / NUDGE
        square = np.einsum("tsi,tsj->sij", slopes, slopes)
        pull = np.einsum("tsi,ts->si", slopes, residual)
        diagonal = np.einsum("sii->si", square) + 1e-12
        square = square + (damping[:, None] * diagonal)[:, :, None] * np.eye(size)
        step = np.linalg.solve(square, pull[:, :, None])[:, :, 0]
        ahead = np.clip(here - step, limits[:, 0], limits[:, 1])
        new = left(ahead)
        error = np.sum(new**2, axis=0)
        # A step that made it worse is undone, and the next one is shorter.
        better = error < least
        here = np.where(better[:, None], ahead, here)
        residual = np.where(better, new, residual)
        least = np.where(better, error, least)
        damping = np.clip(np.where(better, damping / 4.0, damping * 4.0), 1e-9, 1e6)
    return np.asarray(here[np.argsort(least, kind="stable")])
