"""A block on a moving belt, held by a spring, whose kinetic friction falls with the speed of sliding."""

from gnomon.cases.contact.stick_slip_belt import (
    BlockOnBelt,
    StickSlipBelt,
    at_belt_speed,
    lag,
    pull,
    stick_slip_mode,
)
from gnomon.cases.declare import *
from gnomon.reference.contact.stick_slip_falling_friction import FallingStickSlip


def slipping(t: Any, state: Values, parameters: Values) -> Values:
    """v' = g (mu_k - slope (V - v)) - (k/m) x."""
    x, v = state
    m, k, g, _mu_s, mu_k, belt, slope = parameters
    return v, g * (mu_k - slope * (belt - v)) - (k / m) * x


def carried(t: Any, state: Values, parameters: Values) -> Values:
    """x' = v, which is V."""
    return state[1], 0


def swings(n: Any) -> bool:
    """With a growth as slow as 1e-30, a slip could not be told from one that reaches V as a tangent."""
    return bool(Fraction(1, 10**60) * n["k"] < (n["slope"] * n["g"]) ** 2 * n["m"] < 4 * n["k"])


def is_steady(n: Any) -> bool:
    """Sliding at x = xk with v = 0 lasts for ever, and is unstable."""
    return bool(n["v"] == 0 and n["x"] * n["k"] == (n["mu_k"] - n["slope"] * n["V"]) * n["m"] * n["g"])


def law_holds(n: Any) -> bool:
    if not swings(n) or is_steady(n) or n["v"] > n["V"] or n["mu_k"] > n["mu_s"]:
        return True  # another rule refuses these
    numbers = (n[name] for name in ("m", "k", "g", "mu_s", "mu_k", "V", "x", "v", "slope"))
    try:
        return FallingStickSlip(*numbers).keeps_its_law()
    except ArithmeticError:  # so close to a limit that no precision decides
        return False


def belt_holds(n: Any) -> bool:
    return bool(n["v"] < n["V"] or n["k"] * n["x"] >= -n["mu_s"] * n["m"] * n["g"])


class StickSlipFallingFriction(BlockOnBelt):
    name = "stick_slip_falling_friction"
    title = "Stick-slip with friction that falls with the speed of sliding"
    section = "5.11.2, 5.12"
    conventions = (
        "[inferred] As stick_slip_belt, with the kinetic coefficient mu_k - slope (V - v), which stays positive: each slip is "
        "a linear oscillator of negative damping slope m g. The block is never faster than the belt, and the belt can hold it "
        "where a slip ends, x > -mu_s m g/k. No source: the numbers are ours."
    )
    x = Coordinate("m", 0, typical(-0.1, 0.5))
    v = Coordinate("m/s", "0.5", typical(-0.3, 0.3))
    mu_s = Parameter("1", "0.5", "coefficient of static friction", nonnegative(0.4, 1))
    mu_k = Parameter("1", "0.4", "coefficient of kinetic friction as sliding begins", nonnegative(0.3, 0.6))
    V = Parameter("m/s", "0.5", "speed of the belt", positive(0.1, 1))
    slope = Parameter("s/m", "0.1", "fall of the kinetic coefficient with the speed of sliding", positive(0.01, 0.1))
    rules = (
        Rule("mu_k <= mu_s (friction does not grow when sliding begins)", lambda n: n["mu_k"] <= n["mu_s"]),
        Rule("v <= V (the block is not faster than the belt)", lambda n: n["v"] <= n["V"]),
        Rule("1e-30 sqrt(k/m) < slope g < 2 sqrt(k/m) (a slipping block swings, and its swings grow)", swings),
        Rule("the block does not slide steadily (v = 0, k x = (mu_k - slope V) m g)", lambda n: not is_steady(n)),
        Rule("a block that starts at V can be held (x >= -mu_s m g/k)", belt_holds),
        Rule("in every slip friction stays positive, and where it ends the belt can hold the block", law_holds),
    )
    exact_motion = bind(FallingStickSlip, mass="m", stiffness="k")
    variants = (
        Variant(
            "slope_near_zero",
            "one coefficient that falls by 1e-8 per m/s: the speed would pass the belt's by 3e-8 m/s, for 1.6e-4 s",
            {"mu_s": "0.3", "mu_k": "0.3", "slope": "1e-8"},
        ),
        Variant(
            "continuous", "mu_s = mu_k: the block is released without a jump of the force", {"mu_s": "0.4"},
        ),
        Variant("many", "1,315 cycles: errors of event times add up", span="2050.3"),
        Variant("stiff_spring", "k = 1e6 N/m: slips of 6 ms", {"k": 10**6, "V": "0.01"}, (0, "0.01")),
        Variant(
            "grazing", "the second peak of the speed would pass the belt's by 1e-10 m/s: caught 4.5e-6 s before it",
            initial_state=("0.1252439371092388", 0),
        ),
        Variant(
            "missed", "the second peak stays 1e-10 m/s below the belt's speed: caught on the third",
            initial_state=("0.1252439371278112", 0),
        ),
        Variant(
            "spirals_out", "starts 1e-8 m from steady sliding, which is unstable: 23 growing swings before the one on which it is caught",
            initial_state=("0.17167501", 0), span=40,
        ),
        Variant("slow_belt", "V = 1e-3: long phases of sticking, short slips", {"V": "1e-3"}, (0, "1e-3")),
    )  # fmt: skip
    forms = (
        Hybrid(
            modes=(Mode("stick", carried), Mode("slip", slipping)),
            start=stick_slip_mode,
            transitions=(
                Transition("release", "stick", pull, 1, at_belt_speed, "slip"),
                Transition("stick", "slip", lag, 1, at_belt_speed, "stick"),
            ),
        ),
    )

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        return (self.level(StickSlipBelt, "kinetic friction that does not fall"),)

    def derived(self, digits: int) -> dict[str, Any]:
        """`fastest_sliding`: the largest speed of the belt past the block after the first release."""
        return super().derived(digits) | {"fastest_sliding": self.exact_motion.slides_at_most(digits)}
