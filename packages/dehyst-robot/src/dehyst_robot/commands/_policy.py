"""The thresholds by which units of a bench log are guessed or refused: one record, each with its reason."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class BenchPolicy:
    """Numbers that decide how a log of a muscle is read, and what the commands of the robot warn of.

    Shares are between 0 and 1.
    """

    # A valve or pressure that is at its limit for a larger share of a trial is worth a warning.
    long_at_limit: float = 0.2

    # A pressure without a unit is taken for bar if it goes no higher, ... [bar]
    bar_up_to: float = 12.0
    # ... then for kPa, ... [kPa]
    kpa_up_to: float = 1200.0
    # ... then for mbar, and else for Pa. [mbar]
    mbar_up_to: float = 12_000.0
    # No muscle takes 20 bar: a higher pressure is in another unit. [Pa]
    strongest: float = 2e6
    # A log that stays below a tenth of a bar is in another unit. [Pa]
    weakest: float = 1e4
    # A lower gauge pressure is none; offsets of sensors are smaller. [Pa]
    vacuum: float = -2e4
    # The strongest muscles built, for water hydraulics, pull about 28 kN: a larger force is in another unit. [N]
    hardest: float = 1e5
    # With a contraction below this a unit or a length is wrong, ... [parts of the length]
    shortest: float = -0.15
    # ... and with one above this too. [parts of the length]
    longest: float = 0.5
    # A log in percent that stays below this contraction may hold a number from 0 to 1.
    still: float = 0.005

    # A higher pressure is not taken; muscles are driven with less. [bar]
    highest_bar: float = 20.0
    # A longer muscle is not taken: muscles are sold up to 9 m. [m]
    longest_muscle: float = 20.0
    # A loop that is narrower than this share of the range is no hysteresis.
    narrow: float = 1e-6
    # A curve of Hill that misses by more is not worth its name. [% of F_0]
    hill: float = 2.0


POLICY = BenchPolicy()
