"""Methods on the rotation group for a rigid body: each step is a rotation.

Angular velocity and attitude are rotated by the same Q in a step: R' = R Q and M' = Q^T M (+ torque). So without torque
R M, the angular momentum in space, is constant to round-off, and R(0)^T R(t) is orthogonal to round-off.
"""

from collections.abc import Sequence
from math import cos, sin, sqrt
from typing import Any

from gnomon.cases.core.forms import Form, RigidBody
from gnomon.harness.contract.integrator import Integrator, Problem, Refused, Solver
from gnomon.harness.integrators.base.fixed_step import FixedStep, Table, take_numbers
from gnomon.harness.integrators.base.stepping import StepData, evaluate
from gnomon.harness.integrators.geometric.splitting import Composed, KahanLi6
from gnomon.harness.integrators.runge_kutta.explicit import RK4


def munthe_kaas_step(s: StepData, t: Any, h: Any) -> bool:
    """One step of the Runge-Kutta-Munthe-Kaas method.

    Rows of `table`: c_j, a_j1, ... for each stage; 1, b_1, ...; the moments of inertia. The first six columns of
    `store` hold the stage vectors u (rotation since the start of the step, Q = exp(hat u)) and g (angular momentum
    added by torque, along the axes at the start): u' = u-dexp^-1(w), g' = Q torque.
    """
    table, y, x, slope, store, increment = s.table, s.y, s.x, s.slope, s.store, s.increment
    stages = table.shape[0] - 2
    inertia = stages + 1
    for j in range(stages + 1):
        for i in range(6):
            total = 0.0
            for m in range(min(j, stages)):
                total += table[j, m + 1] * store[m, i]
            store[stages, i] = h * total
        u1, u2, u3 = store[stages, 0], store[stages, 1], store[stages, 2]
        less = exponential_less_one(u1, u2, u3)
        g1, g2, g3 = store[stages, 3], store[stages, 4], store[stages, 5]
        m1, m2, m3 = table[inertia, 0] * y[0], table[inertia, 1] * y[1], table[inertia, 2] * y[2]
        turned_momentum = multiply_transposed(less, m1 + g1, m2 + g2, m3 + g3)
        increment[0] = (turned_momentum[0] + g1) / table[inertia, 0]
        increment[1] = (turned_momentum[1] + g2) / table[inertia, 1]
        increment[2] = (turned_momentum[2] + g3) / table[inertia, 2]
        for row in range(3, 12, 3):
            rotated = multiply_transposed(less, y[row], y[row + 1], y[row + 2])
            for i in range(3):
                increment[row + i] = rotated[i]
        for i in range(12):
            x[i] = y[i] + increment[i]
        if j == stages:
            break
        evaluate(s, t + table[j, 0] * h)
        w1, w2, w3 = x[0], x[1], x[2]
        # The inverse differential of exp, to the terms that order 4 needs: w + u x w / 2 + u x (u x w) / 12.
        a1, a2, a3 = u2 * w3 - u3 * w2, u3 * w1 - u1 * w3, u1 * w2 - u2 * w1
        store[j, 0] = w1 + a1 / 2 + (u2 * a3 - u3 * a2) / 12
        store[j, 1] = w2 + a2 / 2 + (u3 * a1 - u1 * a3) / 12
        store[j, 2] = w3 + a3 / 2 + (u1 * a2 - u2 * a1) / 12
        brought = times(less, slope[0], slope[1], slope[2])
        for i in range(3):
            store[j, i + 3] = slope[i] + brought[i]
    return True


def axis_splitting_step(s: StepData, t: Any, h: Any) -> bool:
    """One step of symmetric steps: half the torque, exact rotations about axes 1, 2, 3, 2, 1, half the torque.

    Rows of `table`: lengths of the symmetric steps over h; moments of inertia.
    """
    table, increment = s.table, s.increment
    for i in range(12):
        increment[i] = 0.0
    now = t
    for j in range(table.shape[1]):
        length = table[0, j] * h
        if length == 0.0:
            continue
        half = length / 2
        push(s, now, half)
        spin(s, 0, half)
        spin(s, 1, half)
        spin(s, 2, length)
        spin(s, 1, half)
        spin(s, 0, half)
        now += length
        push(s, now, half)
    return True


def push(s: Any, now: Any, length: Any) -> None:
    """Change the angular velocity by the torque over `length`."""
    for i in range(12):
        s.x[i] = s.y[i] + s.increment[i]
    evaluate(s, now)
    for i in range(3):
        s.increment[i] += length * s.slope[i] / s.table[1, i]


def spin(s: Any, axis: int, length: Any) -> None:
    """The exact motion under the kinetic energy of one axis, M_i^2 / (2 I_i): a rotation about it at constant w_i.

    It is added as a change, with cos - 1 = -2 sin^2(angle / 2), so that small angles lose no digits.
    """
    y, table, increment = s.y, s.table, s.increment
    b = (axis + 1) % 3
    c = (axis + 2) % 3
    angle = length * (y[axis] + increment[axis])
    half_sine = sin(angle / 2)
    sine, less = 2 * half_sine * cos(angle / 2), -2 * half_sine * half_sine
    mb, mc = table[1, b] * (y[b] + increment[b]), table[1, c] * (y[c] + increment[c])
    increment[b] += (less * mb + sine * mc) / table[1, b]
    increment[c] += (less * mc - sine * mb) / table[1, c]
    for row in range(3, 12, 3):
        rb, rc = y[row + b] + increment[row + b], y[row + c] + increment[row + c]
        increment[row + b] += less * rb + sine * rc
        increment[row + c] += less * rc - sine * rb


def exponential_less_one(u1: Any, u2: Any, u3: Any) -> Any:
    """exp(hat u) - 1, row by row, through a unit quaternion, without cancellation."""
    square = u1 * u1 + u2 * u2 + u3 * u3
    if square == 0.0:
        s, c = square + 1 / 2, square + 1
    else:
        angle = sqrt(square)
        s, c = sin(angle / 2) / angle, cos(angle / 2)
    a, b, d = s * u1, s * u2, s * u3
    return (
        (-2 * (b * b + d * d), 2 * (a * b - c * d), 2 * (a * d + c * b)),
        (2 * (a * b + c * d), -2 * (a * a + d * d), 2 * (b * d - c * a)),
        (2 * (a * d - c * b), 2 * (b * d + c * a), -2 * (a * a + b * b)),
    )


def times(q: Any, v1: Any, v2: Any, v3: Any) -> Any:
    """The product Q v."""
    return (
        q[0][0] * v1 + q[0][1] * v2 + q[0][2] * v3,
        q[1][0] * v1 + q[1][1] * v2 + q[1][2] * v3,
        q[2][0] * v1 + q[2][1] * v2 + q[2][2] * v3,
    )


def multiply_transposed(q: Any, v1: Any, v2: Any, v3: Any) -> Any:
    """The product Q^T v."""
    return (
        q[0][0] * v1 + q[1][0] * v2 + q[2][0] * v3,
        q[0][1] * v1 + q[1][1] * v2 + q[2][1] * v3,
        q[0][2] * v1 + q[1][2] * v2 + q[2][2] * v3,
    )


class RigidBodyMethod(FixedStep):
    """A method for a rigid body: its step calls the torque, and its table ends with the moments of inertia."""

    accepts = (RigidBody,)
    compensated = True
    function, function_widths = "torque", (12, 3)

    def table(self, mp: Any, form: Form, parameters: Sequence[Any], roundoff: Any) -> Table:
        assert isinstance(form, RigidBody)
        return [*self.coefficients(mp), take_numbers(mp, form.inertia, parameters, 3)]


class MuntheKaas4(RigidBodyMethod):
    """Runge-Kutta-Munthe-Kaas method on SO(3) over the classical tableau (Munthe-Kaas, BIT 38, 1998). Order 4."""

    name, order, conserves = "RKMK 4", 4, ("momentum", "attitude")
    step = munthe_kaas_step

    @classmethod
    def coefficients(cls, mp: Any) -> Table:
        return RK4.coefficients(mp)

    def rows(self, form: Form) -> int:
        return 5


class AxisSplitting(Composed, RigidBodyMethod):
    """Symmetric splitting of the kinetic energy into its three axes, each with its exact rotation.

    McLachlan, Physical Review Letters 71, 1993; Reich, Physica D 76, 1994. Torque must not depend on angular velocity.
    """

    conserves = ("symplectic", "reversible", "momentum", "attitude")
    step = axis_splitting_step

    def prepare(self, problem: Problem, setting: float) -> Solver:
        assert isinstance(problem.form, RigidBody)
        nan = float("nan")
        state = (nan, nan, nan, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
        torque = problem.form.torque(problem.t0, state, tuple(problem.parameters.tolist()))
        if any(value != value for value in torque):
            raise Refused("the torque depends on angular velocity; this splitting needs one of attitude and time alone")
        return super().prepare(problem, setting)


class AxisSplitting2(AxisSplitting):
    """Axis splitting with five rotations a step. Order 2."""

    name, order = "Axis splitting 2", 2


class AxisSplitting6(AxisSplitting):
    """Axis splitting with nine symmetric steps in the lengths of Kahan and Li. Order 6."""

    name, order = "Axis splitting 6", 6
    composition = KahanLi6


INTEGRATORS: tuple[type[Integrator], ...] = (MuntheKaas4, AxisSplitting2, AxisSplitting6)
