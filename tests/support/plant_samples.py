"""A joint with two DMSP-40 muscles as in docs and arm.toml, and what the tests of the plant vary in it."""

import copy

import numpy as np

from dehyst_robot._native import PneumaticJoint
from dehyst_robot.arm import _mechanisms as mechanisms

BAR = 1e5
AIR = {
    "supply": 8e5,
    "ambient": 1e5,
    "temperature": 293.0,
    "gas_constant": 287.0,
    "polytropic": 1.26,
    "reference_density": 1.185,
}
MUSCLE = {
    "map": 0,
    "coefficient": [6398.4, 0.122366, 10.47143, 2.023288, 0.25, 6.2e5],
    "length": 0.4,
    "volume": [1.2566e-3, 7.1981e-3, -12.6821e-3, 4.2274e-3],
    "dead_volume": 6e-5,
    "viscous_force": 40.0,
    "viscous_speed": 0.2,
    "creep_time": [0.1, 0.6, 3.5, 20.0, 120.0, 700.0],
    "creep_force": [100.0] * 6,
    "creep_pressure": [3.5 / BAR] * 6,
}
BENCH = {"map": 1, "coefficient": [0.0002, 369.27, -37.51, -0.0304, 0.0093, -546.02]}
VALVE = {
    "conductance": 2e-8,
    "ratio": 0.3,
    "dead_band": 0.03,
    "leak": 0.02,
    "frequency": 628.3,
    "damping": 0.7,
}
SENSORS = {"angle_step": 2 * np.pi / 2**17, "pressure_noise": 250.0, "pressure_lag": 0.002}
BUILT_IN = mechanisms.BUILDERS


def muscle(hysteresis=None, **changes):
    return {**copy.deepcopy(MUSCLE), "hysteresis": hysteresis or mechanisms.none(), **changes}


def parameters(hysteresis=None, air=(), valve=(), sensors=(), substeps=4, **changes):
    return {
        "air": {**AIR, **dict(air)},
        "muscle": [muscle(hysteresis, **changes), muscle(hysteresis, **changes)],
        "valve": [{**VALVE, **dict(valve)}, {**VALVE, **dict(valve)}],
        "sensors": {**SENSORS, **dict(sensors)},
        "arm": [[0.05], [-0.05]],
        "contraction": 0.11,
        "substeps": substeps,
    }


def joint(hysteresis=None, q=0.0, p=(3e5, 3e5), seed=1, **changes):
    made = PneumaticJoint(parameters(hysteresis, **changes), seed)
    made.reset(q, p[0], p[1], seed)
    return made
