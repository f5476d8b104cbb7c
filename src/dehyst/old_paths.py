"""Old import paths of modules that have moved: they still work for one release, with a warning."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Sequence
from importlib import import_module
from importlib.abc import Loader
from importlib.machinery import ModuleSpec
from types import ModuleType

MOVED = {
    **{f"dehyst.{name}": f"dehyst.data.{name}" for name in ("recording", "loops", "outliers", "ranges")},
    **{
        f"dehyst.evaluation.{name}": f"dehyst.robot.iso9283.{name}"
        for name in ("curves", "metrics", "paths", "sections", "timing")
    },
    "dehyst.evaluation.cube": "dehyst.robot.iso9283.paths",
    "dehyst.evaluation.slowing": "dehyst.robot.iso9283.timing",
    "dehyst.evaluation.summary": "dehyst.robot.iso9283.metrics",
    "dehyst.gaps": "dehyst.data.loops",
    "dehyst.data.gaps": "dehyst.data.loops",
    "dehyst.evaluation": "dehyst.design",
    "dehyst.identification.drift": "dehyst.monitoring",
    "dehyst.identification.evaluate": "dehyst.monitoring.evaluate",
    "dehyst.muscles": "dehyst.robot.muscles",
    "dehyst.robot.muscles.storage": "dehyst.robot.muscles.registry",
    "dehyst.robot.muscles.maker": "dehyst.robot.muscles.maps",
    "dehyst.robot.muscles.sarosi": "dehyst.robot.muscles.maps",
    "dehyst.robot.muscles.tondu_lopez": "dehyst.robot.muscles.conical",
    "dehyst.robot.arm.bench": "dehyst.robot.arm.joints",
    "dehyst.robot.arm.joint_path": "dehyst.robot.arm.kinematics",
    "dehyst.robot.arm.physics_engine": "dehyst.robot.arm.rigid_body",
    "dehyst.robot.arm.pneumatic": "dehyst.robot.arm.joints",
    "dehyst.robot.arm.validation": "dehyst.fields",
    "dehyst.robot.experiments.compensators": "dehyst.robot.experiments.equipment",
    "dehyst.robot.experiments.design_joint": "dehyst.robot.experiments.path",
    "dehyst.robot.experiments.direct_run": "dehyst.robot.experiments.identification",
    "dehyst.robot.experiments.learning": "dehyst.robot.experiments.trials",
    "dehyst.robot.experiments.logs": "dehyst.robot.experiments.output",
    "dehyst.robot.experiments.loops_run": "dehyst.robot.experiments.identification",
    "dehyst.robot.experiments.nominal": "dehyst.robot.experiments.calibration",
    "dehyst.robot.experiments.quasistatic": "dehyst.robot.experiments.calibration",
    "dehyst.robot.experiments.reviewed": "dehyst.robot.experiments.equipment",
    "dehyst.robot.experiments.scores": "dehyst.robot.experiments.output",
    "dehyst.robot.experiments.sweep.keys": "dehyst.robot.experiments.sweep.spec",
    "dehyst.robot.experiments.sweep.table": "dehyst.robot.experiments.sweep.points",
    "dehyst.plant": "dehyst.robot.arm",
    "dehyst.experiments": "dehyst.robot.experiments",
    "dehyst.report.reproduction": "dehyst.robot.report",
    "dehyst.report.sweep": "dehyst.robot.report.sweep",
    "dehyst.report.muscle": "dehyst.robot.report.muscle",
}


def spec_of(name: str) -> ModuleSpec | None:
    """Return how a module is found under an old path; None if there was none.

    Examples
    --------
    >>> spec_of("dehyst.gone") is None
    True
    """
    old = next((old for old in MOVED if name == old or name.startswith(f"{old}.")), None)
    if old is None:
        return None
    new = MOVED[old] + name.removeprefix(old)
    warnings.warn(
        f"{name} is {new} now: change the import; the old path goes with the next release.",
        DeprecationWarning,
        stacklevel=3,
    )
    return ModuleSpec(name, _Moved(new), is_package=True)


class _Moved(Loader):
    """Hands over a module that has another name."""

    def __init__(self, name: str) -> None:
        self.name = name

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        """A module of the old name with what the new one has."""
        module = ModuleType(spec.name, f"What was moved to {self.name}.")
        for room in self._rooms():
            vars(module).update({key: value for key, value in vars(room).items() if not key.startswith("__")})
        return module

    def exec_module(self, module: ModuleType) -> None:
        """Nothing runs twice."""

    def _rooms(self) -> Sequence[ModuleType]:
        both = ("dehyst.design", "dehyst.robot.iso9283") if self.name == "dehyst.design" else (self.name,)
        return [sys.modules.get(name) or import_module(name) for name in both]
