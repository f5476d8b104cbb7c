"""Exports models, inverses and joint controllers as code for a target, with tests of that code."""

from dehyst.lazy import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst.export._controller import ControllerInterface as ControllerInterface
    from dehyst.export._controller import Quantity as Quantity
    from dehyst.export._folder import Written as Written
    from dehyst.export._folder import export as export
    from dehyst.export._folder import read_manifest as read_manifest
    from dehyst.export._numbers import DirectNumbers as DirectNumbers
    from dehyst.export._numbers import ElementNumbers as ElementNumbers
    from dehyst.export._numbers import JointNumbers as JointNumbers
    from dehyst.export._numbers import ModelNumbers as ModelNumbers
    from dehyst.export._numbers import OffsetUnit as OffsetUnit
    from dehyst.export._numbers import UnitNumbers as UnitNumbers
    from dehyst.export._pair import write_pair as write_pair
    from dehyst.export._signal import Signal as Signal
    from dehyst.export._signal import SignalPart as SignalPart
    from dehyst.export._signal import Whole as Whole
    from dehyst.export._subject import Subject as Subject
    from dehyst.export._subject import subject_of as subject_of
    from dehyst.export._targets import TARGETS as TARGETS
    from dehyst.export._targets import Check as Check
    from dehyst.export._verification import verify as verify
    from dehyst.export.compilers import found as found
    from dehyst.export.precision import Floats as Floats

__getattr__, __dir__, __all__ = lazy_names(
    "dehyst.export",
    {
        "_controller": "ControllerInterface Quantity",
        "_folder": "Written export read_manifest",
        "_numbers": "DirectNumbers ElementNumbers JointNumbers ModelNumbers OffsetUnit UnitNumbers",
        "_pair": "write_pair",
        "_signal": "Signal SignalPart Whole",
        "_subject": "Subject subject_of",
        "_targets": "Check TARGETS",
        "_verification": "verify",
        "compilers": "found",
        "precision": "Floats",
    },
)
