"""dehyst compare: all families see the same samples, and the verdict is on those that none has seen."""

import json
import re
import sys
from dataclasses import dataclass, replace
from types import ModuleType

import numpy as np
import pytest

from dehyst import Recording, compare, identify, load
from dehyst.errors import ExcitationError, ParameterError
from dehyst.families import UNSCALED, Family, LoopModel, Scaling
from dehyst.families import _registry as registry
from dehyst.identification import _comparison as comparison
from dehyst.identification import _prepared as prepared_logs
from dehyst.identification import _scores as scores
from dehyst.identification import all_names
from dehyst.io import example_recording
from dehyst.models import ModelCard, PrandtlIshlinskii
from dehyst.models._card import NO_CARD
from places import DATA

LOGS = {
    "pam_wrist_joint": ("pressure_mpa", "angle_deg", ()),
    "pneumatic_arm_segment": (
        "pressure_interp_psi",
        "tilt_rad",
        ("--from", "12", "--run", "oct28_exp1"),
    ),
    "cavatappi_muscle": ("pressure_psi", "displacement_mm", ("--run", "200g_s2_t1")),
    "tendon_sheath_joint": ("angle_cmd_deg", "angle_deg", ("--run", "conf0_50")),
    "piezo_dbo": ("voltage_v", "displacement_um", ("--from", "2", "--run", "model")),
    "mr_damper": ("displacement_mm", "force_N", ("--run", "ensaio1.2")),
}


@pytest.fixture(scope="module")
def lagging():
    t = np.linspace(0.0, 60.0, 1500)
    x = 2.0 * np.sin(t) * np.linspace(1.0, 0.3, t.size) + 0.5
    truth = PrandtlIshlinskii([0.0, 0.3, 0.8], [0.7, 0.4, 0.3])
    return Recording(
        input=x,
        output=truth.simulate(x) + np.random.default_rng(1).normal(0.0, 0.005, t.size),
        time=t,
    )


@pytest.fixture(scope="module")
def found(lagging):
    return compare(lagging)


@pytest.mark.slow
def test_every_family_has_a_row_with_an_error_or_a_reason(found):
    # The best row is one of the rows, and this loop no butterfly.
    wanted = set(all_names()) - {"elements", "butterfly"}
    assert {entry.family for entry in found.entries} == wanted
    for entry in found.entries:
        assert entry.model is not None or entry.reason
        assert entry.invertible or entry.no_inverse or entry.reason


@pytest.mark.slow
def test_rows_are_in_the_order_of_their_held_out_error(found):
    # Six digits: below that rounding decides between sums that are the same.
    errors = [float(f"{entry.error_percent:.6g}") for entry in found.entries]
    assert errors == sorted(errors)
    assert found.chosen is found.entries[0]


@pytest.mark.slow
def test_the_chosen_family_is_never_worse_than_what_identify_chooses(found, lagging):
    auto = identify(lagging)
    assert found.auto.family == auto.family
    assert found.auto_entry.test.rmse == pytest.approx(auto.test.rmse, rel=1e-12)
    assert found.chosen.test.rmse <= auto.test.rmse


@pytest.mark.slow
def test_a_row_says_what_a_separate_scoring_of_its_predictions_says(found, lagging):
    mask = found.masks[0]
    for entry in found.entries:
        if entry.model is not None:
            error = entry.fit.predictions[0][mask] - lagging.output[mask]
            assert entry.test.rmse == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-9)
            assert entry.test.max == pytest.approx(np.abs(error).max(), rel=1e-9)


def fitted_half_is_the_same(table, lagging, families=None):
    """Whether other values in the held-out half change no model, so no prediction of the fitted half."""
    half = len(lagging) // 2
    y = lagging.output.copy()
    y[half:] = 0.3 * y[half:] + 0.2
    other = compare(replace(lagging, output=y), families)
    for entry in table.entries:
        if entry.model is not None:
            np.testing.assert_array_equal(
                entry.fit.predictions[0][:half],
                other[entry.family].fit.predictions[0][:half],
                err_msg=entry.family,
            )


@pytest.mark.slow
def test_no_family_sees_the_held_out_samples(found, lagging):
    fitted_half_is_the_same(found, lagging)


def test_the_quickest_families_do_not_see_the_held_out_samples(lagging):
    quickest = ["static", "pi", "dahl"]
    fitted_half_is_the_same(compare(lagging, quickest), lagging, quickest)


@pytest.mark.exhaustive
def test_the_curve_is_fitted_and_scored_once_for_all_families(lagging, monkeypatch):
    made = []
    for module, name in ((scores, "_baseline"), (prepared_logs, "best_curve")):
        monkeypatch.setattr(module, name, counted(getattr(module, name), made))
    table = compare(lagging, ["pi", "stop", "static", "play-sum", "dahl"])
    assert sorted(made) == ["_baseline", "best_curve"]
    curve = identify(lagging, "pi").static_test
    for entry in table.entries:
        assert entry.fit.static_test == curve


def counted(function, names):
    """The function, which notes its name at each call."""

    def noting(*arguments):
        names.append(function.__name__)
        return function(*arguments)

    return noting


@pytest.mark.parametrize("seed", [-1, 0.5, None, True])
def test_a_seed_is_a_whole_number(lagging, seed):
    with pytest.raises(ParameterError, match="seed"):
        compare(lagging, ["static"], seed=seed)


@pytest.mark.slow
def test_ties_are_those_whose_difference_drowns_in_the_scatter(lagging):
    found = compare(lagging, ["pi", "pi-cumulative", "static"])
    assert found.chosen.tied
    assert found["pi"].tied and not found["static"].tied


@pytest.mark.slow
def test_no_exportable_row_is_smaller_and_better_than_one_of_the_front(lagging):
    comparison = compare(
        lagging, ["pi", "pi-cumulative", "modified-pi", "static", "dahl", "play-sum"]
    )
    front = comparison.front
    assert front and list(front) == sorted(front, key=lambda entry: -entry.error_percent)
    for entry in front:
        assert entry.exportable and entry.error_percent < comparison["static"].error_percent
        for other in comparison.rows:
            if other.exportable and other.parameters <= entry.parameters:
                assert other.error_percent >= entry.error_percent
    assert comparison.as_dict()["front"] == [entry.family for entry in front]


@pytest.mark.slow
def test_a_handful_of_held_out_samples_is_not_called_loops(lagging):
    found = compare(lagging, ["pi", "static"], train_fraction=0.999)
    assert found.masks[0].sum() < 5
    assert "too few to tell models apart" in found.verdict and "loops" not in found.verdict
    assert "on held-out loops" in compare(lagging, ["pi", "static"]).verdict


def test_a_reason_names_the_direction_of_the_loop():
    x = np.sin(np.linspace(0.0, 60.0, 1500)) * np.linspace(1.0, 0.4, 1500)
    y = 1.5 * x - PrandtlIshlinskii([0.0, 0.4], [0.2, 0.8]).simulate(x)
    found = compare(Recording(input=x, output=y), ["pi", "stop"])
    assert "clockwise" in found["pi"].reason
    assert "clockwise" not in found["stop"].reason


def test_unknown_names_and_dead_signals_are_refused_with_the_cure(lagging):
    with pytest.raises(ParameterError, match="There are: static, pi"):
        compare(lagging, ["prandtl"])
    with pytest.raises(ParameterError):
        compare(lagging, [])
    with pytest.raises(ExcitationError):
        compare(Recording(input=np.ones(100), output=np.arange(100.0)))


@pytest.mark.slow
def test_a_progress_callback_is_told_of_every_family(lagging):
    told = []
    compare(lagging, ["pi", "static"], progress=lambda *what: told.append(what))
    assert told == [("pi", 0, 2), ("static", 1, 2)]


# A toy family: one file, one line of registration.


@dataclass(frozen=True, repr=False)
class Backlash(LoopModel):
    """y = (1 - w) x + w P_r[x]: one play operator beside a line."""

    radius: float = 0.2
    weight: float = 0.5
    scaling: Scaling = UNSCALED
    start: str = "rest"
    card: ModelCard = NO_CARD
    family = "backlash"
    free_parameters = 2
    no_inverse = ""

    def rest(self, x):
        return np.array([x])

    def run(self, x, dt, memory):
        z, y = memory[0], np.empty(x.size)
        for k, value in enumerate(x):
            z = max(value - self.radius, min(value + self.radius, z))
            y[k] = (1.0 - self.weight) * value + self.weight * z
        return y, np.array([z])


def fit_backlash(training):
    tried = [
        Backlash(r, w, training.scaling) for r in (0.1, 0.2, 0.3, 0.4) for w in (0.3, 0.5, 0.7)
    ]
    return training.best_start(training.thinned(300).best(tried))


@pytest.fixture
def registered(monkeypatch):
    module = ModuleType("backlash_of_a_user")
    module.FAMILY = Family(
        "backlash", "Backlash", Backlash, fit_backlash, convex=False, source="this test"
    )
    monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.setitem(registry.MODULES, "backlash", module.__name__)


@pytest.mark.slow
def test_a_new_family_needs_one_module_and_one_line(registered, lagging):
    x = lagging.input
    truth = Backlash(0.3, 0.5, Scaling(float(x.mean()), 2.0, 3.0, 7.0), "zero")
    record = Recording(input=x, output=truth.simulate(x))
    found = compare(record, ["pi", "backlash"])
    assert found["backlash"].test.rmse_percent < 2.0
    assert found["backlash"].invertible and found["backlash"].inverse_percent < 4.0
    fit = identify(record, "backlash")
    assert (fit.model.radius, fit.model.weight) == (
        found["backlash"].model.radius,
        found["backlash"].model.weight,
    )
    assert fit.test.rmse == found["backlash"].test.rmse
    np.testing.assert_allclose(fit.model.inverse().simulate(fit.model.simulate(x)), x, atol=1e-9)


@pytest.fixture(scope="module")
def log(tmp_path_factory, lagging):
    path = tmp_path_factory.mktemp("compare") / "log.csv"
    rows = np.column_stack([lagging.time, lagging.input, lagging.output])
    np.savetxt(
        path, rows, delimiter=",", header="time_s,pressure_bar,angle_deg", comments="", fmt="%.9g"
    )
    return path


SIGNALS = ("--input", "pressure_bar", "--output", "angle_deg")


@pytest.mark.slow
def test_the_command_prints_a_table_draws_a_picture_and_a_page(run, log, tmp_path):
    page, picture = tmp_path / "families.html", tmp_path / "families.svg"
    chosen = ("--families", "pi,modified-pi,static", "--report", page, "--figure", picture)
    status, out, _ = run("compare", log, *SIGNALS, *chosen)
    assert status == 0 and "held out" in out and "next: dehyst identify" in out
    assert (
        page.read_text().startswith("<!DOCTYPE html>")
        and "Every family on this log" in page.read_text()
    )
    assert "<svg" in picture.read_text()
    assert run("compare", log, *SIGNALS, *chosen)[0] == 0  # its own files may be drawn anew


@pytest.mark.slow
def test_the_table_fits_eighty_columns_with_whole_names_and_says_where_there_is_no_inverse(
    run, log, monkeypatch
):
    monkeypatch.setenv("COLUMNS", "80")
    status, out, _ = run(
        "compare",
        log,
        *SIGNALS,
        "--families",
        "krasnoselskii-pokrovskii,generalised-bouc-wen,lugre",
    )
    assert "p in Python only" in out and not re.search(
        r"(?m)^krasnoselskii-pokrovskii( \*)? p ", out
    )
    assert re.search(r"(?m)^generalised-bouc-wen( \*)? p ", out) and re.search(
        r"(?m)^lugre( \*)? p ", out
    )
    table = [
        line.replace(" *", "").replace(" p ", "").split()
        for line in out.splitlines()
        if re.match(r"\S+ (\* )?.* \d+\.\d\d$", line)
    ]
    rows = {row[0]: row[1:] for row in table}
    assert status == 0 and "…" not in out
    assert set(rows) == {"krasnoselskii-pokrovskii", "generalised-bouc-wen", "lugre"}
    assert all(len(cells) == 5 for cells in rows.values()) and rows["lugre"][2] == "none"


@pytest.mark.slow
def test_a_rival_that_was_left_out_and_errs_less_is_said_so(lagging):
    found = compare(lagging, ["static"])
    assert f"smallest error, {found.chosen.error_percent:.3g} %" in found.verdict
    assert "among those compared" in found.verdict and "against" not in found.verdict


@pytest.mark.parametrize("family", ["dahl", "pi", "direct-inverse"])
def test_the_saved_model_of_any_family_simulates_and_compensates(run, log, tmp_path, family):
    model, there, back = tmp_path / "m.json", tmp_path / "y.csv", tmp_path / "x.csv"
    status, out, err = run("compare", log, *SIGNALS, "--families", family, "--save", model)
    assert status == 0 and "dehyst compensate" in out, err
    assert run("simulate", model, log, "--input", "pressure_bar", "--out", there)[0] == 0
    assert run("compensate", model, log, "--output", "angle_deg", "--out", back)[0] == 0
    x = np.loadtxt(back, delimiter=",", skiprows=1)
    y = np.loadtxt(there, delimiter=",", skiprows=1)
    data = np.loadtxt(log, delimiter=",", skiprows=1)
    late = slice(len(data) // 2, None)
    assert np.sqrt(np.mean((x[late, 2] - data[late, 1]) ** 2)) < 0.05 * np.ptp(data[:, 1])
    assert np.sqrt(np.mean((y[late, 2] - data[late, 2]) ** 2)) < 0.05 * np.ptp(data[:, 2])


@pytest.mark.slow
def test_a_damaged_file_of_a_family_is_refused(run, log, tmp_path):
    model = tmp_path / "m.json"
    assert run("compare", log, *SIGNALS, "--families", "dahl", "--save", model)[0] == 0
    status, _, err = run("export", model, "--target", "c", "--out", tmp_path / "c")
    assert status == 2 and "dahl" in err
    content = json.loads(model.read_text())
    content["parameters"]["values"]["weights"] = [9.0]
    model.write_text(json.dumps(content))
    for line in (
        ("simulate", model, log, "--input", "pressure_bar"),
        ("export", model, "--target", "c"),
    ):
        status, _, err = run(*line, "--out", tmp_path / "c")
        assert status == 2 and "checksum" in err


@pytest.mark.parametrize("name", registry.names())
def test_every_family_survives_its_file_bit_for_bit(name, tmp_path):
    model = registry.example(name)
    path = model.save(tmp_path / "m.json")
    again = load(path)
    x = np.sin(np.linspace(0.0, 20.0, 300))
    t = np.linspace(0.0, 20.0, 300)
    assert again.parameters() == model.parameters() and again.start == model.start
    np.testing.assert_array_equal(again.simulate(x, t), model.simulate(x, t))


def test_json_has_a_row_for_each_family(run, log):
    result = json.loads(run("compare", log, *SIGNALS, "--families", "pi,static", "--json")[1])
    assert set(result["families"]) == {"pi", "static"}
    row = result["families"]["pi"]
    assert {"test", "seconds", "parameters", "invertible"} <= set(row)
    assert (
        row["test"]["rmse_percent"] > 0.0
        and isinstance(row["parameters"], int)
        and row["invertible"] is True
    )
    assert result["chosen"] == "pi"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((*SIGNALS, "--families", "prandl"), "names no family"),
        (("--input", "presure_mbar", "--output", "angle_deg"), "pressure_bar"),
        ((*SIGNALS, "--figure", "families.pdf"), ".svg"),
        ((*SIGNALS, "--report", "nowhere/families.html"), "Make it first"),
    ],
    ids=["family", "column", "picture", "folder"],
)
def test_bad_requests_end_with_a_cure_before_any_work(run, log, arguments, words):
    status, _, err = run("compare", log, *arguments)
    assert status == 2
    assert words in err


@pytest.mark.exhaustive
@pytest.mark.skipif(not DATA.is_dir(), reason="measured logs are not there")
@pytest.mark.parametrize("name", LOGS)
def test_on_measured_logs_the_chosen_family_is_at_least_as_good_as_auto(run, name):
    x, y, more = LOGS[name]
    result = json.loads(
        run("compare", DATA / name / "data.csv.gz", "--input", x, "--output", y, *more, "--json")[1]
    )
    best = result["families"][result["chosen"]]
    assert best["test"]["rmse"] <= result["auto"]["test"]["rmse"]


@pytest.mark.slow
def test_a_narrow_terminal_cuts_no_name_of_a_family(run, log, monkeypatch):
    monkeypatch.setenv("COLUMNS", "60")
    _, out, _ = run("compare", log, *SIGNALS, "--families", "krasnoselskii-pokrovskii,pi")
    assert any(line.startswith("krasnoselskii-pokrovskii") for line in out.splitlines())


@pytest.mark.slow
def test_a_family_is_as_large_in_compare_as_identified_by_its_name():
    """identify --family full-sum said "208 of 208 terms", auto "105 of 317 terms" of the same model."""
    record = example_recording()
    rows = compare(record, ["creep-pi", "dahl"])
    for name in ("creep-pi", "dahl"):
        fit = identify(record, name)
        assert (
            fit.size == f"{rows[name].parameters} parameters"
            and f"{name}, {fit.size}: " in fit.verdict
        )


@pytest.mark.slow
def test_the_inverse_of_the_curve_errs_as_much_in_compare_as_in_identify():
    """The inverse of a curve asks for inputs beyond the range; compare did not keep them within it."""
    t = np.linspace(0.0, 60.0, 1200)
    x = np.sin(t) * np.linspace(0.7, 1.0, t.size)
    y = PrandtlIshlinskii([0.0, 0.8], [1.0, 8.0]).simulate(x)
    found = compare(Recording(input=x, output=y, time=t), ["static", "pi"])
    row = next(option for option in found.auto.table if option.family == "static")
    asked = found.auto.static.inverse().simulate(y)
    assert np.ptp(asked) > 1.005 * np.ptp(x), (
        "the curve asks for nothing beyond the range, and nothing is tested"
    )
    assert found["static"].inverse_percent == pytest.approx(row.input_percent, rel=1e-12)


@pytest.mark.slow
def test_errors_that_differ_are_not_printed_as_the_same_number():
    """It said "0.09 % of range rms, against 0.09 %"."""
    found = compare(example_recording(), ["pi", "modified-pi"])

    def errs(entry, percent):
        return replace(entry, test=replace(entry.test, rmse_percent=percent))

    entries = (errs(found["modified-pi"], 0.0931), errs(found["pi"], 1.0))
    close = replace(found, entries=entries, auto_entry=errs(found.auto_entry, 0.0942))
    assert (
        "0.0931 % of range rms" in close.verdict and "against 0.0942 % of full-sum" in close.verdict
    )


@pytest.mark.slow
def test_one_model_under_two_names_is_listed_once_and_says_the_other_name():
    x = 2.0 * np.sin(np.linspace(0.0, 60.0, 1200)) * np.linspace(1.0, 0.3, 1200)
    y = PrandtlIshlinskii([0.0, 0.3, 0.8], [1.0, 0.4, 0.3]).simulate(x)
    record = Recording(input=x, output=y, time=0.01 * np.arange(x.size))
    twice = compare(record, ["static", "pi"])
    marked = comparison._named_once(
        [twice["pi"], replace(twice["pi"], family="twin"), twice["static"]]
    )
    assert [entry.same_as for entry in marked] == ["", "pi", ""]
    found = replace(twice, entries=tuple(marked))
    assert [entry.family for entry in found.rows] == ["pi", "static"]
    assert ("twin", "the same model here as pi") in found.notes and "twin" not in found.verdict
    assert found["twin"].same_as == "pi" and set(found.as_dict()["families"]) == {
        "pi",
        "twin",
        "static",
    }
