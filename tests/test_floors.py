"""The house: a module imports from lower floors or its own room only, and every foreign package has one home."""

import ast
import re
import sys
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

SOURCE = Path(__file__).parents[1] / "src" / "dehyst"
FLOORS = (  # those of the architecture, with errors below the other modules of the first one, and app below cli
    {"arrays", "shell", "version"},
    {"errors", "findings", "_native"},
    {"fields", "files", "plugins", "units"},
    {"data"},
    {"models"},
    {"identification", "design"},
    {"families"},
    {"io", "monitoring"},
    {"export", "neighbours", "report"},
    {"app"},
    {"robot"},
    {"cli"},
    {"__main__", "worker"},
)
INNER = {  # floors inside large rooms, of what is named
    "robot": ({"control", "muscles", "iso9283"}, {"export"}, {"arm"}, {"experiments"}, {"report"}, {"commands"}),
    "identification": (
        {"data"},
        {"regressors"},
        {"families"},
        {"selection"},
        {"certify"},
        {"procedure"},
        {"direct", "shear", "stream"},
        {"plays"},
    ),
    "export": ({"iec"}, {"units"}, {"subject"}, {"st", "fmu"}, {"fmu2", "fmu3"}, {"verification"}),
    "families": ({"base"}, {"elements"}, {"columns"}, {"choice"}, {"rows"}, {"best"}),
    "report": ({"parts"}, {"drawing", "svg"}, {"figures", "page"}, {"fit", "compare", "drift", "pictures"}),
}
FLOOR = {room: number for number, rooms in enumerate(FLOORS, 1) for room in rooms}
HOMES = {
    "scipy": {"identification", "families", "io", "monitoring", "robot"},
    "h5py": {"io"},
    "jinja2": {"export", "neighbours", "report"},
    "markupsafe": {"report", "robot"},  # jinja2's own strings
    "threadpoolctl": {"identification"},
    "matplotlib": {"report"},
    "typer": {"cli", "app"},
    "rich": {"cli", "app", "robot"},
    "starlette": {"app"},
    "uvicorn": {"app"},
    "rosbags": {"io"},
    "asammdf": {"io"},
    "polars": {"io"},
    "narwhals": {"io", "data"},
    "paho": {"io"},
    "asyncua": {"io"},
    "control": {"neighbours"},
    "sklearn": {"neighbours"},
    "python_calamine": {"io"},
    "nptdms": {"io"},
    "distributed": {"robot"},
    "fmpy": {"export"},
    "mujoco": {"robot"},
    "gymnasium": {"robot"},
    "mink": {"robot"},
    "numpy": set(FLOOR),
}
MODULES = [path for path in sorted(SOURCE.rglob("*.py")) if path != SOURCE / "__init__.py"]  # the public names


def imports(tree, package):
    """Return the dotted names that a module imports anywhere, functions included; relative ones made absolute."""
    names = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = ".".join(package[: len(package) - node.level + 1]) if node.level else ""
            module = ".".join(filter(None, (base, node.module)))
            names += [f"{module}.{alias.name}" for alias in node.names] if module == "dehyst" else [module]
        elif isinstance(node, ast.Call) and getattr(node.func, "id", getattr(node.func, "attr", "")) == "import_module":
            names += [a.value for a in node.args[:1] if isinstance(a, ast.Constant)]
    return names


def faults(source, parts):
    """Return what a module at these parts below dehyst imports against the rules."""
    room = parts[0].removesuffix(".py")
    found = []
    for name in imports(ast.parse(source), ("dehyst", *parts[:-1])):
        top, _, rest = name.partition(".")
        if top == "dehyst":
            other = rest.split(".")[0]
            if other and other != "__version__" and other != room and FLOOR.get(other, 99) >= FLOOR[room]:
                found.append(f"{room} (floor {FLOOR[room]}) imports dehyst.{rest}")
        elif top not in sys.stdlib_module_names and room not in HOMES.get(top, ()):
            found.append(f"{room} imports {top}, whose home is {sorted(HOMES.get(top, ['nowhere']))}")
    return found


@pytest.mark.slow
def test_a_module_imports_from_lower_floors_only():
    found = {}
    for path in MODULES:
        parts = path.relative_to(SOURCE).parts
        assert parts[0].removesuffix(".py") in FLOOR, f"{parts[0]} has no floor: add it to FLOORS"
        found["/".join(parts)] = faults(path.read_text(encoding="utf-8"), parts)
    assert len(found) > 100 and {name: wrong for name, wrong in found.items() if wrong} == {}


def names_in(path):
    """Modules of the package that a file imports when it runs, in functions too; what only types need is left out."""
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


def test_no_module_imports_itself_through_others():
    files = {".".join(("dehyst", *path.relative_to(SOURCE).with_suffix("").parts)): path for path in MODULES}
    files = {name.removesuffix(".__init__"): path for name, path in files.items()}
    graph = {}
    for name, path in files.items():
        named = names_in(path) & set(files)
        graph[name] = {other for other in named if not any(one.startswith(f"{other}.") for one in named)} - {name}
    assert sum(map(len, graph.values())) > 1000
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as found:
        pytest.fail(f"imports go round: {' -> '.join(found.args[1])}")


@pytest.mark.parametrize("room", INNER)
def test_large_rooms_have_floors_inside(room):
    level = {name: number for number, names in enumerate(INNER[room], 1) for name in names}
    found = []
    for path in sorted((SOURCE / room).rglob("*.py")):
        part = path.relative_to(SOURCE / room).parts[0].removesuffix(".py")
        if part == "__init__":
            continue
        for name in names_in(path):
            other = name.removeprefix(f"dehyst.{room}.").split(".")[0] if name.startswith(f"dehyst.{room}.") else part
            if other != part and level.get(other, 0) >= level.get(part, 99):
                found.append(f"{path.name} imports {name}")
    assert found == [] and set(level) <= {path.stem for path in (SOURCE / room).iterdir()}


@pytest.mark.parametrize(
    ("source", "parts", "number"),
    [
        ("import dehyst.io", ("models", "pi.py"), 1),
        ("from dehyst.io.text import a", ("models", "pi.py"), 1),
        ("def f():\n    from dehyst import io", ("models", "pi.py"), 1),
        ("from ..report import page", ("identification", "fit.py"), 1),
        ("from importlib import import_module\nimport_module('dehyst.cli')", ("io", "a.py"), 1),
        ("from dehyst.findings import Finding", ("errors.py",), 1),  # never sideways either
        ("import scipy.optimize, pandas", ("models", "pi.py"), 2),
        ("from . import text\nfrom dehyst import __version__, models\nimport os, numpy", ("io", "a.py"), 0),
        ("from dehyst.errors import LogError\nimport scipy", ("io", "a.py"), 0),
    ],
)
def test_the_rule_itself_finds_what_it_should(source, parts, number):
    assert len(faults(source, parts)) == number


PAGE = (SOURCE.parents[1] / "CONTRIBUTING.md").read_text(encoding="utf-8")


def test_contributing_names_the_homes_of_foreign_packages_and_the_rooms_that_share_a_floor():
    homes: dict[str, set[str]] = {}
    for part in PAGE.partition("\nHomes: ")[2].partition("\n\n")[0].split(";"):
        packages, _, rooms = part.partition(" in ")
        for package in re.findall(r"\w+", packages.replace(" and ", " ")):
            homes[package] = set(re.findall(r"`(\w+)`", rooms))
    assert homes == {package: rooms for package, rooms in HOMES.items() if package != "numpy"}
    shared = PAGE.partition("some share one: ")[2].partition("\n\n")[0].split(";")
    named = [set(re.findall(r"`(\w+)`", part)) for part in shared]
    rows = set(re.findall(r"(?m)^\| `src/dehyst/(\w+)/", PAGE)) | {"neighbours"}
    assert named == [floor & rows for floor in FLOORS if len(floor & rows) > 1]
