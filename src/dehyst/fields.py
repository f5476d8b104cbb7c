"""Reads parameter files into frozen dataclasses, whose fields declare unit, range and choices of each key.

A field is declared with its type and a `Key`, ``supply: Annotated[float, Key("bar", 1.0, 12.0)]``. Its key in the file
is its name and the unit, ``supply_bar``; the record holds SI. What a file may hold:

===========================  =========================================================================================
type of the field            in the file
===========================  =========================================================================================
``float``, ``int``           a finite number within the range of the `Key`; true and false are none
``str``, ``bool``            a printable text, one of the choices if there are any; true or false
``tuple[T, ...]``            a list of T; of tables, if T is a dataclass
a dataclass                  a table
``Mapping[str, T]``          tables by name, each a T; those of the choices if there are any. T = Any: unchecked
``Mapping[int, T]``          tables by number, each a T: from 1 on without a gap, or those of the choices
===========================  =========================================================================================

A field with a default, or that may be None, may be left out.
"""

from __future__ import annotations

import difflib
import math
import types
from collections.abc import Callable, Iterable, Mapping
from dataclasses import MISSING, dataclass, fields, is_dataclass
from functools import cache
from numbers import Real
from typing import Any, NamedTuple, TypeVar, Union, get_args, get_origin, get_type_hints

from dehyst.errors import ParameterError

T = TypeVar("T")
Plain = dict[str, Any]
LARGEST = 1e300  # beyond, numbers count as infinite
# what stands behind the name of a key -> factor to SI, as it is written elsewhere. Frequencies become angular: [rad/s].
UNITS: Mapping[str, tuple[float, str]] = {
    **{unit: (1.0, unit) for unit in ("", "m", "kg", "s", "K", "N", "Nm")},
    "Nm_s": (1.0, "Nm s"),
    "m_s": (1.0, "m/s"),
    "m_s2": (1.0, "m/s²"),
    "m_s3": (1.0, "m/s³"),
    "1_s": (1.0, "1/s"),
    "deg": (math.pi / 180.0, "deg"),
    "bar": (1e5, "bar"),
    "bar_rad": (1e5, "bar/rad"),
    "N_bar": (1e-5, "N/bar"),
    "1_bar": (1e-5, "1/bar"),
    "N_m": (1.0, "N/m"),
    "K_W": (1.0, "K/W"),
    "1_K": (1.0, "1/K"),
    "l": (1e-3, "l"),
    "l_per_m": (1e-3, "l/m"),
    "l_s_bar": (1e-3 / 1e5, "l/(s bar)"),
    "Hz": (2.0 * math.pi, "Hz"),
}


@dataclass(frozen=True)
class Key:
    """What a key of a file may hold.

    Attributes
    ----------
    unit
        Of the value in the file, one of `UNITS`; "" for none.
    low, high
        Ends of the range, both allowed, in that unit.
    least, most
        Number of values of a list, of letters of a text.
    choices
        Allowed words of a text; names of tables by name, all of which are needed. Empty: any.
    distinct
        Whether no value of a list may come twice.
    name
        Of the key, where it is not that of the field.
    """

    unit: str = ""
    low: float = -LARGEST
    high: float = LARGEST
    least: int = 1
    most: int = 64
    choices: tuple[str, ...] = ()
    distinct: bool = False
    name: str = ""


class Entry(NamedTuple):
    """One key of a table: the field it goes to, its type without None, what it may hold, whether it may be left out."""

    field: str
    kind: Any
    key: Key
    needed: bool
    optional: bool


@cache
def entries(table: type) -> Mapping[str, Entry]:
    """Return key of the file -> entry of a table.

    Examples
    --------
    >>> from dehyst.robot.arm.tables import Air
    >>> list(entries(Air))[:2], entries(Air)["supply_bar"].key.high
    (['supply_bar', 'ambient_bar'], 12.0)
    """
    found, hints = {}, get_type_hints(table, include_extras=True)
    for each in fields(table):
        kind = hints[each.name]
        key = next((one for one in getattr(kind, "__metadata__", ()) if isinstance(one, Key)), None)
        kind, key = (kind, Key()) if key is None else (get_args(kind)[0], key)
        optional = get_origin(kind) in (Union, types.UnionType)
        if optional:
            kind = next(one for one in get_args(kind) if one is not types.NoneType)
        needed = not optional and each.default is MISSING and each.default_factory is MISSING
        name = key.name or (f"{each.name}_{key.unit}" if key.unit else each.name)
        found[name] = Entry(each.name, kind, key, needed, optional)
    return found


def read(table: type[T], values: object, where: str, cure: str = "") -> T:
    """Check a table of a file and return its record, in SI.

    Parameters
    ----------
    table
        Dataclass that declares its keys.
    values
        Mapping from a TOML or JSON file.
    where
        Name of the file, for messages.
    cure
        What to do about missing keys other than adding them: ", or ...".

    Raises
    ------
    ParameterError
        If a key is unknown or missing, or a value cannot stand at its key.

    Examples
    --------
    >>> from dehyst.robot.arm.tables import Payload
    >>> read(Payload, {"mass_kg": 2}, "arm.toml")
    Payload(mass=2.0)
    >>> read(Payload, {"mass_kg": 200}, "arm.toml")
    Traceback (most recent call last):
    dehyst.errors.ParameterError: arm.toml: mass_kg = 200 is not a number from 0 to 100 kg, the unit of the key.
    """
    return record(table, checked(table, values, where, cure))


def checked(table: type, values: object, where: str, cure: str = "") -> Plain:
    """Check a table of a file and return it as plain numbers, texts, lists and tables, in the units of the file."""
    reading = _Reading(table, values, where)
    plain = reading.table(table, values, "")
    if missing := sorted(reading.missing):
        listed = ", ".join(missing[:12]) + (f" and {len(missing) - 12} more" if len(missing) > 12 else "")
        them = "it" if len(missing) == 1 else "them"
        raise ParameterError(f"{where} lacks {listed}. Add {them}{cure}.", missing=missing, source=where)
    return plain


def record(table: type[T], plain: Mapping[str, Any]) -> T:
    """Return the record, in SI, of a table that is `checked`."""
    made: Plain = {}
    for name, entry in entries(table).items():  # type: ignore[arg-type]
        if name in plain:
            made[entry.field] = _in_si(plain[name], entry.kind, UNITS[entry.key.unit][0])
        elif entry.optional:
            made[entry.field] = None
    return table(**made)


def dotted(table: type, values: object) -> list[str]:
    """Return every key, with its tables before it, that a file with the named tables of `values` may hold.

    Examples
    --------
    >>> from dehyst.robot.arm.tables import Tables
    >>> [key for key in dotted(Tables, {"muscle": {"big": {}}}) if key.endswith(".length_m")]
    ['muscle.big.length_m']
    """
    found: list[str] = []
    for name, entry in entries(table).items():
        inner = values.get(name) if isinstance(values, Mapping) else None
        form = _form(entry.kind)
        if form is dataclass:
            found += [f"{name}.{key}" for key in dotted(entry.kind, inner)]
        elif form is Mapping and _inner(entry.kind) is not Any:
            members = entry.key.choices or (map(word_of, inner) if isinstance(inner, Mapping) else ())
            found += [f"{name}.{member}.{key}" for member in members for key in dotted(_inner(entry.kind), None)]
        else:
            found.append(name)
    return found


def did_you_mean(word: object, known: Iterable[str]) -> str:
    """Return " Did you mean ...?" for a word that is not known, or nothing.

    Examples
    --------
    >>> did_you_mean("mechanisms.scale", ["hysteresis.scale", "air.supply_bar"])
    ' Did you mean hysteresis.scale?'
    """
    text, words = str(word)[:200], sorted(known)
    near = difflib.get_close_matches(text, words, 1, 0.5)
    if not near:  # the end of a key may be right and its table wrong
        near = [each for each in words if each.rpartition(".")[2] == text.rpartition(".")[2]][:3]
    return f" Did you mean {' or '.join(near)}?" if near else ""


def shown(value: object) -> str:
    """Return a value as it is typed, cut after sixty letters."""
    try:
        text = repr(value)
    except (ValueError, RecursionError):  # Python prints no number of more than 4300 digits
        return "(too long to be shown)"
    return text if len(text) <= 60 else text[:57] + "..."


def word_of(key: object) -> str:
    """Return a key as a text: from Python it may be anything."""
    return key if isinstance(key, str) else shown(key)


def schema_of(table: type, partial: bool = False) -> Plain:
    """Return the JSON Schema of a file, by which editors check and complete while one types; `partial` needs no key.

    Examples
    --------
    >>> from dehyst.robot.arm.tables import Payload
    >>> schema_of(Payload)["properties"]
    {'mass_kg': {'type': 'number', 'minimum': 0.0, 'maximum': 100.0}}
    """
    told = entries(table)
    return {
        "type": "object",
        "properties": {name: _schema(entry.kind, entry.key, partial) for name, entry in told.items()},
        "required": [name for name, entry in told.items() if entry.needed and not partial],
        "additionalProperties": False,
    }


class _Reading:
    """A file that is being read: what it is called, which keys it may have, and which it lacks."""

    def __init__(self, table: type, values: object, where: str) -> None:
        self.where, self.missing = where, list[str]()
        self._known: Callable[[], list[str]] = lambda: dotted(table, values)

    def refused(self, path: str, value: object, allowed: str, hint: str = "") -> ParameterError:
        """Return the error for a value that cannot stand at this key."""
        said = f"{path} = {shown(value)} is" if path else f"it is {shown(value)},"
        message = f"{self.where}: {said} not {allowed}.{hint}"
        return ParameterError(message, key=path, value=value, source=self.where)

    def table(self, table: type, values: object, path: str) -> Plain:
        """Return a table, checked."""
        mapping = self._mapping(values, path)
        told, before = entries(table), f"{path}." if path else ""
        for name, value in mapping.items():
            if name not in told:
                raise self._no_such(f"{before}{word_of(name)}", value, [f"{before}{key}" for key in told])
        found: Plain = {}
        for name, entry in told.items():
            form, at = _form(entry.kind), f"{before}{name}"
            if name in mapping or (entry.needed and form in (dataclass, Mapping)):
                found[name] = self.value(mapping.get(name, {}), entry.kind, entry.key, at)
            elif entry.needed:
                many = form is tuple and _form(_inner(entry.kind)) is dataclass
                self.missing.append(f"[[{at}]]" if many else at)
        return found

    def value(self, value: Any, kind: Any, key: Key, path: str) -> Any:
        """Return a value, checked."""
        form = _form(kind)
        if form is dataclass:
            return self.table(kind, value, path)
        if form is Mapping:
            return self._tables(value, kind, key, path)
        if form is tuple:
            return self._list(value, kind, key, path)
        if kind is Any or (kind is bool and isinstance(value, bool)):
            return value
        if kind is str and isinstance(value, str):
            length = key.least <= len(value.strip()) <= len(value) <= key.most
            if value in key.choices or (length and value.isprintable() and not key.choices):
                return value
        number = kind in (int, float) and isinstance(value, Real) and not isinstance(value, bool)
        if number and key.low <= value <= key.high and (kind is float or value % 1 == 0):  # in this order: 10**400
            return kind(value)
        hint = did_you_mean(value, key.choices) if isinstance(value, str) else ""
        raise self.refused(path, value, _allowed(kind, key), hint)

    def _mapping(self, value: object, path: str) -> Mapping[str, Any]:
        if isinstance(value, Mapping):
            return value
        raise self.refused(path, value, f"a table: write [{path}] and its keys below it" if path else "a table")

    def _tables(self, value: object, kind: Any, key: Key, path: str) -> Plain:
        mapping, inner = self._mapping(value, path), _inner(kind)
        if inner is Any:
            return dict(mapping)
        numbered = get_args(kind)[0] is int
        counted = tuple(str(n) for n in range(1, min(max(len(mapping), key.least), key.most) + 1))
        allowed = key.choices or (counted if numbered else ())
        for member in mapping:
            if not isinstance(member, str) or (allowed and member not in allowed):
                last = f", numbered without a gap up to {key.most} at most" if numbered and not key.choices else ""
                names = f"[{path}] has {', '.join(allowed)}{last}" if allowed else "a name is a text"
                at = f"{path}.{word_of(member)}"
                raise ParameterError(f"{self.where}: there is no {at}; {names}.", key=at, source=self.where)
        return {m: self.table(inner, mapping.get(m, {}), f"{path}.{m}") for m in allowed or sorted(mapping)}

    def _list(self, value: Any, kind: Any, key: Key, path: str) -> list[Any]:
        given, inner = value.tolist() if hasattr(value, "tolist") else value, _inner(kind)
        least, most = _lengths(kind, key)
        if isinstance(given, list | tuple) and least <= len(given) <= most:
            found = [self.value(each, inner, key, f"{path}[{k}]") for k, each in enumerate(given)]
            if not key.distinct or len(set(found)) == len(found):
                return found
        many = _form(inner) is dataclass
        raise self.refused(path, value, f"a list of tables: write [[{path}]]" if many else _allowed(kind, key))

    def _no_such(self, path: str, value: object, here: list[str]) -> ParameterError:
        leaf, inner = path, value
        for _ in range(4):  # the first key below a table that is not known says which one is meant
            if isinstance(inner, Mapping) and inner:
                below, inner = next(iter(inner.items()))
                leaf = f"{leaf}.{word_of(below)}"
        known = self._known()
        hint = did_you_mean(leaf, here) or did_you_mean(leaf, known) or did_you_mean(path, here)
        message = f"{self.where}: there is no key {shown(path)}.{hint} Known are: {', '.join(here)}."
        return ParameterError(message, key=path, source=self.where)


@cache
def _form(kind: Any) -> Any:
    """How a type is read: as a `dataclass`, a Mapping, a tuple, or as the plain value that it is."""
    return dataclass if is_dataclass(kind) else get_origin(kind) or kind


@cache
def _inner(kind: Any) -> Any:
    """What a list or a table by names holds."""
    return get_args(kind)[_form(kind) is Mapping]


def _lengths(kind: Any, key: Key) -> tuple[int, int]:
    """Least and most values of a list; tuple[T, T] has two."""
    size = len(get_args(kind))
    return (key.least, key.most) if Ellipsis in get_args(kind) else (size, size)


def _allowed(kind: Any, key: Key) -> str:
    """What may stand at a key, in words."""
    if _form(kind) is tuple:
        least, most = _lengths(kind, key)
        count = f"{least}" if least == most else f"{least} to {most}"
        return f"a list [..., ...] of {count}{' different' * key.distinct} values, each {_allowed(_inner(kind), key)}"
    if kind is str:
        letters = f"a printable text in quotes of {key.least} to {key.most} letters"
        return f"one of {', '.join(key.choices)}" if key.choices else letters
    if kind is bool:
        return "true or false"
    number = "a whole number" if kind is int else "a number"
    if key.high >= LARGEST:
        return number.replace(" ", " finite ", 1)
    unit = UNITS[key.unit][1]
    to = f"to {key.high:g}" if key.high < 1e15 else "on"
    return f"{number} from {key.low:g} {to}{f' {unit}, the unit of the key' if unit else ''}"


def _in_si(value: Any, kind: Any, factor: float) -> Any:
    if _form(kind) is dataclass:
        return record(kind, value)
    if _form(kind) is Mapping and _inner(kind) is not Any:
        return {get_args(kind)[0](member): record(_inner(kind), inner) for member, inner in value.items()}
    if _form(kind) is tuple:
        return tuple(_in_si(each, _inner(kind), factor) for each in value)
    return value * factor if kind is float else value


def _schema(kind: Any, key: Key, partial: bool) -> Plain:
    if _form(kind) is dataclass:
        return schema_of(kind, partial)
    if _form(kind) is Mapping:
        inner = {} if _inner(kind) is Any else schema_of(_inner(kind), partial)
        if get_args(kind)[0] is int and not key.choices:
            numbers = [str(n) for n in range(1, key.most + 1)]
            return {"type": "object", "properties": dict.fromkeys(numbers, inner), "additionalProperties": False,
                    "minProperties": 0 if partial else key.least}  # fmt: skip
        if not key.choices:
            return {"type": "object", "additionalProperties": inner}
        needed = [] if partial else list(key.choices)
        return {"type": "object", "properties": dict.fromkeys(key.choices, inner), "required": needed,
                "additionalProperties": False}  # fmt: skip
    if _form(kind) is tuple:
        least, most = _lengths(kind, key)
        return {"type": "array", "items": _schema(_inner(kind), key, partial), "minItems": least, "maxItems": most,
                "uniqueItems": key.distinct}  # fmt: skip
    if kind is str:
        told = {"enum": list(key.choices)} if key.choices else {"minLength": key.least, "maxLength": key.most}
        return {"type": "string", **told}
    if kind in (int, float):
        ends = {} if key.high >= LARGEST else {"minimum": key.low, "maximum": key.high}
        return {"type": "integer" if kind is int else "number", **ends}
    return {"type": "boolean"} if kind is bool else {}
