"""More right methods, each for a form of equations or with more than one motion; `planted_faults.py` changes their text."""

import math

import numpy as np


def nystrom(f, t, y, h):
    """Nyström's method of order 4 (Hairer, Nørsett and Wanner, II.14)."""
    q, v = np.split(y, 2)
    a = f(t, q)
    b = f(t + h / 2, q + h / 2 * v + h * h / 8 * a)
    c = f(t + h, q + h * v + h * h / 2 * b)
    q = q + h * v + h * h / 6 * (a + 2 * b)
    v = v + h / 6 * (a + 4 * b + c)
    return np.concatenate([q, v])


PARTS = (0.784513610477557263819497633866, 0.235573213359358133684793182978, -1.17767998417887100694641568096)
"""Yoshida's solution A of order 6, the outer parts first (Physics Letters A 150, 1990)."""


def yoshida6(f, t, y, h):
    q, v = np.split(y, 2)
    for part in (*PARTS, 1 - 2 * sum(PARTS), *PARTS[::-1]):
        v = v + part * h / 2 * f(t, q)
        q = q + part * h * v
        t = t + part * h
        v = v + part * h / 2 * f(t, q)
    return np.concatenate([q, v])


def jacobian(f, t, y):
    """By forward differences."""
    base, columns = f(t, y), []
    for i in range(len(y)):
        moved = y.copy()
        moved[i] += 1e-7 * max(abs(y[i]), 1e-3)
        columns.append((f(t, moved) - base) / (moved[i] - y[i]))
    return np.array(columns).T


def radau3(f, t, y, h):
    """Radau IIA of two stages and order 3, by Newton's iteration with one Jacobian a step."""
    a = np.array([[5 / 12, -1 / 12], [3 / 4, 1 / 4]])
    n, c = len(y), (1 / 3, 1.0)
    matrix = np.eye(2 * n) - h * np.kron(a, jacobian(f, t, y))
    z = np.zeros((2, n))
    if not np.all(np.isfinite(matrix)):
        return np.full(n, np.nan)
    for _ in range(50):
        slopes = np.array([f(t + c[i] * h, y + z[i]) for i in range(2)])
        change = np.linalg.solve(matrix, (h * a @ slopes - z).ravel()).reshape(2, n)
        z = z + change
        if not np.max(np.abs(change)) > 1e-15 * np.max(np.abs(y)):
            break
    return y + z[1]


def abm(f, t0, y0, times, step):
    """Adams, Bashforth and Moulton's pair of order 4 in the mode PECE; the start is Runge and Kutta's."""
    count = round((times[-1] - t0) / step)
    every, h = count // len(times), (times[-1] - t0) / count
    y, found, past = y0, [], [f(t0, y0)]
    for k in range(count):
        t = t0 + k * h
        if k < 3:
            a = past[-1]
            b = f(t + h / 2, y + h / 2 * a)
            c = f(t + h / 2, y + h / 2 * b)
            y = y + h / 6 * (a + 2 * b + 2 * c + f(t + h, y + h * c))
        else:
            w, x, u, s = past[-4:]
            p = f(t + h, y + h / 24 * (55 * s - 59 * u + 37 * x - 9 * w))
            y = y + h / 24 * (9 * p + 19 * s - 5 * u + x)
        past = [*past[-3:], f(t + h, y)]
        if (k + 1) % every == 0:
            found.append(y)
    return np.array(found)


def compensated(f, t0, y0, times, step):
    """Runge and Kutta's method of order 4 with Kahan's sum of the steps."""
    count = round((times[-1] - t0) / step)
    every, h = count // len(times), (times[-1] - t0) / count
    y, rest, found = y0, 0 * y0, []
    for k in range(count):
        t = t0 + k * h
        a = f(t, y)
        b = f(t + h / 2, y + h / 2 * a)
        c = f(t + h / 2, y + h / 2 * b)
        d = f(t + h, y + h * c)
        change = h / 6 * (a + 2 * b + 2 * c + d) + rest
        after = y + change
        y, rest = after, change - (after - y)
        if (k + 1) % every == 0:
            found.append(y)
    return np.array(found)


def ensemble(f, t0, starts, times, step):
    """Heun's method of order 3 for many motions at once: starts (n, dim), states (n, times, dim)."""
    count = round((times[-1] - t0) / step)
    every, h = count // len(times), (times[-1] - t0) / count
    y, found = starts, []
    for k in range(count):
        t = t0 + k * h
        a = np.array([f(t, each) for each in y])
        b = np.array([f(t + h / 3, each) for each in y + h / 3 * a])
        c = np.array([f(t + 2 / 3 * h, each) for each in y + 2 / 3 * h * b])
        y = y + h / 4 * (a + 3 * c)
        if (k + 1) % every == 0:
            found.append(y)
    return np.array(found).transpose(1, 0, 2)


def boris(form, p, t0, y0, times, step):
    """Boris' method, relativistic where the form has a speed of light: drift, kick, rotation, kick, drift."""
    count = round((times[-1] - t0) / step)
    every, h = count // len(times), (times[-1] - t0) / count
    x, u = np.split(y0, 2)
    light, found = form.light(p)[0] if form.light else math.inf, []
    for k in range(count):
        t = t0 + k * h
        x = x + h / 2 * u / math.sqrt(1 + u @ u / light**2)
        a, w = np.split(np.array(form.fields(t + h / 2, tuple(x), p)), 2)
        u = u + h / 2 * a
        turn = h / 2 * w / math.sqrt(1 + u @ u / light**2)
        u = u + 2 / (1 + turn @ turn) * np.cross(u + np.cross(u, turn), turn)
        u = u + h / 2 * a
        x = x + h / 2 * u / math.sqrt(1 + u @ u / light**2)
        if (k + 1) % every == 0:
            found.append(np.concatenate([x, u]))
    return np.array(found), None


def rattle(form, p, t0, y0, times, step):
    """RATTLE (Andersen 1983) for one constraint and unit mass."""
    count = round((times[-1] - t0) / step)
    every, h = count // len(times), (times[-1] - t0) / count
    q, v = np.split(y0, 2)
    value, found = form.constraint(t0, tuple(q), p)[0], []
    for k in range(count):
        t = t0 + k * h
        slope = np.array(form.gradient(t, tuple(q), p))
        v = v + h / 2 * np.array(form.force(t, tuple(q), p))
        for _ in range(50):
            new = q + h * v
            there = np.array(form.gradient(t + h, tuple(new), p))
            lack = (form.constraint(t + h, tuple(new), p)[0] - value) / (there @ slope)
            v = v - lack / h * slope
            if not abs(lack) * np.linalg.norm(slope) > 1e-15 * np.linalg.norm(q):
                break
        q = q + h * v
        slope = np.array(form.gradient(t + h, tuple(q), p))
        v = v + h / 2 * np.array(form.force(t + h, tuple(q), p))
        v = v - (slope @ v) / (slope @ slope) * slope
        if (k + 1) % every == 0:
            found.append(np.concatenate([q, v]))
    return np.array(found), None


def product(p, q):
    """Of quaternions (scalar, vector)."""
    return np.array([p[0] * q[0] - p[1:] @ q[1:], *(p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:]))])


def matrix_of(q):
    """The rotation of a unit quaternion, from the body's axes to the axes of space."""
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def quaternion_of(R):
    """The unit quaternion of a rotation, from its largest component."""
    four = np.array([np.trace(R), *np.diag(R)])
    k = int(np.argmax(four))
    if k == 0:
        q = np.array([1 + np.trace(R), R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    else:
        i, j, l = k - 1, k % 3, (k + 1) % 3  # noqa: E741
        q = np.zeros(4)
        q[0] = R[l, j] - R[j, l]
        q[1 + i] = 1 + R[i, i] - R[j, j] - R[l, l]
        q[1 + j], q[1 + l] = R[j, i] + R[i, j], R[l, i] + R[i, l]
    return q / np.linalg.norm(q)


def quaternion(form, p, t0, y0, times, step):
    """Runge and Kutta's method of order 4 for the angular velocity and a quaternion, which is normalised each step."""
    count = round((times[-1] - t0) / step)
    every, h = count // len(times), (times[-1] - t0) / count
    moments = np.array(form.inertia(p))

    def f(t, y):
        spin, q = y[:3], y[3:]
        state = (*spin, *matrix_of(q).ravel())
        moment = np.array(form.torque(t, state, p)) - np.cross(spin, moments * spin)
        return np.concatenate([moment / moments, product(q, np.array([0.0, *spin])) / 2])

    y, found = np.concatenate([y0[:3], quaternion_of(y0[3:].reshape(3, 3))]), []
    for k in range(count):
        t = t0 + k * h
        a = f(t, y)
        b = f(t + h / 2, y + h / 2 * a)
        c = f(t + h / 2, y + h / 2 * b)
        d = f(t + h, y + h * c)
        y = y + h / 6 * (a + 2 * b + 2 * c + d)
        y[3:] = y[3:] / np.linalg.norm(y[3:])
        if (k + 1) % every == 0:
            found.append(np.concatenate([y[:3], matrix_of(y[3:]).ravel()]))
    return np.array(found), None


def bodies(form, p, t0, y0, times, step):
    """Leapfrog for bodies under gravitation."""
    count = round((times[-1] - t0) / step)
    every, h = count // len(times), (times[-1] - t0) / count
    masses, state = form.masses(p), np.array(form.bodies(tuple(y0)))
    x, v, found = state[:, :3], state[:, 3:], []

    def pull(x):
        total = np.zeros_like(x)
        for i in range(len(x)):
            for j in range(i):
                line = x[j] - x[i]
                cube = np.linalg.norm(line) ** 3
                total[i] += masses[j] * line / cube
                total[j] -= masses[i] * line / cube
        return total

    for k in range(count):
        v = v + h / 2 * pull(x)
        x = x + h * v
        v = v + h / 2 * pull(x)
        if (k + 1) % every == 0:
            found.append(form.state(tuple(map(tuple, np.hstack([x, v])))))
    return np.array(found), None


def functions(z):
    """exp(z), phi_1(z) and phi_2(z) of a matrix: a series of z / 2^k, doubled k times."""
    doublings = max(0, math.ceil(math.log2(max(np.linalg.norm(z, 1), 1e-300))) + 2)
    z, one = z / 2**doublings, np.eye(len(z))
    two = sum(np.linalg.matrix_power(z, n) / math.factorial(n + 2) for n in range(16))
    first = one + z @ two
    for _ in range(doublings):
        power = one + z @ first
        two = (first @ first + 2 * two) / 4
        first = (power @ first + first) / 2
        z = 2 * z
    return one + z @ first, first, two


def exponential_heun(form, p, t0, y0, times, step):
    """The exponential method of Runge and Kutta of order 2 (Cox and Matthews 2002); the linear part is exact."""
    count = round((times[-1] - t0) / step)
    every, h = count // len(times), (times[-1] - t0) / count
    linear = np.array(form.linear(p)).reshape(len(y0), len(y0))
    power, first, two = functions(h * linear)
    y, found = y0, []
    for k in range(count):
        t = t0 + k * h
        rest = np.array(form.rest(t, tuple(y), p))
        middle = power @ y + h * first @ rest
        y = middle + h * two @ (np.array(form.rest(t + h, tuple(middle), p)) - rest)
        if (k + 1) % every == 0:
            found.append(y)
    return np.array(found), None
