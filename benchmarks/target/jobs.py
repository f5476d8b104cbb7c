"""Jobs of the drivers: parameters of blocks as images, and signals; answers read back."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst.export import Subject, UnitNumbers

Array = npt.NDArray[np.float64]
KIND = {"double": 0x64685008, "float": 0x64685004}  # block_image.c
TYPE = {"double": np.dtype("<f8"), "float": np.dtype("<f4")}
LIMITS = ("input_low", "input_high", "output_low", "output_high", "reach_low", "reach_high")
REST = (*LIMITS, "line_slope", "line_offset", "fade")


@dataclass(frozen=True)
class Case:
    """A block with the signal to run it over from its reset on."""

    block: UnitNumbers
    x: Array
    on: npt.NDArray[np.bool_]

    def words(self, real: str) -> bytes:
        """Return the whole case as words of a job."""
        parameters = image(self.block, real)
        samples = np.empty(self.x.size, [("x", TYPE[real]), ("on", "<u4")])
        with np.errstate(over="ignore"):
            samples["x"], samples["on"] = self.x, self.on
        return word(len(parameters) // 4) + parameters + word(self.x.size) + samples.tobytes()


@dataclass(frozen=True)
class Answer:
    """What a block did: output and flags of every sample, and the play states at the end."""

    y: Array
    flags: npt.NDArray[np.uint32]
    state: Array


def word(value: int) -> bytes:
    """Return a number as one word."""
    return np.array(value, "<u4").tobytes()


def image(block: UnitNumbers, real: str) -> bytes:
    """Return parameters as dehyst_block_load takes them."""
    model = block.model
    maps = [values for pair in (model.before, model.after) for values in pair or ((), ())]
    rest = (model.center, model.offset, *(getattr(block, name) for name in REST))
    head = [KIND[real], model.parts, *model.points, block.fingerprint]
    parts = (model.threshold, model.slope, model.loading, model.start, *maps, rest)
    body = np.array(head, "<u4").tobytes() + b"".join(
        np.asarray(part, TYPE[real]).tobytes() for part in parts
    )
    return body + word(zlib.crc32(body))


def job(cases: Sequence[Case], real: str) -> bytes:
    """Return the content of job.bin."""
    return word(len(cases)) + b"".join(case.words(real) for case in cases)


def joint_job(subject: Subject, periods: int) -> bytes:
    """Return the recorded run of a joint controller as job.bin."""
    test, kind = subject.test, TYPE[subject.real]
    rows = np.empty(min(periods, test.samples), [("x", kind, 10), ("switches", "<u4")])
    rows["x"], rows["switches"] = test.inputs[: rows.size], test.switch[: rows.size]
    return word(rows.size) + rows.tobytes()


def unit_job(inputs: Array, real: str) -> bytes:
    """Return samples (T, m) of an exported block, always on, as job.bin."""
    rows = np.empty(len(inputs), [("x", TYPE[real], inputs.shape[1:]), ("on", "<u4")])
    rows["x"], rows["on"] = inputs, 1
    return word(rows.size) + rows.tobytes()


def answers(content: bytes, cases: Sequence[Case], real: str) -> list[Answer]:
    """Read answer.bin."""
    found, at = [], 0
    for case in cases:
        rows = np.frombuffer(content, [("y", TYPE[real]), ("flags", "<u4")], case.x.size, at)
        at += rows.nbytes
        state = np.frombuffer(content, TYPE[real], case.block.model.parts, at)
        at += state.nbytes
        found.append(Answer(rows["y"].astype(float), rows["flags"], state.astype(float)))
    if at != len(content):
        raise ValueError(f"the answer has {len(content)} bytes, not {at}")
    return found
