"""The slider-crank by the places of its pin and its slider: two constraints, three coordinates, one freedom."""

from gnomon.cases.core.consistent import violation
from gnomon.cases.declare import *

STATE = ("x", "y", "s", "vx", "vy", "vs")


def crank_and_rod_weight(t: Any, place: Values, parameters: Values) -> Values:
    """Each uniform rod has half of its weight at each end; the slider is on its rail."""
    crank, rod, _slider, g = parameters
    return 0, -g * (crank + rod) / 2, 0


def crank_and_rod_masses(t: Any, place: Values, parameters: Values) -> Values:
    """A uniform rod whose ends have the velocities u, v has the kinetic energy m (u^2 + u v + v^2)/6."""
    crank, rod, slider, _g = parameters
    pin = (crank + rod) / 3
    return pin, 0, rod / 6, 0, pin, 0, rod / 6, 0, slider + rod / 3


def crank_and_rod(t: Any, place: Values, parameters: Values) -> Values:
    """The squares of the lengths of crank and rod."""
    x, y, s = place
    return x * x + y * y, (s - x) * (s - x) + y * y


def along_crank_and_rod(t: Any, place: Values, parameters: Values) -> Values:
    x, y, s = place
    ahead = 2 * (s - x)
    return 2 * x, 2 * y, 0, -ahead, 2 * y, ahead


def slider_crank_equations(t: Any, state: Values, parameters: Values) -> Values:
    """Index 1: the least accelerations that keep the lengths, and one along the freedom, which is across both normals."""
    x, y, s, vx, vy, vs = state
    crank, rod, slider, g = parameters
    ahead, closing, rise = s - x, vs - vx, vy * vy
    first, second = vx * vx + rise, closing * closing + rise
    height = y * y
    square, mixed, other = x * x + height, height - ahead * x, 2 * (ahead * ahead) + height
    both = square * other - mixed * mixed
    inward, along = (other * first - mixed * second) / both, (square * second - mixed * first) / both
    stretch = along * ahead
    ax, ay = stretch - inward * x, -(inward + along) * y
    free_x, free_y, free_s = ahead * y, -ahead * x, y * s
    pin, shared, end = (crank + rod) / 3, rod / 6, slider + rod / 3
    push_x, push_y, push_s = pin * free_x + shared * free_s, pin * free_y, shared * free_x + end * free_s
    work = -(g * (crank + rod) / 2) * free_y - push_x * ax - push_y * ay + push_s * stretch
    rate = work / (push_x * free_x + push_y * free_y + push_s * free_s)
    return vx, vy, vs, ax + rate * free_x, ay + rate * free_y, rate * free_s - stretch


def slider_crank_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy (J); potential energy is zero on the rail."""
    _x, y, _s, vx, vy, vs = state
    crank, rod, slider, g = parameters
    pin = vx * vx + vy * vy
    kinetic = (crank * pin + rod * (pin + vx * vs + vs * vs)) / 6 + slider * vs * vs / 2
    return (kinetic + (crank + rod) * g * y / 2,)


def squared_crank(t: Any, state: Values, parameters: Values) -> Values:
    """The square of the crank's length (m^2)."""
    return (crank_and_rod(t, state[:3], parameters)[0],)


def squared_rod(t: Any, state: Values, parameters: Values) -> Values:
    """The square of the rod's length (m^2)."""
    return (crank_and_rod(t, state[:3], parameters)[1],)


FORM = Constrained(
    slider_crank_equations,
    force=crank_and_rod_weight,
    constraint=crank_and_rod,
    gradient=along_crank_and_rod,
    mass=crank_and_rod_masses,
)


def _departure(numbers: Mapping[str, Fraction]) -> str | None:
    parameters = [numbers[name] for name in ("m1", "m2", "m3", "g")]
    return violation(FORM, 0.0, [numbers[name] for name in STATE], parameters)


def _consistent(numbers: Mapping[str, Fraction]) -> bool:
    x, y, s, vx, vy, vs = (numbers[name] for name in STATE)
    return x * vx + y * vy == 0 and (s - x) * (vs - vx) + y * vy == 0


def _apart(numbers: Mapping[str, Fraction]) -> bool:
    """The rod's square less the crank's is s (s - 2 x)."""
    x, y, s = (numbers[name] for name in STATE[:3])
    return s != 0 and s != 2 * x and (x != 0 or y != 0) and (s != x or y != 0)


class SliderCrank(IntegratedCase):
    """A crank turns in the vertical plane and drives a slider along a horizontal rail by a rod."""

    name = "slider_crank"
    title = "Slider-crank by its pin and slider: two constraints (certified Taylor)"
    section = "11.2.1"
    conventions = (
        "[inferred] Crank and rod are uniform, m1 and m2; the slider m3 is on a smooth rail through the crank's axis. Pin "
        "(x, y) and slider (s, 0) from that axis, y up. The lengths of crank and rod are those of the start, whose velocities "
        "keep them exactly. Index 1: the multipliers are eliminated. A rod as long as the crank is refused: with slider and "
        "axis in one place its constraints do not determine the motion."
    )
    x = Coordinate("m", 0, typical(0, 0))
    y = Coordinate("m", "0.5", typical(0.3, 0.7))
    s = Coordinate("m", "1.2", typical(1, 1.5))
    vx = Coordinate("m/s", -3, typical(-3, -3))
    vy = Coordinate("m/s", 0, typical(0, 0))
    vs = Coordinate("m/s", -3, typical(-3, -3))
    m1 = Parameter("kg", 1, "mass of the crank", positive(0.5, 2))
    m2 = Parameter("kg", 2, "mass of the rod", positive(1, 4))
    m3 = Parameter("kg", 1, "mass of the slider", positive(0.5, 2))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(5, 15))
    rules = (
        Rule("crank and rod have different lengths, not zero (s and s - 2 x are not 0)", _apart),
        Rule(
            "the velocities keep both lengths (x vx + y vy = 0, (s - x) (vs - vx) + y vy = 0)", _consistent, _departure
        ),
    )
    default_span = 3
    variants = (
        Variant(
            "near_fold",
            "rod 1 cm longer than the crank: it whips round twice a turn, and the slider nearly stops for half of it",
            initial_state=(0, "0.5", "0.1", -3, 0, -3),
            span="1.5",
        ),
        Variant("short_rod", "rod of 0.3 m on a crank of 0.5 m: the rod turns round, the crank swings",
                initial_state=("0.5", 0, "0.8", 0, 3, 0)),
        Variant("fast", "600 rad/s: gravity hardly matters", initial_state=(0, "0.5", "1.2", -300, 0, -300), span="0.05"),
        Variant("slow_top", "leaves its highest point at 2e-4 rad/s", initial_state=(0, "0.5", "1.2", "-0.0001", 0, "-0.0001"), span=4),
        Variant("small_swings", "swings of 0.067 rad about the lowest point",
                initial_state=(0, "-0.5", "1.2", "-0.1", 0, "-0.1"), span=4),
        Variant("light_rod", "rod of 1e-4 kg: its masses are 1e4 times smaller than the others'", {"m2": "0.0001"}),
    )  # fmt: skip
    invariants = conserved(energy=slider_crank_energy, squared_crank=squared_crank, squared_rod=squared_rod)
    forms = (FORM,)

    @property
    def time_scale(self) -> float:
        """A radian of the crank, at its start or by its weight."""
        x, y, _s, vx, vy, _vs = map(float, self.initial_state)
        crank = hypot(x, y)
        return 1 / hypot(hypot(vx, vy) / crank, sqrt(float(self.g) / crank))

    @property
    def fastest_time(self) -> float:
        """A radian of the crank, or of the rod where it stands across its rail."""
        return self.time_scale / 4
