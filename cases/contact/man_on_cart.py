"""A man who walks back and forth on a cart or in a boat: the centre of mass moves uniformly."""

from gnomon.cases.declare import *
from gnomon.cases.scenes.cart import MAN
from gnomon.reference.oscillators.forced_oscillators import ForcedLinear

ZERO = Fraction(0)


def cart_recoils(t: Any, q: Values, parameters: Values) -> Values:
    """(m + M) x'' = -m xi'', with xi = (d/2) (1 - cos(w t)) the man's position on the cart."""
    m, M, d, w = parameters
    return (-m * d * w * w * cos(w * t) / (2 * (m + M)),)


def cart_and_man_momentum(t: Any, state: Values, parameters: Values) -> Values:
    _, v = state
    m, M, d, w = parameters
    return ((m + M) * v + m * d * w * sin(w * t) / 2,)


def cart_and_man_centre(t: Any, state: Values, parameters: Values) -> Values:
    """x_C - v_C t, constant; the cart's centre of mass is at x."""
    x, v = state
    m, M, d, w = parameters
    share, half = m / (m + M), sin(w * t / 2)
    return (x + share * d * half * half - t * (v + share * d * w * sin(w * t) / 2),)


class ManOnCart(Case):
    name = "man_on_cart"
    title = "Man walking back and forth on a cart (or in a boat): the centre of mass moves uniformly"
    section = "8.2, 8.4"
    conventions = (
        "x of the cart, on a smooth floor (of the boat, on water without resistance). The man walks from one end to the "
        "other and back: he is at x + xi, with xi = (d/2) (1 - cos(w t)) prescribed."
    )
    x = Coordinate("m", 0, typical(-3, 3))
    v = Coordinate("m/s", "0.01", typical(-3, 3))
    m = Parameter("kg", 75, "mass of the man", positive())
    M = Parameter("kg", 150, "mass of the cart", positive())
    d = Parameter("m", 3, "length of the walk", typical(-3, 3))
    w = Parameter("rad/s", "0.5", "frequency of the walk", positive(0.1, 5))
    exact_motion = bind(
        lambda c: ForcedLinear(ZERO, ZERO, ZERO, -c._half_way * c.w * c.w, ZERO, c.w, ZERO, *c.initial_state)
    )
    default_span = Span(10.37, "turn")
    variants = (
        Variant(
            "light_cart", "M = 1e-9 m: the man stays in place, the cart moves back and forth below him", {"M": "75e-9"}
        ),
        Variant(
            "heavy_cart",
            "M = 1e9 m: the cart moves by 1e-9 of the walk, below a larger absolute tolerance",
            {"M": 75 * 10**9},
            (0, 0),
        ),
        Variant(
            "drifting", "drifts at 1e6 m/s: few digits of the state are left for the walk", initial_state=(0, 10**6)
        ),
        Variant("long_1e5", "100,000 walks: phase error", periods=100_000.37),
    )
    invariants = conserved(momentum=cart_and_man_momentum, centre_of_mass_start=cart_and_man_centre)
    autonomous = False
    forms = (SecondOrder(cart_recoils),)
    scene = MAN

    @property
    def _half_way(self) -> Fraction:
        """m d/(2 (m + M)), half the distance that the cart moves."""
        m, M, d, _ = self.parameter_values()
        return m * d / (2 * (m + M))

    @property
    def time_scale(self) -> float:
        """1/w."""
        return 1 / float(self.w)

    def derived(self, digits: int) -> dict[str, Any]:
        """The distance that the cart moves, m d/(m + M) (m); the largest force (N); the speed of the centre of mass (m/s)."""
        return {
            "cart_way": 2 * abs(self._half_way),
            "largest_force": self.M * abs(self._half_way) * self.w * self.w,
            "centre_speed": self.v,
        }
