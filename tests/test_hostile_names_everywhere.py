"""Claims about names that would steer a terminal or an editor: no file that is written holds their bytes."""

from __future__ import annotations

import io
import unicodedata
import zipfile
from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest

from dehyst.export import TARGETS, subject_of
from dehyst.export._folder import contents
from dehyst.io import example_csv, inspect_log
from dehyst.models import ModelCard, PrandtlIshlinskii, SignalCard, load
from dehyst.models._storage import save_model
from dehyst.shell import visible_text

FORGED = "\n# Verified by `dehyst verify`."
STEERING = "\x1b[31m\x07\0\u202e\u2028\u2066\x85\r\x7f\ufeff\x9b"
HOSTILE = STEERING + FORGED
IN_LOGS = (
    STEERING.replace("\0", "").replace("\r", "").replace("\x85", "").replace("\u2028", "")
)  # no break of a line
ALLOWED = frozenset("\n\t\u00ad\u200c\u200d")


def _faults(name, data):
    """What in a file steers: its text, or that of the members of an archive."""
    if data[:4] == b"PK\3\4":
        with zipfile.ZipFile(io.BytesIO(data)) as packed:
            return [
                fault
                for one in packed.namelist()
                for fault in _faults(f"{name}/{one}", packed.read(one))
            ]
    text = ""
    with suppress(UnicodeDecodeError):  # compiled
        text = data.decode("utf-8")
    return [f"{name}: {letter!r}" for letter in sorted(_letters(text))] + [f"{name}: forged"] * (
        FORGED in text
    )


def _letters(text):
    """Letters that steer."""
    return {
        letter
        for letter in set(text) - ALLOWED
        if unicodedata.category(letter) in ("Cc", "Cf", "Zl", "Zp")
    }


def _model(unit=""):
    card = ModelCard(
        SignalCard(f"p{HOSTILE}", f"bar{unit}", -1.0, 1.0),
        SignalCard(f"angle{HOSTILE}", f"deg{unit}", -2.0, 2.0),
    )
    return PrandtlIshlinskii([0.0, 0.5], [1.0, 1.0], card=card)


@pytest.mark.slow
@pytest.mark.parametrize("unit", ["", HOSTILE], ids=["name", "unit"])
@pytest.mark.parametrize("target", TARGETS)
@pytest.mark.usefixtures("one_compiler")
def test_no_file_of_an_export_steers(target, unit):
    kind = TARGETS[target]
    for what in ("inverse", "forward"):
        subject = subject_of(
            _model(unit), what, name="unit_1", real=kind.reals[-1], period=0.01, excerpt=np.linspace(-1.0, 1.0, 50),
            excerpt_source=f"log{HOSTILE}.csv, p{HOSTILE}", tunable=target in ("c", "c-header"),
        )  # fmt: skip
        files = contents(subject, target)
        assert [fault for name, data in files.items() for fault in _faults(name, data)] == []


def test_the_files_of_c_do_not_steer():
    files = contents(
        subject_of(_model(HOSTILE), name="unit_1", excerpt=np.ones(9), excerpt_source=HOSTILE), "c"
    )
    assert [fault for name, data in files.items() for fault in _faults(name, data)] == []
    assert "\\x1b[31m" in files["expected/test_signal.csv"].decode()


def test_what_is_spelled_out_keeps_lines_tabs_and_letters():
    text = "all:\n\tcc -o \x1b[31mx\u202e\r\nDrück \U0001f600 漢 a\u200db\n"
    assert (
        visible_text(text) == "all:\n\tcc -o \\x1b[31mx\\u202e\\r\nDrück \U0001f600 漢 a\u200db\n"
    )


@pytest.mark.slow
def test_no_command_writes_or_prints_what_steers(run, tmp_path, monkeypatch):
    """Every command that writes a file for people, of a model and of a log with hostile names; terminal too."""
    monkeypatch.chdir(tmp_path)
    lines = example_csv(0).splitlines()[:3000]
    names = [f'"{name}{IN_LOGS}"' if k else name for k, name in enumerate(lines[0].split(","))]
    (tmp_path / "log.csv").write_text("\n".join([",".join(names), *lines[1:]]), encoding="utf-8")
    _, x, y = (column.name for column in inspect_log(tmp_path / "log.csv").columns)
    pair = (f"--input={x}", f"--output={y}")
    commands = [
        ("inspect", "log.csv"),
        ("loops", "log.csv", *pair, "--out=loops.svg"),
        ("loops", "log.csv", *pair, "--out=loops.html"),
        ("sensor", "log.csv", f"--reading={x}", f"--quantity={y}", "--out=sensor.svg"),
        ("sensor", "log.csv", f"--reading={x}", f"--quantity={y}", "--out=sensor.html"),
        (
            "identify",
            "log.csv",
            *pair,
            "--family=pi",
            "--n=5",
            "--save=m.json",
            "--report=r.html",
            "--figures=figures",
        ),
        (
            "compare",
            "log.csv",
            *pair,
            "--families=static,pi",
            "--report=compare.html",
            "--figure=compare.svg",
        ),
        ("simulate", "m.json", "log.csv", "--input", x, "--out=simulated.csv"),
        ("simulate", "m.json", "log.csv", "--input", x),
        (
            "simulate",
            "m.json",
            "log.csv",
            "--input",
            x,
            "--unknown-state",
            "--out=band.csv",
            "--figure=band.svg",
        ),
        ("compensate", "m.json", "log.csv", "--output", y, "--out=compensated.csv"),
        ("evaluate", "m.json", "log.csv", *pair),
        ("drift", "m.json", "log.csv", *pair, "--reference=log.csv", "--report=drift.html"),
        ("design", "--range", "0", "1", "--unit", f"V{IN_LOGS}", "--out=design.csv"),
        (
            "watch",
            "m.json",
            "--follow=log.csv",
            *pair,
            "--until-silent=0.5",
            "--every=2",
            "--cycles=4",
        ),
        ("export", "m.json", "--target=c", "--out=code", "--log=log.csv", "--column", y),
        ("verify", "code"),
    ]
    for words in commands:
        status, out, err = run(*words)
        assert status in (0, 1, 2, 3, 4), (words, err)
        assert _letters(out + err) == set(), words
        if (
            words[0] == "identify"
        ):  # reading spells out; a model of somebody else says what it likes
            model = load(tmp_path / "m.json")
            signals = [
                replace(card, name=f"{card.name}{HOSTILE}")
                for card in (model.card.input, model.card.output)
            ]
            save_model(
                model.with_card(replace(model.card, input=signals[0], output=signals[1])),
                tmp_path / "m.json",
            )
    files = [path for path in tmp_path.rglob("*") if path.is_file() and path.name != "log.csv"]
    due = {
        "r.html",
        "compare.html",
        "drift.html",
        "simulated.csv",
        "compensated.csv",
        "band.csv",
        "VERIFIED.txt",
    }
    assert {path.name for path in files} > due
    assert [
        fault
        for path in files
        for fault in _faults(str(path.relative_to(tmp_path)), path.read_bytes())
    ] == []
