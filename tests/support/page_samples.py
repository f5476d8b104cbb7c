"""Logs in the dialects of loggers, for the page in a browser and the same numbers from Python."""

from __future__ import annotations

import gzip

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
    (
        ";",
        ",",
        "time_s;pressure_cmd_bar;pressure_bar;angle_deg",
        1.0,
        "% saved by a logger\r\n",
        False,
    ),
)


def dialect_log(seed: int) -> bytes:
    """A log of the seed's mechanism in the seed's dialect, sometimes with holes, repeats or an outlier."""
    x, y, t = generated(seed).parts[0]
    rng = np.random.default_rng(seed)
    delimiter, decimal, header, unit, above, packed = DIALECTS[seed % len(DIALECTS)]
    rows = [[f"{v:.9g}" for v in row] for row in zip(t * unit, x, y, strict=True)]
    names = header.removeprefix("# ").replace(", ", " ")  # what separates no columns
    if names.count(delimiter) == 3:
        extra = ["ok"] * len(rows) if "note" in header else [f"{v:.3f}" for v in np.round(x, 1)]
        rows = [
            [*row, e] if "note" in header else [row[0], e, *row[1:]]
            for row, e in zip(rows, extra, strict=True)
        ]
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
    return (
        "time_s,pressure_bar,angle_deg\n"
        + "\n".join(",".join(f"{v:.5f}" for v in row) for row in table)
    ).encode()


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


def _table(row, header="time_s,pressure_bar,angle_deg", rows=400) -> str:
    return (
        "\n".join([header, *(row(k, np.sin(k / 16), np.sin(k / 16 - 0.3)) for k in range(rows))])
        + "\n"
    )


def _plain(k: int, x: float, y: float) -> str:
    return f"{k / 10:.1f},{x:.4f},{y:.4f}"


# Logs that the page may not guess at: a word of the reason, and the text.
UNCLEAR = {
    "dates.csv": (
        "dates",
        _table(lambda k, x, y: f"2024-05-01 12:00:{k % 60:02d},{x:.4f},{y:.4f}"),
    ),
    "both signs.csv": (
        "decimal comma",
        _table(
            lambda k, x, y: f"{k};{x:.4f};{y:.4f}".replace(".", "," if k % 2 else "."),
            "n;pressure_bar;angle_deg",
        ),
    ),
    "thousands.csv": (
        "thousands",
        _table(
            lambda k, x, y: f"{k};{2 + x:.3f};{3 + y:.3f}".replace(".", ","),
            "n;pressure_bar;angle_deg",
        ),
    ),
    "words.csv": (
        "words",
        _table(lambda k, x, y: f"{k / 10:.1f},{x:.4f},{'high' if k == 90 else f'{y:.4f}'}"),
    ),
    "two runs.csv": (
        "run",
        _table(lambda k, x, y: f"{k // 200},{x:.4f},{y:.4f}", "run,pressure_bar,angle_deg"),
    ),
    "time restarts.csv": ("does not rise", _table(lambda k, x, y: f"{k % 200},{x:.4f},{y:.4f}")),
    "gap.csv": ("gap", _table(lambda k, x, y: f"{k + 50 * (k > 90)},{x:.4f},{y:.4f}")),
    "short row.csv": ("row", _table(lambda k, x, y: _plain(k, x, y) if k != 7 else "0.7,1")),
    "missing.csv": (
        "missing",
        _table(lambda k, x, y: f"{k / 10:.1f},{x:.4f},{y:.4f}" if k != 50 else "5.0,nan,1"),
    ),
    "spike.csv": (
        "outlier",
        _table(lambda k, x, y: f"{k / 10:.1f},{x:.4f},{99 if k == 50 else y:.4f}"),
    ),
    "code.csv": (
        "outlier",
        _table(lambda k, x, y: f"{k / 10:.1f},{x:.4f},{-9999 if 50 < k < 60 else y:.4f}"),
    ),
    "short spike.csv": (
        "outlier",
        _table(lambda k, x, y: f"{k / 10:.1f},{x:.4f},{y + 1.9 * (k == 50):.4f}"),
    ),
    "lost packets.csv": (
        "outlier",
        _table(lambda k, x, y: f"{k / 10:.1f},{x:.4f},{0 if k % 97 == 23 else y:.4f}"),
    ),
    "one turn.csv": (
        "turn",
        _table(lambda k, x, y: f"{k / 10:.1f},{x:.4f},{(360 + 9 * y) % 360:.4f}"),
    ),
    "one column.csv": ("two numbers", _table(lambda k, x, y: f"{x:.4f}", "pressure_bar")),
    "no names.csv": (
        "names",
        _table(lambda k, x, y: f"{k},{1000 * x:.0f},{1000 * y:.0f}", "# a log"),
    ),
    "twice.csv": ("one name", _table(_plain, "angle_deg,pressure_bar,angle_deg")),
}
