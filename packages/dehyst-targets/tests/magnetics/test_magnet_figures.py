"""Figures of a core: textbook loops, units, and logs that are no loop."""

import numpy as np
import pytest

from dehyst import PrandtlIshlinskii
from dehyst.data import Recording
from dehyst.errors import ColumnError, ExcitationError, RecordingError
from dehyst_targets.magnetics import core_of, read_core

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
