"""Types of the compiled core."""

from typing import Any

import numpy as np
import numpy.typing as npt

_Array = npt.NDArray[np.float64]
_Words = npt.NDArray[np.uint32]
_Compensator = tuple[_Array, _Array, float, float, _Array, _Array, _Array, _Array, _Array]

INPUT_LIMIT: float

def accept(x: float) -> bool: ...
def play_bank(
    x: _Array, thresholds: _Array, state: _Array, rows: npt.NDArray[np.int64]
) -> tuple[_Array, _Array]: ...
def pi_invert(
    thresholds: _Array, weights: _Array, state: _Array
) -> tuple[int, _Array, _Array, _Array]: ...
def stop_to_play(slope: float, stop_weights: _Array) -> _Array: ...
def map_values(u: _Array, v: _Array, x: _Array) -> _Array: ...

DIRECT_GROUPS: int
DIRECT_SCHEDULES: int
DIRECT_GIVEN: int
DIRECT_COEFFICIENTS: int
_Direct = tuple[
    _Array,
    _Array,
    _Array,
    _Array,
    npt.NDArray[np.int64],
    npt.NDArray[np.int64],
    _Array,
    _Array,
    _Array,
    int,
    int,
    bool,
]

def decay(x: float) -> float: ...
def direct_bank(
    y: _Array,
    time: _Array,
    radius: _Array,
    length: _Array,
    time_constant: _Array,
    known: bool,
    memory: _Array | None = None,
) -> tuple[_Array, _Array]: ...

class _Sampled:
    def save(self) -> _Array: ...
    def restore(self, image: _Array) -> None: ...
    @property
    def rejected(self) -> bool: ...
    @property
    def rejected_ever(self) -> bool: ...

class DirectStepper(_Sampled):
    def __init__(self, parameters: _Direct) -> None: ...
    def __call__(
        self,
        y: float,
        rate: float = 0.0,
        first: float = 0.0,
        second: float = 0.0,
        third: float = 0.0,
    ) -> float: ...
    def advance(
        self,
        y: float,
        rate: float,
        passed: float,
        time_constant: _Array,
        first: float = 0.0,
        second: float = 0.0,
        third: float = 0.0,
    ) -> float: ...
    def reset(self, y: float = 0.0) -> None: ...
    def simulate(
        self,
        y: _Array,
        rate: _Array,
        time: _Array,
        given: _Array,
        restart: npt.NDArray[np.int64],
        time_constant: _Array,
    ) -> tuple[_Array, int]: ...
    @property
    def doubt(self) -> float: ...
    @property
    def limited(self) -> bool: ...
    @property
    def memory(self) -> _Array: ...

class _PlayStepper(_Sampled):
    def __init__(
        self,
        thresholds: _Array,
        weights: _Array,
        center: float,
        offset: float,
        before_u: _Array,
        before_v: _Array,
        after_u: _Array,
        after_v: _Array,
        state: _Array,
    ) -> None: ...
    def __call__(self, x: float | None, period: float = 0.0) -> float: ...
    def simulate(self, x: _Array) -> tuple[_Array, int]: ...
    def reset(self) -> None: ...
    @property
    def method(self) -> str: ...
    @property
    def parameters(self) -> _Compensator: ...
    @property
    def state(self) -> _Array: ...
    @property
    def output(self) -> float: ...

class Stepper(_PlayStepper): ...
class StackStepper(_PlayStepper): ...

# ---- A model as a function block of a machine.
BLOCK_REJECTED: int
BLOCK_REJECTED_EVER: int
BLOCK_LIMITED: int
BLOCK_LIMITED_EVER: int

def block_image(
    thresholds: _Array,
    weights: _Array,
    center: float,
    offset: float,
    before_u: _Array,
    before_v: _Array,
    after_u: _Array,
    after_v: _Array,
    state: _Array,
    limits: list[float],
    fingerprint: int,
) -> _Words: ...

class _Machine:
    def reset(self) -> None: ...
    @property
    def output(self) -> float: ...
    @property
    def share(self) -> float: ...
    @property
    def flags(self) -> int: ...

class _SavedMachine(_Machine):
    def save(self) -> _Words: ...
    def restore(self, image: _Words) -> int: ...

class Block(_SavedMachine):
    def __init__(self, image: _Words) -> None: ...
    def step(self, x: float | None, on: bool) -> float: ...
    def run(self, x: _Array, on: npt.NDArray[np.bool_]) -> tuple[_Array, _Words]: ...
    def dump(self) -> _Words: ...
    @property
    def parameters(self) -> dict[str, Any]: ...
    @property
    def state(self) -> _Array: ...

OFFSET_WORDS: int

class Offset:
    def __init__(self, limit: float, turn: float, part: float, fingerprint: int) -> None: ...
    def reset(self) -> None: ...
    def next(self, x: float, on: bool) -> float: ...
    def step(
        self, x: float, said: float, measured: float, share: float, flags: int, on: bool
    ) -> float: ...
    def run(self, x: _Array, said: _Array, measured: _Array) -> _Array: ...
    def save(self) -> _Words: ...
    def restore(self, image: _Words) -> int: ...
    @property
    def applied(self) -> float: ...

class DirectBlock(_Machine):
    def __init__(
        self, parameters: _Direct, line_slope: float, line_offset: float, fade: float
    ) -> None: ...
    def step(
        self,
        y: float | None,
        rate: float | None,
        first: float | None,
        second: float | None,
        third: float | None,
        on: bool,
    ) -> float: ...
    def run(self, y: _Array, more: _Array, on: npt.NDArray[np.bool_]) -> tuple[_Array, _Words]: ...
    @property
    def doubt(self) -> float: ...

# ---- The engine: long signals.
ENGINE_DENSE: int

def engine_level() -> int: ...
def engine_best_level() -> int: ...
def engine_use_level(level: int) -> None: ...

class Evaluator:
    def __init__(
        self, thresholds: _Array, weights: _Array, center: float, offset: float, state: _Array
    ) -> None: ...
    def run(self, x: _Array, out: _Array | None = None) -> _Array: ...
    def method(self, method: int) -> None: ...
    @property
    def state(self) -> _Array: ...
    @property
    def events(self) -> int: ...
    @property
    def rejected(self) -> int: ...

# ---- The output that follows an input, from a direct inverse.
def direct_forward(
    u: _Array,
    time: _Array | None,
    given: _Array | None,
    first: float,
    lowest: _Array,
    highest: _Array,
    path: _Array,
    radii: _Array,
    lengths: _Array,
    time_constants: _Array,
    stop_weights: _Array,
    path_weights: _Array,
    creep_weights: _Array,
    polynomial: _Array,
    viscous: _Array,
    factor: list[int],
    low: _Array,
    high: _Array,
    center: float,
    held_low: float,
    held_high: float,
    y_low: float,
    y_high: float,
) -> tuple[_Array, int]: ...

# ---- Sums of elements: the core's machine.

ELEMENT_KINDS: tuple[str, ...]
_Kinds = npt.NDArray[np.int32]

class ElementSum:
    def __init__(
        self,
        kind: _Kinds,
        schedule: _Kinds,
        radius: _Array,
        time: _Array,
        weight: _Array,
        points: _Kinds,
        map: _Array,
        offset: float,
        before: _Array,
        after: _Array,
        low: float,
        high: float,
        source: _Kinds,
        range: _Array,
    ) -> None: ...
    def gains(self, period: float) -> _Array: ...
    def rest(self, x: float) -> _Array: ...
    def run(
        self,
        x: _Array,
        dt: _Array | None,
        given: _Array | None,
        memory: _Array,
        core: bool = False,
    ) -> tuple[_Array, _Array, int, int]: ...
    def solve(
        self,
        y: _Array,
        dt: _Array | None,
        given: _Array | None,
        memory: _Array,
        core: bool = False,
    ) -> tuple[_Array, _Array, int, int]: ...
    def columns(self, x: _Array, dt: _Array | None, memory: _Array) -> tuple[_Array, _Array]: ...

class ElementSteps:
    def __init__(
        self,
        sum: ElementSum,
        solves: bool,
        center: float,
        half_range: float,
        level: float,
        amplitude: float,
    ) -> None: ...
    def begin(self, memory: _Array) -> None: ...
    def step(self, value: float, passed: float) -> float: ...
    def memory(self) -> _Array: ...

class ElementPair:
    def __init__(
        self,
        own: ElementSum,
        from_second: ElementSum,
        from_first: ElementSum,
        second_own: ElementSum,
        numbers: _Array,
        solves: bool,
    ) -> None: ...
    def rest(self) -> _Array: ...
    def run(
        self, samples: _Array, dt: _Array | None, memory: _Array
    ) -> tuple[_Array, _Array, npt.NDArray[np.uint32], int]: ...

class ElementBlock(_SavedMachine):
    def __init__(
        self,
        sum: ElementSum,
        period: float,
        solves: bool,
        delay: int,
        start: _Array,
        numbers: _Array,
        fingerprint: int,
    ) -> None: ...
    def step(
        self,
        x: float | None,
        first: float | None,
        second: float | None,
        third: float | None,
        on: bool,
    ) -> float: ...
    def observe(
        self,
        input: float | None,
        output: float | None,
        first: float | None,
        second: float | None,
        third: float | None,
    ) -> None: ...
    def run(self, x: _Array, given: _Array, on: npt.NDArray[np.bool_]) -> tuple[_Array, _Words]: ...

# ---- The engine's bounded least squares.
SLOPES: int
WEIGHTS: int
STOPS: int

def solve_bounded(
    gram: _Array,
    rhs: _Array,
    lower: _Array,
    free: int,
    plays: int,
    basis: int,
    extra: _Array | None = None,
    extra_rhs: _Array | None = None,
    passive: npt.NDArray[np.bool_] | None = None,
    target_norm: float = 0.0,
) -> tuple[_Array, npt.NDArray[np.bool_], float, float, int, int]: ...
def triangle(matrix: _Array, out: _Array) -> None: ...
def ramps(e: _Array, cell: npt.NDArray[np.int64], numbers: _Array, out: _Array) -> None: ...
def sums_of_triangles(
    triangles: _Array, factors: _Array, chosen: npt.NDArray[np.int64]
) -> _Array: ...

# ---- The engine's streaming normal equations: sums of products of the columns [1 | cells | targets].
class Gram:
    def __init__(self, thresholds: _Array, state: _Array, targets: int) -> None: ...
    def add(self, x: _Array, targets: _Array, weights: _Array | None = None) -> None: ...
    def skip(self, x: _Array) -> None: ...
    def take(self) -> _Array: ...
    def method(self, prefix: int) -> None: ...
    def only_targets(self, only: bool) -> None: ...
    @property
    def events(self) -> int: ...
    @property
    def prefix(self) -> int: ...
    @property
    def state(self) -> _Array: ...

# ---- Signals.
def turning_points(x: _Array, swing: float) -> npt.NDArray[np.int64]: ...
def bin_sums(
    x: _Array, y: _Array, weight: _Array | None, bins: int, low: float, high: float
) -> _Array: ...
def essential(
    x: _Array, rows: npt.NDArray[np.int64]
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]: ...

# ---- Tables of numbers in text.
def text_lines(text: bytes, offset: int = 0) -> int: ...
def text_offset(text: bytes, lines: int, start: int = 0) -> int: ...
def text_whole_lines(text: bytes) -> int: ...
def text_number(text: bytes, decimal: str = ".") -> float | None: ...
def text_read(
    text: bytes,
    offset: int,
    line: int,
    delimiter: str,
    decimal: str,
    letters: list[int],
    columns: list[npt.NDArray[Any]],
    rows: npt.NDArray[np.int64],
    missing: bool = False,
    portable: bool = False,
) -> tuple[int, int, int, int, bool, bool]: ...

# ---- Friction along a path.
def bank_run(
    x: _Array, curve: _Array, element: _Array, weight: _Array, memory: _Array
) -> tuple[_Array, _Array]: ...
def bank_states(x: _Array, element: _Array, memory: _Array) -> _Array: ...
def bank_invert(
    y: _Array, farthest: float, curve: _Array, element: _Array, weight: _Array, memory: _Array
) -> tuple[_Array, _Array]: ...
def duhem_run(
    x: _Array, curve: _Array, alpha: float, loss: _Array, memory: _Array
) -> tuple[_Array, _Array]: ...
def duhem_invert(
    y: _Array, farthest: float, curve: _Array, alpha: float, loss: _Array, memory: _Array
) -> tuple[_Array, _Array]: ...
def lugre_run(
    x: _Array, dt: _Array, curve: _Array, parameter: _Array, memory: _Array
) -> tuple[_Array, _Array]: ...
def lugre_columns(
    x: _Array, dt: _Array, curve: _Array, parameter: _Array, memory: _Array
) -> _Array: ...
def lugre_invert(
    y: _Array, dt: _Array, farthest: float, curve: _Array, parameter: _Array, memory: _Array
) -> tuple[_Array, _Array]: ...

# ---- Operators on the triangle of switching values; cell (i, j), j <= i, is number i (i + 1)/2 + j.
def preisach_run(
    knots: _Array, everett: _Array, below: float, above: float, memory: _Array, x: _Array
) -> tuple[_Array, _Array]: ...
def preisach_invert(
    knots: _Array, everett: _Array, below: float, above: float, memory: _Array, y: _Array
) -> tuple[_Array, _Array]: ...
def preisach_cells(knots: _Array, memory: _Array, x: _Array) -> _Array: ...

# ---- Oscillators with hysteresis.
def oscillate(
    linear: _Array,
    bouc_wen: _Array,
    slope: _Array,
    grid: _Array,
    threshold: _Array,
    weight: _Array,
    square: _Array,
    force: _Array,
    steps: int,
    dt: float,
    state: _Array,
) -> tuple[_Array, _Array, int]: ...
