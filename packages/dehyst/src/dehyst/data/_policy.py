"""The thresholds by which false values, gaps, turns, rests and repeated samples are told: one record, with reasons."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class DataPolicy:
    """Numbers that decide which samples of a log count, and what is said of it.

    Shares are between 0 and 1.
    """

    # A swing counts as a turn when it exceeds this share of the signal's range: above sensor noise, below any loop that
    # an identification would use.
    turn_fraction: float = 0.05

    # A step of time is a gap when it is this many times the median ... [median steps]
    gap_medians: float = 5.0
    # ... if it also misses this many samples at the usual rate. [samples]
    gap_samples: float = 3.0
    # Where the input moves by more than this share of its range across a gap, its memory is unknown.
    moved: float = 0.05
    # Samples come at an even pace if no step differs from the median by more than this share of it, ...
    even_within: float = 0.5
    # ... but for a few; this share of the steps must be so: a timer of a busy computer is late now and then.
    even_share: float = 0.9
    # A jump of the clock is taken back by one that follows within so many samples ... [samples]
    back_samples: int = 50
    # ... or within this share of the log ...
    back_share: float = 0.01
    # ... and that differs from it by no more than this share of it.
    back_alike: float = 0.02

    # A spike has no more samples than this: a longer excursion may be real. [samples]
    spike_length: int = 3
    # Its jump is at least this share of the range of the others ...
    spike_range: float = 0.5
    # ... this many times the 99.9 % quantile of the second differences of the others ... [factor]
    spike_curvature: float = 10.0
    # ... and this many times their largest step. [factor]
    spike_step: float = 2.0
    # At the ends of a log there is only one neighbour to judge by: a spike there jumps so far. [ranges of the others]
    end_range: float = 10.0
    # More spikes than this share of the samples are a signal, not a fault.
    rare: float = 0.01
    # With fewer samples nothing is judged ... [samples]
    judged_from: int = 32
    # ... nor with fewer different values among the others: a staircase has no range to leave. [values]
    levels: int = 8
    # A code of a failed sensor lies so far from everything else. [ranges of the others]
    code_distance: float = 3.0
    # Codes in more than this share of the samples are the signal.
    code_share: float = 0.5

    # Longer runs are told only in a signal that moves in small steps: false values jump in and out, and it goes on. A
    # run jumps by this share of the range of the others at least ...
    run_jump: float = 0.1
    # ... and by so many of their largest steps ... [factor]
    run_step: float = 4.0
    # ... which fits into their range so many times. [factor]
    run_smooth: float = 5.0
    # A signal comes back to where it left, but for this share of the smaller jump.
    run_return: float = 0.5
    # A run may be so long in a short log, and at the ends of any log; elsewhere as long as `rare` says. [samples]
    run_most: int = 5
    # More runs that are longer than a spike are pulses, a signal. [runs]
    runs_most: int = 5
    # A run at an end of the log lies beyond the range of the others by this share of it.
    run_beyond: float = 0.3
    # More jumps are a signal in any case. [jumps]
    jumps_most: int = 1000

    # One value that comes again and again, such as 0 of a lost packet, is told by its runs, however many: each jumps
    # there from wherever a smooth signal is, and back. There must be so many ... [runs]
    same_runs: int = 3
    # ... of so many samples each, at most: a longer one may be a rest ... [samples]
    same_length: int = 8
    # ... and together no more than this share of the samples.
    same_share: float = 0.03
    # They begin over at least this share of the range of the others: a signal passes its values at one place.
    same_spread: float = 0.15
    # At least this share of them begins while the signal moves: pulses start from a rest.
    same_moving: float = 0.2
    # Once a value is known to be false, a run that jumps further than so many of the largest other steps is false too.
    # [factor]
    same_near: float = 1.5

    # So small a share of the samples, at either end of the range, ...
    few_extremes: float = 0.005
    # ... that makes more than this share of the whole range does not count, ...
    extremes_range: float = 0.2
    # ... unless so many of them follow each other. [samples]
    in_a_row: int = 6
    # With fewer samples all count. [samples]
    extremes_from: int = 32

    # The sensor of an input is at the end of its range where, while the input rests at its extreme, the output goes on
    # by this share of its range in the mean of the rests, ...
    rest_out: float = 0.01
    # ... as fast, at the begin and the end of a rest, as this share of what it does before and behind it, ...
    rest_pace: float = 0.15
    # ... and comes back in this share of the rests.
    rest_returns: float = 0.6
    # What goes to and fro by this share of the way out rings.
    rest_ringing: float = 0.5
    # Behind a step of the input of this share of its range an output may ring: such a rest tells nothing.
    step_into_rest: float = 0.1
    # A smaller share of the samples in such rests is not worth a word.
    in_rests: float = 0.005
    # In a single rest anything may have moved the output. [rests]
    fewest_rests: int = 2
    # A shorter stretch at an extreme is a turn, not a rest. [samples]
    least_rest: int = 3

    # Moves of both signals in a row that two measurements do not repeat to the last digit: with even odds of one digit
    # more or less at each of them, once in 2^100 logs. [moves]
    repeated_moves: int = 100
    # A recording with fewer moves is not looked for in another one. [moves]
    sought_moves: int = 16
    # A window of a log has this share of its samples in it, one after the other: reading may have left out a row at its
    # ends.
    whole_window: float = 0.99
    # Where a smaller share of the probes is in the other recording, they are there by chance.
    likely: float = 0.02
    # A shared block is at least this share of the shorter recording: a common beginning of two simulations is shorter.
    shared_block: float = 0.05
    # A signal in which a larger share of the samples bends the other way than the one before has noise; a simulated
    # motion is smooth.
    rough: float = 0.1
    # A signal with fewer decimals or significant digits was rounded when it was written. [digits]
    written_digits: int = 10

    # A way so long is motion, as a share of the range: noise of sensors is several times smaller.
    chord: float = 0.05
    # Where the signal does not go so far, a share of its own range.
    small_chord: float = 0.25
    # At least this share of the samples passes such a way.
    moving: float = 0.005
    # This share of the way is slower than the speed of a signal: a single jump is none.
    slower: float = 0.9
    # Pairs of samples further apart in time than so many times the usual lie beside a gap. [factor]
    speed_gap: float = 3.0

    # A swing and the one back make a loop if they differ by no more than this share of them: no two cycles are quite
    # alike.
    cycle_alike: float = 0.05
    # What no closed loop explains, such as the swings of a motion that dies away, makes a loop that does not close if
    # the smaller swing is this share of the larger one: a first rise from rest to a cycle is half of it.
    cycle_whole: float = 0.75
    # The numbers of the largest loops are means over those that are this share of the largest one.
    loops_large: float = 0.9
    # Intervals are those of the scatter from so many loops on; with fewer the noise of the samples makes them. [loops]
    fewest_scatter: int = 3
    # A change from cycle to cycle is a line through so many loops at least. [loops]
    fewest_trend: int = 4
    # Loops are of one depth if it scatters by no more than this share of it; else the line stands beside it, ...
    one_depth: float = 0.001
    # ... and is drawn only if depths leave this share of the squares of time: sizes that grow evenly look like time.
    own_place: float = 0.1
    # The gain is told where the output differs between the turns by this share of its range in the loop.
    rises_by: float = 0.5
    # A branch is read at a place by a parabola through what lies within this share of its range on either side ...
    reading_reach: float = 0.025
    # ... if there are so many samples; else between the two beside it. [samples]
    reading_samples: int = 6
    # The parabola takes the nearest samples, as many as it takes for this standard error, as a share of the range.
    reading_error: float = 0.0002
    # The slope at a turn is that of a line over this share of the way.
    turn_reach: float = 0.1
    # A loop closes if its begin and its end lie no further apart than this share of the output's range, ...
    loop_closed: float = 0.02
    # ... or than so many standard errors that the noise makes. [standard errors]
    closed_errors: float = 3.0
    # An output that jumps where the input turns, within this share of the way, closes within that jump.
    at_turn: float = 0.01
    # A loop whose branches are closer than this share of the output's range, in the mean, has no direction.
    loop_narrow: float = 0.01
    # It crosses itself if the smaller part of its area is at least this share of the larger one.
    loop_mixed: float = 0.25
    # Coercivity and remanence are measured about zero if that lies so far inside the range; else about its middle.
    zero_inside: float = 0.25
    # Of more loops so many, spread over the log, are measured. [loops]
    most_loops: int = 1000
    # Where only the numbers of the largest loops are wanted, so many of these are enough for a mean. [loops]
    most_largest: int = 50

    # A data sheet measures strokes that go over this share of the quantity's range.
    full_stroke: float = 0.9
    # A quantity is at rest within a band of this share of its range, noise included, ...
    hold_band: float = 0.01
    # ... for this share of the time of a full stroke: a ramp leaves the band in less than half of it, ...
    hold_time: float = 0.025
    # ... if half of its samples lie within this share of the band: at the turn of a sine they fill half of it.
    hold_flat: float = 0.25
    # A calibration goes in steps if its strokes rest so often between their ends; read is what stands when a step
    # ends. [rests]
    fewest_steps: int = 3
    # Creep is that of a hold of this share of the time of a full stroke at least: shorter ones end before it shows.
    creep_time: float = 0.1
    # It is measured in this share of the range at either end of it, as load cells are.
    creep_end: float = 0.1
    # A first cycle is named as the cause of the spread if this share of it, or less, is left without it.
    first_cycle: float = 0.5
    # The largest of twenty places that is no more than so many standard errors of each is noise. [standard errors]
    above_noise: float = 3.0
    # A full-scale output below this share of the range of the reading is none: the reading comes back.
    least_output: float = 0.05

    # The input of a choice moves once it has left a band around its last place: noise at rest is no way. [half ranges]
    still_band: float = 0.004
    # All rests together have this share of the weight of a choice at most, however long they are.
    most_rests: float = 0.2


POLICY = DataPolicy()
