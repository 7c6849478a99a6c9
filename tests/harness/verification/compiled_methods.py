"""Methods as people write them for numba: a step, an implicit step with its Jacobian, a solver, forces of velocities."""

import numba
import numpy as np

from gnomon.verify import Steps, from_solve, from_step


@numba.njit
def rk4(f, t, y, h):
    a = f(t, y)
    b = f(t + h / 2, y + h / 2 * a)
    c = f(t + h / 2, y + h / 2 * b)
    d = f(t + h, y + h * c)
    return y + h / 6 * (a + 2 * b + 2 * c + d)


@numba.njit
def midpoint(f, t, y, h, jac):
    """The implicit midpoint rule by Newton's iteration, for two variables: numba takes 6 s for `np.linalg.solve`."""
    found = y + h * f(t, y)
    for _ in range(8):
        middle = (y + found) / 2
        slope = jac(t + h / 2, middle)
        a, b = 1 - h / 2 * slope[0, 0], -h / 2 * slope[0, 1]
        c, d = -h / 2 * slope[1, 0], 1 - h / 2 * slope[1, 1]
        u, v = found - y - h * f(t + h / 2, middle)
        found = found - np.array([d * u - b * v, a * v - c * u]) / (a * d - b * c)
    return found


@numba.njit
def solve(f, t0, y0, times, h):
    """Fixed steps of RK4, all in compiled code; f is given an int, a row of a matrix and a column of one."""
    found = np.empty((len(times), len(y0)))
    t, y = t0, y0
    for k in range(len(times)):
        count = max(1, int(np.ceil((times[k] - t) / h * (1 - 1e-12))))
        step = (times[k] - t) / count
        for _ in range(count):
            y, t = rk4(f, t, y, step), t + step
        t = times[k]
        found[k] = y
    return found


@numba.njit
def newmark(f, t, y, h):
    """Newmark's method (gamma 1/2, beta 1/4) by fixed-point iteration."""
    half = len(y) // 2
    q, v = y[:half], y[half:]
    a = f(t, q, v)
    after = a
    for _ in range(30):
        after = f(t + h, q + h * v + h * h / 4 * (a + after), v + h / 2 * (a + after))
    return np.concatenate((q + h * v + h * h / 4 * (a + after), v + h / 2 * (a + after)))


compiled_rk4 = from_step(rk4, name="compiled RK4", order=4)
compiled_midpoint = from_step(midpoint, name="compiled midpoint", order=2)
compiled_solve = from_solve(solve, name="compiled solve", order=4, sweep=Steps())
compiled_newmark = from_step(newmark, name="compiled Newmark", order=2, velocities=True)
