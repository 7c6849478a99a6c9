"""The conservative cubic oscillator."""

from gnomon.cases.core import accuracy
from gnomon.cases.declare import *
from gnomon.cases.scenes.point import railed_pull
from gnomon.reference.oscillators.duffing_unforced import DuffingMotion


def cubic_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """x'' = -alpha x - beta x^3."""
    (x,) = q
    alpha, beta = parameters
    return (-alpha * x - beta * x * x * x,)


def quartic_potential(t: Any, q: Values, parameters: Values) -> Values:
    (x,) = q
    alpha, beta = parameters
    return (alpha * x * x / 2 + beta * x * x * x * x / 4,)


def quartic_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the mass."""
    x, v = state
    alpha, beta = parameters
    return (v * v / 2 + alpha * x * x / 2 + beta * x * x * x * x / 4,)


def _bounded(numbers: Mapping[str, Fraction]) -> bool:
    return DuffingMotion(numbers["alpha"], numbers["beta"], numbers["x"], numbers["v"]).bounded


SCENE = railed_pull(cubic_acceleration)


class DuffingUnforced(Case):
    """A spring that hardens (beta > 0) or softens (beta < 0), or two wells (alpha < 0), without damping or force."""

    name = "duffing_unforced"
    title = "Conservative cubic (Duffing) oscillator, Biermann-Weierstrass / cn, dn, sech"
    section = "6.13, 7.11.2 (quartic pendulum: alpha=w0^2, beta=-w0^2/6)"
    conventions = "x from the middle; forces over the mass."
    x = Coordinate("m", 1, typical(-2, 2))
    v = Coordinate("m/s", "0.5", typical(-2, 2))
    alpha = Parameter("1/s^2", 1, "linear stiffness over the mass", typical(-2, 2))
    beta = Parameter("1/(m^2 s^2)", 1, "cubic stiffness over the mass", typical(-2, 2))
    rules = (Rule("the motion is bounded (with beta < 0 it does not escape; alpha < 0 needs beta > 0)", _bounded),)
    exact_motion = bind(DuffingMotion)
    default_span = Span(10.37, lambda motion: motion.period(20))
    variants = (
        Variant("soft", "sn: softening spring", {"beta": "-0.25"}, ("1.2", "0.3")),
        Variant("one_well", "dn: stays in one of two wells", {"alpha": -1}, ("1.2", "0.1")),
        Variant("across_wells", "cn: swings across both wells", {"alpha": -1}, ("1.6", 0)),
        Variant("homoclinic", "sech: exactly the energy at the saddle", {"alpha": -1, "beta": 2}, (1, 0)),
        Variant("heteroclinic", "tanh: exactly the energy for escape", {"beta": "-0.5"}, (0, 1)),
        Variant("near_escape", "1e-12 below the escape speed", {"beta": "-0.5"}, (0, "0.999999999999"), periods=2.37),
        Variant("saddle_1e_8", "released 1e-8 m from the saddle", {"alpha": -1}, ("1e-8", 0), periods=0.9),
        Variant("saddle_1e_12", "released 1e-12 m from the saddle", {"alpha": -1}, ("1e-12", 0), periods=0.9),
        Variant("long_1e3", "1000 periods: phase error", periods=1000.37),
        Variant("long_1e4", "10,000 periods: phase error", periods=10000.37),
    )
    invariants = conserved(energy=quartic_energy)
    forms = (Separable(cubic_acceleration, quartic_potential),)
    scene = SCENE
    mirror = ("x", "v")

    @property
    def time_scale(self) -> float:
        """One over the root of the largest stiffness |alpha| + 3 |beta| x^2 of the motion; 1 s if that is zero."""
        alpha, beta = map(float, self.parameter_values())
        reach = max(abs(float(x)) for x in self.exact_motion.turning_points())
        stiffness = abs(alpha) + 3 * abs(beta) * reach**2
        return 1 / sqrt(stiffness) if stiffness > 0 else 1.0

    def natural_span(self) -> Number:
        """10.37 periods; 9 times 1/sqrt|alpha| on a separatrix; 10.37 turns of the time scale at rest."""
        if self.exact_motion.periodic:
            return super().natural_span()
        if self.exact_motion.regime == DuffingMotion.REST:
            return 10.37 * tau * self.time_scale
        return 9 / sqrt(abs(float(self.alpha)))

    def scales(self) -> dict[str, float]:
        """The scale of x in closed form if the span holds a period: close to a separatrix the peaks are narrow."""
        scales = accuracy.grid_scales(self)
        if self.exact_motion.periodic and self.span >= self.exact_motion.period():
            scales["length"] = max(abs(float(x)) for x in self.exact_motion.turning_points())
        return scales

    @property
    def quantity_names(self) -> tuple[str, ...]:
        names = ("least_x largest_x=turning_points", "energy", "escape_energy")
        return (*names, "period", "modulus_squared") if self.exact_motion.periodic else names
