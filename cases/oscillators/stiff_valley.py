"""A point in a valley with steep walls that narrows: a fast vibration across it drives the slow motion along it."""

from gnomon.cases.core.arithmetic import mpmath_arithmetic, rebind
from gnomon.cases.declare import *
from gnomon.cases.scenes.point import UP, free_point


def valley_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """Minus the gradient of k x^2/2 + w^2 (1 + b x^2) y^2/2."""
    x, y = q
    k, b, w = parameters
    steep = w * w
    return -k * x - steep * b * x * y * y, -steep * (1 + b * x * x) * y


def valley_potential(t: Any, q: Values, parameters: Values) -> Values:
    x, y = q
    k, b, w = parameters
    return (k * x * x / 2 + w * w * (1 + b * x * x) * y * y / 2,)


def valley_energy(t: Any, state: Values, parameters: Values) -> Values:
    x, y, vx, vy = state
    return ((vx * vx + vy * vy) / 2 + valley_potential(t, (x, y), parameters)[0],)


def valley_equations(t: Any, state: Values, parameters: Values) -> Values:
    x, y, vx, vy = state
    return (vx, vy, *valley_acceleration(t, (x, y), parameters))


def valley_action(state: Values, parameters: Values) -> Any:
    """The adiabatic invariant, the energy across the valley over the frequency there."""
    x, y, _vx, vy = state
    _k, b, w = parameters
    local = w * sqrt(1 + b * x * x)
    return (vy * vy + local * local * y * y) / (2 * local)


SCENE = free_point(valley_equations, UP, token="position_force")


class StiffValley(IntegratedCase):
    name = "stiff_valley"
    title = "Point in a stiff valley that narrows (no closed form; certified Taylor)"
    section = "6.14"
    conventions = (
        "[inferred] Unit mass, V = k x^2/2 + w^2 (1 + b x^2) y^2/2: x along the valley, y across it. A frequency that "
        "depends on the slow motion, as in Hairer, Lubich and Wanner, Geometric Numerical Integration, XIV.3; the start "
        "has y of order 1/w, so that the energies along and across are of the same order for any w."
    )
    x = Coordinate("m", 1, typical(-1.5, 1.5))
    y = Coordinate("m", "0.04", typical(-0.1, 0.1))
    vx = Coordinate("m/s", 0, typical(-1, 1))
    vy = Coordinate("m/s", "0.5", typical(-1, 1))
    k = Parameter("1/s^2", 1, "stiffness along the valley", positive(0.5, 2))
    b = Parameter("1/m^2", 1, "narrowing of the valley", nonnegative(0, 2))
    w = Parameter("rad/s", 25, "frequency across the valley at x = 0", positive(5, 40))
    default_span = Span(364, "time scale")
    variants = (
        Variant("steep", "w = 100: four times steeper walls", {"w": 100}, (1, "0.01", 0, "0.5"), periods=608),
        Variant("steepest", "w = 1000: forty times steeper walls", {"w": 1000}, (1, "0.001", 0, "0.5"), periods=664),
        Variant("uniform", "b = 0: both directions vibrate alone", {"b": 0}),
    )
    invariants = conserved(energy=valley_energy)
    forms = (Separable(valley_acceleration, valley_potential),)
    scene = SCENE

    @property
    def time_scale(self) -> float:
        """One radian of the vibration across the valley at the start, or along it if that is shorter."""
        k, b, w = map(float, self.parameter_values())
        x, _y, _vx, _vy = map(float, self.initial_state)
        return min(1 / sqrt(k), 1 / (w * sqrt(1 + b * x * x)))

    def derived(self, digits: int) -> dict[str, Any]:
        """The frequency across the valley at the start (rad/s), and the adiabatic invariant there (m^2/s)."""
        k, b, w = self.parameter_values()
        square = w**2 * (1 + b * self.x**2)

        def action(mp: Any) -> Any:
            function = rebind(valley_action, mpmath_arithmetic(mp))
            return function(tuple(map(mp.mpf, self.initial_state)), tuple(map(mp.mpf, (k, b, w))))

        return {"local_frequency": lambda mp: mp.sqrt(mp.mpf(square)), "fast_action": action}
