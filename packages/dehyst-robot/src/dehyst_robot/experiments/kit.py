"""Tools of `dehyst_robot.experiments` for other rooms."""

from dehyst.lazy import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst_robot.experiments._output import as_json as as_json
    from dehyst_robot.experiments._output import log_folder as log_folder
    from dehyst_robot.experiments._output import log_names as log_names
    from dehyst_robot.experiments._output import mean_figures as mean_figures
    from dehyst_robot.experiments._plant_fit import ALL as ALL
    from dehyst_robot.experiments._plant_fit import OFFSETS as OFFSETS
    from dehyst_robot.experiments._plant_fit import UNITS as UNITS
    from dehyst_robot.experiments._plant_fit import fit_plant as fit_plant
    from dehyst_robot.experiments._plant_fit import named as named
    from dehyst_robot.experiments._policy import POLICY as POLICY
    from dehyst_robot.experiments._recipes import RECIPES as RECIPES
    from dehyst_robot.experiments._reproduce import ALONE as ALONE
    from dehyst_robot.experiments._results import TRIALS as TRIALS
    from dehyst_robot.experiments._results import TrialRun as TrialRun
    from dehyst_robot.experiments._rig import PRESSURES as PRESSURES
    from dehyst_robot.experiments._rig import cautions as cautions
    from dehyst_robot.experiments._rig import check_rig as check_rig
    from dehyst_robot.experiments._rig import new_rig as new_rig
    from dehyst_robot.experiments._sweep.points import ratios_of as ratios_of
    from dehyst_robot.experiments._sweep.points import summarise as summarise
    from dehyst_robot.experiments._sweep.run import SweepResult as SweepResult
    from dehyst_robot.experiments._sweep.spec import load_sweep as load_sweep

__getattr__, __dir__, __all__ = lazy_names(
    "dehyst_robot.experiments.kit",
    {
        "_output": "as_json log_folder log_names mean_figures",
        "_plant_fit": "ALL OFFSETS UNITS fit_plant named",
        "_policy": "POLICY",
        "_recipes": "RECIPES",
        "_reproduce": "ALONE",
        "_results": "TRIALS TrialRun",
        "_rig": "PRESSURES cautions check_rig new_rig",
        "_sweep.points": "ratios_of summarise",
        "_sweep.run": "SweepResult",
        "_sweep.spec": "load_sweep",
    },
)
