"""The page of the paper's experiment: figures, tables, a moving picture of the arm."""

from dehyst.lazy import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst_robot.report._muscle import write_muscle_figure as write_muscle_figure
    from dehyst_robot.report._muscle import write_muscle_report as write_muscle_report
    from dehyst_robot.report._page import write_reproduction_report as write_reproduction_report
    from dehyst_robot.report._rig import write_fit_figure as write_fit_figure
    from dehyst_robot.report._rig import write_rig_figure as write_rig_figure
    from dehyst_robot.report._sweep import SweepCurve as SweepCurve
    from dehyst_robot.report._sweep import write_sweep_figure as write_sweep_figure
    from dehyst_robot.report._words import WHY as WHY
    from dehyst_robot.report._words import grown as grown
    from dehyst_robot.report._words import run_on as run_on

__getattr__, __dir__, __all__ = lazy_names(
    "dehyst_robot.report",
    {
        "_muscle": "write_muscle_figure write_muscle_report",
        "_page": "write_reproduction_report",
        "_rig": "write_fit_figure write_rig_figure",
        "_sweep": "SweepCurve write_sweep_figure",
        "_words": "WHY grown run_on",
    },
)
