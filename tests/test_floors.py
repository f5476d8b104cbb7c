"""The house: a module imports from lower floors or its own room only, and every foreign package has one home."""

import ast
import re
import sys
from functools import cache
from graphlib import CycleError, TopologicalSorter
from importlib import import_module
from pathlib import Path

import pytest

from places import ROOT, SOURCES

FLOORS = (  # of the kernel, from the ground up: a room imports from the floors below its own, or from itself
    {"arrays", "lazy", "shell", "version"},
    {"errors", "findings", "_native"},
    {"files", "least_squares", "plugins", "student", "units"},
    {"data"},
    {"models"},
    {"families"},
    {"identification", "design"},
    {"io", "monitoring"},
    {"export", "neighbours", "report"},
    {"app"},
    {"cli"},
    {"__main__"},
)
INNER = {  # floors inside large rooms and inside the packages beside the kernel, of what is named
    "dehyst/identification": (
        {"_data"},
        {"_regressors"},
        {"_families"},
        {"_selection"},
        {"_direct"},
        {"_candidate"},
        {"_judge"},
        {"_prepared"},
        {"_candidates"},
        {"_shear"},
        {"_auto", "_cross_validation"},
        {"_comparison"},
    ),
    "dehyst/export": ({"_units"}, {"_subject"}, {"_verification"}),
    "dehyst/families": ({"_base"}, {"_elements"}, {"_columns"}, {"_choice"}, {"_rows"}),
    "dehyst/report": (
        {"_parts"},
        {"_drawing", "_svg"},
        {"_figures", "_page"},
        {"_fit", "_compare", "_drift", "_pictures"},
    ),
    "dehyst_robot": (
        {"fields"},
        {"control", "muscles", "iso9283"},
        {"export"},
        {"arm"},
        {"experiments"},
        {"report"},
        {"commands"},
    ),
    "dehyst_targets/backlash": (
        {"_policy", "_requests"},
        {"_readings"},
        {"_lost_motion"},
        {"_compensation"},
        {"_machines"},
        {"_plan", "_write"},
        {"_figure"},
        {"_command"},
    ),
    "dehyst_targets/valves": (
        {"_policy", "_requests"},
        {"_positions", "_regression"},
        {"_fit", "_loop"},
        {"_verdict"},
        {"_figure"},
        {"_command"},
    ),
    "dehyst_targets/magnetics": (
        {"_policy", "_requests"},
        {"_loop"},
        {"_models"},
        {"_write"},
        {"_command"},
    ),
    "dehyst_targets/batteries": (
        {"_policy", "_requests"},
        {"_ocv"},
        {"_fit"},
        {"_write"},
        {"_command"},
    ),
    "dehyst_targets": ({"iec", "wrapped"}, {"st", "fmu", "rust", "ada"}, {"fmu2", "fmu3"}),
    "dehyst_studio": (
        {"live", "strays", "requests"},
        {"mqtt", "opcua", "watch"},
        {"studio", "page", "watch_command"},
        {"commands"},
    ),
}
FLOOR = {room: number for number, rooms in enumerate(FLOORS, 1) for room in rooms}
HOMES = {  # foreign package -> rooms of the kernel, and packages beside it, that may import it
    "scipy": {"io", "dehyst_robot"},
    "h5py": {"io"},
    "jinja2": {"export", "neighbours", "report", "dehyst_targets"},
    "markupsafe": {"report", "dehyst_robot"},  # jinja2's own strings
    "threadpoolctl": {"identification"},
    "matplotlib": {"report"},
    "typer": {"cli", "app"},
    "rich": {"cli", "app", "dehyst_robot"},
    "starlette": {"dehyst_studio"},
    "uvicorn": {"dehyst_studio"},
    "rosbags": {"io"},
    "asammdf": {"io"},
    "polars": {"io"},
    "narwhals": {"io", "data"},
    "paho": {"dehyst_studio"},
    "asyncua": {"dehyst_studio"},
    "control": {"neighbours"},
    "sklearn": {"neighbours"},
    "python_calamine": {"io"},
    "nptdms": {"io"},
    "dask": {"dehyst_robot"},
    "distributed": {"dehyst_robot"},
    "fmpy": {"dehyst_targets"},
    "mujoco": {"dehyst_robot"},
    "gymnasium": {"dehyst_robot"},
    "mink": {"dehyst_robot"},
    "tomlkit": {"dehyst_robot"},
    "numpy": set(FLOOR) | set(SOURCES),
}
MODULES = {  # package -> its modules, without its public names
    package: [path for path in sorted(folder.rglob("*.py")) if path != folder / "__init__.py"]
    for package, folder in SOURCES.items()
}


def imports(tree, package):
    """Return the dotted names that a module imports anywhere, functions included; relative ones made absolute."""
    names = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = ".".join(package[: len(package) - node.level + 1]) if node.level else ""
            module = ".".join(filter(None, (base, node.module)))
            names += (
                [f"{module}.{alias.name}" for alias in node.names]
                if module == "dehyst"
                else [module]
            )
        elif (
            isinstance(node, ast.Call)
            and getattr(node.func, "id", getattr(node.func, "attr", "")) == "import_module"
        ):
            names += [a.value for a in node.args[:1] if isinstance(a, ast.Constant)]
    return names


def faults(source, parts, package="dehyst"):
    """Return what a module at these parts below a package imports against the rules."""
    room = parts[0].removesuffix(".py")
    home = room if package == "dehyst" else package
    against = []
    for name in imports(ast.parse(source), (package, *parts[:-1])):
        top, _, rest = name.partition(".")
        if top == "dehyst" and package == "dehyst":
            other = rest.split(".")[0]
            if (
                other
                and other != "__version__"
                and other != room
                and FLOOR.get(other, 99) >= FLOOR[room]
            ):
                against.append(f"{room} (floor {FLOOR[room]}) imports dehyst.{rest}")
        elif top in SOURCES:
            if top not in ("dehyst", package):
                against.append(f"{package} imports {name}: a package knows itself and the kernel")
        elif top not in sys.stdlib_module_names and home not in HOMES.get(top, ()):
            against.append(
                f"{home} imports {top}, whose home is {sorted(HOMES.get(top, ['nowhere']))}"
            )
    return against


@pytest.mark.slow
@pytest.mark.spread(len(SOURCES))
@pytest.mark.parametrize("package", SOURCES)
def test_a_module_imports_from_lower_floors_only(package):
    against = {}
    for path in MODULES[package]:
        parts = path.relative_to(SOURCES[package]).parts
        if package == "dehyst":
            assert parts[0].removesuffix(".py") in FLOOR, (
                f"{parts[0]} has no floor: add it to FLOORS"
            )
        against["/".join(parts)] = faults(path.read_text(encoding="utf-8"), parts, package)
    assert len(against) > 10 and {name: wrong for name, wrong in against.items() if wrong} == {}


@cache
def names_in(path):
    """Modules that a file imports when it runs, in functions too; what only types need is left out."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, ast.If) and getattr(node.test, "id", "") == "TYPE_CHECKING":
            node.body = []
    named = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module:
            named |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
        elif isinstance(node, ast.Import):
            named |= {alias.name for alias in node.names}
    return named


@pytest.mark.slow
def test_no_module_imports_itself_through_others():
    files = {}
    for package, folder in SOURCES.items():
        for path in MODULES[package]:
            name = ".".join((package, *path.relative_to(folder).with_suffix("").parts))
            files[name.removesuffix(".__init__")] = path
    graph = {}
    for name, path in files.items():
        named = names_in(path) & set(files)
        graph[name] = {
            other for other in named if not any(one.startswith(f"{other}.") for one in named)
        } - {name}
    assert sum(map(len, graph.values())) > 1000
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as fault:
        pytest.fail(f"imports go round: {' -> '.join(fault.args[1])}")


@pytest.mark.parametrize("room", INNER)
def test_large_rooms_have_floors_inside(room):
    package, _, inner = room.partition("/")
    folder = SOURCES[package] / inner
    prefix = ".".join(filter(None, (package, inner))) + "."
    level = {name: number for number, names in enumerate(INNER[room], 1) for name in names}
    against = []
    for path in sorted(folder.rglob("*.py")):
        part = path.relative_to(folder).parts[0].removesuffix(".py")
        if part == "__init__":
            continue
        for name in names_in(path):
            other = name.removeprefix(prefix).split(".")[0] if name.startswith(prefix) else part
            if other != part and level.get(other, 0) >= level.get(part, 99):
                against.append(f"{path.name} imports {name}")
    assert against == [] and set(level) <= {path.stem for path in folder.iterdir()}


OPEN = {  # modules inside rooms, beside each `kit.py`, that are imported by their paths
    "dehyst/app/requests.py",  # of other packages' commands too
    "dehyst/export/c.py",  # what targets of C are made of
    "dehyst/export/compilers.py",
    "dehyst/export/core_files.py",
    "dehyst/export/precision.py",
    "dehyst/neighbours/benchmarks.py",  # one a foreign package: its name says which
    "dehyst/neighbours/control.py",
    "dehyst/neighbours/scikit.py",
}


def test_modules_inside_a_room_begin_with_an_underscore():
    open_modules = set()
    for package, folder in SOURCES.items():
        for path in MODULES[package]:
            parts = path.relative_to(folder).parts
            inside = parts[1:] if path.name != "__init__.py" else parts[1:-1]
            if not inside or inside == ("kit.py",):
                continue
            if not any(part.startswith("_") for part in inside):
                open_modules.add("/".join((package, *parts)))
    assert open_modules == OPEN


def public_names(module):
    """Names that a face shows: those of `__all__`, else those that do not begin with `_`."""
    listed = getattr(module, "__all__", None)
    if listed is not None:
        return [name for name in listed if not name.startswith("_")]
    source = Path(module.__file__).read_text(encoding="utf-8")
    names = set()
    for node in ast.parse(source).body:
        if isinstance(node, ast.ImportFrom):
            # `import a as a` shows a name to others; without `as` it only uses it.
            names |= {alias.asname for alias in node.names if alias.asname == alias.name}
        elif isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            names.add(node.name)
        elif isinstance(node, ast.Assign):
            names |= {target.id for target in node.targets if isinstance(target, ast.Name)}
    return [name for name in names if not name.startswith("_")]


MOST_NAMES = {"dehyst": 32}  # of a face; of every other one 26
FACES = {
    ".".join((package, *path.relative_to(folder).parts[:-1])): path
    for package, folder in SOURCES.items()
    for path in (folder / "__init__.py", *sorted(folder.glob("*/__init__.py")))
}


@pytest.mark.parametrize("face", FACES)
def test_a_face_shows_few_names(face):
    names = public_names(import_module(face))
    assert len(names) <= MOST_NAMES.get(face, 26), sorted(names)


@pytest.mark.parametrize(
    ("source", "parts", "number"),
    [
        ("import dehyst.io", ("models", "pi.py"), 1),
        ("from dehyst.io._text import a", ("models", "pi.py"), 1),
        ("def f():\n    from dehyst import io", ("models", "pi.py"), 1),
        ("from ..report import page", ("identification", "fit.py"), 1),
        ("from importlib import import_module\nimport_module('dehyst.cli')", ("io", "a.py"), 1),
        ("from dehyst.findings import Finding", ("errors.py",), 1),  # never sideways either
        ("import scipy.optimize, pandas", ("models", "pi.py"), 2),
        ("import dehyst_robot.arm", ("io", "a.py"), 1),
        (
            "from . import text\nfrom dehyst import __version__, models\nimport os, numpy",
            ("io", "a.py"),
            0,
        ),
        ("from dehyst.errors import LogError\nimport polars", ("io", "a.py"), 0),
    ],
)
def test_the_rule_itself_finds_what_it_should(source, parts, number):
    assert len(faults(source, parts)) == number


PAGE = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")


def test_contributing_names_every_room():
    rooms = {f"{path.parent.name}/" for path in SOURCES["dehyst"].glob("*/__init__.py")}
    rooms |= {
        f"{path.parent.name}/"
        for package in ("dehyst_robot", "dehyst_targets", "dehyst_studio")
        for path in SOURCES[package].glob("*/__init__.py")
    }
    named = set(re.findall(r"`(?:[\w./-]*/)?(\w+/)`", PAGE))
    assert rooms - named == set()
