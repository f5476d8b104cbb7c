"""What auto leaves out is said; a period far from the log's is no silent guess; compensators begin at rest."""

import pytest

import dehyst
from dehyst.errors import ParameterError
from dehyst.io import example_recording


@pytest.fixture(scope="module")
def log() -> dehyst.Recording:
    return example_recording()


def codes(fit: dehyst.Fit) -> set[str]:
    return {finding.code for finding in fit.warnings}


def test_a_setting_of_plays_tells_that_auto_looked_at_plays_only(log: dehyst.Recording) -> None:
    told = next(f.message for f in dehyst.identify(log, n=40).warnings if f.code == "plays-only")
    assert "(n)" in told
    assert "leave those settings out" in told


@pytest.mark.slow
def test_usual_settings_and_families_by_name_do_not(log: dehyst.Recording) -> None:
    assert "plays-only" not in codes(dehyst.identify(log, n=100, eps="auto"))
    assert "plays-only" not in codes(dehyst.identify(log, "modified-pi", n=40))


def test_an_unknown_setting_is_named_with_those_there_are(log: dehyst.Recording) -> None:
    with pytest.raises(ParameterError, match="eps_: no such setting; they are n, eps"):
        dehyst.identify(log, eps_=3)


def test_a_period_of_milliseconds_given_as_seconds_is_told(log: dehyst.Recording) -> None:
    model = dehyst.identify(log, "inverse-stop").model
    assert model.rate_dependent
    assert model.period == pytest.approx(0.02)
    with pytest.warns(
        UserWarning, match="a period of 20 s is 1e\\+03 times that of the log, 0.02 s"
    ):
        model.stepper(20.0)
    with pytest.warns(UserWarning, match="Give it in seconds"):
        dehyst.block(model, period=20.0)


@pytest.mark.filterwarnings("error")
def test_a_loop_faster_or_a_little_slower_than_the_log_is_fine(log: dehyst.Recording) -> None:
    model = dehyst.identify(log, "inverse-stop").model
    for period in (0.001, 0.1, None):
        model.stepper(period)
        dehyst.block(model, period=period)


def test_a_period_that_is_none_is_refused_by_its_name(log: dehyst.Recording) -> None:
    model = dehyst.identify(log, "inverse-stop").model
    for wrong in ("a", -1.0, float("nan"), [0.1]):
        with pytest.raises(ParameterError, match="period"):
            dehyst.block(model, period=wrong)  # type: ignore[arg-type]
