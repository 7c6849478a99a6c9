"""Hénon and Heiles's potential: two equal oscillators with a cubic coupling, between order and chaos."""

from gnomon.cases.declare import *
from gnomon.cases.oscillators.small_vibrations import SmallVibrations
from gnomon.cases.scenes.point import free_point


def henon_heiles_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """x'' = -w^2 x - 2 lam x y, y'' = -w^2 y - lam (x^2 - y^2)."""
    x, y = q
    w, lam = parameters
    return -w * w * x - 2 * lam * x * y, -w * w * y - lam * (x * x - y * y)


def henon_heiles_potential(t: Any, q: Values, parameters: Values) -> Values:
    """w^2 (x^2 + y^2)/2 + lam (x^2 y - y^3/3)."""
    x, y = q
    w, lam = parameters
    return (w * w * (x * x + y * y) / 2 + lam * y * (x * x - y * y / 3),)


def henon_heiles_equations(t: Any, state: Values, parameters: Values) -> Values:
    x, y, vx, vy = state
    return vx, vy, *henon_heiles_acceleration(t, (x, y), parameters)


def henon_heiles_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the mass."""
    x, y, vx, vy = state
    return ((vx * vx + vy * vy) / 2 + henon_heiles_potential(t, (x, y), parameters)[0],)


def _share(n: Mapping[str, Fraction]) -> Fraction:
    """The energy over the escape energy w^6/(6 lam^2)."""
    w, lam = n["w"], n["lam"]
    (energy,) = henon_heiles_energy(0, (n["x"], n["y"], n["vx"], n["vy"]), (w, lam))
    return 6 * lam * lam * Fraction(energy) / w**6


def _inside(n: Mapping[str, Fraction]) -> bool:
    """Within the triangle of the three saddles, at most at the escape energy."""
    size = n["lam"] / n["w"] ** 2
    x, y = size * n["x"], size * n["y"]
    return -1 <= 2 * y <= 2 and 3 * x * x <= (1 - y) ** 2 and _share(n) <= 1


class HenonHeiles(IntegratedCase):
    """A star's motion in the meridian plane of a galaxy, as Hénon and Heiles modelled it."""

    name = "henon_heiles"
    title = "Hénon-Heiles potential: islands of order in a chaotic sea (no closed form; certified Taylor)"
    section = "11.13"
    conventions = (
        "[inferred] Not in the book: M. Hénon, C. Heiles, The Astronomical Journal 69 (1964) 73, with frequency w and "
        "coefficient lam of the cubic terms, both 1 there. Forces over the mass. Bound below the energy w^6/(6 lam^2). The "
        "default has 3/4 of it, the paper's E = 1/8."
    )
    x = Coordinate("m", 0, typical(-0.3, 0.3))
    y = Coordinate("m", 0, typical(-0.3, 0.3))
    vx = Coordinate("m/s", "0.48", typical(-0.3, 0.3))
    vy = Coordinate("m/s", "-0.14", typical(-0.3, 0.3))
    w = Parameter("rad/s", 1, "frequency of small swings", positive(0.8, 1.25))
    lam = Parameter("1/(m s^2)", 1, "coefficient of the cubic terms over the mass", positive(0.1, 1))
    rules = (Rule("the start is within the potential's triangle, at most at the escape energy w^6/(6 lam^2)", _inside),)
    default_span = Span(100.3, "time scale")
    default_horizon = 417
    variants = (
        Variant(
            "regular", "E = 1/8 too, in an island of order: 62 turns", initial_state=(0, 0, "0.4", "0.3"), span=390
        ),
        Variant("chaotic", "to 0.95 of the horizon, 417 s", span=396, horizon=417),
        Variant(
            "near_escape",
            "99.84 % of the escape energy, to 0.95 of the horizon, 216 s",
            initial_state=(0, 0, "0.48", "0.32"),
            span=205,
            horizon=216,
        ),
    )
    forms = (Separable(henon_heiles_acceleration, henon_heiles_potential),)
    invariants = conserved(energy=henon_heiles_energy)
    scene = free_point(henon_heiles_equations, (0, 2), token="position_force")
    mirror = ("x", "vx")

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        """Small swings: two equal oscillators, as the first and second of three masses on springs of their own."""
        x, y, vx, vy = self.initial_state
        springs: dict[str, Any] = {"k1": self.w**2, "k2": self.w**2, "k3": 1, "k12": 0, "k23": 0}
        linear = SmallVibrations(initial_state=(x, y, 0, vx, vy, 0), span=self.span, m1=1, m2=1, m3=1, **springs)

        def of_two(states: Floats) -> Floats:
            return states[:, (0, 1, 3, 4)]

        return (Level(linear, of_two, "small swings: two equal oscillators"),)

    @property
    def time_scale(self) -> float:
        return 1 / float(self.w)

    def derived(self, digits: int) -> dict[str, Any]:
        """`escape_share`: the energy over the escape energy."""
        return {"escape_share": _share(self.numbers)}
