"""Sensor and reference faults are detected, bridged, flagged and forgotten; if they last, the joint fails safe."""

import math
from dataclasses import replace

import numpy as np
import pytest

from dehyst_robot.control import (
    FLAGS,
    SWITCHES,
    JointController,
    JointControllerParameters,
    JointReference,
)
from joint_oracles import PERIOD, Rig, closed_loop, column, reference_along

JOINT = JointControllerParameters(frozen_samples=100, hold_samples=40)
REFERENCE = reference_along(PERIOD * np.arange(4000))
ON = SWITCHES["position"] | SWITCHES["integrator"]
START = 2800  # at speed: 0.25 rad/s
FAULT = ("angle-fault", "pressure-fault-1", "pressure-fault-2")
STICKY = FLAGS["failed"] | FLAGS["fault-ever"]


def replaced(sensor, value):
    """Return a spoiler that puts a value (or a function of the reading) in the place of one sensor's reading."""

    def spoil(reading):
        changed = list(reading)
        changed[sensor] = value(reading[sensor]) if callable(value) else value
        return changed

    return spoil


def run(spoil, samples, joint=JOINT, reference=REFERENCE, start=START):
    """Run with readings spoiled for some samples: (angles, flags (T,), outputs)."""

    def change(k, reading):
        return spoil(reading) if start <= k < start + samples else reading

    q, outputs = closed_loop(JointController(joint), Rig(joint), reference, ON, change)
    return q, column(outputs, "flags"), outputs


CLEAN = run(lambda reading: reading, 0)
KINDS = {
    "nan": math.nan,
    "infinite": -math.inf,
    "huge": 1e300,
    "no answer": None,
    "jump": lambda x: x + (0.3 if abs(x) < 10 else 1.5e5),
}


def test_a_sound_joint_raises_no_flag():
    assert not CLEAN[1].any()


@pytest.mark.spread(8)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("sensor", [0, 1, 2])
def test_a_short_fault_is_flagged_bridged_and_forgotten(sensor, kind):
    q, flags, outputs = run(replaced(sensor, KINDS[kind]), 30)
    hit = (flags & FLAGS[FAULT[sensor]]) != 0
    assert hit[START : START + 30].all()
    assert hit.sum() == 30  # no sooner, no later
    assert np.all((flags[START:] & STICKY) == FLAGS["fault-ever"])
    assert not flags[:START].any()
    assert np.max(np.abs(q - CLEAN[0])) < 1e-3
    assert np.max(np.abs(column(outputs, "angle") - q)) < 2e-3


@pytest.mark.spread(8)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("sensor", [0, 1, 2])
def test_a_fault_that_lasts_closes_the_valves_for_good(sensor, kind):
    _, flags, outputs = run(replaced(sensor, KINDS[kind]), 60)
    failed = (flags & FLAGS["failed"]) != 0
    assert (
        np.flatnonzero(failed)[0] == START + JOINT.hold_samples
    )  # 40 are bridged, the next one is too many
    assert failed[START + JOINT.hold_samples :].all()
    valves = np.array([(o.valve_1, o.valve_2) for o in outputs])
    assert not valves[failed].any()
    assert valves[~failed].any()
    assert not (flags[-1] & FLAGS[FAULT[sensor]])  # the flags tell that the sensor is well again


def test_a_reset_ends_the_failure():
    controller = JointController(JOINT)
    controller.reset(0.0, 3e5, 3e5)
    for _ in range(50):
        out = controller.step(math.nan, 3e5, 3e5, JointReference(), ON)
    assert out.raised("failed")
    controller.reset(0.0, 3e5, 3e5)
    assert controller.step(0.0, 3e5, 3e5, JointReference(), ON).flags == 0


@pytest.mark.parametrize("bad", [(math.nan, 3e5, 3e5), (0.0, math.inf, 3e5), (0.0, 3e5, 1e200)])
def test_a_start_without_a_sensor_fails_safe(bad):
    controller = JointController(JOINT)
    controller.reset(*bad)
    out = controller.step(0.0, 3e5, 3e5, JointReference(0.2), ON)
    assert out.raised("failed")
    assert (out.valve_1, out.valve_2) == (0.0, 0.0)


def frozen(sensor):
    kept = []

    def spoil(reading):
        kept.append(reading[sensor])
        changed = list(reading)
        changed[sensor] = kept[0]
        return changed

    return spoil


@pytest.mark.parametrize("sensor", [1, 2])
def test_a_frozen_pressure_sensor_is_found_bridged_and_forgotten(sensor):
    q, flags, _ = run(frozen(sensor), JOINT.frozen_samples + 25)
    hit = np.flatnonzero(flags & FLAGS[FAULT[sensor]])
    assert hit[0] == START + JOINT.frozen_samples
    assert hit[-1] == START + JOINT.frozen_samples + 24
    assert not (flags & FLAGS["failed"]).any()
    assert np.max(np.abs(q - CLEAN[0])) < 0.02
    _, flags, _ = run(frozen(sensor), 400)
    assert (
        np.flatnonzero(flags & FLAGS["failed"])[0]
        == START + JOINT.frozen_samples + JOINT.hold_samples
    )


def test_a_pressure_is_bridged_right_while_a_valve_is_at_its_limit():
    # 4 bar more of dp at once: the valves are fully open and the desired pressure is no guide to the true one.
    joint = replace(JOINT, ramp=0.0)
    reference = np.zeros((1500, 7))
    reference[:, 4], reference[1000:, 5] = 3e5, 4e5
    controller, rig = JointController(joint), Rig(joint)
    spoil = replaced(1, math.nan)
    _, outputs = closed_loop(
        controller,
        rig,
        reference,
        0,
        lambda k, reading: spoil(reading) if 1005 <= k < 1035 else reading,
    )
    flags = column(outputs, "flags")
    assert (flags[1005:1035] & FLAGS["valve-limit"]).all()
    assert np.array_equal(np.flatnonzero(flags & FLAGS["pressure-fault-1"]), np.arange(1005, 1035))


def test_a_frozen_encoder_of_a_moving_joint_is_found():
    _, flags, outputs = run(frozen(0), 400)
    hit = np.flatnonzero(flags & FLAGS["angle-fault"])
    assert hit[0] <= START + JOINT.frozen_samples + 3
    assert np.flatnonzero(flags & FLAGS["failed"])[0] == hit[0] + JOINT.hold_samples
    assert outputs[-1].valve_1 == outputs[-1].valve_2 == 0.0


def test_a_joint_at_rest_has_no_frozen_encoder():
    reference = np.zeros((6000, 7))
    reference[:, 4] = 3e5
    joint = JOINT
    rig = Rig(joint, noise=250.0, load=lambda q: 15.0 * math.sin(q) + 6.0)
    _, outputs = closed_loop(JointController(joint), rig, reference, ON)
    still = JointController(joint)
    still.reset(0.1, 3e5, 3e5)
    noise = np.random.default_rng(3).normal(size=(6000, 2)) * 250
    drift = np.linspace(0, 2e4, 6000)  # pressures creep, the encoder says the same all the time
    answers = [still.step(0.1, 3e5 + a + d, 3e5 + b - d, JointReference(0.1), ON) for (a, b), d in
               zip(noise, drift, strict=True)]  # fmt: skip
    assert not (column(outputs, "flags") & FLAGS["angle-fault"]).any()
    assert not (column(answers, "flags") & FLAGS["angle-fault"]).any()


def test_a_joint_that_stops_smoothly_has_no_frozen_encoder():
    stop = reference_along(PERIOD * np.arange(8000))
    stop[2000:, 0], stop[2000:, 1:3] = stop[2000, 0], 0.0  # at its turning point
    _, outputs = closed_loop(JointController(JOINT), Rig(JOINT), stop, ON)
    assert not (column(outputs, "flags") & FLAGS["angle-fault"]).any()


def test_a_vented_muscle_is_not_a_frozen_sensor():
    controller = JointController(JOINT)
    controller.reset(0.0, 0.0, 0.0)
    rng = np.random.default_rng(0)
    outputs = [
        controller.step(1e-3 * rng.normal(), 0.0, 0.0, JointReference(mean_pressure=0.2e5), 0)
        for _ in range(400)
    ]
    assert not column(outputs, "flags").any()


@pytest.mark.parametrize("field", range(7))
def test_a_reference_that_is_no_number_is_held_and_flagged(field):
    spoiled = REFERENCE.copy()
    spoiled[START : START + 20, field] = [math.nan, math.inf, -math.inf, 1e300] * 5
    q, outputs = closed_loop(JointController(JOINT), Rig(JOINT), spoiled, ON)
    flags = column(outputs, "flags")
    hit = (flags & FLAGS["reference-fault"]) != 0
    assert np.array_equal(np.flatnonzero(hit), np.arange(START, START + 20))
    assert (flags[START:] & FLAGS["fault-ever"]).all()
    assert not (flags & FLAGS["failed"]).any()
    assert np.max(np.abs(q - CLEAN[0])) < 2e-3


def test_checks_can_be_switched_off():
    joint = JointControllerParameters(frozen_samples=0, angle_jump=0.0, pressure_jump=0.0)
    _, flags, _ = run(replaced(1, lambda x: 3.3e5), 500, joint)
    assert not (flags & FLAGS["fault-ever"]).any()
