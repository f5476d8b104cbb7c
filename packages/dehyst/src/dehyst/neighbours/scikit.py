"""A scikit-learn regressor around `dehyst.identify`. Order matters: a model with memory is no function of a row."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.data import Recording
from dehyst.errors import MissingExtraError, ParameterError
from dehyst.identification import identify

try:
    from sklearn.base import BaseEstimator, RegressorMixin
except ImportError as fault:
    raise MissingExtraError(
        f"a regressor needs the package scikit-learn, which is not installed ({fault}). Type: pip install "
        f"'dehyst[scikit]' - or call dehyst.identify.",
        extra="scikit",
    ) from None


class HysteresisRegressor(RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """Identify with `fit`, simulate with `predict`; rows are samples in the order of time.

    Shuffled folds, a random split or rows of several logs behind each other give a wrong memory, and with it wrong
    scores: split with `sklearn.model_selection.TimeSeriesSplit`. `predict` begins as the model says, not where the
    training ended. After `fit`, ``fit_`` is the `dehyst.Fit` with scores and findings, ``model_`` its model.

    Parameters
    ----------
    family, purpose
        As for `dehyst.identify`.
    dt
        Time between two rows; None for models without time. [s]

    Examples
    --------
    >>> from dehyst import PrandtlIshlinskii
    >>> x = 2 * np.sin(np.linspace(0, 40, 800)) * np.linspace(1, 0.3, 800)
    >>> y = PrandtlIshlinskii([0.0, 0.6], [1.0, 0.5]).simulate(x)
    >>> regressor = HysteresisRegressor(family="pi").fit(x[:, None], y)
    >>> bool(regressor.score(x[:, None], y) > 0.9999), regressor.get_params()["family"]
    (True, 'pi')
    """

    def __init__(
        self, family: str = "auto", purpose: str = "simulate", dt: float | None = None
    ) -> None:
        self.family, self.purpose, self.dt = family, purpose, dt

    def fit(self, X: npt.ArrayLike, y: npt.ArrayLike) -> Self:
        """Identify from an input (T, 1) and an output (T,); all rows are fitted, none held out."""
        u = _column(X)
        record = Recording(u, np.asarray(y, np.float64), self._time(u))
        # scikit-learn splits the data itself, so that nothing is held out here.
        self.fit_ = identify(record, self.family, purpose=self.purpose, train_fraction=1.0)
        self.model_, self.n_features_in_ = self.fit_.model, 1
        return self

    def predict(self, X: npt.ArrayLike) -> Array:
        """Return the model's output (T,) for an input (T, 1)."""
        u = _column(X)
        return np.asarray(self.model_.simulate(u, self._time(u)))

    def _time(self, u: Array) -> Array | None:
        if self.dt is None:
            return None
        return np.asarray(self.dt * np.arange(u.size), np.float64)


def _column(X: Any) -> Array:
    values = np.asarray(X, dtype=np.float64)
    if values.ndim != 2 or values.shape[1] != 1:
        raise ParameterError(
            f"X has shape {values.shape}: a hysteresis model has one input, a row for each sample in the order of "
            f"time. Pass X[:, [k]] or x.reshape(-1, 1).",
            shape=values.shape,
        )
    return values[:, 0]
