"""The thresholds by which calibrations, gains, paths and fits are judged: one record, each with its reason."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ExperimentPolicy:
    """Numbers that decide what an experiment accepts, proposes or refuses.

    Shares are between 0 and 1.
    """

    # A compensator may be switched on if it leaves at most this share of the hysteresis unexplained: 0.1 to 0.4 where
    # there is hysteresis, of 0.1 to 1 times the usual size, and 0.6 to 0.8 without.
    acceptable: float = 0.5

    # Valves or pressures that were at a limit for more than this share of the second before a failure are its cause.
    overloaded: float = 0.2
    # So many rows show that an angle stood still. [rows]
    still_rows: int = 3
    # A jump that is smaller than this comes by chance. [times the noise]
    above_noise: float = 6.0
    # A joint that ends its homing further from the middle than this share of its range was not homed.
    astray: float = 0.2
    # If more of the mean pressure is missing, that is no valve's error: the supply does not keep up. [Pa]
    missing_pressure: float = 3e4
    # A muscle may be slack below this share of the force at zero and mean pressure.
    slack: float = 0.1
    # Pressures of a sweep are stretched by no more than this to reach its angles. [factor]
    largest_stretch: float = 2.0
    # The unknown torque is at most this many times the rms residual of the calibration sweeps. [factor]
    unknown_torque: float = 3.0

    # The gain of a position loop may be so many times higher before it oscillates, 6 dB. [factor]
    gain_margin: float = 2.0
    # A command may come so much later. [s]
    delay_margin_s: float = 0.005
    # An angle that is held is quiet within this rms about its drift, four ticks of the encoder: more is oscillation.
    # [deg]
    quiet_deg: float = 0.01
    # Of a light joint, whose valves hunt, this rms is no oscillation yet. [deg]
    swing_deg: float = 0.1

    # A path may use this share of pressures and of valve flow: the rest is for the controller.
    planned_share: float = 0.85
    # Acceleration may add this share of the torque at the largest pressure difference to a log.
    inertia_share: float = 0.002
    # A path whose ends are nearer than this is closed: nobody types more digits. [deg]
    closed_deg: float = 0.01
    # Angles within this share of a joint's range, and within pi, may be radians.
    likely_radians: float = 0.15
    # Steps between rows that are no shorter may be milliseconds. [s]
    likely_milliseconds: float = 2.0
    # A step of learning that failed before is not worth a pass once it is smaller than this share.
    least_step: float = 0.2
    # A joint usually moved before within this share of the identified range.
    usual_past: float = 0.5

    # A file's number is taken to be off by this share of it, rms: what is held, and numbers to begin with.
    doubt: float = 0.5
    # Below this share of the largest force a muscle hangs loose.
    slack_force: float = 0.005
    # A number is told by no sample if its doubt changes all errors together by less, in units of theirs.
    least_effect: float = 1e-3

    # Gravity may take this share of what the muscles hold in a new file of a rig.
    gravity_share: float = 0.5
    # A joint without muscles reaches so far if nothing else is said. [deg]
    electric_reach: float = 60.0
    # Errors up to what the model missed on loops on which nothing touched the joint are its own, and are learned;
    # larger ones may be a contact. But none beyond half of the torque of a hand of 4 Nm is taken for the model's own:
    # with pinched muscles, of which the model missed 2.7 Nm, such a hand was learned. [Nm]
    most_own_error: float = 2.0
    # A contact is told if it took more than this share of a trial ...
    touched: float = 0.01
    # ... and if more came than so many times what the model missed on loops on which nothing touched the joint: its own
    # errors in trials were up to 1.8 times that, but for one muscle, and a hand of 4 Nm made 3.5 to 4.4 times. [factor]
    beyond_model: float = 2.0
    # Where the body's file has less, a joint gets this share of critical damping by the stiffness of its muscles: they
    # are "very lightly damped" (Kastner, Gattringer, Naderer 2012); the packaged arm's first joint has 0.03.
    damped: float = 0.03


POLICY = ExperimentPolicy()
