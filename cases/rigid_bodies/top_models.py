"""Simpler models of the heavy top: the levels below `lagrange_top` in its hierarchy.

Cases: lagrange_top_fast, lagrange_top_small_nutation.
"""

from gnomon.cases.declare import *
from gnomon.reference.rigid_bodies.top_models import FastTop, SmallNutation


def fast_top(t: Any, state: Values, parameters: Values) -> Values:
    axial, weight, a = parameters
    slow = weight / a
    return 0 * t, 0 * t, slow, a / axial - slow * cos(state[0])


def nutating_top(t: Any, state: Values, parameters: Values) -> Values:
    """theta'', phi' and psi' of the top to first order in theta - tilt."""
    theta, omega, _phi, _psi = state
    moment, axial, weight, a, b, tilt = parameters
    s, u, off = sin(tilt), cos(tilt), theta - tilt
    turn = (b - a * u) / (moment * s * s)
    slope = (a - 2 * moment * turn * u) / (moment * s)
    torque = turn * (moment * turn * u - a) + weight
    steeper = torque * u + slope * (2 * moment * turn * u - a) * s - moment * turn * turn * s * s
    return (
        omega,
        (torque * s + steeper * off) / moment,
        turn + slope * off,
        a / axial - turn * u + (turn * s - slope * u) * off,
    )


class LagrangeTopFast(Case):
    """A kinematic model without forces: it has no scene."""

    name = "lagrange_top_fast"
    title = "Fast top: steady slow precession at W/a"
    section = "11.12.4"
    conventions = "As lagrange_top; theta is constant, phi' = W/a, psi' = a/I3 - (W/a) cos(theta)."
    theta = Coordinate("rad", "0.6", Range(0.0, pi, typical=(0.1, 3.0)), group="tilt")
    omega_theta = Coordinate("rad/s", 0, Range(0.0, 0.0, typical=(0.0, 0.0)))
    phi = Coordinate("rad", 0, group="precession")
    psi = Coordinate("rad", 0, group="spin")
    I3 = Parameter("kg m^2", "0.01", "axial moment", positive(0.5, 2))
    W = Parameter("N m", "0.5", "weight times distance of the centre of mass from the point", positive(0.2, 4))
    a = Parameter("kg m^2/s", "0.6", "p_psi, momentum of the spin, I3 w3", typical(0.5, 4))
    rules = (Rule("the top spins (a is not 0)", lambda n: n["a"] != 0),)
    exact_motion = bind(FastTop, start="theta omega_theta phi psi")
    default_span = Span(65.3, "time scale")
    forms = (FirstOrder(fast_top),)

    @property
    def time_scale(self) -> float:
        """The time of a radian of the spin."""
        return float(self.I3) / abs(float(self.a))


class LagrangeTopSmallNutation(Case):
    """Linearised equations, which no bodies and forces obey exactly: no scene."""

    name = "lagrange_top_small_nutation"
    title = "Top with small nutation about a tilt"
    section = "11.12.4"
    conventions = "The equations of lagrange_top to first order in theta - tilt."
    theta = Coordinate("rad", "0.6", typical(0.4, 2.1), group="tilt")
    omega_theta = Coordinate("rad/s", 0, typical(-0.5, 0.5))
    phi = Coordinate("rad", 0, group="precession")
    psi = Coordinate("rad", 0, group="spin")
    I1 = Parameter("kg m^2", "0.02", "transverse moment about the point", positive(0.5, 2))
    I3 = Parameter("kg m^2", "0.01", "axial moment", positive(0.5, 2))
    W = Parameter("N m", "0.5", "weight times distance of the centre of mass from the point", positive(0.2, 4))
    a = Parameter("kg m^2/s", "0.6", "p_psi, momentum of the spin, I3 w3", typical(2, 4))
    b = Parameter("kg m^2/s", "0.52", "p_phi, momentum about the vertical", typical(1, 2))
    tilt = Parameter(
        "rad",
        "0.6",
        "the angle about which the equations are linear",
        Range(0.0, pi, low_open=True, typical=(0.5, 2.0)),
    )
    exact_motion = bind(SmallNutation, start="theta omega_theta phi psi")
    default_span = Span(10.37, "nutation")
    quantity_names = ("nutation_rate",)
    variants = (
        Variant("fast", "a^2/(I1 W) = 1e6: a fast small nutation on the precession", {"a": 100, "b": 82}),
        Variant("long_1e4", "10,000 nutations: phase errors", periods=10000.37),
    )
    forms = (FirstOrder(nutating_top),)

    @property
    def time_scale(self) -> float:
        """The shortest time of nutation, spin and weight."""
        moment, axial, weight, a = (float(self.parameters[name]) for name in ("I1", "I3", "W", "a"))
        return 1 / max(abs(a) / moment, abs(a) / axial, sqrt(weight / moment))

    def natural_span(self) -> Number:
        """10.37 nutations; ten time scales if the tilt is unstable."""
        rate = self.exact_motion.nutation_rate()
        return 10 * self.time_scale if rate is None else self.periods * 2 * pi / float(rate)
