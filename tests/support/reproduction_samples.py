"""A Reproduction made by hand for the tests of its report: an arm on its path, errors from filtered hysteresis."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.signal import lfilter

import dehyst
from dehyst.models import PrandtlIshlinskii
from dehyst_robot.experiments import JointIdentification, PlantResult, Reproduction
from dehyst_robot.experiments._results import TRIALS, Characteristic, TrialRun

PLANTS = ("maxwell-slip", "preisach", "dahl", "none")
JOINTS = (1, 2, 4)
SIZE = {"maxwell-slip": 6.0, "preisach": 7.0, "dahl": 5.0, "none": 0.0}  # Nm at the joint
LEFT = {
    "maxwell-slip": 0.2,
    "preisach": 0.26,
    "dahl": 0.31,
    "none": 0.0,
}  # share that the compensator leaves
FIGURES = ("line", "large circle", "small circle", "rectangle")
AXES = ("yaw", "pitch", "roll", "pitch", "roll", "pitch", "yaw")
ZERO = np.deg2rad([0.0, -20.0, 0.0, 75.0, 0.0, 0.0, 0.0])
LENGTH = (0.10, 0.20, 0.20, 0.20, 0.15, 0.06, 0.10)
ROTATION = {"yaw": (0, 1), "pitch": (2, 0), "roll": (1, 2)}
INERTIA, POLE, SPEED, EDGE = 4.0, 6.0, 0.25, 0.4
SETTINGS = {
    "robot": "seven-joint arm with pneumatic muscles",
    "fingerprint": "0123456789abcdef",
    "seeds": [0, 1, 2],
    "joints": [1, 2, 4],
    "command": "dehyst reproduce --plant all --seed 0 --out run",
    "changes": {"hysteresis.scale": 1.5},
    "sources": {
        "controller.pole_1_s": "lambda of the position loop; assumption",
        "sensors.encoder_bits": "[1]",
        "hysteresis.scale": "of hysteresis_N of all muscles",
    },
    "parameters": {
        "sensors": {"encoder_bits": 17, "pressure_noise_bar": 0.0025},
        "controller": {"pole_1_s": 6.0, "mean_pressure_bar": 3.0},
        "hysteresis": {"mechanism": "maxwell-slip", "scale": 1.5},
    },
    "versions": {"dehyst": "0.1.0", "mujoco": "4.0.0", "numpy": "2.4.6"},
}


def frames_of(q: np.ndarray) -> np.ndarray:
    """Where joints and tool are, (K, 8, 3), base at the origin, joint 1 at 0.8 m."""
    places = np.zeros((len(q), 8, 3))
    places[:, 0, 2] = 0.8
    turn = np.broadcast_to(np.eye(3), (len(q), 3, 3))
    for joint in range(7):
        a, b = ROTATION[AXES[joint]]
        angle = q[:, joint] + ZERO[joint]
        step = np.broadcast_to(np.eye(3), (len(q), 3, 3)).copy()
        step[:, a, a] = step[:, b, b] = np.cos(angle)
        step[:, a, b], step[:, b, a] = -np.sin(angle), np.sin(angle)
        turn = turn @ step
        along = (
            turn[:, :, 2] if joint == 0 else turn[:, :, 0]
        )  # link 1 stands, the others reach forward
        places[:, joint + 1] = places[:, joint] + LENGTH[joint] * along
    return places


def angles_to(tool: np.ndarray) -> np.ndarray:
    """Angles (T, 7) of joints 1, 2 and 4 that bring the tool there: Newton's method from the middle pose."""
    q = np.zeros((len(tool), 7))
    moved, eps = (0, 1, 3), 1e-6
    for _ in range(12):
        here = frames_of(q)[:, 7]
        jacobian = np.stack(
            [(frames_of(q + eps * np.eye(7)[j])[:, 7] - here) / eps for j in moved], axis=2
        )
        q[:, moved] += np.clip(
            np.linalg.solve(jacobian, (tool - here)[..., None])[..., 0], -0.3, 0.3
        )
    return q


def _outline() -> list[np.ndarray]:
    """Points (m, 2) of the four figures in their plane, in units of the cube's edge."""
    turn = np.linspace(0.0, 2 * np.pi, 200)[:, None]
    circle = np.hstack([np.sin(turn), 1.0 - np.cos(turn)])
    line = np.linspace(-0.4, 0.4, 80)[:, None] * np.array([[1.0, 1.0]])
    corner = np.array([[-0.4, -0.4], [0.4, -0.4], [0.4, 0.4], [-0.4, 0.4], [-0.4, -0.4]])
    s = np.linspace(0.0, 4.0, 400)
    rectangle = np.column_stack([np.interp(s, np.arange(5), corner[:, k]) for k in (0, 1)])
    return [line, 0.4 * circle - [0, 0.4], 0.05 * circle - [0, 0.05], rectangle]


def desired_path(sample: float, factor: float, cycles: int) -> tuple[np.ndarray, ...]:
    """Time, tool (T, 3), figure and cycle numbers of the path, slowed by a factor."""
    u, v = np.array([0.0, 1.0, 0.0]), np.array([-0.5, 0.0, 0.85])
    points, figure = [], []
    for number, flat in enumerate(_outline()):
        length = EDGE * np.sum(np.hypot(*np.diff(flat, axis=0).T))
        steps = max(20, int(length / SPEED * 1.5 * factor / sample))
        share = np.linspace(0.0, 1.0, steps)
        share = share**3 * (10 - 15 * share + 6 * share**2)  # at rest at both ends
        place = np.interp(share, np.linspace(0, 1, len(flat)), np.arange(len(flat)))
        along = np.column_stack(
            [np.interp(place, np.arange(len(flat)), flat[:, k]) for k in (0, 1)]
        )
        rest = np.repeat(along[-1:], int(1.0 * factor / sample), axis=0)
        points += [along, rest]
        figure += [np.full(len(along) + len(rest), number)]
        gap = _outline()[(number + 1) % 4][0] - along[-1]
        if np.any(gap):
            ramp = np.linspace(0, 1, int(1.0 * factor / sample))[:, None]
            points.append(along[-1] + (3 * ramp**2 - 2 * ramp**3) * gap)
            figure.append(np.full(len(ramp), number))
    flat = np.concatenate(points)
    middle = frames_of(np.zeros((1, 7)))[0, 7]
    tool = middle + EDGE * (flat[:, :1] * u + flat[:, 1:] * v)
    number = np.concatenate(figure)
    return (
        np.arange(len(tool) * cycles) * sample,
        np.tile(tool, (cycles, 1)),
        np.tile(number, cycles),
        np.repeat(np.arange(cycles), len(tool)),
    )


def _filtered(torque: np.ndarray, sample: float, integrator: bool) -> np.ndarray:
    """Angle error that a disturbance torque leaves: s d/(J (s + pole)^3), or d/(J (s + pole)^2) without integrator."""
    keep = np.exp(-POLE * sample)
    hold = np.exp(
        -0.15 * POLE * sample
    )  # the integrator, slower than the rest: more is left in slow trials
    low = torque / (INERTIA * POLE**2)
    for _ in range(2):
        low = lfilter([1 - keep], [1, -keep], low - low[0]) + low[0]
    return low - lfilter([1 - hold], [1, -hold], low - low[0]) - low[0] if integrator else low


def trial_run(
    plant: str, trial: str, compensator: str, seed: int, sample: float, cycles: int
) -> TrialRun:
    """One run; its errors are hysteresis through the closed loop, less what the compensator takes away."""
    factor = 1.0 if trial == "fast" else 10.0
    t, desired_tool, figure, cycle = desired_path(
        sample * factor, factor, cycles if trial == "fast" else 1
    )
    one = int(np.searchsorted(cycle, 1))
    desired = np.tile(angles_to(desired_tool[:one]), (len(t) // one, 1))
    rng = np.random.default_rng([seed, TRIALS.index(trial), PLANTS.index(plant)])
    integrator = trial != "slow_no_integrator"
    angle, torques, comp = desired.copy(), np.zeros_like(desired), np.zeros_like(desired)
    missing = np.zeros_like(desired)
    acceleration = np.gradient(np.gradient(desired, t, axis=0), t, axis=0)
    for j in (0, 1, 3, 5, 6):
        scale = SIZE[plant] * (1 + 0.05 * rng.standard_normal())
        loss = (
            scale
            * PrandtlIshlinskii([0.02, 0.06, 0.15], [0.4, 0.3, 0.3]).simulate(desired[:, j])
            / 0.15
        )
        creep = 0.4 * np.log1p(t / 5.0) + 0.05 * scale
        on = compensator != "off" and j + 1 in JOINTS and identification(plant, j + 1).accepted
        left = (
            loss * LEFT[plant] + 0.1 * np.sign(np.gradient(loss)) * (SIZE[plant] > 0)
            if on
            else loss
        )
        left = left + creep + 0.2 * INERTIA * acceleration[:, j]
        noise = 2e-5 * rng.standard_normal(len(t))
        angle[:, j] = desired[:, j] - _filtered(left, sample * factor, integrator) - noise
        torques[:, j] = left if integrator else 0.0
        missing[:, j] = -left
        comp[:, j] = (loss - left) / 35.0 * 1e5 if on else 0.0
    places = np.linspace(0, one - 1, 120).astype(int)
    frames = frames_of(angle[places])
    return TrialRun(
        trial=trial,
        compensator=compensator,
        seed=seed,
        time=t,
        desired=desired,
        angle=angle,
        integrator=torques,
        torque_error=missing,
        pressure_difference=comp + 1e5 * desired,
        compensation=comp,
        pressure=np.full((len(t), 7, 2), 3e5),
        tool_desired=desired_tool,
        tool=frames_of(angle)[:, 7],
        figure=figure,
        figures=FIGURES,
        cycle=cycle,
        flags=np.zeros((len(t), 7), dtype=np.int64),
        frames=frames,
        frame_time=t[places],
    )


@lru_cache
def identification(plant: str, joint: int) -> JointIdentification:
    """A real fit of x -> q on decaying loops of a sum of plays that is not the model's grid."""
    rng = np.random.default_rng([PLANTS.index(plant), joint])
    t, q = _loops((1.0, 0.9, 0.75, 0.6, 0.45, 0.32, 0.2, 0.1))
    unseen_t, unseen_q = _loops((0.95, 0.5, 0.7, 0.25))
    shear, size = 1.0, (0.18 + 0.02 * joint) * SIZE[plant] / 6.0
    held = [
        size * _friction(angle) + 0.01 * np.log1p(time)
        for angle, time in ((q, t), (unseen_q, unseen_t))
    ]
    nominal = 5.4 * q + 2.0 * q**3
    dp = nominal + held[0] + 0.002 * rng.standard_normal(t.size)
    x = dp - nominal + shear * q
    log = {
        "time_s": t, "pressure_1_bar": 3 + dp / 2, "pressure_2_bar": 3 - dp / 2, "pressure_difference_bar": dp,
        "nominal_difference_bar": nominal, "sheared_bar": x, "angle_rad": q,
    }  # fmt: skip
    recording = dehyst.Recording(
        input=x, output=q, time=t, name="identification", input_name="x", output_name="q",
        input_unit="bar", output_unit="rad",
    )  # fmt: skip
    fit = dehyst.identify(recording, family="pi", n=40)
    inverse = fit.model.inverse().simulate(unseen_q) - shear * unseen_q
    measured = held[1] + 0.002 * rng.standard_normal(unseen_t.size)
    unseen = {
        "time_s": unseen_t,
        "angle_rad": unseen_q,
        "hysteresis_bar": measured,
        "inverse_bar": inverse,
    }
    ratio = float(np.sqrt(np.mean((measured - inverse) ** 2) / np.mean(measured**2)))
    unexplained = float(np.std(measured - inverse) / np.std(measured))
    characteristic = Characteristic(
        np.array([1e-5]), np.array([3.5e-4]), np.zeros(1), -0.63, 0.63, 1.2
    )
    return JointIdentification(joint, characteristic, log, fit, shear, unseen, ratio, unexplained)


def _friction(q: np.ndarray) -> np.ndarray:
    """Of 12 elements that slip: about +-1."""
    r = np.geomspace(0.01, 0.4, 12)
    held, stretch = np.empty(q.size), np.zeros(12)
    for k, step in enumerate(np.diff(q, prepend=0.0).tolist()):
        stretch = np.clip(stretch + step, -r, r)
        held[k] = float(np.mean(stretch / r))
    return held


def _loops(amplitudes: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    t = np.arange(0.0, 24.0 * len(amplitudes), 0.2)
    return t, 0.63 * np.array(amplitudes)[(t / 24.0).astype(int)] * np.sin(2 * np.pi * t / 24.0)


def figures_of(runs: tuple[TrialRun, ...], joints: tuple[int, ...], plant: str, seed: int) -> dict:
    """The nested figures of a plant, from its runs; spread by seed."""
    compensated = identification(plant, 1).accepted

    def noise(run: TrialRun, number: int) -> float:
        """The same off and on where no compensator is switched on."""
        on = int(compensated and run.compensator != "off")
        return float(
            np.random.default_rng([seed, number, TRIALS.index(run.trial), on]).standard_normal()
        )

    joint_figures: dict = {}
    tool: dict = {}
    for joint in joints:
        found = identification(plant, joint)
        trials: dict = {}
        for run in runs:
            error = np.rad2deg(run.error[:, joint - 1]) * (1 + 0.04 * noise(run, joint))
            trials.setdefault(run.trial, {})[run.compensator] = {
                "rms_deg": float(np.sqrt(np.mean(error**2))),
                "max_deg": float(np.max(np.abs(error))),
            }
        joint_figures[joint] = {
            "identification": {
                "nonzero_weights": found.nonzero_weights + seed,
                "inverse_rms_ratio_unseen": found.inverse_rms_ratio * (1 + 0.05 * seed),
                "unexplained_unseen": found.unexplained * (1 + 0.05 * seed),
                "accepted": found.accepted,
                "calibration_residual_Nm": found.characteristic.residual,
            },
            "trials": trials,
        }
    for run in runs:
        distance = (
            1e3 * np.linalg.norm(run.tool - run.tool_desired, axis=1) * (1 + 0.03 * noise(run, 9))
        )
        tool.setdefault(run.trial, {})[run.compensator] = _tool_figures(run, distance)
    return {"joints": joint_figures, "tool": tool}


def _tool_figures(run: TrialRun, distance: np.ndarray) -> dict:
    """In the shape of `dehyst.design.iso9283`; distance (T,) from where the tool should be. [mm]"""
    rms, largest, cycles = (
        float(np.sqrt(np.mean(distance**2))),
        float(distance.max()),
        int(run.cycle.max()) + 1,
    )
    again = cycles > 1
    found = {
        "AT_mm": 0.8 * rms, "RT_mm": 0.1 * rms if again else None, "CR_mm": 9.0 + 0.1 * rms, "CO_mm": 0.3 * rms,
        "AV_percent": -0.4 - 0.1 * rms, "RV_percent": 1.2 if again else None, "FV_mm_s": 5.0 + rms,
        "tracking_rms_mm": rms, "tracking_max_mm": largest, "tracking_p95_mm": 0.7 * largest,
    }  # fmt: skip
    missing = {name: "needs two cycles or more" for name in ("RT_mm", "RV_percent") if not again}
    speed = {"command_speed_mm_s": 300.0, "share_at_command_speed": 0.9, "sections_missed": 0.0}
    parts = {}
    for k, name in enumerate(FIGURES):
        part = {key: value and value / (1 + k) for key, value in found.items()}
        corners = {} if name == "rectangle" else dict.fromkeys(("CR_mm", "CO_mm"))
        parts[name] = (
            part | corners | speed | {"reasons": missing | dict.fromkeys(corners, "no corners")}
        )
    return found | {"cycles": cycles, "sections_missed": 0.0, "reasons": missing, "figures": parts}


def plant_result(
    plant: str,
    *,
    seeds=(0, 1, 2),
    joints=(1, 2, 4),
    sample=0.05,
    cycles=3,
    compensators=("off", "paper"),
) -> PlantResult:
    """Everything of one plant."""
    runs = tuple(
        trial_run(plant, trial, name, 0, sample, cycles)
        for trial in TRIALS
        for name in compensators
    )
    return PlantResult(
        plant=plant,
        identifications={joint: identification(plant, joint) for joint in joints},
        runs=runs,
        figures={seed: figures_of(runs, joints, plant, seed) for seed in seeds},
        real_time_factor=31.4,
    )


def rest_study() -> dict:
    """Integrator over a rest of 200 s: level differs, drift is equal."""
    t = np.linspace(0.0, 200.0, 400)
    creep = 0.4 * np.exp(-t / 40.0) - 0.007 * t
    return {"time_s": t, "integrator_off_Nm": 4.0 + creep, "integrator_on_Nm": 0.5 + creep}


def studies() -> dict:
    """All four studies."""
    scale = np.array([0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5])
    ratio = np.hypot((scale - 1.0), 0.2) / np.maximum(scale, 0.2)
    return {
        "rest": rest_study(),
        "smaller hysteresis": {"scale": scale, "ratio_rms": ratio, "ratio_max": 1.3 * ratio},
        "double compensation": {
            "case": [
                "none",
                "compensator",
                "compensator twice",
                "model of friction and compensator",
            ],
            "ratio_rms": np.array([1.0, 0.22, 1.05, 0.85]),
        },
        "high gains": {
            "pole_1_s": np.array([4.0, 6.0, 8.0, 12.0, 16.0]),
            "ratio_rms": [0.21, 0.3, 0.42, 0.62, 0.8],
        },
    }


@lru_cache
def sample_reproduction(
    plants=PLANTS, seeds=(0, 1, 2), joints=(1, 2, 4), with_studies=True, **options
) -> Reproduction:
    """The experiment on some plants; the same arguments give the same object."""
    return Reproduction(
        plants={
            plant: plant_result(plant, seeds=seeds, joints=joints, **options) for plant in plants
        },
        compensator="paper",
        settings=SETTINGS | {"seeds": list(seeds)},
        studies=studies() if with_studies else {},
    )
