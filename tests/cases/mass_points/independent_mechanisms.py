"""Second derivations for mechanisms: closed chains of bodies, their joints kept as constraints."""

from typing import Any

from independent_mechanics import Vec, World, dot, sin, sqrt
from independent_models import model
from independent_quantities import ObservedMotion, mp, oracle


@model("car_axis")
def car_axis(w: World, p: Any, xl: Any, yl: Any, xr: Any, yr: Any) -> None:
    """Two masses at the ends of the axle; the wheels are points that the road moves."""
    left, right = Vec((xl, yl)), Vec((xr, yr))
    height = p.c / p.w * sin(p.w * w.t)
    wheel = Vec((sqrt(p.L * p.L - height * height), height))
    for end, foot in ((left, Vec((0, 0))), (right, wheel)):
        w.mass(p.m / 2, end, (0, -p.g))
        w.spring(p.k, p.l0, foot, end)
    w.keep(dot(left, wheel))
    w.keep(dot(left - right, left - right))


@oracle("car_axis.multiplier_axle", "car_axis.multiplier_shaft")
def forces_at_the_start(observed: ObservedMotion, value: Any) -> Any:
    """What the springs leave of the accelerations along the road, where the right wheel is at (L, 0)."""
    p, s = observed.p, observed.at(0)
    ahead = s.xr - p.L
    pull = 2 * p.k / p.m * (p.l0 / mp.sqrt(ahead * ahead + s.yr * s.yr) - 1) * ahead
    axle = pull - observed.rate("vxr")
    over = p.m / (2 * p.k)
    if value is observed.found["multiplier_axle"]:
        return axle * over / (2 * (s.xl - s.xr))
    return (observed.rate("vxl") + axle) * over / p.L
