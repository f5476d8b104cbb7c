"""Parameters of the muscle models: tables of name, unit, bounds, source, meaning and default, and published sets.

Every model has a file, ``published/NAME.toml``. Reading, checking, fitting, printing and the pages of the models use
these tables.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from inspect import cleandoc
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.files import document_of, text_of
from dehyst.models import kit as models_kit
from dehyst_robot.fields import Key, read

FOLDER = Path(__file__).with_name("published")
REFUSED = "ParameterError\n    If a value has no physical meaning."
SECTION = re.compile(r"^\w[\w ]*\n-+$", re.M)  # of a docstring: a heading and its line
Sentence = Annotated[str, Key(most=300)]


@dataclass(frozen=True)
class Parameter:
    """One parameter of a model, as the fit, the command line and the pages use it.

    Attributes
    ----------
    name
        Of the field. A field that is a tuple counts as several values with the same bounds.
    default
        Its value in the first published set.
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
    least
        The record takes positive values where this is positive, values from 0 on where it is 0, and any where it is
        negative. None: `low` decides that.
    """

    name: str
    default: Any
    unit: str
    low: float
    high: float
    source: Sentence
    meaning: Sentence
    fitted: bool = True
    least: float | None = None


@dataclass(frozen=True)
class ParameterSet:
    """A published parameter set: its name, its source, and the values that differ from the defaults."""

    name: str
    source: Sentence
    values: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class _PublishedFile:
    """A file of a model's parameters."""

    parameters: tuple[Parameter, ...]
    sets: tuple[ParameterSet, ...]


class ParameterRecord:
    """A frozen record whose fields are the parameters of a file.

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

    def __init_subclass__(cls) -> None:
        """Read the parameters of a model that has a name: defaults of its fields, and a part of its docstring."""
        super().__init_subclass__()
        if "name" not in vars(cls):
            return
        file = FOLDER / f"{cls.name}.toml"
        if not file.is_file():
            return  # A model of the user's own: its numbers stand in the class.
        published = _read_published(file)
        cls.PARAMETERS = published.parameters
        cls.PUBLISHED = published.sets
        cls.SETS = {published_set.name: published_set.source for published_set in published.sets}
        for entry in cls.PARAMETERS:
            default = entry.default
            if isinstance(default, list):  # TOML knows no tuples
                default = tuple(default)
            setattr(cls, entry.name, default)
        cls.__doc__ = cls._documented(cleandoc(cls.__doc__ or ""))

    @classmethod
    def _documented(cls, text: str) -> str:
        """Return the docstring of a model with its parameters and errors before the first section."""
        section = SECTION.search(text)
        begin = len(text)
        if section:
            begin = section.start()
        rows = []
        for entry in cls.PARAMETERS:
            rows.append(f"{entry.name}\n    {entry.meaning}. [{entry.unit}]")
        table = "\n".join(rows)
        raises = ""
        if "Raises\n" not in text[begin:]:
            raises = f"Raises\n------\n{REFUSED}\n\n"
        head = text[:begin].rstrip()
        return f"{head}\n\nParameters\n----------\n{table}\n\n{raises}{text[begin:]}"

    def __post_init__(self) -> None:
        """Convert every number of the record, and refuse those without a physical meaning."""
        for entry in self.PARAMETERS:
            key = entry.name
            least = entry.least
            if least is None:
                least = entry.low
            value: Any = getattr(self, key)
            if isinstance(getattr(type(self), key), tuple):
                # A single number is a tuple of one.
                value = tuple(models_kit.parameter_array(np.atleast_1d(value), key).tolist())
                shown = f"{value}"
            else:
                value = models_kit.parameter_number(value, key)
                shown = f"{value:g}"
            object.__setattr__(self, key, value)
            if least > 0 and not np.min(value) > 0:
                raise ParameterError(
                    f"{key} = {shown} of {self.name} must be positive.", **{key: key}
                )
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
        >>> from dehyst_robot.muscles import muscle_class
        >>> muscle_class("maker").published("DMSP-20").length
        0.25
        """
        for published_set in cls.PUBLISHED:
            if which in ("", published_set.name):
                return cls(**published_set.values)
        raise ParameterError(
            f"{cls.name} has no parameter set {which!r:.40}; there are: {', '.join(cls.SETS)}.",
            which=which,
        )

    def as_dict(self) -> dict[str, Any]:
        """Return the parameters by name, as plain numbers and lists.

        Examples
        --------
        >>> from dehyst_robot.muscles import muscle
        >>> muscle("sarosi").as_dict()["a2"]
        369.27
        """
        values = asdict(self)  # type: ignore[call-overload]
        for key, value in values.items():
            if isinstance(value, tuple):
                values[key] = list(value)
        return dict(values)

    def vector(self) -> Array:
        """Return the fitted parameters, (n,): those of `PARAMETERS` that are `fitted`, tuples laid out.

        Examples
        --------
        >>> from dehyst_robot.muscles import muscle
        >>> muscle("maker").vector().round(3).tolist()
        [6398.4, 0.122, 10.471, 2.023]
        """
        parts = [np.zeros(0)]  # a model may have no fitted parameter
        for entry in self._fitted:
            parts.append(np.atleast_1d(getattr(self, entry.name)))
        return np.concatenate(parts)

    def with_vector(self, vector: npt.ArrayLike) -> Self:
        """Return the model with other values of the fitted parameters, in the order of `vector`.

        Raises
        ------
        ParameterError
            If their number is wrong, or a value has no physical meaning.

        Examples
        --------
        >>> from dehyst_robot.muscles import muscle
        >>> muscle("maker").with_vector([6000.0, 0.12, 10.0, 2.0]).force
        6000.0
        """
        values = np.asarray(vector, float)
        if values.shape != self.vector().shape:
            raise ParameterError(
                f"{self.name} has {self.vector().size} fitted parameters, got {values.shape}."
            )
        new: dict[str, Any] = {}
        begin = 0
        for entry in self._fitted:
            old = getattr(self, entry.name)
            end = begin + np.size(old)
            part = values[begin:end].tolist()
            new[entry.name] = tuple(part) if isinstance(old, tuple) else part[0]
            begin = end
        return replace(self, **new)  # type: ignore[type-var]

    def bounds(self) -> tuple[Array, Array]:
        """Return lower and upper bounds of `vector`, (n,) each."""
        low, high, sizes = [], [], []
        for entry in self._fitted:
            low.append(entry.low)
            high.append(entry.high)
            sizes.append(np.size(getattr(self, entry.name)))
        return np.repeat(low, sizes), np.repeat(high, sizes)

    @property
    def _fitted(self) -> list[Parameter]:
        return [entry for entry in self.PARAMETERS if entry.fitted]


def _read_published(file: Path) -> _PublishedFile:
    def refused(fault: str) -> ParameterError:
        return ParameterError(f"the parameter file '{file}' {fault}.")

    return read(_PublishedFile, document_of(text_of(file, refused), refused, "TOML"), file.name)


def parameter_names(model: ParameterRecord) -> tuple[str, ...]:
    """Return the names of the entries of `ParameterRecord.vector`, (n,): ``a[0]``, ``a[1]`` for those of a tuple.

    Examples
    --------
    >>> from dehyst_robot.muscles import muscle
    >>> parameter_names(muscle("tondu-lopez"))[:2]
    ('radius', 'angle')
    """
    names: list[str] = []
    for entry in model._fitted:
        value = getattr(model, entry.name)
        if isinstance(value, tuple):
            names += [f"{entry.name}[{i}]" for i in range(len(value))]
        else:
            names.append(entry.name)
    return tuple(names)
