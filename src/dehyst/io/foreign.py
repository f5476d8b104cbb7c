"""The border to readers of other packages: their faults become named errors, their warnings stay silent."""

from __future__ import annotations

import importlib
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from dehyst.errors import DehystError, LogError, MissingExtraError
from dehyst.io.text import EXPANSION_LIMIT, SIZE_LIMIT

# Arrays unpack without parsing, so more is allowed for free than for text.
BINARY_FREE = 64 << 20


@contextmanager
def foreign_reader(name: str, kind: str) -> Iterator[None]:
    """Turn any fault of a foreign reader into a LogError.

    A damaged file can make such a reader raise anything; polars' panics are not even an Exception. Whatever it
    raises, the meaning here is one: the file is not what its first bytes promise.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            yield
        except (DehystError, KeyboardInterrupt, SystemExit, GeneratorExit):
            raise
        except BaseException as fault:
            detail = " ".join(str(fault).split())[:160]
            raise LogError(
                f"log '{name}' is damaged: it cannot be read as {kind} ({type(fault).__name__}: {detail}). Copy or "
                f"export it again, or save the columns as CSV.",
                file=name,
                kind=kind,
            ) from None


def optional(module: str, extra: str, name: str) -> Any:
    """Import an optional package, or say which line installs it.

    Raises
    ------
    MissingExtraError
        If it is not installed.
    """
    try:
        return importlib.import_module(module)
    except ImportError as fault:
        raise MissingExtraError(
            f"reading '{name}' needs the package {module.partition('.')[0]}, which is not installed ({fault}). Type: "
            f"pip install 'dehyst[{extra}]' - or save the columns as CSV.",
            extra=extra,
            module=module,
        ) from None


def refuse_bomb(expanded: int, packed: int, name: str) -> None:
    """Refuse contents that unpack to more than 100 times the file (and 64 MB), or more than 1 GB.

    Raises
    ------
    LogError
        If they do.
    """
    limit = min(SIZE_LIMIT, max(BINARY_FREE, EXPANSION_LIMIT * packed))
    if expanded > limit:
        raise LogError(
            f"log '{name}' has {packed} bytes but claims to hold {expanded}; more than {limit >> 20} MB are not read "
            f"from it: it is damaged, or was made to fill the memory. Save the columns you need as CSV.",
            file=name,
            limit=limit,
        )
