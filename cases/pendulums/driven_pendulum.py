"""The damped pendulum under a harmonic torque: periodic, period-doubled or chaotic."""

from gnomon.cases.declare import *
from gnomon.cases.oscillators.forced_oscillators import ForcedOscillator
from gnomon.cases.scenes.hinge import hinged_point


def driven_pendulum_equations(t: Any, state: Values, parameters: Values) -> Values:
    """theta' = omega, omega' = -w0^2 sin theta - c omega + F cos(w t)."""
    theta, omega = state
    w0, c, F, w = parameters
    return omega, F * cos(w * t) - c * omega - w0 * w0 * sin(theta)


class DrivenPendulum(IntegratedCase):
    name = "driven_pendulum"
    title = "Driven damped pendulum: period doubling and chaos (no closed form; certified Taylor)"
    section = "6.12"
    conventions = (
        "[inferred] Not in the book: G. L. Baker, J. P. Gollub, Chaotic Dynamics (1990), theta'' + theta'/q + sin theta = "
        "g cos(w t) with q = 2 and w = 2/3, here 0.666666666666667. theta from the downward vertical, not wrapped; c, F over "
        "the moment of inertia."
    )
    theta = Coordinate("rad", 0, typical(-3, 3))
    omega = Coordinate("rad/s", -1, typical(-2, 2))
    w0 = Parameter("rad/s", 1, "frequency of small swings", positive(0.8, 1.25))
    c = Parameter("1/s", "0.5", "damping over the moment of inertia", nonnegative(0, 1))
    F = Parameter("rad/s^2", "1.5", "amplitude of the torque over the moment of inertia", typical(-1.5, 1.5))
    w = Parameter("rad/s", "0.666666666666667", "frequency of the torque", nonnegative(0.3, 1.5))
    default_span = Span(100.3, "time scale")
    default_horizon = 314
    variants = (
        Variant("periodic", "F = 0.9: one period of the torque; errors die out", {"F": "0.9"}, span=200),
        Variant(
            "period_doubled", "F = 1.07: two periods of the torque, behind a long transient", {"F": "1.07"}, span=200
        ),
        Variant("onset", "F = 1.15: chaos with long regular phases", {"F": "1.15"}, span=300),
        Variant("chaotic", "to 0.95 of the horizon, 314 s", span=298, horizon=314),
    )
    autonomous = False
    forms = (FirstOrder(driven_pendulum_equations),)
    scene = hinged_point(driven_pendulum_equations, "time_force")
    mirror = ("theta", "omega", "F")

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        """Small swings: the forced oscillator."""
        numbers = dict(zip(("x", "v"), self.initial_state, strict=True))
        linear = ForcedOscillator(
            initial_state=tuple(numbers.values()), span=self.span, m=1, c=self.c, k=self.w0**2, F0=self.F, w=self.w
        )
        return (Level(linear, same, "small swings: a forced oscillator"),)

    @property
    def time_scale(self) -> float:
        return 1 / max(float(self.w0), float(self.w))
