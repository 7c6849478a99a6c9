"""Second derivation of the double Atwood machine, and its tensions from the accelerations of the masses."""

from typing import Any

from independent_mechanics import World
from independent_models import model
from independent_quantities import ObservedMotion, label_of, oracle


@model("double_atwood")
def double_atwood(w: World, p: Any, y: Any, z: Any) -> None:
    """The height of each mass."""
    w.mass(p.m1, (y,), (-p.g,))
    w.mass(p.m2, (-y - z,), (-p.g,))
    w.mass(p.m3, (z - y,), (-p.g,))


@oracle(*(f"double_atwood.{label}" for label in ("pulley_acceleration", "relative_acceleration")))
def acceleration(observed: ObservedMotion, value: Any) -> Any:
    return observed.rate("V" if label_of(observed, value) == "pulley_acceleration" else "v")


@oracle(*(f"double_atwood.tension_{number}" for number in (1, 2)))
def tension(observed: ObservedMotion, value: Any) -> Any:
    """The string of m1 holds it up, the string of m2 brakes its fall."""
    pulley, relative, p = observed.rate("V"), observed.rate("v"), observed.p
    upper = label_of(observed, value) == "tension_1"
    return p.m1 * (p.g + pulley) if upper else p.m2 * (p.g - pulley - relative)
