"""The thresholds by which a control loop is judged: one record, each with its reason."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ValvePolicy:
    """Numbers that decide whether a valve is said to stick.

    Shares are between 0 and 1.
    """

    # A swing of the controller output from turn to turn counts as half a cycle from this share of its range on.
    swing: float = 0.4
    # A dead band as wide as the swing of the controller output never lets the valve move.
    largest_dead_band: float = 0.97
    # A dead band is excluded if Schwarz's criterion is higher by this than for a valve that follows (10: very strong,
    # by Kass and Raftery). [-]
    excluded: float = 10.0
    # No model is exact: valves whose gain over one that follows falls short of the best one's by this share are
    # possible.
    inexact: float = 0.05
    # Among so many valves the best one falls below the one that follows by chance, hence twice that. [-]
    certain: float = 20.0
    # The gain over a valve that follows is in all parts of the record, not in one, from so many standard errors on. [-]
    steady: float = 2.0
    # The record has power if dead bands above this share of the swing are excluded.
    seen: float = 0.3
    # In automatic a valve that makes its loop swing has a dead band of most of the swing; in simulated loops that
    # others made swing irregularly, apparent dead bands were below this share of it.
    causes: float = 0.35
    # An interval of the dead band that is wider than this share of it asks for care.
    wide: float = 0.5
    # A jump whose interval ends below this share of the dead band is none.
    no_jump: float = 0.25
    # A jump whose interval begins above this share of the dead band is one.
    least_jump: float = 0.1
    # A change of the position above this many standard deviations of all changes is a move. [-]
    move_over_noise: float = 4.0
    # Fewer moves, or fewer that turn, tell dead band and jump too vaguely to look near them. [moves]
    fewest_moves: int = 6
    # Where the fit and the moves of the position differ by more than this share of the dead band, one of them is wrong.
    agrees: float = 0.05
    # Fewer cycles do not show what repeats. [cycles]
    fewest_cycles: float = 4.0
    # Fewer samples are no cycles of anything. [samples]
    fewest_samples: int = 100
    # A controller that explains this share of the changes of its output is certainly in automatic.
    certain_law: float = 0.9
    # One that explains less than this share of them is not.
    no_law: float = 0.3
    # A column that changes in less than this share of the samples is a set point, or was compressed.
    held: float = 0.1
    # A controller output may pass the ends of its span by this much: some systems allow -5 to 105 %. [%]
    beyond_span: float = 10.0
    # At the ends of the span the valve is not moved; a share above this is worth a word.
    saturated: float = 0.05
    # Steps of the test in manual that make up the dead band that is possible. [-]
    test_steps: float = 3.0
    # The dead band that it is made for is no smaller than this. [% of controller output]
    least_test: float = 1.0
    # A rest of the test takes so many periods of the loop: most processes have answered by then. [periods]
    test_rest: float = 0.3


POLICY = ValvePolicy()
