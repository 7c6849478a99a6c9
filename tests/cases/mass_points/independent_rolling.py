"""Second derivations for bodies on a plane, made as in independent_bodies: billiard balls, a rolling disc."""

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import flint
from independent_bodies import attitude, columns, euler_axes, orthogonal, small_turn, solid, spin, times
from independent_mechanics import Vec, World, coefficient, cos, cross, length, rate, sin, velocity
from independent_models import model


def ball(w: World, p: Any, q: Sequence[Any]) -> Vec:
    """A uniform solid sphere of mass 1 on the table; returns its material point of contact."""
    axes, centre = columns(small_turn(q[2:])), Vec((q[0], q[1], 0))
    moment = p.R * p.R * 2 / 5
    solid(w, (moment, moment, moment), axes, centre, 1)
    return Vec(centre - axes[2] * p.R)


def slip_of(p: Any, q: Sequence[Any]) -> Vec:
    """The velocity of the point of the ball that touches the table, at any time on the path."""
    return Vec((rate(q[0]), rate(q[1]), 0)) + cross(spin(columns(small_turn(q[2:]))), (0, 0, -p.R))


def ball_there(p: Any, s: SimpleNamespace) -> Any:
    return [s.x, s.y, 0, 0, 0], [s.vx, s.vy, s.wx, s.wy, s.wz]


def ball_back(p: Any, s: Any, q: Sequence[Any]) -> list[Any]:
    turn = small_turn(q[2:])
    state = [q[0], q[1], rate(q[0]), rate(q[1]), *spin(columns(turn))]
    if hasattr(s, "R11"):
        state += [x for row in times(turn, attitude(s)) for x in row]
    return state


def sliding(source: Any, p: Any, s: Any, mode: str) -> None:
    """The slip is closest to the axis of the mode; at the end of sliding its component along that axis is zero."""
    if hasattr(s, "R11"):
        orthogonal(source, p, s, mode)
    along, across = abs(flint.arb(source.uniform(0.5, 1))), flint.arb(source.uniform(-0.4, 0.4))
    slips = {"east": (along, across), "west": (-along, across), "north": (across, along), "south": (across, -along)}
    sx, sy = slips.get(mode.split("_")[-1], (flint.arb(0), flint.arb(0)))
    if mode == "roll":
        p.R = flint.arb(1) / 32  # so that a binary64 state has exactly no slip
    if mode.startswith("at rolls"):
        sx, sy = (flint.arb(0), sy) if mode[9:] in ("east", "west") else (sx, flint.arb(0))
    s.wx, s.wy = (sy - s.vy) / p.R, (s.vx - sx) / p.R


BALL = {"there": ball_there, "back": ball_back}


@model("billiard_ball", "billiard_ball_attitude", prepare=sliding, **BALL)
def billiard_ball(w: World, p: Any, *q: Any) -> None:
    contact = ball(w, p, q)
    if w.mode.startswith("slide"):
        slip = velocity(contact)
        w.force(contact, -slip * (p.mu * p.g / length(slip)))
    else:
        for x in slip_of(p, q)[:2]:
            w.no_slip(x)


@model("billiard_ball_drill", **BALL)
def drilling_ball(w: World, p: Any, *q: Any) -> None:
    contact = ball(w, p, q)
    slip, axes = velocity(contact), columns(small_turn(q[2:]))
    drill = coefficient(spin(axes)[2], 0)
    share = p.mu * p.g / (length(slip) + p.rho * abs(drill))
    w.force(contact, -slip * share)
    couple_at(w, Vec((q[0], q[1], 0)), axes, -share * p.rho * p.rho * drill)


def couple_at(w: World, centre: Vec, axes: Sequence[Vec], torque: Any) -> None:
    """A torque about the vertical at the start of the path, where the body's axes are the axes of space."""
    for side in (1, -1):
        w.force(centre + axes[0] * side, (0, torque * side / 2, 0))


def disc_there(p: Any, s: SimpleNamespace) -> Any:
    """The rates of the angles from the components along the disc's axes; the velocity from rolling."""
    turning = [s.w1, s.w2 / sin(s.theta)]
    rates = [0, 0, *turning, s.w3 - turning[1] * cos(s.theta)]
    still = [flint.arb_series([x, v, 0], 3) for x, v in zip((s.x, s.y, s.theta, s.phi, s.psi), rates, strict=True)]
    slip = disc_slip(p, *still)
    return [s.x, s.y, s.theta, s.phi, s.psi], [-coefficient(slip[0], 0), -coefficient(slip[1], 0), *rates[2:]]


def disc_axes(theta: Any, phi: Any, psi: Any) -> tuple[Sequence[Vec], Vec]:
    """Axes that rotate with the disc, and the steepest radius."""
    axes, still = euler_axes(theta, phi, psi), euler_axes(theta, phi, flint.arb(0))
    return axes, still[1]


def disc_slip(p: Any, x: Any, y: Any, theta: Any, phi: Any, psi: Any) -> Vec:
    axes, radius = disc_axes(theta, phi, psi)
    centre = Vec((x, y, 0)) + radius * p.a
    return Vec(rate(c) for c in centre) - cross(spin(axes), radius * p.a)


@model(
    "rolling_disc",
    there=disc_there,
    back=lambda p, s, q: [*q, rate(q[2]), rate(q[3]) * sin(q[2]), rate(q[4]) + rate(q[3]) * cos(q[2])],
)
def rolling_disc(w: World, p: Any, x: Any, y: Any, theta: Any, phi: Any, psi: Any) -> None:
    """A thin disc of mass 1; its point of contact has velocity zero."""
    axes, radius = disc_axes(theta, phi, psi)
    square = p.a * p.a
    solid(w, (square / 4, square / 4, square / 2), axes, Vec((x, y, 0)) + radius * p.a, 1, (0, 0, -p.g))
    for speed in disc_slip(p, x, y, theta, phi, psi)[:2]:
        w.no_slip(speed)
