"""Constants of the fast Gauss method: tuned numbers, limits, reasons to stop, rows of its table."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Tuning:
    """Tuned numbers of the method, which no theory gives; without a unit unless the comment names one.

    They were found by measurements of time and error on the pendulum, Kepler's orbit and the free rigid body, unless a
    comment names another origin. No measurement is recorded for `settling`, `many`, `unmonitored`,
    `best_rate_of_sample`, `first_share`, `first_at_rest`, `shrink`, `shrink_by_rate`, `least_growth`, `stride_share`,
    `most_frequency_change`, `most_square_change`, `windows_to_wait` and the numbers of roundings.
    """

    # Stages. The error that the iteration leaves is biased, and makes the energy drift.
    iteration_share: float = 1e-3  # error that the iteration may leave, in tolerances
    iteration_share_of_ensemble: float = 0.1  # this error for eight trajectories, whose last round leaves far less
    sample_factor: float = 1e-2  # a sample may leave an error 1 / this number times as large: no later result uses it
    best_rate: float = 1e-5  # least ratio of the changes of a round to the changes of the round before that is assumed
    best_rate_finest: float = 1e-6  # this ratio below `finest` and in ensembles, where changes reach round-off early
    finest: float = 5e-14  # tolerance below which `best_rate_finest` replaces `best_rate`
    best_rate_of_sample: float = 1e-3  # this ratio for samples, whose guesses are less accurate
    slow: float = 0.7  # rate above which the iteration does not converge
    fast: float = 0.3  # largest rate that the next step should have
    noise: float = 1e2  # roundings below which changes and Legendre coefficients are round-off
    unmonitored: int = 3  # changes are first computed this number of rounds before the last round of the step before
    settling: int = 2  # rounds after which the motion alone determines the rate
    many: int = 16  # rounds after which changes at the level of round-off end the iteration at any rate
    most_derivatives: int = 3  # largest number of components with which rounds use the derivatives of the equations
    fewest_grouped: int = 8  # least number of components in groups; with five components groups save rounds but no time
    most_groups: int = 3  # largest number of groups, as each group waits for the group before it
    tries: int = 4  # iterations of one sample before its step is made shorter

    # First guesses: the rounds of ten motions were counted, and the pendulum timed. At loose tolerances there are 5 to
    # 15 % fewer rounds than with an extrapolated stage polynomial, from 1e-9 on equally many; Kepler's orbit in Sundman
    # time takes 7 % more.
    usual_width: float = 2.1  # radians a step: bandwidth of the slopes at a tolerance of 1e-6
    width_exponent: float = 0.11  # exponent of the tolerance in the bandwidth
    most_width: float = 1.6  # radians a step: largest bandwidth

    # Error of a step.
    error_factor: float = 0.002  # factor of the error h a^2 / F that the decay of the coefficients gives
    lower_weight: float = 0.1  # weight of the square of coefficient 6 in a^2; coefficient 7 has the weight 1
    not_falling: float = 0.03  # ratio of squares 6 and 7 to squares 4 and 5 above which coefficients do not fall
    not_falling_factor: float = 4.0  # factor of a d^2, besides `error_factor`
    most_error: float = 4.0  # tolerances above which a step is repeated
    fine: float = 3e-16  # tolerance below which steps leave ever smaller errors, until only round-off moves the energy
    exact: float = 1e-11  # tolerance below which residuals of all sums are carried, in 5 to 12 % of the time
    splitter: float = 256.0  # mean slopes: adding and subtracting it leaves products so few bits that sums are exact
    least_share: float = 1e-6  # least scale of a component, as a share of the largest change in a step
    scale_roundings: float = 16.0  # least scale at fine tolerances: roundings of the largest change, over the tolerance
    slope_roundings: float = 4.0  # roundings of the farthest coordinate, over h^2, in slopes whose terms cancel
    tiny: float = 1e-300  # replaces 0 at an equilibrium, where nothing moves; the only absolute number

    # Step sizes. Equal steps have better guesses, and energy does not drift.
    first_share: float = 0.1  # first step, as a share of the times |y| / |y'| and |q / q''|^(1/2)
    first_at_rest: float = 1e-3  # first step if nothing moves, as a share of the span
    safety: float = 0.9  # share of the step that the estimated error allows
    shrink: float = 0.3  # ratio of a step that is repeated because of its stages, a sample or a pole
    shrink_most: float = 0.1  # least ratio of a step that is repeated because of its error
    shrink_by_rate: float = 0.5  # least ratio of a step to the step before because of its rate
    grow_most: float = 4.0  # largest ratio of a step to the step before
    hold_from: float = 0.9  # steps are kept equal while the next could have at least this ratio ...
    hold: float = 3.0  # ... and at most this one; if wanted steps vary more, steps by frequency are tried
    hold_of_ensemble: float = 2.2  # this largest ratio for eight trajectories
    leap: float = 1.3  # a step that is made longer is shorter by this ratio than the error allows
    first_equal_steps_needed: int = 12  # equal steps before they grow by the least ratio allowed; the first is a guess
    equal_steps_needed: int = 100  # this number after the first growth
    least_growth: float = 1.1  # least ratio by which equal steps then grow
    coarse: float = 1e-6  # share of the span: longer steps are rounded to a spacing that keeps times exact
    equal_within: float = 1e-7  # ratios of steps of an ensemble are equal within this
    rounding_of_steps: float = 1.000001  # ratio by which a step of an ensemble may exceed the wanted step, to save one
    shortest_at_pole: float = 1e-12  # share of the span: a shorter step may pass a change of sign, as in sin(x) / x

    # Steps by frequency.
    first_window: int = 12  # steps of the first window in which variations are measured
    window: int = 32  # steps of each later window
    steadier: float = 0.7  # largest variation of the wanted strides, as a share of the variation of the wanted steps
    stride_share: float = 0.95  # first stride, as a share of the least wanted stride
    most_frequency_change: float = 2.0  # largest ratio of the frequency that gives a step to the frequency at its start
    most_square_change: float = 4.0  # largest ratio of the fourth power of the frequency at the end to the last stage
    windows_to_wait: int = 4  # windows to wait after a failure; each new failure doubles them and adds this number

    # Stiffness: convergence limits the steps although the motion is slow.
    stiff_rate: float = 0.075  # rate above which a step may be limited by convergence
    stiff_rate_of_ensemble: float = 0.15  # this rate for eight trajectories
    slow_motion: float = 1e-3  # relative change of every component in a step, below which the motion is slow
    least_moving: float = 1e-12  # share of the largest component that is added to the size of each component
    most_stiff: int = 1000  # surplus of stiff steps over others above which the motion counts as stiff

    # Use of the method.
    loosest: float = 1e-4  # replaces larger tolerances: at 1e-2 Kepler's orbit in Sundman time took as many steps
    ensemble: int = 16  # least number of trajectories at which each vector holds eight of them
    chunk: int = 256  # trajectories in one task of a thread


TUNING = Tuning()

NOT_FINITE, STEP_TOO_SMALL, TOO_MANY_STEPS, STIFF, OUT_OF_RANGE = 1, 2, 3, 4, 5
"""Reasons to stop."""

MOST_STEPS, MOST_ATTEMPTS = 40_000_000, 10**7
"""The largest number of attempted steps of one trajectory, about twenty seconds, and of one vector of an ensemble."""

MOST_ROUNDS, MOST_CHANGE = 24, 1e80
"""The largest number of rounds of an iteration, and the largest change: beyond them it does not converge."""

SMALLEST, LARGEST = 1e-290, 1e290
"""Limits of the largest component of an initial state: beyond them its products with a tolerance or with stages
underflow or overflow. A motion may decay below SMALLEST later."""

ROUNDOFF = 2.0**-52

# First rows of the parts of the table (rows, 8): columns of the stage matrix (squared for second-order equations), of
# the monomials of the stage polynomial about its end and of the powers of the nodes; nodes; weights; weights of
# positions; columns of the guesses one step ahead and of the stage matrix not squared; both stage matrices times these
# guesses; the nodes to few bits, and their rests; rounding residuals of both rows of weights; both stage matrices times
# powers of the nodes; weights of the value at the end of a step; columns of the Legendre coefficients, and weights of
# the last four.
STAGES, MONOMIALS, POWERS, NODES, WEIGHTS, POSITIONS, AHEAD, ONCE, CARRIED = 0, 8, 16, 24, 25, 26, 27, 35, 43
ONCE_CARRIED, NODES_HIGH, NODES_LOW, WEIGHTS_LOW, POWERED, ONCE_POWERED, ENDS = 51, 59, 60, 61, 63, 71, 79
LEGENDRE, HIGHEST = 80, 88
LOW = WEIGHTS_LOW - WEIGHTS

SCRATCH, SCRATCH_ROWS = 136, 120
"""First row and number of the rows of the table to which products write their vectors. A processor delays a load if the
last twelve bits of its address are also the last bits of the address of a recent store. With vectors on the stack,
whose address varies, one process in ten took up to a fifth more time. The first of these rows share such bits with
MONOMIALS and POWERS, which few steps read."""
