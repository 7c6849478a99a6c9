"""A uniform chain on a smooth cycloid: isochronous for every length."""

from gnomon.cases.declare import *
from gnomon.cases.scenes.point import railed_pull
from gnomon.reference.oscillators.harmonic_oscillator import HarmonicMotion


def chain_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """L s'' = -g (y(s + L/2) - y(s - L/2)) with the cycloid's y(s) = s^2/8a."""
    (s,) = q
    g, a, length = parameters
    front, rear = s + length / 2, s - length / 2
    return (-g * (front * front - rear * rear) / (8 * a * length),)


def chain_potential(t: Any, q: Values, parameters: Values) -> Values:
    (s,) = q
    g, a, _ = parameters
    return (g * s * s / (8 * a),)


def chain_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the mass, zero at the lowest position."""
    s, v = state
    g, a, _ = parameters
    return (v * v / 2 + g * s * s / (8 * a),)


def _stays_between_cusps(n: Mapping[str, Fraction]) -> bool:
    room = 4 * n["a"] - n["L"] / 2
    return room > 0 and n["s"] ** 2 + 4 * n["a"] * n["v"] ** 2 / n["g"] <= room**2


SCENE = railed_pull(chain_acceleration)


class ChainSmoothCurve(Case):
    name = "chain_smooth_curve"
    title = "Chain on a smooth cycloid (isochronous for every length)"
    section = "8.12"
    conventions = "s: arc length of the chain's middle from the bottom; the cycloid y = s^2/8a has its cusps at s = 4a."
    s = Coordinate("m", "0.8", typical(-1, 1))
    v = Coordinate("m/s", 0, typical(-1, 1))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    a = Parameter("m", "0.5", "radius of the rolling circle", positive(1, 5))
    L = Parameter("m", 2, "length of the chain", positive(0.1, 4))
    rules = (Rule("the ends of the chain stay between the cusps: amplitude + L/2 <= 4 a", _stays_between_cusps),)
    exact_motion = bind(lambda c: HarmonicMotion(4 * c.a, c.g, *c.initial_state))
    default_span = Span(10.37, "turn")
    quantity_names = ("period", "amplitude")
    variants = (
        Variant("cusp_to_cusp", "the ends of the chain just reach the cusps", initial_state=(1, 0)),
        Variant("short", "L = 1e-9 m: the difference of the heights of its ends cancels", {"L": "1e-9"}),
        Variant("long_1e5", "100,000 periods: phase error", periods=100_000.37),
    )
    invariants = conserved(energy=chain_energy)
    forms = (Separable(chain_acceleration, chain_potential),)
    scene = SCENE

    @property
    def time_scale(self) -> float:
        """2 sqrt(a/g)."""
        return 2 * sqrt(float(self.a) / float(self.g))
