"""The heavy symmetric top: in Euler angles, rising to the vertical, and as a rigid body.

Cases: lagrange_top, lagrange_top_sleeping_separatrix, lagrange_top_attitude.
"""

import math

from gnomon.cases.declare import *
from gnomon.cases.rigid_bodies.top_models import LagrangeTopFast, LagrangeTopSmallNutation
from gnomon.cases.scenes.top import ANGLES_SCENE, BODY_SCENE, RISING_SCENE
from gnomon.reference.numerics.precision import publish, working
from gnomon.reference.rigid_bodies.lagrange_top import LagrangeTop
from gnomon.reference.rigid_bodies.lagrange_top_attitude import TopAttitude


def top_equations(t: Any, state: Values, parameters: Values) -> Values:
    theta, omega, _phi, _psi = state
    moment, axial, weight, a, b = parameters
    s, u = sin(theta), cos(theta)
    precession = (b - a * u) / (moment * s * s)
    return (
        omega,
        (precession * (moment * precession * u - a) + weight) * s / moment,
        precession,
        a / axial - precession * u,
    )


def top_energy(t: Any, state: Values, parameters: Values) -> Values:
    """E = H - a^2/(2 I3)."""
    theta, omega, _phi, _psi = state
    moment, _axial, weight, a, b = parameters
    across = (b - a * cos(theta)) / sin(theta)
    return (moment * omega * omega / 2 + across * across / (2 * moment) + weight * cos(theta),)


def rising_equations(t: Any, state: Values, parameters: Values) -> Values:
    """The equations for b = a, which are regular at the vertical."""
    theta, omega, _phi, _psi = state
    moment, axial, weight, a = parameters
    u = cos(theta)
    precession = a / (moment * (1 + u))
    return (
        omega,
        (precession * (moment * precession * u - a) + weight) * sin(theta) / moment,
        precession,
        a / axial - precession * u,
    )


def rising_energy(t: Any, state: Values, parameters: Values) -> Values:
    """E - W, zero on the homoclinic motion."""
    theta, omega, _phi, _psi = state
    moment, _axial, weight, a = parameters
    half, low = sin(theta / 2), cos(theta / 2)
    across = a * half / low
    return (moment * omega * omega / 2 + across * across / (2 * moment) - 2 * weight * half * half,)


def symmetric_moments(parameters: Values) -> Values:
    moment, axial, _weight = parameters
    return moment, moment, axial


def weight_torque(t: Any, state: Values, parameters: Values) -> Values:
    """The torque of the weight at a point of the third axis; the third row of R is the vertical in body components."""
    _moment, _axial, weight = parameters
    return weight * state[10], -weight * state[9], 0


def body_energy(t: Any, state: Values, parameters: Values) -> Values:
    w1, w2, w3 = state[:3]
    moment, axial, weight = parameters
    return (moment * (w1 * w1 + w2 * w2) / 2 + axial * w3 * w3 / 2 + weight * state[11],)


def body_spin(t: Any, state: Values, parameters: Values) -> Values:
    """a = I3 w3."""
    _moment, axial, _weight = parameters
    return (axial * state[2],)


def body_vertical_momentum(t: Any, state: Values, parameters: Values) -> Values:
    """b, the angular momentum about the vertical."""
    moment, axial, _weight = parameters
    return (moment * (state[0] * state[9] + state[1] * state[10]) + axial * state[2] * state[11],)


class _Angles(Case):
    """Base class of the cases in Euler angles."""

    default_span = Span(10.37, lambda motion: motion.nutation_period(20))

    exact_motion = bind(lambda c: LagrangeTop(c.I1, c.I3, c.W, c.a, c.numbers.get("b", c.a), *c.initial_state))
    quantity_names = ("energy", "nutation_period", "precession_per_nutation", "lowest_cosine highest_cosine=heights")

    @property
    def time_scale(self) -> float:
        """The shortest time of nutation, spin, weight and precession, which is fast close to the vertical."""
        moment, axial, weight, a = (float(self.parameters[name]) for name in ("I1", "I3", "W", "a"))
        b = float(self.parameters.get("b", self.parameters["a"]))
        rates = [abs(a) / moment, abs(a) / axial, math.sqrt(weight / moment), abs(float(self.initial_state[1]))]
        heights = self.exact_motion.heights(30)
        for u in heights or ():
            rates += [abs(b + a) / (2 * moment * float(1 + u)) if b != -a else 0.0]
            rates += [abs(b - a) / (2 * moment * float(1 - u)) if b != a else 0.0]
        return 1 / max(rates)

    def derived(self, digits: int) -> dict[str, Any]:
        """Rates of regular precession at the initial tilt (rad/s), and the least a of a sleeping top (kg m^2/s)."""
        with working(digits + 20) as mp:
            moment, weight, a = (mp.mpf(self.parameters[name]) for name in ("I1", "W", "a"))
            across = 2 * moment * mp.cos(mp.mpf(self.initial_state[0]))
            square = a * a - 2 * across * weight
            quantities = {"sleeping_spin": 2 * mp.sqrt(moment * weight)}
            if square >= 0 and a:
                larger = a + mp.sign(a) * mp.sqrt(square)
                quantities |= {"slow_precession": 2 * weight / larger, "fast_precession": larger / across}
            return dict(zip(quantities, publish(quantities.values(), digits), strict=True))


class LagrangeTopCase(_Angles):
    name = "lagrange_top"
    title = "Heavy symmetric (Lagrange) top in Euler angles"
    section = "11.12.4"
    conventions = (
        "3-1-3 Euler angles, R = Rz(phi) Rx(theta) Rz(psi) body -> space, theta from the upward vertical, phi and psi "
        "continuous; W = m g l, a = p_psi = I3 w3, b = p_phi; b is neither a nor -a, else theta would pass a pole."
    )
    theta = Coordinate("rad", "0.6", Range(0.0, math.pi, low_open=True, typical=(0.1, 3.0)), group="tilt")
    omega_theta = Coordinate("rad/s", 0, typical(-2, 2))
    phi = Coordinate("rad", 0, group="precession")
    psi = Coordinate("rad", 0, group="spin")
    I1 = Parameter("kg m^2", "0.02", "transverse moment about the point", positive(0.5, 2))
    I3 = Parameter("kg m^2", "0.01", "axial moment", positive(0.5, 2))
    W = Parameter("N m", "0.5", "weight times distance of the centre of mass from the point", positive(0.2, 4))
    a = Parameter("kg m^2/s", "0.6", "p_psi, momentum of the spin, I3 w3", typical(-4, 4))
    b = Parameter("kg m^2/s", "0.52", "p_phi, momentum about the vertical", typical(-4, 4))
    rules = (
        Rule(
            "b differs from a and -a (b = a is lagrange_top_sleeping_separatrix)",
            lambda n: abs(n["a"]) != abs(n["b"]),
        ),
    )
    variants = (
        Variant("looping", "precession reverses in every nutation", {"b": "0.47"}),
        Variant(
            "near_cuspidal",
            "b = a cos(theta) up to 1e-16: the precession stops at every turning point",
            {"b": 0.495201368945807},
        ),
        Variant(
            "regular",
            "regular precession up to 1e-8: two roots nearly coincide",
            {"b": "0.5006428"},
        ),
        Variant(
            "near_vertical",
            "b - a = 1e-6 a: passes 2e-6 rad from the vertical, where phi and psi change fast by half a turn",
            {"a": "0.1", "b": "0.1000001"},
            ("1.2", "5", 0, 0),
            periods=5.37,
        ),
        Variant(
            "fast",
            "a^2/(I1 W) = 1e6: nutation a million times faster than the precession",
            {"a": 100, "b": 82},
            periods=40.37,
        ),
        Variant("slow", "too slow to stay up: nutates almost to the lowest point", {"a": "0.05", "b": "0.03"}),
        Variant("precessions_1e4", "1e4 precessions: phase error"),
        Variant("weightless_almost", "W = 1e-6: nearly torque-free", {"W": "1e-6"}),
    )
    invariants = conserved(energy=top_energy)
    forms = (FirstOrder(top_equations),)
    scene = ANGLES_SCENE
    reversal = ("omega_theta", "a", "b")

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        """The fast top in steady precession, then first-order nutation about the tilt of regular precession."""
        n: dict[str, Any] = dict(self.parameters)
        theta, omega, phi, psi = self.initial_state
        effect = "small nutation about regular precession"
        nutating = self.level(LagrangeTopSmallNutation, effect, tilt=self._steady_tilt())
        if not n["a"] or omega:
            return (nutating,)
        steady = LagrangeTopFast(
            initial_state=(theta, 0, phi, psi), span=self.span, **{name: n[name] for name in ("I3", "W", "a")}
        )
        return (Level(steady, same, "steady precession at W/a, no nutation"), nutating)

    def _steady_tilt(self) -> float:
        """The tilt between the turning points at which theta'' = 0, by bisection in binary64 (rad)."""
        heights = self.exact_motion.heights()
        if heights is None:
            return float(self.theta)
        numbers = tuple(map(float, self.parameter_values()))
        high, low = (math.acos(float(u)) for u in heights)
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (middle, high) if top_equations(0, (middle, 0, 0, 0), numbers)[1] > 0 else (low, middle)
        return low

    def natural_span(self) -> Number:
        if self.variant == "precessions_1e4":
            motion = self.exact_motion
            nutations = 10000 * 2 * math.pi / abs(float(motion.precession_per_nutation()))  # type: ignore[arg-type]
            return float(motion.nutation_period(20)) * (math.floor(nutations) + 0.37)  # type: ignore[arg-type]
        return super().natural_span()


class LagrangeTopSleepingSeparatrix(_Angles):
    name = "lagrange_top_sleeping_separatrix"
    title = "Top rising to the vertical: close to the homoclinic motion of the weak sleeping top"
    section = "11.12.4"
    conventions = (
        "As lagrange_top, with b = a: theta passes the vertical and changes its sign there. Exactly homoclinic starts, "
        "theta = acos(a^2/(2 I1 W) - 1) at rest, are not binary64 numbers: the default is the double below, a "
        "variant the double above."
    )
    theta = Coordinate("rad", 2.418858405776377, Range(-math.pi, math.pi, typical=(-2.8, 2.8)), group="tilt")
    omega_theta = Coordinate("rad/s", 0, typical(-2, 2))
    phi = Coordinate("rad", 0, group="precession")
    psi = Coordinate("rad", 0, group="spin")
    I1 = Parameter("kg m^2", "0.25", "transverse moment about the point", positive(0.5, 2))
    I3 = Parameter("kg m^2", "0.125", "axial moment", positive(0.5, 2))
    W = Parameter("N m", "0.5", "weight times distance of the centre of mass from the point", positive(0.2, 4))
    a = Parameter("kg m^2/s", "0.25", "p_psi = p_phi", typical(-4, 4))
    rules = (Rule("a is not 0 (a top without spin would pass the lowest point too)", lambda n: n["a"] != 0),)
    default_span = Span(0.45, lambda motion: motion.nutation_period(20))
    variants = (
        Variant(
            "above",
            "the double above the homoclinic start: stays at the vertical for a short time and falls to the other side",
            initial_state=(2.418858405776378, 0, 0, 0),
            periods=0.2,
        ),
        Variant(
            "from_vertical",
            "1e-12 rad/s at the vertical: 18 s of exponential growth, to 9e-3 rad",
            initial_state=(0, "1e-12", 0, 0),
            periods=0.2,
        ),
        Variant(
            "strong",
            "a^2 > 4 I1 W: the sleeping top is stable, and swings through the vertical",
            {"a": 2},
            ("0.01", 0, 0, 0),
            periods=10.37,
        ),
        Variant(
            "marginal",
            "exactly a^2 = 4 I1 W, numbers exact in binary",
            {"I1": "0.5", "a": 1},
            ("0.01", 0, 0, 0),
            periods=10.37,
        ),
        Variant("through", "passes the vertical at full speed", initial_state=(1, 5, 0, 0), periods=10.37),
    )
    invariants = conserved(energy=rising_energy)
    forms = (FirstOrder(rising_equations),)
    scene = RISING_SCENE
    reversal = ("omega_theta", "a")


def tilted(tilt: float, nutation: float, precession: float, spin: float) -> tuple[float, ...]:
    """The state at phi = psi = 0 from theta and the rates of theta, phi and psi, rounded to binary64."""
    s, c = math.sin(tilt), math.cos(tilt)
    return (nutation, precession * s, spin + precession * c, 1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c)


AXIS = "direction of the axis"


class LagrangeTopAttitude(Case):
    name = "lagrange_top_attitude"
    title = "Heavy symmetric (Lagrange) top as a rigid body"
    section = "11.12.4"
    conventions = (
        "w are body components, the third along the symmetry axis; R, row by row, maps body components to space, z up, "
        "R' = R hat(w). R(0) need not be orthogonal. W = m g l. The initial state has phi = psi = 0: from th0, thd0, "
        "phd0, psd0 it is w = (thd0, phd0 sin th0, psd0 + phd0 cos th0), R = Rx(th0), rounded."
    )
    w1 = Coordinate("rad/s", 0, typical(-2, 2))
    w2 = Coordinate("rad/s", 0, typical(-2, 2))
    w3 = Coordinate("rad/s", 0, typical(-2, 2))
    attitude = Attitude(axis=AXIS)
    default_state = tilted(0.6, 0.0, 2.0, 60.0)
    I1 = Parameter("kg m^2", "0.02", "transverse moment about the point", positive(0.5, 2))
    I3 = Parameter("kg m^2", "0.01", "axial moment", positive(0.5, 1))
    W = Parameter("N m", "0.5", "weight times distance of the centre of mass from the point", positive(0.2, 4))
    exact_motion = bind(TopAttitude, rates="w1 w2 w3")
    default_span = Span(10.37, lambda motion: motion.nutation_period(20), otherwise=20)
    quantity_names = ("nutation_period", "precession_per_nutation")
    variants = (
        Variant("cuspidal", "released without precession: exactly cuspidal", initial_state=tilted(0.6, 0.0, 0.0, 60.0)),
        Variant("looping", "precession reverses in every nutation", initial_state=tilted(0.6, 0.0, -2.0, 60.0)),
        Variant(
            "near_vertical",
            "passes 1e-6 rad from the vertical, where Euler angles would change fast",
            initial_state=tilted(1e-6, 3.0, 0.0, 10.0),
        ),
        Variant(
            "through_vertical", "starts exactly upright and moves: b = a", initial_state=tilted(0.0, 3.0, 0.0, 10.0)
        ),
        Variant(
            "sleeping",
            "upright, stable by its spin: only the spin moves",
            initial_state=tilted(0.0, 0.0, 0.0, 60.0),
        ),
        Variant(
            "weak_sleeping",
            "upright, too slow: must stay upright though unstable",
            initial_state=tilted(0.0, 0.0, 0.0, 10.0),
        ),
        Variant(
            "homoclinic",
            "exactly homoclinic, numbers exact in binary (R(0) is 5/4 of a rotation): rises to the vertical without end",
            {"I1": "0.0625", "I3": "0.03125", "W": "1.5625"},
            (3, 4, 16, "1.25", 0, 0, 0, "0.75", -1, 0, 1, "0.75"),
        ),
        Variant(
            "without_spin", "a = 0: a spherical pendulum", initial_state=tilted(2.0, 1.0, 3.0, -3.0 * math.cos(2.0))
        ),
        Variant(
            "plane",
            "no momentum about the axis or the vertical: a plane pendulum, over the top",
            initial_state=tilted(2.0, 12.0, 0.0, 0.0),
        ),
        Variant("fast", "a^2/(I1 W) = 1e6", initial_state=tilted(0.6, 0.0, 0.0, 10000.0)),
        Variant("precessions_1e4", "1e4 precessions: drift by round-off", span=76000),
        Variant(
            "engines",
            "the heavy top of the engine tables: tilt 30 degrees, 40 rad/s, no precession at the start",
            {"I1": "0.19", "I3": "0.05", "W": "2.943"},
            tilted(math.pi / 6, 0.0, 0.0, 40.0),
            2,
            scored=(AXIS,),
        ),
        Variant(
            "speed",
            "the heavy top of the timing tables: direction of the axis only",
            {"I1": 1, "I3": "0.5", "W": 1},
            tilted(0.6, 0.0, 0.0, 5.0),
            200,
            scored=(AXIS,),
        ),
    )
    invariants = conserved(energy=body_energy, spin=body_spin, vertical_momentum=body_vertical_momentum)
    forms = (RigidBody(symmetric_moments, weight_torque),)
    reversal = ("w1", "w2", "w3")

    @property
    def time_scale(self) -> float:
        """The shortest time of a radian at the initial rates, of a radian of the nutation, and of a fall."""
        moment, axial, weight = map(float, self.parameter_values())
        w1, w2, w3 = map(float, self.initial_state[:3])
        length = math.hypot(*map(float, self.initial_state[9:]))
        return 1 / max(math.hypot(w1, w2, w3), abs(axial * w3) / moment, math.sqrt(weight * length / moment), 1e-3)

    @property
    def scene(self) -> SceneForm | None:
        """None if R(0) is not a rotation: engines have no other attitude."""
        rows = [self.initial_state[k : k + 3] for k in (3, 6, 9)]
        lengths = [float(sum(x * x for x in row)) for row in rows]
        return BODY_SCENE if max(abs(length - 1) for length in lengths) < 1e-9 else None
