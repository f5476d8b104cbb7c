"""A small importer of co-simulation FMUs, without other packages: steps one and reads its variables."""

from __future__ import annotations

import ctypes as c
import tempfile
import zipfile
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Literal
from xml.etree import ElementTree as Xml

from dehyst.errors import OutputError, ParameterError
from dehyst.export.fmu.sources import LINUX, TARGETS, this_machine

_KINDS = {
    "Real": "real",
    "Integer": "whole",
    "Boolean": "truth",
    "Float64": "real",
    "Float32": "single",
    "Int32": "whole",
}
_CALLS = {
    2: {"real": ("Real", c.c_double), "whole": ("Integer", c.c_int), "truth": ("Boolean", c.c_int)},
    3: {
        "real": ("Float64", c.c_double),
        "single": ("Float32", c.c_float),
        "whole": ("Int32", c.c_int32),
        "truth": ("Boolean", c.c_bool),
    },
}
_LOGGER_2 = c.CFUNCTYPE(None, c.c_void_p, c.c_char_p, c.c_int, c.c_char_p, c.c_char_p, c.c_char_p)
_LOGGER_3 = c.CFUNCTYPE(None, c.c_void_p, c.c_int, c.c_char_p, c.c_char_p)


class _Callbacks2(c.Structure):
    _fields_ = (
        ("logger", _LOGGER_2),
        ("allocate", c.c_void_p),
        ("release", c.c_void_p),
        ("finished", c.c_void_p),
        ("environment", c.c_void_p),
    )


class Instance:
    """One instance of an FMU that this module's exporter wrote.

    Parameters
    ----------
    path
        Of the .fmu file.

    Raises
    ------
    OutputError
        If the file is no FMU, has no binary for this machine, or refuses to be instantiated.
    """

    def __init__(self, path: str | Path) -> None:
        self._messages: list[str] = []
        self._folder = tempfile.TemporaryDirectory()
        root = Path(self._folder.name)
        try:
            with zipfile.ZipFile(path) as packed:
                packed.extractall(root)
            xml = Xml.parse(root / "modelDescription.xml").getroot()
        except (OSError, zipfile.BadZipFile, Xml.ParseError) as fault:
            raise OutputError(f"'{path}' is no FMU: {fault}. Export it again.", path=str(path)) from None
        self._version: Literal[2, 3] = 2 if xml.get("fmiVersion", "").startswith("2") else 3
        self._name = xml.find("CoSimulation").get("modelIdentifier", "")  # type: ignore[union-attr]
        self._token = xml.get("guid") or xml.get("instantiationToken") or ""
        self._variables = dict(_variables(xml))
        self._library = c.CDLL(str(self._binary(root)))
        self._component = self._instantiate()
        self._time = 0.0

    @property
    def name(self) -> str:
        """Model identifier."""
        return self._name

    @property
    def token(self) -> str:
        """GUID or instantiation token."""
        return self._token

    @property
    def variables(self) -> dict[str, tuple[str, int, int]]:
        """Name -> (kind, value reference, length)."""
        return dict(self._variables)

    @property
    def messages(self) -> tuple[str, ...]:
        """What the FMU said."""
        return tuple(self._messages)

    def _binary(self, root: Path) -> Path:
        target = next((target for target in TARGETS if target.machine == this_machine()), LINUX)
        file = root / "binaries" / target.folders[self._version - 2] / f"{self._name}{target.suffix}"
        if not file.exists():
            raise OutputError(
                f"the FMU has no binary for this machine ({file.parent.name}). Export it on a machine with a compiler "
                f"for it, or type, in a copy: fmpy compile {self._name}.fmu",
                path=str(file.name),
            )
        return file

    def _instantiate(self) -> int:
        def say(*values: Any) -> None:
            self._messages.append(" ".join(v.decode() for v in values if isinstance(v, bytes) and v != b"%s"))

        name, token = b"instance", self._token.encode()
        if self._version == 2:
            self._keep: Any = _Callbacks2(_LOGGER_2(say), None, None, None, None)
            create = self._library.fmi2Instantiate
            create.restype = c.c_void_p
            made = create(name, 1, token, None, c.byref(self._keep), 0, 0)
        else:
            self._keep = _LOGGER_3(say)
            create = self._library.fmi3InstantiateCoSimulation
            create.restype = c.c_void_p
            no = c.c_bool(False)
            made = create(name, token, None, no, no, no, no, None, c.c_size_t(0), None, self._keep, None)
        if not made:
            raise OutputError(f"the FMU cannot be instantiated: {'; '.join(self._messages)}. Export it again.")
        return int(made)

    def _call(self, name: str, *values: Any) -> int:
        return int(getattr(self._library, f"fmi{self._version}{name}")(c.c_void_p(self._component), *values))

    def _good(self, name: str, *values: Any) -> None:
        if self._call(name, *values):
            raise OutputError(f"{name} was refused: {'; '.join(self._messages[-1:])}")

    def enter(self, start: float = 0.0) -> None:
        """Enter initialization mode at a start time. [s]"""
        no, zero, begin = c.c_bool(False), c.c_double(0.0), c.c_double(start)
        if self._version == 2:
            self._good("SetupExperiment", 0, zero, begin, 0, zero)
            self._good("EnterInitializationMode")
        else:
            self._good("EnterInitializationMode", no, zero, begin, no, zero)
        self._time = start

    def exit(self) -> None:
        """Leave initialization mode: the state is that of the start."""
        self._good("ExitInitializationMode")

    def step(self, length: float) -> None:
        """Make one communication step. [s]"""
        more: tuple[Any, ...] = (c.c_int(0),)
        if self._version == 3:
            flags = [c.c_bool() for _ in range(3)]
            more = (c.c_bool(False), *(c.byref(flag) for flag in flags), c.byref(c.c_double()))
        self._good("DoStep", c.c_double(self._time), c.c_double(length), *more)
        self._time += length

    def get(self, name: str) -> tuple[float, ...]:
        """Values of a variable.

        Raises
        ------
        ParameterError
            If there is none of this name.
        """
        kind, reference, length = self._variable(name)
        call, of = _CALLS[self._version][kind]
        values = (of * length)()  # type: ignore[operator]
        self._good(f"Get{call}", c.byref(c.c_uint32(reference)), c.c_size_t(1), values, *self._size(length))
        return tuple(values)

    def set(self, name: str, values: Sequence[float]) -> None:
        """Set an input or a parameter.

        Raises
        ------
        ParameterError
            If there is no variable of this name.
        OutputError
            If it cannot be set.
        """
        kind, reference, length = self._variable(name)
        call, of = _CALLS[self._version][kind]
        given = (of * length)(*(v if kind in ("real", "single") else int(v) for v in values))  # type: ignore[operator]
        self._good(f"Set{call}", c.byref(c.c_uint32(reference)), c.c_size_t(1), given, *self._size(length))

    def _variable(self, name: str) -> tuple[str, int, int]:
        if name not in self._variables:
            raise ParameterError(
                f"the FMU has no variable '{name:.60}'; it has {', '.join(self._variables)}.", name=name
            )
        return self._variables[name]

    def _size(self, length: int) -> tuple[Any, ...]:
        return (c.c_size_t(length),) if self._version == 3 else ()

    def close(self) -> None:
        """Free the instance and remove the unpacked files."""
        if self._component:
            free = getattr(self._library, f"fmi{self._version}FreeInstance")
            free.restype = None
            free(c.c_void_p(self._component))
            self._component = 0
        self._folder.cleanup()

    def __enter__(self) -> Instance:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, fault: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _variables(xml: Xml.Element) -> list[tuple[str, tuple[str, int, int]]]:
    found = []
    for element in xml.find("ModelVariables") or ():
        of = element[0] if element.tag == "ScalarVariable" else element
        dimension = of.find("Dimension")
        length = 1 if dimension is None else int(dimension.get("start", "1"))
        kind, reference = _KINDS[of.tag], int(element.get("valueReference", "0"))
        found.append((element.get("name", ""), (kind, reference, length)))
    return found
