"""How a joint learns, while it runs, what its muscles need besides what was identified."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields

from dehyst.errors import ParameterError
from dehyst.models.arrays import parameter_number

LEAST_NOISE = 1e-6  # its square is a number in single precision, too


@dataclass(frozen=True)
class Adaptation:
    r"""Projected, normalised gradient for the scales of a direct inverse's groups, and how contact is fed back.

    .. math::

        e = Q_{obs} - \Bigl(c + o + \sum_g \theta_g \varphi_g\Bigr), \qquad
        \theta_g \leftarrow \Pi\Bigl[\theta_g + \mu\,\frac{e\,\varphi_g}{\epsilon^2 + u^2 + \sum \varphi^2}\Bigr],
        \qquad \mu = rate \cdot T

    :math:`Q_{obs}` is the torque that the observer sees beyond the known load, :math:`\varphi_g` what each group of the
    model gives at the measured angle, as late as the observer sees it. Scales stay within lowest..highest and the
    offset within its limit whatever is measured: weights stay >= 0, so that the compensator stays invertible. What was
    learned is in use while its squared error over the last `memory` is smaller than that of the identified model.

    Parameters
    ----------
    rate
        Share of an error that a second of full excitation takes away; 0 switches learning off. [1/s]
    memory
        Over which errors are compared; learned values come into use as slowly. [s]
    noise
        epsilon: size of a torque that teaches nothing. [Nm]
    dead_zone
        Errors below teach nothing. [Nm]
    most_error
        Errors beyond are contact and teach nothing until they are over, unless such errors are usual. [Nm]
    contact_ratio
        An error is usual below so many times the rms of those over the last `memory`, contact left out. 0: none is.
    first_error
        That rms at first, before anything was seen. [Nm]
    patience
        Over which what looks like contact and does not end becomes usual, and is learned: a hysteresis that changed,
        a load that stays. With a ratio c it takes some 2 patience/(c^2 - 1) times the logarithm of how many times too
        large the error is. [s]
    rest
        Without learning after contact. [s]
    lowest, highest
        Of every scale, lowest <= 1 <= highest.
    offset_limit
        Of the learned offset; 0: none. [Nm]
    unit
        u: size that the offset has as a signal beside those of the groups. [Nm]
    most_acceleration
        Of the reference: beyond, what is wrong with the nominal inertia would be learned as hysteresis. [rad/s^2]
    least_speed
        Of the reference under position control: below, a drift at rest would be learned as hysteresis. [rad/s]
    disturbance_pole
        Of the feedback of the contact torque, switched by ``SWITCHES["disturbance"]``. [1/s]

    Raises
    ------
    ParameterError
        If a number is not finite, `noise` is below 1e-6 Nm, or scales could become negative.

    Examples
    --------
    >>> Adaptation(rate=0.5).highest
    2.0
    """

    rate: float = 0.3
    memory: float = 5.0
    noise: float = 0.3
    dead_zone: float = 0.0
    most_error: float = 0.5
    contact_ratio: float = 4.0
    first_error: float = 1.0
    patience: float = 120.0
    rest: float = 1.0
    lowest: float = 0.0
    highest: float = 2.0
    offset_limit: float = 2.0
    unit: float = 1.0
    most_acceleration: float = 0.5
    least_speed: float = 0.002
    disturbance_pole: float = 5.0

    def __post_init__(self) -> None:
        for entry in fields(self):
            object.__setattr__(self, entry.name, parameter_number(getattr(self, entry.name), entry.name))
        if not 0 <= self.lowest <= 1 <= self.highest:
            raise ParameterError(
                f"scales from {self.lowest:g} to {self.highest:g}: they begin at 1 and a negative one would drive "
                f"motion instead of opposing it. Pass 0 <= lowest <= 1 <= highest."
            )
        if not self.noise >= LEAST_NOISE:
            raise ParameterError(
                f"noise = {self.noise:g} Nm is too small: without signal errors would be divided by nothing. Pass "
                f"{LEAST_NOISE:g} Nm or more; 0.3 Nm is usual."
            )
        free = ("noise", "lowest", "highest")
        for name in (entry.name for entry in fields(self) if entry.name not in free):
            if getattr(self, name) < 0:
                raise ParameterError(f"{name} = {getattr(self, name):g} must not be negative.")

    def as_dict(self) -> dict[str, float]:
        """Return the values by the names of the core."""
        return asdict(self)


OFF = Adaptation(rate=0.0)
