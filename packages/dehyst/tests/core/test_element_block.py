"""A sum of elements as a function block: the model to rounding, bounded, held back at limits, switched, restored."""

from dataclasses import replace

import numpy as np
import pytest

from dehyst.errors import InvertibilityError, ParameterError
from dehyst.families import STARTS
from dehyst.families._elements import Element, ElementModel
from dehyst.models import BLOCK_FLAGS, Block
from element_samples import CARD, element_model, random_elements, scheduled_model
from test_block_images import with_number

LIMITED, REJECTED = BLOCK_FLAGS["limited"], BLOCK_FLAGS["rejected"]
TIME = 0.02 * np.arange(700)
INPUT = np.clip(1.3 + 1.8 * np.sin(2.2 * TIME) * np.exp(-TIME / 20), -1.0, 3.0)


@pytest.mark.parametrize("direction", ["forward", "inverse"])
@pytest.mark.parametrize("start", STARTS)
def test_a_block_in_range_answers_what_its_model_answers_and_its_inverse_finds_the_input_again(
    direction, start
):
    model = element_model(direction, start=start)
    y = model.simulate(INPUT, TIME)
    forward, flags = Block(model, "forward", period=0.02).run(INPUT)
    np.testing.assert_allclose(forward, y, atol=1e-12)
    assert not flags.any()
    prompt = replace(model, dead_time=0.0)
    needed, _ = Block(model, "inverse", period=0.02).run(prompt.simulate(INPUT, TIME))
    np.testing.assert_allclose(needed, INPUT, atol=1e-12)


@pytest.mark.parametrize("period", [0.02, 0.01])
@pytest.mark.parametrize("direction", ["forward", "inverse"])
def test_an_inverse_block_shapes_its_reference_as_the_model_does_and_a_forward_one_does_not(
    direction, period
):
    model = element_model(direction, resonance=(4.0, 0.1))
    time = period * np.arange(700)
    still = replace(model, dead_time=0.0, resonance=None)
    wanted = np.clip(still.simulate(INPUT, time), -3.5, 4.5)
    shaped = model.resonance.shaped(wanted, time, 0.0)
    assert np.abs(shaped - wanted).max() > 0.05
    answered, _ = Block(model, "inverse", period=period).run(wanted)
    expected, _ = Block(still, "inverse", period=period).run(shaped)
    np.testing.assert_allclose(answered, expected, atol=1e-12)
    plain = replace(model, resonance=None)
    for one, other in ((model, plain), (replace(model, dead_time=0.0), still)):
        forward = Block(one, "forward", period=period).run(INPUT)[0]
        assert np.array_equal(forward, Block(other, "forward", period=period).run(INPUT)[0])


def test_a_block_too_slow_for_half_a_swing_leaves_its_reference_as_it_is():
    model = element_model(resonance=(20.0, 0.0))  # half a swing is 1.25 periods
    plain = replace(model, resonance=None)
    wanted = np.clip(plain.simulate(INPUT, TIME), -3.5, 4.5)
    blocks = [Block(one, "inverse", period=0.02) for one in (model, plain)]
    assert np.array_equal(*(block.run(wanted)[0] for block in blocks))


@pytest.mark.spread(20)
@pytest.mark.parametrize("seed", range(60))
def test_random_sums_are_undone_by_their_inverse_block_and_stay_within_their_limits(seed):
    rng = np.random.default_rng(seed)
    model = random_elements(rng)
    low, high = model.card.input.low, model.card.input.high
    x = np.clip(np.cumsum(rng.normal(0, 0.2, 400)) * (high - low) / 3 + low, low, high)
    names = Block(model, "forward", period=0.01).given
    given = {name: rng.uniform(-2, 2, x.size) for name in names}
    forward = Block(replace(model, dead_time=0.0), "forward", period=0.01)
    inverse = Block(model, "inverse", period=0.01)
    y, flags = forward.run(x, given=given)
    if not (flags & LIMITED).any():
        found, flags = inverse.run(y, given=given)
        np.testing.assert_allclose(found, x, atol=1e-9 * (high - low))
    for block in (forward, inverse):
        block.reset()
        wild = rng.choice([np.nan, np.inf, -1e300, 1e99, 0.0, 1.0, -3.0, 5e-324], (3000, 4))
        out, _ = block.run(
            wild[:, 0], wild[:, 1] > 0, {name: wild[:, 1 + k] for k, name in enumerate(names)}
        )
        assert (out >= block.output.low).all() and (out <= block.output.high).all()


@pytest.mark.parametrize("direction", ["forward", "inverse"])
def test_at_a_limit_the_memory_is_that_of_an_actuator_that_got_what_was_answered(direction):
    elements = (
        Element("input", weight=0.4),
        Element("play", 0.3, weight=0.4),
        Element("stop", 0.2, weight=0.2),
    )
    model = ElementModel(elements, direction=direction, period=0.02)
    plant = Block(model, "forward", period=0.02, range=(-2.0, 2.0))
    inverse = Block(model, "inverse", period=0.02, range=(-0.8, 0.8))
    limits = inverse.input.low, inverse.input.high
    wanted = np.concatenate(
        [np.linspace(0, 0.95 * limits[1], 50), np.linspace(0.95 * limits[1], -0.2, 200)]
    )
    needed, flags = inverse.run(wanted)
    assert (flags & LIMITED).any() and abs(needed).max() == 0.8
    free = (flags & LIMITED) == 0
    np.testing.assert_allclose(plant.run(needed)[0][free], wanted[free], atol=1e-12)


@pytest.mark.parametrize("direction", ["forward", "inverse"])
def test_a_sample_that_is_no_number_holds_everything(direction):
    block, other = (Block(scheduled_model(), direction, period=0.02) for _ in range(2))
    told = {"signal_0": 0.3, "signal_1": 0.1}
    for x in INPUT[:50]:
        assert block.step(x, given=told) == other.step(x, given=told)
        for bad in (None, float("nan"), float("inf"), -1e101):
            assert block.step(bad, given=told) == other.last and block.flags & REJECTED
            assert block.step(x, given={**told, "signal_1": bad or 1e101}) == other.last


@pytest.mark.parametrize("what", ["forward", "inverse"])
def test_switching_never_jumps_by_more_than_its_share_and_the_motion(what):
    block = Block(element_model(start="rest"), what, period=0.02, ramp=50)
    x = np.linspace(0.5, 0.9, 400)
    on = np.ones(400, dtype=bool)
    on[100:250] = False
    y, _ = block.run(x, on)
    plain = Block(element_model(start="rest"), what, period=0.02, ramp=50).run(x)[0]
    off = Block(element_model(start="rest"), what, period=0.02, ramp=50).run(x, False)[0]
    apart = abs(plain - off).max()
    moved = max(abs(np.diff(plain)).max(), abs(np.diff(off)).max())
    assert abs(np.diff(y)).max() <= apart / 50 + moved + 1e-12
    assert (
        (y[150:250] == off[150:250]).all()
        and (y[:100] == plain[:100]).all()
        and (y[300:] == plain[300:]).all()
    )


@pytest.mark.parametrize("direction", ["forward", "inverse"])
def test_an_image_goes_on_to_the_bit_and_what_is_none_is_refused(direction):
    block = Block(element_model(), direction, period=0.02)
    block.run(INPUT[:333])
    image = block.save()
    after = block.run(INPUT[333:])[0]
    other = Block(element_model(), direction, period=0.02)
    other.restore(image)
    assert (other.run(INPUT[333:])[0] == after).all()
    for word in range(image.size):
        damaged = image.copy()
        damaged[word] ^= 1 << (word % 32)
        with pytest.raises(ParameterError) as error:
            other.restore(damaged)
        assert error.value.facts["fault"] in ("kind", "damaged")
    stranger = Block(replace(element_model(), offset=0.1), direction, period=0.02)
    with pytest.raises(ParameterError, match="another model"):
        stranger.restore(image)
    with pytest.raises(ParameterError, match="another length"):
        other.restore(image[:-1])
    assert (other.save() == block.save()).all()


@pytest.mark.parametrize("late", [True, False], ids=["in the dead time", "last"])
def test_an_image_with_an_input_that_cannot_come_is_refused_since_what_follows_it_could_not_be_restored(
    late,
):
    creeps = (Element("input", weight=0.5), Element("creep", time=0.1, weight=0.5))
    model = ElementModel(creeps, dead_time=0.02, period=0.02, card=CARD, start="rest")
    block, other = (Block(model, "forward", period=0.02) for _ in range(2))
    block.run(INPUT[:50])
    image = block.save()
    other.restore(image)
    place = 2 if late else 3  # behind both memories
    for far, refused in ((4e99, False), (6e99, True)):
        changed = with_number(image, place, far)
        if not late:
            changed = with_number(changed, place + 5, far)  # the largest of all up to the last
        if refused:
            with pytest.raises(ParameterError, match="cannot be here"):
                other.restore(changed)
        else:
            other.restore(changed)
            other.run(INPUT[:5])
            block.restore(other.save())


def test_what_cannot_be_a_block_says_why():
    with pytest.raises(ParameterError, match=r"range=\(low, high\)"):
        Block(ElementModel.example(), "inverse", period=0.02)
    with pytest.raises(ParameterError, match="period"):
        Block(element_model(), "inverse", period=0.0)
    with pytest.raises(ParameterError, match="ramp"):
        Block(element_model(), "inverse", period=0.02, ramp=0)
    falls = ElementModel((Element("input", weight=-1.0),), card=CARD)
    with pytest.raises(InvertibilityError, match="no inverse"):
        Block(falls, "inverse", period=0.02)
    quick = ElementModel(
        (Element("input", weight=0.2), Element("past", time=0.05, weight=0.5)),
        period=1e-3,
        card=CARD,
    )
    with pytest.raises(ParameterError, match=r"every 1 s .* identified every 0.001 s"):
        Block(quick, "inverse", period=1.0)
    with pytest.raises(ParameterError, match="signal_0"):
        Block(scheduled_model(), "forward", period=0.02).run(INPUT)
