"""The programs beside a function block: how it is called, and the test that the PLC runs on itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from dehyst.export import Floats, Signal
from dehyst_targets.iec import SMALLEST, Instance
from dehyst_targets.st._blocks import INPUT_LIMIT, constant_texts, st_number, st_table, zeros
from dehyst_targets.st._pou import Pou, PouVariable, block_of, rendered

DOUBTFUL = {
    "Limited": 4,
    "LimitedEver": 8,
    "PressureLimit": 16,
    "ValveLimit": 32,
    "Learned": 256,
}  # bits of flags
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
        inputs: list[str] = []
        switches: dict[str, int] = {}
        for variable in block.section("VAR_INPUT"):
            # A test never restarts a block: Restart is no part of a signal.
            if variable.name == "Restart":
                continue
            if variable.type == "BOOL":
                switches[variable.name] = 1 << len(switches)
            else:
                inputs.append(variable.name)
        outputs, doubtful = [], {}
        for variable in block.section("VAR_OUTPUT"):
            if variable.type not in ("BOOL", "UDINT"):
                outputs.append(variable.name)
            if variable.name in DOUBTFUL:
                doubtful[variable.name] = DOUBTFUL[variable.name]
        return cls(tuple(inputs), switches, tuple(outputs), doubtful)

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
    # Every comparison with NaN is false: asked this way round, NaN is rejected too.
    if not abs(x) <= INPUT_LIMIT[real]:
        return NO_NUMBER
    if abs(x) < SMALLEST:
        return 0.0
    return min(max(x, NO_NUMBER / -10.0), NO_NUMBER / 10.0)


def example_program(block: str, real: str, words: Mapping[str, str], ports: Ports) -> Pou:
    """Return a program that calls the block of a model once a cycle of a task with a fixed period."""
    arguments, more = "", []
    for name in ports.inputs[1:]:
        arguments += f"{name} := My{name}, "
        comment = f"connect it: {words.get(name, '')}"
        more.append(PouVariable("VAR", f"My{name}", real, comment=comment))
    variables = (
        PouVariable("VAR", "MyBlock", block, comment="one instance for each actuator"),
        PouVariable("VAR", "MyInput", real, comment=f"connect it: {words['input']}"),
        *more,
        PouVariable(
            "VAR",
            "MyEnable",
            "BOOL",
            ("FALSE",),
            comment="connect it: TRUE while the machine is enabled",
        ),
        PouVariable(
            "VAR",
            "MyRestart",
            "BOOL",
            ("FALSE",),
            comment="connect it: TRUE for one call after homing",
        ),
        PouVariable("VAR", "MyOutput", real, comment=f"connect it: {words['output']}"),
        PouVariable(
            "VAR", "Healthy", "BOOL", ("FALSE",), comment="FALSE while samples are rejected"
        ),
    )
    body = (
        f"MyBlock(InputValue := MyInput, {arguments}Enable := MyEnable, Restart := MyRestart);\n"
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
    cubed: list[str] = []
    doubtful = ports.doubtful
    if real == "LREAL":
        # Flags hold to the bit in LREAL, and NO_NUMBER is rejected only when it is cubed.
        doubtful = {}
        cubed = [name for name, values in signal.inputs.items() if NO_NUMBER in values]
    mask = ~sum(doubtful.values())
    tables = []
    for name, values in signal.inputs.items():
        tables.append(st_table(f"Test{name}", real, constant_texts(values, real)))
    for name, switch in signal.switches.items():
        tables.append(st_table(f"Test{name}", "BOOL", map(_bool, switch)))
    for name, values in signal.outputs.items():
        tables.append(st_table(f"Expect{name}", real, constant_texts(values, real)))
    flags = [str(word & mask) for word in signal.flags]
    tables.append(st_table("ExpectFlags", "UDINT", flags))
    for name, value in signal.tolerances.items():
        tables.append(st_number(f"Tolerance{name}", real, value))
    variables = (
        *_RESULTS,
        PouVariable(
            "VAR_OUTPUT", "Largest", real, ("0.0",), comment="largest difference of outputs"
        ),
        PouVariable("VAR", "Tested", block),
        PouVariable("VAR", "Sample", "DINT", ("0",), comment="number of the next sample"),
        PouVariable("VAR", "Difference", real, ("0.0",)),
        PouVariable("VAR", "Wrong", "BOOL", ("FALSE",)),
        PouVariable("VAR", "Seen", "UDINT", ("0",), comment="flags that are compared"),
        PouVariable("VAR CONSTANT", "LastSample", "DINT", (str(signal.samples - 1),)),
        st_number("Zero", real, 0.0),
        *zeros(real, " ".join(f"Fed{name}" for name in cubed)),
        st_number("NoNumber", real, NO_NUMBER, "among the inputs it stands for what is no number"),
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
    return str(value).upper()


_RESULTS = (
    PouVariable(
        "VAR_OUTPUT",
        "Finished",
        "BOOL",
        ("FALSE",),
        comment="TRUE when the last sample was compared",
    ),
    PouVariable(
        "VAR_OUTPUT", "Passed", "BOOL", ("FALSE",), comment="TRUE if finished without a mismatch"
    ),
    PouVariable(
        "VAR_OUTPUT", "Mismatches", "DINT", ("0",), comment="samples whose outputs or flags differ"
    ),
    PouVariable(
        "VAR_OUTPUT", "FirstMismatch", "DINT", ("-1",), comment="number of the first of them"
    ),
)
