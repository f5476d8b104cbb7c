"""An offset that follows the last cycle: bounded, held at rest, no jump, the same everywhere."""

import itertools
import json

import numpy as np
import pytest

import dehyst
from dehyst import _native
from dehyst.errors import ParameterError
from dehyst.export import export, subject_of, verify
from dehyst.models import BLOCK_FLAGS, DirectInverse, ModelCard, SignalCard
from dehyst.models._offset import range_width
from element_samples import element_model
from export_samples import needs_make, play_model
from places import ROOT
from test_export_elements import checked

LIMIT = 0.1


def direct_model():
    card = ModelCard(SignalCard("p", "bar", -2.0, 2.0), SignalCard("x", "mm", -1.0, 1.0))
    return DirectInverse(radii=[0.5], stop_weights=[2.0], polynomial=[0.0, 1.0], card=card)


def element():
    return element_model()


MODELS = {"plays": play_model, "elements": element, "direct inverse": direct_model}
KINDS = [
    (kind, what)
    for kind in MODELS
    for what in ("inverse", "forward")
    if (kind, what) != ("direct inverse", "forward")
]


def follows(kind, what="inverse", limit=LIMIT, **more):
    model = MODELS[kind]()
    return dehyst.block(
        model, what, period=0.01 if kind == "direct inverse" else None, follow_offset=limit, **more
    )


def unfollowed(kind, what="inverse"):
    return dehyst.block(MODELS[kind](), what, period=0.01 if kind == "direct inverse" else None)


def cycles(block, count=12, samples=200):
    """A smooth motion within the limits of a block."""
    low, high = block.input.low, block.input.high
    middle, half = 0.5 * (low + high), 0.15 * (high - low)
    return middle + half * np.sin(np.linspace(0.0, 2.0 * np.pi * count, count * samples))


def stepped(block, x, measured, on=True):
    """One sample, whatever the kind."""
    return block.step(x, on, {**dict.fromkeys(block.given, 0.0), "measured": measured})


def said(block, x, before, answer):
    """What the model says of a sample that was asked for with this offset."""
    return answer - before if block.direction == "forward" else x - before


@pytest.mark.parametrize(("kind", "what"), KINDS)
def test_the_offset_stays_within_its_limit_whatever_is_measured(kind, what):
    block, rng = follows(kind, what), np.random.default_rng(1)
    strange = [np.nan, np.inf, -np.inf, 1e99, -1e99, 1e3, -1e3, 0.0]
    span = block.input.high - block.input.low
    for _ in range(4000):
        x = block.input.low + span * rng.uniform(-0.2, 1.2)
        answer = stepped(block, x, strange[rng.integers(len(strange))], bool(rng.integers(20)))
        assert abs(block.following.offset.applied) <= block.following.numbers.limit
        assert block.output.low <= answer <= block.output.high
    assert block.following.offset.applied != 0.0


@pytest.mark.parametrize(("kind", "what"), KINDS)
def test_without_an_offset_the_answers_are_those_of_the_block_bit_for_bit(kind, what):
    block, plain = follows(kind, what), unfollowed(kind, what)
    for x in cycles(block, 4):
        # nothing measured: nothing is followed
        assert stepped(block, x, np.nan) == plain.step(x, given=dict.fromkeys(plain.given, 0.0))


@pytest.mark.parametrize(("kind", "what"), KINDS)
def test_an_offset_of_the_actuator_is_found_in_a_cycle_and_within_its_limit(kind, what):
    for share, found in ((0.6, 0.6), (3.0, 1.0)):
        block = follows(kind, what)
        true = share * block.following.numbers.limit
        before = 0.0
        for x in cycles(block):
            next_ = block.following.offset.next(x, True)
            probe = stepped_answer(block, x, next_)
            before = probe + true
            stepped(block, x, before)
        assert block.following.offset.applied == pytest.approx(
            found * block.following.numbers.limit, rel=1e-9
        )


def stepped_answer(block, x, offset):
    """What the model says of a sample without its offset."""
    if block.direction == "inverse":
        return x - offset
    image = block.save()
    answer = stepped(block, x, np.nan) - block.following.offset.applied
    block.restore(image)
    return answer


@pytest.mark.parametrize(("kind", "what"), KINDS)
def test_at_rest_nothing_moves_and_along_the_way_nothing_jumps(kind, what):
    block = follows(kind, what)
    x = cycles(block, 3)
    x[350:450] = x[350]
    offsets = []
    for value in x:
        stepped(block, value, block.input.high)
        offsets.append(block.following.offset.applied)
    moves = np.abs(np.diff(offsets))
    assert moves.max() > 0.0
    assert not moves[350:449].any()
    assert np.all(moves <= block.following.numbers.part * np.abs(np.diff(x)) + 1e-15)


@pytest.mark.parametrize("hole", ["off", "nan"])
def test_a_cycle_that_was_off_or_not_measured_teaches_nothing(hole):
    block = follows("plays", ramp=1)
    x, held = cycles(block), 0.0
    for k, value in enumerate(x):
        bad = k >= x.size // 2
        held = block.following.offset.applied if k == x.size // 2 else held
        measured = (
            value - block.following.offset.next(value, True) + 0.5 * block.following.numbers.limit
        )
        strange = np.nan if hole == "nan" else measured + 9.0
        stepped(block, value, strange if bad else measured, not (bad and hole == "off"))
    assert held == pytest.approx(0.5 * block.following.numbers.limit)
    assert block.following.offset.applied == (held if hole == "off" else pytest.approx(held))


def test_one_lost_measurement_in_ten_does_not_stop_it_and_one_in_five_does():
    for every, found in ((10, True), (5, False)):
        block = follows("plays")
        for k, value in enumerate(cycles(block)):
            stepped(block, value, np.nan if k % every == 0 else value + 0.1)
        assert (block.following.offset.applied != 0.0) == found


def test_the_demand_of_an_inverse_turns_where_its_reference_turns():
    block = follows("plays", limit=0.5)
    x = cycles(block, 8)
    asked = []
    for k, value in enumerate(x):
        asked.append(value - block.following.offset.next(value, True))
        stepped(block, value, value + (9.0 if (k // 400) % 2 else -9.0))
    moved = np.diff(x) != 0.0
    assert np.all(np.sign(np.diff(asked))[moved] == np.sign(np.diff(x))[moved])


@pytest.mark.parametrize(("kind", "what"), KINDS)
def test_no_answer_depends_on_its_own_measurement_or_a_later_one(kind, what):
    model, changed = follows(kind, what), follows(kind, what)
    x = cycles(model, 6)
    rng = np.random.default_rng(3)
    measured = x + rng.uniform(-1, 1, x.size)
    at = 777
    others = np.where(np.arange(x.size) < at, measured, -measured)
    a = [stepped(model, *pair) for pair in zip(x, measured, strict=True)]
    b = [stepped(changed, *pair) for pair in zip(x, others, strict=True)]
    assert a[: at + 1] == b[: at + 1] and a[at + 1 :] != b[at + 1 :]


def test_simulation_with_measurements_is_that_of_the_forward_block():
    model = play_model()
    low, high = model.ends
    x = 0.5 * (low + high) + 0.3 * (high - low) * np.sin(np.linspace(0, 50, 4000))
    measured = model.simulate(x) + 0.02 * np.arange(x.size) / x.size
    block = dehyst.block(model, "forward", follow_offset=0.2)
    assert np.allclose(
        model.simulate_following(x, measured, 0.2),
        block.run(x, given={"measured": measured})[0],
        rtol=0.0,
        atol=1e-12,
    )


def test_a_cycling_log_whose_offset_wanders_is_followed_better_than_half():
    model = play_model()
    low, high = model.ends
    x = 0.5 * (low + high) + 0.4 * (high - low) * np.sin(np.linspace(0, 300, 12000))
    said = model.simulate(x)
    height = np.ptp(said)
    y = said + 0.05 * height * np.sin(np.linspace(0, 9, x.size))
    log = dehyst.Recording(input=x, output=y)
    with_it, without = (
        dehyst.evaluate(model, log, follow_offset=limit).entries[0].output.rmse
        for limit in (0.1, None)
    )
    assert with_it < 0.25 * without


@pytest.mark.parametrize(("kind", "what"), [pair for pair in KINDS if pair[0] != "direct inverse"])
def test_a_saved_state_goes_on_with_the_same_bits_and_a_damaged_one_is_refused(kind, what):
    block, other = follows(kind, what), follows(kind, what)
    x = cycles(block, 6)
    measured = np.sin(x) + 0.1
    for pair in zip(x[:500], measured[:500], strict=True):
        stepped(block, *pair)
    image = block.save()
    other.restore(image)
    ahead = [stepped(other, *pair) for pair in zip(x[500:], measured[500:], strict=True)]
    for place in range(image.size):
        damaged = image.copy()
        damaged[place] ^= 1
        with pytest.raises(ParameterError):
            block.restore(damaged)
    assert [stepped(block, *pair) for pair in zip(x[500:], measured[500:], strict=True)] == ahead


@pytest.mark.parametrize("limit", [0.0, -0.1, 0.6, float("nan")])
def test_a_limit_that_is_none_is_refused(limit):
    with pytest.raises(ParameterError, match="follow_offset"):
        follows("plays", limit=limit)


def test_what_was_measured_is_refused_where_it_is_no_signal():
    model = play_model()
    x = np.linspace(0.0, 1.0, 5)
    for wrong in (["a"] * 5, x[:3], None, 1.0):
        with pytest.raises(ParameterError, match="measure"):
            model.simulate_following(x, wrong, LIMIT)


def test_blocks_and_models_take_the_ranges_of_the_card_and_else_those_of_the_signals():
    model = play_model()
    x = np.linspace(-1.0, 1.0, 9)
    bare = model.with_card(ModelCard())
    assert range_width(model.card.input, x) == model.card.input.high - model.card.input.low
    assert range_width(bare.card.input, x) == 2.0
    low, high = model.card.input.low, model.card.input.high
    forward = dehyst.block(model, "forward", follow_offset=LIMIT)
    assert forward.following.numbers.turn == 0.05 * (high - low)


def test_what_pages_say_of_26_runs_is_what_was_measured():
    runs = json.loads((ROOT / "benchmarks" / "results" / "following.json").read_text())["runs"]
    ratios = [run["with"]["0.1"] / run["without"] for run in runs]
    page = " ".join(
        (ROOT / "docs" / "how-to" / "use-the-compensator.md").read_text(encoding="utf-8").split()
    )
    assert (
        f"On {len(runs)} runs the error with it is {min(ratios):.2f} to {max(ratios):.2f} of that without, "
        f"{np.exp(np.mean(np.log(ratios))):.2f} in the mean" in page
    )
    notes = " ".join(
        (ROOT / "docs/decisions/0050-offset-of-the-last-cycle.md")
        .read_text(encoding="utf-8")
        .split()
    )
    for run in runs:
        if run["log"] in ("piezo_dbo", "cavatappi_muscle"):
            row = f"{run['run']} | {run['bias_percent']:.2f} | {run['without']:#.3g} "
            assert row + " ".join(f"| {error:#.3g}" for error in run["with"].values()) in notes


def test_a_large_offset_counts_as_limited_samples_do_not():
    block = follows("plays")
    for value in cycles(block):
        stepped(block, value + 10.0 * (block.input.high - block.input.low), value)
        assert block.flags & BLOCK_FLAGS["limited"]
    assert block.following.offset.applied == 0.0


def test_the_state_of_the_core_refuses_what_no_run_leaves():
    offset = _native.Offset(0.5, 0.1, 0.1, 7)
    foreign = _native.Offset(0.5, 0.1, 0.1, 8)
    assert (offset.restore(offset.save()), offset.restore(foreign.save())) == (0, 4)


@pytest.mark.slow
@needs_make
@pytest.mark.parametrize(
    ("kind", "what", "real"),
    [(*pair, real) for pair, real in itertools.product(KINDS, ("double", "float"))],
)
def test_exported_c_follows_as_the_block_does(kind, what, real, tmp_path):
    period = 0.01 if kind == "direct inverse" else None
    subject = subject_of(
        MODELS[kind](), what, name="unit_1", real=real, ramp=40, period=period, follow_offset=LIMIT
    )
    told = checked(subject, "c" if real == "double" else "c-header", tmp_path / "out")
    assert "all checks passed" in told
    assert np.isfinite(subject.test.inputs[:, -1]).mean() > 0.5
    unit = subject.unit.block
    _, _ = unit.answer(subject.test.inputs, subject.test.switch)
    assert unit.following.offset.applied != 0.0  # the test signal moves it


@pytest.mark.slow
@needs_make
@pytest.mark.parametrize(
    ("target", "real"),
    [("fmu2", "float"), ("fmu3", "double"), ("simulink", "double"), ("arduino", "float"), ("st", "double"),
     ("st", "float")],
)  # fmt: skip
@pytest.mark.parametrize("what", ["inverse", "forward"])
@pytest.mark.usefixtures("one_compiler")
def test_every_target_follows_and_is_verified(target, real, what, tmp_path):
    model = (
        play_model()
        if (what == "forward") == (target in ("arduino", "fmu2", "simulink"))
        else element_model()
    )
    export(
        subject_of(model, what, name="unit_1", real=real, ramp=40, follow_offset=LIMIT),
        target,
        tmp_path / "out",
    )
    assert [check for check in verify(tmp_path / "out") if not check.ok] == []
