"""Own checker of the Structured Text that dehyst writes: parse, check types, run with IEEE arithmetic.

It knows the subset of IEC 61131-3 that the exported function blocks use and refuses everything else. It is no PLC: what
it shows is that the text is well formed, that types agree, that no index leaves its array and no integer its range, and
that the arithmetic of the text, taken literally, gives the bits of the C core.
"""

from dehyst.export.iec.machine import Instance, Library, RunError, load
from dehyst.export.iec.tree import TextError

__all__ = ["Instance", "Library", "RunError", "TextError", "load"]
