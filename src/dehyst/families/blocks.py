"""block(): the function block of a model of any family, as a machine runs it and as it is exported."""

from __future__ import annotations

import warnings
from typing import Any

from dehyst.control.block import Block
from dehyst.control.direct_block import DirectBlock
from dehyst.control.following_block import FollowingBlock
from dehyst.control.machine_block import Direction, MachineBlock
from dehyst.errors import ParameterError
from dehyst.families.element_block import ElementBlock
from dehyst.models import Model
from dehyst.models.model import require_model, too_slow_words


def block(
    model: Model,
    direction: Direction = "inverse",
    *,
    period: float | None = None,
    range: tuple[float, float] | None = None,
    ramp: int = 500,
    follow_offset: float | None = None,
) -> MachineBlock[Any]:
    """Return a model as a function block: limited to its ranges, switched without a bump, held on a sensor's fault.

    Parameters
    ----------
    model
        From the actuator's input to its output: ``fit.model``, or what `dehyst.load` returns.
    direction
        "inverse", the compensator: wanted output in, needed input out. "forward": input in, expected output out.
    period
        Between two samples of the loop; None takes that of the log. Models without creep or rate do not need it. [s]
    range
        Smallest and largest input of the actuator; None takes the range in which the model was identified. [input]
    ramp
        Samples that switching takes, at least 1.
    follow_offset
        Limit of an offset that follows what was measured over the last cycle, as a share of the output's range; None:
        there is none. Steps and runs then take what was measured behind their other inputs.

    Returns
    -------
    block : MachineBlock
        A `Block` of plays, an `ElementBlock` or a `DirectBlock`; a `FollowingBlock` around it with `follow_offset`.

    Raises
    ------
    ParameterError
        If no target can run such a model, or a setting makes no sense.
    InvertibilityError
        If an inverse is asked for and the model has none.

    Examples
    --------
    >>> import dehyst
    >>> from dehyst.experiments import example_recording
    >>> model = dehyst.identify(example_recording()).model
    >>> compensator = dehyst.block(model, range=(-4.0, 4.0), ramp=50)
    >>> [round(compensator.step(angle), 2) for angle in (0.0, 10.0, 90.0, float("nan"))]
    [-0.06, 1.45, 4.0, 4.0]
    """
    own: Any = require_model(model, "fit.model, or what dehyst.load('model.json') returns")
    if period is not None and own.too_slow(period):
        warnings.warn(too_slow_words(own, period), UserWarning, stacklevel=2)
    made = _block(own, direction, period, range, ramp)
    return made if follow_offset is None else FollowingBlock(made, follow_offset)


def _block(
    own: Any, direction: Direction, period: float | None, range: tuple[float, float] | None, ramp: int
) -> MachineBlock[Any]:
    if own.core == "plays":
        return Block(own, direction, range=range, ramp=ramp)
    if own.core == "elements":
        return ElementBlock(own, direction, period=period, range=range, ramp=ramp)
    if own.core != "direct" or direction != "inverse":
        raise ParameterError(own.no_export or f"a {own.family} model runs as its inverse only; leave direction out.")
    if period is None:
        raise ParameterError(f"a {own.family} model needs period, the seconds between two samples of your loop.")
    return DirectBlock(own, period, range, ramp)
