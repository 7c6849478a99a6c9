"""A slider in a radial slot of a rotating table."""

from collections.abc import Sequence

from gnomon.cases.declare import *
from gnomon.cases.scenes.point import railed_point, railed_pull
from gnomon.reference.guided.slider_rotating_slot import Slot


def slot_equations(t: Any, state: Values, parameters: Values) -> Values:
    """r'' = Om^2 r - (k/m) (r - r0) - 2 mu Om r'."""
    r, v = state
    m, k, r0, Om, mu = parameters
    return v, Om * Om * r - (k / m) * (r - r0) - 2 * mu * Om * v


def slot_matrix(parameters: Values) -> Values:
    m, k, _, Om, mu = parameters
    return 0, 1, Om * Om - k / m, -2 * mu * Om


def spring_offset(t: Any, state: Values, parameters: Values) -> Values:
    m, k, r0, _, _ = parameters
    return 0, k / m * r0


def smooth_slot(t: Any, q: Values, parameters: Values) -> Values:
    """r'' = Om^2 r - (k/m) (r - r0)."""
    (r,) = q
    m, k, r0, Om, _ = parameters
    return (Om * Om * r - (k / m) * (r - r0),)


def smooth_slot_potential(t: Any, q: Values, parameters: Values) -> Values:
    (r,) = q
    m, k, r0, Om, _ = parameters
    return (((k / m) * (r - r0) * (r - r0) - Om * Om * r * r) / 2,)


def jacobi_integral(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the mass in the rotating frame, the centrifugal potential included; friction makes it decay."""
    r, v = state
    m, k, r0, Om, _ = parameters
    return ((v * v - Om * Om * r * r + (k / m) * (r - r0) * (r - r0)) / 2,)


ROUGH_SCENE, SMOOTH_SCENE = railed_point(slot_equations), railed_pull(smooth_slot)
"""In the frame of the table: a fixed rail with the centrifugal force and the friction due to the Coriolis force."""


class SliderRotatingSlot(Case):
    name = "slider_rotating_slot"
    title = "Slider block in a radial slot of a steadily rotating table: free, spring controlled, wall friction"
    section = "6.9.1, 6.9.2"
    conventions = (
        "The spring is unstretched at r0. Friction follows from the Coriolis force on the wall: linear damping for either "
        "sign of v. Om >= 0. The slot passes through the axis: r may change its sign."
    )
    r = Coordinate("m", "0.3", typical(-1, 1))
    v = Coordinate("m/s", "0.4", typical(-2, 2))
    m = Parameter("kg", 1, "mass of the slider", positive(0.5, 5))
    k = Parameter("N/m", 20, "stiffness of the spring", nonnegative(0, 30))
    r0 = Parameter("m", "0.2", "position at which the spring is unstretched", typical(0, 1))
    Om = Parameter("rad/s", 3, "rate of the table", nonnegative(0.5, 5))
    mu = Parameter("1", "0.1", "coefficient of friction on the wall", nonnegative(0, 0.5))
    exact_motion = bind(Slot, mass="m", stiffness="k", natural="r0", rate="Om", friction="mu", start="r")
    quantity_names = ("larger_rate smaller_rate=rates", "wall_force", "balance")
    variants = (
        Variant("free", "no spring: moves outward as e^(Om t)", {"k": 0, "mu": 0}),
        Variant("smooth", "no friction: harmonic about a shifted centre", {"mu": 0}),
        Variant("critical", "k/m = Om^2: uniformly accelerated", {"k": 9, "mu": 0}),
        Variant("below_critical", "k/m - Om^2 = 1e-12: a period of 73 days", {"k": "9.000000000001", "mu": 0}),
        Variant("above_critical", "k/m - Om^2 = -1e-12: grows by e in 12 days", {"k": "8.999999999999", "mu": 0}),
        Variant("growth", "moves outward by a factor e^50", {"k": 0, "mu": 0}, span="16.67"),
        Variant("rough", "mu = 2: overdamped by the wall", {"mu": 2}),
    )
    invariants = decaying(jacobi=jacobi_integral)
    reversal = ("v",)

    @property
    def forms(self) -> tuple[Form, ...]:
        """Separable without friction."""
        linear = SemiLinear(slot_equations, linear=slot_matrix, rest=spring_offset)
        return (linear,) if self.mu else (Separable(smooth_slot, smooth_slot_potential), linear)

    @property
    def scene(self) -> SceneForm:
        return ROUGH_SCENE if self.mu else SMOOTH_SCENE

    @property
    def time_scale(self) -> float:
        """The shortest time of table, spring and friction; 1 s without any."""
        m, k, _, Om, mu = map(float, self.parameter_values())
        return 1 / (sqrt(max(Om * Om, k / m)) + 2 * mu * Om or 1.0)

    def natural_span(self) -> Number:
        """10.37 periods or decay times; a growth by e^10; 10 radians of the table at or near the critical speed."""
        motion = self.exact_motion
        growth, pull = float(motion.rates()[0]), float(motion.pull)
        Om = float(motion.rate)
        if abs(pull) < 1e-6 * Om * Om or Om == 0 == pull:
            return 10 / (Om or 1.0)
        if growth > 0:
            return 10 / growth
        turning = -pull - float(motion.damping) ** 2 / 4
        return 10.37 * (tau / sqrt(turning) if turning > 0.01 else min(1 / max(-growth, 0.01), 10.0))

    def reversed(self, state: Sequence[Any]) -> tuple[tuple[Any, ...], dict[str, Fraction]] | None:
        """Only without friction."""
        return super().reversed(state) if self.mu == 0 else None
