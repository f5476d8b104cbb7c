"""block(): a model of any family as a function block, for real-time use and export."""

from __future__ import annotations

import warnings

from dehyst.models import Block, Model
from dehyst.models import kit as models_kit


def block(
    model: Model,
    direction: models_kit.Direction = "inverse",
    *,
    period: float | None = None,
    range: tuple[float, float] | None = None,
    ramp: int = 500,
    follow_offset: float | None = None,
) -> Block:
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
        there is none. Steps and runs are then given what was "measured" besides.

    Returns
    -------
    block : Block

    Raises
    ------
    ParameterError
        If no target can run such a model, or a setting makes no sense.
    InvertibilityError
        If an inverse is asked for and the model has none.

    Examples
    --------
    >>> import dehyst
    >>> from dehyst.io import example_recording
    >>> model = dehyst.identify(example_recording()).model
    >>> compensator = dehyst.block(model, range=(-4.0, 4.0), ramp=50)
    >>> [round(compensator.step(angle), 2) for angle in (0.0, 10.0, 90.0, float("nan"))]
    [-0.06, 1.45, 4.0, 4.0]
    """
    models_kit.require_model(model, "fit.model, or what dehyst.load('model.json') returns")
    new_block = Block(model, direction, range, ramp, period=period, follow_offset=follow_offset)
    # A block at a period much longer than that of the log works, but less well: a warning, no error.
    if slow := model.too_slow(new_block.period):
        warnings.warn(slow, UserWarning, stacklevel=2)
    return new_block
