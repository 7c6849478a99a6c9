"""Radial fall under the inverse-square law."""

from gnomon.cases.declare import *
from gnomon.cases.scenes.point import railed_pull
from gnomon.reference.orbits.radial_fall_inverse_square import RadialFall


def radial_attraction(t: Any, q: Values, parameters: Values) -> Values:
    """r'' = -mu/r^2."""
    (r,) = q
    (mu,) = parameters
    return (-mu / (r * r),)


def radial_potential(t: Any, q: Values, parameters: Values) -> Values:
    (r,) = q
    (mu,) = parameters
    return (-mu / r,)


def radial_energy(t: Any, state: Values, parameters: Values) -> Values:
    r, v = state
    (mu,) = parameters
    return (v * v / 2 - mu / r,)


def falling_masses(parameters: Values) -> Values:
    """The attracting point, and a test particle."""
    (mu,) = parameters
    return mu, 0.0


def falling_bodies(state: Values) -> tuple[Values, ...]:
    r, v = state
    return (0.0, 0.0, 0.0, 0.0, 0.0, 0.0), (r, 0.0, 0.0, v, 0.0, 0.0)


def apart(bodies: tuple[Values, ...]) -> Values:
    centre, particle = bodies
    return particle[0] - centre[0], particle[3] - centre[3]


SCENE = railed_pull(radial_attraction)


class RadialFallInverseSquare(Case):
    name = "radial_fall_inverse_square"
    title = "Radial fall under the inverse-square law: plunge and escape"
    section = "5.9, 5.10, 7.7.1"
    conventions = "r from the attracting point, v outward; the motion ends at the collision."
    r = Coordinate("m", 67_000_000, positive(0.5, 5))
    v = Coordinate("m/s", 0, typical(-2, 2))
    mu = Parameter("m^3/s^2", 398_600_441_800_000, "gravitational parameter: the Earth's", positive())
    exact_motion = bind(RadialFall)
    quantity_names = ("escape_speed", "farthest", "collision_time")
    variants = (
        Variant(
            "plunge",
            "until 1e-5 of the fall is left before the collision: the speed grows without bound",
            {"mu": 1},
            (1, 0),
            "1.11071",
        ),
        Variant(
            "collision",
            "until 1.2e-16 of the fall is left before the collision: the next double is after it",
            {"mu": 1.2337005501361695},
            (1, 0),
            1,
        ),
        Variant("escape", "exactly at the escape speed: the limit between two regimes", {"mu": 2}, (1, 2), 1000),
        Variant("above_escape", "1e-12 above the escape speed", {"mu": 2}, (1, "2.000000000002"), 1000),
        Variant(
            "below_escape", "1e-12 below the escape speed: returns after 1e18 s", {"mu": 2}, (1, "1.999999999998"), 1000
        ),
        Variant("thrown", "thrown up: turns back and falls", {"mu": 1}, ("0.2", 3)),
    )
    invariants = conserved(energy=radial_energy)
    forms = (
        Separable(radial_attraction, radial_potential),
        NBody(falling_masses, falling_bodies, apart),
    )
    scene = SCENE

    @property
    def time_scale(self) -> float:
        """sqrt(r0^3/mu), or r0 over the speed if that is shorter."""
        mu, (r, v) = float(self.mu), map(float, self.initial_state)
        return min(sqrt(r**3 / mu), abs(r / v) if v else inf)

    def natural_span(self) -> Number:
        """0.93 of the time to the collision; 20.7 time scales if there is none or it is later."""
        collision = self.exact_motion.collision_time()
        far = 20.7 * self.time_scale
        return far if collision is None else min(0.93 * float(collision), far)
