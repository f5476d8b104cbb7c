"""Reads a text log as lines: compression, encoding, line ends."""

from __future__ import annotations

import io
import re
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import BinaryIO

import dehyst._native as _native
from dehyst.errors import LogError

MEGABYTE = 1 << 20
# A log of held values packs 50:1 at most; a file of zeros 1000:1. Beyond these limits it is a bomb, not a log.
EXPANSION_LIMIT = 100
EXPANSION_FREE = 8 * MEGABYTE
SIZE_LIMIT = 1024 * MEGABYTE
BLOCK = MEGABYTE  # bytes of text at a time
PACKED = BLOCK // 4  # bytes of gzip at a time
_CONTROL = re.compile("[\x00-\x08\x0e-\x1f\x7f]")  # characters that no text log has
_BEYOND_ASCII = re.compile("[^\x00-\x7f\ufffd]")
GZIP = b"\x1f\x8b"


def expand(data: bytes, name: str) -> bytes:
    """Undo gzip, up to 100 times the size of the file (and 8 MB), and 1 GB."""
    if not data.startswith(GZIP):
        return data
    limit = min(SIZE_LIMIT, max(EXPANSION_FREE, EXPANSION_LIMIT * len(data)))
    parts: list[bytes] = []
    size = 0
    for block in unpacked(io.BytesIO(data), name):
        parts.append(block)
        size += len(block)
        if size > limit:
            raise LogError(
                f"log '{name}' expands from {len(data)} bytes to more than {limit // MEGABYTE} MB; no log of a test "
                f"rig packs that well, so it is not read. If it is one, unpack it first: gzip -d {name}",
                file=name,
                limit=limit,
            )
    return b"".join(parts)


def unpacked(stream: BinaryIO, name: str) -> Iterator[bytes]:
    """Blocks of the text of a gzip file, member by member."""
    data, size = stream.read(PACKED), 0
    while data:
        if len(data) < len(GZIP):
            data += stream.read(PACKED)
        if not data.startswith(GZIP):
            left = len(data) + len(stream.read())
            raise LogError(
                f"log '{name}' is damaged: {left} bytes follow its gzip data that do not belong to it. "
                f"Copy the file again.",
                file=name,
            )
        member = zlib.decompressobj(wbits=31)
        while not member.eof:
            try:
                block = member.decompress(data, BLOCK)
            except zlib.error as fault:
                raise LogError(
                    f"log '{name}' is damaged: its gzip data cannot be expanded ({fault}). Copy the file again, or "
                    f"save what can be saved with: gzip -dc {name} > log.csv",
                    file=name,
                ) from None
            data = member.unconsumed_tail or stream.read(PACKED)
            size += len(block)
            if block:
                yield block
            elif not data and not member.eof:
                raise LogError(
                    f"log '{name}' is damaged: its gzip data ends early, after {size} bytes of text. Copy the file "
                    f"again, or save what is there with: gzip -dc {name} > log.csv",
                    file=name,
                )
        data = (member.unused_data + data).lstrip(b"\0")
        while not data and (more := stream.read(PACKED)):
            data = more.lstrip(b"\0")


def _utf16(data: bytes) -> str | None:
    """Encoding of UTF-16 text, with or without byte-order mark: every other byte of plain text is NUL."""
    # A byte-order mark tells at once.
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        return "utf-16"
    head = data[:4096]
    half = len(head) // 2
    if half < 8:
        return None
    if head[1::2].count(0) > 0.8 * half and head[0::2].count(0) < 0.1 * half:
        return "utf-16-le"
    if head[0::2].count(0) > 0.8 * half and head[1::2].count(0) < 0.1 * half:
        return "utf-16-be"
    return None


def decode(data: bytes, name: str) -> str:
    """Decode a text log: UTF-8 or UTF-16 with or without byte-order mark, else Latin-1."""
    wide = _utf16(data)
    if wide:
        text = data[: len(data) // 2 * 2].decode(wide, errors="replace").lstrip("\ufeff")
    else:
        body = data
        while body.startswith(b"\xef\xbb\xbf"):  # one a program that joined or rewrote the file
            body = body[3:]
        text = _utf8_or_latin1(body)
    head = text[:65536]
    control = len(_CONTROL.findall(head))
    if control > max(2, 0.02 * len(head)):
        raise LogError(
            f"log '{name}' is not text: {control} of its first {len(head)} characters are control characters. "
            f"Known formats are .csv .txt .tsv .dat (also .gz), .mat, .h5, .npz, .npy, .bag, .db3, .mcap, .mf4, .mdf, "
            f".parquet and .feather; give the file the ending of its format.",
            file=name,
        )
    return text


def _utf8_or_latin1(body: bytes) -> str:
    try:
        return body.decode("utf-8")
    except UnicodeDecodeError:
        # A few broken bytes among valid UTF-8 stay visible as U+FFFD; Latin-1 would garble every unit sign.
        replaced = body.decode("utf-8", errors="replace")
        if replaced.count("\ufffd") <= 3 and _BEYOND_ASCII.search(replaced[:4096]):
            return replaced
        return body.decode("latin-1")


def lines_of(text: str) -> list[str]:
    """Split text into lines at any of the three line ends."""
    if "\r" in text:
        text = text.replace("\r\n", "\n").replace("\r", "\n")
    return text.split("\n")


_NUMBER_CELL = re.compile(
    r"(?:^|[,;|\t])\s*[+-]?[\d.]*\d(?:[eE][+-]?\d+)?\s*(?:[,;|\t]|$)", re.ASCII
)
# Lines of one header: a quote that is not closed by then is a mark of inches, or damage.
MOST_JOINED = 20


def join_quoted(lines: list[str]) -> list[str]:
    """Lines of which none ends within the quotes of a name; empty lines after it keep the numbers of the others true.

    A line that holds a cell with a number is never taken for the rest of a name.

    Examples
    --------
    >>> join_quoted(['t,"p', '[bar]"', "0,1"])
    ['t,"p\\n[bar]"', '', '0,1']
    """
    if '"' not in "".join(lines):
        return lines
    joined = list(lines)
    for k, line in enumerate(lines):
        if '"' not in line or joined[k] != line or not _opens(line):
            continue
        for end in range(k + 1, min(k + MOST_JOINED, len(lines))):
            if _NUMBER_CELL.search(lines[end]):
                break
            if lines[end].count('"') % 2:
                joined[k : end + 1] = ["\n".join(lines[k : end + 1])] + [""] * (end - k)
                break
    return joined


def _opens(line: str) -> bool:
    """Whether a quote at the begin of a cell is not closed in its line; one behind a number is a mark of inches."""
    if line.count('"') % 2 == 0:
        return False
    before, quote, _ = line.replace('""', "").rpartition('"')
    return bool(quote) and before[-1:] in ("", *",;|\t ")


HEAD_LINES = 2000  # more than the layout of a log is found by
HEAD_BYTES = 1 << 18  # at least as many characters as tell text from other bytes


@dataclass(frozen=True, slots=True)
class Text:
    """A text log before its cells are looked at."""

    data: bytes  # UTF-8, without byte-order mark
    lines: list[str]  # the first ones; all if `complete`
    complete: bool

    def offset(self, lines: int) -> int:
        """Return the length of the first `lines` lines. [bytes]"""
        return _native.text_offset(self.data, lines)

    def all_lines(self) -> list[str]:
        """Return every line of the log."""
        if self.complete:
            return self.lines
        return join_quoted(lines_of(self.data.decode()))


def open_text(data: bytes, name: str) -> Text:
    """Decode the first lines of a log, and of the others as much as it takes to have UTF-8."""
    data = _without_padding(data)
    cut = len(data)
    if not _utf16(data):
        cut = _head_size(data)
    # What is ASCII behind the first lines is UTF-8 as it stands.
    if cut < len(data) and (data.isascii() or data[cut:].isascii()):
        head = decode(data[:cut], name)
        plain = head.encode()
        if plain != data[:cut]:
            data = plain + data[cut:]
        return Text(data, join_quoted(lines_of(head)[:-1]), False)
    text = decode(data, name)
    plain = text.encode()
    cut = _head_size(plain)
    if cut < len(plain):
        return Text(plain, join_quoted(lines_of(plain[:cut].decode())[:-1]), False)
    return Text(plain, join_quoted(lines_of(text)), True)


def _without_padding(data: bytes) -> bytes:
    """Text without the NULs by which a logger fills its lines, or its file, to a fixed length."""
    if 0 not in data or _utf16(data):
        return data
    text = re.sub("\0+(?=[\r\n]|\\Z)", "", data.decode("latin-1"))
    if "\0" in text:
        return data
    return text.encode("latin-1")


def _head_size(data: bytes) -> int:
    """Bytes of the first lines, all if there are not many more."""
    return max(_native.text_offset(data, HEAD_LINES), _native.text_offset(data, 1, HEAD_BYTES))
