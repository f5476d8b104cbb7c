"""Learning of a direct inverse: bounds whatever comes, convergence, rest on contact, used only if better."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dehyst.errors import ParameterError
from dehyst.models import DirectInverse, ModelCard, SignalCard
from dehyst_robot.control import (
    FLAGS,
    SWITCHES,
    Adaptation,
    JointController,
    JointControllerParameters,
    JointReference,
    kit,
)

CARD = ModelCard(SignalCard("torque", "Nm", -20.0, 20.0), SignalCard("angle", "rad", -0.7, 0.7))
MODEL = DirectInverse(
    radii=[0.02, 0.1, 0.4],
    stop_weights=[80.0, 30.0, 8.0],
    path_lengths=[0.05],
    path_weights=[20.0],
    time_constants=[0.5],
    creep_weights=[3.0],
    polynomial=[0.0, 1.0],
    viscous=0.5,
    card=CARD,
)
PERIOD = 0.01  # the controller's own is 0.5 ms; learning knows only rate times period
JOINT = JointControllerParameters(
    period=PERIOD, inertia=2.0, observer_pole=20.0, angle_jump=0.0, pressure_jump=0.0, frozen_samples=0,
    a=(0.0,), b=(3.5e-4,), c=(0.0,),
)  # fmt: skip
LEARNS = SWITCHES["adapt"]
EVERY = sum(SWITCHES.values())
ANY = st.one_of(
    st.floats(),
    st.sampled_from([math.nan, math.inf, -math.inf, 1e300, -1e300, 1e99, -1e99, 5e-324, 0.0, -0.0]),
    st.floats(-0.7, 0.7),
    st.floats(0, 6e5),
)
SAMPLE = st.tuples(ANY, ANY, ANY, st.tuples(*[ANY] * 7), st.integers(0, EVERY))


def learner(adaptation=None, model=MODEL, joint=JOINT):
    controller = JointController(joint, model, adaptation or Adaptation())
    controller.reset(0.0, 3e5, 3e5)
    return controller


def in_bounds(controller, adaptation):
    values = np.concatenate([controller.scales, controller.applied])
    assert np.isfinite(values).all()
    assert values.min() >= adaptation.lowest
    assert values.max() <= adaptation.highest
    assert abs(controller.offset) <= adaptation.offset_limit


@pytest.mark.parametrize("guarded", [True, False])
@settings(max_examples=60, deadline=None)
@given(
    samples=st.lists(SAMPLE, min_size=1, max_size=40),
    bounds=st.tuples(st.floats(0, 1), st.floats(1, 5), st.floats(0, 10)),
    rate=st.floats(0, 1e6),
    memory=st.floats(0, 1e6),
    ratio=st.floats(0, 1e6),
    patience=st.floats(0, 1e6),
    settling=st.floats(0, 1e6),
)
def test_no_sequence_of_inputs_leaves_the_bounds_or_makes_nan(
    samples, bounds, rate, memory, ratio, patience, settling, guarded
):
    guards = {} if guarded else {"angle_jump": 0.0, "pressure_jump": 0.0, "hold_samples": 1000}
    lowest, highest, offset = bounds
    adaptation = Adaptation(
        rate=rate, memory=memory, contact_ratio=ratio, patience=patience, settling=settling, lowest=lowest,
        highest=highest, offset_limit=offset,
    )  # fmt: skip
    controller = learner(adaptation, joint=JointControllerParameters(period=PERIOD, **guards))
    for angle, p_1, p_2, reference, switches in samples:
        out = controller.step(angle, p_1, p_2, JointReference(*reference), switches | LEARNS)
        in_bounds(controller, adaptation)
        assert math.isfinite(out.contact)
        assert math.isfinite(out.doubt)


@settings(max_examples=40, deadline=None)
@given(samples=st.lists(SAMPLE, min_size=5, max_size=40), split=st.integers(1, 4))
def test_a_restored_state_goes_on_learning_to_the_bit(samples, split):
    first, second = learner(), learner()
    for k, (angle, p_1, p_2, reference, switches) in enumerate(samples):
        if k == split:
            second.restore(first.save())
        told = JointReference(*reference)
        a = first.step(angle, p_1, p_2, told, switches | LEARNS)
        if k >= split:
            b = second.step(angle, p_1, p_2, told, switches | LEARNS)
            assert np.array_equal([a.contact, a.doubt, a.load], [b.contact, b.doubt, b.load])
    assert first.scales.tolist() == second.scales.tolist()
    assert first.applied.tolist() == second.applied.tolist()


def quasistatic(truth, seconds=120.0, push=lambda t: 0.0, adaptation=None, swing=0.3, model=MODEL):
    """Learner and contact of a joint that is moved slowly by its pressures; what its muscles need for it is `truth`."""
    controller = learner(adaptation, model)
    t = PERIOD * np.arange(round(seconds / PERIOD))
    q = swing * np.sin(0.8 * t) * np.clip(t / 3.0, 0, 1)
    needed = truth.run(q, t).u
    inertial = JOINT.inertia * np.gradient(np.gradient(q, PERIOD), PERIOD)
    contact = np.zeros(t.size)
    for k, angle in enumerate(q):
        # With A = C = 0 the torque that pressures make is B dp; the observer sees what of it did not accelerate.
        difference = (needed[k] + inertial[k] + push(t[k])) / JOINT.b[0]
        out = controller.step(
            angle, 3e5 + difference / 2, 3e5 - difference / 2, JointReference(angle), LEARNS
        )
        contact[k] = out.contact
    return controller, contact


def rms(x):
    return float(np.sqrt(np.mean(np.square(x))))


@pytest.mark.parametrize(
    "scales", [(0.5, 0.5, 1.0, 1.0), (1.5, 1.5, 1.0, 1.0), (0.6, 1.4, 1.0, 1.0)]
)
def test_scales_of_another_actuator_are_learned(scales):
    controller, contact = quasistatic(MODEL.scaled(scales))
    assert controller.applied[:2] == pytest.approx(scales[:2], abs=0.12)
    untaught = quasistatic(MODEL.scaled(scales), adaptation=Adaptation(rate=0.0))[1]
    assert rms(contact[-3000:]) < 0.3 * rms(untaught[-3000:])


def test_a_model_that_no_longer_fits_is_flagged_and_scaled_down_and_one_that_fits_is_not():
    still, off = (
        Adaptation(rate=0.0),
        2 * np.pi / 0.8,
    )  # nothing is learned; seconds of a stroke up and one down
    fits, _ = quasistatic(MODEL, adaptation=still)
    assert fits.applied.tolist() == [1.0] * len(fits.applied)
    for scale in (0.0, 0.5):
        controller, _ = quasistatic(MODEL.scaled((scale,) * 4), seconds=3 * off, adaptation=still)
        assert (controller.applied < scale + 0.1).all()
        assert (controller.applied >= 0.0).all()


def test_an_offset_is_learned():
    controller, _ = quasistatic(MODEL.scaled((1.0, 1.0, 1.0, 1.0), offset=0.4))
    assert controller.offset == pytest.approx(0.4, abs=0.1)


def test_a_model_that_is_right_stays_as_it_is():
    controller, contact = quasistatic(MODEL)
    assert controller.applied == pytest.approx([1.0] * 4, abs=0.15)
    assert rms(contact[-3000:]) < 0.1


@pytest.mark.parametrize("size", [5.0, -5.0])
def test_contact_is_seen_and_not_learned(size):
    truth = MODEL.scaled((1.0, 1.0, 1.0, 1.0))
    push = lambda t: size if 80.0 <= t < 95.0 else 0.0  # noqa: E731
    before = quasistatic(truth, 79.0)[0].scales
    controller, contact = quasistatic(truth, 110.0, push)
    during = contact[round(81 / PERIOD) : round(94 / PERIOD)]
    assert during.mean() == pytest.approx(size, abs=0.15)
    assert controller.scales == pytest.approx(before, abs=0.1)
    assert abs(contact[round(97 / PERIOD) :]).max() < 0.5


def test_without_the_rule_for_contact_it_is_learned():
    push = lambda t: 5.0 if 80.0 <= t < 95.0 else 0.0  # noqa: E731
    careful = Adaptation(offset_limit=10.0, unit=10.0)
    careless = replace(careful, most_error=1e6)
    assert quasistatic(MODEL, 95.0, push, careful)[1][-1] == pytest.approx(5.0, abs=0.3)
    assert quasistatic(MODEL, 95.0, push, careless)[1][-1] < 3.0


def test_a_load_that_stays_is_learned_after_a_while():
    controller, contact = quasistatic(
        MODEL,
        200.0,
        lambda t: 1.5 if t >= 40.0 else 0.0,
        Adaptation(patience=20.0, offset_limit=2.0, settling=0.0),
    )
    assert contact[round(45 / PERIOD)] == pytest.approx(1.5, abs=0.3)
    assert controller.offset == pytest.approx(1.5, abs=0.3)


ALONG = LEARNS | SWITCHES["position"]


def nobody(t, way):
    return 0.0


def along_path(
    push=nobody,
    seconds=160.0,
    truth=MODEL,
    adaptation=None,
    size=lambda t: 0.3,
    rate=0.8,
    inertia=1.0,
):
    """Scales and flags of a joint under position control that is dragged to and fro as it shall move, and pushed.

    The size of the strokes may change with time; its inertia is so many times that of the controller.
    """
    controller = learner(adaptation)
    t = PERIOD * np.arange(round(seconds / PERIOD))
    q = np.vectorize(size)(t) * np.sin(rate * t) * np.clip(t / 3.0, 0, 1)
    speed = np.gradient(q, PERIOD)
    acceleration = np.gradient(speed, PERIOD)
    needed = truth.run(q, t).u + inertia * JOINT.inertia * acceleration
    scales, flags = [], []
    for k, angle in enumerate(q):
        pushed = push(t[k], np.tanh(speed[k] / 0.01))
        difference = (needed[k] + pushed) / JOINT.b[0]
        wanted = JointReference(angle, speed[k], acceleration[k])
        out = controller.step(angle, 3e5 + difference / 2, 3e5 - difference / 2, wanted, ALONG)
        scales.append(controller.applied)
        flags.append(out.flags)
    return np.array(scales), np.array(flags), t


@pytest.mark.parametrize("size", [-10.0, -4.0, 4.0, 10.0])
def test_a_hand_that_brakes_or_helps_is_never_learned_as_hysteresis_and_is_told(size):
    scales, flags, t = along_path(lambda t, way: size * way if 60.0 <= t < 140.0 else 0.0)
    touched = flags & FLAGS["touched"] != 0
    held = (t >= 60.0) & (t < 140.0)
    assert touched[held][round(1.0 / PERIOD) :].all()
    assert not touched[t < 60.0].any() and not touched[t > 145.0].any()
    before = scales[round(59.0 / PERIOD)]
    assert scales[t >= 60.0] == pytest.approx(
        np.broadcast_to(before, scales[t >= 60.0].shape), abs=0.15
    )
    assert not (flags & (FLAGS["stale"] | FLAGS["shifted"])).any()


def test_without_the_rule_of_sudden_errors_the_same_hand_is_learned():
    hand = lambda t, way: -4.0 * way if 60.0 <= t < 140.0 else 0.0  # noqa: E731
    scales, flags, t = along_path(hand, adaptation=Adaptation(settling=0.0))
    assert np.abs(scales[t < 140.0][-1] - 1.0).max() > 0.4
    assert not (flags & FLAGS["touched"]).any()


def test_large_strokes_after_small_ones_are_no_touch_and_what_they_show_is_learned():
    for scale in (0.5, 1.5):
        scales, flags, _ = along_path(
            seconds=200.0,
            truth=MODEL.scaled((1.0, scale, 1.0, 1.0)),
            size=lambda t: 0.3 if t >= 60.0 else 0.03,
        )
        assert np.mean(flags & FLAGS["touched"] != 0) < 0.02
        assert scales[-1, 1] == pytest.approx(scale, abs=0.15)


def test_twenty_percent_of_unknown_inertia_is_no_touch_at_any_speed():
    for rate in (0.8, 2.0, 4.0):
        _, flags, _ = along_path(seconds=100.0, rate=rate, inertia=1.2)
        assert not (flags & FLAGS["touched"]).any()


def test_a_hand_that_lets_go_while_the_reference_rests_is_over_there():
    def moves_until_70(t):  # to where a stroke passes the middle
        return 0.3 if t < 18.0 * math.pi / 0.8 else 0.0

    scales, flags, t = along_path(
        lambda t, way: -4.0 if 55.0 <= t < 90.0 else 0.0, seconds=120.0, size=moves_until_70
    )
    touched = flags & FLAGS["touched"] != 0
    assert touched[(t > 56.0) & (t < 69.0)].all() and not touched[t > 95.0].any()
    assert scales[-1] == pytest.approx(scales[round(54.0 / PERIOD)], abs=0.1)


def test_hysteresis_that_is_another_from_the_start_is_learned_and_is_no_touch():
    for scale in (0.6, 1.4):
        scales, flags, _ = along_path(truth=MODEL.scaled((scale, scale, 1.0, 1.0)))
        assert scales[-1, :2] == pytest.approx([scale, scale], abs=0.2)
        assert not (flags & FLAGS["touched"]).any()


def test_what_is_not_better_than_the_identified_model_is_not_used():
    controller, _ = quasistatic(MODEL, 60.0, adaptation=Adaptation(memory=20.0))
    rng = np.random.default_rng(0)
    for _ in range(2000):  # nothing but noise at rest: no evidence for anything
        noise = 1e3 * rng.standard_normal(2)
        controller.step(0.0, 3e5 + noise[0], 3e5 + noise[1], JointReference(0.0), LEARNS)
    assert controller.applied == pytest.approx([1.0] * 4, abs=0.3)


def test_nothing_is_learned_while_a_reference_rests_under_position_control():
    controller = learner()
    on = LEARNS | SWITCHES["position"]
    for k in range(3000):
        angle = 0.1 + 0.02 * math.sin(0.05 * k)
        controller.step(angle, 3.4e5, 2.6e5, JointReference(0.1), on)
    assert controller.scales.tolist() == [1.0] * 4


def test_nothing_is_learned_without_the_switch():
    controller = learner()
    for k in range(500):
        controller.step(0.2 * math.sin(0.02 * k), 3.4e5, 2.6e5, JointReference(0.0), 0)
    assert controller.scales.tolist() == [1.0] * 4


@pytest.mark.parametrize(
    "field",
    [
        "rate",
        "memory",
        "patience",
        "contact_ratio",
        "first_error",
        "rest",
        "settling",
        "least_speed",
    ],
)
def test_a_negative_setting_is_refused_by_name(field):
    with pytest.raises(ParameterError, match=field):
        Adaptation(**{field: -1.0})


@pytest.mark.parametrize("bounds", [(-0.1, 2.0), (1.1, 2.0), (0.0, 0.9)])
def test_scales_that_could_drive_motion_are_refused(bounds):
    with pytest.raises(ParameterError, match="scale"):
        Adaptation(lowest=bounds[0], highest=bounds[1])


def test_a_state_after_an_absurd_angle_is_stored_and_restored_without_a_known_range():
    bare = DirectInverse(
        radii=[0.1], stop_weights=[2.0], polynomial=[0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1e3]
    )
    first, second = learner(model=bare), learner(model=bare)
    for angle in (0.0, 1e15, 1e15):
        first.step(angle, 3e5, 3e5, JointReference(angle), LEARNS)
    second.restore(first.save())
    assert second.applied.tolist() == first.applied.tolist()


@pytest.mark.parametrize(
    ("past", "begun"),
    [("rest", "rest"), ("unknown", "unknown"), ("rising", "unknown"), ("falling", "unknown")],
)
def test_strokes_of_a_log_say_nothing_about_where_a_joint_stands(past, begun):
    last = kit.direct_parameters(MODEL.with_past(past), PERIOD)[-1]
    assert last == MODEL.with_past(begun).parameters(PERIOD)[-1]
