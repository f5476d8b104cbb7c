"""Interface to MuJoCo: imported on first use, its faults raised as errors of dehyst."""

from __future__ import annotations

import ctypes
import importlib
from functools import cache
from pathlib import Path
from typing import Any

from dehyst.errors import MissingExtraError


def mujoco() -> Any:
    """Return the module mujoco."""
    return _imported("mujoco", "simulating the arm")


def mink() -> Any:
    """Return the module mink, inverse kinematics."""
    _imported("daqp", "the inverse kinematics of the arm")
    return _imported("mink", "the inverse kinematics of the arm")


@cache
def mj_step_address() -> int:
    """Return the address of MuJoCo's ``void mj_step(const mjModel*, mjData*)``, for a loop without Python."""
    package = Path(mujoco().__file__).parent
    names = ("libmujoco.so*", "libmujoco*.dylib", "mujoco*.dll")
    libraries = sorted(file for pattern in names for file in package.rglob(pattern))
    for library in libraries:
        try:
            address = ctypes.cast(ctypes.CDLL(str(library)).mj_step, ctypes.c_void_p).value
        except (OSError, AttributeError):  # a plugin's library, or one of another machine
            continue
        if address:
            return address
    found = ", ".join(file.name for file in libraries) or "none"
    raise MissingExtraError(
        f"mujoco {mujoco().__version__} is installed, but no library beside it has the function mj_step (libraries "
        f"found: {found}); the closed loop calls it directly. Type: pip install --force-reinstall 'mujoco>=3.2'",
        extra="plant",
        libraries=found,
    )


def _imported(module: str, doing: str) -> Any:
    try:
        return importlib.import_module(module)
    except ImportError as fault:
        raise MissingExtraError(
            f"{doing} needs the package {module}, which is not installed ({fault}). Type: pip install 'dehyst[plant]'",
            extra="plant",
            module=module,
        ) from None
