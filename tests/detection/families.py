"""Right methods of many families, written as their users write them; `family_faults.py` declares them and changes their text.

Every method also goes backward, where times fall.
"""

# ruff: noqa: B023 - the functions of a step are used in that step only

from __future__ import annotations

import itertools
import math

import numpy as np
from gnomon.cases.core.scene import Readings
from gnomon.harness.contract.integrator import Integrator, Refused, Solution, Solver
from scipy.linalg import expm

ROOT2, ROOT3, ROOT6, ROOT15 = 2**0.5, 3**0.5, 6**0.5, 15**0.5


def jacobian(f, t, y):
    """By central differences."""
    columns = []
    for i in range(len(y)):
        up, down = y.copy(), y.copy()
        up[i] += 6e-6 * max(abs(y[i]), 1e-3)
        down[i] -= 6e-6 * max(abs(y[i]), 1e-3)
        columns.append((f(t, up) - f(t, down)) / (up[i] - down[i]))
    return np.array(columns).T


def time_derivative(f, t, y):
    """By central differences."""
    up, down = t + 6e-6 * max(abs(t), 1.0), t - 6e-6 * max(abs(t), 1.0)
    return (f(up, y) - f(down, y)) / (up - down)


def augmented(f, t, y):
    """(slope, Jacobian) of the state with the time as its last component."""
    n = len(y)
    whole = np.zeros((n + 1, n + 1))
    whole[:n, :n], whole[:n, n] = jacobian(f, t, y), time_derivative(f, t, y)
    if not np.all(np.isfinite(whole)):
        raise Refused("the Jacobian is not finite")
    return np.append(f(t, y), 1.0), whole


def phi(z, most):
    """exp(z), phi_1(z), ... of a matrix, from one exponential."""
    n = len(z)
    block = np.zeros((n * (most + 1), n * (most + 1)))
    block[:n, :n] = z
    for k in range(most):
        block[k * n : (k + 1) * n, (k + 1) * n : (k + 2) * n] = np.eye(n)
    row = expm(block)[:n]
    return [row[:, k * n : (k + 1) * n] for k in range(most + 1)]


# Exponential methods


def exponential_euler(f, t, y, h):
    """The exponential Rosenbrock method of order 2 (Pope 1963)."""
    slope, matrix = augmented(f, t, y)
    return y + h * (phi(h * matrix, 1)[1] @ slope)[:-1]


def exponential_midpoint(f, t, y, h):
    """The exponential midpoint rule, order 2 with any matrix."""
    matrix = jacobian(f, t, y)
    if not np.all(np.isfinite(matrix)):
        return np.full(len(y), np.nan)
    middle = y + h / 2 * phi(h / 2 * matrix, 1)[1] @ f(t, y)
    return y + h * phi(h * matrix, 1)[1] @ (f(t + h / 2, middle) - matrix @ (middle - y))


def exponential_rosenbrock3(f, t, y, h):
    """exprb32 of Hochbruck, Ostermann and Schweitzer (2009)."""
    slope, matrix = augmented(f, t, y)
    _, one, _, three = phi(h * matrix, 3)
    change = h * one @ slope
    rest = np.append(f(t + h, y + change[:-1]), 1.0) - slope - matrix @ change
    return y + (change + 2 * h * three @ rest)[:-1]


def grid(t0, times, step):
    """(steps between samples, step size) of equal steps."""
    every = max(1, math.ceil(abs(times[0] - t0) / step - 1e-9))
    h = (times[-1] - t0) / (len(times) * every)
    if not np.allclose(np.diff([t0, *times]), every * h, rtol=1e-6, atol=0):
        raise Refused("the samples are not equally spaced")
    return every, h


def semilinear(form, p, t0, y0, times, step, most, advance):
    """Equal steps of `advance(rest, t, y, h, half, whole)`, the last two exp(z), phi_1(z), ... for z = h L / 2 and h L."""
    every, h = grid(t0, times, step)
    linear = np.array(form.linear(p), dtype=float).reshape(len(y0), len(y0))
    half, whole = phi(h / 2 * linear, most), phi(h * linear, most)
    y, found = y0, []
    for k in range(every * len(times)):
        y = advance(lambda t, y: np.array(form.rest(t, tuple(y), p)), t0 + k * h, y, h, half, whole)
        if (k + 1) % every == 0:
            found.append(y)
    return np.array(found), None


def etd_rk4(form, p, t0, y0, times, step):
    """Cox and Matthews' exponential method of order 4 (2002)."""

    def advance(rest, t, y, h, halves, whole):
        (half, first, *_), (power, one, two, three) = halves, whole
        n = rest(t, y)
        a = half @ y + h / 2 * first @ n
        na = rest(t + h / 2, a)
        b = half @ y + h / 2 * first @ na
        nb = rest(t + h / 2, b)
        c = half @ a + h / 2 * first @ (2 * nb - n)
        nc = rest(t + h, c)
        ends = (one - 3 * two + 4 * three) @ n + (4 * three - two) @ nc
        return power @ y + h * (ends + 2 * (two - 2 * three) @ (na + nb))

    return semilinear(form, p, t0, y0, times, step, 3, advance)


def etd2(form, p, t0, y0, times, step):
    """The exponential method of Adams and Bashforth, order 2."""

    past = []

    def advance(rest, t, y, h, half, whole):
        power, one, two = whole
        past.append(rest(t, y))
        new = power @ y + h * one @ past[-1]
        return new + h * two @ (past[-1] - past[-2] if len(past) > 1 else rest(t + h, new) - past[-1])

    return semilinear(form, p, t0, y0, times, step, 2, advance)


def lawson4(form, p, t0, y0, times, step):
    """Runge and Kutta's method behind an integrating factor (Lawson 1967)."""

    def advance(rest, t, y, h, halves, whole):
        half = halves[0]
        a = rest(t, y)
        b = rest(t + h / 2, half @ (y + h / 2 * a))
        c = rest(t + h / 2, half @ y + h / 2 * b)
        d = rest(t + h, half @ (half @ y + h * c))
        return half @ (half @ (y + h / 6 * a) + h / 3 * (b + c)) + h / 6 * d

    return semilinear(form, p, t0, y0, times, step, 0, advance)


def strang(form, p, t0, y0, times, step):
    """Strang's splitting: half the linear part, the rest by the midpoint rule, half the linear part."""

    def advance(rest, t, y, h, halves, whole):
        half = halves[0]
        y = half @ y
        y = y + h * rest(t + h / 2, y + h / 2 * rest(t, y))
        return half @ y

    return semilinear(form, p, t0, y0, times, step, 0, advance)


# Rosenbrock methods and methods with implicit stages


def ros2(f, t, y, h):
    """ROS2 of Verwer (1999)."""
    g = 1 - 1 / ROOT2
    matrix, change = np.eye(len(y)) - g * h * jacobian(f, t, y), g * h * time_derivative(f, t, y)
    if not np.all(np.isfinite(matrix)):
        return np.full(len(y), np.nan)
    a = np.linalg.solve(matrix, f(t, y) + change)
    b = np.linalg.solve(matrix, f(t + h, y + h * a) - 2 * a - change)
    return y + h * (3 * a + b) / 2


def rosenbrock(f, t, y, h, gamma, alphas, gammas, a, c, m):
    """A Rosenbrock method in the transformed variables of Hairer and Wanner (IV.7)."""
    matrix, change = np.eye(len(y)) / (gamma * h) - jacobian(f, t, y), h * time_derivative(f, t, y)
    if not np.all(np.isfinite(matrix)):
        return np.full(len(y), np.nan)
    u = []
    for alpha, share, into, back in zip(alphas, gammas, a, c, strict=True):
        here = y + sum((w * x for w, x in zip(into, u, strict=True)), 0 * y)
        rest = sum((w * x for w, x in zip(back, u, strict=True)), 0 * y) / h
        u.append(np.linalg.solve(matrix, f(t + alpha * h, here) + rest + share * change))
    return y + sum(w * x for w, x in zip(m, u, strict=True))


def ros3p(f, t, y, h):
    """ROS3P of Lang and Verwer (2001)."""
    g = (3 + ROOT3) / 6
    into, back = ((), (1 / g,), (1 / g, 0)), ((), (-1 / g**2,), (-2 * ROOT3, -ROOT3))
    return rosenbrock(f, t, y, h, g, (0, 1, 1), (g, g - 1, 0.5 - 2 * g), into, back, (2, 1 / ROOT3, 1 - 1 / ROOT3))


RODAS_A = (
    (),
    (1.544,),
    (0.9466785280815826, 0.2557011698983284),
    (3.314825187068521, 2.896124015972201, 0.9986419139977817),
    (1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950),
    (1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950, 1.0),
)
RODAS_C = (
    (),
    (-5.6688,),
    (-2.430093356833875, -0.2063599157091915),
    (-0.1073529058151375, -9.594562251023355, -20.47028614809616),
    (7.496443313967647, -10.24680431464352, -33.99990352819905, 11.70890893206160),
    (8.083246795921522, -7.981132988064893, -31.52159432874371, 16.31930543123136, -6.058818238834054),
)
"""RODAS (Hairer and Wanner, VI.4)."""


def rodas4(f, t, y, h):
    alphas, gammas = (0, 0.386, 0.21, 0.63, 1, 1), (0.25, -0.1043, 0.1035, -0.0362, 0, 0)
    return rosenbrock(f, t, y, h, 0.25, alphas, gammas, RODAS_A, RODAS_C, (*RODAS_A[5], 1.0))


def converged(y, change, before):
    """Whether an iteration has reached round-off: the change is tiny, or small and no longer halved."""
    size, scale = np.max(np.abs(change)), np.max(np.abs(y))
    return not size > 1e-15 * scale or (size < 1e-11 * scale and size > before / 2)


def implicit(f, t, base, weight, guess):
    """y = base + weight f(t, y), by Newton's iteration with one Jacobian of differences."""
    matrix, y, before = np.eye(len(base)) - weight * jacobian(f, t, guess), guess, math.inf
    if not np.all(np.isfinite(matrix)):
        return np.full(len(base), np.nan)
    for _ in range(50):
        change = np.linalg.solve(matrix, base + weight * f(t, y) - y)
        y = y + change
        if converged(y, change, before):
            return y
        before = np.max(np.abs(change))
    raise Refused("Newton's iteration does not converge")


def diagonally_implicit(f, t, y, h, rows, weights):
    slopes = []
    for row in rows:
        base = y + h * sum((w * k for w, k in zip(row, slopes, strict=False)), 0 * y)
        time = t + sum(row) * h
        if len(row) > len(slopes):
            stage = implicit(f, time, base, h * row[-1], y)
            slopes.append((stage - base) / (h * row[-1]))
        else:
            slopes.append(f(time, base))
    return y + h * sum(w * k for w, k in zip(weights, slopes, strict=True))


def sdirk2(f, t, y, h):
    """Alexander's method of order 2."""
    g = 1 - 1 / ROOT2
    return diagonally_implicit(f, t, y, h, ((g,), (1 - g, g)), (1 - g, g))


def sdirk3(f, t, y, h):
    """Crouzeix' method of order 3."""
    g = (3 + ROOT3) / 6
    return diagonally_implicit(f, t, y, h, ((g,), (1 - 2 * g, g)), (1 / 2, 1 / 2))


def sdirk4(f, t, y, h):
    """Hairer and Wanner's method of order 4 (IV.6, table 6.5)."""
    last = (25 / 24, -49 / 48, 125 / 16, -85 / 12, 1 / 4)
    rows = ((1 / 4,), (1 / 2, 1 / 4), (17 / 50, -1 / 25, 1 / 4), (371 / 1360, -137 / 2720, 15 / 544, 1 / 4), last)
    return diagonally_implicit(f, t, y, h, rows, last)


def trbdf2(f, t, y, h):
    """Trapezoidal rule and BDF2 in one step (Bank and others 1985)."""
    last = (ROOT2 / 4, ROOT2 / 4, 1 - ROOT2 / 2)
    return diagonally_implicit(f, t, y, h, ((), (1 - ROOT2 / 2, 1 - ROOT2 / 2), last), last)


def collocation(f, t, y, h, rows, weights):
    """Stages by iteration to round-off."""
    a, b = np.array(rows), np.array(weights)
    nodes = a.sum(axis=1)
    k, before = np.array([f(t, y)] * len(b)), math.inf
    for _ in range(150):
        last = k
        k = np.array([f(t + c * h, y + h * row @ last) for c, row in zip(nodes, a, strict=True)])
        if not np.all(np.isfinite(k)) or converged(k, k - last, before):
            return y + h * b @ k
        before = np.max(np.abs(k - last))
    raise Refused("the iteration of the stages does not converge")


def gauss6(f, t, y, h):
    s = ROOT15
    rows = (
        (5 / 36, 2 / 9 - s / 15, 5 / 36 - s / 30),
        (5 / 36 + s / 24, 2 / 9, 5 / 36 - s / 24),
        (5 / 36 + s / 30, 2 / 9 + s / 15, 5 / 36),
    )
    return collocation(f, t, y, h, rows, (5 / 18, 4 / 9, 5 / 18))


def radau5(f, t, y, h):
    """Radau IIA of order 5."""
    s = ROOT6
    last = ((16 - s) / 36, (16 + s) / 36, 1 / 9)
    rows = (
        ((88 - 7 * s) / 360, (296 - 169 * s) / 1800, (3 * s - 2) / 225),
        ((296 + 169 * s) / 1800, (88 + 7 * s) / 360, (-2 - 3 * s) / 225),
        last,
    )
    return collocation(f, t, y, h, rows, last)


def lobatto4(f, t, y, h):
    """Lobatto IIIA of order 4 (Hermite and Simpson)."""
    return collocation(f, t, y, h, ((0, 0, 0), (5 / 24, 1 / 3, -1 / 24), (1 / 6, 2 / 3, 1 / 6)), (1 / 6, 2 / 3, 1 / 6))


# Methods of several steps

CASH_KARP = (
    (),
    (1 / 5,),
    (3 / 40, 9 / 40),
    (3 / 10, -9 / 10, 6 / 5),
    (-11 / 54, 5 / 2, -70 / 27, 35 / 27),
    (1631 / 55296, 175 / 512, 575 / 13824, 44275 / 110592, 253 / 4096),
)
CASH_KARP_5 = (37 / 378, 0, 250 / 621, 125 / 594, 0, 512 / 1771)
CASH_KARP_4 = (2825 / 27648, 0, 18575 / 48384, 13525 / 55296, 277 / 14336, 1 / 4)


def stages(f, t, y, h, rows, first=None):
    """The slopes of an explicit method."""
    k = [f(t, y) if first is None else first]
    for row in rows[1:]:
        k.append(f(t + sum(row) * h, y + h * sum(w * s for w, s in zip(row, k, strict=True))))
    return k


def combined(weights, k):
    return sum(w * s for w, s in zip(weights, k, strict=True))


def multistep(f, t0, y0, times, step, past, advance):
    """Equal steps of `advance(f, t, h, states, slopes)` of the last `past` states; the start is Cash and Karp's."""
    every, h = grid(t0, times, step)
    ys, slopes, found = [y0], [f(t0, y0)], []
    for k in range(every * len(times)):
        t = t0 + k * h
        if k < past - 1:
            y = ys[-1] + h * combined(CASH_KARP_5, stages(f, t, ys[-1], h, CASH_KARP))
        else:
            y = advance(f, t, h, ys, slopes)
        ys, slopes = [*ys, y][-past:], [*slopes, f(t + h, y)][-past:]
        if (k + 1) % every == 0:
            found.append(y)
    return np.array(found)


def adams_bashforth5(f, t0, y0, times, step):
    def advance(f, t, h, ys, s):
        return ys[-1] + h / 720 * (1901 * s[4] - 2774 * s[3] + 2616 * s[2] - 1274 * s[1] + 251 * s[0])

    return multistep(f, t0, y0, times, step, 5, advance)


def adams_moulton4(f, t0, y0, times, step):
    """Implicit, by Newton's iteration."""

    def advance(f, t, h, ys, s):
        base = ys[-1] + h / 24 * (19 * s[2] - 5 * s[1] + s[0])
        return implicit(f, t + h, base, 9 * h / 24, ys[-1] + h * s[2])

    return multistep(f, t0, y0, times, step, 3, advance)


def bdf2(f, t0, y0, times, step):
    def advance(f, t, h, ys, s):
        return implicit(f, t + h, (4 * ys[1] - ys[0]) / 3, 2 * h / 3, ys[1] + h * s[1])

    return multistep(f, t0, y0, times, step, 2, advance)


def bdf4(f, t0, y0, times, step):
    def advance(f, t, h, ys, s):
        base = (48 * ys[3] - 36 * ys[2] + 16 * ys[1] - 3 * ys[0]) / 25
        return implicit(f, t + h, base, 12 * h / 25, ys[3] + h * s[3])

    return multistep(f, t0, y0, times, step, 4, advance)


def nordsieck4(f, t0, y0, times, step):
    """Adams and Moulton's method of order 4 in Nordsieck's form; the start is of order 4 too."""
    every, h = grid(t0, times, step)
    y, slopes = y0, [h * f(t0, y0)]
    for k in range(3):
        y = y + h * combined(CASH_KARP_5, stages(f, t0 + k * h, y, h, CASH_KARP))
        slopes.append(h * f(t0 + (k + 1) * h, y))
    a, b, c, d = slopes
    z = np.array([y0, a, (-11 * a + 18 * b - 9 * c + 2 * d) / 12, (2 * a - 5 * b + 4 * c - d) / 6])
    found = []
    for k in range(every * len(times)):
        t = t0 + (k + 1) * h
        z = np.array([z[0] + z[1] + z[2] + z[3], z[1] + 2 * z[2] + 3 * z[3], z[2] + 3 * z[3], z[3]])
        for weight in (1, 1):
            lack = h * f(t, z[0]) - z[1]
            z = z + weight * np.outer((3 / 8, 1, 3 / 4, 1 / 6), lack)
        if (k + 1) % every == 0:
            found.append(z[0])
    return np.array(found)


def stormer4(f, t0, y0, times, step):
    """Stoermer's method of order 4 in summed form, velocities by Adams and Moulton's."""
    every, h = grid(t0, times, step)
    q, v = np.split(y0, 2)
    forces, found, mean = [f(t0, q)], [], None
    for k in range(every * len(times)):
        t = t0 + k * h
        if k < 3:
            before = q
            q, v = np.split(nystrom5(f, t, np.concatenate([q, v]), h), 2)
            mean = (q - before) / h
            forces.append(f(t + h, q))
        else:
            a, b, c, d = forces
            mean = mean + h / 12 * (14 * d - 5 * c + 4 * b - a)
            q = q + h * mean
            forces = [b, c, d, f(t + h, q)]
            v = v + h / 24 * (9 * forces[3] + 19 * d - 5 * c + b)
        if (k + 1) % every == 0:
            found.append(np.concatenate([q, v]))
    return np.array(found)


# Extrapolation, deferred correction, parallel in time


def neville(rows, counts, power):
    """The extrapolation of results with counts[k] substeps, whose error has powers of h^power."""
    for level in range(1, len(rows)):
        rows = [
            new + (new - old) / ((counts[k + level] / counts[k]) ** power - 1)
            for k, (old, new) in enumerate(itertools.pairwise(rows))
        ]
    return rows[0]


def gragg8(f, t, y, h):
    """Gragg's method, extrapolated to order 8."""
    first, rows, counts = f(t, y), [], (2, 4, 6, 8)
    for n in counts:
        z, w = y, y + h / n * first
        for i in range(1, n):
            z, w = w, z + 2 * h / n * f(t + i * h / n, w)
        rows.append(w)
    return neville(rows, counts, 2)


def euler_extrapolated(f, t, y, h):
    """Euler's method, extrapolated to order 4."""
    rows, counts = [], (1, 2, 3, 4)
    for n in counts:
        z = y
        for i in range(n):
            z = z + h / n * f(t + i * h / n, z)
        rows.append(z)
    return neville(rows, counts, 1)


def linearly_implicit_extrapolated(f, t, y, h):
    """The linearly implicit Euler method (Deuflhard 1985), extrapolated to order 3."""
    matrix, rows, counts = jacobian(f, t, y), [], (1, 2, 3)
    if not np.all(np.isfinite(matrix)):
        return np.full(len(y), np.nan)
    for n in counts:
        z, inverse = y, np.linalg.inv(np.eye(len(y)) - h / n * matrix)
        for i in range(n):
            z = z + inverse @ (h / n * f(t + (i + 1) * h / n, z))
        rows.append(z)
    return neville(rows, counts, 1)


def deferred_correction(f, t, y, h):
    """Spectral deferred correction (Dutt, Greengard and Rokhlin 2000): three nodes, Euler's method, three sweeps."""
    nodes, weights = (0, 1 / 2, 1), np.array([[5 / 24, 1 / 3, -1 / 24], [-1 / 24, 1 / 3, 5 / 24]])
    first = f(t, y)
    middle = y + h / 2 * first
    slopes = [first, f(t + h / 2, middle)]
    end = middle + h / 2 * slopes[1]
    slopes.append(f(t + h, end))
    for _ in range(3):
        state, new = y, [first]
        for m in range(2):
            state = state + h / 2 * (new[m] - slopes[m]) + h * weights[m] @ np.array(slopes)
            new.append(f(t + nodes[m + 1] * h, state))
        slopes, end = new, state
    return end


def parareal(f, t0, y0, times, step):
    """Windows of four samples, coarse and fine by Runge and Kutta's method; iterated until nothing changes."""

    def follow(t, y, end, count):
        h = (end - t) / count
        for i in range(count):
            y = kutta(f, t + i * h, y, h)
        return y

    found, ends = [], [t0, *times]
    fine = max(1, math.ceil(abs(times[0] - t0) / step - 1e-9))
    for begin in range(0, len(times), 4):
        window = ends[begin : begin + 5]
        pieces = [*itertools.pairwise(window)]
        states = [found[-1] if found else y0]
        for a, b in pieces:
            states.append(follow(a, states[-1], b, 1))
        for _ in pieces:
            coarse = [follow(a, y, b, 1) for (a, b), y in zip(pieces, states, strict=False)]
            exact = [follow(a, y, b, fine) for (a, b), y in zip(pieces, states, strict=False)]
            before, states = states, states[:1]
            for k, (a, b) in enumerate(pieces):
                states.append(exact[k] + np.nan_to_num(follow(a, states[k], b, 1) - coarse[k], posinf=0, neginf=0))
            if np.array_equal(states, before):
                break
        found += states[1:]
    return np.array(found)


def kutta(f, t, y, h):
    a = f(t, y)
    b = f(t + h / 2, y + h / 2 * a)
    c = f(t + h / 2, y + h / 2 * b)
    d = f(t + h, y + h * c)
    return y + h / 6 * (a + 2 * b + 2 * c + d)


# Accelerations: Nystroem's methods, splittings, variable steps


def nystrom5(f, t, y, h):
    """Nystroem's method of order 5 (Hairer, Norsett and Wanner, II.14)."""
    q, v = np.split(y, 2)
    a = f(t, q)
    b = f(t + h / 5, q + h / 5 * v + h * h / 50 * a)
    c = f(t + 2 / 3 * h, q + 2 / 3 * h * v + h * h / 27 * (7 * b - a))
    d = f(t + h, q + h * v + h * h / 70 * (21 * a - 4 * b + 18 * c))
    q = q + h * v + h * h / 336 * (14 * a + 100 * b + 54 * c)
    v = v + h / 336 * (14 * a + 125 * b + 162 * c + 35 * d)
    return np.concatenate([q, v])


def splitting(f, t, y, h, drifts, kicks):
    q, v = np.split(y, 2)
    for drift, kick in zip(drifts, kicks, strict=True):
        q, t = q + drift * h * v, t + drift * h
        if kick:
            v = v + kick * h * f(t, q)
    return np.concatenate([q, v])


def ruth3(f, t, y, h):
    """Ruth's method of order 3 (1983)."""
    return splitting(f, t, y, h, (1, -2 / 3, 2 / 3, 0), (-1 / 24, 3 / 4, 7 / 24, 0))


def blanes_moan4(f, t, y, h):
    """S6 of order 4 (Blanes and Moan 2002)."""
    a, b = [0.0792036964311957, 0.353172906049774, -0.0420650803577195], [0.209515106613362, -0.143851773179818]
    kicks = [*b, 1 / 2 - sum(b)]
    return splitting(f, t, y, h, (*a, 1 - 2 * sum(a), *a[::-1]), (*kicks, *kicks[::-1], 0))


def leapfrogs(f, t, y, h, parts):
    """A composition of leapfrog steps."""
    for part in parts:
        y, t = splitting(f, t, y, part * h, (1 / 2, 1 / 2), (1, 0)), t + part * h
    return y


def suzuki4(f, t, y, h):
    s = 1 / (4 - 4 ** (1 / 3))
    return leapfrogs(f, t, y, h, (s, s, 1 - 4 * s, s, s))


KAHAN_LI = (0.39216144400731413928, 0.33259913678935943860, -0.70624617255763935981, 0.08221359629355080023)
"""The outer parts of the composition of nine steps and order 6 (Kahan and Li 1997)."""


def kahan_li6(f, t, y, h):
    return leapfrogs(f, t, y, h, (*KAHAN_LI, 1 - 2 * sum(KAHAN_LI), *KAHAN_LI[::-1]))


def chebyshev_verlet(f, t0, y0, times, step):
    """Verlet's method with steps that are shorter near the samples, the same forward and backward."""
    (q, v), t, found = np.split(y0, 2), t0, []
    for end in times:
        count = max(1, math.ceil(abs(end - t) / step - 1e-9))
        ends = t + (end - t) / 2 * (1 - np.cos(np.pi * np.arange(count + 1) / count))
        for start, h in zip(ends, np.diff(ends), strict=False):
            v = v + h / 2 * f(start, q)
            q = q + h * v
            v = v + h / 2 * f(start + h, q)
        t = end
        found.append(np.concatenate([q, v]))
    return np.array(found)


def adaptive_verlet(f, t0, y0, times, step):
    """Steps divided by a density that the force sets (Huang and Leimkuhler 1997); samples from Hermite's cubic."""
    (q, v), t, found, sign = np.split(y0, 2), t0, [], np.sign(times[-1] - t0)
    first = f(t0, q)
    size, most = first @ first or 1.0, 100 * abs(times[-1] - t0) / step + 1000
    density, count = 2.0**0.25, 0
    while len(found) < len(times):
        count += 1
        h = sign * step / density
        if not h * sign > 0 or t + h == t or count > most:
            return np.array([*found, *[np.full(len(y0), np.nan)] * (len(times) - len(found))])
        middle = q + h / 2 * v
        a = f(t + h / 2, middle)
        density = (1 + a @ a / size) ** 0.5 / density
        after = sign * step / density
        speed = v + (h + after) / 2 * a
        place, end = middle + after / 2 * speed, t + (h + after) / 2
        while len(found) < len(times) and sign * (times[len(found)] - end) <= 0:
            whole = end - t
            x = (times[len(found)] - t) / whole
            rise = place - q
            found.append(np.concatenate([
                q + x * (rise + (1 - x) * ((1 - x) * (whole * v - rise) + x * (rise - whole * speed))),
                v + 6 * x * (1 - x) * (rise / whole - v) + x * (3 * x - 2) * (speed - v),
            ]))  # fmt: skip
        t, q, v = end, place, speed
    return np.array(found)


def compensated_verlet(f, t0, y0, times, step):
    """Verlet's method with Kahan's sums."""
    every, h = grid(t0, times, step)
    (q, v), a, found = np.split(y0, 2), f(t0, np.split(y0, 2)[0]), []
    q_rest, v_rest = 0 * q, 0 * v
    for k in range(every * len(times)):
        change = h * (v + h / 2 * a) + q_rest
        q, q_rest = q + change, change - ((q + change) - q)
        force = f(t0 + (k + 1) * h, q)
        change = h / 2 * (a + force) + v_rest
        v, v_rest, a = v + change, change - ((v + change) - v), force
        if (k + 1) % every == 0:
            found.append(np.concatenate([q, v]))
    return np.array(found)


# Pairs with a step size of their own


def error_size(error, y, new):
    """The root of the mean square of errors over sizes; small components count as a thousandth of the largest."""
    sizes = np.maximum(np.abs(y), np.abs(new))
    scale = np.maximum(sizes, max(1e-3 * np.max(sizes), 1e-300))
    return np.sqrt(np.mean((error / scale) ** 2))


def hermite(x, h, y, new, a, b):
    """The cubic through two states with their slopes."""
    return (1 + 2 * x) * (1 - x) ** 2 * y + x * x * (3 - 2 * x) * new + h * x * (1 - x) * ((1 - x) * a - x * b)


def adaptive(f, t0, y0, times, tolerance, step, order, dense=None):
    """Steps of a pair: `step(t, y, h, first slope)` -> (state, error, slope there or None).

    With `dense` samples before the last are interpolated, without it steps end at them.
    """
    t, y, a, h, found = t0, y0, f(t0, y0), 1e-3 * (times[-1] - t0), []
    sign = np.sign(h)
    while len(found) < len(times):
        goal = times[-1] if dense else times[len(found)]
        last = abs(h) >= abs(goal - t)
        taken = goal - t if last else h
        if abs(taken) < 1e-15 * max(abs(t), 1e-300):
            return np.array([*found, *[np.full(len(y0), np.nan)] * (len(times) - len(found))])
        new, error, b = step(t, y, taken, a)
        size = error_size(error, y, new) / tolerance
        if not np.isfinite(size):
            h = taken / 5
            continue
        if size <= 1:
            end = goal if last else t + taken
            b = f(end, new) if b is None else b
            if dense is None and last:
                found.append(new)
            while dense and len(found) < len(times) and sign * (times[len(found)] - end) <= 0:
                found.append(dense((times[len(found)] - t) / taken, taken, y, new, a, b))
            t, y, a = end, new, b
        factor = min(5.0, max(0.2, 0.9 * max(size, 1e-10) ** (-1 / order)))
        h = h if last and size <= 1 and abs(factor * taken) < abs(h) else factor * taken
    return np.array(found)


def cash_karp(f, t0, y0, times, tolerance):
    """Cash and Karp's pair 5(4) with Hermite's interpolant."""

    def step(t, y, h, a):
        k = stages(f, t, y, h, CASH_KARP, a)
        new = y + h * combined(CASH_KARP_5, k)
        return new, y + h * combined(CASH_KARP_4, k) - new, None

    return adaptive(f, t0, y0, times, tolerance, step, 5, hermite)


def bogacki_dense(f, t0, y0, times, tolerance):
    """Bogacki and Shampine's pair 3(2) with Hermite's interpolant."""

    def step(t, y, h, a):
        b = f(t + h / 2, y + h / 2 * a)
        c = f(t + 3 / 4 * h, y + 3 / 4 * h * b)
        new = y + h / 9 * (2 * a + 3 * b + 4 * c)
        d = f(t + h, new)
        return new, h * (-5 / 72 * a + b / 12 + c / 9 - d / 8), d

    return adaptive(f, t0, y0, times, tolerance, step, 3, hermite)


FEHLBERG = (
    (),
    (1 / 4,),
    (3 / 32, 9 / 32),
    (1932 / 2197, -7200 / 2197, 7296 / 2197),
    (439 / 216, -8, 3680 / 513, -845 / 4104),
    (-8 / 27, 2, -3544 / 2565, 1859 / 4104, -11 / 40),
)


def fehlberg45(f, t0, y0, times, tolerance):
    """Fehlberg's pair 5(4); steps end at the samples."""

    def step(t, y, h, a):
        k = stages(f, t, y, h, FEHLBERG, a)
        new = y + h * combined((16 / 135, 0, 6656 / 12825, 28561 / 56430, -9 / 50, 2 / 55), k)
        return new, h * combined((1 / 360, 0, -128 / 4275, -2197 / 75240, 1 / 50, 2 / 55), k), None

    return adaptive(f, t0, y0, times, tolerance, step, 5)


FEHLBERG_8 = (
    (),
    (2 / 27,),
    (1 / 36, 1 / 12),
    (1 / 24, 0, 1 / 8),
    (5 / 12, 0, -25 / 16, 25 / 16),
    (1 / 20, 0, 0, 1 / 4, 1 / 5),
    (-25 / 108, 0, 0, 125 / 108, -65 / 27, 125 / 54),
    (31 / 300, 0, 0, 0, 61 / 225, -2 / 9, 13 / 900),
    (2, 0, 0, -53 / 6, 704 / 45, -107 / 9, 67 / 90, 3),
    (-91 / 108, 0, 0, 23 / 108, -976 / 135, 311 / 54, -19 / 60, 17 / 6, -1 / 12),
    (2383 / 4100, 0, 0, -341 / 164, 4496 / 1025, -301 / 82, 2133 / 4100, 45 / 82, 45 / 164, 18 / 41),
    (3 / 205, 0, 0, 0, 0, -6 / 41, -3 / 205, -3 / 41, 3 / 41, 6 / 41, 0),
    (-1777 / 4100, 0, 0, -341 / 164, 4496 / 1025, -289 / 82, 2193 / 4100, 51 / 82, 33 / 164, 12 / 41, 0, 1),
)


def fehlberg78(f, t0, y0, times, tolerance):
    """Fehlberg's pair 8(7); steps end at the samples."""

    def step(t, y, h, a):
        k = stages(f, t, y, h, FEHLBERG_8, a)
        new = y + h * combined((0, 0, 0, 0, 0, 34 / 105, 9 / 35, 9 / 35, 9 / 280, 9 / 280, 0, 41 / 840, 41 / 840), k)
        return new, 41 / 840 * h * (k[0] + k[10] - k[11] - k[12]), None

    return adaptive(f, t0, y0, times, tolerance, step, 8)


def nystrom_doubled(f, t0, y0, times, tolerance):
    """Nystroem's method of order 5; the error is the difference of one step and two halves."""

    def step(t, y, h, a):
        half = nystrom5(f, t, y, h / 2)
        new = nystrom5(f, t + h / 2, half, h / 2)
        return new, (new - nystrom5(f, t, y, h)) / 31, a

    return adaptive(f, t0, y0, times, tolerance, step, 6)


def ros2_adaptive(f, t0, y0, times, tolerance):
    """ROS2 with the linearly implicit Euler step as its estimate, and Hermite's interpolant."""
    g = 1 - 1 / ROOT2

    def step(t, y, h, a):
        matrix, change = np.eye(len(y)) - g * h * jacobian(f, t, y), g * h * time_derivative(f, t, y)
        if not np.all(np.isfinite(matrix)):
            return y, np.full(len(y), np.nan), None
        one = np.linalg.solve(matrix, a + change)
        two = np.linalg.solve(matrix, f(t + h, y + h * one) - 2 * one - change)
        return y + h * (3 * one + two) / 2, h * (one + two) / 2, None

    return adaptive(f, t0, y0, times, tolerance, step, 2, hermite)


# Events, a class, an engine


def kutta3_events(form, p, t0, y0, times, step):
    """Kutta's method of order 3 with a root finder of its own on Hermite's cubic; a step ends at the first event in it."""
    p = tuple(p)
    every, h = grid(t0, times, step)
    t, y, found, events, before = t0, y0, [], [], {}
    mode = form.mode(form.start(t0, tuple(y0), p))
    for k in range(every * len(times)):
        end = t0 + (k + 1) * h
        while t < end:

            def f(t, y):
                return np.array(mode.equations(t, tuple(y), p + mode.constants))

            whole = end - t
            a = f(t, y)
            b = f(t + whole / 2, y + whole / 2 * a)
            c = f(t + whole, y + whole * (2 * b - a))
            new = y + whole / 6 * (a + 4 * b + c)
            d = f(end, new)

            def at(x):
                return hermite(x, whole, y, new, a, d)

            first = None
            for event in [e for e in form.transitions if e.mode == mode.name]:

                def side(x):
                    return event.direction * event.guard(t + x * whole, tuple(at(x)), p)[0]

                high = 1.0 if first is None else first[0]
                if not side(high) > 0:
                    continue
                low = high / 2
                while side(low) >= 0 and low > 1e-12:
                    low, high = low / 2, low
                below, above = side(low), side(high)
                for _ in range(100):  # the Illinois rule of false position
                    x = (low * above - high * below) / (above - below) if above > below else (low + high) / 2
                    if not low < x < high:
                        break
                    value = side(x)
                    if value > 0:
                        high, above, below = x, value, below / 2
                    else:
                        low, below, above = x, value, above / 2
                    if high - low < 1e-15 or value == 0:
                        break
                first = high, event
            if first is None:
                y, t = new, end
                continue
            x, event = first
            y, t = at(x), t + x * whole
            limit = next((row for row in form.limits if row[0] == event.name), None)
            if limit and t - before.get(event.name, -np.inf) <= form.settle:
                mode, y = form.mode(limit[1]), np.array(limit[2](t, tuple(y), p), dtype=float)
                events.append((t, "limit"))
            else:
                y = np.array(event.reset(t, tuple(y), p), dtype=float)
                mode = form.mode(event.lands(t, tuple(y), p))
                events.append((t, event.name))
            before[event.name] = t
        if (k + 1) % every == 0:
            found.append(y)
    return np.array(found), events


class KuttaClass(Integrator):
    """Kutta's three-eighths rule as a class of its own, which evaluates the equations of the problem itself."""

    counts_rhs = False

    def prepare(self, problem, setting):
        if not 0 < setting <= 2 * abs(problem.interval):
            raise Refused(f"step size {setting}")
        p = tuple(problem.parameters.tolist())

        def f(t, y):
            try:
                return np.array(problem.form.equations(t, tuple(y.tolist()), p))
            except (ArithmeticError, ValueError):
                return np.full(len(y), np.nan)

        def solve(starts):
            runs, steps = [], 0
            for start in starts:
                t, y, found = problem.t0, start, []
                for end in problem.times.tolist():
                    count = max(1, math.ceil(abs(end - t) / setting - 1e-9))
                    h = (end - t) / count
                    for i in range(count):
                        now = t + i * h
                        a = f(now, y)
                        b = f(now + h / 3, y + h / 3 * a)
                        c = f(now + 2 / 3 * h, y + h * (b - a / 3))
                        d = f(now + h, y + h * (a - b + c))
                        y = y + h / 8 * (a + 3 * b + 3 * c + d)
                    t, steps = end, steps + count
                    found.append(y)
                runs.append(found)
            return Solution(np.array(runs), steps)

        return Solver(solve)


def cross(a, b):
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def product(p, q):
    """Of quaternions (vector, scalar)."""
    return np.array([*(p[3] * q[:3] + q[3] * p[:3] + cross(p[:3], q[:3])), p[3] * q[3] - p[:3] @ q[:3]])


def frame(q):
    """The rotation of a unit quaternion, from the body's axes to space."""
    x, y, z, w = q
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip


class FreeBodies:
    """An engine of free bodies and planes: exact flight between exact impacts, the implicit midpoint rule for the spin."""

    def load(self, scene):
        self.scene, self.gravity = scene, np.array(scene.gravity, dtype=float)
        self.states = {
            body.name: [np.array(x, dtype=float) for x in (body.position, body.quaternion, body.velocity, body.angular_velocity)]
            for body in scene.bodies
        }  # fmt: skip

    def step(self, dt):
        for body in self.scene.bodies:
            x, q, v, w = self.states[body.name]
            x, v = self.fly(body, x, v, dt)
            q, w = self.turn(np.array(body.inertia, dtype=float), q, w, dt)
            self.states[body.name] = [x, q, v, w]

    def turn(self, moments, q, w, dt):
        if not moments.any():
            return q, w
        old = frame(q).T @ w
        new = middle = old
        for _ in range(50):
            middle = (old + new) / 2
            before, new = new, old + dt * cross(moments * middle, middle) / moments
            if np.max(np.abs(new - before)) <= 4e-16 * np.max(np.abs(new)):
                break
        angle = dt * np.linalg.norm(middle)
        q = product(q, np.append(np.sinc(angle / 2 / np.pi) / 2 * dt * middle, np.cos(angle / 2)))
        q = q / np.linalg.norm(q)
        return q, frame(q) @ new

    def fly(self, body, x, v, dt):
        g = self.gravity
        while True:
            hit, contact = dt, None
            for each in self.scene.contacts:
                time = self.fall(body, each, x, v, g) if each.body == body.name else math.inf
                if time < hit:
                    hit, contact = time, each
            x, v, dt = x + hit * v + hit * hit / 2 * g, v + hit * g, dt - hit
            if contact is None:
                return x, v
            n = np.array(contact.normal)
            speed = -(n @ v)
            v = v + (speed + self.restitution(contact.restitution, speed) * speed) * n
            if n @ v < 1e-9 and n @ g < 0:  # it rests
                v, g = v - (n @ v) * n, g - (n @ g) * n

    def fall(self, body, contact, x, v, g):
        """The time until a body falls onto a plane."""
        n = np.array(contact.normal)
        size = body.radius if body.radius is not None else np.abs(n) @ np.array(body.half_extents)
        gap, rise, pull = max(0.0, float(n @ x - size)), float(n @ v), -float(n @ g)
        if pull <= 1e-12:
            return gap / -rise if rise < -1e-12 else math.inf
        root = math.sqrt(rise * rise + 2 * pull * gap)
        return (rise + root) / pull if rise >= 0 else 2 * gap / (root - rise)

    def restitution(self, e, speed):
        return e

    def read(self):
        return Readings(
            bodies={name: tuple(tuple(part.tolist()) for part in state) for name, state in self.states.items()}
        )
