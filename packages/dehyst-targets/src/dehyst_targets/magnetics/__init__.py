"""Magnetic cores from measured B-H loops: loss, permeability, and parameters for LTspice, PSpice, ngspice, Modelica."""

from dehyst.lazy import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst_targets.magnetics._loop import Core as Core
    from dehyst_targets.magnetics._loop import core_of as core_of
    from dehyst_targets.magnetics._loop import read_core as read_core
    from dehyst_targets.magnetics._models import Chan as Chan
    from dehyst_targets.magnetics._models import CoreFit as CoreFit
    from dehyst_targets.magnetics._models import JilesAtherton as JilesAtherton
    from dehyst_targets.magnetics._models import Tellinen as Tellinen
    from dehyst_targets.magnetics._models import fit_core as fit_core
    from dehyst_targets.magnetics._policy import POLICY as POLICY
    from dehyst_targets.magnetics._requests import MAGNET as MAGNET
    from dehyst_targets.magnetics._write import FORMATS as FORMATS
    from dehyst_targets.magnetics._write import core_file as core_file
    from dehyst_targets.magnetics._write import run_ngspice as run_ngspice

__getattr__, __dir__, __all__ = lazy_names(
    "dehyst_targets.magnetics",
    {
        "_loop": "Core core_of read_core",
        "_models": "Chan CoreFit JilesAtherton Tellinen fit_core",
        "_policy": "POLICY",
        "_requests": "MAGNET",
        "_write": "FORMATS core_file run_ngspice",
    },
)
