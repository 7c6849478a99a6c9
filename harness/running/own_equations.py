"""The lines of Python that run an integrator on a reader's own equations, for each form that integrators accept."""

from gnomon.cases.core.forms import (
    Charged,
    Constrained,
    FirstOrder,
    Hybrid,
    Impact,
    NBody,
    RigidBody,
    SecondOrder,
    SemiLinear,
)
from gnomon.harness.contract.integrator import Integrator, Tolerance

TOLERANCE = 1e-9
FIRST_ORDER = """\
from math import sin

import gnomon


def swing(t, y):
    angle, rate = y
    return rate, -9.81 * sin(angle)


times = [0.5, 1.0, 1.5]
found = gnomon.solve(swing, (0, 1.5), [1.2, 0.0], "{method}", t_eval=times, {setting})
"""
SECOND_ORDER = """\
from math import sin

import gnomon


def swing(t, q):
    return (-9.81 * sin(q[0]),)


times = [0.5, 1.0, 1.5]
found = gnomon.solve(swing, (0, 1.5), [1.2, 0.0], "{method}", t_eval=times, {setting}, accelerations=True)
"""
SEMI_LINEAR = """\
from math import cos

import gnomon


def decay(t, y, p):
    return (-1000.0 * y[0] + rest(t, y, p)[0],)


def linear(p):  # row by row
    return (-1000.0,)


def rest(t, y, p):
    return (cos(t),)


equations = gnomon.SemiLinear(decay, linear=linear, rest=rest)
times = [0.5, 1.0, 1.5]
found = gnomon.solve(equations, (0, 1.5), [1.0], "{method}", t_eval=times, {setting})
"""
CHARGED = """\
import gnomon


def fields(t, place, p):  # charge over mass times E, then times B
    return 0.5, 0.0, 0.0, 0.0, 0.0, 2.0


def motion(t, state, p):
    ax, ay, az, wx, wy, wz = fields(t, state[:3], p)
    x, y, z, u, v, w = state
    return u, v, w, ax + v * wz - w * wy, ay + w * wx - u * wz, az + u * wy - v * wx


equations = gnomon.Charged(motion, fields=fields)
times = [0.5, 1.0, 1.5]
found = gnomon.solve(equations, (0, 1.5), [0.0, 0.0, 0.0, 1.0, 0.0, 0.1], "{method}", t_eval=times, {setting})
"""
RELATIVISTIC = """\
from math import sqrt

import gnomon


def fields(t, place, p):  # charge over mass times E, then times B
    return 0.5, 0.0, 0.0, 0.0, 0.0, 2.0


def light(p):
    return (10.0,)


def motion(t, state, p):  # of the position and of u = gamma v
    ax, ay, az, wx, wy, wz = fields(t, state[:3], p)
    x, y, z, u, v, w = state
    gamma = sqrt(1 + (u * u + v * v + w * w) / 100.0)
    u, v, w = u / gamma, v / gamma, w / gamma
    return u, v, w, ax + v * wz - w * wy, ay + w * wx - u * wz, az + u * wy - v * wx


equations = gnomon.Charged(motion, fields=fields, light=light)
times = [0.5, 1.0, 1.5]
found = gnomon.solve(equations, (0, 1.5), [0.0, 0.0, 0.0, 1.0, 0.0, 0.1], "{method}", t_eval=times, {setting})
"""
CONSTRAINED = """\
import gnomon


def force(t, q, p):
    return 0.0, -9.81


def constraint(t, q, p):
    return (q[0] * q[0] + q[1] * q[1],)


def gradient(t, q, p):
    return 2 * q[0], 2 * q[1]


def motion(t, state, p):  # with the multiplier eliminated
    x, y, u, v = state
    pull = (u * u + v * v - 9.81 * y) / (x * x + y * y)
    return u, v, -pull * x, -9.81 - pull * y


equations = gnomon.Constrained(motion, force=force, constraint=constraint, gradient=gradient)
times = [0.5, 1.0, 1.5]
found = gnomon.solve(equations, (0, 1.5), [1.0, 0.0, 0.0, 0.0], "{method}", t_eval=times, {setting})
"""
RIGID_BODY = """\
import gnomon


def inertia(p):
    return 1.0, 2.0, 3.0


def torque(t, state, p):
    return 0.0, 0.0, 0.0


start = [0.1, 1.0, 0.2, 1, 0, 0, 0, 1, 0, 0, 0, 1]  # angular velocity in the body, then the attitude by rows
times = [0.5, 1.0, 1.5]
found = gnomon.solve(gnomon.RigidBody(inertia, torque), (0, 1.5), start, "{method}", t_eval=times, {setting})
"""
N_BODY = """\
import gnomon


def masses(p):  # times the constant of gravitation
    return 0.75, 0.25


def bodies(state):  # x, y, z, vx, vy, vz of each
    return state[:6], state[6:]


def state(bodies):
    return (*bodies[0], *bodies[1])


start = [-0.25, 0.0, 0.0, 0.0, -0.25, 0.0, 0.75, 0.0, 0.0, 0.0, 0.75, 0.0]
times = [0.5, 1.0, 1.5]
found = gnomon.solve(gnomon.NBody(masses, bodies, state), (0, 1.5), start, "{method}", t_eval=times, {setting})
"""
HYBRID = """\
import gnomon


def falling(t, state, p):
    return state[1], -9.81


def ground(t, state, p):
    return (state[0],)


def bounce(t, state, p):
    return state[0], -0.8 * state[1]


def start(t, state, p):
    return "flight"


impact = gnomon.Transition("impact", "flight", ground, -1, bounce, "flight")
ball = gnomon.Hybrid((gnomon.Mode("flight", falling),), start, (impact,), settle=1e-9)
times = [0.3, 0.6, 0.9]
found = gnomon.solve(ball, (0, 0.9), [1.0, 0.0], "{method}", t_eval=times, {setting})
"""
IMPACT = """\
import gnomon


def falling(t, state, p):
    return state[1], -9.81


def height(t, q, p):
    return (q[0],)


def normal(t, q, p):
    return (1.0,)


def restitution(p):
    return (0.8,)


def start(t, state, p):
    return "flight"


def bounce(t, state, p):
    return state[0], -0.8 * state[1]


impact = gnomon.Transition("impact", "flight", height, -1, bounce, "flight")
ball = gnomon.Impact(
    (gnomon.Mode("flight", falling),), start, (impact,), settle=1e-9,
    free=falling, gap=height, normal=normal, restitution=restitution,
)
times = [0.3, 0.6, 0.9]
found = gnomon.solve(ball, (0, 0.9), [1.0, 0.0], "{method}", t_eval=times, {setting})
"""
LINES = {
    FirstOrder: FIRST_ORDER, SecondOrder: SECOND_ORDER, RigidBody: RIGID_BODY, NBody: N_BODY, Hybrid: HYBRID,
    Impact: IMPACT, Charged: CHARGED, Constrained: CONSTRAINED, SemiLinear: SEMI_LINEAR,
}  # fmt: skip
SLOW = Charged(lambda t, state, p: (), fields=lambda t, place, p: ())
"""The form of a slow charge, which a method for relativistic charges declines."""


def lines(integrator: Integrator, setting: str | None = None) -> str | None:
    """The lines for an integrator; None for an engine, which takes a scene in place of equations.

    `setting`: the argument of `gnomon.solve` for the accuracy, as rtol=1e-9 or epsilon=1e-9; by default a usual one.
    """
    text = next((text for form, text in LINES.items() if form in integrator.accepts), None)
    if text is None:
        return None
    if text is CHARGED and integrator.unsupported(SLOW) is not None:
        text = RELATIVISTIC
    sweep = integrator.sweep
    usual = "step=2**-7"
    if isinstance(sweep, Tolerance):
        usual = f"{sweep.name}={min(max(TOLERANCE, sweep.tightest), sweep.loosest):g}"
    return text.format(setting=setting or usual, method=integrator.id)
