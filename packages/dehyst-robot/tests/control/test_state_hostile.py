"""Files of controllers and images of states, cut and forged with checksums renewed: taken whole or refused by name."""

from __future__ import annotations

import copy
import json
import math
import random

import numpy as np
import pytest

from block_samples import inverse_block, wishes
from dehyst import PrandtlIshlinskii
from dehyst.errors import DehystError
from dehyst_robot.control import (
    Adaptation,
    JointControllerParameters,
    load_adaptation,
    load_controller,
    load_partner,
    save_controller,
)
from dehyst_robot.control._storage import _checksum
from test_block_images import signed
from test_learning import LEARNS, JointReference, in_bounds, learner

LIES = [
    0,
    -1,
    1,
    2**31,
    2**63,
    10**400,
    -(10**400),
    1e308,
    -1e308,
    5e-324,
    math.nan,
    math.inf,
    -math.inf,
    True,
    None,
]
LIES += [
    "",
    "1.0",
    "x" * 2000,
    "\x1b[31m",
    "\ud800",
    [],
    [1.0] * 9,
    {},
    {"a": 1},
    [[[]]],
    "__class__",
]
CASES = 700


def places(value, way=()):
    """Ways to every value of a JSON content."""
    children = (
        value.items()
        if isinstance(value, dict)
        else enumerate(value)
        if isinstance(value, list)
        else ()
    )
    return [way, *(one for key, child in children for one in places(child, (*way, key)))]


def forged(content, dice):
    content = copy.deepcopy(content)
    for _ in range(dice.choice([1, 1, 2, 4])):
        *way, last = dice.choice([one for one in places(content) if one and one[0] != "sha256"])
        holder = content
        for key in way:
            holder = holder[key]
        if dice.random() < 0.15:
            del holder[last]
        elif dice.random() < 0.15 and isinstance(holder, dict):
            holder[dice.choice(["__init__", "pole ", "", "rate", "pole"])] = copy.deepcopy(
                dice.choice(LIES)
            )
        else:
            holder[last] = copy.deepcopy(dice.choice(LIES))
    told = {key: content[key] for key in ("parameters", "adaptation", "model") if key in content}
    content["sha256"] = _checksum(told)
    return content


def numbers(value):
    children = (
        value.values()
        if isinstance(value, dict)
        else value
        if isinstance(value, list | tuple)
        else None
    )
    return [value] if children is None else [one for child in children for one in numbers(child)]


def look(path):
    """Read all that a controller file tells; whatever is taken is a finite number, or a text that is fit to show."""
    taken = 0
    for load in (load_controller, load_adaptation, load_partner):
        try:
            found = load(path)
        except DehystError as fault:
            assert len(str(fault)) > 30 and str(fault).replace("\n", "").isprintable()
            continue
        taken += 1
        if isinstance(found, tuple):
            assert all(isinstance(one, str) for one in found)
            assert all(one.isprintable() for one in found), found
        elif found is not None:
            assert all(
                type(one) in (int, float) and math.isfinite(one) for one in numbers(found.as_dict())
            )
    return taken


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["parameters", "adaptation", "model"])
def test_forged_controller_files_are_taken_whole_or_refused(kind, tmp_path):
    told = {"adaptation": Adaptation()} if kind != "parameters" else {}
    told |= {"model": PrandtlIshlinskii([0.0], [2.0])} if kind == "model" else {}
    path = save_controller(JointControllerParameters(), tmp_path / "c.json", **told)
    text, content, dice = path.read_bytes(), json.loads(path.read_text()), random.Random(kind)
    assert look(path) == 3
    taken = 0
    for _ in range(CASES):
        path.write_text(json.dumps(forged(content, dice)))
        taken += look(path) > 0
    assert 10 < taken < CASES, "some lies are values that a controller may have"
    for _ in range(200):
        raw = bytearray(text)
        raw[dice.randrange(len(raw))] = dice.randrange(256)
        path.write_bytes(raw)
        look(path)
    for end in range(0, len(text) - 2, 7):
        path.write_bytes(text[:end])
        assert look(path) == 0


WORDS = [
    0,
    1,
    2,
    0x7FF00000,
    0xFFF00000,
    0x7FF80000,
    0x7FEFFFFF,
    0x80000000,
    0xFFFFFFFF,
    0x40000000,
    0xC1E00000,
]


def with_lies(words, dice):
    """Return words, one to four of them changed, under the checksum that belongs to them."""
    words = np.array(words)
    for _ in range(dice.choice([1, 1, 2, 4])):
        at = dice.randrange(words.size - 1)
        words[at] = dice.choice(
            [*WORDS, int(words[at]) ^ 1 << dice.randrange(32), dice.randrange(2**32)]
        )
    return signed(words)


def restored(machine, image):
    """Whether an image was taken; a refused one leaves the state that was there."""
    before = bytes(machine.save())
    try:
        machine.restore(image)
    except DehystError as fault:
        assert fault.facts["fault"] in ("size", "kind", "damaged", "foreign", "invalid")
        assert bytes(machine.save()) == before
        return False
    return True


@pytest.mark.parametrize("seed", range(4))
def test_forged_images_of_a_block_leave_it_within_its_limits(seed):
    block, _, _, rng = inverse_block(seed)
    x, dice = wishes(block, rng, 40), random.Random(seed)
    block.run(x)
    good = block.save()
    assert not any(restored(block, good[:end]) for end in range(good.size))
    taken = 0
    for _ in range(CASES):
        if restored(block, with_lies(good, dice)):
            taken += 1
            outputs, _ = block.run(x)
            assert np.isfinite(outputs).all()
            assert block.output.low <= outputs.min() and outputs.max() <= block.output.high
    assert taken


@pytest.mark.parametrize("seed", range(3))
def test_forged_images_of_what_was_learned_stay_in_bounds(seed):
    controller, dice = learner(), random.Random(seed)
    for k in range(50):
        controller.step(0.2 * np.sin(k / 9), 3e5, 3e5, JointReference(0.2 * np.sin(k / 9)), LEARNS)
    good = controller.save()
    assert not any(restored(controller, good[:end]) for end in range(len(good)))
    taken = 0
    for _ in range(CASES):
        if restored(
            controller, with_lies(np.frombuffer(good, "<u4"), dice).astype("<u4").tobytes()
        ):
            taken += 1
            in_bounds(controller, Adaptation())
            for angle in (0.1, 0.11):
                answer = controller.step(angle, 3e5, 3e5, JointReference(angle), LEARNS)
                assert np.isfinite([answer.contact, answer.doubt, answer.load]).all()
            in_bounds(controller, Adaptation())
    assert taken
