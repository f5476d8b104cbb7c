"""Tools of `dehyst.identification` for other rooms."""

from dehyst.lazy import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst.identification._scores import Part as Part
    from dehyst.identification._scores import score as score

__getattr__, __dir__, __all__ = lazy_names("dehyst.identification.kit", {"_scores": "Part score"})
