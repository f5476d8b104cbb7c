"""Tools of `dehyst.data` for other rooms."""

from dehyst.lazy import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst.data._loop_numbers import LoopEstimate as LoopEstimate
    from dehyst.data._loops import taken_back as taken_back
    from dehyst.data._sensor_sheet import LINES as LINES
    from dehyst.data._sensor_sheet import DataSheet as DataSheet
    from dehyst.data._sensor_sheet import SheetFigure as SheetFigure
    from dehyst.data._sensor_sheet import label_of as label_of
    from dehyst.data._spread import FOLDS as FOLDS
    from dehyst.data._spread import SpreadRows as SpreadRows
    from dehyst.data._spread import folds_of as folds_of
    from dehyst.data._spread import score_of as score_of
    from dehyst.data._spread import shares_of as shares_of
    from dehyst.data._spread import spread_rows as spread_rows

__getattr__, __dir__, __all__ = lazy_names(
    "dehyst.data.kit",
    {
        "_loop_numbers": "LoopEstimate",
        "_loops": "taken_back",
        "_sensor_sheet": "DataSheet LINES SheetFigure label_of",
        "_spread": "FOLDS SpreadRows folds_of score_of shares_of spread_rows",
    },
)
