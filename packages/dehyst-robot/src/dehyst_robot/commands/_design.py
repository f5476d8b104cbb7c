"""`dehyst design --joint`: the motion of a joint of the simulated robot, within its own limits."""

from __future__ import annotations

from dehyst.app import Designed, DesignRequest
from dehyst.app import kit as app_kit
from dehyst.errors import UnitError
from dehyst.units import canonical, convert, dimension
from dehyst_robot.arm import load_robot
from dehyst_robot.experiments import design_joint

ANGLE = "deg"  # if nothing else is typed
BAR = 1e5  # Pa


def designed_joint(request: DesignRequest) -> Designed:
    """Return the plan of a joint of the robot, within its own limits."""
    assert request.joint is not None
    # The robot works in rad; what is typed and shown is in the unit of the user.
    unit = canonical(request.unit or ANGLE) or ""
    if dimension(unit) != "angle":
        raise UnitError(
            f"--unit {request.unit} is no unit of an angle, and joint {request.joint} turns. Type deg or rad.",
            unit=request.unit,
        )

    def si(value: float | None) -> float | None:
        if value is None:
            return None
        return float(convert(value, unit, "rad"))

    low, high = request.range or (None, None)
    limit = request.time_limit
    if limit is None:
        limit = app_kit.POLICY.usual_limit
    design = design_joint(
        load_robot(request.robot),
        request.joint,
        low=si(low),
        high=si(high),
        rate=si(request.rate),
        acceleration=si(request.acceleration),
        time_limit=limit,
        period=request.period,
        unit=unit,
        motion=app_kit.MOTIONS[request.purpose],
    )
    plan = design.plan
    # How much of the joint's own limits the motion takes.
    needs = {
        "pressure_share": design.pressure_share,
        "flow_share": design.flow_share,
        "inertia_torque_Nm": design.inertia_torque,
    }
    extra = {"nominal_pressure_difference_bar": design.difference / BAR}
    title = f"joint {design.number}, {plan.low:z.4g} to {plan.high:z.4g} {unit}"
    return Designed(plan, title, extra, needs)
