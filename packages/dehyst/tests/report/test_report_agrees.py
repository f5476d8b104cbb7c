"""A report does not contradict itself: badge against lights, lights against warnings, warnings against each other."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import dehyst
import test_identification_findings as made
from dehyst.findings import Grade
from dehyst.report._judgement import curve_fits_better, in_words, lights, overall
from test_real_logs import ARM, CAVATAPPI, DAMPER, DATA, PIEZO, TENDON, WRIST

LOGS = [
    (WRIST, {}),
    (TENDON, {"run": "config_000"}),
    (PIEZO, {"run": "model", "start": 2}),
    (ARM, {"run": "oct28_exp5", "start": 12}),
    (CAVATAPPI, {"run": "200g_s3_t1"}),
    (DAMPER, {"run": "ensaio1.2"}),
]


def check(fit):
    found = lights(fit)
    by_aspect = {light.aspect: light for light in found}
    codes = [finding.code for finding in fit.warnings]
    said = " ".join(finding.message for finding in fit.warnings)
    # The badge "do not use" has a light that says why, and no light forbids what the badge allows.
    assert (overall(fit) is Grade.BAD) == (max(light.grade for light in found) is Grade.BAD), found
    # Something was held out, or nothing was.
    if fit.test is not None:
        assert "nothing can be held out" not in said and "no-held-out" not in codes
        assert "nothing was held out" not in by_aspect["Unseen data"].reason
    # One motion that tells more is planned, over one range; what forbids compensation is named.
    planned = re.findall(r"dehyst design --range \S+ \S+", said + by_aspect["The data"].reason)
    assert len({line.rstrip("`") for line in planned}) <= 1, planned
    assert "do not compensate with it" not in fit.verdict or re.search(
        r"with it \([a-z, -]+\)\.$", fit.verdict
    )
    # One reason, one warning.
    assert not {"few-loops", "never-turns"} <= set(codes)
    assert said.count("--train-fraction 1)") <= 1
    assert codes.count("few-loops") <= 1
    # What is made up is not determined, and what loses to a curve where it was fitted is not good against it.
    if "never-turns" in codes:
        assert by_aspect["Determined"].grade is Grade.BAD
    if curve_fits_better(fit):
        assert by_aspect["Against a curve"].grade is not Grade.GOOD
        assert not any("times worse" in sentence for sentence in in_words(fit, found))
    # What depends on rate or time is not denied elsewhere; loops that lead are not sent to a family of those that lag.
    data = by_aspect["The data"].reason
    assert not ("depend on rate or time" in data + said and "no dependence on" in data)
    assert not ({"clockwise", "rate-dependent"} <= set(codes) and "for loops that lag" in said)
    # All of it is fitted already.
    if fit.settings["train_fraction"] == 1.0:
        assert "fit all of it" not in said.lower()


@pytest.mark.parametrize("code", made.FIRING)
def test_of_generated_logs(code):
    make, settings, _ = made.FIRING[code]
    check(dehyst.identify(make(), **({"n": 40} | settings)))


@pytest.mark.parametrize("fraction", [None, 1.0])
@pytest.mark.parametrize("phase", [0.25, 0.75, 1.0])
def test_of_logs_of_one_loop_or_less(tmp_path: Path, phase: float, fraction: float | None):
    t = np.arange(0.0, 12.0, 0.04)
    x = np.cos(2 * np.pi * phase * t / t[-1])
    path = tmp_path / "log.csv"
    np.savetxt(path, np.column_stack([t, x, x**3]), delimiter=",", header="time_s,x,y", comments="")
    check(dehyst.identify(dehyst.read_log(path, "x", "y"), n=20, train_fraction=fraction))


@pytest.mark.slow
@pytest.mark.spread(4)
@pytest.mark.skipif(
    not (DATA / "tendon_sheath_joint" / "data.csv.gz").is_file(), reason="no measured logs"
)
@pytest.mark.parametrize("case", LOGS, ids=lambda case: case[0][0])
def test_of_measured_logs(case):
    (folder, x, y), window = case
    check(dehyst.identify(dehyst.read_log(DATA / folder / "data.csv.gz", x, y, **window)))


def test_a_curve_that_fits_better_is_said_beside_the_held_out_error():
    fit = dehyst.identify(made.clean(), n=20)
    worse = replace(fit, train=replace(fit.train, rmse=2.0 * fit.static_train.rmse))
    (light,) = (each for each in lights(worse) if each.aspect == "Against a curve")
    assert light.grade is Grade.CARE and "held out" in light.reason and "fitted" in light.reason
