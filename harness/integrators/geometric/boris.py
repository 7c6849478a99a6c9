"""Boris's method and related methods for a charge: drift, push by E and rotation by B, each in closed form."""

from collections.abc import Sequence
from math import sqrt, tan
from typing import Any, ClassVar

from gnomon.cases.core.forms import Charged, Form
from gnomon.cases.core.scene import SceneForm
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.integrators.base.fixed_step import Table, take_numbers
from gnomon.harness.integrators.base.stepping import StepData, evaluate, product, sum_of
from gnomon.harness.integrators.geometric.splitting import Composed, KahanLi6, Suzuki4

TURNING, LIGHT = 0, 1
"""Columns of the second row of `table`."""
RATIONAL, EXACT, MEAN = 0, 1, 2
"""Kinds of rotation of u by the magnetic field. RATIONAL: by 2 atan(angle/2); EXACT: by the angle; MEAN: by
2 atan(angle/2), with gamma of the mean u."""


def boris_step(s: StepData, t: Any, h: Any) -> bool:
    """One step for a charge, of symmetric steps: half a drift, half a push, the rotation, half a push, half a drift.

    Rows of `table`: lengths of the symmetric steps over h; kind of rotation, speed of light (0: not relativistic).
    """
    table, y, x, store, increment = s.table, s.y, s.x, s.store, s.increment
    for i in range(6):
        increment[i] = store[0, i]
        store[0, i] = 0.0
    now = t
    for j in range(table.shape[1]):
        length = table[0, j] * h
        if length == 0.0:
            continue
        half = length / 2
        drift(s, half)
        for i in range(3):
            x[i] = y[i] + increment[i]
        evaluate(s, now + half)
        push(s, half)
        turn(s, half)
        push(s, half)
        drift(s, half)
        now += length
    return True


def push(s: Any, half: Any) -> None:
    """Change u by E over `half`. Rounding residuals go to `store`, after the last push to the next step.

    A uniform E pushes by an equal number in every step, and all sums between two powers of two are then rounded
    equally: without the residuals the error would grow as t.
    """
    fields, store, increment = s.slope, s.store, s.increment
    for i in range(3):
        pushed, first = product(half, fields[i])
        increment[3 + i], second = sum_of(increment[3 + i], pushed)
        store[0, 3 + i] += first + second


def drift(s: Any, length: Any) -> None:
    """Change the position by u/gamma over `length`."""
    y, store, increment, light = s.y, s.store, s.increment, s.table[1, LIGHT]
    u1, lost1 = sum_of(y[3], increment[3])
    u2, lost2 = sum_of(y[4], increment[4])
    u3, lost3 = sum_of(y[5], increment[5])
    lost1, lost2, lost3 = lost1 + store[0, 3], lost2 + store[0, 4], lost3 + store[0, 5]
    scale = length
    if light > 0.0:
        scale = length / sqrt(1 + (u1 * u1 + u2 * u2 + u3 * u3) / (light * light))
    increment[0] += scale * u1 + scale * lost1
    increment[1] += scale * u2 + scale * lost2
    increment[2] += scale * u3 + scale * lost3


def turn(s: Any, half: Any) -> None:
    """Rotate u about the magnetic field over twice `half`: u + (u + u x T) x S, S = 2 T/(1 + T^2).

    It is a rotation by 2 atan |T|, so |u| is conserved.
    """
    y, fields, store, increment = s.y, s.slope, s.store, s.increment
    turning, light = s.table[1, TURNING], s.table[1, LIGHT]
    u1, lost1 = sum_of(y[3], increment[3])
    u2, lost2 = sum_of(y[4], increment[4])
    u3, lost3 = sum_of(y[5], increment[5])
    lost1, lost2, lost3 = lost1 + store[0, 3], lost2 + store[0, 4], lost3 + store[0, 5]
    a, b, c = half * fields[3], half * fields[4], half * fields[5]
    square = a * a + b * b + c * c
    if square == 0.0:
        return
    scale = 1 + 0 * square
    if light > 0.0:
        gamma_square = 1 + (u1 * u1 + u2 * u2 + u3 * u3) / (light * light)
        if turning == MEAN:
            along = (u1 * a + u2 * b + u3 * c) / light
            left = gamma_square - square
            gamma_square = (left + sqrt(left * left + 4 * (square + along * along))) / 2
        scale = 1 / sqrt(gamma_square)
    if turning == EXACT:
        angle = sqrt(square) * scale
        scale = scale * tan(angle) / angle
    a, b, c = a * scale, b * scale, c * scale
    v1 = u1 + ((u2 * c - u3 * b) + (lost1 + (lost2 * c - lost3 * b)))
    v2 = u2 + ((u3 * a - u1 * c) + (lost2 + (lost3 * a - lost1 * c)))
    v3 = u3 + ((u1 * b - u2 * a) + (lost3 + (lost1 * b - lost2 * a)))
    w1, w2, w3 = v2 * c - v3 * b, v3 * a - v1 * c, v1 * b - v2 * a
    share, lost = share_of(a, b, c)
    increment[3] += share * w1 + lost * w1
    increment[4] += share * w2 + lost * w2
    increment[5] += share * w3 + lost * w3


def share_of(a: Any, b: Any, c: Any) -> tuple[Any, Any]:
    """2/(1 + T^2) and its rounding residual.

    Without the residual, |u| would change by an equal factor in every step in a uniform field: its error would grow as
    t.
    """
    aa, lost_a = product(a, a)
    bb, lost_b = product(b, b)
    cc, lost_c = product(c, c)
    square, first = sum_of(aa, bb)
    square, second = sum_of(square, cc)
    whole, third = sum_of(1 + 0 * square, square)
    share = 2 / whole
    two, lost = product(share, whole)
    left = (2 - two) - lost - share * (third + (second + (first + (lost_a + lost_b + lost_c))))
    return share, left * share / 2


class ChargeMethod(Composed):
    """A method for a charge, whose step calls a function that computes the fields."""

    accepts = (Charged,)
    conserves = ("volume", "reversible")
    compensated = True
    step = boris_step
    function, function_widths = "fields", (3, 6)
    turning: ClassVar[int]

    def table(self, mp: Any, form: Form, parameters: Sequence[Any], roundoff: Any) -> Table:
        assert isinstance(form, Charged)
        light = [mp.mpf(0)] if form.light is None else take_numbers(mp, form.light, parameters, 1)
        return [*self.coefficients(mp), [mp.mpf(self.turning), *light]]


class Boris(ChargeMethod):
    """Boris's rotation (Proc. 4th Conf. Numerical Simulation of Plasmas, 1970). Order 2.

    Birdsall and Langdon, Plasma Physics via Computer Simulation, 1985, 4-3 and, for relativistic charges, 15-4.

    Half drifts synchronise the usual staggering in time; gamma is computed in the middle of the push.
    """

    name, order, turning = "Boris", 2, RATIONAL


class HigueraCary(ChargeMethod):
    """Boris's rotation with gamma of the mean velocity, which gives correct E x B drifts. Order 2.

    Higuera and Cary, Physics of Plasmas 24, 052104, 2017. For a charge that is not relativistic it is Boris's method.
    """

    name, order, turning = "Higuera-Cary", 2, MEAN

    def unsupported(self, form: Form | SceneForm) -> str | None:
        relativistic = isinstance(form, Charged) and form.light is not None
        return None if relativistic else "the charge is not relativistic: there it is Boris's method"


class VolumePreserving4(ChargeMethod):
    """Five symmetric steps with exact gyration, in Suzuki's lengths (He et al., JCP 305, 2016). Order 4."""

    name, order, turning = "Volume-preserving 4", 4, EXACT
    primary = False
    composition = Suzuki4


class VolumePreserving6(ChargeMethod):
    """Nine symmetric steps with exact gyration, in Kahan and Li's lengths (Math. Comput. 66, 1997). Order 6."""

    name, order, turning = "Volume-preserving 6", 6, EXACT
    composition = KahanLi6


INTEGRATORS: tuple[type[Integrator], ...] = (Boris, HigueraCary, VolumePreserving4, VolumePreserving6)
