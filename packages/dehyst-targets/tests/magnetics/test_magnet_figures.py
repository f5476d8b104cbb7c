"""Figures of a core: textbook loops, units, and logs that are no loop."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dehyst import PrandtlIshlinskii
from dehyst.data import Recording
from dehyst.errors import ColumnError, ExcitationError, RecordingError
from dehyst.io import write_csv
from dehyst_targets.magnetics import core_of, read_core
from dehyst_targets.magnetics._loop import monotone_path

UNITS = {"input_unit": "A/m", "output_unit": "T"}


def ellipse(top_h=100.0, top_b=0.2, lag=0.3, cycles=3, time=None):
    phase = np.linspace(0.0, 2.0 * np.pi * cycles, 1000 * cycles + 1)
    return Recording(top_h * np.sin(phase), top_b * np.sin(phase - lag), time, **UNITS)


def test_an_ellipse_has_the_loss_hc_and_br_of_its_formulas():
    core = core_of(ellipse(lag=0.3, time=np.linspace(0.0, 3e-3, 3001)))
    figures = core.as_dict()
    assert figures["loss_J_per_m3"] == pytest.approx(np.pi * 100.0 * 0.2 * np.sin(0.3), rel=1e-3)
    assert figures["Hc_A_per_m"] == pytest.approx(100.0 * np.sin(0.3), rel=1e-3)
    assert figures["Br_T"] == pytest.approx(0.2 * np.sin(0.3), rel=1e-3)
    assert figures["frequency_Hz"] == pytest.approx(1000.0, rel=1e-3)
    assert figures["loss_W_per_m3"] == pytest.approx(1000.0 * figures["loss_J_per_m3"], rel=1e-3)


def test_a_rectangular_loop_has_four_hc_times_br():
    h = np.interp(np.arange(4001), [0, 1000, 3000, 4000], [0.0, 50.0, -50.0, 0.0])
    h = np.tile(h[:-1], 3)
    state, b = -1.0, np.empty(h.size)
    for k, field in enumerate(h):
        state = 1.0 if field >= 20.0 else -1.0 if field <= -20.0 else state
        b[k] = 0.35 * state
    core = core_of(Recording(h, b, **UNITS))
    assert core.loss == pytest.approx(4.0 * 20.0 * 0.35, rel=5e-3)
    assert core.hc == pytest.approx(20.0, rel=5e-3)
    assert core.br == pytest.approx(0.35, rel=1e-3)
    assert core.saturated


def test_oersted_and_gauss_give_the_same_core():
    one = ellipse()
    other = Recording(one.input * 4e-3 * np.pi, one.output * 1e4, input_unit="Oe", output_unit="G")
    for name, value in core_of(one).as_dict().items():
        if isinstance(value, float):
            assert core_of(other).as_dict()[name] == pytest.approx(value, rel=1e-9), name


@pytest.mark.parametrize(
    ("record", "error", "words"),
    [
        (Recording(ellipse().output, ellipse().input, input_unit="T", output_unit="A/m"), ColumnError, "exchanged"),
        (Recording(ellipse().input, ellipse().output), ColumnError, "--field-unit A/m"),
        (Recording(ellipse().input, 1e3 * ellipse().output, **UNITS), RecordingError, "--density-unit mT"),
        (Recording(ellipse().output, ellipse().input, **UNITS), RecordingError, "exchange --field and --density"),
        (Recording(ellipse().input, 0.0 * ellipse().input, **UNITS), RecordingError, "--density COLUMN"),
        (Recording(0.0 * ellipse().input, ellipse().output, **UNITS), RecordingError, "--field COLUMN"),
        (ellipse(lag=-0.3), RecordingError, "not in phase"),
        (ellipse(lag=2.0), RecordingError, "not in phase"),
        (Recording(np.linspace(-9.0, 9.0, 99), np.linspace(-0.1, 0.1, 99), **UNITS), ExcitationError, "no closed"),
    ],
)  # fmt: skip
def test_what_is_no_loop_is_refused_with_a_cure(record, error, words):
    with pytest.raises(error, match=words):
        core_of(record)


def test_an_offset_of_the_integrator_is_taken_out_and_said():
    shifted = ellipse()
    core = core_of(Recording(shifted.input, shifted.output + 0.07, **UNITS))
    assert "core-offset" in {finding.code for finding in core.findings}
    assert core.br == pytest.approx(core_of(shifted).br, rel=1e-3)


def test_a_loop_beside_zero_is_called_biased_and_bs_a_lower_bound():
    record = ellipse()
    core = core_of(Recording(record.input + 200.0, record.output + 0.3, **UNITS))
    assert {"core-biased", "core-unsaturated"} <= {finding.code for finding in core.findings}
    assert not core.centred
    assert not core.saturated


def test_columns_are_taken_by_their_units_then_by_their_names(tmp_path):
    record, log = ellipse(), tmp_path / "core.csv"
    rows = np.column_stack([record.output * 1e3, record.input])
    np.savetxt(log, rows, delimiter=",", header="probe [mT],coil [A/m]", comments="")
    assert read_core(log).loss == pytest.approx(core_of(record).loss, rel=1e-6)
    np.savetxt(log, rows, delimiter=",", header="B,H", comments="")
    named = read_core(log, field_unit="A/m", density_unit="mT")
    assert named.loss == pytest.approx(core_of(record).loss, rel=1e-6)
    np.savetxt(log, rows, delimiter=",", header="a,b2", comments="")
    with pytest.raises(ColumnError, match="--field"):
        read_core(log)


def test_the_loss_of_a_cycle_holds_the_small_loops_in_it():
    """A rainflow count takes small loops out of the large one; the integral of H dB of the log has them all."""
    phase = np.linspace(0.0, 6.0 * np.pi, 6001)
    h = 100.0 * np.sin(phase) + 30.0 * np.sin(9.0 * phase)
    b = PrandtlIshlinskii([0.0, 5.0, 15.0, 30.0], [1e-3, 1e-3, 1e-3, 1e-3]).simulate(h)
    core = core_of(Recording(h, b, phase, **UNITS))
    (loop,) = core.loops.largest[:1]
    part = (phase >= loop.start) & (phase <= loop.end)
    integral = np.trapezoid(h[part], core.recording.output[part])
    assert core.loss == pytest.approx(abs(integral), rel=0.02)
    assert core.inner_loss > 0.05 * core.loss


def codes(core):
    return {finding.code for finding in core.findings}


def tanh_log(noise=0.0, cycles=3, width=5.0):
    """Cycles at 50 Hz to 100 A/m of a loop with Hc 20 A/m and Bs 1.2 T, with noise of both signals."""
    time = np.arange(1000 * cycles) / 50e3
    h = 100.0 * np.sin(100.0 * np.pi * time)
    b = 1.2 * np.tanh((h - 20.0 * np.sign(np.cos(100.0 * np.pi * time))) / width)
    random = np.random.default_rng(1)
    h += 100.0 * noise * random.normal(size=h.size)
    return Recording(h, b + 1.2 * noise * random.normal(size=h.size), time, **UNITS)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("signs", [(-1.0, 1.0), (1.0, -1.0)])
@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_a_coil_connected_the_other_way_round_is_said_and_taken_with_the_other_sign(signs, noise):
    right = tanh_log(noise)
    core = core_of(Recording(signs[0] * right.input, signs[1] * right.output, right.time, **UNITS))
    assert "core-reversed" in codes(core)
    assert "core-reversed" not in codes(core_of(right))
    assert core.loss == pytest.approx(core_of(right).loss, rel=0.03)
    assert np.corrcoef(core.path)[0, 1] > 0.5


def test_noise_of_one_percent_moves_neither_bs_nor_the_frequency_nor_saturation():
    noisy, clean = core_of(tanh_log(0.01)), core_of(tanh_log())
    assert noisy.saturated and clean.saturated
    assert noisy.bs == pytest.approx(1.2, rel=0.01)
    assert noisy.frequency == pytest.approx(50.0, rel=0.005)
    assert clean.frequency == pytest.approx(50.0, rel=1e-3)
    truth = {"loss_J_per_m3": 96.0, "Hc_A_per_m": 20.0, "Br_T": 1.1992}
    for name, value in truth.items():
        interval = noisy.intervals[name]
        assert interval.low < value < interval.high, name
        assert interval.high - interval.low < 0.2 * value, name


@pytest.mark.parametrize(("noise", "every"), [(0.01, 1), (0.05, 1), (0.0, 25), (0.0, 50)])
def test_neither_noise_nor_few_samples_hide_that_a_loop_is_unsaturated(noise, every):
    record = tanh_log(noise, width=60.0)
    few = Recording(record.input[::every], record.output[::every], record.time[::every], **UNITS)
    assert not core_of(few).saturated


def test_noise_that_makes_loops_of_its_own_adds_nothing_to_the_loss():
    assert core_of(tanh_log(0.05)).loss == pytest.approx(96.0, rel=0.1)


@pytest.mark.parametrize("samples", [8, 12, 20, 1000])
def test_the_frequency_does_not_depend_on_the_samples_of_a_cycle(samples):
    record = ellipse(time=np.linspace(0.0, 0.06, 3001))
    time = np.linspace(0.0, 0.06, 3 * samples + 1)
    signals = (np.interp(time, record.time, values) for values in (record.input, record.output))
    assert core_of(Recording(*signals, time, **UNITS)).frequency == pytest.approx(50.0, rel=1e-3)


@pytest.mark.parametrize(
    ("middle", "biased"), [(0.0, False), (1.0, False), (10.0, True), (60.0, True)]
)
def test_a_field_that_swings_beside_zero_is_called_biased(middle, biased):
    record = ellipse()
    core = core_of(Recording(record.input + middle, record.output, **UNITS))
    assert ("core-biased" in codes(core)) is biased
    assert core.centred is not biased


def test_half_a_loop_is_completed_where_that_is_asked_for():
    whole = tanh_log()
    rows = slice(250, 751)
    half = Recording(whole.input[rows], whole.output[rows], whole.time[rows], **UNITS)
    with pytest.raises(ExcitationError, match="--symmetric"):
        core_of(half)
    core = core_of(half, symmetric=True)
    assert core.loss == pytest.approx(core_of(whole).loss, rel=1e-3)
    assert core.frequency == pytest.approx(50.0, rel=1e-3)


def test_of_one_cycle_no_option_of_another_command_is_named(tmp_path):
    rows, whole = slice(250, 1252), tanh_log()
    columns = {
        "time [s]": whole.time[rows],
        "H [A/m]": whole.input[rows],
        "B [T]": whole.output[rows],
    }
    core = read_core(write_csv(tmp_path / "one.csv", columns))
    assert "few-loops" not in codes(core)
    assert not any("--train" in finding.message for finding in core.findings)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 1e-3, 1e-2]), st.integers(0, 999))
def test_the_path_of_a_model_is_monotone_between_turns_and_keeps_its_area(seed, noise, start):
    phase = np.linspace(0.0, 2.0 * np.pi, 1000, endpoint=False)
    random = np.random.default_rng(seed)
    h = np.roll(np.sin(phase) + noise * random.normal(size=phase.size), start)
    b = np.roll(np.sin(phase - 0.3) + noise * random.normal(size=phase.size), start)
    path_h, path_b = monotone_path(h, b)
    if not noise:
        np.testing.assert_array_equal(path_h, h)
        np.testing.assert_array_equal(path_b, b)
    way = np.abs(np.diff(path_h, append=path_h[0])).sum()
    assert way == pytest.approx(2.0 * np.ptp(path_h), rel=1e-9)
    assert np.ptp(path_h) == pytest.approx(2.0, rel=0.02)
    area = np.trapezoid(np.append(path_h, path_h[0]), np.append(path_b, path_b[0]))
    assert area == pytest.approx(np.pi * np.sin(0.3), rel=0.02)
