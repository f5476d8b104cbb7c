"""Sets the number of threads: one for many small factorisations, all for independent operators."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager
from functools import lru_cache
from typing import TypeVar

from threadpoolctl import ThreadpoolController

In = TypeVar("In")
Out = TypeVar("Out")


@lru_cache(maxsize=1)
def _libraries() -> ThreadpoolController:
    return ThreadpoolController()  # looks through all loaded libraries: 3 ms, as much as a fit


def single_blas() -> AbstractContextManager[object]:
    """Return a context in which BLAS uses one thread.

    Hundreds of small factorisations: its threads would spend their time waiting for each other, up to ten times that
    of the work itself on a busy machine.
    """
    context: AbstractContextManager[object] = _libraries().limit(limits=1, user_api="blas")
    return context


def in_parallel(function: Callable[[In], Out], items: Iterable[In]) -> list[Out]:
    """Results in order; on threads where there are several processors, since the engine releases Python's lock."""
    listed = list(items)
    workers = min(len(listed), os.cpu_count() or 1)
    if workers < 2:
        return [function(item) for item in listed]
    with ThreadPoolExecutor(workers) as pool:
        return list(pool.map(function, listed))
