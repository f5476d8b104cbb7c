"""Parameters of the muscle models: tables of name, unit, bounds, source, meaning and default, and published sets.

A model declares one `parameter` a field and one `parameter_set` a set; reading, checking, fitting, printing and the
pages of the models go by these tables.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import Field, asdict, dataclass, field, replace
from inspect import cleandoc
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.models.arrays import parameter_array, parameter_number

AT_HAND = "assumption: of the muscle at hand"  # a source: measure it
REFUSED = "ParameterError\n    If a value has no physical meaning."
SECTION = re.compile(r"^\w[\w ]*\n-+$", re.M)  # of a docstring: a heading and its line


@dataclass(frozen=True)
class Parameter:
    """One parameter of a model: what the fit, the command line and the pages say about it.

    Attributes
    ----------
    name
        Of the field. A field that is a tuple counts as several values with the same bounds.
    unit
        SI, "1" for a number.
    low, high
        Bounds of a fit; not limits of the record.
    source
        Where the default comes from, and how sure it is.
    meaning
        In a few words.
    fitted
        Whether a fit changes it: not lengths and other facts of the muscle.
    """

    name: str
    unit: str
    low: float
    high: float
    source: str
    meaning: str
    fitted: bool = True


def parameter(
    default: Any, unit: str, low: float, high: float, source: str, meaning: str, fitted: bool = True,
    *, least: float | None = None,
) -> Any:  # fmt: skip
    """Return the field of a parameter: its default, and what a `Parameter` says of it behind its name.

    The record takes positive values where `least` is positive, values from 0 on where it is 0, and any where it is
    negative; without one `low` says so.
    """
    about = (unit, low, high, source, meaning, fitted)
    return field(default=default, metadata={"about": about, "least": low if least is None else least})


def length_row(default: float, source: str = AT_HAND, symbol: str = "l_0", low: float = 0.02) -> Any:
    """Return the row of l_0. [m]"""
    return parameter(default, "m", low, 10.0, source, f"{symbol}, length at rest", False)


def angle_row(default: float, source: str = AT_HAND, symbol: str = "theta_0", fitted: bool = True) -> Any:
    """Return the row of the angle between fibres and axis at rest. [rad]"""
    return parameter(default, "rad", 0.12, 0.94, source, f"{symbol}, fibre angle at rest", fitted)


def presliding_row() -> Any:
    """Return the row of the strain within which friction turns its sign after a reversal."""
    return parameter(1e-4, "1", 1e-6, 0.05, "assumption, numerical", "strain over which friction builds up", False)


class ParameterSet(NamedTuple):
    """A published parameter set: its name, its source, and what differs from the defaults."""

    name: str
    source: str
    values: Mapping[str, Any]


def parameter_set(name: str, source: str, **values: Any) -> ParameterSet:
    """Return a published set; the first one of a model has the defaults."""
    return ParameterSet(name, source, values)


class ParameterRecord:
    """A frozen record whose fields are declared by `parameter`.

    Attributes
    ----------
    name
        As typed on the command line.
    PUBLISHED
        Published sets, the first one that of the defaults.
    PARAMETERS
        Its parameters, in the order of the fields.
    SETS
        Published parameter sets: name -> source.
    """

    name: ClassVar[str] = ""
    PUBLISHED: ClassVar[tuple[ParameterSet, ...]] = ()
    PARAMETERS: ClassVar[tuple[Parameter, ...]] = ()
    SETS: ClassVar[Mapping[str, str]] = {}
    _LEAST: ClassVar[Mapping[str, float]] = {}  # see `parameter`

    def __init_subclass__(cls) -> None:
        """Collect what the fields say of the parameters, and write it into the docstring."""
        cls.SETS = {each.name: each.source for each in cls.PUBLISHED}
        told = {key: entry.metadata for key, entry in vars(cls).items() if isinstance(entry, Field)}
        if told:
            cls.PARAMETERS = tuple(Parameter(key, *about["about"]) for key, about in told.items())
            cls._LEAST = {key: about["least"] for key, about in told.items()}
            text = cleandoc(cls.__doc__ or "")
            place = SECTION.search(text)
            head, rest = (text[: place.start()].rstrip(), text[place.start() :]) if place else (text, "")
            rows = "\n".join(f"{each.name}\n    {each.meaning}. [{each.unit}]" for each in cls.PARAMETERS)
            raises = "" if "Raises\n" in rest else f"Raises\n------\n{REFUSED}\n\n"
            cls.__doc__ = f"{head}\n\nParameters\n----------\n{rows}\n\n{raises}{rest}"

    def __post_init__(self) -> None:
        """Take every number of the record, and refuse those that have no meaning."""
        for key, least in self._LEAST.items():
            value: Any = getattr(self, key)
            if isinstance(getattr(type(self), key), tuple):
                value = tuple(parameter_array(np.atleast_1d(value), key).tolist())  # one will do
                shown = f"{value}"
            else:
                value = parameter_number(value, key)
                shown = f"{value:g}"
            object.__setattr__(self, key, value)
            if least > 0 and not np.min(value) > 0:
                raise ParameterError(f"{key} = {shown} of {self.name} must be positive.", **{key: key})
            if least == 0 and np.min(value) < 0:
                raise ParameterError(f"{key} = {value} of {self.name} is negative; pass 0 or more.")

    @classmethod
    def published(cls, which: str = "") -> Self:
        """Return the model with a published parameter set, one of `SETS`; the first one if none is named.

        Raises
        ------
        ParameterError
            If there is no such set.

        Examples
        --------
        >>> from dehyst.robot.muscles import muscle_class
        >>> muscle_class("maker").published("DMSP-20").length
        0.25
        """
        for each in cls.PUBLISHED:
            if which in ("", each.name):
                return cls(**each.values)
        raise ParameterError(
            f"{cls.name} has no parameter set {which!r:.40}; there are: {', '.join(cls.SETS)}.", which=which
        )

    def as_dict(self) -> dict[str, Any]:
        """Return the parameters by name, as plain numbers and lists.

        Examples
        --------
        >>> from dehyst.robot.muscles import muscle
        >>> muscle("sarosi").as_dict()["a2"]
        369.27
        """
        return {key: list(value) if isinstance(value, tuple) else value for key, value in asdict(self).items()}  # type: ignore[call-overload]

    def vector(self) -> Array:
        """Return the fitted parameters, (n,): those of `PARAMETERS` that are `fitted`, tuples laid out.

        Examples
        --------
        >>> from dehyst.robot.muscles import muscle
        >>> muscle("maker").vector().round(3).tolist()
        [6398.4, 0.122, 10.471, 2.023]
        """
        return np.concatenate([np.zeros(0), *(np.atleast_1d(getattr(self, each.name)) for each in self._fitted)])

    def with_vector(self, vector: npt.ArrayLike) -> Self:
        """Return the model with other values of the fitted parameters, in the order of `vector`.

        Raises
        ------
        ParameterError
            If their number is wrong, or a value has no physical meaning.

        Examples
        --------
        >>> from dehyst.robot.muscles import muscle
        >>> muscle("maker").with_vector([6000.0, 0.12, 10.0, 2.0]).force
        6000.0
        """
        values, old = np.asarray(vector, float), {each.name: getattr(self, each.name) for each in self._fitted}
        if values.shape != self.vector().shape:
            raise ParameterError(f"{self.name} has {self.vector().size} fitted parameters, got {values.shape}.")
        parts = np.split(values, np.cumsum([np.size(value) for value in old.values()])[:-1])
        new = {
            key: tuple(part.tolist()) if isinstance(value, tuple) else float(part[0])
            for (key, value), part in zip(old.items(), parts, strict=False)
        }
        return replace(self, **new)  # type: ignore[type-var]

    def bounds(self) -> tuple[Array, Array]:
        """Return lower and upper bounds of `vector`, (n,) each."""
        sizes = [np.size(getattr(self, each.name)) for each in self._fitted]
        ends = [(each.low, each.high) for each in self._fitted]
        return np.repeat([low for low, _ in ends], sizes), np.repeat([high for _, high in ends], sizes)

    @property
    def _fitted(self) -> list[Parameter]:
        return [each for each in self.PARAMETERS if each.fitted]


def parameter_names(model: ParameterRecord) -> tuple[str, ...]:
    """Return the names of the entries of `ParameterRecord.vector`, (n,): ``a[0]``, ``a[1]`` for those of a tuple.

    Examples
    --------
    >>> from dehyst.robot.muscles import muscle
    >>> parameter_names(muscle("tondu-lopez"))[:2]
    ('radius', 'angle')
    """
    found: list[str] = []
    for entry in model._fitted:
        value = getattr(model, entry.name)
        found += [f"{entry.name}[{i}]" for i in range(len(value))] if isinstance(value, tuple) else [entry.name]
    return tuple(found)
