"""The projectile with Stokes drag, proportional to the velocity."""

from gnomon.cases.declare import *
from gnomon.cases.flight.projectile_parabola import ProjectileParabola
from gnomon.cases.scenes.point import UP, free_point
from gnomon.reference.flight.projectile_stokes_drag import StokesDrag


def stokes_equations(t: Any, state: Values, parameters: Values) -> Values:
    """r'' = g - nu r'."""
    _x, _y, vx, vy = state
    g, nu = parameters
    return vx, vy, -nu * vx, -g - nu * vy


def stokes_matrix(parameters: Values) -> Values:
    _g, nu = parameters
    return 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -nu, 0, 0, 0, 0, -nu


def weight_alone(t: Any, state: Values, parameters: Values) -> Values:
    g, _nu = parameters
    return 0, 0, 0, -g


def stokes_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy per unit mass."""
    _x, y, vx, vy = state
    g, _nu = parameters
    return ((vx * vx + vy * vy) / 2 + g * y,)


def stokes_momentum(t: Any, state: Values, parameters: Values) -> Values:
    """vx + nu x, constant: drag reduces the velocity by nu times the distance."""
    x, _y, vx, _vy = state
    _g, nu = parameters
    return (vx + nu * x,)


SCENE = free_point(stokes_equations, UP)


class ProjectileStokesDrag(Case):
    name = "projectile_stokes_drag"
    title = "Projectile with Stokes drag; range by Lambert's W"
    section = "6.5.1-6.5.2"
    conventions = "x horizontal, y upward; drag -nu v per unit mass; the ground is not part of the motion."
    x = Coordinate("m", 0)
    y = Coordinate("m", 0)
    vx = Coordinate("m/s", 20)
    vy = Coordinate("m/s", 15)
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    nu = Parameter("1/s", "0.5", "drag over mass and speed", nonnegative(0, 5))
    exact_motion = bind(lambda c: StokesDrag(c.nu, (c.g * 0, -c.g), (c.x, c.y), (c.vx, c.vy)))
    variants = (
        Variant("weak", "nu = 1e-10: the exact formula cancels to a parabola", {"nu": "1e-10"}, span="2.9"),
        Variant("stiff", "nu = 1e5: reaches its limiting speed after 1e-5 s of 10 s", {"nu": 10**5}, span=10),
        Variant("no_drag", "nu = 0: exactly the parabola", {"nu": 0}, span=3),
        Variant("engines", "the parameters of engine tests: nu = 0.5, 2 s", initial_state=(0, 0, 10, 10), span=2),
    )
    invariants = decaying(energy=stokes_energy) | conserved(horizontal_momentum=stokes_momentum)
    forms = (SemiLinear(stokes_equations, linear=stokes_matrix, rest=weight_alone),)
    scene = SCENE

    @property
    def time_scale(self) -> float:
        """The shorter of the times in which drag slows the body and in which gravity bends its path."""
        g, nu = map(float, self.parameter_values())
        speed = hypot(*map(float, self.initial_state[2:])) or 1.0
        return min(1 / nu, speed / g) if nu > 0 else speed / g

    def natural_span(self) -> Number:
        """Beyond the end of the throw: four times the time in which gravity bends the path, at most twenty decay times."""
        g, nu = map(float, self.parameter_values())
        speed = hypot(*map(float, self.initial_state[2:])) or 1.0
        return min(20 / nu, 1.97 * speed / g) if nu > 0 else 1.97 * speed / g

    def derived(self, digits: int) -> dict[str, Any]:
        """If it is thrown upward: the flight back to the initial height."""
        motion, time = self.exact_motion, self.exact_motion.flight_time(1, digits)
        return {
            "terminal_speed": motion.terminal_speed(1, digits) if self.nu > 0 else None,
            "flight_time": time,
            "range": None if time is None else motion.range(1, 0, digits),
        }

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        return (self.level(ProjectileParabola, "no drag: the parabola"),)
