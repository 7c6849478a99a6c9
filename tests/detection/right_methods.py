"""Right methods of several kinds, written as their users write them; `mutants.py` changes their text.

Each function of a method takes the user's `f`; `METHODS` has the declarations of each method.
"""

# ruff: noqa: B023 - the functions of a step are used in that step only

from __future__ import annotations

import numpy as np
from gnomon.cases.core.scene import IDENTITY, Readings

C = (0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0)
A = (
    (),
    (1 / 5,),
    (3 / 40, 9 / 40),
    (44 / 45, -56 / 15, 32 / 9),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
    (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
)
E = (71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40)
D = (-12715105075 / 11282082432, 0.0, 87487479700 / 32700410799, -10690763975 / 1880347072,
     701980252875 / 199316789632, -1453857185 / 822651844, 69997945 / 29380423)  # fmt: skip
"""Dormand and Prince's 5(4) pair and its dense output (Hairer, Nørsett and Wanner, II.6)."""


def rk4(f, t, y, h):
    a = f(t, y)
    b = f(t + h / 2, y + h / 2 * a)
    c = f(t + h / 2, y + h / 2 * b)
    d = f(t + h, y + h * c)
    return y + h / 6 * (a + 2 * b + 2 * c + d)


def verlet(f, t, y, h):
    q, v = np.split(y, 2)
    middle = v + h / 2 * f(t, q)
    q = q + h * middle
    v = middle + h / 2 * f(t + h, q)
    return np.concatenate([q, v])


def yoshida(f, t, y, h):
    q, v = np.split(y, 2)
    outer = 1 / (2 - 2 ** (1 / 3))
    for part in (outer, 1 - 2 * outer, outer):
        q = q + part * h / 2 * v
        v = v + part * h * f(t + part * h / 2, q)
        q = q + part * h / 2 * v
        t = t + part * h
    return np.concatenate([q, v])


def implicit_midpoint(f, t, y, h):
    middle = y + h / 2 * f(t, y)
    for _ in range(100):
        better = y + h / 2 * f(t + h / 2, middle)
        change = np.max(np.abs(better - middle))
        middle = better
        if change <= 1e-16 * np.max(np.abs(y)):
            break
    return y + h * f(t + h / 2, middle)


def gauss4(f, t, y, h):
    root = np.sqrt(3) / 6
    k = m = f(t, y)
    for _ in range(100):
        before = k
        k = f(t + (1 / 2 - root) * h, y + h * (k / 4 + (1 / 4 - root) * m))
        m = f(t + (1 / 2 + root) * h, y + h * ((1 / 4 + root) * k + m / 4))
        if np.max(np.abs(k - before)) <= 1e-16 * np.max(np.abs(k)):
            break
    return y + h / 2 * (k + m)


def adams(f, t0, y0, times, step):
    """Adams and Bashforth's method of order 4 with the start of Runge and Kutta's; equal steps."""
    count = round((times[-1] - t0) / step)
    every = count // len(times)
    h = (times[-1] - t0) / count
    y, found, slopes = y0, [], []
    for k in range(count):
        t = t0 + k * h
        slopes = [*slopes[-3:], f(t, y)]
        if k < 3:
            y = rk4(f, t, y, h)
        else:
            w, x, u, s = slopes
            y = y + h / 24 * (55 * s - 59 * u + 37 * x - 9 * w)
        if (k + 1) % every == 0:
            found.append(y)
    return np.array(found)


def norm(y, tolerance):
    return max(np.linalg.norm(y), 1e-3) * tolerance


def dormand_prince(f, t0, y0, times, tolerance):
    """The pair with a step size of its own; samples from its dense output."""
    t, y, h = t0, y0, 1e-3 * times[-1]
    found, first = [], f(t0, y0)
    while len(found) < len(times):
        k = [first]
        for c, row in zip(C[1:], A[1:], strict=True):
            new = y + h * sum(a * b for a, b in zip(row, k, strict=True))
            k.append(f(t + c * h, new))
        error = np.linalg.norm(h * sum(e * s for e, s in zip(E, k, strict=True))) / norm(y, tolerance)
        if not np.isfinite(error) or h < 1e-15 * max(abs(t), 1e-300):
            return np.full((len(times), len(y0)), np.nan)
        if error <= 1:
            r1 = new - y
            r2 = h * k[0] - r1
            r3 = r1 - h * k[6] - r2
            r4 = h * sum(d * s for d, s in zip(D, k, strict=True))
            while len(found) < len(times) and times[len(found)] <= t + h:
                x = (times[len(found)] - t) / h
                found.append(y + x * (r1 + (1 - x) * (r2 + x * (r3 + (1 - x) * r4))))
            t, y, first = t + h, new, k[6]
        h = h * min(5.0, max(0.2, 0.9 * max(error, 1e-10) ** -0.2))
    return np.array(found)


def bogacki_shampine(f, t0, y0, times, tolerance):
    """Bogacki and Shampine's 3(2) pair, which stops at the samples."""
    t, y, h, found = t0, y0, 1e-3 * times[-1], []
    a = f(t, y)
    for end in times:
        while t < end:
            last = t + h >= end
            step = end - t if last else h
            b = f(t + step / 2, y + step / 2 * a)
            c = f(t + 3 / 4 * step, y + 3 / 4 * step * b)
            new = y + step * (2 / 9 * a + 1 / 3 * b + 4 / 9 * c)
            d = f(t + step, new)
            error = np.linalg.norm(step * (-5 / 72 * a + 1 / 12 * b + 1 / 9 * c - 1 / 8 * d)) / norm(y, tolerance)
            if not np.isfinite(error) or step < 1e-15 * max(abs(t), 1e-300):
                return np.full((len(times), len(y0)), np.nan)
            if error <= 1:
                t, y, a = end if last else t + step, new, d
            h = step * min(5.0, max(0.2, 0.9 * max(error, 1e-10) ** (-1 / 3)))
        found.append(y)
    return np.array(found)


def richardson(f, t0, y0, times, tolerance):
    """Gragg's midpoint rule with three extrapolations, order 6; steps by the last difference, stops at the samples."""
    t, y, h, found = t0, y0, 1e-2 * times[-1], []
    for end in times:
        while t < end:
            last = t + h >= end
            step = end - t if last else h
            rows = []
            for n in (2, 4, 6, 8):
                z, w = y, y + step / n * f(t, y)
                for i in range(1, n):
                    z, w = w, z + 2 * step / n * f(t + i * step / n, w)
                rows.append((z + w + step / n * f(t + step, w)) / 2)
            one = [
                (16 * rows[1] - 4 * rows[0]) / 12,
                (36 * rows[2] - 16 * rows[1]) / 20,
                (64 * rows[3] - 36 * rows[2]) / 28,
            ]
            two = [(36 * one[1] - 4 * one[0]) / 32, (64 * one[2] - 16 * one[1]) / 48]
            three = (64 * two[1] - 4 * two[0]) / 60
            error = np.linalg.norm(three - two[1]) / norm(y, tolerance)
            if not np.isfinite(error) or step < 1e-15 * max(abs(t), 1e-300):
                return np.full((len(times), len(y0)), np.nan)
            if error <= 1:
                t, y = end if last else t + step, three
            h = step * min(5.0, max(0.2, 0.9 * max(error, 1e-10) ** (-1 / 7)))
        found.append(y)
    return np.array(found)


def rk4_events(form, p, t0, y0, times, step):
    """RK4 for a motion with events: a step ends at the first event in it, which bisection locates."""
    p = tuple(p)
    t, y, found, events, count = t0, y0, [], [], round((times[-1] - t0) / step)
    every, mode, before = count // len(times), form.mode(form.start(t0, tuple(y0), p)), {}
    for k in range(count):
        end = t0 + (k + 1) * step
        while t < end:

            def f(t, y):
                return np.array(mode.equations(t, tuple(y), p + mode.constants))

            first = None
            for event in [e for e in form.transitions if e.mode == mode.name]:

                def side(x):
                    return event.direction * event.guard(t + x, tuple(rk4(f, t, y, x)), p)[0]

                last = end - t if first is None else first[0]
                if side(last) > 0:
                    low, high = last / 2, last
                    while side(low) >= 0 and low > 1e-12 * step:
                        low, high = low / 2, low
                    while low < (low + high) / 2 < high:
                        middle = (low + high) / 2
                        low, high = (low, middle) if side(middle) > 0 else (middle, high)
                    first = high, event
            if first is None:
                y, t = rk4(f, t, y, end - t), end
                continue
            high, event = first
            y, t = rk4(f, t, y, high), t + high
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


def hat(s):
    return np.array([[0, -s[2], s[1]], [s[2], 0, -s[0]], [-s[1], s[0], 0]])


def exponential(s):
    """The rotation by the vector s (Rodrigues)."""
    angle = np.linalg.norm(s)
    if angle < 1e-8:
        return np.eye(3) + hat(s)
    half = np.sin(angle / 2) / (angle / 2)
    return np.eye(3) + np.sin(angle) / angle * hat(s) + half * half / 2 * hat(s) @ hat(s)


def rotation(moments, torque, t, w, R, h):
    """Munthe-Kaas' method of order 4: RK4 for the angular velocity and the rotation vector since the step's start."""

    def f(t, w, s):
        spin = (torque(t, w, R @ exponential(s)) - hat(w) @ (moments * w)) / moments
        return np.array([spin, w + hat(s) @ w / 2 + hat(s) @ hat(s) @ w / 12])

    none = np.zeros(3)
    a = f(t, w, none)
    b = f(t + h / 2, w + h / 2 * a[0], h / 2 * a[1])
    c = f(t + h / 2, w + h / 2 * b[0], h / 2 * b[1])
    d = f(t + h, w + h * c[0], h * c[1])
    change = h / 6 * (a + 2 * b + 2 * c + d)
    return w + change[0], R @ exponential(change[1])


class LeapfrogEngine:
    """An engine that loads, steps and reads: point masses under gravity and force laws, two leapfrog steps a step."""

    def load(self, scene):
        self.t, self.scene = 0.0, scene
        self.m = {body.name: body.mass for body in scene.bodies}
        self.x = {body.name: np.array(body.position, dtype=float) for body in scene.bodies}
        self.v = {body.name: np.array(body.velocity, dtype=float) for body in scene.bodies}
        self.a = self.accelerations()

    def accelerations(self):
        total = {name: np.array(self.scene.gravity, dtype=float) for name in self.m}
        for force in self.scene.forces:
            x, v = self.x[force.body], self.v[force.body]
            if force.partner:
                x, v = x - self.x[force.partner], v - self.v[force.partner]
            value = np.array(force.law(self.t, tuple(x), tuple(v)))
            total[force.body] = total[force.body] + value / self.m[force.body]
            if force.partner:
                total[force.partner] = total[force.partner] - value / self.m[force.partner]
        return total

    def step(self, dt):
        for _ in range(2):
            for name in self.m:
                self.v[name] = self.v[name] + dt / 4 * self.a[name]
                self.x[name] = self.x[name] + dt / 2 * self.v[name]
            self.t = self.t + dt / 2
            self.a = self.accelerations()
            for name in self.m:
                self.v[name] = self.v[name] + dt / 4 * self.a[name]

    def read(self):
        return Readings(
            bodies={name: (tuple(self.x[name]), IDENTITY, tuple(self.v[name]), (0.0, 0.0, 0.0)) for name in self.m}
        )
