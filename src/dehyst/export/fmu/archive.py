"""The .fmu file: a zip archive whose bytes depend on its content only."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping

_DATE = (1980, 1, 1, 0, 0, 0)


def archive(files: Mapping[str, bytes]) -> bytes:
    """Return the zip archive of files, path -> content; no date and no owner is in it.

    Examples
    --------
    >>> archive({"a": b"x"}) == archive({"a": b"x"})
    True
    """
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as packed:
        for path in sorted(files, key=lambda p: (p != "modelDescription.xml", p)):
            info = zipfile.ZipInfo(path, _DATE)
            info.compress_type = zipfile.ZIP_DEFLATED
            info.external_attr = (0o755 if path.startswith("binaries/") else 0o644) << 16
            packed.writestr(info, files[path])
    return out.getvalue()
