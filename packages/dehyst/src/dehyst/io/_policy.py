"""The thresholds by which a log is understood, mended or refused: one record, each with its reason."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ReadingPolicy:
    """Numbers that decide how a file is read, which of its rows count, and what is said of it.

    Shares are between 0 and 1.
    """

    # Lines that belong to a list, as this share of all, make it no table: a table may begin with a line in brackets.
    listed: float = 0.8
    # Signals that stand in rows fill so many lines at most: time, input, output and a few more. [lines]
    signal_rows: int = 8
    # Such a row has so many numbers at least: no log has so few samples and so many signals. [numbers]
    long_row: int = 32
    # A mark parts cells if this share of the lines has equally many of them.
    regular: float = 0.9
    # A table has this score at least: the share of its cells that are data, times that of the lines of one width.
    least_score: float = 0.2
    # So large a share of the filled cells of a column may be text, and their rows are left out.
    text_most: float = 0.1
    # A column of text names signals if it changes in this share of the rows: a state stays for some, and signals that
    # were stored at once follow each other ...
    changes_often: float = 0.9
    # ... and if it has no more different texts. [signals]
    most_signals: int = 50
    # Whole numbers up to 999 beside 1.017 mean thousands: read as decimals, the column would leap from 999 to 1.
    # [unit of the column]
    thousands_from: float = 100.0

    # A column rises like a clock after so many steps up and none down: a signal of loops falls too. [steps]
    rising: int = 20
    # Of the steps of a clock this share goes forward.
    forward_share: float = 0.9
    # Of the steps of a log whose newest row stands first this share goes back.
    backward_share: float = 0.95
    # A shorter step of day numbers is one of days: read as seconds, logs of loops this fast (50 kHz) are rarer than
    # those with a row every 1.7 s. [unit of the clock]
    surely_days: float = 2e-5
    # A longer one is one of seconds: read as days, a row every 5 min. [unit of the clock]
    surely_seconds: float = 0.0035
    # No log of an actuator has shorter steps, where the unit of time is only assumed ... [s]
    shortest_assumed: float = 1e-7
    # ... and where it is named, ... [s]
    shortest_named: float = 1e-9
    # ... nor does it last longer: a year. [s]
    longest_log: float = 3e7
    # Between the last row of a day and the first of the next lie no more than so many usual steps. [usual steps]
    midnight: float = 10.0

    # More restarts of a clock are no runs. [restarts]
    max_restarts: int = 50
    # Of the rows, this share may stand out of order, and this far from their place ...
    out_of_order: float = 0.01
    # ... and so far in a short log. [rows]
    nearest_place: int = 10
    # A clock is coarse if this share of the rows repeats a stamp, and even equal rows are samples.
    coarse_clock: float = 0.5
    # More jumps than this ... [jumps]
    jumps_most: int = 6
    # ... and than this share of the steps are no clock that was set now and then.
    jumps_share: float = 0.01
    # With fewer samples no jump is judged. [samples]
    jumps_from: int = 32
    # A signal goes on smoothly within so many times the 95 % quantile of its second differences ... [factor]
    smooth_bend: float = 2.0
    # ... and this share of its median step.
    smooth_step: float = 0.25
    # Within a pair of jumps a signal may step by so many times the 99 % quantile of its steps. [factor]
    usual_steps: float = 2.0
    # Before and after a jump a signal moves by so many times its median second difference, or it rests. [factor]
    moving_bend: float = 10.0
    # Were the jump a gap, at least so much of a signal would be missing. [median steps]
    unseen_steps: float = 1.0
    # A clock that is forward by fewer samples is a logger that lost rows, as buffers overflow by a few. [samples]
    lost_rows: int = 20
    # Were rows lost, a signal would have moved by so many times what passes for smooth. [factor]
    clearly_moved: float = 3.0

    # So large a share of the rows of a reference may be empty and held.
    held_most: float = 0.5
    # A jump by this share of a turn leads from one end of the circle to the other ...
    wrapped: float = 0.8
    # ... if no step of the unwrapped angle is so many times the largest other one. [factor]
    unwrapped_step: float = 3.0
    # If a smaller share of the rows holds both signals, they were logged in turns.
    together: float = 0.5

    # Of a held signal this share of the samples repeats the one before.
    held_share: float = 0.6
    # Of a saturated sensor more than this share of the samples sits at its extreme.
    stuck_share: float = 0.005
    # A converter is coarse if a signal has no more different values. [values]
    coarse_levels: int = 24
    # A swing that is smaller than this share of the range may be the noise of a pressure sensor, not a loop.
    loop_share: float = 0.15

    # A pair of columns leads all others by so much if names and units leave no choice. [points]
    clear_lead: float = 1.0
    # Another pair, or the other direction, that is nearer than this is as likely. [points]
    near_points: float = 0.75
    # One signal follows the other wholly. [points]
    points_follows: float = 3.0
    # The output comes later. [points]
    points_leads: float = 0.3
    # That it does is sure when the area of its loops, over the way of the input, times this is one. [factor]
    sure_area: float = 20.0
    # One signal is the other in another unit, or filtered. [points]
    points_copies: float = 6.0
    # Of such a copy a straight line leaves less than this share of the squares: a hundredth of the signal.
    copy: float = 1e-4
    # What moves from sample to sample by this share of what white noise does is a quantity that is kept constant.
    noisy: float = 0.6
    # With fewer samples nothing is called noise. [samples]
    noise_from: int = 20

    # Of a log that is thinned, swings below this share of the input's range are let go of at once ...
    smallest_swing: float = 1e-3
    # ... and larger ones, up to this share, ...
    largest_swing: float = 0.05
    # ... as long as turning points fill more than this share of the rows, because noise turns at every second sample.
    thinned_turns: float = 0.125
    # More turning points than this share of the rows leave no room for what lies between them: the log ends there.
    most_turns: float = 0.5
    # More gaps than this share of the rows are a clock that jitters, whose shorter steps are none.
    most_gaps: float = 0.05

    # A scheduling column may begin later or end earlier by this share of the recording.
    uncovered: float = 0.02

    # Stamps of two files that differ by less than this share of a step are equal.
    equal_stamps: float = 0.1
    # Clocks of two files are aligned from so many samples of each on. [samples]
    aligned_from: int = 20
    # Two files overlap by this share of the shorter one: what a few samples agree in is chance.
    least_overlap: float = 0.3
    # The output follows the input with this share of its variance, or the files are not of one motion.
    least_explained: float = 0.8
    # Another offset that leaves less than so many times the squares is as good: periods that are alike ... [factor]
    as_good: float = 1.1
    # ... or where both leave less than this more, a fiftieth of the deviation, ...
    alike: float = 4e-4
    # ... of which those that cover nearly as much as the longest are compared by what they leave.
    as_long: float = 0.9
    # An output falls with its input only if that leaves less than this share of what a rising one leaves.
    falls: float = 0.5
    # What half as many operators would correct counts so many times in the doubt: loops of other families than plays,
    # aligned with known clocks, were off by up to that. [factor]
    misfit: float = 2.0
    # Noise of the input is smoothed down to this share of its range, for plays hold its peaks, ...
    quiet: float = 0.001
    # ... by a mean over this share of a swing at most.
    smoothed_most: float = 0.03
    # Smoothing may shift a turn of wide loops by this share of the width of the mean.
    smoothing_shifts: float = 0.2
    # The widest plays are determined once the input has passed this share of its range.
    passed: float = 0.8
    # Clocks of instruments differ by a few hundred ppm, and a time between rows that was typed by a percent or two.
    largest_drift: float = 0.02
    # A law of a controller is fitted to so many changes at least. [samples]
    law_samples: int = 100
    # A controller that was logged with its set point leaves less than this share of the changes of its output open:
    # rounding and a faster clock of the controller leave some. Laws that only resemble one leave tenths.
    law_left: float = 0.02
    # The input answers to noise if set point and past leave this share of its changes open. Below it the bias of a fit
    # is below its other errors.
    law_reacts: float = 0.1


POLICY = ReadingPolicy()
