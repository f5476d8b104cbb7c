"""Backlash of a machine's axis: a guided measurement, lost motion over position, the table that the machine reads."""

from dehyst.lazy import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst_targets.backlash._compensation import Compensation as Compensation
    from dehyst_targets.backlash._compensation import compensation_for as compensation_for
    from dehyst_targets.backlash._figure import write_backlash_figure as write_backlash_figure
    from dehyst_targets.backlash._lost_motion import LostMotion as LostMotion
    from dehyst_targets.backlash._lost_motion import lost_motion as lost_motion
    from dehyst_targets.backlash._machines import MACHINES as MACHINES
    from dehyst_targets.backlash._machines import MachineFormat as MachineFormat
    from dehyst_targets.backlash._machines import read_compensation as read_compensation
    from dehyst_targets.backlash._plan import MeasurementPlan as MeasurementPlan
    from dehyst_targets.backlash._plan import plan_measurement as plan_measurement
    from dehyst_targets.backlash._policy import POLICY as POLICY
    from dehyst_targets.backlash._readings import AxisReadings as AxisReadings
    from dehyst_targets.backlash._readings import read_measurement as read_measurement
    from dehyst_targets.backlash._requests import BACKLASH as BACKLASH
    from dehyst_targets.backlash._write import BacklashTable as BacklashTable
    from dehyst_targets.backlash._write import make_table as make_table
    from dehyst_targets.backlash._write import write_table as write_table

__getattr__, __dir__, __all__ = lazy_names(
    "dehyst_targets.backlash",
    {
        "_compensation": "Compensation compensation_for",
        "_figure": "write_backlash_figure",
        "_lost_motion": "LostMotion lost_motion",
        "_machines": "MACHINES MachineFormat read_compensation",
        "_plan": "MeasurementPlan plan_measurement",
        "_policy": "POLICY",
        "_readings": "AxisReadings read_measurement",
        "_requests": "BACKLASH",
        "_write": "BacklashTable make_table write_table",
    },
)
