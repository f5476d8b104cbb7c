"""The programs beside a function block: how it is called, and the test that the PLC runs on itself."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from dehyst.export.iec import Instance
from dehyst.export.iec.parser import SMALLEST
from dehyst.export.precision import Floats
from dehyst.export.signal import Signal
from dehyst.export.st.blocks import INPUT_LIMIT, number
from dehyst.export.st.pou import Pou, Variable, block_of, constant, rendered

DOUBTFUL = {"Limited": 4, "LimitedEver": 8, "PressureLimit": 16, "ValveLimit": 32, "Learned": 256}  # bits of flags
NO_NUMBER = 1e36  # stands for a NaN, for which a PLC has no constant; its cube is rejected, or itself in REAL


@dataclass(frozen=True)
class Ports:
    """How a signal's columns belong to a function block.

    Parameters
    ----------
    inputs
        Names in the order of the columns.
    switches
        Name -> bit of the signal's switch.
    outputs
        Names in the order of the columns.
    doubtful
        Name -> bit of the flags that may hang on the last digit in REAL: whether a limit was met.
    """

    inputs: tuple[str, ...]
    switches: Mapping[str, int]
    outputs: tuple[str, ...]
    doubtful: Mapping[str, int]

    @classmethod
    def of(cls, block: Pou) -> Ports:
        """Return those of a function block: declared in the order of the columns, and of the bits of a switch."""
        inputs = [v for v in block.variables if v.section == "VAR_INPUT" and v.name != "Restart"]
        outputs = [v for v in block.variables if v.section == "VAR_OUTPUT"]
        return cls(
            tuple(v.name for v in inputs if v.type != "BOOL"),
            {v.name: 1 << bit for bit, v in enumerate(v for v in inputs if v.type == "BOOL")},
            tuple(v.name for v in outputs if v.type not in ("BOOL", "UDINT")),
            {v.name: DOUBTFUL[v.name] for v in outputs if v.name in DOUBTFUL},
        )

    @property
    def sure(self) -> int:
        """Return the bits of the flags that hold in REAL too."""
        return ~sum(self.doubtful.values())

    def call(self, unit: Instance, signal: Signal, k: int) -> dict[str, float | int | bool]:
        """Call a unit with sample k of a signal."""
        row = {name: float(x) for name, x in zip(self.inputs, signal.inputs[k], strict=True)}
        switches = {name: bool(signal.switch[k] & bit) for name, bit in self.switches.items()}
        return unit.call(**row, **switches, Restart=False)


@dataclass(frozen=True)
class PlcSignal:
    """What the test program feeds to a block, sample by sample, and what must come out.

    Parameters
    ----------
    inputs, switches, outputs
        By the names of the block, (T,) each; each input is one for which Structured Text has a constant (`writable`).
    flags
        Expected flags, (T,).
    tolerances
        Largest allowed difference of each output: 0 for LREAL.
    """

    inputs: Mapping[str, Floats]
    switches: Mapping[str, tuple[bool, ...]]
    outputs: Mapping[str, Floats]
    flags: tuple[int, ...]
    tolerances: Mapping[str, float]

    @property
    def samples(self) -> int:
        """Return T."""
        return len(self.flags)


def writable(x: float, real: str) -> float:
    """Return an input for which every tool has a constant: `NO_NUMBER` for one that is rejected.

    What only LREAL holds becomes a tenth of that, or 0.

    Examples
    --------
    >>> [writable(x, "LREAL") for x in (float("nan"), 1e101, -1e99, 5e-324, 0.5)], writable(1e14, "REAL")
    ([1e+36, 1e+36, -1e+35, 0.0, 0.5], 100000000000000.0)
    """
    if not abs(x) <= INPUT_LIMIT[real]:
        return NO_NUMBER
    return min(max(x, NO_NUMBER / -10.0), NO_NUMBER / 10.0) if abs(x) >= SMALLEST else 0.0


def example(block: str, real: str, words: Mapping[str, str], ports: Ports) -> Pou:
    """Return a program that calls the block of a model once a cycle of a task with a fixed period."""
    more = ports.inputs[1:]
    given = "".join(f"{name} := My{name}, " for name in more)
    variables = (
        Variable("VAR", "MyBlock", block, comment="one instance for each actuator"),
        Variable("VAR", "MyInput", real, comment=f"connect it: {words['input']}"),
        *(Variable("VAR", f"My{name}", real, comment=f"connect it: {words.get(name, '')}") for name in more),
        Variable("VAR", "MyEnable", "BOOL", ("FALSE",), comment="connect it: TRUE while the machine is enabled"),
        Variable("VAR", "MyRestart", "BOOL", ("FALSE",), comment="connect it: TRUE for one call after homing"),
        Variable("VAR", "MyOutput", real, comment=f"connect it: {words['output']}"),
        Variable("VAR", "Healthy", "BOOL", ("FALSE",), comment="FALSE while samples are rejected"),
    )
    body = (
        f"MyBlock(InputValue := MyInput, {given}Enable := MyEnable, Restart := MyRestart);\n"
        "MyOutput := MyBlock.OutputValue;\n"
        "Healthy := NOT MyBlock.Rejected;\n"
    )
    return Pou("PROGRAM", f"{block}_Example", variables, body, _example_comment(block, words))


def _example_comment(block: str, words: Mapping[str, str]) -> str:
    return (
        f"Example of a call of {block}. Give this program a cyclic task with a fixed interval"
        f"{words['task']}; call the block exactly once a cycle, whether it is enabled or not: its states follow."
    )


def self_test(block: str, real: str, ports: Ports, signal: PlcSignal) -> Pou:
    """Return a block that feeds the test signal to another, one sample a call, and counts what differs.

    It is a function block because STruC++ leaves constant arrays of a PROGRAM at zero.
    """
    cubed = [name for name, xs in signal.inputs.items() if real == "LREAL" and NO_NUMBER in xs]
    doubtful = {} if real == "LREAL" else ports.doubtful
    mask = ~sum(doubtful.values())
    tables = (
        *(_table(f"Test{name}", real, (constant(x, real) for x in xs)) for name, xs in signal.inputs.items()),
        *(_table(f"Test{name}", "BOOL", (_bool(on) for on in ons)) for name, ons in signal.switches.items()),
        *(_table(f"Expect{name}", real, (constant(y, real) for y in ys)) for name, ys in signal.outputs.items()),
        _table("ExpectFlags", "UDINT", (str(flags & mask) for flags in signal.flags)),
        *(number(f"Tolerance{name}", real, value) for name, value in signal.tolerances.items()),
    )
    variables = (
        *_RESULTS,
        Variable("VAR_OUTPUT", "Largest", real, ("0.0",), comment="largest difference of outputs"),
        Variable("VAR", "Tested", block),
        Variable("VAR", "Sample", "DINT", ("0",), comment="number of the next sample"),
        Variable("VAR", "Difference", real, ("0.0",)),
        Variable("VAR", "Wrong", "BOOL", ("FALSE",)),
        Variable("VAR", "Seen", "UDINT", ("0",), comment="flags that are compared"),
        Variable("VAR CONSTANT", "LastSample", "DINT", (str(signal.samples - 1),)),
        number("Zero", real, 0.0),
        *(Variable("VAR", f"Fed{name}", real, ("0.0",)) for name in cubed),
        number("NoNumber", real, NO_NUMBER, "among the inputs it stands for what is no number"),
        *tables,
    )
    body = rendered("test.st.j2", ports=ports, doubtful=doubtful, cubed=cubed)
    comment = (
        f"Test of {block} on the PLC itself: one sample a call, {signal.samples} calls. Declare an instance in a "
        "program of a cyclic task, and call it there. Passed must become TRUE; remove it when it has. The block that "
        "is in use is another instance."
    )
    return block_of(f"{block}_Test", variables, body, comment)


def _bool(value: bool) -> str:
    return "TRUE" if value else "FALSE"


def _table(name: str, type_: str, values: Iterable[str]) -> Variable:
    initial = tuple(values)
    return Variable("VAR CONSTANT", name, type_, initial, len(initial))


_RESULTS = (
    Variable("VAR_OUTPUT", "Finished", "BOOL", ("FALSE",), comment="TRUE when the last sample was compared"),
    Variable("VAR_OUTPUT", "Passed", "BOOL", ("FALSE",), comment="TRUE if finished without a mismatch"),
    Variable("VAR_OUTPUT", "Mismatches", "DINT", ("0",), comment="samples whose outputs or flags differ"),
    Variable("VAR_OUTPUT", "FirstMismatch", "DINT", ("-1",), comment="number of the first of them"),
)
