"""The firing pin of a torpedo that hits its target."""

from gnomon.cases.contact.coulomb_friction_oscillator import spring_speed, standing
from gnomon.cases.declare import *
from gnomon.cases.scenes.box import HALF_EXTENTS
from gnomon.reference.contact.torpedo_firing_pin import FiringPin
from gnomon.reference.numerics.precision import exact
from mpmath import mpf


def pin_motion(t: Any, state: Values, parameters: Values) -> Values:
    """v' = (k/m) (d0 - x) - mu a."""
    x, v = state
    m, k, d0, mu, a, _gap = parameters
    return v, (k / m) * (d0 - x) - mu * a


def pin_at_rest(t: Any, state: Values, parameters: Values) -> Values:
    return 0, 0


def way_to_the_primer(t: Any, state: Values, parameters: Values) -> Values:
    x, _v = state
    gap = parameters[5]
    return (x - gap,)


def in_the_primer(t: Any, state: Values, parameters: Values) -> Values:
    gap = parameters[5]
    return gap, 0


def pin_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy of pin and spring."""
    x, v = state
    m, k, d0, _mu, _a, _gap = parameters
    return ((m * v * v + k * (d0 - x) * (d0 - x)) / 2,)


def pin_mode(t: Any, state: Values, parameters: Values) -> str:
    """The pin is held if friction exceeds the spring's force, decided exactly."""
    x, v = map(exact, state)
    m, k, d0, mu, a, gap = map(exact, parameters[:6])
    if x >= gap:
        return "struck"
    return "moving" if v > 0 or k * (d0 - x) > mu * m * a else "stopped"


def pin_scene(state: Values, parameters: Values) -> Scene:
    """A flat box on the wall of its guide, in the frame of the torpedo.

    The deceleration presses it on the wall, the plane z = 0; the primer is the plane x = 0 in front of it.
    """
    x, v = state
    m, k, d0, mu, a, gap = parameters
    front, side, height = HALF_EXTENTS
    inertia = (
        m * (side * side + height * height) / 3,
        m * (front * front + height * height) / 3,
        m * (front * front + side * side) / 3,
    )

    def spring(t: float, position: Vector, velocity: Vector) -> Vector:
        return k * (d0 - (position[0] + front + gap)), 0.0, 0.0

    pin = Body("pin", m, inertia, (x - gap - front, 0.0, height), velocity=(v, 0.0, 0.0), half_extents=HALF_EXTENTS)
    # one coefficient for both planes: nothing slides along the primer
    wall, primer = (Contact("pin", normal, friction=mu) for normal in ((0.0, 0.0, 1.0), (-1.0, 0.0, 0.0)))
    return Scene((0.0, 0.0, -a), (pin,), contacts=(wall, primer), forces=(Force("pin", "position_force", spring),))


def pin_reading(readings: Readings, parameters: Values) -> Values:
    position, _, velocity, _ = readings.bodies["pin"]
    return position[0] + HALF_EXTENTS[0] + parameters[5], velocity[0]


NEEDS = frozenset({"coulomb_isotropic", "rigid_impact", "position_force"})
STRIKING, CAUGHT = (
    SceneForm(pin_scene, pin_reading, NEEDS | more, conservative=False) for more in (set[str](), {"latch"})
)
"""A pin that stops before the primer is held by a catch, which contacts do not express."""


class TorpedoFiringPin(Case):
    name = "torpedo_firing_pin"
    title = "Spring-driven firing pin with guide friction from the impact's deceleration"
    section = "5.12.2 (model inferred from the section's title)"
    conventions = (
        "[inferred] x along the guide from the cocked position; the guide's friction is mu m a, a the deceleration. "
        "The primer at x = gap stops the pin; a pin that stops before it is held by a catch and does not fire."
    )
    x = Coordinate("m", 0, nonnegative(0, 0.5))
    v = Coordinate("m/s", 0, nonnegative(0, 2))
    m = Parameter("kg", "0.05", "mass of the pin", positive())
    k = Parameter("N/m", 2000, "stiffness of the spring", positive())
    d0 = Parameter("m", "0.03", "compression of the cocked spring", nonnegative(0.5, 5))
    mu = Parameter("1", "0.2", "coefficient of friction", nonnegative(0, 1))
    a = Parameter("m/s^2", 2000, "deceleration of the torpedo", nonnegative(0, 5))
    gap = Parameter("m", "0.01", "distance to the primer", positive(0.5, 5))
    rules = (
        Rule("x <= gap (the pin is not beyond the primer)", lambda n: n["x"] <= n["gap"]),
        Rule("a pin at the primer has struck it (v = 0)", lambda n: n["x"] < n["gap"] or n["v"] == 0),
    )
    exact_motion = bind(FiringPin, mass="m", stiffness="k")
    variants = (
        Variant(
            "grazing",
            "gap = 2 xe exactly: arrives with speed zero",
            {"m": 1, "k": 4, "d0": 2, "mu": "0.5", "a": 8, "gap": 2},
        ),
        Variant("short", "stops just before the primer", {"gap": "0.04001"}),
        Variant("held", "friction exceeds the spring's force: the pin does not move", {"a": 6001}, span="0.05"),
        Variant("nearly_held", "friction leaves 1e-9 of the spring's force", {"a": "5999.999994", "gap": "1e-11"}),
        Variant("oblique", "an impact at 60 degrees to the torpedo's axis: half the friction", {"a": 1000}),
    )
    invariants = decaying(energy=pin_energy)
    forms = (
        Hybrid(
            modes=(Mode("moving", pin_motion), Mode("struck", pin_at_rest), Mode("stopped", pin_at_rest)),
            start=pin_mode,
            transitions=(
                Transition("strike", "moving", way_to_the_primer, 1, in_the_primer, "struck"),
                Transition("stop", "moving", spring_speed, -1, standing, "stopped"),
            ),
            terminal=frozenset({"struck", "stopped"}),
        ),
    )

    @property
    def scene(self) -> SceneForm:
        return CAUGHT if self.exact_motion.moves and not self.exact_motion.fires else STRIKING

    @property
    def time_scale(self) -> float:
        """sqrt(m/k)."""
        return sqrt(float(self.m / self.k))

    def natural_span(self) -> Number:
        """A third longer than the motion."""
        return 1.37 * float(self.exact_motion.end_time()) if self.exact_motion.moves else 3.7 * self.time_scale

    def list_events(self, digits: int) -> tuple[Event, ...]:
        """`strike`, or `stop` before the primer."""
        motion, zero = self.exact_motion, mpf(0)
        if not motion.moves or motion.end_time(20) > self.span:
            return ()
        place = motion.end_position(digits)
        speed = motion.strike_speed(digits) if motion.fires else zero
        name = "strike" if motion.fires else "stop"
        return (Event(motion.end_time(digits), name, (place, speed), (place, zero)),)

    def same_course(self, other: Case) -> bool:
        theirs = FiringPin(*other.parameter_values(), *other.initial_state)
        return (theirs.moves, theirs.fires) == (self.exact_motion.moves, self.exact_motion.fires)

    def scales(self) -> dict[str, float]:
        """In closed form."""
        motion = self.exact_motion
        length = float(motion.end_position()) if motion.moves else float(self.x)
        return {"length": length or 1.0, "velocity": float(motion.fastest()) or 1.0}

    def derived(self, digits: int) -> dict[str, Any]:
        """`fires`: 1 if the pin reaches the primer, else 0."""
        motion = self.exact_motion
        quantities = {
            "fires": int(motion.fires),
            "holding_deceleration": motion.holding_deceleration(digits) if self.mu > 0 else None,
        }
        if motion.moves and motion.fires:
            return quantities | {"strike_time": motion.end_time(digits), "strike_speed": motion.strike_speed(digits)}
        if motion.moves:
            return quantities | {"stop_time": motion.end_time(digits), "stop_position": motion.end_position(digits)}
        return quantities

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        """A smooth guide; for the oblique impact, which has half the deceleration, also the head-on one."""
        smooth = self.with_numbers(self.initial_state, self.parameters | {"mu": self.mu * 0})
        levels = (Level(smooth, same, "a smooth guide"),)
        if self.variant != "oblique":
            return levels
        head_on = self.with_numbers(self.initial_state, self.parameters | {"a": 2 * self.a})
        return (*levels, Level(head_on, same, "the friction of a head-on impact"))
