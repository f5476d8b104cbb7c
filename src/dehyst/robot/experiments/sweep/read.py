"""Reads a TOML table: checks types, and refuses unknown keys."""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping, Sequence
from typing import Any

from dehyst.errors import ParameterError


class Reader:
    """Takes entries out of a table, each of the kind that is wanted; `finish` refuses what nobody took.

    Parameters
    ----------
    where
        Place of the table, for messages.
    table
        What stands there.
    """

    def __init__(self, where: str, table: Any) -> None:
        self.where = where
        if not isinstance(table, Mapping):
            raise ParameterError(f"{where} is {table!r:.60}, but must be a table {{...}}.")
        self._table = dict(table)
        self._known: set[str] = set()

    def _take(self, key: str, default: Any) -> Any:
        self._known.add(key)
        return self._table.get(key, default)

    def _refuse(self, key: str, value: Any, wanted: str) -> ParameterError:
        return ParameterError(f"{self.where}: {key} is {value!r:.60}. Give {wanted}.", key=key)

    def text(self, key: str, default: str) -> str:
        """Return a short printable text."""
        value = self._take(key, default)
        if not isinstance(value, str) or not value.strip() or not value.isprintable() or len(value) > 80:
            raise self._refuse(key, value, "a text of 1 to 80 printable letters")
        return value

    def whole(self, key: str, default: int, low: int, high: int) -> int:
        """Return a whole number from `low` to `high`."""
        value = self._take(key, default)
        if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
            raise self._refuse(key, value, f"a whole number from {low} to {high}")
        return value

    def number(self, key: str) -> float:
        """Return a finite number that must be there."""
        value = self._take(key, None)
        if not isinstance(value, int | float) or isinstance(value, bool) or not _moderate(value):
            raise self._refuse(key, value if value is not None else "missing", "a finite number")
        return float(value)

    def flag(self, key: str) -> bool:
        """Return true or false; false if nothing is said."""
        value = self._take(key, False)
        if not isinstance(value, bool):
            raise self._refuse(key, value, "true or false")
        return value

    def one_of(self, key: str, allowed: Sequence[str], default: str) -> str:
        """Return one of the texts allowed."""
        value = self._take(key, default)
        if value not in allowed:
            raise self._refuse(key, value, f"one of: {', '.join(allowed)}")
        return str(value)

    def several(self, key: str, allowed: Sequence[str] | None, default: Sequence[str]) -> tuple[str, ...]:
        """Return different texts, of those allowed if they are known."""
        value = self._take(key, list(default))
        texts = isinstance(value, list) and value and all(isinstance(each, str) and each for each in value)
        known = texts and (allowed is None or set(value) <= set(allowed))
        if not known or len(set(value)) != len(value):
            raise self._refuse(key, value, f"a list of different names{' of ' + ', '.join(allowed) if allowed else ''}")
        return tuple(value)

    def seeds(self, key: str, default: Sequence[int]) -> tuple[int, ...]:
        """Return different whole numbers from 0 on."""
        value = self._take(key, list(default))
        whole = isinstance(value, list) and value and all(type(each) is int and 0 <= each < 2**63 for each in value)
        if not whole or len(set(value)) != len(value):
            raise self._refuse(key, value, "a list of different whole numbers from 0 on, for example [1, 2, 3]")
        return tuple(value)

    def items(self, key: str) -> list[Any]:
        """Return a list, empty if nothing is said."""
        value = self._take(key, [])
        if not isinstance(value, list) or (key in self._table and not value):
            raise self._refuse(key, value, "a list of values")
        return value

    def table(self, key: str) -> Mapping[str, Any]:
        """Return a table, empty if nothing is said."""
        value = self._take(key, {})
        if not isinstance(value, Mapping):
            raise self._refuse(key, value, f'a table, for example [{key}] with lines "hysteresis.scale" = ...')
        return value

    def tables(self, key: str) -> list[Any]:
        """Return a list of tables with one entry at least."""
        value = self._take(key, [])
        if not isinstance(value, list) or not value:
            raise ParameterError(f'{self.where} has no [[{key}]]. Add one: [[{key}]] and name = "size" below it.')
        return value

    def finish(self) -> None:
        """Refuse keys that nobody took."""
        for key in self._table:
            if key not in self._known:
                close = difflib.get_close_matches(key, self._known, 1)
                near = f"Did you mean {close[0]}? " if close else ""
                raise ParameterError(
                    f"{self.where}: there is no entry {key!r:.60}. {near}Known are: {', '.join(sorted(self._known))}.",
                    key=key,
                )


def _moderate(value: float) -> bool:
    return abs(value) <= 1e300 and math.isfinite(value)
