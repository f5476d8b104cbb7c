"""A muscle of the simulated robot as an actuator of any MuJoCo model: plugin ``dehyst.muscle``.

MuJoCo imports this module by itself where it knows entry points, so nothing here may be slow to import.
"""

from __future__ import annotations

import ctypes
import importlib
from dataclasses import fields
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.sax.saxutils import quoteattr

from dehyst.errors import MissingExtraError, ParameterError
from dehyst.robot._native import mujoco_places, mujoco_register

if TYPE_CHECKING:
    from dehyst.robot.arm.parameters import Robot

_FUNCTIONS = ("mjp_registerPlugin", "mj_getPluginConfig", "mju_error")
_DATA = ("plugin_state", "ctrl", "actuator_length", "actuator_velocity", "actuator_force")
_MODEL = ("actuator_plugin", "actuator_length0", "plugin_stateadr", "actuator_ctrladr", "actuator_outadr")
_PROBE = """<mujoco><extension><plugin plugin="dehyst.muscle"/></extension><option timestep="0.0012345678"/>
<worldbody>{bodies}</worldbody><actuator>{actuators}</actuator></mujoco>"""
_BODY = '<body><freejoint/><geom size="1"/></body><body><joint name="j{0}"/><geom size="1"/><site name="s{0}"/></body>'
_ACTUATOR = """<general joint="j{0}" dyntype="integrator"/><plugin plugin="dehyst.muscle" joint="j{0}"/>"""


@cache
def load() -> None:
    """Register the actuator plugin ``dehyst.muscle`` in MuJoCo; a second call does nothing.

    From MuJoCo 4.0 on, ``import mujoco`` does it wherever dehyst is installed. The plugin runs in Python's processes
    only: where MuJoCo keeps its arrays differs between versions and is measured here, on two small models.

    Raises
    ------
    MissingExtraError
        If mujoco is not installed, or is a version whose arrays are not found.

    Examples
    --------
    >>> load()
    >>> import mujoco
    >>> model = mujoco.MjModel.from_xml_string('''<mujoco>
    ...   <extension><plugin plugin="dehyst.muscle"/></extension>
    ...   <worldbody><body><joint name="elbow" axis="0 1 0"/><geom size="0.05 0.2" type="capsule"/></body></worldbody>
    ...   <actuator><plugin plugin="dehyst.muscle" joint="elbow" gear="0.05">
    ...     <config key="muscle" value="dmsp20"/></plugin></actuator></mujoco>''')
    >>> data = mujoco.MjData(model)
    >>> mujoco.mj_step(model, data)
    >>> bool(-1500 < data.actuator_force[0] < 0)  # it pulls
    True
    """
    try:
        mujoco = importlib.import_module("mujoco")
    except ImportError as fault:
        raise MissingExtraError(
            f"the plugin needs the package mujoco, which is not installed ({fault}). Type: pip install 'dehyst[plant]'",
            extra="plant",
        ) from None
    mujoco_register(*_addresses(mujoco))
    try:
        offsets = _measured(mujoco, 3)
        if offsets != _measured(mujoco, 5):
            raise LookupError("two models disagree")
    except (LookupError, AttributeError) as fault:
        raise MissingExtraError(
            f"mujoco {mujoco.__version__} keeps its arrays where the plugin dehyst.muscle cannot find them ({fault}); "
            "it would read and write wrong memory. Type: pip install 'mujoco==4.0.0', the last version that was tried",
            extra="plant",
        ) from None
    mujoco_places(offsets)


def _addresses(mujoco: Any) -> list[int]:
    package = Path(mujoco.__file__).parent
    for pattern in ("libmujoco.so*", "libmujoco*.dylib", "mujoco*.dll"):
        for file in package.glob(pattern):
            library = ctypes.CDLL(str(file))
            return [ctypes.cast(getattr(library, name), ctypes.c_void_p).value or 0 for name in _FUNCTIONS]
    raise MissingExtraError(
        f"no library of MuJoCo lies beside {package.name}, the plugin cannot reach it. "
        "Type: pip install --force-reinstall mujoco",
        extra="plant",
    )


def _measured(mujoco: Any, size: int) -> list[int]:
    bodies = "".join(_BODY.format(i) for i in range(size))
    actuators = "".join(_ACTUATOR.format(i) for i in range(size))
    model = mujoco.MjModel.from_xml_string(_PROBE.format(bodies=bodies, actuators=actuators))
    data = mujoco.MjData(model)

    timestep = ctypes.c_uint64.from_buffer(ctypes.c_double(model.opt.timestep)).value
    sizes = [i for i in range(0, 256, 4) if ctypes.c_int32.from_address(model._address + i).value == model.nu]
    state = _places(data, _pointers(data, _DATA))
    arrays = _places(model, {**_pointers(model, _MODEL), "timestep": timestep})
    count = sizes[hasattr(model, "nactuator")]  # which follows nu, where actuators may have several controls
    return [*(state[name] for name in _DATA), arrays["timestep"], count, *(arrays.get(name, -1) for name in _MODEL)]


def _pointers(owner: Any, names: tuple[str, ...]) -> dict[str, int]:
    return {name: getattr(owner, name).ctypes.data for name in names if hasattr(owner, name)}


def _places(owner: Any, wanted: dict[str, int]) -> dict[str, int]:
    """Return the offsets of words; of equal neighbours the last: an array without elements lies where the next does."""
    names = {value: name for name, value in wanted.items()}
    found: dict[str, int] = {}
    last = None
    for offset in range(0, 1 << 20, 8):
        value = ctypes.c_uint64.from_address(owner._address + offset).value
        name = names.get(value)
        if name is not None and (name not in found or name == last):
            found[name] = offset
        last = name
        if name is None and len(found) == len(names):
            return found
    raise LookupError(", ".join(names.values() - found.keys()))


def actuator_xml(
    robot: Robot, number: int, muscle: int, *, seed: int = 0, drive: str = "valve", **attributes: object
) -> str:
    """Return a muscle of the robot as an actuator for the ``<actuator>`` part of an MJCF file.

    Parameters
    ----------
    robot
        From `load_robot`.
    number
        Of a pneumatic joint.
    muscle
        0 or 1.
    seed
        Draws the muscle's tolerances, as of `dehyst.robot.arm.JointBench`.
    drive
        ``valve``: control is the valve's command, -1 .. 1. ``pressure``: control is the gauge pressure. [Pa]
    **attributes
        Of MuJoCo's element: ``name``, ``joint`` or ``tendon``, ``gear``, ``ctrlrange``, ... The contraction is the
        joint's where the model is in qpos0; a muscle pulls its actuator shorter, so that gear = -radius makes a muscle
        that turns a hinge forward.

    Raises
    ------
    ParameterError
        If the joint has no such muscle.

    Examples
    --------
    >>> from dehyst.robot.arm import load_robot
    >>> print(actuator_xml(load_robot(), 1, 0, joint="elbow", gear=-0.05).splitlines()[0])
    <plugin plugin="dehyst.muscle" joint="elbow" gear="-0.05">
    """
    config = _config(robot, number, muscle, seed, drive)
    own = "".join(f" {key}={quoteattr(str(value))}" for key, value in attributes.items())
    lines = [f"  <config key={quoteattr(key)} value={quoteattr(value)}/>" for key, value in config.items()]
    return "\n".join([f'<plugin plugin="dehyst.muscle"{own}>', *lines, "</plugin>"])


_MAPS = ("tool", "exponential", "geometric")


def _config(robot: Robot, number: int, muscle: int, seed: int, drive: str) -> dict[str, str]:
    joints = importlib.import_module("dehyst.robot.arm.joints")
    if muscle not in (0, 1):
        raise ParameterError(f"muscle = {muscle}: a joint has muscles 0 and 1.", muscle=muscle)
    joint = joints.pneumatic_joint_parameters(robot, number, seed)
    form = {code: form for form, code in joints.FORMS.items()}
    if form[joint["muscle"][muscle]["map"]] == "table":
        raise ParameterError(
            f"muscle {muscle} of joint {number} has the static force of a muscle model, "
            f"{robot.muscles_of(number)[muscle].model}: the plugin takes the maps {', '.join(_MAPS)}. Give that "
            f"type of muscle a map and no model.",
            joint=number,
        )
    own: dict[str, Any] = {**joint["muscle"][muscle]}
    hysteresis = own.pop("hysteresis")
    own |= {**joint["valve"][muscle], **joint["air"]}
    own |= {key: value for key, value in hysteresis.items() if key not in ("kind", "n", "center", "strain", "share")}
    own |= {"map": form[own["map"]], "mechanism": robot.hysteresis.mechanism if hysteresis["kind"] else "none"}
    own |= {"contraction": joint["contraction"], "substeps": joint["substeps"], "drive": drive}
    own["pressure"] = robot.controller.mean_pressure
    tables = importlib.import_module("dehyst.robot.arm.tables")
    life = {"shift", "step", "middle"}
    life |= {
        f.name for table in (tables.Muscle, tables.Valve, tables.Hysteresis) for f in fields(table) if f.default == 0
    }
    unused = {"creep_branches", "supply_volume", "supply_conductance"}  # a supply of one's own: the pressure stays
    unused |= {name for name in life if own.get(name) == 0}
    return {
        key: " ".join(map(repr, v)) if isinstance(v, list) else str(v) for key, v in own.items() if key not in unused
    }
