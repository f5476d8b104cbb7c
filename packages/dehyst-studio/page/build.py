"""Builds dehyst.html, which fits a log in a browser: C to WebAssembly by zig, TypeScript by esbuild, one file.

Run from anywhere: `python page/build.py [OUT.html]`. Without OUT it writes the file that the package ships.
The same sources and versions give the same bytes.
"""

from __future__ import annotations

import base64
import gzip
import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parents[2]
KERNEL = ROOT / "packages" / "dehyst"
SHIPPED = ROOT / "packages" / "dehyst-studio" / "src" / "dehyst_studio" / "html" / "dehyst.html"
LIMIT = 250_000


def wasm(out: Path) -> bytes:
    """Compile core/, engine/ and the glue."""
    zig = Path(find_spec("ziglang").origin).with_name("zig")  # type: ignore[union-attr,arg-type]
    sources = [
        HERE / "glue.c",
        *sorted((KERNEL / "core").glob("*.c")),
        *sorted((KERNEL / "engine").glob("*.c")),
    ]
    sources += sorted((KERNEL / "engine" / "lanes").glob("*.c"))
    names = [os.path.relpath(path, ROOT) for path in sources]
    subprocess.run(
        [
            zig, "cc", "--target=wasm32-wasi", "-mexec-model=reactor", "-std=c11", "-Os", "-ffp-contract=off",
            "-msimd128", "-fno-sanitize=undefined", "-DLANES_LEVEL=0",
            "-Ipackages/dehyst/core", "-Ipackages/dehyst/engine",
            "-Wall", "-Wextra", "-Wconversion", "-Wpedantic", "-Werror",
            "-Wl,--gc-sections,--strip-all,-z,stack-size=1048576", *names, "-o", out,
        ],
        check=True,
        cwd=ROOT,
    )  # fmt: skip
    return out.read_bytes()


def bundle(entry: str, out: Path) -> str:
    """Check the types and bundle the TypeScript."""
    if not (HERE / "node_modules" / "esbuild").is_dir():
        subprocess.run([_npm(), "ci", "--silent"], check=True, cwd=HERE)
    tools = HERE / "node_modules" / ".bin"
    subprocess.run([tools / "tsc", "--noEmit", "-p", HERE], check=True)
    subprocess.run(
        [
            tools / "esbuild", f"src/{entry}", "--bundle", "--minify", "--format=iife", "--target=es2022",
            "--charset=utf8", "--legal-comments=inline", "--log-level=warning", f"--outfile={out}",
        ],
        check=True,
        cwd=HERE,
    )  # fmt: skip
    text = out.read_text(encoding="utf-8")
    assert "</script" not in text.lower(), "the script would end its own element"
    return text.strip()


def page() -> str:
    """Return the page."""
    from dehyst.report._theme import FONT_STACK, variables
    from dehyst.version import __version__

    with tempfile.TemporaryDirectory() as folder:
        code = wasm(Path(folder) / "page.wasm")
        start = bundle("start.ts", Path(folder) / "start.js")
        program = bundle("main.ts", Path(folder) / "main.js")
    style = (HERE / "node_modules" / "uplot" / "dist" / "uPlot.min.css").read_text(
        encoding="utf-8"
    ).strip() + "\n"
    style += "".join(
        (HERE / "src" / f"{name}.css").read_text(encoding="utf-8") for name in ("page", "identify")
    )
    parts = {
        "light": variables(dark=False),
        "dark": variables(dark=True),
        "font": FONT_STACK,
    }
    for name, value in parts.items():
        style = style.replace(f"/*{name}*/", value)
    text = (HERE / "src" / "page.html").read_text(encoding="utf-8")
    fields = {
        "version": __version__,
        "begun": _hash(start),
        "allowed": _hash(program),
        "styled": _hash(style),
        "style": style,
        "wasm": _packed(code),
        "program": _packed(program.encode()),
        "start": start,
    }
    for name, value in fields.items():
        text = text.replace("{{ " + name + " }}", value)
    return text


def _packed(data: bytes) -> str:
    """Gzip in base 85, which takes 6 % less room than base 64; a comma for the sign that opens a tag."""
    return base64.b85encode(gzip.compress(data, 9, mtime=0)).decode().replace("<", ",")


def _hash(text: str) -> str:
    return base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()


def _npm() -> str:
    found = shutil.which("npm")
    if found is None:
        sys.exit(
            "page/build.py needs npm, which fetches esbuild, TypeScript and uPlot: apt-get install nodejs npm"
        )
    return found


def main(arguments: list[str]) -> None:
    """Write the page and say how large it is."""
    out = Path(arguments[0]) if arguments else SHIPPED
    text = page().encode()
    if len(text) > LIMIT:
        sys.exit(
            f"the page has {len(text)} bytes, more than {LIMIT}: look at what was added to page/src"
        )
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_bytes(text)
    print(f"{out}: {len(text)} bytes")


if __name__ == "__main__":
    main(sys.argv[1:])
