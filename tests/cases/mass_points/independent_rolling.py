"""Second derivations for bodies on a plane, made as in independent_bodies: billiard balls, a rolling disc, a tippe top."""

from collections.abc import Sequence
from functools import partial
from types import SimpleNamespace
from typing import Any

import flint
from gnomon.cases.core.arithmetic import mpmath_arithmetic, rebind
from gnomon.cases.rigid_bodies.tippe_top import jellett, tippe_energy
from independent_bodies import attitude, columns, euler_axes, orthogonal, small_turn, solid, spin, times
from independent_mechanics import System, Vec, World, coefficient, cos, cross, dot, length, rate, sin, velocity
from independent_models import model
from independent_quantities import ObservedMotion, mp, oracle


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


def tippe_there(p: Any, s: SimpleNamespace) -> Any:
    """The height follows from the eccentricity as long as the sphere stays on the plane."""
    climb = -p.R * (s.wx * s.ey - s.wy * s.ex)
    return [0, 0, p.R * (1 - s.ez), 0, 0, 0], [s.vx, s.vy, climb, s.wx, s.wy, s.wz]


def tippe_back(p: Any, s: Any, q: Sequence[Any]) -> list[Any]:
    turn = small_turn(q[3:])
    return [*spin(columns(turn)), *moved(turn, (s.ex, s.ey, s.ez)), rate(q[0]), rate(q[1])]


def moved(turn: Sequence[Vec], place: Sequence[Any]) -> Vec:
    return Vec(dot(row, place) for row in turn)


def pressed(force: Any, w: World, p: Any, x: Any, y: Any, z: Any, *q: Any) -> None:
    """An eccentric sphere kept on the plane, with the friction that belongs to this normal force."""
    turn, e, centre = small_turn(q), Vec((w.s.ex, w.s.ey, w.s.ez)), Vec((x, y, z))
    axis = e / length(e)
    across = cross(axis, (1, 0, 0))
    across = across / length(across)
    axes = [moved(turn, each) for each in (across, cross(axis, across), axis)]
    solid(w, (p.I1, p.I1, p.I3), axes, centre, p.m, (0, 0, -p.g))
    contact = centre + moved(turn, (e - Vec((0, 0, 1))) * p.R)
    w.force(contact, -velocity(contact) * (p.mu * force))
    w.keep(z + moved(turn, e)[2] * p.R)


@model("tippe_top", there=tippe_there, back=tippe_back)
def tippe_top(w: World, p: Any, *q: Any) -> None:
    """The force that keeps the sphere on the plane is linear in the one that friction belongs to; both are equal."""
    start, speeds = ([coefficient(x, k) for x in q] for k in (0, 1))
    none, one = (
        System(partial(pressed, flint.arb(force)), p, coefficient(w.t, 0), w.s, w.mode).accelerations(start, speeds)[1][
            0
        ]
        for force in (0, 1)
    )
    pressed(none / (1 + none - one), w, p, *q)


@oracle("tippe_top.jellett_limit")
def least_energy(observed: ObservedMotion, value: Any) -> Any:
    """Above it, upside down has the least energy that Jellett's integral allows.

    Energy is U + w.K w/2 and the integral j.w, so this least energy is U + J^2/(2 j.(K^-1 j)).
    """
    energy, integral = (rebind(each, mpmath_arithmetic(mp)) for each in (tippe_energy, jellett))
    values, start = tuple(vars(observed.p).values()), observed.at(0)
    alpha = mp.sqrt(start.ex**2 + start.ey**2 + start.ez**2)

    def parts(tilt: Any) -> tuple[Any, Any]:
        def at(found: Any, *w: int) -> Any:
            return found(0, (*map(mp.mpf, w), alpha * mp.sin(tilt), mp.mpf(0), -alpha * mp.cos(tilt), 0, 0), values)[0]

        units = [tuple(int(i == k) for i in range(3)) for k in range(3)]
        rest = at(energy, 0, 0, 0)
        both = [[at(energy, *map(sum, zip(a, b, strict=True))) for b in units] for a in units]
        alone = [at(energy, *a) for a in units]
        inertia = mp.matrix([[both[i][k] - alone[i] - alone[k] + rest for k in range(3)] for i in range(3)])
        weights = mp.matrix([at(integral, *a) for a in units])
        return rest, 1 / (2 * (weights.T * mp.lu_solve(inertia, weights))[0])

    potential, rotation = (mp.diff(lambda tilt, k=k: parts(tilt)[k], 0, 2) for k in (0, 1))
    return mp.sqrt(-potential / rotation)


@oracle("tippe_top.jellett_ratio")
def over_the_limit(observed: ObservedMotion, value: Any) -> Any:
    return abs(observed.invariant("jellett")) / mp.mpf(observed.found["jellett_limit"])
