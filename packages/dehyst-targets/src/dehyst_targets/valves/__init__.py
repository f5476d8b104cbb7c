"""Control valves from records of their loops: dead band and jump with intervals, or why they cannot be told."""

from dehyst.lazy import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst_targets.valves._figure import write_valve_figure as write_valve_figure
    from dehyst_targets.valves._fit import ValveEstimate as ValveEstimate
    from dehyst_targets.valves._loop import ControlLoop as ControlLoop
    from dehyst_targets.valves._loop import explained_share as explained_share
    from dehyst_targets.valves._loop import read_control_loop as read_control_loop
    from dehyst_targets.valves._policy import POLICY as POLICY
    from dehyst_targets.valves._positions import valve_positions as valve_positions
    from dehyst_targets.valves._requests import VALVE as VALVE
    from dehyst_targets.valves._verdict import ValveVerdict as ValveVerdict
    from dehyst_targets.valves._verdict import judge_valve as judge_valve
    from dehyst_targets.valves._verdict import step_test as step_test

__getattr__, __dir__, __all__ = lazy_names(
    "dehyst_targets.valves",
    {
        "_figure": "write_valve_figure",
        "_fit": "ValveEstimate",
        "_loop": "ControlLoop explained_share read_control_loop",
        "_policy": "POLICY",
        "_positions": "valve_positions",
        "_requests": "VALVE",
        "_verdict": "ValveVerdict judge_valve step_test",
    },
)
