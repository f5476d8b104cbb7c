"""FMUs: the exported C code with the functions of FMI 2.0 and 3.0."""

from dehyst.lazy import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst_targets.fmu._companions import fmu_companions as fmu_companions
    from dehyst_targets.fmu._companions import fmu_files as fmu_files
    from dehyst_targets.fmu._package import package as package
    from dehyst_targets.fmu._verification import check_fmu as check_fmu

__getattr__, __dir__, __all__ = lazy_names(
    "dehyst_targets.fmu",
    {
        "_companions": "fmu_companions fmu_files",
        "_package": "package",
        "_verification": "check_fmu",
    },
)
