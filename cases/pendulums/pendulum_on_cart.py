"""A pendulum under a cart that is free to roll: the centre of mass moves uniformly along the rail."""

from gnomon.cases.core import accuracy
from gnomon.cases.declare import *
from gnomon.cases.oscillators.well import WellCase
from gnomon.cases.scenes.cart import CART_PENDULUM
from gnomon.reference.pendulums.light_cart import LightCart
from gnomon.reference.pendulums.pendulum_on_cart import CartPendulum


def cart_equations(t: Any, state: Values, parameters: Values) -> Values:
    """x'' = m sin th (L th'^2 + g cos th)/(M + m sin^2 th), L th'' = -g sin th - x'' cos th."""
    _, theta, vx, omega = state
    g, m, M, length = parameters
    sine, cosine = sin(theta), cos(theta)
    cart = m * sine * (length * omega * omega + g * cosine) / (M + m * sine * sine)
    return vx, omega, cart, -(g * sine + cart * cosine) / length


def cart_momentum(t: Any, state: Values, parameters: Values) -> Values:
    _, theta, vx, omega = state
    _, m, M, length = parameters
    return ((M + m) * vx + m * length * omega * cos(theta),)


def cart_energy(t: Any, state: Values, parameters: Values) -> Values:
    _, theta, vx, omega = state
    g, m, M, length = parameters
    kinetic = ((M + m) * vx * vx + m * length * length * omega * omega) / 2 + m * length * vx * omega * cos(theta)
    return (kinetic + 2 * m * g * length * sin(theta / 2) * sin(theta / 2),)


def _swings(n: Any) -> bool:
    return CartPendulum(n["g"], n["m"], n["M"], n["L"], n["x"], n["theta"], n["vx"], n["omega"]).swings


def _motion(case: "PendulumOnCart") -> Any:  # LightCart is not a WellMotion
    moves = case.theta != 0 or case.omega != 0
    kind = LightCart if case.m > case.M and moves else CartPendulum
    return kind(*case.parameter_values(), *case.initial_state)


class PendulumOnCart(WellCase):
    name = "pendulum_on_cart"
    title = "Pendulum on a cart that is free to roll"
    section = "8.10, 8.11"
    conventions = (
        "[inferred] The book names the system; the model is a point mass m on a massless rod L, hinged to a cart M on a "
        "smooth straight rail. theta from the downward vertical; the pendulum swings and does not turn over."
    )
    x = Coordinate("m", 0, typical(-2, 2))
    theta = Coordinate("rad", 2, Range(low=-pi, high=pi, typical=(-1.0, 1.0)))
    vx = Coordinate("m/s", "0.3", typical(-2, 2))
    omega = Coordinate("rad/s", 0, typical(-1, 1))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(1, 10))
    m = Parameter("kg", 1, "mass of the pendulum", positive(0.2, 1))
    M = Parameter("kg", 2, "mass of the cart", positive(2, 5))
    L = Parameter("m", 1, "length of the rod", positive(0.5, 2))
    rules = (Rule("the energy is below that at the top (the pendulum swings)", _swings),)
    exact_motion = bind(_motion)
    variants = (
        Variant(
            "light_cart",
            "M = 0.1 m: the mass falls almost straight, the cart moves fast while the mass passes below the hinge",
            {"M": "0.1"},
        ),
        Variant(
            "bare_cart",
            "m/M = 1e8: for about 1e-9 s of each swing the cart moves at 5e4 m/s, when the mass passes below the hinge",
            {"M": "1e-8"},
            span="4.1",
        ),
        Variant("heavy_cart", "M = 1e8 m: the cart moves by 1e-8 of the swing", {"M": 10**8}, (0, 2, 0, 0)),
        Variant("long_1e4", "10,000 periods: phase error beside a drift of 8e3 m", periods=10000.37),
    )
    invariants = conserved(energy=cart_energy, momentum=cart_momentum)
    forms = (FirstOrder(cart_equations),)
    scene = CART_PENDULUM
    reversal = ("vx", "omega")

    @property
    def fastest_time(self) -> float:
        """The time in which the pendulum turns by sqrt(M/m) rad at the bottom, where a light cart moves fast."""
        rate = self._bottom_rate()
        m, M = float(self.m), float(self.M)
        return min(self.time_scale, sqrt(M / m) / rate) if rate else self.time_scale

    def _bottom_rate(self) -> float:
        """theta' at the bottom, from the energy (rad/s)."""
        if self.exact_motion.rests:
            return 0.0
        g, m, M, length = map(float, self.parameter_values())
        return 2 * sin(float(self.exact_motion.turning_points()[1]) / 2) * sqrt(g * (M + m) / (M * length))

    def scales(self) -> dict[str, float]:
        """On a grid, and at the bottom, where the speeds have a peak that may be narrower than the grid spacing."""
        scales = accuracy.grid_scales(self)
        if not self.exact_motion.rests and self.span >= self.exact_motion.period() / 2:
            _g, m, M, length = map(float, self.parameter_values())
            arm, rate, (_, theta, vx, omega) = m * length / (M + m), self._bottom_rate(), map(float, self.initial_state)
            scales["angular velocity"] = rate
            scales["velocity"] = abs(vx + arm * omega * cos(theta)) + arm * rate
        return scales
