"""Table of log formats: how the first bytes identify one, and which module reads it."""

from __future__ import annotations

import hashlib
import os
import re
import zlib
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Any

from dehyst.errors import LogError
from dehyst.io._collect import Collector, NotInPartsError, Source
from dehyst.io._delimited import TextParts, read_delimited
from dehyst.io._foreign import guard, optional
from dehyst.io._frames import is_frame, table_of_frame
from dehyst.io._table import LogTable
from dehyst.io._text import GZIP, SIZE_LIMIT
from dehyst.shell import quoted

PathLike = str | os.PathLike[str]

THREAD_BYTES = 1 << 20  # larger files are hashed beside the reading
HEAD_BYTES = 1024  # tell the format
HDF5 = b"\x89HDF\r\n\x1a\n"
PACKERS = {  # pattern of the first bytes -> program
    rb"BZh[1-9]1AY&SY": "bzip2",
    rb"\xfd7zXZ\x00": "xz",
    rb"\x28\xb5\x2f\xfd": "zstd",
}
TAR_MARK = 257  # where a tar archive names its format


@dataclass(frozen=True)
class Format:
    """A row of `FORMATS`.

    `module`, a module in ``dehyst.io``, is imported when it is needed. It has ``fill(collector, data, path)``, which
    adds what a file holds to a `Collector`; and, where long logs are read in parts, the `Source` that `parts` names.
    """

    title: str  # in messages
    endings: tuple[str, ...]  # that promise this format
    marks: (
        tuple[bytes, ...] | Callable[[bytes, str], bool]
    )  # first bytes, or what tells by first bytes and ending
    module: str
    needs: tuple[str, ...] = ()  # packages that it imports
    extra: str = ""  # of dehyst that installs them
    instead: str = "save the columns as CSV"  # what can be done without them
    parts: str = ""  # its `Source` of long logs; "" if it reads a log at once only

    def knows(self, head: bytes, ending: str) -> bool:
        """Whether a file with these first bytes and this ending is of this format."""
        return self.marks(head, ending) if callable(self.marks) else head.startswith(self.marks)

    def reader(self, log: str) -> Any:
        """Module that reads the format, once the packages that it needs are known to be there."""
        for name in self.needs:
            optional(name, self.extra, log, instead=self.instead)
        return import_module(f"dehyst.io._{self.module}")

    def read(self, data: bytes, path: Path, size: int, sheet: str | int | None = None) -> LogTable:
        """Read a whole file, or one sheet of it."""
        fill, collector = self.reader(path.name).fill, Collector(path.name, sheet=sheet)
        guard(path.name, self.title, size, lambda: fill(collector, data, path))
        return collector.table()


def _is_hdf5(head: bytes, ending: str) -> bool:
    return (
        head.startswith(HDF5) or head[512:520] == HDF5
    )  # MATLAB writes 512 bytes of its own before


def _is_sheet(head: bytes, ending: str) -> bool:
    packed = head.startswith(b"PK\x03\x04")
    inside = b"[Content_Types].xml" in head[:200] or b"mimetypeapplication/vnd.oasis" in head[:200]
    return (packed and (inside or ending in SHEETS)) or head.startswith(b"\xd0\xcf\x11\xe0")


def _is_mat(head: bytes, ending: str) -> bool:
    return head.startswith(b"MATLAB 5.0") or (ending == ".mat" and b"\0" in head[:20])


ROSBAGS = ("rosbags.highlevel", "rosbags.typesys")
WITHOUT_HDF5 = (
    "save a MAT file by save('log.mat', '-v7') in MATLAB, anything else as CSV"  # 7.3 is HDF5
)
SHEETS = (".xlsx", ".xlsm", ".xlsb", ".xls", ".ods")
FORMATS = (
    Format("a spreadsheet", SHEETS, _is_sheet, "spreadsheet", ("python_calamine",), "excel"),
    Format("TDMS", (".tdms",), (b"TDSm",), "tdms", ("nptdms",), "tdms"),
    Format("a ROS bag", (".bag",), (b"#ROSBAG V2.0",), "ros", ROSBAGS, "ros", parts="RosParts"),
    Format(
        "a ROS bag", (".db3",), (b"SQLite format 3\0",), "ros", ROSBAGS, "ros", parts="RosParts"
    ),
    Format(
        "an MCAP file", (".mcap",), (b"\x89MCAP0\r\n",), "ros", ROSBAGS, "ros", parts="RosParts"
    ),
    Format(
        "a NumPy archive",
        (".npz",),
        (b"PK\x03\x04", b"PK\x05\x06"),
        "numpy_files",
        parts="NumpyParts",
    ),
    Format("a NumPy array", (".npy",), (b"\x93NUMPY",), "numpy_files", parts="NumpyParts"),
    Format(
        "HDF5",
        (".h5", ".hdf5"),
        _is_hdf5,
        "hdf5",
        ("h5py",),
        "hdf5",
        instead=WITHOUT_HDF5,
        parts="Hdf5Parts",
    ),
    Format("netCDF", (".nc",), (b"CDF\x01", b"CDF\x02"), "netcdf", ("scipy.io",), "netcdf"),
    Format(
        "MDF",
        (".mf4", ".mdf"),
        (b"MDF     ", b"UnFinMF "),
        "mdf",
        ("asammdf",),
        "mdf",
        parts="MdfParts",
    ),
    Format(
        "Parquet",
        (".parquet",),
        (b"PAR1",),
        "parquet",
        ("polars",),
        "parquet",
        parts="ParquetParts",
    ),
    Format(
        "Feather",
        (".feather",),
        (b"ARROW1",),
        "parquet",
        ("polars",),
        "parquet",
        parts="ParquetParts",
    ),
    Format(
        "a MAT file", (), _is_mat, "matlab"
    ),  # without an ending: MATLAB saves text as .mat as well
)


def format_of(head: bytes, path: Path) -> Format | None:
    """Format of a file that begins like this; None if it is text. An ending that promises another is refused."""
    ending = path.suffix.lower()
    for row in FORMATS:
        if row.knows(head, ending):
            return row
    _refuse_packed(head, path)
    if b'"format": "dehyst-' in head:
        raise LogError(
            f"'{path.name}' is a model that dehyst saved, not a log. Name the log instead; where a command takes both, "
            f"the model comes first.",
            path=str(path),
        )
    promised = next((row for row in FORMATS if ending in row.endings), None)
    if promised:
        raise LogError(
            f"'{path.name}' ends in {ending}, but its first bytes ({head[:8].hex(' ')}) are not those of "
            f"{promised.title}: it is damaged, or has the wrong ending. Copy or export it again.",
            path=str(path),
        )
    return None


def _refuse_packed(head: bytes, path: Path) -> None:
    """Refuse a compressed file unless it is a text log packed with gzip; say what it is and what to type."""
    name = quoted(path.name)
    for mark, program in PACKERS.items():
        if re.match(mark, head):
            raise LogError(
                f"'{path.name}' is packed with {program}; of packed logs only text with gzip is read. Unpack it first: "
                f"{program} -dk {name}",
                path=str(path),
            )
    if not head.startswith(GZIP):
        return
    try:
        inner = zlib.decompressobj(wbits=31).decompress(head, HEAD_BYTES)
    except zlib.error:
        return  # it is damaged, and its reader says how
    content, cure = "", f"Unpack it first: gzip -dk {name}"
    ending = Path(path.stem).suffix.lower()
    for row in FORMATS:
        if row.knows(inner, ending):
            content = row.title
            break
    if inner[TAR_MARK : TAR_MARK + 5] == b"ustar":
        content, cure = "an archive of files", f"Unpack it first: tar -xzf {name}"
    elif inner.startswith(GZIP):
        content = "a file that was packed before"
    elif b'"format": "dehyst-' in inner:
        content, cure = "a model that dehyst saved", "Name the log instead."
    if content:
        raise LogError(
            f"'{path.name}' is packed with gzip and holds {content}; of packed logs only text is read. {cure}",
            path=str(path),
        )


def read_table(path: PathLike | Any, sheet: str | int | None = None) -> LogTable:
    """Read a log of any known format, chosen by the file's ending and first bytes; or a data frame.

    Of a workbook a `sheet` may be named, by its name or by its number from 1.
    """
    if is_frame(path):
        _refuse_sheet("a data frame", sheet)
        return table_of_frame(path)
    source = path_of(path)
    with readable(source):
        if source.is_dir():
            _refuse_sheet(f"'{source.name}'", sheet)
            return _read_folder(source)
        size = require_file(source)
        if size > SIZE_LIMIT:
            raise LogError(
                f"'{source.name}' has {size / 2**20:.0f} MB, more than the {SIZE_LIMIT >> 20} MB that are read at "
                f"once: it would not fit into memory. Split it into runs, or save input, output and time as NPZ, "
                f"Parquet or HDF5, which are read in parts.",
                size=size,
            )
        data = source.read_bytes()
    with ThreadPoolExecutor(
        1
    ) as thread:  # hashing takes as long as parsing, and both let go of the interpreter
        beside = thread.submit(hashlib.sha256, data) if len(data) >= THREAD_BYTES else None
        row = format_of(data[:HEAD_BYTES], source)
        if row is None or row.module != "spreadsheet":
            _refuse_sheet(f"'{source.name}'", sheet)
        table = (
            row.read(data, source, len(data), sheet) if row else read_delimited(data, source.name)
        )
        digest = beside.result() if beside else hashlib.sha256(data)
    return replace(table, sha256=digest.hexdigest())


def _refuse_sheet(log: str, sheet: str | int | None) -> None:
    """Refuse a sheet where there are none."""
    if sheet is not None:
        raise LogError(
            f"{log} is no workbook, so it has no sheet '{sheet}'. Leave out --sheet (in Python sheet=), or name the "
            f"workbook.",
            sheet=sheet,
        )


def open_source(path: PathLike) -> Source:
    """Open a log that is to be read in parts; errors are those of `read_table`.

    Raises
    ------
    NotInPartsError
        If its format is read at once only.
    """
    source = path_of(path)
    with readable(source):
        require_file(source)
        with source.open("rb") as stream:
            row = format_of(stream.read(HEAD_BYTES), source)
        if row and not row.parts:
            raise NotInPartsError(
                f"'{source.name}' is {row.title}, which is read at once only. Save input, output and time as CSV, NPZ, "
                f"Parquet or HDF5.",
                file=source.name,
            )
        if row is None:
            return TextParts(source, "text")
        parts: type[Source] = getattr(row.reader(source.name), row.parts)
        return parts(source, row.title)


def path_of(path: PathLike) -> Path:
    """Path of a log, whatever was given for it."""
    if not isinstance(path, str | os.PathLike):
        raise LogError(
            f"the log is given as {path!r:.60}, which is no path. Give the file's name, for example 'log.csv'; of "
            f"arrays or a table in memory, make a recording: dehyst.Recording(input=u, output=y, time=t).",
            path=path,
        )
    return Path(path)


def require_file(source: Path) -> int:
    """Bytes of a file that can be read more than once."""
    size = source.stat().st_size
    if not source.is_file():
        raise LogError(
            f"'{source}' is not a file that can be read twice; save it to disk first.",
            path=str(source),
        )
    if size == 0:
        raise LogError(
            f"'{source.name}' is empty. Check that the logger was started.", path=str(source)
        )
    return size


@contextmanager
def readable(source: Path) -> Iterator[None]:
    """Turn what the system says about a path into a LogError."""
    try:
        yield
    except OSError as fault:
        raise LogError(
            f"cannot read '{source}': {fault.strerror or fault}. Check the path and the permissions.",
            path=str(source),
        ) from None
    except ValueError as fault:  # a NUL byte in the path
        raise LogError(
            f"cannot read {str(source)!r}: {fault}. Check the path.", path=str(source)
        ) from None


def _read_folder(source: Path) -> LogTable:
    """A rosbag2 folder is one log; any other folder is not."""
    if not (source / "metadata.yaml").is_file():
        raise LogError(
            f"'{source}' is a folder, not a log. Name a file inside it (a rosbag2 folder would hold metadata.yaml).",
            path=str(source),
        )
    digest = hashlib.sha256()
    for part in sorted(source.iterdir()):
        if part.suffix in {".db3", ".mcap", ".yaml"} and part.is_file():
            digest.update(part.read_bytes())
    bag = next(row for row in FORMATS if row.module == "ros")
    table = bag.read(b"", source, sum(part.stat().st_size for part in source.iterdir()))
    return replace(table, sha256=digest.hexdigest())
