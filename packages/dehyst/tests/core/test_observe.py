"""A block follows an actuator that something else drives: its memory is put right by what is applied and measured."""

import ctypes
import subprocess
from dataclasses import replace

import numpy as np
import pytest

from dehyst import PrandtlIshlinskii
from dehyst.errors import ParameterError
from dehyst.export import export, subject_of
from dehyst.families._elements import Element, ElementModel
from dehyst.models import BLOCK_FLAGS, Block
from element_samples import element_model, scheduled_model
from export_samples import needs_make

LIMITED, REJECTED = BLOCK_FLAGS["limited"], BLOCK_FLAGS["rejected"]
RANGE = (-1.0, 1.0)
STARTS = ("rest", "rising", "falling", "zero")
NAN = float("nan")


def sum_of_plays(rng, direction, start="rest"):
    """Plays and stops of random radii and weights, some behind a map."""
    elements = [Element("input", weight=0.4)]
    for _ in range(rng.integers(2, 9)):
        knots = (-1.0, float(rng.uniform(-0.4, 0.4)), 1.0)
        bend = (
            (knots, (-1.0, float(rng.uniform(-0.4, 0.4)), 1.0)) if rng.random() < 0.3 else ((), ())
        )
        kind = "play" if rng.random() < 0.7 else "stop"
        radius, weight = float(rng.uniform(0.02, 0.9)), float(rng.uniform(0.02, 0.3))
        elements.append(Element(kind, radius, 0.0, weight, bend))
    return ElementModel(tuple(elements), direction=direction, start=start)


def motion(rng, begin, count, size):
    """Strokes between random tips, from where the one before ended."""
    x = [begin]
    for tip in rng.uniform(-size, size, count):
        x.extend(np.linspace(x[-1], tip, max(2, int(60 * abs(tip - x[-1]))))[1:])
    return np.array(x)


class Scene:
    """An actuator with a past, what it is driven with, and what a compensator does afterwards."""

    def __init__(self, seed, direction, size=None):
        rng = np.random.default_rng(seed)
        model = sum_of_plays(rng, direction)
        actuator = Block(model, "forward", range=RANGE)
        past = motion(rng, 0.0, 8, 1.0)
        actuator.run(past)
        self.applied = motion(rng, past[-1], int(rng.integers(2, 7)), size or rng.uniform(0.1, 0.9))
        self.measured, _ = actuator.run(self.applied)
        self.needed = motion(rng, self.applied[-1], 4, 0.9)
        self.wanted, _ = actuator.run(self.needed)
        # Its start is another than the memory of the actuator.
        self.unknowing = Block(replace(model, start=STARTS[seed % 4]), "inverse", range=RANGE)

    def block_after(self, applied, measured):
        """The compensator after it observed both, or one alone."""
        block = self.unknowing
        block.reset()
        for u, y in zip(applied, measured, strict=True):
            block.observe(u, y)
        return block

    def errors(self):
        """Errors of the compensator after it observed both, and the signal alone that moves the memory."""
        nothing = np.full(self.applied.size, NAN)
        alone = [self.applied, nothing]
        if self.unknowing.model.direction == "inverse":
            alone = [nothing, self.measured]
        errors = []
        for applied, measured in ((self.applied, self.measured), alone):
            block = self.block_after(applied, measured)
            errors.append(np.std(block.run(self.wanted)[0] - self.needed))
        return errors


@pytest.mark.parametrize("direction", ["forward", "inverse"])
def test_both_signals_put_a_wrong_memory_right_where_one_alone_does_not(direction):
    both, alone = np.array([Scene(seed, direction).errors() for seed in range(40)]).T
    assert np.sqrt(np.mean(both**2)) < np.sqrt(np.mean(alone**2)) / 3.0
    assert np.mean(both <= alone + 1e-3) >= 0.9  # of 200, 0.95 and 0.99


@pytest.mark.parametrize("direction", ["forward", "inverse"])
@pytest.mark.parametrize("seed", range(4))
def test_after_a_stroke_over_the_whole_range_the_memory_is_exact_and_noise_does_not_move_it(
    seed, direction
):
    scene = Scene(seed, direction)
    model = replace(scene.unknowing.model, start="zero")
    actuator, block = (Block(model, what, range=RANGE) for what in ("forward", "inverse"))
    rng = np.random.default_rng(seed)
    stroke = np.concatenate([[-1.0], np.linspace(-1.0, 1.0, 50), motion(rng, 1.0, 3, 0.8)])
    actuator.run(motion(rng, 0.0, 5, 1.0))
    measured, _ = actuator.run(stroke)
    noise = 0.0
    if direction == "forward":  # here the measured output moves no memory
        noise = 0.05 * rng.standard_normal(stroke.size)
        noise[:51] = 0.0
    for u, y in zip(stroke, measured + noise, strict=True):
        block.observe(u, y)
    needed = motion(rng, stroke[-1], 5, 1.0)
    wanted, _ = actuator.run(needed)
    np.testing.assert_allclose(block.run(wanted)[0], needed, atol=1e-12)


@pytest.mark.parametrize("direction", ["forward", "inverse"])
def test_what_goes_on_from_an_observed_sample_begins_where_the_actuator_is(direction):
    scene = Scene(3, direction)
    block = scene.block_after(scene.applied, scene.measured)
    for _ in range(60):  # at rest: what is still missing is learnt
        block.observe(scene.applied[-1], scene.measured[-1])
    assert block.last == scene.applied[-1] and block.share == 1.0
    assert abs(block.step(scene.measured[-1]) - scene.applied[-1]) < 1e-6


@pytest.mark.parametrize("direction", ["forward", "inverse"])
@pytest.mark.parametrize("what", ["forward", "inverse"])
def test_a_block_that_knows_the_past_follows_either_signal_exactly(direction, what):
    model = element_model(direction, dead_time=0.0, start="zero")
    time = 0.02 * np.arange(400)
    u = np.clip(1.0 + 1.9 * np.sin(2.2 * time) * np.exp(-time / 9), -1.0, 3.0)
    y = model.simulate(u, time)
    for applied, measured in ((u, y), (u, np.full(u.size, NAN)), (np.full(u.size, NAN), y)):
        block = Block(model, what, period=0.02)
        for one, other in zip(applied[:300], measured[:300], strict=True):
            block.observe(one, other)
            assert block.flags == 0
        driven, answer = (u, y) if what == "forward" else (y, u)
        np.testing.assert_allclose(block.run(driven[300:])[0], answer[300:], atol=1e-11)


def test_a_dead_time_delays_what_is_observed_as_what_is_stepped():
    model = element_model()
    time = 0.02 * np.arange(400)
    u = np.clip(1.0 + 1.9 * np.sin(2.2 * time), -1.0, 3.0)
    y = model.simulate(u, time)
    block = Block(model, "forward", period=0.02)
    for applied, measured in zip(u[:300], y[:300], strict=True):
        block.observe(applied, measured)
    np.testing.assert_allclose(block.run(u[300:])[0], y[300:], atol=1e-12)


@pytest.mark.parametrize("direction", ["forward", "inverse"])
def test_a_shaper_is_for_references_and_remembers_what_was_measured(direction):
    model = element_model(direction, dead_time=0.0, resonance=(4.0, 0.1), start="zero")
    still = replace(model, resonance=None)
    time = 0.02 * np.arange(300)
    u = np.clip(1.0 + 1.9 * np.sin(2.2 * time), -1.0, 3.0)
    y = still.simulate(u, time)
    block, plain = (Block(one, "inverse", period=0.02) for one in (model, still))
    for applied, measured in zip(u, y, strict=True):
        block.observe(applied, measured)
        plain.observe(applied, measured)
    # Half a swing later the reference has been at rest for so long that nothing is shaped.
    rest = np.full(40, y[-1])
    np.testing.assert_allclose(block.run(rest)[0][20:], plain.run(rest)[0][20:], atol=0.02)
    block.observe(u[-1], y[-1])
    later = Block(model, "inverse", period=0.02)
    later.restore(block.save())
    assert later.step(y[-1]) == block.step(y[-1])


def test_steps_that_are_off_make_nothing_known_and_steps_that_are_on_do():
    model = ElementModel([("input", 0.0, 0.0, 0.5), ("play", 0.4, 0.0, 0.5)])
    for on in (True, False):
        block = Block(model, "inverse", range=RANGE)
        wanted = Block(model, "forward", range=RANGE).run(np.sin(np.linspace(0, 9, 200)))[0]
        block.run(wanted, on)
        before = block.save()
        for _ in range(30):
            block.observe(block.last, wanted[-1] + 0.1)
        moved = not np.array_equal(before[5:9], block.save()[5:9])
        assert moved != on


def test_what_is_no_number_teaches_nothing_and_both_are_refused():
    scene = Scene(1, "forward")
    block = scene.block_after(scene.applied, scene.measured)
    for bad in (None, NAN, float("inf"), -1e101):
        before = block.save()
        block.observe(bad, bad)
        assert block.flags & REJECTED
        assert np.array_equal(before[5:-1], block.save()[5:-1])
    with pytest.raises(ParameterError, match="a number each"):
        block.observe("up", 0.0)
    beyond = block.last
    block.observe(7.0, 0.0)
    assert block.flags & LIMITED and block.last == RANGE[1] != beyond


@pytest.mark.parametrize("direction", ["forward", "inverse"])
def test_a_sample_with_a_bad_signal_moves_nothing(direction):
    block = Block(scheduled_model(direction, (0, 1, 2)), period=0.02)
    told = {"signal_0": 0.3, "signal_1": 0.1, "signal_2": 0.2}
    block.observe(0.5, 0.4, told)
    before = block.save()
    block.observe(0.6, 0.5, {**told, "signal_2": NAN})
    assert block.flags & REJECTED and np.array_equal(before[5:-1], block.save()[5:-1])
    with pytest.raises(ParameterError, match="signal_2"):
        block.observe(0.6, 0.5, {"signal_0": 0.3, "signal_1": 0.1})


@pytest.mark.parametrize("what", ["forward", "inverse"])
@pytest.mark.parametrize("direction", ["forward", "inverse"])
def test_whatever_is_observed_the_answer_is_in_range_and_the_state_can_be_saved(direction, what):
    block = Block(element_model(direction), what, period=0.02)
    twin = Block(element_model(direction), what, period=0.02)
    rng = np.random.default_rng(2)
    wild = rng.choice([NAN, np.inf, -1e300, 1e99, 0.0, 1.0, -3.0, 5e-324, 2.5], (4000, 3))
    for u, y, x in wild:
        if rng.random() < 0.6:
            block.observe(u, y)
        else:
            answer = block.step(x, bool(rng.random() < 0.5))
            assert block.output.low <= answer <= block.output.high
    twin.restore(block.save())
    for u, y, x in wild[:200]:
        block.observe(u, y)
        twin.observe(u, y)
        assert block.step(x) == twin.step(x)


def test_an_offset_that_is_followed_is_no_part_of_the_memory():
    model = ElementModel([("input", 0.0, 0.0, 0.5), ("play", 0.4, 0.0, 0.5)])
    plain, block = Block(model, range=RANGE), Block(model, range=RANGE, follow_offset=0.2)
    u = 0.9 * np.sin(np.linspace(0, 30, 900))
    y = Block(model, "forward", range=RANGE).run(u)[0]
    for applied, measured in zip(u[:600], y[:600], strict=True):
        plain.observe(applied, measured)
        block.observe(applied, measured)
    for wanted in y[600:]:
        assert block.step(wanted) == plain.step(wanted)


def test_a_block_of_plays_says_what_to_do_in_its_place():
    block = Block(PrandtlIshlinskii([0.0, 0.2], [1.0, 1.0]), range=RANGE)
    with pytest.raises(ParameterError, match=r"step\(measured, on=False\)"):
        block.observe(0.1, 0.1)


DRIVER = """
#include "unit_1.h"
static unit_1_state unit;
void start(void) { unit_1_reset(&unit); }
double step(const double *x, int on) { return unit_1_step(&unit, ARGUMENTS, on); }
void observe(double applied, double measured, const double *x)
{
    (void)x;
    unit_1_observe(&unit, applied, measuredSIGNALS);
}
"""


@pytest.mark.slow
@needs_make
@pytest.mark.usefixtures("one_compiler")
@pytest.mark.parametrize("what", ["inverse", "forward"])
@pytest.mark.parametrize("form", ["every kind", "identified inversely", "three signals", "offset"])
def test_the_exported_unit_observes_with_the_bits_of_the_block(form, what, tmp_path):
    model, follow, signals = element_model(), None, 0
    if form == "identified inversely":
        model = element_model("inverse")
    elif form == "three signals":
        model, signals = scheduled_model(sources=(0, 1, 2)), 3
    elif form == "offset":
        follow = 0.2
    place = export(
        subject_of(model, what, name="unit_1", ramp=40, follow_offset=follow), "c", tmp_path / "out"
    ).folder
    given = "".join(f", x[{k + 1}]" for k in range(signals))
    measured = "" if follow is None else ", x[1]"
    text = DRIVER.replace("ARGUMENTS", "x[0]" + given + measured).replace("SIGNALS", given)
    (tmp_path / "driver.c").write_text(text, encoding="utf-8")
    sources = [tmp_path / "driver.c", *sorted((place / "src").glob("*.c"))]
    subprocess.run(
        ["cc", "-shared", "-fPIC", "-O2", "-ffp-contract=off", "-std=c11", "-Wall", "-Wextra", "-Werror",
         f"-I{place / 'src'}", *sources, "-o", tmp_path / "unit.so"], check=True,
    )  # fmt: skip
    unit = ctypes.CDLL(str(tmp_path / "unit.so"))
    unit.step.restype = ctypes.c_double
    unit.start()
    block = Block(model, what, ramp=40, period=model.period, follow_offset=follow)
    rng = np.random.default_rng(5)
    for k in range(1500):
        u, y = rng.uniform(-1.5, 3.5), rng.uniform(-4.5, 5.5)
        if k % 37 == 0:
            u = NAN
        if k % 41 == 0:
            y = NAN
        further = rng.uniform(-1.0, 1.0, max(1, signals))
        x = (ctypes.c_double * 4)(u if what == "forward" else y, *further)
        told = dict(zip(block.given, further, strict=False))
        if k // 100 % 3:
            unit.observe(ctypes.c_double(u), ctypes.c_double(y), x)
            block.observe(u, y, told)
        else:
            on = k // 50 % 2
            answer = unit.step(x, on)
            assert answer == block.step(x[0], bool(on), told), k
