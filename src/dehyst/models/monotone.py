"""Monotone piecewise linear maps: the memoryless part of a modified Prandtl-Ishlinskii model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.models.arrays import parameter_array, signal_array, strictly_increasing


@dataclass(frozen=True, eq=False)
class MonotoneMap:
    r"""Strictly monotone, piecewise linear map v(u), continued along its end segments.

    Equal to Kuhnen's superposition of one-sided dead-zone operators,
    :math:`S[u] = v_m + \sum_i w_i S_{r_i}(u - u_m)`, with the slopes as partial sums of the weights; its inverse
    only swaps the two lists, which is exact.

    Parameters
    ----------
    u
        Breakpoints, (m,), m >= 2, strictly increasing.
    v
        Values, (m,), strictly increasing or strictly decreasing.

    Raises
    ------
    ParameterError
        If the map is not strictly monotone.

    Examples
    --------
    >>> bend = MonotoneMap([0.0, 1.0, 2.0], [0.0, 1.0, 1.5])
    >>> bend([0.5, 3.0]).tolist()
    [0.5, 2.0]
    >>> bend.inverse()([0.5, 2.0]).tolist()
    [0.5, 3.0]
    """

    u: Array
    v: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "u", parameter_array(self.u, "u"))
        object.__setattr__(self, "v", parameter_array(self.v, "v"))
        if self.u.size != self.v.size or self.u.size < 2:
            raise ParameterError(
                f"a map needs at least two breakpoints and as many values, got {self.u.size} and {self.v.size}.",
                u=self.u.size,
                v=self.v.size,
            )
        strictly_increasing(self.u, "u")
        strictly_increasing(self.v if self.increasing else -self.v, "v" if self.increasing else "-v")

    @property
    def increasing(self) -> bool:
        """Whether the map rises."""
        return bool(self.v[-1] > self.v[0])

    @property
    def slopes(self) -> Array:
        """Slopes of the segments, (m - 1,). [v/u]"""
        return np.diff(self.v) / np.diff(self.u)

    @property
    def inverse_gain(self) -> float:
        """Largest slope of the inverse map; infinite where a slope is too small for double precision. [u/v]"""
        flattest = float(np.min(np.abs(self.slopes)))
        return float("inf") if flattest == 0.0 else 1.0 / flattest

    def __call__(self, u: npt.ArrayLike) -> Array:
        """Return the values at u, (T,)."""
        return _native.map_values(self.u, self.v, signal_array(u, "u"))

    def file_parameters(self) -> dict[str, list[float]]:
        """Return breakpoints and values as plain JSON values."""
        return {"u": self.u.tolist(), "v": self.v.tolist()}

    def inverse(self) -> MonotoneMap:
        """Return the inverse map."""
        if self.increasing:
            return MonotoneMap(self.v, self.u)
        return MonotoneMap(self.v[::-1], self.u[::-1])

    @property
    def pairs(self) -> tuple[Array, Array]:
        """Breakpoints and values, as the core takes them."""
        return self.u, self.v
