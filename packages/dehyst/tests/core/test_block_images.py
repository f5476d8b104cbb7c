"""Images of blocks: saved and restored to the bit; damaged, foreign and impossible ones are refused by name."""

import struct
import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from block_samples import inverse_block, sample, wishes
from dehyst import Block, ModifiedPrandtlIshlinskii, MonotoneMap, PrandtlIshlinskii, _native
from dehyst.errors import ParameterError
from in_one import in_one

SEEDS = st.integers(0, 100_000)
MODEL = ModifiedPrandtlIshlinskii(
    PrandtlIshlinskii([0.0, 0.2, 0.4], [0.6, 0.3, 0.3], center=0.1),
    after_map=MonotoneMap([-2.0, 0.0, 2.0], [-1.0, 0.0, 2.0]),
)
REST = (
    *(
        "center",
        "offset",
        "input_low",
        "input_high",
        "output_low",
        "output_high",
        "reach_low",
        "reach_high",
    ),
    *("line_slope", "line_offset", "fade"),
)


def signed(words):
    """Return words with the checksum that belongs to them, by zlib."""
    body = np.asarray(words[:-1], dtype="<u4")
    return np.append(body, np.uint32(zlib.crc32(body.tobytes()))).astype(np.uint32)


def with_number(words, index, value):
    """Return an image in which the index-th number behind the five words of the head has another value."""
    changed = np.array(words)
    changed[5 + 2 * index : 7 + 2 * index] = struct.unpack("<2I", struct.pack("<d", value))
    return signed(changed)


def refused(block, image):
    before = block.save()
    with pytest.raises(ParameterError, match="not restored") as caught:
        block.restore(image)
    assert block.save().tobytes() == before.tobytes()
    return caught.value.facts["fault"]


def used(seed=0, **settings):
    block = Block(MODEL, range=(-1.0, 1.0), **settings)
    block.run(wishes(block, np.random.default_rng(seed), 40))
    return block


@given(SEEDS, st.booleans())
def test_a_restored_block_goes_on_bit_for_bit(seed, forward):
    model, bounds, rng = sample(seed)
    one, other = (
        Block(model, "forward" if forward else "inverse", bounds, ramp=9) for _ in range(2)
    )
    x, on = wishes(one, rng, 200), np.repeat(rng.random(40) < 0.5, 5)
    x[rng.random(x.size) < 0.05] = np.nan
    k = int(rng.integers(0, 200))
    one.run(x[:k], on[:k])
    image = one.save()
    other.restore(image)
    assert other.save().tobytes() == image.tobytes()
    y, flags = one.run(x[k:], on[k:])
    again, other_flags = other.run(x[k:], on[k:])
    assert y.tobytes() == again.tobytes()
    assert np.array_equal(flags, other_flags)
    assert one.save().tobytes() == other.save().tobytes()


@given(SEEDS)
def test_a_block_made_of_dumped_parameters_is_the_same_block(seed):
    block, _, _, rng = inverse_block(seed)
    image = block.dump()
    again = _native.Block(image)
    assert again.dump().tobytes() == image.tobytes()
    x = wishes(block, rng, 100)
    assert again.run(x, np.ones(100, dtype=bool))[0].tobytes() == block.run(x)[0].tobytes()
    assert again.save().tobytes() == block.save().tobytes()
    p = block.parameters
    for name, value in again.parameters.items():
        assert np.array_equal(getattr(p, name), value)


def test_the_checksum_is_the_common_one():
    for image in (used().save(), used().dump()):
        assert image[-1] == zlib.crc32(image[:-1].astype("<u4").tobytes())


@given(st.integers(0, 10**9))
def test_every_flipped_bit_is_found(place):
    block = used()
    image = block.save()
    word, bit = place % image.size, (place // image.size) % 32
    image[word] ^= np.uint32(1 << bit)
    assert refused(block, image) in ("damaged", "kind")
    parameters = block.dump()
    parameters[place % parameters.size] ^= np.uint32(1 << bit)
    with pytest.raises(ValueError, match=r"^[23]$"):
        _native.Block(parameters)


def test_images_of_another_kind_or_length_are_refused_by_name():
    block = used()
    image = block.save()
    assert refused(block, image[:-1]) == "size"
    assert refused(block, np.append(image, 0)) == "size"
    assert refused(block, []) in ("size", "kind")
    assert refused(block, block.dump()) == "size"
    assert refused(block, signed([*b"abcd", *image[4:]])) == "kind"
    assert refused(block, image.astype(float)) == "kind"
    assert refused(block, image[None]) == "kind"
    assert refused(block, "image") == "kind"
    assert refused(block, -image.astype(np.int64)) == "kind"


def test_images_of_another_model_are_refused_but_other_limits_and_ramps_are_not():
    block = used()
    hysteresis = MODEL.hysteresis
    other = PrandtlIshlinskii(hysteresis.thresholds, [0.6, 0.3, 0.30001], center=0.1)
    foreign = [
        Block(ModifiedPrandtlIshlinskii(other, after_map=MODEL.after_map), range=(-1.0, 1.0)),
        Block(ModifiedPrandtlIshlinskii(hysteresis, before_map=MODEL.after_map), range=(-1.0, 1.0)),
        Block(MODEL, "forward", range=(-1.0, 1.0)),
    ]
    assert [refused(block, wrong.save()) for wrong in foreign] == ["foreign"] * 3
    wider = Block(MODEL, range=(-1.5, 1.5), ramp=3)
    wider.restore(block.save())
    assert wider.last == block.last
    assert wider.parameters.fingerprint == block.parameters.fingerprint


@pytest.mark.parametrize(
    ("index", "value"),
    [
        *((k, float("nan")) for k in range(6)),
        *((k, float("inf")) for k in range(6)),
        (0, 50.0),  # a play far from its neighbour
        (1, -50.0),
        (3, 1.5),  # share
        (3, -0.1),
        (4, 3.0),  # output beyond the actuator's range
        (5, 1e101),
    ],
)
def test_signed_images_of_impossible_states_are_refused(index, value):
    block = used()
    assert refused(block, with_number(block.save(), index, value)) == "invalid"


@pytest.mark.parametrize(("word", "value"), [(3, 16), (3, 2**31), (4, 2), (4, 2**32 - 1)])
def test_signed_images_with_impossible_flags_are_refused(word, value):
    block = used()
    image = block.save()
    image[word] = value
    assert refused(block, signed(image)) == "invalid"


def bad_parameters():
    """Return (name of the fault, index of a number, value), the numbers in the order of dehyst_block_dump."""
    n, before = 3, 3  # inverse: three operators, a map of three points in front
    at = {
        "threshold": 0,
        "slope": n,
        "loading": 2 * n,
        "start": 3 * n,
        "u": 4 * n,
        "v": 4 * n + before,
    }
    at |= {name: 4 * n + 2 * before + k for k, name in enumerate(REST)}
    for name, index in at.items():
        yield f"{name} is no number", index, float("nan")
        yield f"{name} is endless", index, -float("inf")
        yield f"{name} is beyond the limit", index, 1.1e100
    yield "negative threshold", 0, -0.1
    yield "equal thresholds", 1, 0.0
    yield "loading curve of other slopes", 2 * n + 2, 7.0
    yield "loading curve that begins elsewhere", 2 * n, 1e-3
    yield "slopes of another loading curve", n, 7.0
    yield "start that no input leaves", 3 * n, 9.0
    yield "map that turns", 4 * n + 1, 9.0
    yield "map that stands still", at["v"] + 1, -2.0
    yield "input range without an inside", at["input_low"], 99.0
    yield "output range without an inside", at["output_high"], -99.0
    yield "reach without an inside", at["reach_low"], 99.0
    yield "no ramp", at["fade"], 0.0
    yield "negative ramp", at["fade"], -0.1
    yield "ramp of less than a sample", at["fade"], 1.5
    yield "input with an argument beyond the limit", at["center"], 9e99


@in_one("name, index, value", bad_parameters())
def test_signed_parameters_of_no_block_are_refused(name, index, value):
    image = used().dump()
    with pytest.raises(ValueError, match=r"^5$"):
        _native.Block(with_number(image, index, value))


@pytest.mark.parametrize(
    ("word", "value"), [(1, 0), (1, 2**31), (1, 100_001), (2, 2**32 - 1), (3, 200_000)]
)
def test_signed_parameters_with_impossible_sizes_are_refused(word, value):
    image = used().dump()
    image[word] = value
    with pytest.raises(ValueError, match=r"^5$"):
        _native.Block(signed(image))


@pytest.mark.parametrize("word", [1, 2, 3])
def test_signed_parameters_with_another_size_are_refused(word):
    image = used().dump()
    image[word] += 1
    with pytest.raises(ValueError, match=r"^1$"):
        _native.Block(signed(image))
    with pytest.raises(ValueError, match=r"^1$"):
        _native.Block(image[:5])
