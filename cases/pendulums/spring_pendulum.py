"""The spring pendulum: a point mass that swings on a spring."""

import numpy as np
from gnomon.cases.declare import *
from gnomon.cases.oscillators.small_vibrations import SmallVibrations
from gnomon.cases.pendulums.pendulum_simple import PendulumSimple
from gnomon.cases.scenes.point import UP, free_point
from gnomon.reference.numerics.precision import publish, working


def spring_pendulum_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """The spring pulls along itself with k times its stretch; gravity acts along -y."""
    x, y = q
    m, k, length, g = parameters
    pull = (k / m) * (1 - length / sqrt(x * x + y * y))
    return -pull * x, -pull * y - g


def spring_pendulum_potential(t: Any, q: Values, parameters: Values) -> Values:
    x, y = q
    m, k, length, g = parameters
    stretch = sqrt(x * x + y * y) - length
    return ((k / m) * stretch * stretch / 2 + g * y,)


def spring_pendulum_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the mass."""
    x, y, vx, vy = state
    return ((vx * vx + vy * vy) / 2 + spring_pendulum_potential(t, (x, y), parameters)[0],)


def spring_pendulum_equations(t: Any, state: Values, parameters: Values) -> Values:
    x, y, vx, vy = state
    return (vx, vy, *spring_pendulum_acceleration(t, (x, y), parameters))


SCENE = free_point(spring_pendulum_equations, UP, token="position_force")


class SpringPendulum(IntegratedCase):
    name = "spring_pendulum"
    title = "Spring pendulum (no closed form; certified Taylor)"
    section = "11.9"
    conventions = "x right and y up from the pivot; the spring pushes when compressed; the mass never passes the pivot."
    x = Coordinate("m", 1, typical(0.5, 1.5))
    y = Coordinate("m", "-0.5", typical(-1.5, -0.5))
    vx = Coordinate("m/s", 0, typical(-1, 1))
    vy = Coordinate("m/s", 0, typical(-1, 1))
    m = Parameter("kg", 1, "mass", positive(0.5, 2))
    k = Parameter("N/m", 40, "stiffness of the spring", positive(20, 100))
    L = Parameter("m", 1, "length of the spring at rest", positive(0.5, 1.5))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(5, 12))
    rules = (Rule("the mass is not at the pivot", lambda numbers: numbers["x"] != 0 or numbers["y"] != 0),)
    default_span = Span(12.3, "time scale")
    variants = (
        Variant(
            "resonance",
            "k L = 3 m g: the spring's frequency is twice the swing's, and energy passes between them",
            {"k": "29.43"},
            ("0.05", "-1.4", 0, 0),
            periods=30,
        ),
        Variant(
            "stiff",
            "k = 1e4: nearly a rod, with a fast vibration of 1e-3 of its length",
            {"k": 10**4},
            ("0.8", "-0.6", 0, 0),
            periods=3.3,
        ),
        Variant("vertical", "vertical motion only: x stays exactly zero", initial_state=(0, -1, 0, 0)),
    )
    invariants = conserved(energy=spring_pendulum_energy)
    forms = (Separable(spring_pendulum_acceleration, spring_pendulum_potential),)
    scene = SCENE
    mirror = ("x", "vx")

    @property
    def time_scale(self) -> float:
        """sqrt((L + m g/k)/g), the time of a small swing."""
        m, k, length, g = map(float, self.parameter_values())
        return sqrt((length + m * g / k) / g)

    @property
    def fastest_time(self) -> float:
        return min(self.time_scale, sqrt(float(self.m) / float(self.k)))

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """Length in equilibrium (m), and the frequencies of small swings and of the spring (rad/s)."""
        with working(digits + 10) as mp:
            m, k, length, g = map(mp.mpf, self.parameter_values())
            hanging = length + m * g / k
            values = publish((hanging, mp.sqrt(g / hanging), mp.sqrt(k / m)), digits)
        return dict(zip(("hanging_length", "swing_frequency", "spring_frequency"), values, strict=True))

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        """Two uncoupled oscillators about the equilibrium, swing and spring (a third mass stays at rest); then a rod."""
        m, k, length, g = self.parameter_values()
        x, y, vx, vy = self.initial_state
        hanging = length + m * g / k
        springs: dict[str, Any] = {"k1": m * g / hanging, "k2": k, "k3": k, "k12": 0, "k23": 0}
        small = SmallVibrations(
            initial_state=(x, y + hanging, 0, vx, vy, 0), span=self.span, m1=m, m2=m, m3=m, **springs
        )
        rest = float(hanging)

        def hung(states: Floats) -> Floats:
            return np.stack([states[:, 0], states[:, 1] - rest, states[:, 3], states[:, 4]], axis=1)

        smallest = Level(small, hung, "small swings: spring and swing uncoupled")
        if not x and not vx:
            return (smallest,)
        away, begin = hypot(float(x), float(y)), atan2(float(x), -float(y))
        turn = (float(vx) * cos(begin) + float(vy) * sin(begin)) / away
        rod = PendulumSimple(initial_state=(begin, turn), span=self.span, g=g, L=hanging)

        def on_the_circle(states: Floats) -> Floats:
            angle, rate = states.T
            s, c = np.sin(angle), np.cos(angle)
            return rest * np.stack([s, -c, rate * c, rate * s], axis=1)

        return (smallest, Level(rod, on_the_circle, "swings of any amplitude, a rod instead of the spring"))
