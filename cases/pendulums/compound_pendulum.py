"""Bodies that swing like a simple pendulum of another length: about a fixed axis, or rolling in a bowl.

Cases: rotation_fixed_axis_compound_pendulum, rolling_sphere_in_bowl.
"""

from gnomon.cases.core.scene import IDENTITY, joint
from gnomon.cases.declare import *
from gnomon.cases.pendulums.pendulum_simple import PendulumSimple
from gnomon.reference.pendulums.pendulum_simple import Pendulum


def swing(theta: Any, square: Any) -> Values:
    return (-square * sin(theta),)


def swing_potential(theta: Any, square: Any) -> Values:
    half = sin(theta / 2)
    return (2 * square * half * half,)


def body_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    inertia, m, g, arm = parameters
    return swing(q[0], m * g * arm / inertia)


def body_potential(t: Any, q: Values, parameters: Values) -> Values:
    inertia, m, g, arm = parameters
    return swing_potential(q[0], m * g * arm / inertia)


def body_energy_over_inertia(t: Any, state: Values, parameters: Values) -> Values:
    return (state[1] * state[1] / 2 + body_potential(t, state[:1], parameters)[0],)


def bowl_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    g, bowl, radius = parameters
    return swing(q[0], 5 * g / (7 * (bowl - radius)))


def bowl_potential(t: Any, q: Values, parameters: Values) -> Values:
    g, bowl, radius = parameters
    return swing_potential(q[0], 5 * g / (7 * (bowl - radius)))


def bowl_energy(t: Any, state: Values, parameters: Values) -> Values:
    return (state[1] * state[1] / 2 + bowl_potential(t, state[:1], parameters)[0],)


def compound_scene(state: Values, parameters: Values) -> Scene:
    """Engines take the moment about the centre of mass, I - m l^2 by Steiner's theorem."""
    theta, omega = state
    inertia, m, g, arm = parameters
    own = max(inertia - m * arm * arm, 0.0)
    body = Body("body", m, (own, own, own))
    hinge = Hinge("pivot", "body", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -arm), theta, omega)
    return Scene((0.0, 0.0, -g), (body,), hinges=(hinge,))


def bowl_scene(state: Values, parameters: Values) -> Scene:
    """The sphere's centre moves on a circle; a separate token states that the sphere rolls."""
    theta, omega = state
    g, bowl, radius = parameters
    way, moment = bowl - radius, 2 * radius * radius / 5

    def circle(angle: float) -> Vector:
        return way * sin(angle), 0.0, -way * cos(angle)

    sphere = Body("sphere", 1.0, (moment, moment, moment), circle(theta), IDENTITY, radius=radius)
    return Scene((0.0, 0.0, -g), (sphere,), guides=(Guide("bowl", "sphere", circle, theta, omega),))


COMPOUND_SCENE = SceneForm(compound_scene, joint("pivot"), frozenset({"hinge"}))
BOWL_SCENE = SceneForm(
    bowl_scene, joint("bowl"), frozenset({"curved_guide", "rolling_without_slip"}), conservative=False
)


class _Swinging(Case):
    """A pendulum whose subclass states the square of the frequency of small swings."""

    default_span = Span(10.37, lambda motion: motion.period(20), otherwise=9)

    def square(self) -> Fraction:
        raise NotImplementedError

    exact_motion = bind(lambda c: Pendulum(c.square(), Fraction(1), *c.initial_state))

    @property
    def time_scale(self) -> float:
        """The time scale of a small swing; in fast rotation the time of a radian."""
        return min(1 / sqrt(float(self.square())), float(self.exact_motion.period()) / tau)

    @property
    def quantity_names(self) -> tuple[str, ...]:
        period = {Pendulum.ROTATION: ("turn_time=period",), Pendulum.LIBRATION: ("period",)}
        return ("small_swing_period", "amplitude", "top_speed", *period.get(self.exact_motion.regime, ()))


class CompoundPendulum(_Swinging):
    name = "rotation_fixed_axis_compound_pendulum"
    title = "Rotation about a fixed axis: the compound pendulum"
    section = "10.11.1, 10.4"
    conventions = (
        "theta from the downward vertical, rad, not wrapped; I about the axis, l from it to the centre of mass."
    )
    theta = Coordinate("rad", 2, typical(-7, 7))
    omega = Coordinate("rad/s", 0, typical(-8, 8))
    I = Parameter("kg m^2", "0.35", "moment of inertia about the axis", positive(1, 10))
    m = Parameter("kg", 1, "mass", positive(0.5, 2))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    l = Parameter("m", "0.5", "from the axis to the centre of mass", positive(0.1, 0.7))
    rules = (Rule("I >= m l^2 (the body's own moment is not negative)", lambda n: n["I"] >= n["m"] * n["l"] ** 2),)
    variants = (
        Variant("rotation", "turns over the top", initial_state=("0.5", 12)),
        Variant("point", "I = m l^2: all mass in one point, the simple pendulum", {"I": "0.25"}),
        Variant("near_axis", "l = 1e-6: the axis almost at the centre of mass, a slow swing", {"l": "1e-6"}),
        Variant(
            "separatrix",
            "exactly the energy at the top, numbers exact in binary",
            {"I": "0.5", "m": 1, "g": 8, "l": "0.25"},
            (0, 4),
        ),
        Variant(
            "upright", "released at rest 1e-12 rad from the top", initial_state=("3.141592653588793", 0), periods=0.45
        ),
        Variant("long_1e4", "10,000 periods: phase error", periods=10000.37),
    )
    invariants = conserved(energy=body_energy_over_inertia)
    forms = (Separable(body_acceleration, body_potential),)
    scene = COMPOUND_SCENE

    def square(self) -> Fraction:
        inertia, m, g, arm = self.parameter_values()
        return m * g * arm / inertia

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        """The simple pendulum of length l: all mass at the centre of mass."""
        _inertia, _m, g, arm = self.parameter_values()
        return (self.level(PendulumSimple, "all mass at the centre of mass", g=g, L=arm),)

    def derived(self, digits: int) -> dict[str, Any]:
        """`center_of_percussion`: its distance from the axis, I/(m l) (m). Reactions of the axis at the start (N)."""
        weight, arm = self.m * self.g, self.m * self.l
        rest = weight * (1 - arm * self.l / self.I)
        return {
            "center_of_percussion": self.I / arm,
            "reaction_along": lambda mp: mp.mpf(weight) * mp.cos(mp.mpf(self.theta)) + mp.mpf(arm * self.omega**2),
            "reaction_across": lambda mp: mp.mpf(rest) * mp.sin(mp.mpf(self.theta)),
        }


class RollingSphereInBowl(_Swinging):
    name = "rolling_sphere_in_bowl"
    title = "Sphere rolling in a spherical bowl"
    section = "10.12, 10.19"
    conventions = (
        "[inferred] A solid sphere rolls without slip in a vertical plane of the bowl; theta is the angle of the line "
        "of centres from the downward vertical; contact is assumed to last."
    )
    theta = Coordinate("rad", "1.2", typical(-1.5, 1.5))
    omega = Coordinate("rad/s", 0, typical(-2, 2))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    R = Parameter("m", 1, "radius of the bowl", positive(1, 10))
    r = Parameter("m", "0.1", "radius of the sphere", positive(0.1, 0.9))
    rules = (Rule("the sphere fits into the bowl, r < R", lambda n: n["r"] < n["R"]),)
    variants = (
        Variant("small", "amplitude 1e-6", initial_state=("1e-6", 0)),
        Variant("tight", "r = 0.999999 R: a very fast small swing", {"r": "0.999999"}),
        Variant("long_1e4", "10,000 periods: phase error", periods=10000.37),
    )
    invariants = conserved(energy=bowl_energy)
    forms = (Separable(bowl_acceleration, bowl_potential),)
    scene = BOWL_SCENE

    def square(self) -> Fraction:
        g, bowl, radius = self.parameter_values()
        return 5 * g / (7 * (bowl - radius))
