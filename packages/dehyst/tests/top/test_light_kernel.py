"""`pip install dehyst` alone is light: what it needs, how large that is, and what works without any extra."""

import subprocess
import sys
import tomllib
from importlib.metadata import distribution
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from places import KERNEL, SOURCES

LARGEST = 220e6  # bytes on the disk of all that `pip install dehyst` brings
HEAVY = ("scipy", "h5py", "mujoco", "polars", "pandas", "sklearn", "control")
WITHOUT = f"""
import sys

class Missing:
    @staticmethod
    def find_spec(name, *_):
        if name.partition(".")[0] in {HEAVY}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

sys.meta_path.insert(0, Missing)
"""


def brought_by(lines):
    """Return the names of all distributions that requirements bring, without extras."""
    names, waiting = set(), list(lines)
    while waiting:
        requirement = Requirement(waiting.pop())
        name = canonicalize_name(requirement.name)
        if name not in names and (
            requirement.marker is None or requirement.marker.evaluate({"extra": ""})
        ):
            names.add(name)
            waiting += distribution(name).requires or ()
    return names


def test_the_kernel_needs_neither_scipy_nor_h5py_and_is_at_most_220_mb_on_the_disk():
    packages = brought_by(
        tomllib.loads((KERNEL / "pyproject.toml").read_text(encoding="utf-8"))["project"][
            "dependencies"
        ]
    )
    assert {"numpy", "matplotlib"} <= packages and not {"scipy", "h5py"} & packages
    files = {Path(file.locate()) for name in packages for file in distribution(name).files or ()}
    files |= set((SOURCES["dehyst"]).rglob("*"))
    assert sum(file.stat().st_size for file in files if file.is_file()) < LARGEST


def without_extras(code, folder):
    """Run code in a Python that has no package of an extra; return what it prints, and what it complains of."""
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT + code], capture_output=True, text=True, cwd=folder
    )
    return done.stdout, done.stderr


def test_the_package_itself_loads_nothing_heavy(tmp_path):
    code = "import dehyst\nprint(sorted({'numpy', 'matplotlib', 'jinja2', 'rich', 'typer'} & set(sys.modules)))"
    assert without_extras(code, tmp_path) == ("[]\n", "")


@pytest.mark.slow
def test_an_identification_loads_nothing_that_draws(tmp_path):
    code = """
import dehyst
from dehyst.io import example_recording
fit = dehyst.identify(example_recording())
print(sorted({'matplotlib', 'jinja2', 'rich', 'typer'} & set(sys.modules)), fit.verdict[:3])
"""
    out, err = without_extras(code, tmp_path)
    assert out.startswith("[] ") and err == ""


COMMANDS = """
from pathlib import Path
from dehyst.cli import main
pair = ["--input", "pressure_difference_bar", "--output", "angle_deg"]
for words in (
    ["example"],
    ["identify", "example.csv", *pair, "--save", "model.json", "--report", "fit.html"],
    ["identify", "example.csv", *pair, "--family", "duhem", "--save", "duhem.json"],
    ["identify", "example.csv", *pair, "--family", "bouc-wen"],
    ["export", "model.json", "--target", "c", "--name", "elbow", "--out", "elbow"],
    ["drift", "model.json", "example.csv", *pair],
):
    sys.argv = ["dehyst", *words]
    try:
        main()
    except SystemExit as left:
        print("status", words[0], left.code)
"""


@pytest.mark.slow
def test_identify_report_export_and_drift_work_without_extras(tmp_path):
    out, err = without_extras(COMMANDS, tmp_path)
    lines = [line for line in out.splitlines() if line.startswith("status ")]
    assert len(lines) == 6 and {line.split()[-1] for line in lines[:5]} == {"0"}, err
    assert lines[5] in {"status drift 0", "status drift 1"} and "Traceback" not in err
    assert (tmp_path / "fit.html").is_file() and (tmp_path / "duhem.json").is_file()


@pytest.mark.parametrize(
    ("name", "head", "cures"),
    [
        ("log.h5", b"\x89HDF\r\n\x1a\n" + bytes(100), ("pip install 'dehyst[hdf5]'", "CSV")),
        ("log.mat", bytes(512) + b"\x89HDF\r\n\x1a\n", ("'dehyst[hdf5]'", "save('log.mat', '-v7')")),
        ("log.nc", b"CDF\x01" + bytes(100), ("pip install 'dehyst[netcdf]'", "CSV")),
    ],
)  # fmt: skip
def test_a_log_of_an_extra_says_what_to_type_and_what_else_cures(tmp_path, name, head, cures):
    (tmp_path / name).write_bytes(head)
    code = f"import dehyst\ntry:\n    dehyst.inspect_log({name!r})\n"
    code += "except dehyst.DehystError as fault:\n    print(fault)"
    out, err = without_extras(code, tmp_path)
    assert all(cure in out for cure in cures) and err == "", out


@pytest.mark.slow
def test_a_command_of_the_laboratory_without_its_packages_says_what_to_type(tmp_path):
    code = "from dehyst.cli import main\nsys.argv = ['dehyst', 'muscle', 'list']\nmain()"
    _, err = without_extras(code, tmp_path)
    assert err.strip() == (
        "this command needs the package scipy, which is not installed. Type: pip install dehyst-robot"
    )
