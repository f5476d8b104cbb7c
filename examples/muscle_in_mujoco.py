"""An elbow with two pneumatic muscles on tendons in MuJoCo: where it stays after pushes there and back."""

from pathlib import Path

import mujoco
import numpy as np

from dehyst_robot.mujoco_plugin import load

PULSES = ((1.0, 0.25), (-1.0, 0.5), (1.0, 0.25))  # valve of the flexor, share of its way; seconds: there, back, again

load()  # before MuJoCo reads a model with the plugin
model = mujoco.MjModel.from_xml_path(str(Path(__file__).parent / "pneumatic_elbow" / "scene.xml"))
data = mujoco.MjData(model)


def run(valve: float, seconds: float) -> None:
    """Open the flexor's valve, and the extensor's the other way."""
    data.ctrl[:] = valve, -valve
    for _ in range(round(seconds / model.opt.timestep)):
        mujoco.mj_step(model, data)


def pressures() -> str:
    """Gauge pressures: the first number of each muscle's state."""
    return " and ".join(f"{data.plugin_state[at] / 1e5:.2f} bar" for at in model.plugin_stateadr)


run(0.0, 1.0)
print(f"at rest: {np.rad2deg(data.qpos[0]):.2f} deg, {pressures()}")
for valve, seconds in PULSES:
    run(0.3 * valve, 0.4 * seconds)
    run(0.0, 1.0)
    print(f"valves {0.3 * valve:+.1f} for {0.4 * seconds:.1f} s: {np.rad2deg(data.qpos[0]):.2f} deg, {pressures()}")
