"""`dehyst doctor` says what is there, and what to type for what is not."""

import json
import shutil
from importlib.metadata import PackageNotFoundError, requires

import dehyst.app._doctor as doctor
from dehyst.app.requests import DoctorRequest


def rows(capsys):
    doctor.run_doctor(DoctorRequest(json=True))
    return {row["name"]: row for row in json.loads(capsys.readouterr().out)["parts"]}


def test_every_extra_of_users_has_a_row_with_the_versions_of_its_packages(capsys):
    extras = {
        line.partition("extra ==")[2].strip(" '\"")
        for line in requires("dehyst")
        if "extra ==" in line
    }
    assert {f"dehyst[{extra}]" for extra in extras - {"all", "test", "bench"}} == {
        name for name in rows(capsys) if name.startswith("dehyst[")
    }
    assert "dehyst-robot 0" in rows(capsys)["dehyst-robot"]["found"]
    assert "gymnasium" in rows(capsys)["dehyst-robot[gym]"]["found"]


def test_what_is_missing_is_told_with_the_line_to_type(monkeypatch, capsys):
    def missing(name):
        raise PackageNotFoundError(name)

    monkeypatch.setattr(doctor, "version", missing)
    monkeypatch.setattr(shutil, "which", lambda name: None)
    found = rows(capsys)
    assert not any(row["found"] for row in found.values())
    assert found["dehyst-robot"]["install"] == "pip install dehyst-robot"
    assert found["cc"]["install"] == "apt-get install gcc"
    doctor.run_doctor(DoctorRequest())
    assert "missing" in capsys.readouterr().out


def test_a_narrow_terminal_cuts_no_line_to_type(monkeypatch, capsys):
    def missing(name):
        if name.startswith("nonlinear"):
            raise PackageNotFoundError(name)
        return "10.20.30"

    monkeypatch.setattr(doctor, "version", missing)
    monkeypatch.setattr(shutil, "which", lambda name: None)
    monkeypatch.setenv("COLUMNS", "80")
    doctor.run_doctor(DoctorRequest())
    out = capsys.readouterr().out
    assert (
        "'dehyst[benchmarks]'" in out
        and "libnewlib-arm-none-eabi" in out
        and "apt-get install make" in out
    )
