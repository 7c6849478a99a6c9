"""pymunk reaches the errors of its best known configuration, runs each scene that moves in a plane, and refuses the others.

Its step is a drift and a kick with the position after the drift: order 1 on every smooth scene.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from gnomon.cases import Case, get, names
from gnomon.cases.core.scene import TOKENS, Body, Contact, Force, Hinge, Scene, SceneForm, free_body, joint
from gnomon.harness.adapters.engines import pymunk_build
from gnomon.harness.adapters.engines.pymunk import INTEGRATORS, Pymunk, PymunkAsShipped
from gnomon.harness.adapters.engines.pymunk_plane import Plane, plane_of
from gnomon.harness.contract.integrator import Floats, Problem, Refused
from gnomon.harness.contract.problem import initial_state, problem_of
from on_cases import exact_states
from scipy.integrate import solve_ivp

pymunk = pytest.importorskip("pymunk")

SCENES = [name for name in names() if get(name).scene is not None]
OUT_OF_PLANE = {
    "charge_in_E_and_B", "relativistic_charge", "free_fall_rotating_earth", "free_fall_rotating_frame_centrifugal",
    "tower_drop", "rotating_pendulum_free_hoop", "equilateral_three_body", "billiard_ball_attitude", "billiard_ball",
}  # fmt: skip
"""Scenes without a token that needs three dimensions, which move in three with their default numbers."""
TWO_BODIES_ON_A_ROPE = {"central_force_hanging_mass", "swinging_atwood"}
RUN = [
    name
    for name in SCENES
    if Pymunk().unsupported(get(name).scene) is None and name not in OUT_OF_PLANE | TWO_BODIES_ON_A_ROPE  # type: ignore[arg-type]
]
SMOOTH = [name for name in RUN if get(name).hybrid is None]
SECOND_ORDER = {"central_force_shortened_string", "flywheel"}
"""Scenes on a circle or a spiral, where the errors of first order in angle and rate cancel."""
QUICK = ("pendulum_simple", "double_pendulum", "pendulum_on_cart", "man_on_cart", "dumbbell_free_flight")


def states(policy: type[Pymunk], case: Case, dt: float, times: Floats | None = None) -> Floats:
    problem = problem_of(case, policy.accepts)
    run = policy().prepare(problem if times is None else replace(problem, times=times), dt)
    try:
        return run(initial_state(case)[None]).states[0]
    finally:
        run.close()


def error_over_the_path(policy: type[Pymunk], case: Case, dt: float) -> float:
    return float(np.max(case.metric.distance(states(policy, case, dt), exact_states(case), case.times)))


def angle_over_the_path(policy: type[Pymunk], case: Case, dt: float) -> float:
    off = states(policy, case, dt)[:, 0] - exact_states(case)[:, 0]
    return float(np.max(np.abs(np.remainder(off + np.pi, 2 * np.pi) - np.pi)))


def position_at_the_end(policy: type[Pymunk], case: Case, dt: float) -> float:
    lengths = [i for i, coordinate in enumerate(case.state) if coordinate.kind == "length"]
    off = states(policy, case, dt)[-1] - case.sample(case.times[-1:])[0]
    return float(np.linalg.norm(off[lengths]))


def time_of_the_tenth_impact(policy: type[Pymunk], case: Case, dt: float) -> float:
    times = np.arange(1, round(1.05 * float(case.span) / dt)) * dt
    v = states(policy, case, dt, times)[:, 1]
    turns = np.nonzero((v[:-1] < 0) & (v[1:] > 0))[0]
    before = turns[9]
    found = times[before] + dt * v[before] / (v[before] - v[before + 1])
    return abs(float(found - case.events()[9].time))


PUBLISHED: tuple[tuple[str, str, Callable[[type[Pymunk], Case, float], float], tuple[float, ...]], ...] = (
    ("projectile_parabola", "engines", position_at_the_end, (0.049, 0.0049, 0.00049)),
    ("kepler_orbit", "engines", position_at_the_end, (0.31, 0.0032, 3.2e-5)),
    ("bouncing_ball", "engines_e1", time_of_the_tenth_impact, (0.071, 0.019, 5.5e-4)),
    ("bouncing_ball", "engines_e08", time_of_the_tenth_impact, (0.041, 0.0041, 5.1e-4)),
    ("block_incline_friction", "engines_stop", position_at_the_end, (0.015, 1.5e-3, 1.5e-4)),
    ("block_incline_friction", "engines_slide", position_at_the_end, (0.012, 1.2e-3, 1.2e-4)),
    ("billiard_ball", "engines", position_at_the_end, (4.5e-3, 4.3e-4, 4.3e-5)),
    # A rod without inertia: a tenth of the error 1.1 at 1e-2 that a body with a moment of 1e-3 kg m^2 has.
    ("pendulum_simple", "engines", angle_over_the_path, (0.11, 0.0039, 3.1e-4)),
)


@pytest.mark.parametrize("step", [0, pytest.param(1, marks=pytest.mark.slow), pytest.param(2, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    ("name", "label", "measure", "published"), PUBLISHED, ids=[f"{n}-{x}" for n, x, *_ in PUBLISHED]
)
def test_errors_are_those_published(
    name: str,
    label: str,
    measure: Callable[[type[Pymunk], Case, float], float],
    published: tuple[float, ...],
    step: int,
) -> None:
    error = measure(Pymunk, get(name, label).rounded(), (1e-2, 1e-3, 1e-4)[step])
    assert published[step] / 2 < error < 2 * published[step]


@pytest.mark.parametrize("name", [n if n in QUICK else pytest.param(n, marks=pytest.mark.slow) for n in SMOOTH])
def test_a_smooth_scene_is_of_first_order(name: str) -> None:
    """The next term of the error is a hundredth of the leading one, near a collision some hundredths."""
    case = get(name, span=min(8 * get(name).time_scale, float(get(name).span))).rounded()
    coarse, fine = (error_over_the_path(Pymunk, case, float(case.times[0]) / parts) for parts in (64, 128))
    assert coarse < 0.05
    if name not in SECOND_ORDER:
        assert np.log2(coarse / fine) == pytest.approx(1.0, abs=0.05)
    else:
        assert np.log2(coarse / fine) > 1.5


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in RUN if name not in SMOOTH])
def test_impacts_and_friction_converge(name: str) -> None:
    """An impact is late by up to a step, wherever it is in its step: order 1, irregular; a sixteenth of the step, a quarter
    of the error at most."""
    case = get(name).rounded()
    coarse, fine = (error_over_the_path(Pymunk, case, float(case.times[0]) / parts) for parts in (16, 256))
    assert fine < coarse / 4


@pytest.mark.parametrize("name", sorted(OUT_OF_PLANE | TWO_BODIES_ON_A_ROPE))
def test_a_scene_is_refused_for_its_numbers(name: str) -> None:
    """When it is built, or placed in its start."""
    case = get(name).rounded()
    with pytest.raises(Refused, match="planar engine" if name in OUT_OF_PLANE else "second body"):
        states(Pymunk, case, float(case.times[0]))


def test_the_engine_has_none_of_what_it_lacks() -> None:
    assert set(Pymunk.lacks) <= set(TOKENS)
    assert {kind.__name__ for kind in pymunk.Constraint.__subclasses__()} == {
        "PinJoint", "SlideJoint", "PivotJoint", "GrooveJoint", "DampedSpring", "DampedRotarySpring",
        "RotaryLimitJoint", "RatchetJoint", "GearJoint", "SimpleMotor",
    }  # fmt: skip
    body = pymunk.Body(1, 1)
    assert len(body.position) == 2
    assert isinstance(body.angular_velocity, float)
    assert [name for name in dir(pymunk.Shape) if "friction" in name] == ["friction"]
    left, right = pymunk.Body(1, 1), pymunk.Body(1, 1)
    left.velocity, right.position = (1, 0), (1, 0)
    space = pymunk.Space()
    space.add(left, right, pymunk.Circle(left, 0.0), pymunk.Circle(right, 0.0))
    for _ in range(2048):
        space.step(2**-10)
    assert left.position.x == 2.0


def test_the_plane_is_that_of_the_scene() -> None:
    def plane(name: str) -> int:
        case = get(name).rounded()
        scene = case.scene.build(tuple(initial_state(case)), tuple(map(float, case.parameter_values())))  # type: ignore[union-attr]
        return plane_of(scene).normal

    assert (plane("pendulum_simple"), plane("kepler_orbit"), plane("foucault_pendulum_linear")) == (1, 2, 2)


@pytest.mark.parametrize("normal", [0, 1, 2])
def test_angles_are_positive_about_the_normal(normal: int) -> None:
    plane = Plane(normal)
    first, second = np.array(plane.space((1.0, 0.0))), np.array(plane.space((0.0, 1.0)))
    assert np.array_equal(np.cross(first, second), plane.spin(1.0))
    assert plane.angle(plane.attitude(0.7)) == pytest.approx(0.7)


def test_friction_of_a_hinge_on_a_point_with_weight() -> None:
    """The wheel that replaces the point turns as the point does: the error halves with the step."""
    m, length, friction, drag = 1.7, 0.6, 0.3, 0.2

    def build(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
        hinge = Hinge("h", "b", (0, 0, 0), (0, 1, 0), (0, 0, -length), *state, friction=friction)
        brake = Force("b", "velocity_force", lambda t, x, v: (-drag * v[0], -drag * v[1], -drag * v[2]))
        return Scene((0, 0, -9.81), (Body("b", m, (0.0, 0.0, 0.0)),), hinges=(hinge,), forces=(brake,))

    form = SceneForm(build, joint("h"), frozenset({"hinge", "joint_friction", "velocity_force"}), conservative=False)

    def change(t: float, y: Floats) -> list[float]:
        return [y[1], -9.81 / length * np.sin(y[0]) - friction / (m * length**2) * np.sign(y[1]) - drag / m * y[1]]

    exact = solve_ivp(change, (0, 0.5), [1.0, -0.5], rtol=1e-10, atol=1e-12).y[:, -1]
    errors = []
    for dt in (2**-9, 2**-10):
        run = Pymunk().prepare(Problem(form, 2, np.zeros(0), np.array([0.5]), time_scale=0.2), dt)
        errors.append(np.abs(run(np.array([[1.0, -0.5]])).states[0, -1] - exact))
        run.close()
    assert errors[0] / errors[1] == pytest.approx(2.0, abs=0.05)


def test_a_moving_plane_carries_a_block_with_it() -> None:
    """Friction accelerates it with 2 m/s^2 to the plane's 0.5 m/s. The first drift and the last slip err by a step each."""

    def build(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
        box = Body("b", 1.0, (0.1, 0.1, 0.1), (0.0, 0.0, 0.1), half_extents=(0.5, 0.5, 0.1))
        plane = Contact("b", (0.0, 0.0, 1.0), friction=0.2, velocity=(0.5, 0.0, 0.0))
        return Scene((0.0, 0.0, -10.0), (box,), contacts=(plane,))

    form = SceneForm(build, free_body("b", 0), frozenset({"coulomb_isotropic", "moving_surface"}), conservative=False)
    run = Pymunk().prepare(Problem(form, 2, np.zeros(0), np.array([0.125, 0.25, 1.0]), time_scale=0.2), 2**-9)
    found = run(np.zeros((1, 2))).states[0]
    run.close()
    assert found[:, 1] == pytest.approx([0.25, 0.5, 0.5], abs=1e-12)
    assert found[:, 0] == pytest.approx([1 / 64, 1 / 16, 7 / 16], abs=2**-9)


def test_few_iterations_leave_an_error_that_no_step_removes(monkeypatch: pytest.MonkeyPatch) -> None:
    """A block that touches two planes with friction."""
    case = get("torpedo_firing_pin").rounded()
    step = float(case.times[0]) / 64
    enough = error_over_the_path(Pymunk, case, step)
    monkeypatch.setattr(pymunk_build, "ITERATIONS", pymunk.Space().iterations)
    assert error_over_the_path(Pymunk, case, step) > 5 * enough


def test_as_shipped_a_joint_errs_more() -> None:
    case = get("pendulum_simple", "engines").rounded()
    assert angle_over_the_path(PymunkAsShipped, case, 1e-3) > 100 * angle_over_the_path(Pymunk, case, 1e-3)


@pytest.mark.parametrize("name", ["pendulum_simple", "bouncing_ball", "projectile_parabola"])
def test_options_are_recorded(name: str) -> None:
    """The values that the engine reports after a run, and its defaults, from which they differ."""
    case = get(name).rounded()
    run = Pymunk().prepare(problem_of(case, Pymunk.accepts), float(case.times[0]))
    run(initial_state(case)[None])
    space, defaults = run.world.built.space, pymunk.Space()  # type: ignore[attr-defined]
    held = {each: getattr(space, each) for each in ("collision_bias", "iterations", "collision_slop", "damping")}
    for constraint in space.constraints:
        held["error_bias"] = constraint.error_bias
    changed = {each: value for each, value in held.items() if value != getattr(defaults, each, None)}
    assert run.options == changed
    run.close()
    shipped = PymunkAsShipped().prepare(problem_of(case, Pymunk.accepts), float(case.times[0]))
    assert not shipped.options
    shipped.close()


def test_a_singular_force_stops_the_run() -> None:
    """The engine prints an exception of a callback and goes on; the step raises it again."""
    case = get("kepler_orbit", "plunge").rounded()
    problem = replace(problem_of(case, Pymunk.accepts), times=np.array([0.125, 0.25]))
    run = Pymunk().prepare(problem, 0.125)
    solution = run(np.array([[0.25, 0.0, -2.0, 0.0]]))
    run.close()
    assert "not finite" in (solution.stopped or "")
    assert np.all(np.isnan(solution.states))


@pytest.mark.parametrize("policy", INTEGRATORS)
def test_runs_repeat_to_the_bit(policy: type[Pymunk]) -> None:
    case = get("bouncing_ball", "engines_e08").rounded()
    assert np.array_equal(states(policy, case, 1e-2), states(policy, case, 1e-2))
