"""Recipes of docs/contributing/: families, figures, formats, targets, muscles, sensors, a changed rule; all are run."""

import doctest
import importlib.util
import inspect
import re
import shutil
import subprocess
import sys
import sysconfig
import tomllib
from pathlib import Path

import numpy as np
import pytest

import test_families_conformity as conformity
import test_muscles_models as pulls
from dehyst import Recording, compare, identify, load
from dehyst.data import kit as data_kit
from dehyst.export import _targets as targets
from dehyst.export import kit as export_kit
from dehyst.families import STARTS, example
from dehyst.families import _registry as registry
from dehyst.families import _rows as rows
from dehyst.families import _table as table
from dehyst.io import _formats as formats
from dehyst.report import _figures as figures
from dehyst.report import write_report
from dehyst_robot.arm import JointBench, load_robot
from dehyst_robot.muscles import _parameters as muscle_parameters
from dehyst_robot.muscles import _registry as muscles
from export_samples import play_model
from places import KERNEL, ROBOT, ROOT
from report_samples import fit_by_hand

RECIPES = ROOT / "docs" / "contributing"


def page(name):
    """Text of one recipe."""
    return (RECIPES / f"{name}.md").read_text(encoding="utf-8")


def code_of(text):
    """Code that a recipe shows, block by block; commands are left out."""
    return re.findall(r"(?ms)^```(?:python|toml|text)\n(.*?)^```$", text)


def files_named(text):
    """Files of the packages, tests and pages that a recipe asks to write or to change."""
    names = set(re.findall(r"`((?:packages|tests|docs)/\S+\.\w+)`", text))
    for link in re.findall(r"\]\(\.\./(how-to/\S+\.md)\)", text):
        names.add(f"docs/{link}")
    return names - {"tests/test_contributing.py"}


MODEL_PAGE = page("add-a-model")
(ROW,) = code_of(MODEL_PAGE.partition("## A row of elements")[2].partition("\n## ")[0])
SECTION = MODEL_PAGE.partition("## A family for comparison")[2].partition("\n## ")[0]
FAMILY, LINE, TESTS = code_of(SECTION)
FIGURE, LINES, FIGURE_TESTS = code_of(page("add-a-report-figure"))
FORMAT, FORMAT_ROW, FORMAT_TESTS = code_of(page("add-a-log-format"))
TARGET, TARGET_ROW, TARGET_POINT, TARGET_TESTS, TARGET_PACKAGE = code_of(page("add-a-target"))
MUSCLE, MUSCLE_FILE, MUSCLE_LINES, MUSCLE_TESTS = code_of(page("add-a-muscle-model"))
SENSOR_ROWS, SENSOR_KEYS, SENSOR_NUMBERS, SENSOR_TESTS = code_of(page("add-a-sensor"))
RULE, RULE_TESTS = code_of(page("change-the-rule-of-auto"))
RULING = page("change-the-rule-of-auto")
OF_RATE = {"test_a_rate_dependent_family_asks_for_time"}
PROMISES = [
    value
    for name, value in vars(conformity).items()
    if name.startswith("test_") and name not in OF_RATE
]


@pytest.fixture
def registered(tmp_path, monkeypatch):
    """The file and the line of the recipe, as if they were part of the package."""
    ((name, module),) = eval("{" + LINE + "}").items()
    load_shown(module, FAMILY, tmp_path, monkeypatch)
    monkeypatch.setitem(registry.MODULES, name, module)
    return name


def load_shown(module, text, folder, monkeypatch):
    require_faces(text)
    path = folder / f"{module.rpartition('.')[2]}.py"
    path.write_text(text, encoding="utf-8")
    spec = importlib.util.spec_from_file_location(module, path)
    loaded = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, module, loaded)
    spec.loader.exec_module(loaded)


def require_faces(text):
    """A recipe imports names of rooms from their faces or kits, never from a private module."""
    assert not re.findall(r"^(?:from|import) dehyst\S*\._\w+", text, re.M)


def run_shown(text, folder=None):
    """Run the tests of the recipe; return how many there are. `folder` is for those that write files."""
    shown = {}
    exec(compile(text, "recipe", "exec", dont_inherit=True), shown)
    tests = [value for name, value in shown.items() if name.startswith("test_")]
    for test in tests:
        test(**dict.fromkeys(inspect.signature(test).parameters, folder))
    return len(tests)


@pytest.fixture
def tabled(monkeypatch):
    """The row of the recipe, as if it stood in the table."""
    (row,) = eval(f"({ROW.strip()})", {"_row": table._row})
    monkeypatch.setattr(registry, "ROW_NAMES", (*registry.ROW_NAMES, row.name))
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
    fit = identify(Recording(input=x, output=example(tabled).simulate(x, t), time=t), tabled)
    assert fit.family == fit.model.family == tabled and fit.test.rmse_percent < 2.0
    again = load(fit.model.save(tmp_path / "row.json"))
    assert np.max(np.abs(again.inverse().simulate(fit.model.simulate(x, t), t) - x)) < 1e-9


def test_the_tests_shown_pass(registered):
    assert run_shown(TESTS) == 2


@pytest.mark.parametrize(
    "promise", PROMISES, ids=lambda promise: promise.__name__.removeprefix("test_")
)
def test_the_family_shown_keeps_what_every_family_promises(registered, promise):
    starts = STARTS if "start" in inspect.signature(promise).parameters else (None,)
    for start in starts:
        promise(registered, **({} if start is None else {"start": start}))


@pytest.mark.slow
def test_the_family_shown_takes_part_in_the_command(registered, run, tmp_path):
    x = np.sin(np.linspace(0.0, 40.0, 900)) * np.linspace(1.0, 0.4, 900)
    y = example(registered).simulate(x)
    np.savetxt(
        tmp_path / "log.csv",
        np.column_stack([x, y]),
        delimiter=",",
        header="x_bar,y_deg",
        comments="",
    )
    model = tmp_path / "model.json"
    signals = (
        "--input",
        "x_bar",
        "--output",
        "y_deg",
        "--families",
        f"static,{registered}",
        "--save",
        model,
    )
    status, out, err = run("compare", tmp_path / "log.csv", *signals)
    assert status == 0 and out.startswith(f"{registered} has the smallest error"), out + err
    assert load(model).family == registered
    status, _, err = run(
        "compensate", model, tmp_path / "log.csv", "--output", "y_deg", "--out", tmp_path / "x.csv"
    )
    assert status == 0, err


def test_the_family_shown_says_why_it_cannot_fit_a_clockwise_loop(registered):
    x = np.sin(np.linspace(0.0, 40.0, 900)) * np.linspace(1.0, 0.4, 900)
    found = compare(
        Recording(input=x, output=x - 0.6 * example(registered).simulate(x)), [registered]
    )
    assert "clockwise" in found[registered].reason


def test_a_mistake_in_the_family_shown_would_be_noticed(registered, monkeypatch):
    """The promises can fail: a model that forgets its memory between two calls breaks the first."""
    record = type(example(registered))
    whole = record.run
    monkeypatch.setattr(
        record, "run", lambda self, x, dt, memory: whole(self, x, dt, self.rest(float(x[0])))
    )
    with pytest.raises(AssertionError):
        conformity.test_a_run_cut_in_pieces_is_the_same_run_bit_for_bit(registered)


@pytest.fixture
def drawn(tmp_path, monkeypatch):
    """The figure of the recipe, as if its lines stood among the figures of a fit."""
    module, name, entry = re.fullmatch(r"from (\S+) import (\w+)\n    (\w+),\n", LINES).groups()
    assert entry == name
    load_shown(module, FIGURE, tmp_path, monkeypatch)
    monkeypatch.setattr(figures, "MAKERS", (*figures.MAKERS, getattr(sys.modules[module], name)))


@pytest.mark.parametrize(
    ("name", "number"),
    [
        ("add-a-report-figure", 3),
        ("add-a-log-format", 4),
        ("add-a-muscle-model", 4),
        ("add-a-sensor", 4),
        ("change-the-rule-of-auto", 2),
    ],
)
def test_a_recipe_touches_no_more_than_four_files(name, number):
    names = files_named(page(name))
    missing = []
    for path in sorted(names):
        if not (ROOT / path).is_file():
            missing.append(path)
    assert len(names) == number
    # What is not there yet is the new module, its parameters and its tests.
    assert len(missing) <= 3


def test_a_target_touches_no_more_than_four_files():
    text = page("add-a-target").partition("A build system whose files")[0]
    assert len(files_named(text)) == 4


def test_the_tests_of_the_figure_shown_pass(drawn):
    assert run_shown(FIGURE_TESTS) == 2


@pytest.mark.slow
def test_the_figure_shown_is_on_the_page_and_among_the_files(drawn, tmp_path):
    fit = fit_by_hand()
    page = write_report(fit, tmp_path / "r.html", figures=tmp_path / "figures").read_text(
        encoding="utf-8"
    )
    figure = figures.all_figures(fit)[-1]
    assert (
        f'<section class="figure" id="{figure.key}">' in page
        and f'<a href="#{figure.key}">' in page
    )
    assert figure.panels[0].alt in page and "samples with a larger error [%]" in page
    assert (
        tmp_path / "figures" / f"figure-{len(figures.all_figures(fit))}-{figure.key}.svg"
    ).is_file()
    bare = write_report(fit_by_hand(train=1.0), tmp_path / "bare.html").read_text(encoding="utf-8")
    assert f'id="{figure.key}"' not in bare


@pytest.fixture
def readable(tmp_path, monkeypatch):
    """The file and the row of the recipe for a log format, as if they were part of the package."""
    (row,) = eval(f"({FORMAT_ROW.strip()})", {"Format": formats.Format})
    load_shown(f"dehyst.io._{row.module}", FORMAT, tmp_path, monkeypatch)
    monkeypatch.setattr(formats, "FORMATS", (*formats.FORMATS, row))
    return row


def test_the_tests_of_the_log_format_shown_pass(readable, tmp_path):
    assert run_shown(FORMAT_TESTS, tmp_path) == 2


def test_the_log_format_shown_is_read_by_the_command_and_refused_by_its_name(
    readable, run, tmp_path
):
    shown = {}
    exec(compile(FORMAT_TESTS, "recipe", "exec", dont_inherit=True), shown)
    path = shown["written"](tmp_path)
    status, out, err = run("inspect", path)
    assert status == 0 and "--input pressure_bar --output angle_deg" in out, out + err
    path.write_bytes(path.read_bytes()[:-3])
    assert f"cannot be read as {readable.title}" in run("inspect", path)[2]
    path.write_bytes(b"something else")
    assert f"not those of {readable.title}" in run("inspect", path)[2]


@pytest.fixture
def exportable(tmp_path, monkeypatch):
    """The file and the row of the recipe for a target, as if they were part of the package."""
    module = {"export_kit": export_kit}
    exec(TARGET_ROW, module)
    name, _, place = TARGET_POINT.strip().partition(" = ")
    package, _, attribute = eval(place).partition(":")
    row = module[attribute]
    assert (package, name) == ("dehyst_targets", row.name)
    load_shown(row.module, TARGET, tmp_path, monkeypatch)
    monkeypatch.setattr(targets, "TARGETS", {**targets.TARGETS, row.name: row})
    return row


def test_the_package_shown_adds_the_target_under_its_name(exportable):
    package = tomllib.loads(TARGET_PACKAGE)
    points = package["project"]["entry-points"][targets.GROUP]
    assert points == {exportable.name: "esp_idf_row:ESP_IDF"}
    modules = package["tool"]["hatch"]["build"]["targets"]["wheel"]["only-include"]
    assert modules[0] == "esp_idf_row.py"


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
    assert (
        f"{exportable.name} ({exportable.summary})"
        in run("export", model, "--target", "x", "--out", "y")[2]
    )


@pytest.fixture
def pulling(tmp_path, monkeypatch):
    """The class and the lines of the recipe, as if they were part of the table of muscles."""
    module, name, entry = re.fullmatch(
        r"from (\S+) import (\w+)\n +(\w+),\n", MUSCLE_LINES
    ).groups()
    assert entry == name
    monkeypatch.setattr(muscle_parameters, "FOLDER", tmp_path)
    (tmp_path / "linear.toml").write_text(MUSCLE_FILE, encoding="utf-8")
    load_shown(module, MUSCLE, tmp_path, monkeypatch)
    kind = getattr(sys.modules[module], name)
    monkeypatch.setitem(muscles.MODELS, kind.name, kind)
    return kind


def test_the_tests_of_the_muscle_shown_pass(pulling):
    assert run_shown(MUSCLE_TESTS) == 2
    assert doctest.testmod(sys.modules[pulling.__module__]).failed == 0


def test_the_muscle_shown_keeps_what_every_muscle_promises(pulling, monkeypatch):
    tests = [test for name, test in vars(pulls).items() if name.startswith("test_")]
    promises = [test for test in tests if {"name"} == set(inspect.signature(test).parameters)]
    assert len(promises) > 10
    for promise in promises:
        promise(pulling.name)
    monkeypatch.setattr(
        pulling, "_resistance", lambda self, kappa, pressure, speed, slip, m: -self.band * slip
    )
    with pytest.raises(AssertionError):  # they can fail
        pulls.test_friction_opposes_the_motion_once_everything_slips(pulling.name)


def test_the_muscle_shown_takes_part_in_the_command(pulling, run):
    status, out, err = run("muscle", pulling.name)
    assert (
        status == 0 and "Constant area, constant stiffness, Coulomb friction; l_0 = 300 mm" in out
    ), out + err
    assert pulling.name in run("muscle", "--list")[1]


def test_the_tests_of_the_rule_shown_pass_with_it_and_not_without(monkeypatch):
    with pytest.raises(AssertionError):
        run_shown(RULE_TESTS)
    shown = {}
    exec(RULE, shown)
    monkeypatch.setattr(data_kit, "score_of", shown["score_of"])
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
    """A copy of the package with the sensor of the recipe, its plant compiled anew beside the extension."""
    nanobind = pytest.importorskip(
        "nanobind", reason="nanobind binds the plant: pip install nanobind"
    )
    if not shutil.which("gcc") or not shutil.which("g++"):
        pytest.skip("gcc and g++ compile the plant, and are not installed")
    folder = tmp_path_factory.mktemp("sensing")
    package = Path(importlib.util.find_spec("dehyst_robot").origin).parent
    shutil.copytree(package, folder / "dehyst_robot", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(ROBOT / "plant", folder / "plant")
    shutil.copytree(KERNEL / "native", folder / "native")
    shutil.copytree(ROBOT / "native", folder / "native", dirs_exist_ok=True)
    kind, sensor = SENSOR_ROWS.splitlines(keepends=True)
    put_in(folder / "plant" / "sensors.h", r"\n#define PLANT_SENSORS\(", kind)
    put_in(folder / "plant" / "sensors.h", r"\n#endif", sensor)
    arm = folder / "dehyst_robot" / "arm"
    put_in(arm / "_tables.py", r"\n\n@dataclass\(frozen=True\)\nclass Base", SENSOR_KEYS)
    put_in(arm / "arm.toml", r"\n# The chain:", SENSOR_NUMBERS)
    (folder / "native" / "alone.cpp").write_text(
        '#include "robot.h"\nNB_MODULE(alone, m) { bind_plant(m); bind_robot(m); }\n',
        encoding="utf-8",
    )
    home, native = Path(nanobind.include_dir()).parent, folder / "native"
    includes = [folder / "plant", KERNEL / "engine", KERNEL / "core", ROBOT / "reviewed"]
    includes += [home / "include", home / "ext/robin_map/include"]
    flags = ["-fPIC", "-ffp-contract=off", "-O1", *(f"-I{path}" for path in includes)]
    flags += [f"-I{sysconfig.get_paths()['include']}"]
    c = [
        *(folder / "plant").glob("*.c"),
        *(KERNEL / "core").glob("*.c"),
        *(ROBOT / "reviewed").glob("*.c"),
    ]
    c = [*sorted(c), KERNEL / "engine" / "patience.c"]
    own = ("alone", "plant", "plant_parameters", "robot")
    cpp = [*(native / f"{name}.cpp" for name in own), home / "src/nb_combined.cpp"]
    objects = [folder / f"{k}.o" for k in range(len(c) + len(cpp))]
    for source, target in zip((*c, *cpp), objects, strict=True):
        compiler = (
            ("gcc", "-std=c11") if source in c else ("g++", "-std=c++17", "-fvisibility=hidden")
        )
        subprocess.run(
            [*compiler, "-DNB_DOMAIN=alone", *flags, "-c", source, "-o", target],
            check=True,
            timeout=600,
        )
    module = folder / f"alone{sysconfig.get_config_var('EXT_SUFFIX')}"
    subprocess.run(["g++", "-shared", *objects, "-o", module], check=True, timeout=600)
    return folder


@pytest.mark.slow
def test_the_tests_of_the_sensor_shown_pass(sensing):
    (sensing / "test_shown.py").write_text(SENSOR_TESTS, encoding="utf-8")
    begin = "import alone, dehyst_robot._native as n; n.PneumaticJoint = alone.PneumaticJoint; "
    begin += "n.ClosedLoop = alone.ClosedLoop"
    program = f"import sys; sys.path.insert(0, '.'); {begin}; import test_shown as t\n" + (
        "for name in dir(t):\n    if name.startswith('test_'): getattr(t, name)(); print(name)\n"
        "shown = t.run(t.ROBOT, 200)[0]; print(*(shown[name].tobytes().hex() for name in list(shown)[:3]))"
    )
    told = subprocess.run(
        [sys.executable, "-c", program], cwd=sensing, capture_output=True, text=True, timeout=600
    )
    assert told.stdout.count("test_") == 2, told.stdout + told.stderr
    assert told.stdout.splitlines()[-1].split() == [
        values.tobytes().hex() for values in readings_without()
    ]


def readings_without():
    """What the sensors show in the run of the shown test, in the plant as it is."""
    bench, rows = JointBench(load_robot(), 2, seed=3), []
    for _ in range(200):
        rows.append(bench.step([[0.3, -0.3]])[0])
    return np.array(rows).T.copy()
