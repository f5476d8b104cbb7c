"""What a page is written with."""

from dehyst.lazy import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst.report._drawing import DASHED as DASHED
    from dehyst.report._drawing import legend_label as legend_label
    from dehyst.report._drawing import logarithmic as logarithmic
    from dehyst.report._figures.operators import play_figure as play_figure
    from dehyst.report._loops import write_loops as write_loops
    from dehyst.report._page import write_page as write_page
    from dehyst.report._parts import WIDTH as WIDTH
    from dehyst.report._parts import notes_section as notes_section
    from dehyst.report._parts import numbered as numbered
    from dehyst.report._parts import tables_section as tables_section
    from dehyst.report._parts import warnings_section as warnings_section
    from dehyst.report._pictures import write_band as write_band
    from dehyst.report._pictures import write_excitation_figure as write_excitation_figure
    from dehyst.report._sensor import write_data_sheet as write_data_sheet
    from dehyst.report._svg import write_picture as write_picture
    from dehyst.report._text import between as between
    from dehyst.report._text import count as count
    from dehyst.report._text import flattened as flattened
    from dehyst.report._text import listed as listed
    from dehyst.report._text import number as number
    from dehyst.report._text import plain as plain
    from dehyst.report._text import short as short
    from dehyst.report._theme import AXIS as AXIS
    from dehyst.report._theme import CYCLE as CYCLE
    from dehyst.report._theme import DATA as DATA
    from dehyst.report._theme import FIFTH as FIFTH
    from dehyst.report._theme import INK as INK
    from dehyst.report._theme import MODEL as MODEL
    from dehyst.report._theme import MUTED as MUTED
    from dehyst.report._theme import PAPER as PAPER
    from dehyst.report._theme import TEST as TEST
    from dehyst.report._theme import TRAIN as TRAIN
    from dehyst.report._thin import joined as joined
    from dehyst.report._thin import thin_series as thin_series

__getattr__, __dir__, __all__ = lazy_names(
    "dehyst.report.kit",
    {
        "_drawing": "DASHED legend_label logarithmic",
        "_figures.operators": "play_figure",
        "_loops": "write_loops",
        "_page": "write_page",
        "_parts": "WIDTH notes_section numbered tables_section warnings_section",
        "_pictures": "write_band write_excitation_figure",
        "_sensor": "write_data_sheet",
        "_svg": "write_picture",
        "_text": "between count flattened listed number plain short",
        "_theme": "AXIS CYCLE DATA FIFTH INK MODEL MUTED PAPER TEST TRAIN",
        "_thin": "joined thin_series",
    },
)
