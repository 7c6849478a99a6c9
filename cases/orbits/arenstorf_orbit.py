"""Arenstorf's orbits: a satellite that loops round the Earth and the Moon, and closes."""

from gnomon.cases.declare import *


def satellite(t: Any, state: Values, parameters: Values) -> Values:
    """The plane restricted problem of three bodies, in axes that turn with Earth and Moon."""
    x, y, vx, vy = state
    (mu,) = parameters
    rest = 1 - mu
    earth, moon = x + mu, x - rest
    first, second = earth * earth + y * y, moon * moon + y * y
    a, b = rest / (first * sqrt(first)), mu / (second * sqrt(second))
    return vx, vy, x + 2 * vy - a * earth - b * moon, y - 2 * vx - (a + b) * y


def jacobi_constant(t: Any, state: Values, parameters: Values) -> Values:
    x, y, vx, vy = state
    (mu,) = parameters
    rest = 1 - mu
    earth, moon = x + mu, x - rest
    near = rest / sqrt(earth * earth + y * y) + mu / sqrt(moon * moon + y * y)
    return (x * x + y * y + 2 * near - vx * vx - vy * vy,)


class ArenstorfOrbit(IntegratedCase):
    """A satellite in the plane of Earth and Moon, which circle each other: after several loops its orbit closes."""

    name = "arenstorf_orbit"
    title = "Arenstorf orbit of the restricted three-body problem (no closed form; certified Taylor)"
    section = "8.9.2"
    conventions = (
        "[inferred] Not in the book: R. F. Arenstorf, American Journal of Mathematics 85 (1963) 27; E. Hairer, S. P. Norsett, "
        "G. Wanner, Solving Ordinary Differential Equations I, II.0, whose numbers these are. The axes turn with Earth "
        "(at -mu) and Moon (at 1 - mu); distance and rate of the two are 1, mu is the Moon's share of the mass."
    )
    x = Coordinate("m", "0.994", typical(0.9, 0.994))
    y = Coordinate("m", 0, typical(-0.05, 0.05))
    vx = Coordinate("m/s", 0, typical(-0.1, 0.1))
    vy = Coordinate("m/s", "-2.0317326295573368357302057924", typical(-2.1, -1.9))
    mu = Parameter(
        "1",
        "0.012277471",
        "the Moon's share of the mass",
        Range(0.0, 1.0, low_open=True, high_open=True, typical=(0.01, 0.02)),
    )
    rules = (
        Rule("the satellite is not at the Earth", lambda n: n["x"] != -n["mu"] or n["y"] != 0),
        Rule("the satellite is not at the Moon", lambda n: n["x"] != 1 - n["mu"] or n["y"] != 0),
    )
    default_span = "11.12434033726608"
    longest = 5000
    most_work = 50_000
    variants = (
        Variant(
            "four_loops",
            "the orbit of four loops, over its period: four passages by the Earth, the Moon at 0.006 m at both ends",
            initial_state=("0.994", 0, 0, "-2.00158510637908252240537862224"),
            span="17.06521656015796",
        ),
    )
    invariants = conserved(jacobi_constant=jacobi_constant)
    forms = (FirstOrder(satellite),)
    reversal = ("vx", "y")
    time_scale = 1.0  # a radian of Earth and Moon round each other

    @property
    def fastest_time(self) -> float:
        """The time of a radian round the nearer of Earth and Moon at the start."""
        x, y, mu = float(self.x), float(self.y), float(self.mu)
        earth, moon = hypot(x + mu, y), hypot(x - 1 + mu, y)
        return min(1.0, sqrt(earth**3 / (1 - mu)), sqrt(moon**3 / mu))
