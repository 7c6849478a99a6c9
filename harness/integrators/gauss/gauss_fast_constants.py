"""Constants of the fast Gauss method: what was tuned, its limits, the reasons to stop, the rows of its table."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Tuning:
    """Numbers without an exact reason; without a unit where none is named.

    They were found by measuring times and errors on the pendulum, Kepler's orbit and the free rigid body, unless another
    origin is named. Of `settling`, `many`, `unmonitored`, `best_rate_of_sample`, `first_share`, `first_at_rest`, `shrink`,
    `shrink_by_rate`, `least_growth`, `stride_share`, `most_frequency_change`, `most_square_change`, `windows_to_wait` and
    the numbers of roundings no measurement is recorded.
    """

    # Stages. What the iteration leaves is biased, and makes energy drift.
    iteration_share: float = 1e-3  # tolerances that the iteration may leave
    iteration_share_of_ensemble: float = 0.1  # the same for eight trajectories, whose last round leaves far less
    sample_factor: float = 1e-2  # a sample may leave 1 / this times as much: nothing is computed from it
    best_rate: float = 1e-5  # changes of a round over those of the round before: no better rate is assumed
    best_rate_finest: float = 1e-6  # the same below `finest` and in ensembles, where changes reach round-off early
    finest: float = 5e-14  # tolerance
    best_rate_of_sample: float = 1e-3  # the same rate for samples, whose guesses err more
    slow: float = 0.7  # rate above which the iteration does not converge
    fast: float = 0.3  # rate that the next step should have at most
    noise: float = 1e2  # roundings below which changes and Legendre coefficients are round-off
    unmonitored: int = 3  # rounds before the last one of the step before, up to which changes are not computed
    settling: int = 2  # rounds before the rate is that of the motion
    many: int = 16  # rounds after which changes at the level of round-off end the iteration at any rate
    most_derivatives: int = 3  # components up to which rounds use the derivatives of the equations
    fewest_grouped: int = 8  # components from which a round is done in groups; with five they save rounds, and no time
    most_groups: int = 3  # each group waits for the one before it
    tries: int = 4  # iterations of one sample before its step is made shorter

    # First guesses: the rounds of ten motions were counted, and the pendulum timed. At loose tolerances these are 5 to 15 %
    # fewer than with the stage polynomial continued, from 1e-9 on as many; Kepler's orbit in Sundman time takes 7 % more.
    usual_width: float = 2.1  # radians a step: bandwidth of the slopes at a tolerance of 1e-6
    width_exponent: float = 0.11  # of the tolerance in the bandwidth
    most_width: float = 1.6  # radians a step

    # Error of a step.
    error_factor: float = 0.002  # of the error h a^2 / F that the decay of the coefficients gives
    lower_weight: float = 0.1  # of the square of coefficient 6 in a^2, beside 1 for that of coefficient 7
    not_falling: float = 0.03  # ratio of squares 6 and 7 to squares 4 and 5 above which coefficients do not fall
    not_falling_factor: float = 4.0  # of a d^2, beside `error_factor`
    most_error: float = 4.0  # tolerances above which a step is repeated
    fine: float = 3e-16  # tolerance below which steps leave ever less, until only round-off moves the energy
    exact: float = 1e-11  # tolerance below which residuals of all sums are carried, in 5 to 12 % of the time
    splitter: float = 256.0  # mean slopes: added and subtracted, it leaves so few bits of a product that sums are exact
    least_share: float = 1e-6  # of the largest change in a step: the least scale of a component
    scale_roundings: float = 16.0  # of the largest change, over the tolerance: the same where that is fine
    slope_roundings: float = 4.0  # of the farthest coordinate, over h^2: what remains where terms of the slopes cancel
    tiny: float = 1e-300  # stands for 0 at an equilibrium, where nothing moves; nothing else is absolute

    # Step sizes. Equal steps have better guesses, and energy does not drift.
    first_share: float = 0.1  # of the times |y| / |y'| and |q / q''|^(1/2): the first step
    first_at_rest: float = 1e-3  # of the span: the first step where nothing moves
    safety: float = 0.9  # of the step that the estimated error allows
    shrink: float = 0.3  # ratio of a repeated step whose stages, sample or pole were the reason
    shrink_most: float = 0.1  # least ratio of a repeated step whose error was the reason
    shrink_by_rate: float = 0.5  # least ratio of a step to the one before because of its rate
    grow_most: float = 4.0  # largest ratio of a step to the one before
    hold_from: float = 0.9  # steps are kept equal while the next could have at least this ratio ...
    hold: float = 3.0  # ... and at most this one; a frequency is looked for where wanted steps vary more
    hold_of_ensemble: float = 2.2  # the same for eight trajectories
    leap: float = 1.3  # ratio of the step that could follow, to the one that follows, where it could be longer
    first_equal_steps_needed: int = 12  # equal steps before they grow by what all of them allowed; the first is a guess
    equal_steps_needed: int = 100  # the same, later
    least_growth: float = 1.1  # least ratio by which they grow then
    coarse: float = 1e-6  # of the span: longer steps are rounded to multiples of its spacing, so that times are exact
    equal_within: float = 1e-7  # ratios of steps of an ensemble are equal within this
    rounding_of_steps: float = 1.000001  # wanted steps of an ensemble may be that much longer, so that one fewer fits
    shortest_at_pole: float = 1e-12  # of the span: a shorter step may pass a change of sign, as sin(x) / x has no pole

    # Steps by frequency.
    first_window: int = 12  # steps whose variation is looked at, the first time
    window: int = 32  # the same, later
    steadier: float = 0.7  # of the variation of the wanted steps: the most that the wanted strides may have
    stride_share: float = 0.95  # of the least wanted stride: the first one
    most_frequency_change: float = 2.0  # ratio of the frequency to the one before
    most_square_change: float = 4.0  # ratio of the fourth power of the frequency, continued to the end of a step
    windows_to_wait: int = 4  # windows before it is tried again; after each failure twice as many and this number

    # Stiffness: a motion that only convergence limits while it moves slowly.
    stiff_rate: float = 0.075  # rate above which a step may be limited by convergence
    stiff_rate_of_ensemble: float = 0.15  # the same for eight trajectories
    slow_motion: float = 1e-3  # relative change of every component in a step, below which the motion is slow
    least_moving: float = 1e-12  # of the largest component: what is smaller is compared with this
    most_stiff: int = 1000  # such steps more than others

    # Use of the method.
    loosest: float = 1e-4  # tolerances above are replaced: at 1e-2 Kepler's orbit in Sundman time took as many steps
    ensemble: int = 16  # trajectories from which each vector holds eight of them
    chunk: int = 256  # of these are one task of a thread


TUNING = Tuning()

NOT_FINITE, STEP_TOO_SMALL, TOO_MANY_STEPS, STIFF, OUT_OF_RANGE = 1, 2, 3, 4, 5
"""Reasons to stop."""

MOST_STEPS, MOST_ATTEMPTS = 40_000_000, 10**7
"""Attempts for one trajectory, about twenty seconds; and for one vector of an ensemble."""

MOST_ROUNDS, MOST_CHANGE = 24, 1e80
"""Rounds of one iteration, and its largest change: beyond these it does not converge."""

SMALLEST, LARGEST = 1e-290, 1e290
"""The largest component of an initial state must lie between them: outside, products of it with a tolerance or with
stages underflow or overflow. A motion that decays from such a start may go below."""

ROUNDOFF = 2.0**-52

# First rows of the parts of the table (rows, 8): columns of the stage matrix (squared for second-order equations), of the
# monomials of the stage polynomial about its end and of the powers of the nodes; nodes; weights; weights of positions;
# columns of the guesses one step ahead and of the stage matrix not squared; both stage matrices times these guesses; the
# nodes to few bits, and the rest; rounding residuals of both rows of weights; both stage matrices times the powers of the
# nodes; weights of the value at the end of a step; columns of the Legendre coefficients, and weights of the last four.
STAGES, MONOMIALS, POWERS, NODES, WEIGHTS, POSITIONS, AHEAD, ONCE, CARRIED = 0, 8, 16, 24, 25, 26, 27, 35, 43
ONCE_CARRIED, NODES_HIGH, NODES_LOW, WEIGHTS_LOW, POWERED, ONCE_POWERED, ENDS = 51, 59, 60, 61, 63, 71, 79
LEGENDRE, HIGHEST = 80, 88
LOW = WEIGHTS_LOW - WEIGHTS

SCRATCH, SCRATCH_ROWS = 136, 120
"""Rows of the table that products write their vectors to. A processor delays a load whose address has the same last
twelve bits as that of a recent store: with vectors on the stack, whose address varies, one process in ten took up to a
fifth more time. The first of these rows have such addresses in common with MONOMIALS and POWERS, which few steps read."""
