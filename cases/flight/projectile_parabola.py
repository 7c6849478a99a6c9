"""The projectile in uniform gravity, without drag."""

from gnomon.cases.declare import *
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


def projectile_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    """A free point mass under gravity; y is along the engine's z."""
    x, y, vx, vy = state
    (g,) = parameters
    return Scene((0.0, 0.0, -g), (Body("projectile", 1.0, (0.0, 0.0, 0.0), (x, 0.0, y), velocity=(vx, 0.0, vy)),))


SCENE = SceneForm(projectile_scene, free_body("projectile", 0, 2), frozenset())


class ProjectileParabola(Case):
    name = "projectile_parabola"
    title = "Projectile in uniform gravity"
    section = "6.4.2"
    conventions = "x horizontal, y upward; the ground is y = 0 and is not part of the motion."
    x = Coordinate("m", 0)
    y = Coordinate("m", 0)
    vx = Coordinate("m/s", 20)
    vy = Coordinate("m/s", 15)
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", nonnegative(0, 20))
    exact_motion = bind(Projectile)
    default_span = 3
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
    invariants = conserved(energy=projectile_energy, horizontal_momentum=horizontal_momentum)
    forms = (Separable(uniform_gravity, height_potential),)
    scene = SCENE
    mirror = ("x", "vx")

    @property
    def time_scale(self) -> float:
        """The time in which gravity changes the velocity by the initial speed; the span if gravity or speed is zero."""
        speed = hypot(float(self.vx), float(self.vy))
        g = float(self.g)
        return speed / g if speed * g > 0 else float(self.span)

    @property
    def quantity_names(self) -> tuple[str, ...]:
        """`range` to y = 0; the top of the envelope of all throws at this speed, and where it meets y = 0 (m)."""
        if self.g == 0:
            return ()
        lands = () if self.exact_motion.landing() is None else ("landing_time landing_x=landing", "range")
        envelope = () if self.vx == 0 == self.vy else ("highest_apex", "farthest_range")
        return ("apex_time apex_height=apex", *lands, *envelope)
