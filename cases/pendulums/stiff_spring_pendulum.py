"""The pendulum on a stiff spring: a fast vibration along the spring beside a slow swing."""

import numpy as np
from gnomon.cases.core.arithmetic import mpmath_arithmetic, rebind
from gnomon.cases.declare import *
from gnomon.cases.pendulums.spring_pendulum import (
    SpringPendulum,
    spring_pendulum_acceleration,
    spring_pendulum_energy,
    spring_pendulum_potential,
)
from gnomon.cases.scenes.point import UP, free_point


def spring_numbers(parameters: Values) -> Values:
    """The parameters of the spring pendulum: mass, stiffness, length of the spring at rest, gravity."""
    length, g, w = parameters
    return 1, w * w, length, g


def stiff_spring_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    return spring_pendulum_acceleration(t, q, spring_numbers(parameters))


def stiff_spring_potential(t: Any, q: Values, parameters: Values) -> Values:
    return spring_pendulum_potential(t, q, spring_numbers(parameters))


def stiff_spring_energy(t: Any, state: Values, parameters: Values) -> Values:
    return spring_pendulum_energy(t, state, spring_numbers(parameters))


def stiff_spring_equations(t: Any, state: Values, parameters: Values) -> Values:
    x, y, vx, vy = state
    return (vx, vy, *stiff_spring_acceleration(t, (x, y), parameters))


def fast_action(state: Values, parameters: Values) -> Any:
    """The adiabatic invariant, the energy of the fast vibration over its frequency, to first order in 1/w.

    The vibration is about the length at which the spring carries the weight and the centrifugal force of the swing.
    """
    x, y, vx, vy = state
    length, g, w = parameters
    r = sqrt(x * x + y * y)
    along, across = (x * vx + y * vy) / r, (x * vy - y * vx) / r
    stretch = r - length - (across * across / r - g * y / r) / (w * w)
    return (along * along + w * w * stretch * stretch) / (2 * w)


def polar_equations(t: Any, state: Values, parameters: Values) -> Values:
    """Stretch and angle from the downward vertical; the stiff part, -w^2 stretch, is linear."""
    stretch, _theta, rate, turn = state
    _length, _g, w = parameters
    _, _, outward, turning = polar_load(t, state, parameters)
    return rate, turn, outward - w * w * stretch, turning


def polar_matrix(parameters: Values) -> Values:
    _length, _g, w = parameters
    return (0, 0, 1, 0, 0, 0, 0, 1, -w * w, 0, 0, 0, 0, 0, 0, 0)


def polar_load(t: Any, state: Values, parameters: Values) -> Values:
    stretch, theta, rate, turn = state
    length, g, _w = parameters
    r = length + stretch
    return 0, 0, r * turn * turn + g * cos(theta), -(2 * rate * turn + g * sin(theta)) / r


def to_polar(mp: Any, state: Any, parameters: Any) -> tuple[Any, ...]:
    x, y, vx, vy = state
    length, _g, _w = parameters
    r = mp.hypot(x, y)
    return r - length, mp.atan2(x, -y), (x * vx + y * vy) / r, (x * vy - y * vx) / (r * r)


def from_polar(y: Floats, parameters: Any) -> Floats:
    stretch, theta, rate, turn = np.moveaxis(y, -1, 0)
    r = parameters[0] + stretch
    s, c = np.sin(theta), np.cos(theta)
    return np.stack([r * s, -r * c, rate * s + r * turn * c, r * turn * s - rate * c], axis=-1)


SCENE = free_point(stiff_spring_equations, UP, token="position_force")


class StiffSpringPendulum(IntegratedCase):
    name = "stiff_spring_pendulum"
    title = "Pendulum on a stiff spring (no closed form; certified Taylor)"
    section = "11.9"
    conventions = (
        "[inferred] Unit mass, x right and y up from the pivot; w is the frequency of the spring alone, so its stiffness "
        "is w^2. The elastic pendulum of Hairer, Lubich and Wanner, Geometric Numerical Integration, XIV.3, with the "
        "stretch and its rate scaled as there: vibration and swing have energies of the same order for any w."
    )
    x = Coordinate("m", "0.8", typical(0.4, 1.2))
    y = Coordinate("m", "-0.6", typical(-1.2, -0.4))
    vx = Coordinate("m/s", "0.4", typical(-1, 1))
    vy = Coordinate("m/s", "-0.3", typical(-1, 1))
    L = Parameter("m", 1, "length of the spring at rest", positive(0.7, 1.3))
    g = Parameter("m/s^2", 1, "acceleration of gravity", positive(0.5, 2))
    w = Parameter("rad/s", 10, "frequency of the spring alone", positive(8, 30))
    rules = (Rule("the mass is not at the pivot", lambda numbers: numbers["x"] != 0 or numbers["y"] != 0),)
    default_span = Span(204, "time scale")
    variants = (
        Variant("ratio_100", "the vibration is a hundred times faster than the swing", {"w": 100}, periods=690),
        Variant("ratio_1000", "the vibration is a thousand times faster than the swing", {"w": 1000}, periods=690),
        Variant("many", "twice the span", periods=406),
    )
    invariants = conserved(energy=stiff_spring_energy)
    forms = (Separable(stiff_spring_acceleration, stiff_spring_potential),)
    formulations = (
        Formulation(
            "polar", (SemiLinear(polar_equations, linear=polar_matrix, rest=polar_load),), to_polar, from_polar
        ),
    )
    scene = SCENE
    mirror = ("x", "vx")

    @property
    def time_scale(self) -> float:
        """One radian of the vibration, or of a small swing if that is shorter."""
        length, g, w = map(float, self.parameter_values())
        return min(1 / w, sqrt((length + g / (w * w)) / g))

    def derived(self, digits: int) -> dict[str, Any]:
        """Length in equilibrium (m), frequencies of spring and small swings (rad/s), adiabatic invariant at the start (m^2/s)."""
        length, g, w = self.parameter_values()
        hanging = length + g / w**2

        def action(mp: Any) -> Any:
            function = rebind(fast_action, mpmath_arithmetic(mp))
            return function(tuple(map(mp.mpf, self.initial_state)), tuple(map(mp.mpf, self.parameter_values())))

        return {
            "hanging_length": hanging,
            "spring_frequency": w,
            "swing_frequency": lambda mp: mp.sqrt(mp.mpf(g) / mp.mpf(hanging)),
            "fast_action": action,
        }

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        """Swing and vibration uncoupled; then a rod instead of the spring."""
        length, g, w = self.parameter_values()
        same_motion = SpringPendulum(initial_state=self.initial_state, span=self.span, m=1, k=w**2, L=length, g=g)
        return same_motion.hierarchy
