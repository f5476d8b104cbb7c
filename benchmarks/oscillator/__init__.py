"""Oscillators with hysteresis from force and position: linear, Bouc-Wen, Maxwell slip, Duhem."""

from oscillator.duhem import (
    Choice,
    best,
    identify_duhem_polynomial,
    identify_duhem_table,
    rms_error,
)
from oscillator.linear import identify_linear
from oscillator.maxwell import identify_maxwell_slip
from oscillator.output_error import OutputErrorFit, fit_output_error
from oscillator.records import PeriodicRecord, average_periods
from oscillator.white_box import BoucWenFit, identify_bouc_wen

__all__ = [
    "BoucWenFit",
    "Choice",
    "OutputErrorFit",
    "PeriodicRecord",
    "average_periods",
    "best",
    "fit_output_error",
    "identify_bouc_wen",
    "identify_duhem_polynomial",
    "identify_duhem_table",
    "identify_linear",
    "identify_maxwell_slip",
    "rms_error",
]
