"""The documentation is true: generated text is fresh, code runs and prints what is shown, links lead somewhere.

How shown outputs are compared is written in docs/generate/blocks.py: words must agree, numbers within 1 % or one unit
of their last digit.
"""

from __future__ import annotations

import contextlib
import doctest
import importlib
import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import dehyst
from dehyst.families import example
from dehyst.models import model_to_dict
from dehyst_robot.experiments.kit import TRIALS
from in_one import in_one
from places import ROOT

DOCS = ROOT / "docs"
sys.path.insert(0, str(DOCS))

import build  # noqa: E402 - docs/build.py, found through the path above
from generate import (  # noqa: E402
    blocks,
    demo,
    errors,
    figures,
    findings,
    parameters,
    python_names,
    sensitivity,
    thresholds,
)

PAGES = [
    page
    for page in (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.rglob("*.md")))
    if page.exists()
]
RUN = build.written_pages()
STALE = "run: python docs/build.py"
ROOMS = {}  # generated pages, those of the models together: processes share the work
for _page in [*dict.fromkeys(page for page, _ in build.PARTS), *build.PAGES]:
    ROOMS.setdefault(
        "reference/models" if _page.startswith("reference/models/") else _page, []
    ).append(_page)


def name_of(path: Path) -> str:
    return str(path.relative_to(ROOT))


def generated(name: str) -> str:
    """Up-to-date text of one page: each test makes its own, so that processes share the work."""
    if name in build.PAGES:
        return build.PAGES[name]()
    text = (DOCS / name).read_text(encoding="utf-8")
    for (page, part), make in build.PARTS.items():
        text = build.with_part(text, part, make()) if page == name else text
    return text


def test_pages_are_found():
    assert len(PAGES) >= 14
    assert len(RUN) >= 6
    assert sum(len(blocks.steps(page.read_text(encoding="utf-8"))) for page in RUN) > 20


@pytest.mark.slow
@pytest.mark.parametrize("room", ROOMS)
def test_generated_text_is_fresh(room):
    old = [
        name for name in ROOMS[room] if (DOCS / name).read_text(encoding="utf-8") != generated(name)
    ]
    assert not old, f"{STALE}, which writes {', '.join(old)} anew"


@pytest.mark.slow
@pytest.mark.parametrize("page", RUN, ids=name_of)
def test_code_on_a_page_runs_and_prints_what_is_shown(page, tmp_path):
    wrong = [
        f"{name_of(page)}:{step.line}\n--- shown\n{step.shown}\n--- printed\n{printed}"
        for step, printed in blocks.run_page(page.read_text(encoding="utf-8"), tmp_path)
        if step.shown is not None and not blocks.agree(step.shown, printed)
    ]
    assert not wrong, STALE + "\n" + "\n".join(wrong)


@in_one(
    "shown, printed",
    [
        ("rms 0.16 %", "rms 0.19 %"),
        ("a b", "a b c"),
        ("a\n...\nz", "a b c"),
        ("5 gaps", "7 gaps"),
        ("error 1e-15", "error 1e-6"),
        ("True", "False"),
        ("", "Traceback"),
        ("[ 0. 15.]", "[-2. 15.]"),
        ("[1. 2.]", "1. 2."),
    ],
)
def test_the_comparison_of_outputs_can_fail(shown, printed):
    assert blocks.agree(shown, shown)
    assert not blocks.agree(shown, printed)


@in_one(
    "shown, printed",
    [("[-0. 15.]", "[ 0. 15.]"), ("-0.00 %", "0.00 %"), ("rms 0.164 %", "rms 0.1641 %")],
)
def test_what_another_processor_rounds_otherwise_is_no_other_output(shown, printed):
    assert blocks.agree(shown, printed)
    assert blocks.agree(printed, shown)


def test_a_page_whose_code_fails_is_noticed(tmp_path):
    with pytest.raises(AssertionError, match="line 3"):
        blocks.run_page("text\n```python\n1 / 0\n```\n", tmp_path)


def test_outputs_that_are_no_longer_true_are_replaced_and_true_ones_kept(tmp_path):
    text = "```python\nprint(0.5)\n```\n\n```text\n{}\n```\n\nafter\n"
    for shown, kept in (("0.7", "0.5"), ("0.501", "0.501")):
        page, folder = text.format(shown), tmp_path / kept
        folder.mkdir()
        assert blocks.with_outputs(page, blocks.run_page(page, folder)) == text.format(kept)


@in_one("module", [blocks, findings, thresholds])
def test_examples_of_the_generators_are_right(module):
    result = doctest.testmod(module)
    assert result.attempted
    assert not result.failed


def anchors(page: Path) -> set[str]:
    """Anchors that a reader of Markdown gives to the headings of a page."""
    headings = re.findall(
        r"(?m)^#+ +(.+)$", re.sub(r"(?ms)^```.*?^```", "", page.read_text(encoding="utf-8"))
    )
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def broken_links(page: Path) -> list[str]:
    text = re.sub(r"(?ms)^```.*?^```", "", page.read_text(encoding="utf-8"))
    targets = re.findall(r"\]\(([^)\s]+)\)", text) + re.findall(
        r"(?:src|href|srcset)=\"([^\"]+)\"", text
    )
    broken = []
    for target in targets:
        if target.startswith(("https://", "http://", "mailto:")):
            continue
        path, _, anchor = target.partition("#")
        goal = (page.parent / path).resolve() if path else page
        if not goal.exists() or (anchor and anchor not in anchors(goal)):
            broken.append(f"{name_of(page)}: {target}")
    return broken


def test_every_link_leads_somewhere(tmp_path, monkeypatch):
    others = [ROOT / name for name in repository() if name.endswith(".md")] + sorted(
        ROOT.glob("*.md")
    )
    broken = [
        link
        for page in {*PAGES, *others, *build.written_notebooks()}
        for link in broken_links(page)
    ]
    assert not broken, "no such file or heading; correct the links:\n" + "\n".join(broken)
    monkeypatch.setitem(globals(), "ROOT", tmp_path)
    (tmp_path / "a.md").write_text(
        "# Head\n[x](nowhere.md) [y](#other) [z](#head)\n", encoding="utf-8"
    )
    assert broken_links(tmp_path / "a.md") == ["a.md: nowhere.md", "a.md: #other"]


ENDINGS = "py|c|h|cpp|pyi|toml|cmake|yml"
FOLDERS = {
    path.name: path for path in ROOT.iterdir() if path.is_dir() and not path.name.startswith(".")
}
# Files that readers of docs/contributing/ write; test_contributing.py runs them.
THEIRS = (
    "packages/dehyst/src/dehyst/report/_figures/exceeded.py",
    "packages/dehyst/tests/report/test_report_exceeded.py",
    "packages/dehyst/src/dehyst/io/_card.py",
    "packages/dehyst/tests/io/test_io_card.py",
    "packages/dehyst/src/dehyst/families/_backlash.py",
    "packages/dehyst/tests/families/test_families_backlash.py",
    "packages/dehyst-targets/src/dehyst_targets/esp_idf.py",
    "packages/dehyst-targets/tests/targets/test_export_esp_idf.py",
    "packages/dehyst-robot/src/dehyst_robot/muscles/_linear.py",
    "packages/dehyst-robot/src/dehyst_robot/muscles/published/linear.toml",
    "packages/dehyst-robot/tests/muscles/test_muscles_linear.py",
    "packages/dehyst-robot/tests/arm/test_plant_torque.py",
)
# Names that look like those of modules and are none: of the MuJoCo plugin, of a header, of a file, any name; groups of
# entry points.
NO_MODULES = {
    "dehyst.muscle",
    "dehyst.h",
    "dehyst.elbow.0.1.0.pack",
    "dehyst.NAME",
    "dehyst_robot.NAME",
}
NO_MODULES |= {"dehyst.commands", "dehyst.targets", "dehyst.controllers", "dehyst.designs"}
HIDDEN = {"node_modules", "__pycache__", "build", "dist", "site"}  # what tools leave


def missing_files(text: str, files: set[str]) -> set[str]:
    """Return files of the repository that a text names in backticks and that are not among `files`.

    A path with a room of the repository in front, or of the package, is one, and so is the name of a test.
    """
    missing = set()
    for path in re.findall(rf"`((?:[\w.-]+/)*[\w-]+\.(?:{ENDINGS})|(?:[\w.-]+/)+)`", text):
        first = path.partition("/")[0]
        whole = first in FOLDERS and "/" in path
        if not whole and not path.startswith("test_"):
            continue
        if not any(
            file == path or file.startswith(path) or file.endswith(f"/{path}") for file in files
        ):
            missing.add(path)
    return missing


def repository() -> set[str]:
    """Return every file of the repository but what tools leave."""
    return {
        path.relative_to(ROOT).as_posix()
        for room in FOLDERS.values()
        if room.name not in HIDDEN
        for path in room.rglob("*")
        if path.is_file() and not HIDDEN & set(path.relative_to(ROOT).parts)
    }


def missing_modules(text: str) -> set[str]:
    """Return modules and names of the package that a text spells with dots and that are not there."""
    missing = set()
    for spelled in set(re.findall(r"`(dehyst\w*(?:\.\w+)+)(?:\(.*?\))?`", text)) - NO_MODULES:
        place, *names = spelled.split(".")
        found = importlib.import_module(place)
        for name in names:
            place = f"{place}.{name}"
            if not hasattr(found, name):
                with contextlib.suppress(ImportError):
                    importlib.import_module(place)
            found = getattr(found, name, None)
            if found is None:
                missing.add(spelled)
                break
    return missing


def test_files_rooms_and_modules_that_pages_name_exist():
    files = repository()
    files |= set(THEIRS)
    missing = {}
    for name in sorted(files | {path.name for path in ROOT.iterdir()}):
        page = ROOT / name
        if (
            page.suffix != ".md" or page.name == "CHANGELOG.md" or "decisions" in page.parts
        ):  # these tell what was
            continue
        text = page.read_text(encoding="utf-8")
        names = missing_files(text, files) | missing_modules(text)
        if names:
            missing[name_of(page)] = sorted(names)
    assert not missing, missing
    gone = {"packages/dehyst/core/gone.c", "test_gone.py", "packages/dehyst/src/dehyst/gone/"}
    quoted = ", ".join(f"`{name}`" for name in ("tests/test_docs.py", *sorted(gone)))
    assert missing_files(quoted, files) == gone
    assert missing_modules("`dehyst.io.read_log`, `dehyst.gone`, `dehyst.load(x)`") == {
        "dehyst.gone"
    }


PRIVATE_MODULE = re.compile(
    r"\bdehyst\w*(?:\.\w+)*\._[a-z]\w*|\bfrom dehyst[\w.]* import \(?_[a-z]\w*"
)
USED = ("tutorial", "how-to", "reference")  # folders of pages for those who use dehyst


def test_pages_for_users_name_no_private_module():
    pages = [ROOT / "README.md", *sorted((ROOT / "packages").glob("*/README.md"))]
    for folder in USED:
        pages += sorted((DOCS / folder).rglob("*.md"))
    private = {}
    for page in pages:
        names = PRIVATE_MODULE.findall(page.read_text(encoding="utf-8"))
        if names:
            private[name_of(page)] = names
    assert len(pages) > 50 and not private, private
    assert PRIVATE_MODULE.search("`dehyst.models._speed.faster`")
    assert PRIVATE_MODULE.search("from dehyst_robot.muscles import _measured as measured")
    assert not PRIVATE_MODULE.search("`dehyst.models.kit.faster`, `dehyst.__version__`")


def test_index_links_every_page_and_every_decision():
    index = (DOCS / "index.md").read_text(encoding="utf-8")
    linked = {(DOCS / target).resolve() for target in re.findall(r"\]\(([^)#\s]+)", index)}
    models = DOCS / "reference" / "models"
    for folder, page in (
        (models, "index.md"),
        (DOCS / "decisions", "README.md"),
    ):  # link a page each
        listed = (folder / page).read_text(encoding="utf-8")
        linked |= {(folder / target).resolve() for target in re.findall(r"\]\(([^)#\s]+)", listed)}
    pages = [*DOCS.rglob("*.md"), *build.written_notebooks()]
    missing = [
        name_of(page) for page in pages if page.resolve() not in linked | {DOCS / "index.md"}
    ]
    assert not missing, STALE


PRIVATE = re.compile(
    r"(?<![\w.])/(work|tmp|root|home|Users)/|[A-Z]:\\|file://|localhost|\b\d{1,3}(?:\.\d{1,3}){3}\b"
    r"|https?://[^\s/]*(?:\.local|\.internal|\.lan|proxy|artifactory|registry|mirror)",
)


def test_no_path_or_host_of_a_machine_is_written_anywhere():
    files = [
        *PAGES,
        *build.written_notebooks(),
        *DOCS.rglob("*.py"),
        *(DOCS / "images").rglob("*.svg"),
        *(ROOT / "examples").rglob("*.py"),
    ]
    found = [
        f"{name_of(path)}: {match[0]}"
        for path in files
        for match in PRIVATE.finditer(path.read_text(encoding="utf-8"))
        if path.name != "test_docs.py"
    ]
    assert not found
    assert PRIVATE.search("see /" + "tmp/x")


@pytest.mark.slow
def test_every_warning_code_of_the_source_is_documented():
    assert findings.documented() == findings.raised()
    assert len(findings.raised()) > 30


def test_a_code_that_is_computed_otherwise_is_noticed():
    assert findings.codes_in("Finding('a-b', 'text')") == {"a-b"}
    with pytest.raises(ValueError, match="computed"):
        findings.codes_in("Finding(name, 'text')")


def test_every_threshold_has_a_unit_and_a_reason_of_its_own():
    rooms = {room: thresholds.thresholds(source) for room, source in thresholds.records()}
    assert {"dehyst.identification", "dehyst.monitoring", "dehyst.families"} <= set(rooms)
    for room, fields in rooms.items():
        lacking = [field.name for field in fields if not field.unit or not field.reason]
        assert fields and not lacking, (
            f"{room}: write a reason above {lacking}, and its unit in brackets"
        )


def test_a_threshold_without_a_reason_is_noticed():
    (field,) = thresholds.thresholds("class Policy:\n    few: int = 3\n")
    assert not field.unit and not field.reason


def test_every_error_class_has_an_entry_with_a_message_of_its_own():
    kinds = {kind.__name__ for kind in errors.classes()} - {"DehystError"}
    assert kinds == set(errors.PROVOKED)
    assert set(re.findall(r"(?m)^## (\w+)$", generated("reference/errors.md"))) == kinds


def test_every_public_name_and_every_member_of_the_stepper_is_in_the_reference():
    page = generated("reference/python.md")
    assert all(
        f"### dehyst.{name}\n" in page for name in dehyst.__all__ if not name.startswith("_")
    )
    assert all(f"`step.{name}" in page for name in python_names.stepper_names())
    assert (
        "| `.from_frame(" in page and "| `.to_frame(" in page
    )  # a class's method as an instance's
    for path in (Path(dehyst.__file__).parent / "neighbours").glob("[a-z]*.py"):
        for name in re.findall(
            r"(?m)^(?:def|class) ([A-Za-z]\w*)", path.read_text(encoding="utf-8")
        ):
            assert f"### dehyst.neighbours.{path.stem}.{name}\n" in page


def keys_of(value: Any, free: tuple[str, ...] = ("runs",)) -> set[str]:
    if isinstance(value, dict):
        return set(value).union(
            *(keys_of(item, free) for key, item in value.items() if key not in free)
        )
    return (
        set().union(*(keys_of(item, free) for item in value))
        if isinstance(value, (list, tuple))
        else set()
    )


def test_every_key_of_the_json_outputs_and_of_the_model_file_is_documented(tmp_path):
    from dehyst.io import write_example

    log = write_example(tmp_path / "example.csv")
    rec = dehyst.read_log(log, input="#2", output="#3", stop=40.0)
    inner = dehyst.PrandtlIshlinskii([0.0, 1.0], [1.0, 1.0])
    keys = keys_of(dehyst.inspect_log(log).as_dict())
    for family in ("pi", "modified-pi", "stop"):
        fit = dehyst.identify(rec, family, initial_state="rest")
        keys |= keys_of(fit.as_dict()) | keys_of(model_to_dict(fit.model))
    keys |= keys_of(model_to_dict(fit.static)) | keys_of(model_to_dict(inner)) | {"code", "message"}
    documented = set(
        re.findall(r"`([\w-]+)`", (DOCS / "reference" / "json.md").read_text(encoding="utf-8"))
    )
    assert not keys - documented
    assert len(keys) > 60


@pytest.mark.slow
def test_every_key_of_a_comparison_and_of_a_family_s_file_is_documented(tmp_path):
    x = np.sin(np.linspace(0.0, 40.0, 600)) * np.linspace(1.0, 0.4, 600)
    found = dehyst.compare(
        dehyst.Recording(input=x, output=example("dahl").simulate(x)), ["static", "dahl"]
    )
    content = json.loads(found["dahl"].model.save(tmp_path / "m.json").read_text(encoding="utf-8"))
    keys = keys_of(found.as_dict(), free=("families",)) | keys_of(found["dahl"].as_dict())
    keys |= keys_of(content, free=("values",))
    documented = set(
        re.findall(r"`([\w-]+)`", (DOCS / "reference" / "json.md").read_text(encoding="utf-8"))
    )
    assert not keys - documented
    assert len(keys) > 30


def test_every_figure_exists_and_is_shown():
    folder = DOCS / "images"
    images = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    drawn = {f"{name}.svg" for name in figures.FIGURES} | {
        f"{name}.png" for name in figures.WITH_PNG
    }
    # Taken of a browser or of a viewer, each by a command that its page or script names.
    taken = {"browser.png", "browser-inverse.png", "browser-phone.png", "studio.png", "muscles.png"}
    shown = {
        name
        for page in PAGES
        for name in re.findall(r"images/([\w./-]+)", page.read_text(encoding="utf-8"))
    }
    assert images == drawn | taken, STALE
    assert shown <= images and taken <= shown
    assert {name for name in images if name.endswith(".svg")} <= shown


@pytest.mark.slow
def test_a_figure_is_drawn_the_same_twice_without_date_or_address(tmp_path):
    texts = []
    for folder in (tmp_path / "a", tmp_path / "b"):
        folder.mkdir()
        texts.append(figures.write("play", figures.play, folder)[0].read_bytes())
    assert texts[0] == texts[1]
    assert b"<dc:date>" not in texts[0]
    assert b"<!DOCTYPE" not in texts[0]


@pytest.mark.slow
def test_numbers_beside_figures_are_those_of_the_figures():
    _, wanted, plain, compensated = figures.tracking()
    tutorial = (DOCS / "tutorial" / "first-loop.md").read_text(encoding="utf-8")
    assert f"leaves {figures.rms(compensated - wanted):.2f} deg rms" in tutorial
    assert f"leaves {figures.rms(plain - wanted):.2f} deg" in tutorial
    time, _, angle, plays, chosen = figures.hold()
    held = int((time < 2.0).sum())
    limits = (DOCS / "explanation" / "limits.md").read_text(encoding="utf-8")
    crept = f"creeps from {angle[held]:.1f} to {angle[-1]:.1f} deg"
    assert f"{crept} while plays stay at {plays[-1]:.1f} deg" in limits
    assert f"goes to {chosen[-1]:.1f} deg" in limits


def readme_row_is_that_of(name, result, trials):
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    row = re.search(rf"(?m)^\| {name} \| (.+?) \| (.+?) \| (.+?) \|", readme)
    for shown, trial in zip(row.groups(), trials, strict=False):
        for number, expected in zip(shown.split(" → "), demo.errors(result, trial), strict=True):
            assert abs(float(number) - expected) <= max(0.02 * expected, 0.0011), (name, trial)


@pytest.mark.slow
def test_numbers_of_the_readme_are_those_of_the_demo():
    readme_row_is_that_of("Preisach", demo.experiment(), ("fast", "slow"))


@pytest.mark.slow
@pytest.mark.exhaustive  # a minute each
@pytest.mark.parametrize(
    ("plant", "name"),
    [
        ("braid", "friction of a braid"),
        ("lugre", "LuGre"),
        ("pinched", "pinched Bouc-Wen"),
        ("ageing", "contacts that age"),
        ("maxwell-slip", "Maxwell slip"),
        ("dahl", "Dahl"),
        ("none", "without hysteresis"),
    ],
)
def test_every_row_of_the_readme_is_that_of_its_command(plant, name):
    result = demo.experiment(plant, TRIALS)
    readme_row_is_that_of(name, result, TRIALS)


@pytest.mark.slow  # beside the test above: one process runs the demo for both
def test_every_key_of_the_reproduction_is_documented():
    found = demo.experiment().plants[demo.PLANT].figures[0]
    keys = {key for key in keys_of(found) if not key.isdigit() and " " not in key}
    documented = set(
        re.findall(r"`([\w-]+)`", (DOCS / "reference" / "json.md").read_text(encoding="utf-8"))
    )
    assert not keys - documented
    assert len(keys) > 25


def test_every_parameter_is_in_the_reference_and_the_plants_are_on_its_page():
    from dehyst_robot.arm import sources

    page = (DOCS / "reference" / "parameters.md").read_text(encoding="utf-8")
    plant = (DOCS / "explanation" / "the-plant.md").read_text(encoding="utf-8")
    assert len(sources()) > 150
    for key in sources():
        table, _, name = key.rpartition(".")
        assert f"\n## {table}\n" in page
        assert re.search(rf"(?ms)^## {re.escape(table)}$.*?^\| `{name}` \|", page), key
        assert table.partition(".")[0] not in parameters.PLANT or f"| `{key}` |" in plant
    assert re.findall(r"(?m)^- \[(\d+)\]", page) == [str(n) for n in range(1, 19)]


def test_a_sensitivity_table_of_another_sweep_is_refused(tmp_path, monkeypatch):
    lines = sensitivity.RESULT.read_text(encoding="utf-8").splitlines(keepends=True)
    other = tmp_path / "other.csv"
    other.write_text("".join(lines[:-1]), encoding="utf-8")
    monkeypatch.setattr(sensitivity, "RESULT", other)
    with pytest.raises(ValueError, match="dehyst sweep"):
        sensitivity.table()


def test_a_page_without_a_place_for_its_generated_part_is_refused():
    page = "a <!-- x: generated by docs/build.py -->\n{}\n<!-- end of x --> b"
    assert build.with_part(page.format("old"), "x", "new") == page.format("new")
    with pytest.raises(ValueError, match="no place"):
        build.with_part("nothing", "x", "new")


def run_example(name: str, folder: Path) -> str:
    done = subprocess.run(
        [sys.executable, ROOT / "examples" / name],
        capture_output=True,
        text=True,
        cwd=folder,
        env=os.environ,
        timeout=600,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert not done.stderr
    return done.stdout


def test_no_page_shows_a_command_that_was_not_found():
    shown = [
        name_of(page) for page in PAGES if "dehyst: not found" in page.read_text(encoding="utf-8")
    ]
    assert not shown, f"build these with .venv/bin on the path: {', '.join(shown)}"


def test_examples_are_short():
    scripts = list((ROOT / "examples").glob("*.py"))
    assert len(scripts) >= 2
    assert all(len(path.read_text(encoding="utf-8").splitlines()) < 75 for path in scripts)


def test_the_example_of_a_real_time_loop_shows_that_the_compensator_helps():
    page = (DOCS / "how-to" / "use-the-compensator.md").read_text(
        encoding="utf-8"
    )  # run by the test of its page
    shown = next(
        step.shown
        for step in blocks.steps(page)
        if step.code.startswith("python examples/real_time_loop.py")
    )
    rms = [float(number) for number in re.findall(r"([\d.]+) um with", shown)]
    assert len(rms) == 4
    assert rms[1] < 0.2 * rms[0]
    assert rms[3] < 0.5 * rms[2]


def test_the_example_of_firmware_shows_what_compensator_and_feedback_each_leave():
    page = (DOCS / "how-to" / "run-on-a-microcontroller.md").read_text(
        encoding="utf-8"
    )  # run by the test of its page
    shown = next(
        step.shown
        for step in blocks.steps(page)
        if step.code.startswith("make -s -C examples/firmware") and "FAMILY=" in step.code
    )
    line, feedback, compensator, both = (
        float(number) for number in re.findall(r"([\d.]+) um rms", shown)
    )
    assert both < compensator < feedback < line
    assert compensator < 0.2 * line and both < 0.2 * feedback


@pytest.mark.slow
def test_the_example_of_identification_checks_itself(tmp_path):
    printed = run_example("identify_and_compensate.py", tmp_path)
    assert "good for compensation" in printed
    assert "same output: True" in printed
    assert float(re.search(r"wanted: (\S+) deg", printed)[1]) < 1e-9
    assert not list(tmp_path.iterdir())
