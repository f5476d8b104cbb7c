"""What a command is written with."""

from dehyst.lazy import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst.app._design import MOTIONS as MOTIONS
    from dehyst.app._drift import ENDS as ENDS
    from dehyst.app._policy import POLICY as POLICY
    from dehyst.app._targets import MUSCLE as MUSCLE
    from dehyst.app._targets import MUSCLES as MUSCLES
    from dehyst.app._targets import REPRODUCTION as REPRODUCTION
    from dehyst.app._targets import RIGS as RIGS
    from dehyst.app._targets import SWEEP as SWEEP
    from dehyst.app._terminal import MARK as MARK
    from dehyst.app._terminal import terminal as terminal
    from dehyst.app.requests import INPUT as INPUT
    from dehyst.app.requests import MODEL as MODEL
    from dehyst.app.requests import OUTPUT as OUTPUT

__getattr__, __dir__, __all__ = lazy_names(
    "dehyst.app.kit",
    {
        "_design": "MOTIONS",
        "_drift": "ENDS",
        "_policy": "POLICY",
        "_targets": "MUSCLE MUSCLES REPRODUCTION RIGS SWEEP",
        "_terminal": "MARK terminal",
        "requests": "INPUT MODEL OUTPUT",
    },
)
