"""Tools of `dehyst.monitoring` for other packages: Student's distribution."""

from dehyst.lazy import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst.monitoring._student import place_of_tail as place_of_tail
    from dehyst.monitoring._student import tail as tail

__getattr__, __dir__, __all__ = lazy_names(
    "dehyst.monitoring.kit", {"_student": "place_of_tail tail"}
)
