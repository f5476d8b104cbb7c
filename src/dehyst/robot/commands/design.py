"""`dehyst design --joint`: the motion of a joint of the simulated robot, within its own limits."""

from __future__ import annotations

from dehyst.app.design import MOTIONS, USUAL_LIMIT, Designed
from dehyst.app.requests import DesignRequest
from dehyst.errors import UnitError
from dehyst.robot.arm.parameters import load_robot
from dehyst.robot.experiments.path import design_joint
from dehyst.units import canonical, convert, dimension

ANGLE = "deg"  # if nothing else is typed
BAR = 1e5  # Pa


def designed_joint(request: DesignRequest) -> Designed:
    """Return the plan of a joint of the robot, within its own limits."""
    assert request.joint is not None
    unit = canonical(request.unit or ANGLE) or ""
    if dimension(unit) != "angle":
        raise UnitError(
            f"--unit {request.unit} is no unit of an angle, and joint {request.joint} turns. Type deg or rad.",
            unit=request.unit,
        )

    def si(value: float | None) -> float | None:
        return None if value is None else float(convert(value, unit, "rad"))

    low, high = (None, None) if request.range is None else request.range
    limit = USUAL_LIMIT if request.time_limit is None else request.time_limit
    found = design_joint(
        load_robot(request.robot), request.joint, low=si(low), high=si(high), rate=si(request.rate),
        acceleration=si(request.acceleration), time_limit=limit, period=request.period, unit=unit,
        motion=MOTIONS[request.purpose],
    )  # fmt: skip
    needs = {
        "pressure_share": found.pressure_share,
        "flow_share": found.flow_share,
        "inertia_torque_Nm": found.inertia_torque,
    }
    plan = found.plan
    extra = {"nominal_pressure_difference_bar": found.difference / BAR}
    return Designed(plan, f"joint {found.number}, {plan.low:z.4g} to {plan.high:z.4g} {unit}", extra, needs)
