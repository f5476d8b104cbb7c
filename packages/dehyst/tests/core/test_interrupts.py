"""Ctrl-C stops every long call of the binding at once, whatever it was doing; the object that was called goes on."""

import re
import signal
import threading
import time

import numpy as np
import pytest

import dehyst
from dehyst import _native
from dehyst.families._elements import Element, ElementModel
from dehyst_robot import _native as _robot
from dehyst_robot.control import Adaptation, JointControllerParameters
from direct_export_samples import direct_model
from export_samples import play_model
from places import ROOT

PROMISED = 0.2  # s of processor time; the bound of the test is generous
RNG = np.random.default_rng(0)
R, Z = np.linspace(0.0, 0.9, 100), np.zeros(100)
W = np.full(100, 0.01)
EMPTY = np.zeros(0)


def noise(samples):
    return RNG.uniform(-1, 1, samples)


def stepper(kind, *maps):
    before, after = maps or (EMPTY, EMPTY)
    return kind(R, W, 0.0, 0.0, before, before, after, after, Z)


def direct():
    return direct_model(schedules=0).core_stepper(1e-3)


CURVE, ELEMENT = np.array([0.0, 1.0]), np.array([1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0])
SUM = ElementModel((Element("input"), *(Element("play", r, weight=0.01) for r in R.tolist())))._sum
SQUARE = np.cov(RNG.normal(size=(1500, 3000)))


def long_calls():
    """Name of each long call -> the call itself, which would take seconds or minutes."""
    n = 10_000_000
    x, few = noise(n), noise(1_000_000)
    ones, none = np.full(few.size, 1e-3), np.zeros(few.size, np.int64)
    pairs = noise(3 * few.size).reshape(-1, 3)
    bend = np.linspace(-1, 1, 20)
    rows = np.arange(0, n, n // 50)
    everett = np.zeros((200, 200))
    knots = np.linspace(-1, 1, 200)
    block = dehyst.models.Block(play_model())
    model = direct_model(schedules=0)
    joint = _robot.JointController(
        JointControllerParameters().as_dict(), None, None, Adaptation().as_dict(), None
    )
    gram = _native.Gram(np.linspace(0, 0.9, 1000), np.zeros(1000), 1)
    linear = np.array([1.0, 0.1, 1.0, 0.0])
    element = np.tile(ELEMENT, 20)
    forward = (few, None, None, 0.0, np.zeros(50), np.zeros(50), EMPTY, np.linspace(0.1, 1, 50), EMPTY, EMPTY,
               np.full((1, 50), 0.02), np.zeros((1, 0)), np.zeros((1, 0)), np.array([[0.0, 1.0]]), np.zeros(1), [0],
               np.zeros(1), np.ones(1), 0.0, -9.0, 9.0, -9.0, 9.0)  # fmt: skip
    text = b"1.5,2.5\n" * 10_000_000

    def read():
        columns, where = [np.empty(10_000_000) for _ in range(2)], np.empty(10_000_000, np.int64)
        _native.text_read(text, 0, 0, ",", ".", [0, 0], columns, where)

    return {
        "Stepper.simulate": lambda: stepper(_native.Stepper).simulate(x),
        "Stepper.simulate with maps": lambda: stepper(_native.Stepper, bend, bend).simulate(x),
        "StackStepper.simulate": lambda: stepper(_native.StackStepper).simulate(x),
        "Evaluator.run": lambda: _native.Evaluator(R, W, 0.0, 0.0, Z).run(x),
        "Evaluator.run in place": lambda: (lambda y: _native.Evaluator(R, W, 0.0, 0.0, Z).run(y, y))(x.copy()),
        "play_bank": lambda: _native.play_bank(x, R, Z, rows),
        "play_bank by the definition": lambda: _native.play_bank(x, R, Z + 5 * (np.arange(100) % 2), rows),
        "map_values": lambda: _native.map_values(bend, bend, x),
        "Block.run": lambda: block._native.run(x, np.ones(n, bool)),
        "DirectStepper.simulate": lambda: direct().simulate(
            few, few, np.arange(few.size) * 1e-3, pairs, none, model.time_constants
        ),
        "DirectBlock.run": lambda: _native.DirectBlock(model.parameters(1e-3), 1.0, 0.0, 1.0).run(
            few, np.zeros((few.size, 4)), np.ones(few.size, bool)
        ),
        "direct_bank": lambda: _native.direct_bank(few, few, R[1:9], R[1:9], R[1:9], False),
        "direct_forward": lambda: _native.direct_forward(*forward),
        "JointController.run": lambda: joint.run(few, few, few, np.zeros((few.size, 7)), none),
        "ElementSum.run": lambda: SUM.run(few, None, None, SUM.rest(0.0)),
        "ElementSum.solve": lambda: SUM.solve(few, None, None, SUM.rest(0.0)),
        "ElementSum.columns": lambda: SUM.columns(few[:300_000], None, SUM.rest(0.0)),
        "bank_run": lambda: _native.bank_run(few, CURVE, element, np.ones(20), np.zeros(21)),
        "bank_states": lambda: _native.bank_states(few, element, np.zeros(21)),
        "bank_invert": lambda: _native.bank_invert(few, 99.0, CURVE, element, np.full(20, 0.01), np.zeros(21)),
        "lugre_run": lambda: _native.lugre_run(x, np.full(n, 1e-3), CURVE, np.ones(6), np.zeros(2)),
        "lugre_columns": lambda: _native.lugre_columns(x, np.full(n, 1e-3), CURVE, np.ones(6), np.zeros(2)),
        "lugre_invert": lambda: _native.lugre_invert(few, ones, 99.0, CURVE, np.full(6, 0.1), np.zeros(2)),
        "duhem_run": lambda: _native.duhem_run(x, CURVE, 1.0, np.array([0.1, 0.01]), np.zeros(2)),
        "duhem_invert": lambda: _native.duhem_invert(few, 99.0, CURVE, 1.0, np.array([0.1, 0.01]), np.zeros(2)),
        "preisach_run": lambda: _native.preisach_run(knots, everett.ravel(), 0.0, 0.0, np.zeros(4), x),
        "preisach_invert": lambda: _native.preisach_invert(knots, everett.ravel(), 1.0, 1.0, np.zeros(4), x),
        "preisach_cells": lambda: _native.preisach_cells(knots, np.zeros(4), few[:10_000]),
        "oscillate": lambda: _native.oscillate(
            linear, np.array([1.0, 0.5, 0.5, 0.1, 1.5]), EMPTY, EMPTY, EMPTY, EMPTY, EMPTY, x[:8_000_001], 10, 1e-3,
            np.zeros(3)
        ),
        "turning_points": lambda: _native.turning_points(x, 0.5),
        "essential": lambda: _native.essential(x, rows),
        "bin_sums": lambda: _native.bin_sums(x, x, x, 100, -1.0, 1.0),
        "Gram.add": lambda: gram.add(few, few[None], None),
        "Gram.skip": lambda: gram.skip(x),
        "solve_bounded": lambda: _native.solve_bounded(
            SQUARE, np.abs(noise(1500)), np.zeros(1500), 0, 1500, _native.SLOPES
        ),
        "text_read": read,
    }  # fmt: skip


CALLS = long_calls()


@pytest.fixture(autouse=True)
def heeded():
    """Ctrl-C as at a terminal: where the suite was started with `&` or nohup it is ignored, and loops would not end."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def late(call, delay=0.1):
    """Seconds of processor time, which other work does not lengthen, from SIGINT to KeyboardInterrupt; the call is made
    again until it is hit."""
    sent = []

    def send():
        sent.append(time.process_time())
        signal.raise_signal(signal.SIGINT)

    timer = threading.Timer(delay, send)
    timer.start()
    try:
        while True:
            call()
    except KeyboardInterrupt:
        return time.process_time() - sent[0]


@pytest.mark.parametrize("name", CALLS)
def test_a_long_call_stops_when_it_is_asked_to(name):
    assert late(CALLS[name]) < 5 * PROMISED


def test_every_loop_of_the_binding_can_be_stopped():
    """A function that frees the interpreter for its work asks afterwards whether it was stopped."""
    for path in sorted((ROOT / "src").glob("native*/*.cpp")):
        text = path.read_text(encoding="utf-8")
        freed = len(re.findall(r"gil_scoped_release \w+;|const Turn \w+\(.*\);\n.*_run\(", text))
        assert text.count("raise_if_stopped();") >= freed - 3 * (path.name == "text.cpp"), path.name


def test_an_interrupted_simulation_leaves_the_stepper_as_it_was():
    step, x = stepper(_native.Stepper), noise(10_000_000)
    step(0.7)
    before = step.save()
    late(lambda: step.simulate(x))
    # The calls before the one that was hit moved it; all of them end in the same state.
    whole = stepper(_native.Stepper)
    whole(0.7)
    whole.simulate(x)
    assert np.array_equal(step.save(), before) or np.array_equal(step.save(), whole.save())


def test_a_stopped_run_in_another_thread_is_not_disturbed():
    """Signals belong to the main thread: a worker's call runs to its end."""
    done = []
    x = noise(3_000_000)
    worker = threading.Thread(target=lambda: done.append(stepper(_native.Stepper).simulate(x)[0]))
    worker.start()
    late(lambda: stepper(_native.Stepper).simulate(x))
    worker.join()
    assert np.array_equal(done[0], stepper(_native.Stepper).simulate(x)[0])
