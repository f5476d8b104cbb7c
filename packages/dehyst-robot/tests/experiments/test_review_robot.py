"""Requests that would run something else than what was asked for are refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from dehyst.errors import ParameterError
from dehyst_robot.arm import load_robot
from dehyst_robot.arm._mechanisms import mechanisms_of
from dehyst_robot.experiments import Request, reproduce


@pytest.mark.parametrize(
    ("changes", "request_", "says"),
    [
        ({"joint.1.drive": "electric"}, Request(joints=(1,)), "electric"),
        ({}, Request(foreign={"mine": lambda joint, muscle: None}), "mine"),  # type: ignore[arg-type,return-value]
        ({}, Request(foreign={"dahl": lambda joint, muscle: None}), "my-dahl"),  # type: ignore[arg-type,return-value]
        ({}, Request(own=lambda found: None, compensators=("off",)), "off"),  # type: ignore[arg-type,return-value]
        ({}, Request(seeds=(1.5,)), "whole"),  # type: ignore[arg-type]
        ({}, Request(seeds=(2**64,)), "2\\*\\*32"),
    ],
)
def test_a_request_that_cannot_be_run_as_asked_is_refused_before_anything_moves(
    changes: dict[str, object], request_: Request, says: str, tmp_path: Path
) -> None:
    with pytest.raises(ParameterError, match=says):
        reproduce(load_robot(conditions="kind", changes=changes), request_, tmp_path)


def test_a_factory_that_makes_no_mechanism_is_named() -> None:
    factory: Any = lambda joint, muscle: None  # noqa: E731
    with pytest.raises(ParameterError, match="muscle 0 of joint 4"):
        mechanisms_of(factory, (4,))


def test_a_degree_that_the_controller_cannot_hold_is_refused_with_the_file() -> None:
    with pytest.raises(ParameterError, match="degree"):
        load_robot(conditions="kind", changes={"calibration.degree": 8})
