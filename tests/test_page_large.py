"""Claims about the page and logs as long as a day: no list of the log's length becomes arguments of a call.

The script of the page's worker runs in Node, whose stack is that of a browser; what it reads is compared with Python.
"""

from __future__ import annotations

import base64
import gzip
import json
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from dehyst import identify, read_log
from dehyst.io import inspect_log

PAGE = Path(__file__).parents[1] / "src" / "dehyst" / "page" / "dehyst.html"
NODE = shutil.which("node")
ROWS = 150_000
HARNESS = """
const fs = require("fs");
const [, , wasm, script, log, asked] = process.argv;
const answers = {};
globalThis.onmessage = null;
globalThis.postMessage = ({ id, answer, fault }) => { answers[id] = fault ? { fault } : answer; };
const scalar = (key, v) => (ArrayBuffer.isView(v) ? { length: v.length, last: v[v.length - 1] } : v);
(async () => {
  (0, eval)(fs.readFileSync(script, "utf-8"));
  const module = await WebAssembly.compile(fs.readFileSync(wasm));
  const data = fs.readFileSync(log), name = require("path").basename(log);
  const file = { name, size: data.length, arrayBuffer: async () => Uint8Array.from(data).buffer };
  await onmessage({ data: { kind: "open", id: "open", module } });
  await onmessage({ data: { kind: "read", id: "read", file } });
  const [input, output] = asked.split("|");
  const fit = { kind: "identify", id: "identify", input, output, run: null, reading: {}, fitting: {} };
  if (output) await onmessage({ data: fit });
  process.stdout.write(JSON.stringify(answers, scalar), () => process.exit(0));
})();
"""

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(NODE is None, reason="no Node found: apt-get install nodejs"),
    pytest.mark.skipif(not PAGE.exists(), reason="the page is not built: make page"),
]


@pytest.fixture(scope="module")
def ask(tmp_path_factory):
    """Run the worker of the page on a log: what it answers."""
    folder = tmp_path_factory.mktemp("worker")
    text = PAGE.read_text(encoding="utf-8")
    for name in ("wasm", "worker"):
        packed = re.search(rf'<script type="application/octet-stream" id="{name}">([^<]*)</script>', text)[1]
        (folder / name).write_bytes(gzip.decompress(base64.b85decode(packed.replace(",", "<"))))
    (folder / "harness.js").write_text(HARNESS)

    def asked(log, input="", output=""):
        words = [NODE, folder / "harness.js", folder / "wasm", folder / "worker", log, f"{input}|{output}"]
        return json.loads(subprocess.run(words, capture_output=True, check=True, timeout=500).stdout)

    return asked


def _rows(rows):
    t = np.arange(rows) / 200
    x = np.sin(0.7 * t) * (0.4 + 0.6 * np.abs(np.cos(0.01 * t)))
    y = x + 0.3 * np.gradient(x, t)
    return t, 3 + x, y


LAYOUTS = {  # header, format of a row, decimal comma
    "semicolons, decimal comma": ("time_s;pressure_bar;angle_deg", "{:.3f};{:.5f};{:.5f}", True),
    "tabs, decimal comma": ("time_s\tpressure_bar\tangle_deg", "{:.3f}\t{:.5f}\t{:.5f}", True),
    "quoted, decimal comma": ("time_s,pressure_bar,angle_deg", '"{:.3f}","{:.5f}","{:.5f}"', True),
    "a column of words": ("time_s;pressure_bar;angle_deg;state", "{:.3f};{:.5f};{:.5f};on", True),
    "stamps": ("time;pressure_bar;angle_deg", "2024-03-05 {:s};{:.5f};{:.5f}", True),
    "decimal point": ("time_s,pressure_bar,angle_deg", "{:.3f},{:.5f},{:.5f}", False),
    "bars": ("time_s|pressure_bar|angle_deg", "{:.3f}|{:.5f}|{:.5f}", True),
    "no header": ("", "{:.3f};{:.5f};{:.5f}", True),
    "empty cells": ("time_s;pressure_bar;angle_deg;torque_Nm", "{:.3f};{:.5f};{:.5f};", True),
}


def _log(path, layout, rows):
    header, row, comma = LAYOUTS[layout]
    lines = [header] if header else []
    for t, x, y in zip(*_rows(rows), strict=True):
        clock = f"{int(t // 3600):02d}:{int(t // 60 % 60):02d}:{t % 60:06.3f}" if "{:s}" in row else t
        line = row.format(clock, x, y)
        lines.append(line.replace(".", ",") if comma else line)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_long_log_of_any_layout_is_read_as_python_reads_it(ask, tmp_path, layout):
    log = _log(tmp_path / "long.csv", layout, ROWS)
    seen = ask(log)["read"]
    summary = inspect_log(log)
    assert "fault" not in seen, seen["fault"]
    assert seen["rows"] == summary.rows == ROWS
    assert [one["name"] for one in seen["columns"]] == [one.name for one in summary.columns]
    for one, other in zip(seen["columns"], summary.columns, strict=True):
        assert one["minimum"] == other.minimum or np.isnan(other.minimum)
        assert one["maximum"] == other.maximum or np.isnan(other.maximum)


def test_a_long_log_with_holes_is_identified_as_by_python(ask, tmp_path):
    """Samples left out are a list as long as they are many."""
    log = _log(tmp_path / "holes.csv", "semicolons, decimal comma", ROWS)
    header, *lines = log.read_text().splitlines()
    for k in [*range(300, ROWS, 7), *range(303, ROWS, 7)]:
        cells = lines[k].split(";")
        lines[k] = f"{cells[0]};{cells[1]};nan"
    log.write_text("\n".join([header, *lines]))
    seen = ask(log, "pressure_bar", "angle_deg")["identify"]
    fit = identify(read_log(log, "pressure_bar", "angle_deg"), "pi")
    assert "fault" not in seen, seen["fault"]
    assert seen["scores"]["test"]["rmse"] == pytest.approx(fit.test.rmse, rel=1e-6)
    assert seen["x"]["length"] == len(fit.predictions[0])
