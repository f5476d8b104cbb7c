"""Figures of runs, nested as ``--json`` shows them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from dehyst.evaluation import Timed, iso9283
from dehyst.experiments.results import JointIdentification, TrialRun


def joint_figures(run: TrialRun, number: int) -> dict[str, float]:
    """Root mean square and largest error of a joint over a run. [deg]"""
    error = np.degrees(run.error[:, number - 1])
    return {"rms_deg": float(np.sqrt(np.mean(error**2))), "max_deg": float(np.abs(error).max())}


def plant_figures(
    identifications: Mapping[str, Mapping[int, JointIdentification]],
    runs: Iterable[TrialRun],
    motions: Mapping[str, Timed],
    joints: Iterable[int],
) -> dict[str, Any]:
    """Everything measured on one plant with one seed.

    Parameters
    ----------
    identifications
        Compensator -> joint number -> identification; the last one is the one that is explained.
    runs
        Trials, off and on.
    motions
        Trial -> its command motion.
    joints
        Joints whose errors are listed.
    """
    found = trial_figures(runs, motions, joints)
    for number in joints:
        told = {name: _identification(one[number]) for name, one in identifications.items()}
        first = {"identification": [*told.values()][-1], "identifications": told}
        found["joints"][str(number)] = first | found["joints"][str(number)]
    return found


def trial_figures(runs: Iterable[TrialRun], motions: Mapping[str, Timed], joints: Iterable[int]) -> dict[str, Any]:
    """Errors of joints and tool in all runs; parameters as for `plant_figures`."""
    listed: dict[str, Any] = {str(number): {"trials": {}} for number in joints}
    tool: dict[str, Any] = {}
    for run in runs:
        for number, one in listed.items():
            one["trials"].setdefault(run.trial, {})[run.compensator] = joint_figures(run, int(number))
        tool.setdefault(run.trial, {})[run.compensator] = iso9283(
            motions[run.trial], run.time, run.tool, run.cycle, run.figure
        )
    return {"joints": listed, "tool": tool}


def _identification(found: JointIdentification) -> dict[str, Any]:
    return {
        "nonzero_weights": found.nonzero_weights,
        "inverse_rms_ratio_unseen": found.inverse_rms_ratio,
        "unexplained_unseen": found.unexplained,
        "accepted": found.accepted,
        "calibration_residual_Nm": found.characteristic.residual,
    }
