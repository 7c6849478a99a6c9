"""A block dropped on a spring."""

from gnomon.cases.declare import *
from gnomon.cases.scenes.point import railed
from gnomon.reference.oscillators.work_energy_spring_block import SpringBlock
from mpmath import fneg, mpf


def free_block(t: Any, state: Values, parameters: Values) -> Values:
    _, v = state
    return v, -parameters[0]


def block_on_spring(t: Any, state: Values, parameters: Values) -> Values:
    """y'' = -g - (k/m) y."""
    y, v = state
    g, m, k = parameters
    return v, -g - k / m * y


def spring_end(t: Any, state: Values, parameters: Values) -> Values:
    return (state[0],)


def unchanged(t: Any, state: Values, parameters: Values) -> Values:
    y, v = state
    return y, v


def spring_block_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy, zero at the free end of the spring; the spring only pushes, its compression is -(y - sqrt(y^2))/2."""
    y, v = state
    g, m, k = parameters
    squeezed = (y - sqrt(y * y)) / 2
    return ((m * v * v + k * squeezed * squeezed) / 2 + m * g * y,)


def spring_block_mode(t: Any, state: Values, parameters: Values) -> str:
    y, v = state
    return "spring" if y < 0 or (y == 0 and v <= 0) else "flight"


def weight_and_spring(t: float, y: float, parameters: tuple[float, ...]) -> float:
    """The force over the mass, in both modes."""
    return -parameters[0] - parameters[2] / parameters[1] * min(y, 0.0)


SCENE = railed(weight_and_spring)


class WorkEnergySpringBlock(Case):
    """A block that drops on a vertical spring, is thrown up and drops again."""

    name = "work_energy_spring_block"
    title = "Block dropped on a spring"
    section = "7.5, 7.7.2, 7.9"
    conventions = "y upward from the free end of a massless spring, to which the block does not stick; no losses."
    y = Coordinate("m", "0.5", typical(0, 2))
    v = Coordinate("m/s", 0, typical(-2, 2))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(1, 10))
    m = Parameter("kg", 1, "mass of the block", positive(0.5, 3))
    k = Parameter("N/m", 500, "stiffness of the spring", positive(10, 1000))
    exact_motion = bind(SpringBlock)
    default_span = Span(5.37, lambda motion: motion.period())
    variants = (
        Variant("stiff", "k = 1e9 N/m: a contact of 1e-4 s between flights of 0.6 s", {"k": 10**9}),
        Variant(
            "soft", "released at the end of the spring: returns to it at rest and never leaves", initial_state=(0, 0)
        ),
        Variant("on_spring", "starts on the compressed spring, which throws it up", initial_state=("-0.2", 0)),
        Variant("long_1e3", "2,000 events: errors of event times add up", periods=1000.37),
    )
    invariants = conserved(energy=spring_block_energy)
    scene = SCENE
    forms = (
        Hybrid(
            modes=(Mode("flight", free_block), Mode("spring", block_on_spring)),
            start=spring_block_mode,
            transitions=(
                Transition("touch", "flight", spring_end, -1, unchanged, "spring"),
                Transition("lift", "spring", spring_end, 1, unchanged, "flight"),
            ),
        ),
    )

    @property
    def time_scale(self) -> float:
        """sqrt(m/k)."""
        return 1 / sqrt(float(self.exact_motion.square))

    def list_events(self, digits: int) -> tuple[Event, ...]:
        """`touch` and `lift` alternate."""
        motion, events, n = self.exact_motion, list[Event](), 1
        if not motion.leaves:
            return ()
        self.limit_events(2 * float(self.span) / float(motion.period()))
        u = motion.speed(digits)
        down, up = (mpf(0), fneg(u, exact=True)), (mpf(0), u)
        while True:
            times = [("touch", motion.touch_time(n, digits), down), ("lift", motion.lift_time(n, digits), up)]
            times.sort(key=lambda item: item[1])
            for name, time, state in times:
                if Fraction(float(time)) > self.span:
                    return tuple(events)
                if time > 0:
                    events.append(Event(time, name, state, state))
            n += 1

    def same_course(self, other: Case) -> bool:
        return isinstance(other, WorkEnergySpringBlock) and other.exact_motion.leaves == self.exact_motion.leaves

    @property
    def quantity_names(self) -> tuple[str, ...]:
        names = ("period", "largest_compression=compression")
        return (*names, "contact_time") if self.exact_motion.leaves else names
