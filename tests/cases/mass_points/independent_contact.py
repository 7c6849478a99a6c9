"""Second derivations for dry friction, guides and stops, and machines with belts, ropes and wheels."""

from typing import Any

import flint
from independent_bodies import flat_body
from independent_mechanics import Vec, World, coefficient, cos, dot, exp, polar, rate, sin, velocity
from independent_models import model


def friction(w: World, place: Any, most: Any, slip: Any) -> None:
    """A friction force of size `most` against the slip."""
    size = sum(abs(x) for x in slip)
    w.force(place, [-most * x / size for x in slip])


def by_sign(source: Any, p: Any, s: Any, mode: str) -> None:
    """Modes are given by the sign of the velocity, which is zero at the end of a mode."""
    signs = {"up": 1, "right": 1, "moving": 1, "slide": 1, "turns": 1, "down": -1, "left": -1}
    name = "w" if hasattr(s, "w") else "v"
    speed = abs(getattr(s, name))
    setattr(s, name, signs[mode] * speed if mode in signs else flint.arb(0))


def on_the_incline(source: Any, p: Any, s: Any, mode: str) -> None:
    """The block sticks on an incline that is less steep than the angle of friction."""
    by_sign(source, p, s, mode)
    if mode == "stick":
        p.alpha = source.random() * p.mu_s / (1 + p.mu_s)


@model("block_incline_friction", prepare=on_the_incline)
def block_on_an_incline(w: World, p: Any, s: Any) -> None:
    """The normal force is the component of the weight normal to the plane."""
    up, across = Vec((cos(p.alpha), sin(p.alpha))), Vec((-sin(p.alpha), cos(p.alpha)))
    place = up * s
    w.mass(1, place, (0, -p.g))
    if w.mode in ("up", "down"):
        friction(w, (s,), p.mu_k * dot((0, p.g), across), (s[1],))
    elif w.mode == "stick":
        w.keep(s)


def on_the_plane(source: Any, p: Any, s: Any, mode: str) -> None:
    by_sign(source, p, s, mode)
    if mode == "stick":
        s.x = source.uniform(-1, 1) * p.mu_s * p.m * p.g / p.k


@model("coulomb_friction_oscillator", prepare=on_the_plane)
def block_on_a_spring(w: World, p: Any, x: Any) -> None:
    w.mass(p.m, (x,))
    w.energy(p.k * x * x / 2)
    if w.mode in ("right", "left"):
        friction(w, (x,), p.mu_k * p.m * p.g, (x[1],))
    elif w.mode == "stick":
        w.keep(x)


def on_the_belt(source: Any, p: Any, s: Any, mode: str) -> None:
    """The belt holds the block until k x = mu_s m g; a slipping block is slower than the belt."""
    s.v = p.V - source.uniform(0.1, 2) if mode == "slip" else p.V
    if mode == "at release":
        s.x = p.mu_s * p.m * p.g / p.k
    if mode == "stick":
        s.x = source.uniform(-1, 1) * p.mu_s * p.m * p.g / p.k


@model("stick_slip_belt", prepare=on_the_belt)
def block_on_a_belt(w: World, p: Any, x: Any) -> None:
    w.mass(p.m, (x,))
    w.energy(p.k * x * x / 2)
    if w.mode == "slip":
        friction(w, (x,), p.mu_k * p.m * p.g, (x[1] - p.V,))
    elif w.mode == "stick":
        w.no_slip(rate(x))


@model("stick_slip_falling_friction", prepare=on_the_belt)
def block_on_a_slippery_belt(w: World, p: Any, x: Any) -> None:
    w.mass(p.m, (x,))
    w.energy(p.k * x * x / 2)
    if w.mode == "slip":
        sliding = x[1] - p.V
        friction(w, (x,), (p.mu_k - p.slope * abs(sliding)) * p.m * p.g, (sliding,))
    elif w.mode == "stick":
        w.no_slip(rate(x))


def in_the_guide(source: Any, p: Any, s: Any, mode: str) -> None:
    by_sign(source, p, s, "moving" if mode == "at strike" else mode)
    if mode in ("at strike", "struck"):
        s.x = p.gap


@model("torpedo_firing_pin", prepare=in_the_guide)
def firing_pin(w: World, p: Any, x: Any) -> None:
    """In the frame of the torpedo, whose deceleration presses the pin on the guide with m a."""
    w.mass(p.m, (x,))
    w.energy(p.k * (p.d0 - x) * (p.d0 - x) / 2)
    if w.mode == "moving":
        friction(w, (x,), p.mu * p.m * p.a, (x[1],))
    elif w.mode == "at strike":
        w.strike(x, 0)
    elif w.mode in ("struck", "stopped"):
        w.keep(x)


def warming(source: Any, p: Any, s: Any, mode: str) -> Any:
    """The can is on an incline that would hold it; the final lift P makes it slide or float."""
    s.v = flint.arb(0) if mode in ("stick", "at sets_off") else abs(s.v)
    p.alpha = (0.1 + source.random()) / 2 * p.mu_s / (1 + p.mu_s)
    t, share = p.T * source.uniform(0.2, 2), source.random()
    across, along = p.m * p.g * cos(p.alpha), p.m * p.g * sin(p.alpha)
    slides, floats = across - along / p.mu_s, across
    lifts = {"stick": share * slides, "at sets_off": slides, "slide": slides + share * (floats - slides)}
    p.P = lifts.get(mode, floats if mode == "at lifts_off" else (1 + share) * floats) / (1 - exp(-t / p.T))
    return t


@model("sliding_can", prepare=warming)
def can_on_an_incline(w: World, p: Any, s: Any) -> None:
    """The normal force is the component of the weight normal to the plane less the lift of the air, or zero."""
    down, across = Vec((cos(p.alpha), -sin(p.alpha))), Vec((sin(p.alpha), cos(p.alpha)))
    w.mass(p.m, down * s, (0, -p.g))
    if w.mode == "slide":
        lift = p.P * (1 - exp(-w.t[0] / p.T))
        friction(w, (s,), p.mu_k * (dot((0, p.m * p.g), across) - lift), (s[1],))
    elif w.mode in ("stick",):
        w.keep(s)


@model("atwood_pulley_systems")
def atwood(w: World, p: Any, x: Any) -> None:
    """The pulley is a mass I at distance 1 from its axis."""
    w.mass(p.m1, (-x,), (-p.g,))
    w.mass(p.m2, (x,), (-p.g,))
    w.mass(p.I, polar(1, x / p.R))


@model("yo_yo")
def yo_yo(w: World, p: Any, y: Any) -> None:
    flat_body(w, p.m, p.I, Vec((0, -y)), y / p.r, (0, -p.g))


def wheels(source: Any, p: Any, s: Any, mode: str) -> None:
    """In the mode `ahead` the first rim is the faster one."""
    if mode in ("ahead", "behind"):
        side = 1 if mode == "ahead" else -1
        s.w2 = (p.r1 * s.w1 - side * source.uniform(0.1, 3)) / p.r2
    else:
        p.r2 = 2 * p.r1  # so that a binary64 state has exactly no slip
        s.w2 = p.r1 * s.w1 / p.r2


@model(
    "belt_driven_machine",
    prepare=wheels,
    there=lambda p, s: ([0, 0], [s.w1, s.w2]),
    back=lambda p, s, q: [rate(q[0]), rate(q[1])],
)
def two_pulleys(w: World, p: Any, one: Any, two: Any) -> None:
    """Each wheel is a mass I at distance 1; the torque is a force there, the belt pulls at the rims."""
    rims = polar(p.r1, one), polar(p.r2, two)
    w.mass(p.I1, polar(1, one))
    w.mass(p.I2, polar(1, two))
    torque(w, one, p.M)
    slip = p.r1 * one[1] - p.r2 * two[1]
    if w.mode in ("ahead", "behind"):
        pull = p.F * slip / abs(slip)
        for rim, angle, side in ((rims[0], one, -1), (rims[1], two, 1)):
            w.force(rim, Vec((-sin(angle), cos(angle))) * (side * pull))
    else:
        w.keep(p.r1 * one - p.r2 * two)


def torque(w: World, angle: Any, moment: Any) -> None:
    """A torque on a wheel as a tangential force at distance 1."""
    w.force(polar(1, angle), Vec((-sin(angle), cos(angle))) * moment)


@model("flywheel")
def flywheel(w: World, p: Any, angle: Any) -> None:
    rim = polar(1, angle)
    w.mass(p.I, rim)
    torque(w, angle, p.M * (1 + p.p * cos(p.W * w.t)))
    w.force(rim, -velocity(rim) * p.c)


@model("flywheel_coast_down", prepare=by_sign)
def coasting_wheel(w: World, p: Any, angle: Any) -> None:
    rim = polar(1, angle)
    w.mass(p.I, rim)
    w.force(rim, -velocity(rim) * p.c)
    if w.mode == "turns":
        friction(w, (angle,), p.M, (angle[1],))
    elif w.mode == "rests":
        w.keep(angle)


def on_the_slope(source: Any, p: Any, s: Any, mode: str) -> None:
    if mode in ("ahead", "behind"):
        side = 1 if mode == "ahead" else -1
        s.w = (s.v - side * source.uniform(0.1, 2)) / p.R
    else:
        p.R = flint.arb(1) / 8  # so that a binary64 state has exactly no slip
        s.w = s.v / p.R
    if mode == "roll":
        p.alpha = source.random() * p.mu / (1 + p.mu)


@model(
    "rolling_bodies",
    prepare=on_the_slope,
    there=lambda p, s: ([s.s, 0], [s.v, s.w]),
    back=lambda p, s, q: [q[0], rate(q[0]), rate(q[1])],
)
def body_on_a_slope(w: World, p: Any, s: Any, angle: Any) -> None:
    """Down the slope is to the right, so the body turns clockwise; friction acts at the material point of contact."""
    down, across = Vec((cos(p.alpha), -sin(p.alpha))), Vec((sin(p.alpha), cos(p.alpha)))
    centre = down * s
    flat_body(w, 1, p.k * p.R * p.R, centre, -angle, (0, -p.g))
    turn = angle - coefficient(angle, 0)
    touching = centre - (across * cos(turn) + down * sin(turn)) * p.R
    if w.mode in ("ahead", "behind"):
        slip = dot(velocity(touching), down)
        w.force(touching, down * (-p.mu * dot((0, p.g), across) * slip / abs(slip)))
    else:
        w.keep(s - p.R * angle)
