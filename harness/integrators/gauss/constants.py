"""Constants of the fast Gauss method: tuned numbers, limits, reasons to stop, rows of its table."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Tuning:
    """Tuned numbers of the method, which no theory gives; without a unit unless the text names one.

    In brackets: other values, with the work at equal error that they take in place of this one, the mean and the worst
    of 15 motions (pendulum, rotation, Kepler's orbit with e = .6 to .99, in Sundman time too, free body, heavy top, its
    attitude, forced and cubic oscillators, double pendulum, pendulum on a cart, rubber tube, drag). Work is the number of
    rounds and twice the number of steps: thirteen tolerances from 1e-4 to 1e-16, one trajectory. A change of 3 % of the
    mean is more than chance; where all are less, the value serves a kind of motion that is not among the 15.
    """

    # Stages. The error that the iteration leaves is biased, and makes the energy drift.
    iteration_share: float = 1e-3
    """Error that the iteration may leave, in tolerances. [0.1: 1.00, 1.07]"""
    iteration_share_of_ensemble: float = 0.1
    """This error for eight trajectories, whose last round leaves far less."""
    sample_factor: float = 1e-2
    """A sample may leave an error 1 / this number times as large, as no later result uses it. [1: 1.00, 1.05; the forced
    oscillator at an error of 1e-6 1.26]"""
    best_rate: float = 1e-5
    """Least ratio of the changes of a round to the changes of the round before that is assumed. [1: 1.12, 1.18; 1e-6: the
    pendulum at an error of 1e-9 1.05]"""
    best_rate_finest: float = 1e-6
    """This ratio below `finest`, where changes reach round-off early."""
    finest: float = 5e-14
    """Tolerance below which `best_rate_finest` replaces `best_rate`."""
    best_rate_of_sample: float = 1e-3
    """This ratio for samples, whose guesses are less accurate. [1e-06: 1.00, 1.00]"""
    slow: float = 0.7
    """Rate above which the iteration does not converge. [0.3: 1.02, 1.40; 1: 0.99, 1.01]"""
    fast: float = 0.3
    """Largest rate that the next step should have. [0.7: 1.00, 1.00]"""
    unmonitored: int = 3
    """Changes are first computed this number of rounds before the last round of the step before. [24: 1.01, 1.08]"""
    roundings: float = 16.0
    """Roundings below which changes, Legendre coefficients and slopes that cancel are round-off. [1: 1.00, 1.03; 256:
    1.00, 1.02]"""
    most_derivatives: int = 3
    """Largest number of components with which rounds use the derivatives of the equations. [0: 1.42, 2.71]"""
    fewest_grouped: int = 8
    """Least number of components in groups; with five components groups save rounds but no time. [99: 1.07, 1.72]"""
    most_groups: int = 3
    """Largest number of groups, as each group waits for the group before it. [1: 1.07, 1.72]"""

    # First guesses.
    usual_width: float = 2.1
    """Radians a step: bandwidth of the slopes at a tolerance of 1e-6. [0: 1.01, 1.06]"""
    width_exponent: float = 0.11
    """Exponent of the tolerance in the bandwidth. [0: 1.04, 1.15]"""
    most_width: float = 1.6
    """Radians a step: largest bandwidth. [9: the attitude of the heavy top at an error of 1e-6 1.10]"""

    # Error of a step.
    error_factor: float = 0.002
    """Factor of the error h a^2 / F that the decay of the coefficients gives. [0.0002: 1.03, 1.08; 0.02: 1.00, 1.06]"""
    lower_weight: float = 0.1
    """Weight of the square of coefficient 6 in a^2; coefficient 7 has the weight 1. [0: 1.06, 1.19; 1: 1.01, 1.07]"""
    not_falling: float = 0.03
    """Ratio of squares 6 and 7 to squares 4 and 5 above which coefficients do not fall. [1: 1.00, 1.04]"""
    fine: float = 3e-16
    """Tolerance below which steps leave ever smaller errors, until only round-off moves the energy. [1e-30: 1.00,
    1.00]"""
    exact: float = 1e-11
    """Tolerance below which residuals of all sums are carried, in 5 to 12 % of the time. [1e-30: 1.00, 1.02]"""

    # Step sizes. Equal steps have better guesses, and energy does not drift.
    first_share: float = 0.1
    """First step, as a share of the times |y| / |y'| and |q / q''|^(1/2). [0.01: 1.03, 1.14; 1: 1.03, 1.15]"""
    safety: float = 0.9
    """Share of the step that the estimated error allows; steps that allow this ratio stay equal. [0.99: 1.04, 1.13;
    0.8: 1.00, 1.07]"""
    shrink: float = 0.3
    """Ratio of a step that is repeated to the step before, and the least ratio by the error. [0.1: 1.00, 1.02; 0.6:
    1.00, 1.05]"""
    grow_most: float = 4.0
    """Largest ratio of a step to the step before, and of frequency^4 at its end to the last stage. [2: 1.11, 1.76;
    10: 1.01, 1.17]"""
    hold: float = 3.0
    """Largest ratio that equal steps decline; if wanted steps vary more, steps by frequency are tried. [1.5: 1.12,
    1.52; 10: 1.20, 1.79]"""
    leap: float = 1.3
    """A step that is made longer at once is shorter by this ratio than the error allows. [1: 1.01, 1.07; 2: 1.00,
    1.05]"""
    few_steps: int = 12
    """Equal steps before they first grow by the least ratio allowed; steps that show variations. [100: 1.08, 1.30]"""
    many_steps: int = 100
    """This number of equal steps later. [12: 1.01, 1.16; 1000: 1.00, 1.00]"""
    least_growth: float = 1.1
    """Least ratio by which equal steps then grow. [1: 1.01, 1.07; 1.5: 1.01, 1.06]"""

    # Steps by frequency.
    stride_share: float = 0.95
    """First stride, as a share of the least wanted stride. [0.9: 1.00, 1.06; 1: 1.00, 1.04]"""
    most_frequency_change: float = 2.0
    """Largest ratio of the frequency that gives a step to the frequency at its start. [1.1: 1.02, 1.19; 4: 1.03,
    1.35]"""

    # Stiffness: convergence limits the steps although the motion is slow.
    stiff_rate: float = 0.15
    """Rate above which a step may be limited by convergence."""
    slow_motion: float = 1e-3
    """Relative change of every component in a step, below which the motion is slow."""


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

# Limits, each far from all that a solution needs.
TINY = 1e-300  # replaces 0 at an equilibrium, where nothing moves; the only absolute number
SPLITTER = 256.0  # mean slopes: adding and subtracting it leaves products so few bits that sums are exact
COARSE = 1e-6  # share of the span: longer steps are rounded to a spacing that keeps times exact
EQUAL_WITHIN = 1e-6  # relative: steps of an ensemble that differ less are equal, and one may exceed the wanted step
SHORTEST_AT_POLE = 1e-12  # share of the span: a shorter step may pass a change of sign, as in sin(x) / x
LEAST_MOVING = 1e-12  # share of the largest component that is added to the size of each component
MOST_STIFF = 1000  # surplus of stiff steps over others above which the motion counts as stiff
LOOSEST = 1e-4  # replaces larger tolerances: at 1e-2 Kepler's orbit in Sundman time took as many steps
ENSEMBLE = 16  # least number of trajectories at which each vector holds eight of them
CHUNK = 256  # trajectories in one task of a thread

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
