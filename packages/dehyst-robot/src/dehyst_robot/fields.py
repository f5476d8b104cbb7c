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

import math
import types
from collections.abc import Callable, Iterable, Mapping
from dataclasses import MISSING, dataclass, fields, is_dataclass
from functools import cache
from numbers import Real
from typing import Any, NamedTuple, TypeVar, Union, get_args, get_origin, get_type_hints

from dehyst.errors import ParameterError
from dehyst.shell import did_you_mean

T = TypeVar("T")
Plain = dict[str, Any]
LARGEST = 1e300  # beyond, numbers count as infinite
# Unit at the end of a key -> its factor to SI, and how texts write it. Frequencies become angular: [rad/s].
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
    """One key of a table: its field, its type without None, what it may hold, whether a file must have it."""

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
    >>> from dehyst_robot.arm._tables import Air
    >>> list(entries(Air))[:2], entries(Air)["supply_bar"].key.high
    (['supply_bar', 'ambient_bar'], 12.0)
    """
    hints = get_type_hints(table, include_extras=True)
    entry_of_key = {}
    for field in fields(table):
        kind, key = _declared(hints[field.name])
        optional = get_origin(kind) in (Union, types.UnionType)
        if optional:
            kind = _without_none(kind)
        needed = not optional and field.default is MISSING and field.default_factory is MISSING
        entry_of_key[_key_name(field.name, key)] = Entry(field.name, kind, key, needed, optional)
    return entry_of_key


def _declared(hint: Any) -> tuple[Any, Key]:
    """Return the type of a field and its `Key`; a field without one may hold anything of its type."""
    for metadata in getattr(hint, "__metadata__", ()):
        if isinstance(metadata, Key):
            return get_args(hint)[0], metadata
    return hint, Key()


def _without_none(kind: Any) -> Any:
    for member in get_args(kind):
        if member is not types.NoneType:
            return member
    raise TypeError(f"{kind} declares a field that is always None")


def _key_name(field: str, key: Key) -> str:
    if key.name:
        return key.name
    if key.unit:
        return f"{field}_{key.unit}"
    return field


def read(table: type[T], values: object, source: str, cure: str = "") -> T:
    """Check a table of a file and return its record, in SI.

    Parameters
    ----------
    table
        Dataclass that declares its keys.
    values
        Mapping from a TOML or JSON file.
    source
        Name of the file, for messages.
    cure
        What to do about missing keys other than adding them: ", or ...".

    Raises
    ------
    ParameterError
        If a key is unknown or missing, or a value cannot stand at its key.

    Examples
    --------
    >>> from dehyst_robot.arm._tables import Payload
    >>> read(Payload, {"mass_kg": 2}, "arm.toml")
    Payload(mass=2.0)
    >>> read(Payload, {"mass_kg": 200}, "arm.toml")
    Traceback (most recent call last):
    dehyst.errors.ParameterError: arm.toml: mass_kg = 200 is not a number from 0 to 100 kg, the unit of the key.
    """
    return record(table, checked_table(table, values, source, cure))


def checked_table(table: type, values: object, source: str, cure: str = "") -> Plain:
    """Check a table of a file and return it as plain numbers, texts, lists and tables, in the units of the file."""
    reading = _Reading(table, values, source)
    plain = reading.table(table, values, "")
    if missing := sorted(reading.missing):
        listed = ", ".join(missing[:12])
        if len(missing) > 12:
            listed += f" and {len(missing) - 12} more"
        them = "them"
        if len(missing) == 1:
            them = "it"
        raise ParameterError(
            f"{source} lacks {listed}. Add {them}{cure}.", missing=missing, source=source
        )
    return plain


def record(table: type[T], plain: Mapping[str, Any]) -> T:
    """Return the record, in SI, of a table that is `checked_table`."""
    values: Plain = {}
    for name, entry in entries(table).items():  # type: ignore[arg-type]
        if name in plain:
            values[entry.field] = _in_si(plain[name], entry.kind, UNITS[entry.key.unit][0])
        elif entry.optional:
            values[entry.field] = None
    return table(**values)


def dotted(table: type, values: object) -> list[str]:
    """Return every key, with its tables before it, that a file with the named tables of `values` may hold.

    Examples
    --------
    >>> from dehyst_robot.arm import Tables
    >>> [key for key in dotted(Tables, {"muscle": {"big": {}}}) if key.endswith(".length_m")]
    ['muscle.big.length_m']
    """
    keys: list[str] = []
    for name, entry in entries(table).items():
        inner = values.get(name) if isinstance(values, Mapping) else None
        form = _form(entry.kind)
        if form is dataclass:
            for key in dotted(entry.kind, inner):
                keys.append(f"{name}.{key}")
        elif form is Mapping and _inner(entry.kind) is not Any:
            # Names of such tables are free, so that only the file knows them; else the declaration lists them.
            members: Iterable[str] = entry.key.choices
            if not members and isinstance(inner, Mapping):
                members = map(key_text, inner)
            inner_keys = dotted(_inner(entry.kind), None)
            for member in members:
                for key in inner_keys:
                    keys.append(f"{name}.{member}.{key}")
        else:
            keys.append(name)
    return keys


def short_repr(value: object) -> str:
    """Return a value as it is typed, cut after sixty letters."""
    try:
        text = repr(value)
    except (ValueError, RecursionError):  # Python prints no number of more than 4300 digits
        return "(too long to be shown)"
    if len(text) > 60:
        text = text[:57] + "..."
    return text


def key_text(key: object) -> str:
    """Return a key as a text: from Python it may be anything."""
    if isinstance(key, str):
        return key
    return short_repr(key)


def schema_of(table: type, partial: bool = False) -> Plain:
    """Return the JSON Schema of a file, by which editors check and complete while one types; `partial` needs no key.

    Examples
    --------
    >>> from dehyst_robot.arm._tables import Payload
    >>> schema_of(Payload)["properties"]
    {'mass_kg': {'type': 'number', 'minimum': 0.0, 'maximum': 100.0}}
    """
    properties = {}
    required = []
    for name, entry in entries(table).items():
        properties[name] = _schema(entry.kind, entry.key, partial)
        if entry.needed and not partial:
            required.append(name)
    return {
        "type": "object",
        "properties": properties,
        "required": required,
        "additionalProperties": False,
    }


class _Reading:
    """A file that is being read: what it is called, which keys it may have, and which it lacks."""

    def __init__(self, table: type, values: object, source: str) -> None:
        self.source = source
        self.missing: list[str] = []
        # Only a message asks for all keys: they are listed when one is wrong.
        self._all_keys: Callable[[], list[str]] = lambda: dotted(table, values)

    def refused(self, path: str, value: object, allowed: str, hint: str = "") -> ParameterError:
        """Return the error for a value that cannot stand at this key."""
        subject = f"it is {short_repr(value)},"
        if path:
            subject = f"{path} = {short_repr(value)} is"
        message = f"{self.source}: {subject} not {allowed}.{hint}"
        return ParameterError(message, key=path, value=value, source=self.source)

    def table(self, table: type, values: object, path: str) -> Plain:
        """Return a table, checked."""
        mapping = self._mapping(values, path)
        declared = entries(table)
        before = f"{path}." if path else ""
        for name, value in mapping.items():
            if name not in declared:
                keys = [f"{before}{key}" for key in declared]
                raise self._no_such(f"{before}{key_text(name)}", value, keys)
        plain: Plain = {}
        for name, entry in declared.items():
            form = _form(entry.kind)
            key_path = f"{before}{name}"
            # A needed table that is not there is read as an empty one, so that its missing keys are named.
            if name in mapping or (entry.needed and form in (dataclass, Mapping)):
                plain[name] = self.value(mapping.get(name, {}), entry.kind, entry.key, key_path)
            elif entry.needed and form is tuple and _form(_inner(entry.kind)) is dataclass:
                self.missing.append(f"[[{key_path}]]")
            elif entry.needed:
                self.missing.append(key_path)
        return plain

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
        # The range comes first: 10**400 is a whole number that no float holds.
        if number and key.low <= value <= key.high and (kind is float or value % 1 == 0):
            return kind(value)
        hint = did_you_mean(value, key.choices) if isinstance(value, str) else ""
        raise self.refused(path, value, _allowed(kind, key), hint)

    def _mapping(self, value: object, path: str) -> Mapping[str, Any]:
        if isinstance(value, Mapping):
            return value
        allowed = "a table"
        if path:
            allowed = f"a table: write [{path}] and its keys below it"
        raise self.refused(path, value, allowed)

    def _tables(self, value: object, kind: Any, key: Key, path: str) -> Plain:
        mapping = self._mapping(value, path)
        inner = _inner(kind)
        if inner is Any:
            return dict(mapping)
        numbered = get_args(kind)[0] is int and not key.choices
        allowed = key.choices
        if numbered:
            # As many tables as the file has, but at least and at most as many as the key allows.
            count = min(max(len(mapping), key.least), key.most)
            allowed = tuple(str(number) for number in range(1, count + 1))
        for member in mapping:
            if not isinstance(member, str) or (allowed and member not in allowed):
                names = "a name is a text"
                if allowed:
                    names = f"[{path}] has {', '.join(allowed)}"
                if numbered:
                    names += f", numbered without a gap up to {key.most} at most"
                key_path = f"{path}.{key_text(member)}"
                raise ParameterError(
                    f"{self.source}: there is no {key_path}; {names}.",
                    key=key_path,
                    source=self.source,
                )
        tables = {}
        for member in allowed or sorted(mapping):
            tables[member] = self.table(inner, mapping.get(member, {}), f"{path}.{member}")
        return tables

    def _list(self, value: Any, kind: Any, key: Key, path: str) -> list[Any]:
        inner = _inner(kind)
        items = value
        if hasattr(value, "tolist"):  # an array of numpy, when the values come from Python
            items = value.tolist()
        least, most = _lengths(kind, key)
        if isinstance(items, list | tuple) and least <= len(items) <= most:
            values = []
            for index, item in enumerate(items):
                values.append(self.value(item, inner, key, f"{path}[{index}]"))
            # Values that come twice are refused below, as a list of a wrong length is.
            if not key.distinct or len(set(values)) == len(values):
                return values
        if _form(inner) is dataclass:
            raise self.refused(path, value, f"a list of tables: write [[{path}]]")
        raise self.refused(path, value, _allowed(kind, key))

    def _no_such(self, path: str, value: object, allowed_here: list[str]) -> ParameterError:
        # The first key below an unknown table shows which table is meant.
        leaf, inner = path, value
        for _ in range(4):
            if isinstance(inner, Mapping) and inner:
                below, inner = next(iter(inner.items()))
                leaf = f"{leaf}.{key_text(below)}"
        hint = (
            did_you_mean(leaf, allowed_here)
            or did_you_mean(leaf, self._all_keys())
            or did_you_mean(path, allowed_here)
        )
        listed = ", ".join(allowed_here)
        message = f"{self.source}: there is no key {short_repr(path)}.{hint} Known are: {listed}."
        return ParameterError(message, key=path, source=self.source)


@cache
def _form(kind: Any) -> Any:
    """How a type is read: as a `dataclass`, a Mapping, a tuple, or as the plain value that it is."""
    if is_dataclass(kind):
        return dataclass
    return get_origin(kind) or kind


@cache
def _inner(kind: Any) -> Any:
    """What a list or a table by names holds."""
    return get_args(kind)[_form(kind) is Mapping]


def _lengths(kind: Any, key: Key) -> tuple[int, int]:
    """Return how few and how many values a list may have; tuple[T, T] has exactly two."""
    members = get_args(kind)
    if Ellipsis in members:
        return key.least, key.most
    return len(members), len(members)


def _allowed(kind: Any, key: Key) -> str:
    """What may stand at a key, in words."""
    if _form(kind) is tuple:
        least, most = _lengths(kind, key)
        count = f"{least}"
        if least < most:
            count = f"{least} to {most}"
        inner = _allowed(_inner(kind), key)
        return f"a list [..., ...] of {count}{' different' * key.distinct} values, each {inner}"
    if kind is str and key.choices:
        return f"one of {', '.join(key.choices)}"
    if kind is str:
        return f"a printable text in quotes of {key.least} to {key.most} letters"
    if kind is bool:
        return "true or false"
    # No end of the range stands for "any number that is finite".
    whole = ""
    if kind is int:
        whole = "whole "
    if key.high >= LARGEST:
        return f"a finite {whole}number"
    upper_end = f"to {key.high:g}" if key.high < 1e15 else "on"
    text = f"a {whole}number from {key.low:g} {upper_end}"
    if unit := UNITS[key.unit][1]:
        text += f" {unit}, the unit of the key"
    return text


def _in_si(value: Any, kind: Any, factor: float) -> Any:
    if _form(kind) is dataclass:
        return record(kind, value)
    if _form(kind) is Mapping and _inner(kind) is not Any:
        member_type = get_args(kind)[0]
        records = {}
        for member, inner in value.items():
            records[member_type(member)] = record(_inner(kind), inner)
        return records
    if _form(kind) is tuple:
        return tuple(_in_si(item, _inner(kind), factor) for item in value)
    if kind is float:
        return value * factor
    return value


def _schema(kind: Any, key: Key, partial: bool) -> Plain:
    if _form(kind) is dataclass:
        return schema_of(kind, partial)
    if _form(kind) is Mapping:
        return _schema_of_tables(kind, key, partial)
    if _form(kind) is tuple:
        least, most = _lengths(kind, key)
        return {"type": "array", "items": _schema(_inner(kind), key, partial), "minItems": least, "maxItems": most,
                "uniqueItems": key.distinct}  # fmt: skip
    if kind is str and key.choices:
        return {"type": "string", "enum": list(key.choices)}
    if kind is str:
        return {"type": "string", "minLength": key.least, "maxLength": key.most}
    if kind is bool:
        return {"type": "boolean"}
    if kind not in (int, float):
        return {}
    # A number without an end of its range has no limits in the schema either.
    schema: Plain = {"type": "integer" if kind is int else "number"}
    if key.high < LARGEST:
        schema |= {"minimum": key.low, "maximum": key.high}
    return schema


def _schema_of_tables(kind: Any, key: Key, partial: bool) -> Plain:
    inner = {}
    if _inner(kind) is not Any:
        inner = schema_of(_inner(kind), partial)
    names = key.choices
    if get_args(kind)[0] is int and not names:
        # Numbered tables: their names are known beforehand, how many there are is not.
        numbers = [str(number) for number in range(1, key.most + 1)]
        return {"type": "object", "properties": dict.fromkeys(numbers, inner), "additionalProperties": False,
                "minProperties": 0 if partial else key.least}  # fmt: skip
    if not names:
        return {"type": "object", "additionalProperties": inner}
    needed = [] if partial else list(names)
    return {"type": "object", "properties": dict.fromkeys(names, inner), "required": needed,
            "additionalProperties": False}  # fmt: skip
