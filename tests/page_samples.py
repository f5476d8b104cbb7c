"""Logs in the dialects of loggers, for the page in a browser and the same numbers from Python."""

from __future__ import annotations

import gzip
import os

import numpy as np

from generated_logs import generated

DIALECTS = (
    # delimiter, decimal sign, header, unit of time, comment above, gzip
    (",", ".", "time_s,pressure_bar,angle_deg", 1.0, "", False),
    (";", ",", "Zeit [s];Druck [bar];Winkel [deg]", 1.0, "", False),
    ("\t", ".", "t_ms\tvoltage_V\tdisplacement_um", 1e3, "", True),
    (",", ".", '"time, s","pressure (kPa)","position (mm)"', 1.0, "", False),
    (";", ".", "time;u;y\ns;V;mm", 1.0, "", False),
    (" ", ".", "# t u y", 1.0, "# rig 7, test of Monday\n", False),
    (",", ".", "Time [s],Pressure [bar],Angle [rad],note", 1.0, "", False),
    ("|", ".", "time_s|current_A|force_N", 1.0, "", True),
    (",", ".", "", 1.0, "", False),
    (";", ",", "time_s;pressure_cmd_bar;pressure_bar;angle_deg", 1.0, "% saved by a logger\r\n", False),
)


def dialect_log(seed: int) -> bytes:
    """A log of the seed's mechanism in the seed's dialect, sometimes with holes, repeats or an outlier."""
    x, y, t = generated(seed).parts[0]
    rng = np.random.default_rng(seed)
    delimiter, decimal, header, unit, above, packed = DIALECTS[seed % len(DIALECTS)]
    rows = [[f"{v:.9g}" for v in row] for row in zip(t * unit, x, y, strict=True)]
    if header.count(delimiter) == 3:
        extra = ["ok"] * len(rows) if "note" in header else [f"{v:.3f}" for v in np.round(x, 1)]
        rows = [[*row, e] if "note" in header else [row[0], e, *row[1:]] for row, e in zip(rows, extra, strict=True)]
    if seed % 7 == 3:
        for k in rng.integers(20, len(rows), 3):
            rows[k][-1 if "note" not in header else -2] = "nan"
    if seed % 11 == 5:
        rows[len(rows) // 3][2] = "1e6"
    lines = [delimiter.join(cell.replace(".", decimal) for cell in row) for row in rows]
    end = "\r\n" if seed % 4 == 1 else "\n"
    text = above + (header.replace("\n", end) + end if header else "") + end.join(lines) + end
    return gzip.compress(text.encode(), mtime=0) if packed else text.encode()


def big_log(rows: int) -> bytes:
    """Many rows of plays with noise."""
    rng = np.random.default_rng(1)
    t = np.arange(rows) / 200
    x = np.sin(0.7 * t) * (0.4 + 0.6 * np.abs(np.cos(0.01 * t)))
    y = x + 0.3 * np.gradient(x, t) + 0.01 * rng.normal(size=rows)
    table = np.column_stack([t, 3 + x, y])
    return ("time_s,pressure_bar,angle_deg\n" + "\n".join(",".join(f"{v:.5f}" for v in row) for row in table)).encode()


HOSTILE = {
    "one-column.csv": b"value\n" + b"\n".join(b"%d" % (k % 17) for k in range(400)),
    "nothing-but-nan.csv": b"time_s,u_V,y_mm\n" + b"\n".join(b"%d,nan,nan" % k for k in range(400)),
    "binary.csv": bytes(np.random.default_rng(3).integers(0, 256, 200_000, dtype=np.uint8)),
    "empty.csv": b"",
    "still.csv": b"time_s,u_V,y_mm\n" + b"\n".join(b"%d,1,2" % k for k in range(400)),
    "broken.csv.gz": gzip.compress(b"time_s,u_V,y_mm\n" + b"1,2,3\n" * 9999)[:200],
    "words.txt": b"This is no table. " * 400,
    "prices.csv": b"a,b\n" + b"\n".join(b"'=cmd|x'!A1,%d" % k for k in range(99)),
}


def cores() -> float:
    """How much longer than on a quiet machine something may take here."""
    return max(1.0, 1.5 * os.getloadavg()[0] / (os.cpu_count() or 1))
