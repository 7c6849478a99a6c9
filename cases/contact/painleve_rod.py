"""A rigid rod that slides on a rough plane on its lower end: Painleve's paradox."""

import math

from gnomon.cases.declare import *

STEPS = 200
"""Steps per time scale of the scout that looks for the end of sliding."""
FINEST = 1e-9
"""Part of a step to which the scout resolves the end of sliding."""
LONGEST = 20
"""Time scales that the scout looks ahead for the natural span."""


def shape(theta: Any, mu: Any) -> Any:
    """p(theta): the normal acceleration of the end for a unit normal force on a unit mass."""
    return 1 + 3 * cos(theta) * (cos(theta) - mu * sin(theta))


def normal_force(state: Values, parameters: Values) -> Any:
    """N/m (m/s^2), the force that keeps the end on the plane."""
    _x, theta, _vx, omega = state
    _m, l, mu, g = parameters
    return (g - l * omega * omega * sin(theta)) / shape(theta, mu)


def rod_equations(t: Any, state: Values, parameters: Values) -> Values:
    """The end at (x, 0) slides towards +x; the centre is at (x - l cos theta, l sin theta)."""
    _x, theta, vx, omega = state
    _m, l, mu, _g = parameters
    n = normal_force(state, parameters)
    turn = 3 * n * (cos(theta) - mu * sin(theta))
    return vx, omega, turn * sin(theta) - mu * n - l * cos(theta) * omega * omega, -turn / l


def rod_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy (J); potential energy is zero on the plane."""
    _x, theta, vx, omega = state
    m, l, _mu, g = parameters
    across, up = vx + l * omega * sin(theta), l * omega * cos(theta)
    return (m * ((across * across + up * up) / 2 + l * l * omega * omega / 6 + g * l * sin(theta)),)


def failing(state: tuple[float, ...], parameters: tuple[float, ...]) -> str | None:
    """What ends sliding in this state, in words."""
    _x, theta, vx, omega = state
    _m, l, mu, g = parameters
    if float(shape(theta, mu)) <= 0:
        return "p reaches 0 and there is no forward solution beyond"
    if g - l * omega * omega * math.sin(theta) <= 0:
        return "N reaches 0 and the rod lifts off"
    if math.sin(theta) <= 0:
        return "the rod falls flat on the plane"
    return "vx reaches 0 and the end stops" if vx <= 0 else None


def end_of_sliding(state: Floats, parameters: tuple[float, ...], step: float, span: float) -> tuple[float, str] | None:
    """The time at which sliding ends, and why; None if it lasts through the span. Runge-Kutta steps, binary64.

    A step that fails is halved down to `FINEST` of a step: near the end p and N fall together, and what reaches 0 first
    shows only there.
    """
    y: tuple[float, ...] = tuple(map(float, state))
    h, t, why = step, 0.0, ""
    while span - t > FINEST * step and h > FINEST * step:
        h = min(h, span - t)
        *stages, last = _stepped(y, parameters, h)
        failed = next((cause for stage in (*stages, last) if (cause := failing(stage, parameters))), None)
        if failed:
            h, why = h / 2, failed
        else:
            y, t = last, t + h
    return (t, why) if h <= FINEST * step and why else None


def _stepped(y: tuple[float, ...], parameters: tuple[float, ...], h: float) -> list[tuple[float, ...]]:
    """The stages of a step, and the state after it."""

    def rates(y: tuple[float, ...]) -> tuple[float, ...]:
        return tuple(map(float, rod_equations(0, y, parameters)))

    def moved(k: tuple[float, ...], h: float) -> tuple[float, ...]:
        return tuple(a + h * b for a, b in zip(y, k, strict=True))

    k1 = rates(y)
    middle = moved(k1, h / 2)
    k2 = rates(middle)
    other = moved(k2, h / 2)
    k3 = rates(other)
    end = moved(k3, h)
    k4 = rates(end)
    mean = tuple(a + 2 * b + 2 * c + d for a, b, c, d in zip(k1, k2, k3, k4, strict=True))
    return [middle, other, end, moved(mean, h / 6)]


def _regular(n: Mapping[str, Fraction]) -> bool:
    return float(shape(float(n["theta"]), float(n["mu"]))) > 0


def _pressed(n: Mapping[str, Fraction]) -> bool:
    return float(n["g"]) > float(n["l"]) * float(n["omega"]) ** 2 * math.sin(float(n["theta"]))


class PainleveRod(IntegratedCase):
    """A uniform rod pushed along a rough plane on its end, while it slides."""

    name = "painleve_rod"
    title = "Painleve's rod: sliding on its end with friction, up to the paradox (certified Taylor)"
    section = "10.6"
    conventions = (
        "[inferred] Not in the book: F. Genot, B. Brogliato, Eur. J. Mech. A/Solids 18 (1999) 653. A uniform rod of length 2 l "
        "has its lower end at (x, 0), its centre at (x - l cos theta, l sin theta); the end slides towards +x, friction is "
        "mu N towards -x, N = m (g - l omega^2 sin theta)/p, p = 1 + 3 cos theta (cos theta - mu sin theta). Only the sliding "
        "phase: p, N, vx and sin theta stay positive. p may vanish only if mu >= 4/3. The numbers are not published ones."
    )
    x = Coordinate("m", 0, typical(-1, 1))
    theta = Coordinate("rad", "0.4", typical(0.2, 0.8))
    vx = Coordinate("m/s", 6, typical(3, 8))
    omega = Coordinate("rad/s", 3, typical(-1, 3))
    m = Parameter("kg", 1, "mass", positive(0.5, 2))
    l = Parameter("m", "0.5", "half of the rod's length", positive(0.3, 1))
    mu = Parameter("1", "1.6", "coefficient of friction", nonnegative(0.1, 2))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(5, 15))
    rules = (
        Rule("the end slides towards +x (vx > 0)", lambda n: n["vx"] > 0),
        Rule("the rod is above the plane (0 < theta < pi)", lambda n: 0 < float(n["theta"]) < math.pi),
        Rule("the start is not paradoxical (p > 0)", _regular),
        Rule("the plane presses on the rod (N > 0)", _pressed),
    )
    variants = (
        Variant("never_paradoxical", "friction below 4/3: p has no zero", {"mu": 1}, (0, "0.4", 6, 1)),
        Variant("near_boundary", "stops shortly before p = 0, where the force is singular", span="0.134"),
        Variant("near_lift_off", "ends shortly before N reaches 0", {"mu": 1}, (0, "0.4", 8, 3), span="0.377"),
    )
    forms = (FirstOrder(rod_equations),)
    invariants = decaying(energy=rod_energy)
    reversal = None

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        with self._within_reach():
            end = self._end(float(self.span))
            if end:
                raise ValueError(f"at t = {end[0]:g} s {end[1]}; give a shorter span")

    def _end(self, span: float) -> tuple[float, str] | None:
        parameters = tuple(map(float, self.parameter_values()))
        start: Any = tuple(map(float, self.initial_state))
        return end_of_sliding(start, parameters, self.time_scale / STEPS, span)

    @property
    def time_scale(self) -> float:
        """The time of a radian of the rod as a pendulum, or at its first angular velocity."""
        return 1 / max(math.sqrt(float(self.g / self.l)), abs(float(self.omega)))

    def natural_span(self) -> Number:
        """0.8 of the time for which the end slides."""
        most = LONGEST * self.time_scale
        end = self._end(most)
        return 0.8 * (end[0] if end else most)
