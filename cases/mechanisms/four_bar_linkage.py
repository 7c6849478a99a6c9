"""The four-bar linkage by the places of its two joints: three constraints, four coordinates, one freedom."""

from gnomon.cases.core.consistent import violation
from gnomon.cases.declare import *

STATE = ("xa", "ya", "xb", "yb", "vxa", "vya", "vxb", "vyb")


def three_rods_weight(t: Any, place: Values, parameters: Values) -> Values:
    """Each uniform rod has half of its weight at each end."""
    crank, coupler, rocker, _d, g = parameters
    return 0, -g * (crank + coupler) / 2, 0, -g * (coupler + rocker) / 2


def three_rods_masses(t: Any, place: Values, parameters: Values) -> Values:
    """A uniform rod whose ends have the velocities u, v has the kinetic energy m (u^2 + u v + v^2)/6."""
    crank, coupler, rocker, _d, _g = parameters
    left, shared, right = (crank + coupler) / 3, coupler / 6, (coupler + rocker) / 3
    return left, 0, shared, 0, 0, left, 0, shared, shared, 0, right, 0, 0, shared, 0, right


def three_rods(t: Any, place: Values, parameters: Values) -> Values:
    """The squares of the lengths of crank, coupler and rocker."""
    xa, ya, xb, yb = place
    d, x, y = parameters[3], xb - xa, yb - ya
    return xa * xa + ya * ya, x * x + y * y, (xb - d) * (xb - d) + yb * yb


def along_three_rods(t: Any, place: Values, parameters: Values) -> Values:
    xa, ya, xb, yb = place
    x, y = 2 * (xb - xa), 2 * (yb - ya)
    return 2 * xa, 2 * ya, 0, 0, -x, -y, x, y, 0, 0, 2 * (xb - parameters[3]), 2 * yb


def four_bar_equations(t: Any, state: Values, parameters: Values) -> Values:
    """Index 1: the angular accelerations p, q of crank and rocker keep the coupler's length by -turn_a p + turn_b q + left = 0.

    Their least solution, and a motion along the freedom p : q = turn_b : turn_a by the principle of d'Alembert.
    """
    xa, ya, xb, yb, vxa, vya, vxb, vyb = state
    crank, coupler, rocker, d, g = parameters
    x, y, xc, u, v = xb - xa, yb - ya, xb - d, vxb - vxa, vyb - vya
    inward_a = (vxa * vxa + vya * vya) / (xa * xa + ya * ya)
    inward_b = (vxb * vxb + vyb * vyb) / (xc * xc + yb * yb)
    axa, aya, axb, ayb = -inward_a * xa, -inward_a * ya, -inward_b * xc, -inward_b * yb
    turn_a, turn_b = y * xa - x * ya, y * xc - x * yb
    left = u * u + v * v + x * (axb - axa) + y * (ayb - aya)
    share = left / (turn_a * turn_a + turn_b * turn_b)
    by_a, by_b = share * turn_a, -share * turn_b
    axa, aya, axb, ayb = axa - by_a * ya, aya + by_a * xa, axb - by_b * yb, ayb + by_b * xc
    free_xa, free_ya, free_xb, free_yb = -turn_b * ya, turn_b * xa, -turn_a * yb, turn_a * xc
    end, shared, other = (crank + coupler) / 3, coupler / 6, (coupler + rocker) / 3
    push_xa, push_ya = end * free_xa + shared * free_xb, end * free_ya + shared * free_yb
    push_xb, push_yb = shared * free_xa + other * free_xb, shared * free_ya + other * free_yb
    weight = -(g / 2) * ((crank + coupler) * free_ya + (coupler + rocker) * free_yb)
    work = weight - push_xa * axa - push_ya * aya - push_xb * axb - push_yb * ayb
    rate = work / (push_xa * free_xa + push_ya * free_ya + push_xb * free_xb + push_yb * free_yb)
    accelerations = axa + rate * free_xa, aya + rate * free_ya, axb + rate * free_xb, ayb + rate * free_yb
    return vxa, vya, vxb, vyb, *accelerations


def four_bar_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy (J); potential energy is zero on the line of the pivots."""
    _xa, ya, _xb, yb, vxa, vya, vxb, vyb = state
    crank, coupler, rocker, _d, g = parameters
    a, b = vxa * vxa + vya * vya, vxb * vxb + vyb * vyb
    kinetic = (crank * a + coupler * (a + vxa * vxb + vya * vyb + b) + rocker * b) / 6
    return (kinetic + g * ((crank + coupler) * ya + (coupler + rocker) * yb) / 2,)


def squared_crank(t: Any, state: Values, parameters: Values) -> Values:
    """The square of the crank's length (m^2)."""
    return (three_rods(t, state[:4], parameters)[0],)


def squared_coupler(t: Any, state: Values, parameters: Values) -> Values:
    """The square of the coupler's length (m^2)."""
    return (three_rods(t, state[:4], parameters)[1],)


def squared_rocker(t: Any, state: Values, parameters: Values) -> Values:
    """The square of the rocker's length (m^2)."""
    return (three_rods(t, state[:4], parameters)[2],)


FORM = Constrained(
    four_bar_equations,
    force=three_rods_weight,
    constraint=three_rods,
    gradient=along_three_rods,
    mass=three_rods_masses,
)


def _given(numbers: Mapping[str, Fraction]) -> tuple[tuple[Fraction, ...], tuple[Fraction, ...]]:
    """State and parameters."""
    state = tuple(numbers[name] for name in STATE)
    return state, tuple(numbers[name] for name in ("m1", "m2", "m3", "d", "g"))


def _departure(numbers: Mapping[str, Fraction]) -> str | None:
    return violation(FORM, 0.0, *_given(numbers))


def _consistent(numbers: Mapping[str, Fraction]) -> bool:
    xa, ya, xb, yb, vxa, vya, vxb, vyb = (numbers[name] for name in STATE)
    coupler = (xb - xa) * (vxb - vxa) + (yb - ya) * (vyb - vya)
    return xa * vxa + ya * vya == 0 and coupler == 0 and (xb - numbers["d"]) * vxb + yb * vyb == 0


def _rods(numbers: Mapping[str, Fraction]) -> bool:
    """The three rods have a length and are not in one line with the pivots."""
    state, parameters = _given(numbers)
    a, b, c = three_rods(0, state[:4], parameters)
    return a * b * c != 0 and any(state[k] for k in (1, 3))


def _unfolds(numbers: Mapping[str, Fraction]) -> bool:
    """Flat, the linkage has the energy 0; it can lie flat if a sum of its lengths d, a, b, c with signs vanishes."""
    state, parameters = _given(numbers)
    (a, b, c), d = three_rods(0, state[:4], parameters), numbers["d"] ** 2
    level, outer, inner = d + a - b - c, 4 * d * a, 4 * b * c
    flat = (level**2 + outer - inner) ** 2 == 4 * level**2 * outer
    return not flat or four_bar_energy(0, state, parameters)[0] < 0


class FourBarLinkage(IntegratedCase):
    """A crank and a rocker on two pivots at one height, joined by a coupler, in the vertical plane."""

    name = "four_bar_linkage"
    title = "Four-bar linkage by its two joints: three constraints (certified Taylor)"
    section = "11.2.1"
    conventions = (
        "[inferred] Crank, coupler and rocker are uniform rods m1, m2, m3. The crank turns about (0, 0), the rocker about "
        "(d, 0); joints A = (xa, ya) and B = (xb, yb), y up. The rods' lengths are those of the start, whose velocities keep "
        "them exactly. Index 1: the multipliers are eliminated. A linkage that comes to lie flat is refused: there it may go "
        "on in two ways. The default is a crank-rocker with crank and rocker upright."
    )
    xa = Coordinate("m", 0, typical(0, 0))
    ya = Coordinate("m", "0.3", typical(0.25, 0.4))
    xb = Coordinate("m", 1, typical(1, 1))
    yb = Coordinate("m", "0.9", typical(0.8, 1))
    vxa = Coordinate("m/s", -3, typical(-3, -3))
    vya = Coordinate("m/s", 0, typical(0, 0))
    vxb = Coordinate("m/s", -3, typical(-3, -3))
    vyb = Coordinate("m/s", 0, typical(0, 0))
    m1 = Parameter("kg", 1, "mass of the crank", positive(0.5, 2))
    m2 = Parameter("kg", 2, "mass of the coupler", positive(1, 4))
    m3 = Parameter("kg", 1, "mass of the rocker", positive(0.5, 2))
    d = Parameter("m", 1, "distance of the pivots", positive(1, 1))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(5, 15))
    rules = (
        Rule("the rods have a length and do not lie flat at the start", _rods),
        Rule("the velocities keep the three lengths", _consistent, _departure),
        Rule(
            "it does not come to lie flat (no sum of its lengths with signs is 0, or its energy is negative)", _unfolds
        ),
    )
    default_span = 1
    variants = (
        Variant("near_change_point", "a parallelogram but for a rocker 1 cm longer: it snaps over where it nearly lies flat",
                initial_state=(0, "0.3", 1, "0.31", -3, 0, -3, 0), span="0.8"),
        Variant("parallelogram", "hangs as a compound pendulum and swings to 79 degrees",
                initial_state=(0, "-0.5", 1, "-0.5", 3, 0, 3, 0)),
        Variant("fast", "1000 rad/s: gravity hardly matters",
                initial_state=(0, "0.3", 1, "0.9", -300, 0, -300, 0), span="0.02"),
        Variant("slow_top", "leaves its highest point at 3e-4 rad/s",
                initial_state=(0, "0.3", 1, "0.9", "-0.0001", 0, "-0.0001", 0), span=2),
        Variant("small_swings", "swings of 0.067 rad about a hanging crank and rocker",
                initial_state=(0, "-0.3", 1, "-0.9", "-0.1", 0, "-0.1", 0)),
        Variant("light_coupler", "coupler of 1e-4 kg: its masses are 1e4 times smaller than the others'", {"m2": "0.0001"}),
    )  # fmt: skip
    invariants = conserved(
        energy=four_bar_energy,
        squared_crank=squared_crank,
        squared_coupler=squared_coupler,
        squared_rocker=squared_rocker,
    )
    forms = (FORM,)

    @property
    def time_scale(self) -> float:
        """A radian of the crank, at its start or by its weight."""
        xa, ya, _xb, _yb, vxa, vya, _vxb, _vyb = map(float, self.initial_state)
        crank = hypot(xa, ya)
        return 1 / hypot(hypot(vxa, vya) / crank, sqrt(float(self.g) / crank))

    @property
    def fastest_time(self) -> float:
        """A radian of a rod where the linkage lies nearly flat."""
        return self.time_scale / 4
