"""The projectile in uniform gravity, without drag."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar

from gnomon.cases.core.case import Case, Invariant, Variant
from gnomon.cases.core.forms import Separable, Values
from gnomon.cases.core.numbers import POINT_IN_A_PLANE, Domain, Parameter, Range
from gnomon.cases.flight.projectile_parabola_scene import SCENE
from gnomon.reference.flight.projectile_parabola import Projectile


def uniform_gravity(t: Any, q: Values, parameters: Values) -> Values:
    """x'' = 0, y'' = -g."""
    (g,) = parameters
    return 0 * g, -g


def height_potential(t: Any, q: Values, parameters: Values) -> Values:
    (g,) = parameters
    return (g * q[1],)


def projectile_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy per unit mass."""
    _x, y, vx, vy = state
    (g,) = parameters
    return ((vx * vx + vy * vy) / 2 + g * y,)


def horizontal_momentum(t: Any, state: Values, parameters: Values) -> Values:
    """Momentum along x per unit mass."""
    return (state[2],)


class ProjectileParabola(Case):
    name = "projectile_parabola"
    title = "Projectile in uniform gravity"
    section = "6.4.2"
    conventions = "x horizontal, y upward; the ground is y = 0 and is not part of the motion."
    state = POINT_IN_A_PLANE
    parameter_list = (Parameter("g", "m/s^2", "9.81", "acceleration of gravity"),)
    default_state = (0, 0, 20, 15)
    default_span = 3
    domain = Domain({"g": Range(low=0.0, typical=(0.0, 20.0))})
    variants = (
        Variant("engines", "the parameters of the engine tables: 10 m/s, 1 s", initial_state=(0, 0, 6, 8), span=1),
        Variant("vertical", "straight up: a component that stays exactly zero", initial_state=(0, 0, 0, 30), span=6),
        Variant(
            "far_origin",
            "1e8 m from the origin: the increment of a small step is below the ulp of the position",
            initial_state=(10**8, 10**8, 20, 15),
        ),
        Variant("long_fall", "a fall of 1e4 s: round-off of many steps", initial_state=(0, 0, 20, 15), span=10**4),
    )
    invariants: ClassVar[Mapping[str, Invariant]] = {
        "energy": Invariant(projectile_energy),
        "horizontal_momentum": Invariant(horizontal_momentum),
    }
    forms = (Separable(uniform_gravity, height_potential),)
    scene = SCENE
    reversal = ("vx", "vy")
    mirror = ("x", "vx")

    def motion(self) -> Projectile:
        return Projectile(self.parameters["g"], *self.initial_state)

    @property
    def time_scale(self) -> float:
        """The time in which gravity changes the velocity by the initial speed; the span if gravity or speed is zero."""
        speed = math.hypot(float(self.initial_state[2]), float(self.initial_state[3]))
        g = float(self.parameters["g"])
        return speed / g if speed * g > 0 else float(self.span)

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """`range` to y = 0; the top of the envelope of all throws at this speed, and where it meets y = 0 (m)."""
        if self.parameters["g"] == 0:
            return {}
        motion = self.motion()
        apex_time, apex_height = motion.apex(digits)
        found = {"apex_time": apex_time, "apex_height": apex_height}
        landing = motion.landing(digits)
        if landing is not None:
            found |= {"landing_time": landing[0], "landing_x": landing[1], "range": motion.range(digits)}
        if motion.vx == 0 == motion.vy:
            return found
        found["highest_apex"] = motion.envelope(motion.x, digits)
        farthest = motion.farthest_range(digits)
        return found if farthest is None else found | {"farthest_range": farthest}
