"""Open-circuit voltage with hysteresis: branches and decay rate from slow cycles, as PyBaMM reads them."""

from dehyst.lazy import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst_targets.batteries._fit import OcvFit as OcvFit
    from dehyst_targets.batteries._fit import fit_ocv as fit_ocv
    from dehyst_targets.batteries._ocv import OcvLog as OcvLog
    from dehyst_targets.batteries._ocv import ocv_of as ocv_of
    from dehyst_targets.batteries._ocv import read_ocv as read_ocv
    from dehyst_targets.batteries._policy import POLICY as POLICY
    from dehyst_targets.batteries._requests import BATTERY as BATTERY
    from dehyst_targets.batteries._write import pybamm_file as pybamm_file

__getattr__, __dir__, __all__ = lazy_names(
    "dehyst_targets.batteries",
    {
        "_fit": "OcvFit fit_ocv",
        "_ocv": "OcvLog ocv_of read_ocv",
        "_policy": "POLICY",
        "_requests": "BATTERY",
        "_write": "pybamm_file",
    },
)
