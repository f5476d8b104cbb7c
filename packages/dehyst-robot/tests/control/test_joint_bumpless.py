"""Switching position control, integrator and compensator, or exchanging it, never makes dp_d jump."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dehyst import PrandtlIshlinskii
from dehyst_robot.control import (
    SWITCHES,
    InverseCompensator,
    JointController,
    JointControllerParameters,
    JointReference,
    along,
)
from joint_oracles import PERIOD, reference_along

JOINT = JointControllerParameters(frozen_samples=0, ramp=0.05, angle_jump=0.0)
PAPER = PrandtlIshlinskii([0.0, 0.3, 0.8, 1.5], [0.6, 0.2, 0.1, 0.05]).inverse()
OTHER = PrandtlIshlinskii([0.0, 0.2, 1.0], [0.9, 0.3, 0.1], offset=0.05).inverse()
SAMPLES = 900


def signals():
    """Return readings and references of a joint that lags and errs a little, smooth and noise-free."""
    t = PERIOD * np.arange(SAMPLES)
    reference = reference_along(4 * t, amplitude=0.3)
    reference[:, 1] *= 4
    reference[:, 2] *= 16
    reference[:, 3] = 5 * np.sin(9 * t)
    reference[:, 5] = 0.5e5 * np.cos(7 * t)
    reference[:, 6] = 0.1e5 * np.sin(11 * t)
    q = 0.9 * reference[:, 0] + 0.02 * np.sin(5 * t)
    dp = 1e5 * np.sin(6 * t)
    return q, 3e5 + dp / 2, 3e5 - dp / 2, reference


EVENTS = st.lists(
    st.tuples(st.integers(1, SAMPLES - 1), st.sampled_from([*range(8), "exchange", "none"])),
    min_size=1,
    max_size=12,
)


def peek(controller, reading, reference, switches):
    """Return the dp_d that the controller would answer, leaving it as it is."""
    image = controller.save()
    out = controller.step(*reading, JointReference(*reference), switches)
    controller.restore(image)
    return out.pressure_difference


@pytest.mark.slow
@given(EVENTS, st.integers(0, 7))
@settings(max_examples=60)
def test_no_switch_at_any_time_makes_a_bump(events, switches):
    q, p_1, p_2, reference = signals()
    controller = JointController(JOINT, PAPER)
    controller.reset(q[0], p_1[0], p_2[0])
    at, last = dict(events), 0.0
    for k in range(SAMPLES):
        reading, event, before = (q[k], p_1[k], p_2[k]), at.get(k), switches
        if event in (
            "exchange",
            "none",
        ):  # while the reference does not move, an exchange changes nothing
            unchanged = peek(controller, reading, reference[k - 1], switches)
            controller.exchange(OTHER if event == "exchange" else None, shear=2e5)
            assert peek(controller, reading, reference[k - 1], switches) == pytest.approx(
                unchanged, rel=1e-9, abs=1e-4
            )
        elif event is not None:
            switches = event
            turned = (before ^ switches) & SWITCHES[
                "position"
            ]  # position control goes on from the last dp_d
            expected = last if turned else peek(controller, reading, reference[k], before)
            assert peek(controller, reading, reference[k], switches) == pytest.approx(
                expected, rel=1e-9, abs=1e-4
            )
        last = controller.step(
            *reading, JointReference(*reference[k]), switches
        ).pressure_difference


@given(st.lists(st.tuples(st.integers(1, 399), st.integers(0, 7)), min_size=1, max_size=6))
@settings(max_examples=40)
def test_a_switched_term_moves_no_faster_than_its_ramp(events):
    # Nothing else moves: at a constant reference and constant readings all that changes is switching and I.
    controller = JointController(JOINT, PAPER)
    q, q_d = 0.1, 0.12
    controller.reset(q, 3.2e5, 2.8e5)
    reference = JointReference(q_d, load=8.0, pressure_difference=-0.3e5, extra=0.2e5)
    at, switches, dp, terms = dict(events), 0, [], []
    for k in range(400):
        switches = at.get(k, switches)
        out = controller.step(q, 3.2e5, 2.8e5, reference, switches)
        dp.append(out.pressure_difference)
        terms.append(abs(out.integrator) / 3.4e-4)
    everything = 6 * 1e5 + 2 * max(terms)  # more than all terms together [Pa]
    integrating = PERIOD * JOINT.inertia * JOINT.pole**3 * (q_d - q) / 3.4e-4
    assert np.max(np.abs(np.diff(dp))) <= everything * PERIOD / JOINT.ramp + 1.1 * integrating


def test_a_term_that_faded_in_is_there_in_full_and_one_that_faded_out_is_gone():
    controller = JointController(JOINT, PAPER)
    controller.reset(0.0, 3e5, 3e5)
    reference = JointReference(0.2, extra=0.1e5)
    on, off = SWITCHES["position"] | SWITCHES["compensator"], SWITCHES["position"]
    outputs = [controller.step(0.0, 3e5, 3e5, reference, on) for _ in range(150)]
    term = along(InverseCompensator(PAPER, JOINT.shear), [0.2])[0] + 0.1e5
    assert outputs[-1].compensation == pytest.approx(term, rel=1e-12)
    assert outputs[50].compensation == pytest.approx(term / 2, rel=0.03)
    outputs += [controller.step(0.0, 3e5, 3e5, reference, off) for _ in range(150)]
    assert outputs[-1].compensation == 0.0
    assert outputs[149].pressure_difference - outputs[-1].pressure_difference == pytest.approx(
        term, rel=1e-9
    )


def test_the_integrator_runs_out_over_the_ramp():
    controller = JointController(replace(JOINT, ramp=0.1))
    controller.reset(0.0, 3e5, 3e5)
    both = SWITCHES["position"] | SWITCHES["integrator"]
    grown = [
        controller.step(0.0, 3e5, 3e5, JointReference(0.02), both).integrator for _ in range(400)
    ]
    gone = [
        controller.step(0.0, 3e5, 3e5, JointReference(0.02), SWITCHES["position"]).integrator
        for _ in range(300)
    ]
    assert grown[-1] > 1.0
    assert abs(gone[0] - grown[-1]) <= 1.1 * (grown[-1] - grown[-2])
    np.testing.assert_allclose(np.diff(gone[:200]), -gone[0] * PERIOD / 0.1, rtol=1e-6)
    assert gone[-1] == 0.0


def test_the_compensator_follows_the_desired_path_while_it_is_off():
    _, _, _, reference = signals()
    reference[:, 6] = 0.0
    outputs = {}
    for early in (0, 600):
        controller = JointController(JOINT, PAPER)
        controller.reset(0.0, 3e5, 3e5)
        switches = np.where(np.arange(SAMPLES) >= early, 5, 1)
        outputs[early] = controller.run(
            reference[:, 0], *np.full((2, SAMPLES), 3e5), reference, switches
        )
    expected = along(InverseCompensator(PAPER, JOINT.shear), reference[:, 0])
    for early, out in outputs.items():
        np.testing.assert_allclose(
            out.compensation[early + 110 :], expected[early + 110 :], atol=1e-6
        )
    assert np.ptp(expected) > 1e4


def test_an_own_compensator_by_the_reference_is_as_good_as_the_built_in_one():
    _, _, _, reference = signals()
    reference[:, 6] = 0.0
    own = reference.copy()
    own[:, 6] = along(InverseCompensator(PAPER, JOINT.shear), reference[:, 0])
    answers = []
    for model, wanted in ((PAPER, reference), (None, own)):
        controller = JointController(JOINT, model)
        controller.reset(0.0, 3e5, 3e5)
        answers.append(
            controller.run(
                0.9 * wanted[:, 0], *np.full((2, SAMPLES), 3e5), wanted, np.full(SAMPLES, 7)
            )
        )
    for name in ("valve_1", "valve_2", "pressure_difference"):
        np.testing.assert_allclose(
            getattr(answers[0], name), getattr(answers[1], name), rtol=1e-7, atol=1e-8
        )


def test_after_an_exchange_the_new_compensator_is_alone():
    controller = JointController(JOINT, PAPER)
    controller.reset(0.0, 3e5, 3e5)
    reference = JointReference(0.25)
    for _ in range(200):
        controller.step(0.2, 3e5, 3e5, reference, 5)
    controller.exchange(OTHER, shear=2e5)
    terms = [controller.step(0.2, 3e5, 3e5, reference, 5).compensation for _ in range(200)]
    assert terms[0] == pytest.approx(along(InverseCompensator(PAPER, 1e5), [0.25])[0], rel=1e-9)
    assert terms[-1] == pytest.approx(along(InverseCompensator(OTHER, 2e5), [0.25])[0], rel=1e-9)
    assert np.max(np.abs(np.diff(terms))) <= 1.01 * abs(terms[-1] - terms[0]) * PERIOD / JOINT.ramp
