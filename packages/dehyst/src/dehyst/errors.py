"""All errors of dehyst: one base class, one class for each kind of fault; the message says what to do.

A message says what happened, gives the numbers, says why it matters and what to type. The same facts
are attributes of the exception (``error.facts``), so that a program can act on them.
"""

from __future__ import annotations

from typing import Any

from dehyst.shell import visible_lines


class DehystError(Exception):
    """Base of all errors that a user can cure.

    Parameters
    ----------
    message
        What happened, the numbers, why it matters and the way out.
    **facts
        The same facts by name, kept as ``error.facts``.

    Examples
    --------
    >>> error = ColumnError("no column 'x' in log.csv", column="x")
    >>> error.facts["column"]
    'x'
    """

    def __init__(self, message: str, **facts: Any) -> None:
        super().__init__(visible_lines(message))
        self.facts: dict[str, Any] = facts


class ParameterError(DehystError, ValueError):
    """A setting or model parameter lies outside what its formula allows."""


class InvertibilityError(DehystError, ValueError):
    """The model has no closed inverse: some partial sum of its weights is zero or changes sign."""


class RecordingError(DehystError, ValueError):
    """A recording cannot be used as it is: lengths differ, samples are not finite, too short."""


class ExcitationError(DehystError, ValueError):
    """The input did not move in a way that determines the model."""


class SimulationError(DehystError, RuntimeError):
    """The simulated robot left the range that it can be simulated in, or a controller of it failed safe."""


class IdentificationError(DehystError, RuntimeError):
    """The optimisation did not reach its optimality conditions."""


class LogError(DehystError):
    """A log file cannot be read: missing, empty, damaged, or of an unknown format."""


class ColumnError(LogError):
    """The log has no such column, or the column holds no numbers."""


class RunError(LogError):
    """The log has no such run, or holds several and none was named."""


class TimeError(LogError):
    """Time stamps contradict the request: empty window, two clocks, no time column."""


class UnitError(DehystError, ValueError):
    """Two units cannot be converted into each other."""


class ModelFileError(DehystError):
    """A model file is damaged, hostile, of another schema version, or not a model at all."""


class MissingExtraError(DehystError, ImportError):
    """An optional package is not installed; the message names the line to type."""


class OutputError(DehystError):
    """A result cannot be written where it was asked to go."""
