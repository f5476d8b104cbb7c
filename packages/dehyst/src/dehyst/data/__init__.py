"""Recordings, their turning points, loops and gaps, outliers, and the range that percentages refer to."""

from dehyst.lazy import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst.data._clipping import about_clipping as about_clipping
    from dehyst.data._clipping import rests as rests
    from dehyst.data._loop_figures import loops_of as loops_of
    from dehyst.data._loop_figures import measure_loops as measure_loops
    from dehyst.data._loop_numbers import Loops as Loops
    from dehyst.data._loop_numbers import MeasuredLoop as MeasuredLoop
    from dehyst.data._loops import gap_limit as gap_limit
    from dehyst.data._loops import is_even as is_even
    from dehyst.data._loops import memory_lost as memory_lost
    from dehyst.data._loops import summarise_loops as summarise_loops
    from dehyst.data._loops import turning_points as turning_points
    from dehyst.data._outliers import bridged as bridged
    from dehyst.data._outliers import find_outliers as find_outliers
    from dehyst.data._plotted import Plotted as Plotted
    from dehyst.data._policy import POLICY as POLICY
    from dehyst.data._ranges import range_of as range_of
    from dehyst.data._ranges import range_over as range_over
    from dehyst.data._ranges import robust_range as robust_range
    from dehyst.data._recording import MINIMUM_SAMPLES as MINIMUM_SAMPLES
    from dehyst.data._recording import Recording as Recording
    from dehyst.data._recording import require_recordings as require_recordings
    from dehyst.data._repeats import counted_once as counted_once
    from dehyst.data._repeats import refuse_repeated as refuse_repeated
    from dehyst.data._sensor import sensor_data_sheet as sensor_data_sheet
    from dehyst.data._speeds import top_speed as top_speed

__getattr__, __dir__, __all__ = lazy_names(
    "dehyst.data",
    {
        "_clipping": "about_clipping rests",
        "_loop_figures": "loops_of measure_loops",
        "_loop_numbers": "Loops MeasuredLoop",
        "_loops": "gap_limit is_even memory_lost summarise_loops turning_points",
        "_outliers": "bridged find_outliers",
        "_plotted": "Plotted",
        "_policy": "POLICY",
        "_ranges": "range_of range_over robust_range",
        "_recording": "MINIMUM_SAMPLES Recording require_recordings",
        "_repeats": "counted_once refuse_repeated",
        "_sensor": "sensor_data_sheet",
        "_speeds": "top_speed",
    },
)
