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
from dehyst_robot._native import mujoco_places, mujoco_register

if TYPE_CHECKING:
    from dehyst_robot.arm import Robot

# Names of MuJoCo's functions, and of the arrays of a state and a model, that the C code uses.
_FUNCTIONS = ("mjp_registerPlugin", "mj_getPluginConfig", "mju_error")
_DATA = ("plugin_state", "ctrl", "actuator_length", "actuator_velocity", "actuator_force")
_MODEL = (
    "actuator_plugin",
    "actuator_length0",
    "plugin_stateadr",
    "actuator_ctrladr",
    "actuator_outadr",
)
_PROBE = """<mujoco><extension><plugin plugin="dehyst.muscle"/></extension><option timestep="0.0012345678"/>
<worldbody>{bodies}</worldbody><actuator>{actuators}</actuator></mujoco>"""
_BODY = '<body><freejoint/><geom size="1"/></body><body><joint name="j{0}"/><geom size="1"/><site name="s{0}"/></body>'
_ACTUATOR = (
    """<general joint="j{0}" dyntype="integrator"/><plugin plugin="dehyst.muscle" joint="j{0}"/>"""
)


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
            f"the plugin needs the package mujoco, which is not installed ({fault}). Type: pip install dehyst-robot",
            extra="dehyst-robot",
        ) from None
    mujoco_register(*_addresses(mujoco))
    # Offsets that are right depend on the version of MuJoCo alone, so two models must agree on them.
    try:
        offsets = _measured(mujoco, 3)
        if offsets != _measured(mujoco, 5):
            raise LookupError("two models disagree")
    except (LookupError, AttributeError) as fault:
        raise MissingExtraError(
            f"mujoco {mujoco.__version__} keeps its arrays where the plugin dehyst.muscle cannot find them ({fault}); "
            "it would read and write wrong memory. Type: pip install 'mujoco==4.0.0', the last version that was tried",
            extra="dehyst-robot",
        ) from None
    mujoco_places(offsets)


def _addresses(mujoco: Any) -> list[int]:
    package = Path(mujoco.__file__).parent
    for pattern in ("libmujoco.so*", "libmujoco*.dylib", "mujoco*.dll"):
        for file in package.glob(pattern):
            library = ctypes.CDLL(str(file))
            addresses = []
            for name in _FUNCTIONS:
                pointer = ctypes.cast(getattr(library, name), ctypes.c_void_p)
                addresses.append(pointer.value or 0)
            return addresses
    raise MissingExtraError(
        f"no library of MuJoCo lies beside {package.name}, the plugin cannot reach it. "
        "Type: pip install --force-reinstall mujoco",
        extra="dehyst-robot",
    )


def _measured(mujoco: Any, size: int) -> list[int]:
    """Return the offsets of the plugin's arrays in MuJoCo's structures, measured on a model with `size` actuators."""
    bodies = "".join(map(_BODY.format, range(size)))
    actuators = "".join(map(_ACTUATOR.format, range(size)))
    model = mujoco.MjModel.from_xml_string(_PROBE.format(bodies=bodies, actuators=actuators))
    data = mujoco.MjData(model)

    state = _places(data, _pointers(data, _DATA))
    # The time step of the probe has an unusual value, so that its bits mark its place.
    timestep = ctypes.c_uint64.from_buffer(ctypes.c_double(model.opt.timestep)).value
    arrays = _places(model, {**_pointers(model, _MODEL), "timestep": timestep})
    offsets = list(map(state.__getitem__, _DATA))
    offsets += [arrays["timestep"], _place_of_count(model)]
    # Arrays that this version does not have are marked by -1.
    for name in _MODEL:
        offsets.append(arrays.get(name, -1))
    return offsets


def _place_of_count(model: Any) -> int:
    """Return the offset of the number of actuators among the sizes at the beginning of a model."""
    places = []
    for offset in range(0, 256, 4):
        if ctypes.c_int32.from_address(model._address + offset).value == model.nu:
            places.append(offset)
    # Where actuators may have several controls, the number of actuators follows the number of controls, nu.
    return places[hasattr(model, "nactuator")]


def _pointers(owner: Any, names: tuple[str, ...]) -> dict[str, int]:
    return {name: getattr(owner, name).ctypes.data for name in names if hasattr(owner, name)}


def _places(owner: Any, values: dict[str, int]) -> dict[str, int]:
    """Return the offset of each value in the memory of a model or a state.

    Of equal neighbours it is the last one: an array without elements has the address of the array after it.
    """
    names = {value: name for name, value in values.items()}
    offsets: dict[str, int] = {}
    last = None
    for offset in range(0, 1 << 20, 8):
        value = ctypes.c_uint64.from_address(owner._address + offset).value
        name = names.get(value)
        if name is not None and (name not in offsets or name == last):
            offsets[name] = offset
        last = name
        if name is None and len(offsets) == len(names):
            return offsets
    raise LookupError(", ".join(names.values() - offsets.keys()))


def actuator_xml(
    robot: Robot,
    number: int,
    muscle: int,
    *,
    seed: int = 0,
    drive: str = "valve",
    **attributes: object,
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
        Draws the muscle's tolerances, as of `dehyst_robot.arm.JointBench`.
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
    >>> from dehyst_robot.arm import load_robot
    >>> print(actuator_xml(load_robot(), 1, 0, joint="elbow", gear=-0.05).splitlines()[0])
    <plugin plugin="dehyst.muscle" joint="elbow" gear="-0.05">
    """
    config = _config(robot, number, muscle, seed, drive)
    lines = ['<plugin plugin="dehyst.muscle"']
    for key, value in attributes.items():
        lines[0] += f" {key}={quoteattr(str(value))}"
    lines[0] += ">"
    for key, value in config.items():
        lines.append(f"  <config key={quoteattr(key)} value={quoteattr(value)}/>")
    lines.append("</plugin>")
    return "\n".join(lines)


_MAPS = ("tool", "exponential", "geometric")
# A mechanism is named, and the plugin sets its elements up by itself.
_OF_MECHANISM = ("kind", "n", "center", "strain", "share")
# The plugin keeps its supply pressure, and counts the branches of creep.
_OF_JOINT = ("creep_branches", "supply_volume", "supply_conductance")


def _config(robot: Robot, number: int, muscle: int, seed: int, drive: str) -> dict[str, str]:
    joints = importlib.import_module("dehyst_robot.arm._joints")
    if muscle not in (0, 1):
        raise ParameterError(f"muscle = {muscle}: a joint has muscles 0 and 1.", muscle=muscle)
    joint = joints.pneumatic_joint_parameters(robot, number, seed)
    form = {code: form for form, code in joints.FORMS.items()}
    physics = joint["muscle"][muscle]
    if form[physics["map"]] == "table":
        raise ParameterError(
            f"muscle {muscle} of joint {number} has the static force of a muscle model, "
            f"{robot.muscles_of(number)[muscle].model}: the plugin takes the maps {', '.join(_MAPS)}. Give that "
            f"type of muscle a map and no model.",
            joint=number,
        )
    values: dict[str, Any] = dict(physics)
    hysteresis = values.pop("hysteresis")
    values |= {**joint["valve"][muscle], **joint["air"]}
    for key, value in hysteresis.items():
        if key not in _OF_MECHANISM:
            values[key] = value
    values["map"] = form[values["map"]]
    values["mechanism"] = robot.hysteresis.mechanism if hysteresis["kind"] else "none"
    values |= {
        "contraction": joint["contraction"],
        "substeps": joint["substeps"],
        "drive": drive,
        "pressure": robot.controller.mean_pressure,
    }
    # An effect of realistic actuators that is 0, as by default, needs no line in the file.
    zero_by_default = _zero_by_default()
    config = {}
    for key, value in values.items():
        if key in _OF_JOINT or (key in zero_by_default and value == 0):
            continue
        config[key] = " ".join(map(repr, value)) if isinstance(value, list) else str(value)
    return config


def _zero_by_default() -> set[str]:
    """Return the names of the parameters that are 0 unless a file sets them."""
    tables = importlib.import_module("dehyst_robot.arm._tables")
    names = {"shift", "step", "middle"}
    for table in (tables.Muscle, tables.Valve, tables.Hysteresis):
        for field in fields(table):
            if field.default == 0:
                names.add(field.name)
    return names
