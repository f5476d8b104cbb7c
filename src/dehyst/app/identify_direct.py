"""dehyst identify --family direct-inverse: its own options and columns."""

from __future__ import annotations

from typing import Any

from dehyst.app.context import schedule_of
from dehyst.app.requests import IdentifyRequest
from dehyst.app.terminal import ask_progress
from dehyst.arrays import Array
from dehyst.data.recording import Recording
from dehyst.errors import ParameterError
from dehyst.identification import Fit, identify_direct

DIRECT = "direct-inverse"


def refuse_options(request: IdentifyRequest) -> None:
    """Refuse options that say nothing to the family that was asked for."""
    direct = {
        "--creep": request.creep is not None,
        "--creep-times": request.creep_times is not None,
        "--load": request.load is not None,
        "--mean-pressure": request.mean_pressure is not None,
        "--no-position-schedule": not request.position_schedule,
    }
    forward = {
        "--n": request.n != "100",
        "--eps": request.eps is not None,
        "--thresholds": request.thresholds is not None,
        "--stream": request.stream is True,
        "--spool-dir": request.spool_dir is not None,
        "--shear": request.shear is not None,
        "--max-inverse-gain": request.max_inverse_gain is not None,
    }
    is_direct = request.family == DIRECT
    wrong = [name for name, given in (forward if is_direct else direct).items() if given]
    if not wrong:
        return
    about = (
        f"says nothing to --family {DIRECT}, whose terms are its own and which reads the log at once"
        if is_direct
        else f"belongs to --family {DIRECT}, and the family is {request.family}"
    )
    raise ParameterError(
        f"{' and '.join(wrong)} {about}. Leave it out, or choose {'another family' if is_direct else 'that family'}.",
        options=wrong,
    )


def identify_from(request: IdentifyRequest, records: list[Recording]) -> Fit:
    """Read the scheduling columns and identify."""
    runs = [(log, run) for log in request.logs for run in (request.runs or (None,))]
    given: dict[str, list[Array]] = {}
    units: dict[str, str] = {}
    with ask_progress("reading", request.json):
        for name, column in (("load", request.load), ("mean_pressure", request.mean_pressure)):
            if column is not None:
                given[name], units[name] = schedule_of(name, column, (request.time, request.time_unit), runs, records)
    signals: dict[str, Any] = dict(given)
    with ask_progress("identifying", request.json):
        return identify_direct(
            records,
            creep="auto" if request.creep is None else request.creep,
            creep_times=_times(request.creep_times),
            units=units,
            position_schedule=request.position_schedule,
            initial_state=request.initial_state,
            train_fraction=request.train_fraction,
            **signals,
        )


def _times(text: str | None) -> list[float] | None:
    if text is None:
        return None
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise ParameterError(
            f"--creep-times {text!r} is not a list of seconds; write them with commas: --creep-times 4,25,150"
        ) from None
