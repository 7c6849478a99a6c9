"""Radial oscillation of a rubber tube: a thin wall, and a wall of any thickness.

Cases: rubber_tube_thin, rubber_tube_thick.
"""

from gnomon.cases.core import accuracy
from gnomon.cases.declare import *
from gnomon.cases.oscillators.well import WellCase
from gnomon.reference.oscillators.rubber_tube_thick import ThickTube
from gnomon.reference.oscillators.rubber_tube_thin import Pinney


def thin_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """x'' = -w^2 (x - 1/x^3)."""
    (x,) = q
    (w,) = parameters
    return (-w * w * (x - 1 / (x * x * x)),)


def thin_potential(t: Any, q: Values, parameters: Values) -> Values:
    (x,) = q
    (w,) = parameters
    return (w * w * (x * x + 1 / (x * x)) / 2,)


def thin_energy(t: Any, state: Values, parameters: Values) -> Values:
    x, v = state
    (w,) = parameters
    return ((v * v + w * w * (x - 1 / x) * (x - 1 / x)) / 2,)


def thick_equations(t: Any, state: Values, parameters: Values) -> Values:
    """x'' = -(M' v^2/2 + V')/M, M = x^2 ln(1 + gam/x^2).

    V = (w^2/2)(x^2 - 1) (ln(1 + gam) - ln(1 + gam/x^2)) - p (x^2 - 1)/2.
    """
    x, v = state
    gam, w, p = parameters
    square = x * x
    wall = log(1 + gam / square)
    half_slope = x * wall - gam * x / (square + gam)
    force = (w * w / 2) * (2 * x * (log(1 + gam) - wall) + 2 * gam * (square - 1) / (x * (square + gam)))
    return v, -(half_slope * v * v + force - p * x) / (square * wall)


def thick_energy(t: Any, state: Values, parameters: Values) -> Values:
    x, v = state
    gam, w, p = parameters
    wall = log(1 + gam / (x * x))
    return ((x * x * wall * v * v + (x * x - 1) * (w * w * (log(1 + gam) - wall) - p)) / 2,)


def _holds(n: Mapping[str, Fraction]) -> bool:
    return ThickTube(n["gam"], n["w"], n["x"], n["v"], n["p"]).holds


class RubberTubeThin(Case):
    """No scene: rigid bodies do not express a wall that deforms."""

    name = "rubber_tube_thin"
    title = "Radial oscillation of a thin-walled incompressible (neo-Hookean/Mooney-Rivlin) tube: Ermakov-Pinney"
    section = "6.13.2"
    conventions = "x=a(t)/A, w^2=mu/(rho A^2); isochronous with period pi/w at every amplitude."
    x = Coordinate("1", "0.5", positive(0.1, 5))
    v = Coordinate("1/s", 0, typical(-5, 5))
    w = Parameter("rad/s", 2, "rate: w^2 = mu/(rho A^2)", positive())
    exact_motion = bind(Pinney)
    default_span = Span(10.37, "turn")
    quantity_names = ("period", "least", "largest", "top_rate=top_speed")
    variants = (
        Variant("squeezed_1e-2", "released at x = 1e-2: turns within 1e-4 of the period", initial_state=("1e-2", 0)),
        Variant("squeezed_1e-4", "released at x = 1e-4: turns within 1e-8 of the period", initial_state=("1e-4", 0)),
        Variant(
            "small",
            "amplitude 1e-6 about x = 1: the period does not depend on the amplitude",
            initial_state=(1, "2e-6"),
        ),
        Variant("long_1e5", "100,000 periods: phase error", periods=100_000.37),
    )
    invariants = conserved(energy=thin_energy)
    forms = (Separable(thin_acceleration, thin_potential),)

    @property
    def time_scale(self) -> float:
        """The period over 2 pi."""
        return 1 / (2 * float(self.w))

    @property
    def fastest_time(self) -> float:
        """The time in which the motion turns where the tube is narrowest."""
        return 1 / (float(self.exact_motion.largest()) ** 2 * float(self.w))

    def scales(self) -> dict[str, float]:
        """In closed form if the span holds a period: the peaks of the rate are narrow."""
        scales = accuracy.grid_scales(self)
        if self.span >= self.exact_motion.period():
            largest, speed = float(self.exact_motion.largest()), float(self.exact_motion.top_speed())
            return {"dimensionless": largest, "rate": speed or 1.0}
        return scales


class RubberTubeThick(WellCase):
    """No scene: rigid bodies do not express a wall that deforms."""

    name = "rubber_tube_thick"
    title = "Knowles thick-walled incompressible Mooney-Rivlin tube, radial oscillation: quadrature"
    section = "6.13.2"
    conventions = (
        "x = a/A is the stretch of the inner radius, gam = B^2/A^2 - 1, w^2 = mu/(rho A^2); the energy M v^2/2 + V is "
        "constant. A particle at radius R in the unstressed wall moves to sqrt(R^2 + a^2 - A^2). An inner pressure "
        "applied suddenly adds -p (x^2 - 1)/2 to V."
    )
    x = Coordinate("1", 2, positive(0.8, 1.3))
    v = Coordinate("1/s", 0, typical(-0.2, 0.2))
    gam = Parameter("1", 3, "B^2/A^2 - 1 of the unstressed radii, inner A and outer B", positive(0.5, 2))
    w = Parameter("rad/s", 2, "rate: w^2 = mu/(rho A^2)", positive(0.5, 5))
    p = Parameter("1/s^2", 0, "twice the inner pressure over rho A^2", typical(-0.1, 0.1))
    rules = (Rule("the wall withstands the pressure: p < w^2 ln(1 + gam)", _holds),)
    exact_motion = bind(ThickTube)
    quantity_names = ("balance",)
    variants = (
        Variant(
            "thin_wall", "gam = 1e-6: differences of logarithms that nearly cancel; the thin tube", {"gam": "1e-6"}
        ),
        Variant(
            "thick_wall", "gam = 1e3: the inertia depends on x like the inertia of a large body of fluid", {"gam": 1000}
        ),
        Variant("squeezed", "released at x = 0.2: a sharp turn where the tube is narrow", initial_state=("0.2", 0)),
        Variant("small", "amplitude 1e-6 about x = 1", initial_state=("1.000001", 0)),
        Variant("pressure", "pressure applied suddenly to the tube at rest", {"p": 2}, (1, 0)),
        Variant(
            "near_burst",
            "1 % below the pressure that the wall cannot withstand: stretches 15-fold and back",
            {"p": "5.49"},
            (1, 0),
        ),
    )
    invariants = conserved(energy=thick_energy)
    forms = (FirstOrder(thick_equations),)
    reversal = ("v",)

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        """A thin wall, without pressure."""
        if self.p:
            return ()
        return (self.level(RubberTubeThin, "a wall without thickness: isochronous"),)
