"""Where things lie in the repository, for tests, oracles and their helpers."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SUPPORT = ROOT / "tests" / "support"
PACKAGES = ROOT / "packages"
KERNEL, TARGETS, ROBOT, STUDIO = (
    PACKAGES / name for name in ("dehyst", "dehyst-targets", "dehyst-robot", "dehyst-studio")
)
SOURCES = {  # import name -> folder of its modules
    "dehyst": KERNEL / "src" / "dehyst",
    "dehyst_targets": TARGETS / "src" / "dehyst_targets",
    "dehyst_robot": ROBOT / "src" / "dehyst_robot",
    "dehyst_studio": STUDIO / "src" / "dehyst_studio",
}
DATA = ROOT.parent / "shared" / "data"  # measured logs, where they lie beside the repository
