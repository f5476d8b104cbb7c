"""A cure that names an option or a command is executed on the log that raised it: it removes or changes the finding."""

import ast
import re
import shlex
import sys
from itertools import pairwise

import numpy as np
import pytest

import dehyst
from cures import CURES, moved
from dehyst.design import design_excitation
from dehyst.findings import Finding
from dehyst.identification._cautions import with_reasons
from dehyst.models import DirectInverse, ModelCard, SignalCard
from places import ROOT
from test_identification_findings import rate_dependent

sys.path.insert(0, str(ROOT / "docs"))

from generate.findings import SOURCE, TEXTS, codes_in

SAID = re.compile(r"warning ([a-z-]+): (.*?)(?=\n\s*\n|\nwarning |\Z)", re.S)
NAMES_SOMETHING = re.compile(
    r"(?<![\w-])--[a-z][a-z-]+|dehyst (?:design|compare|inspect|identify|muscle|backlash|valve|magnet|battery)\b"
)
# A slice of them that takes a few seconds; the others are marked slow.
QUICK = {
    "no-time",
    "time-unit",
    "day-numbers",
    "gap",
    "memory-carried",
    "header-width",
    "drift",
    "unknown-past",
    "verdict",
}
ROWS = [
    pytest.param(
        code, row, id=f"{code}-{number}", marks=[] if code in QUICK else [pytest.mark.slow]
    )
    for code, rows in CURES.items()
    for number, row in enumerate(rows)
]


def with_each_option_once(line):
    """What a person makes of a line who adds an option that it has: the new one stands in the place of the old."""
    words = shlex.split(line)
    begins = [k for k, word in enumerate(words) if word.startswith("--")] + [len(words)]
    once = words[: begins[0]]
    for begin, end in pairwise(begins):
        if words[begin] not in words[end:]:
            once += words[begin:end]
    return shlex.join(once)


def typed(run, line):
    """Run a line; its exit status, what it printed, and its findings by code."""
    status, out, err = run(*shlex.split(line.removeprefix("dehyst ")))
    findings = SAID.findall(out) + SAID.findall(err)
    return status, out + err, {code: " ".join(message.split()) for code, message in findings}


# All of them: each is another cure.
@pytest.mark.spread(len(ROWS))
@pytest.mark.parametrize(("code", "row"), ROWS)
def test_what_a_finding_names_is_typed_and_ends_or_changes_it(
    code, row, run, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    row.write(tmp_path)
    _, printed, before = typed(run, row.line)
    assert code in before, printed
    cure = re.search(row.named, before[code])
    assert cure, before[code]
    line = row.typed.format(line=row.line, named=cure[0]).removeprefix("dehyst ")
    status, printed, after = typed(run, with_each_option_once(line))
    assert status == 0, printed
    if row.after == "runs":
        return
    if line.startswith("design"):
        moved(tmp_path, row.taus)
    if row.again:
        assert typed(run, row.again)[0] == 0
    if line.split()[0] != row.line.split()[0]:  # what it made is used as before
        after = typed(run, row.line)[2]
    if row.after == "gone":
        assert code not in after, after[code]
    else:
        assert after.get(code) != before[code]


def codes_that_name_something():
    """Codes of findings whose text, in the source or on the page, names an option or a command as a cure."""
    named = {
        code
        for entries in TEXTS.values()
        for code, (_, cure) in entries.items()
        if NAMES_SOMETHING.search(cure)
    }
    for path in SOURCE.rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        for call in ast.walk(ast.parse(text)):
            if isinstance(call, ast.Call) and getattr(
                call.func, "id", getattr(call.func, "attr", "")
            ) in (
                "Finding",
                "say",
            ):
                words = ast.unparse(call)
                if NAMES_SOMETHING.search(words):
                    named |= codes_in(words)
    return named


def test_only_starts_that_the_model_takes_are_named():
    time = np.arange(400) / 20.0
    y = np.linspace(-0.5, 0.5, 400) + 0.05 * np.sin(time)
    card = ModelCard(SignalCard("u", "", -2.0, 2.0), SignalCard("y", "", -1.0, 1.0))
    direct = DirectInverse(radii=[0.1], stop_weights=[0.5], polynomial=[0.0, 1.0], card=card)
    plays = dehyst.PrandtlIshlinskii([0.0, 0.1], [1.0, 0.5], card=card)
    record = dehyst.Recording(input=y, output=y, time=time, input_name="u", output_name="y")
    for model in (direct, plays):
        said = {
            finding.code: finding.message
            for finding in dehyst.evaluate({"m": model}, record).findings
        }
        starts = re.findall(r"--start (\w+)", said["start-counts"])[1:]
        assert starts
        for start in starts:
            assert not dehyst.evaluate({"m": model}, record, start=start)["m"].reason.startswith(
                "no output"
            )


@pytest.mark.slow
def test_every_finding_that_names_an_option_has_a_row():
    missing = codes_that_name_something() - {code for code, rows in CURES.items() if rows}
    assert not missing


def test_a_gain_that_plays_cannot_lower_without_losing_rate_is_not_cured_by_plays():
    fit = dehyst.identify(rate_dependent(), "rate-dependent-pi")
    said = {finding.code: finding.message for finding in fit.warnings}
    assert "--max-inverse-gain" not in said["high-inverse-gain"]
    assert (
        "Smooth the reference" in said["high-inverse-gain"]
        and "this log depends on" in said["high-inverse-gain"]
    )


def test_what_is_named_as_the_reason_of_a_poor_fit_is_a_finding_of_that_fit():
    poor, differs = Finding("poor-fit", "The model misses."), Finding("drift", "It drifts.")
    alone = with_reasons((poor, Finding("no-time", "No time.")))
    assert alone[0].message.startswith("The model misses. No other finding says why.")
    assert [finding.message for finding in with_reasons((differs, poor))] == [
        "It drifts.",
        "The model misses. What may be the reason: drift.",
    ]


@pytest.mark.parametrize("hold", [5.0, 80.0, 400.0])
def test_design_rests_as_long_as_was_asked_for(hold):
    plan = design_excitation(-1.0, 1.0, hold=hold, time_limit=2000.0)
    assert max(plan.hold_s) >= hold
    with pytest.raises(dehyst.DehystError) as refused:
        design_excitation(-1.0, 1.0, hold=hold, time_limit=hold)
    enough = refused.value.facts["needed"]
    try:
        plan = design_excitation(-1.0, 1.0, hold=hold, time_limit=enough)
    except dehyst.DehystError as again:
        plan = design_excitation(-1.0, 1.0, hold=hold, time_limit=again.facts["needed"])
    assert max(plan.hold_s) >= hold
