"""CONTRIBUTING shows how to add families, figures, formats, targets, muscles, sensors, to change a rule; all is run."""

import doctest
import importlib.util
import inspect
import re
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import numpy as np
import pytest

import test_families_conformity as conformity
import test_muscles_models as pulls
from dehyst import Recording, compare, load
from dehyst.export import targets
from dehyst.families import STARTS, choice, example, identify_family, registry, rows, table
from dehyst.io import formats
from dehyst.report import figures, write_report
from dehyst.robot.arm import JointBench, load_robot
from dehyst.robot.muscles import registry as muscles
from export_samples import play_model
from report_samples import fit_by_hand

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
SECTION = PAGE.partition("### A family for comparison")[2].partition("\n#")[0]
ROW = re.search(r"(?ms)^### A row of elements.*?^```text\n(.*?)^```$", PAGE)[1]
FAMILY, LINE, TESTS = re.findall(r"(?ms)^```python\n(.*?)^```$", SECTION)
DRAWING = PAGE.partition("## Add a report figure")[2].partition("\n## ")[0]
FIGURE, LINES, FIGURE_TESTS = re.findall(r"(?ms)^```(?:python|text)\n(.*?)^```$", DRAWING)
READING = PAGE.partition("## Add a log format")[2].partition("\n## ")[0]
FORMAT, FORMAT_ROW, FORMAT_TESTS = re.findall(r"(?ms)^```(?:python|text)\n(.*?)^```$", READING)
EXPORTING = PAGE.partition("## Add a target of")[2].partition("\n## ")[0]
TARGET, TARGET_ROW, TARGET_TESTS = re.findall(r"(?ms)^```(?:python|text)\n(.*?)^```$", EXPORTING)
PULLING = PAGE.partition("## Add a muscle model")[2].partition("\n## ")[0]
MUSCLE, MUSCLE_LINES, MUSCLE_TESTS = re.findall(r"(?ms)^```(?:python|text)\n(.*?)^```$", PULLING)
SENSING = PAGE.partition("## Add a sensor in")[2].partition("\n## ")[0]
SENSOR_ROWS, SENSOR_KEYS, SENSOR_NUMBERS, SENSOR_TESTS = re.findall(r"(?ms)^```(?:python|text)\n(.*?)^```$", SENSING)
RULING = PAGE.partition("## Change the rule of auto")[2].partition("\n## ")[0]
RULE, RULE_TESTS = re.findall(r"(?ms)^```python\n(.*?)^```$", RULING)
OF_RATE = {"test_a_rate_dependent_family_asks_for_time"}
PROMISES = [value for name, value in vars(conformity).items() if name.startswith("test_") and name not in OF_RATE]


@pytest.fixture
def registered(tmp_path, monkeypatch):
    """The file and the line of CONTRIBUTING, as if they were part of the package."""
    ((name, module),) = eval("{" + LINE + "}").items()
    load_shown(module, FAMILY, tmp_path, monkeypatch)
    monkeypatch.setitem(registry.MODULES, name, module)
    return name


def load_shown(module, text, folder, monkeypatch):
    path = folder / f"{module.rpartition('.')[2]}.py"
    path.write_text(text, encoding="utf-8")
    spec = importlib.util.spec_from_file_location(module, path)
    loaded = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, module, loaded)
    spec.loader.exec_module(loaded)


def run_shown(text, folder=None):
    """Run the tests of CONTRIBUTING; return how many there are. `folder` is for those that write files."""
    shown = {}
    exec(compile(text, "CONTRIBUTING.md", "exec", dont_inherit=True), shown)
    tests = [value for name, value in shown.items() if name.startswith("test_")]
    for test in tests:
        test(**dict.fromkeys(inspect.signature(test).parameters, folder))
    return len(tests)


@pytest.fixture
def tabled(monkeypatch):
    """The row of CONTRIBUTING, as if it stood in the table."""
    (row,) = eval(f"({ROW.strip()})", {"_row": table._row})
    monkeypatch.setattr(registry, "ROWS", (*registry.ROWS, row.name))
    monkeypatch.setitem(rows.FAMILIES, row.name, rows.family_of(row))
    return row.name


@pytest.mark.parametrize(
    "promise",
    [value for name, value in vars(conformity).items() if name.startswith("test_")],
    ids=lambda promise: promise.__name__.removeprefix("test_"),
)
def test_the_row_shown_keeps_what_every_family_promises(tabled, promise):
    starts = STARTS if "start" in inspect.signature(promise).parameters else (None,)
    for start in starts:
        promise(tabled, **({} if start is None else {"start": start}))


def test_the_row_shown_is_fitted_inverted_saved_and_loaded(tabled, tmp_path):
    t = 0.01 * np.arange(1500)
    x = np.sin(1.7 * t) * np.linspace(1.0, 0.4, t.size)
    fit = identify_family(Recording(input=x, output=example(tabled).simulate(x, t), time=t), tabled)
    assert fit.family == fit.model.family == tabled and fit.test.rmse_percent < 2.0
    again = load(fit.model.save(tmp_path / "row.json"))
    assert np.max(np.abs(again.inverse().simulate(fit.model.simulate(x, t), t) - x)) < 1e-9


def test_the_tests_shown_pass(registered):
    assert run_shown(TESTS) == 2


@pytest.mark.parametrize("promise", PROMISES, ids=lambda promise: promise.__name__.removeprefix("test_"))
def test_the_family_shown_keeps_what_every_family_promises(registered, promise):
    starts = STARTS if "start" in inspect.signature(promise).parameters else (None,)
    for start in starts:
        promise(registered, **({} if start is None else {"start": start}))


def test_the_family_shown_takes_part_in_the_command(registered, run, tmp_path):
    x = np.sin(np.linspace(0.0, 40.0, 900)) * np.linspace(1.0, 0.4, 900)
    y = example(registered).simulate(x)
    np.savetxt(tmp_path / "log.csv", np.column_stack([x, y]), delimiter=",", header="x_bar,y_deg", comments="")
    model = tmp_path / "model.json"
    signals = ("--input", "x_bar", "--output", "y_deg", "--families", f"static,{registered}", "--save", model)
    status, out, err = run("compare", tmp_path / "log.csv", *signals)
    assert status == 0 and out.startswith(f"{registered} has the smallest error"), out + err
    assert load(model).family == registered
    status, _, err = run("compensate", model, tmp_path / "log.csv", "--output", "y_deg", "--out", tmp_path / "x.csv")
    assert status == 0, err


def test_the_family_shown_says_why_it_cannot_fit_a_clockwise_loop(registered):
    x = np.sin(np.linspace(0.0, 40.0, 900)) * np.linspace(1.0, 0.4, 900)
    found = compare(Recording(input=x, output=x - 0.6 * example(registered).simulate(x)), [registered])
    assert "clockwise" in found[registered].reason


def test_a_mistake_in_the_family_shown_would_be_noticed(registered, monkeypatch):
    """The promises can fail: a model that forgets its memory between two calls breaks the first."""
    record = type(example(registered))
    whole = record.run
    monkeypatch.setattr(record, "run", lambda self, x, dt, memory: whole(self, x, dt, self.rest(float(x[0]))))
    with pytest.raises(AssertionError):
        conformity.test_a_run_cut_in_pieces_is_the_same_run_bit_for_bit(registered)


@pytest.fixture
def drawn(tmp_path, monkeypatch):
    """The figure of CONTRIBUTING, as if its lines stood among the figures of a fit."""
    module, name, entry = re.fullmatch(r"from (\S+) import (\w+)\n    (\w+),\n", LINES).groups()
    assert entry == name
    load_shown(module, FIGURE, tmp_path, monkeypatch)
    monkeypatch.setattr(figures, "MAKERS", (*figures.MAKERS, getattr(sys.modules[module], name)))


def test_the_figure_shown_needs_no_more_than_four_files():
    named = set(re.findall(r"`((?:src|tests)/\S+\.py)`", DRAWING))
    assert len(named - {"tests/test_contributing.py", "tests/test_report.py"}) == 3  # those run by themselves


def test_the_tests_of_the_figure_shown_pass(drawn):
    assert run_shown(FIGURE_TESTS) == 2


@pytest.mark.slow
def test_the_figure_shown_is_on_the_page_and_among_the_files(drawn, tmp_path):
    fit = fit_by_hand()
    page = write_report(fit, tmp_path / "r.html", figures=tmp_path / "figures").read_text(encoding="utf-8")
    figure = figures.all_figures(fit)[-1]
    assert f'<section class="figure" id="{figure.key}">' in page and f'<a href="#{figure.key}">' in page
    assert figure.panels[0].alt in page and "samples with a larger error [%]" in page
    assert (tmp_path / "figures" / f"figure-{len(figures.all_figures(fit))}-{figure.key}.svg").is_file()
    bare = write_report(fit_by_hand(train=1.0), tmp_path / "bare.html").read_text(encoding="utf-8")
    assert f'id="{figure.key}"' not in bare


@pytest.fixture
def readable(tmp_path, monkeypatch):
    """The file and the row of CONTRIBUTING for a log format, as if they were part of the package."""
    (row,) = eval(f"({FORMAT_ROW.strip()})", {"Format": formats.Format})
    load_shown(f"dehyst.io.{row.module}", FORMAT, tmp_path, monkeypatch)
    monkeypatch.setattr(formats, "FORMATS", (*formats.FORMATS, row))
    return row


def test_the_log_format_shown_needs_no_more_than_four_files():
    named = set(re.findall(r"`(src/\S+\.py|tests/\S+\.py)`|\((docs/\S+\.md)\)", READING))
    assert len({one or other for one, other in named} - {"tests/test_contributing.py"}) == 4


def test_the_tests_of_the_log_format_shown_pass(readable, tmp_path):
    assert run_shown(FORMAT_TESTS, tmp_path) == 2


def test_the_log_format_shown_is_read_by_the_command_and_refused_by_its_name(readable, run, tmp_path):
    shown = {}
    exec(compile(FORMAT_TESTS, "CONTRIBUTING.md", "exec", dont_inherit=True), shown)
    path = shown["written"](tmp_path)
    status, out, err = run("inspect", path)
    assert status == 0 and "--input pressure_bar --output angle_deg" in out, out + err
    path.write_bytes(path.read_bytes()[:-3])
    assert f"cannot be read as {readable.title}" in run("inspect", path)[2]
    path.write_bytes(b"something else")
    assert f"not those of {readable.title}" in run("inspect", path)[2]


@pytest.fixture
def exportable(tmp_path, monkeypatch):
    """The file and the row of CONTRIBUTING for a target, as if they were part of the package."""
    (row,) = eval(f"({TARGET_ROW.strip()})", {"Target": targets.Target})
    load_shown(row.module, TARGET, tmp_path, monkeypatch)
    monkeypatch.setattr(targets, "TARGETS", {**targets.TARGETS, row.name: row})
    return row


def test_the_target_shown_needs_no_more_than_four_files():
    named = set(re.findall(r"`((?:src|tests)/\S+\.py)`", EXPORTING))
    others = {"tests/test_contributing.py", "src/dehyst/export/extra.py", "tests/test_export_extra.py"}
    assert len(named - others) == 4


@pytest.mark.slow
def test_the_tests_of_the_target_shown_pass(exportable, tmp_path):
    assert run_shown(TARGET_TESTS, tmp_path) == 2


@pytest.mark.slow
def test_the_target_shown_is_exported_and_signed_off_by_the_commands(exportable, run, tmp_path):
    model = play_model().save(tmp_path / "model.json")
    status, out, err = run("export", model, "--target", exportable.name, "--out", tmp_path / "made")
    assert status == 0, out + err
    status, out, err = run("verify", tmp_path / "made")
    assert status == 0 and "idf.py build" in out, out + err
    assert f"{exportable.name} ({exportable.summary})" in run("export", model, "--target", "x", "--out", "y")[2]


@pytest.fixture
def pulling(tmp_path, monkeypatch):
    """The class and the lines of CONTRIBUTING, as if they were part of the table of muscles."""
    module, name, entry = re.fullmatch(r"from (\S+) import (\w+)\n +(\w+),\n", MUSCLE_LINES).groups()
    assert entry == name
    load_shown(module, MUSCLE, tmp_path, monkeypatch)
    kind = getattr(sys.modules[module], name)
    monkeypatch.setitem(muscles.MODELS, kind.name, kind)
    return kind


def test_the_muscle_shown_needs_no_more_than_four_files():
    named = set(re.findall(r"`((?:src|tests)/\S+\.py)`", PULLING))
    assert len(named - {"tests/test_contributing.py", "tests/test_muscles_models.py"}) == 3  # those run by themselves


def test_the_tests_of_the_muscle_shown_pass(pulling):
    assert run_shown(MUSCLE_TESTS) == 2
    assert doctest.testmod(sys.modules[pulling.__module__]).failed == 0


def test_the_muscle_shown_keeps_what_every_muscle_promises(pulling, monkeypatch):
    tests = [test for name, test in vars(pulls).items() if name.startswith("test_")]
    promises = [test for test in tests if {"name"} == set(inspect.signature(test).parameters)]
    assert len(promises) > 10
    for promise in promises:
        promise(pulling.name)
    monkeypatch.setattr(pulling, "_resistance", lambda self, kappa, pressure, speed, slip, m: -self.band * slip)
    with pytest.raises(AssertionError):  # they can fail
        pulls.test_friction_opposes_the_motion_once_everything_slips(pulling.name)


def test_the_muscle_shown_takes_part_in_the_command(pulling, run):
    status, out, err = run("muscle", pulling.name)
    assert status == 0 and "Constant area, constant stiffness, Coulomb friction; l_0 = 300 mm" in out, out + err
    assert pulling.name in run("muscle", "--list")[1]


def test_the_rule_shown_needs_no_more_than_four_files():
    named = set(re.findall(r"`((?:src|tests|docs)/\S+?)`", RULING))
    assert len(named) <= 4 and all((ROOT / name).exists() for name in named)


def test_the_tests_of_the_rule_shown_pass_with_it_and_not_without(monkeypatch):
    with pytest.raises(AssertionError):
        run_shown(RULE_TESTS)
    shown = {}
    exec(RULE, shown)
    monkeypatch.setattr(choice, "score_of", shown["score_of"])
    assert run_shown(RULE_TESTS) == 2


def test_the_commands_that_judge_a_rule_are_there():
    commands = re.findall(r"^python (\S+)", RULING, re.M)
    assert len(commands) == 2 and all((ROOT / name).is_file() for name in commands)


def put_in(path, before, text):
    """Insert lines before the first place of a pattern."""
    whole = path.read_text(encoding="utf-8")
    place = re.search(before, whole).start()
    path.write_text(whole[:place] + text + whole[place:], encoding="utf-8")


@pytest.fixture(scope="module")
def sensing(tmp_path_factory):
    """A copy of the package with the sensor of CONTRIBUTING, its plant compiled anew beside the extension."""
    nanobind = pytest.importorskip("nanobind", reason="nanobind binds the plant: pip install nanobind")
    if not shutil.which("gcc") or not shutil.which("g++"):
        pytest.skip("gcc and g++ compile the plant, and are not installed")
    folder = tmp_path_factory.mktemp("sensing")
    package = Path(importlib.util.find_spec("dehyst").origin).parent
    shutil.copytree(package, folder / "dehyst", ignore=shutil.ignore_patterns("__pycache__", "core_sources"))
    shutil.copytree(ROOT / "plant", folder / "plant")
    shutil.copytree(ROOT / "src" / "native", folder / "native")
    shutil.copytree(ROOT / "src" / "native_robot", folder / "native", dirs_exist_ok=True)
    kind, sensor = SENSOR_ROWS.splitlines(keepends=True)
    put_in(folder / "plant" / "sensors.h", r"\n#define PLANT_SENSORS\(", kind)
    put_in(folder / "plant" / "sensors.h", r"\n#endif", sensor)
    arm = folder / "dehyst" / "robot" / "arm"
    put_in(arm / "tables.py", r"\n\n@dataclass\(frozen=True\)\nclass Base", SENSOR_KEYS)
    put_in(arm / "arm.toml", r"\n# The chain:", SENSOR_NUMBERS)
    (folder / "native" / "alone.cpp").write_text(
        '#include "robot.h"\nNB_MODULE(alone, m) { bind_plant(m); bind_robot(m); }\n', encoding="utf-8"
    )
    home, native = Path(nanobind.include_dir()).parent, folder / "native"
    includes = [folder / "plant", *(ROOT / name for name in ("engine", "core", "reviewed"))]
    includes += [home / "include", home / "ext/robin_map/include"]
    flags = ["-fPIC", "-ffp-contract=off", "-O1", *(f"-I{path}" for path in includes)]
    flags += [f"-I{sysconfig.get_paths()['include']}"]
    c = [*(folder / "plant").glob("*.c"), *(ROOT / "core").glob("*.c"), *(ROOT / "reviewed").glob("*.c")]
    c = [*sorted(c), ROOT / "engine" / "patience.c"]
    own = ("alone", "plant", "plant_parameters", "robot")
    cpp = [*(native / f"{name}.cpp" for name in own), home / "src/nb_combined.cpp"]
    objects = [folder / f"{k}.o" for k in range(len(c) + len(cpp))]
    for source, target in zip((*c, *cpp), objects, strict=True):
        compiler = ("gcc", "-std=c11") if source in c else ("g++", "-std=c++17", "-fvisibility=hidden")
        subprocess.run([*compiler, "-DNB_DOMAIN=alone", *flags, "-c", source, "-o", target], check=True, timeout=600)
    module = folder / f"alone{sysconfig.get_config_var('EXT_SUFFIX')}"
    subprocess.run(["g++", "-shared", *objects, "-o", module], check=True, timeout=600)
    return folder


@pytest.mark.slow
def test_the_tests_of_the_sensor_shown_pass(sensing):
    (sensing / "test_shown.py").write_text(SENSOR_TESTS, encoding="utf-8")
    begin = "import alone, dehyst.robot._native as n; n.PneumaticJoint = alone.PneumaticJoint; "
    begin += "n.ClosedLoop = alone.ClosedLoop"
    program = f"import sys; sys.path.insert(0, '.'); {begin}; import test_shown as t\n" + (
        "for name in dir(t):\n    if name.startswith('test_'): getattr(t, name)(); print(name)\n"
        "shown = t.run(t.ROBOT, 200)[0]; print(*(shown[name].tobytes().hex() for name in list(shown)[:3]))"
    )
    told = subprocess.run([sys.executable, "-c", program], cwd=sensing, capture_output=True, text=True, timeout=600)
    assert told.stdout.count("test_") == 2, told.stdout + told.stderr
    assert told.stdout.splitlines()[-1].split() == [values.tobytes().hex() for values in readings_without()]


def readings_without():
    """What the sensors show in the run of the shown test, in the plant as it is."""
    bench, rows = JointBench(load_robot(), 2, seed=3), []
    for _ in range(200):
        rows.append(bench.step([[0.3, -0.3]])[0])
    return np.array(rows).T.copy()


def test_the_sensor_shown_needs_no_more_than_four_files():
    named = set(re.findall(r"`((?:src|tests|plant)/\S+\.\w+)`", SENSING)) - {"tests/test_contributing.py"}
    assert len(named) == 4 and all((ROOT / name).is_file() for name in named if not name.startswith("tests/"))
