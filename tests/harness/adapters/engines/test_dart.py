"""DART reaches the errors of its best known configuration, and its accelerations are those of the cases' equations.

Errors are absolute, at steps of 1e-2, 1e-3 and 1e-4 s. Symplectic Euler is order 1, so each step has its own number.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from breadth import tenth
from gnomon.cases import Case, get, names
from gnomon.cases.core.forms import first_order
from gnomon.cases.core.scene import Readings, Scene
from gnomon.harness.adapters.engines.dart import INTEGRATORS, Dart, DartAsShipped, DartTight, World
from gnomon.harness.adapters.engines.scene_run import SceneRun
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.contract.problem import initial_state, problem_of
from on_cases import exact_states, recorded
from scipy.spatial.transform import Rotation

dartpy = pytest.importorskip("dartpy")

STEPS = (1e-2, 1e-3, 1e-4)
TAKEN = [name for name in names() if (form := get(name).scene) is not None and Dart().unsupported(form) is None]
SMOOTH = [name for name in TAKEN if get(name).hybrid is None]


@contextmanager
def running(policy: type[Dart], case: Case, dt: float, times: Floats | None = None) -> Iterator[SceneRun]:
    problem = problem_of(case, Dart.accepts)
    run = policy().prepare(problem if times is None else replace(problem, times=times), dt)
    try:
        yield run
    finally:
        run.close()


def states(policy: type[Dart], case: Case, dt: float, times: Floats | None = None) -> Floats:
    with running(policy, case, dt, times) as run:
        return run(initial_state(case)[None]).states[0]


def errors(policy: type[Dart], case: Case, dt: float) -> Floats:
    return case.metric.distance(states(policy, case, dt), exact_states(case), case.times)


def position_at_the_end(case: Case, dt: float) -> float:
    lengths = [i for i, coordinate in enumerate(case.state) if coordinate.kind == "length"]
    off = states(Dart, case, dt)[-1] - case.sample(case.times[-1:])[0]
    return float(np.linalg.norm(off[lengths]))


def attitude_at_the_end(case: Case, dt: float) -> float:
    """The angle of the rotation between two attitudes, |A - B| = 2 sqrt(2) sin(angle/2) in the Frobenius norm."""
    off = states(Dart, case, dt)[-1, 3:] - case.sample(case.times[-1:])[0, 3:]
    return 2 * float(np.arcsin(min(np.linalg.norm(off) / 8**0.5, 1.0)))


def time_of_the_tenth_impact(case: Case, dt: float) -> float:
    """The engine's impact is where its velocity, interpolated over the step in which it turns upward, is zero."""
    times = np.arange(1, round(1.05 * float(case.span) / dt)) * dt  # late impacts included
    v = states(Dart, case, dt, times)[:, 1]
    turns = np.nonzero((v[:-1] < 0) & (v[1:] > 0))[0]
    if len(turns) < 10:
        return float("inf")
    before = turns[9]
    return abs(float(times[before] + dt * v[before] / (v[before] - v[before + 1]) - case.events()[9].time))


Measure = Callable[[Case, float], float]
PUBLISHED: tuple[tuple[str, str, Measure, tuple[float, ...]], ...] = (
    ("projectile_parabola", "engines", position_at_the_end, (0.049, 0.0049, 0.00049)),
    ("kepler_orbit", "engines", position_at_the_end, (0.31, 0.0032, 3.2e-5)),
    ("euler_top", "engines", attitude_at_the_end, (0.48, 0.047, 0.0047)),
    ("forced_oscillator", "engines", position_at_the_end, (2.3e-3, 2.1e-4, 2.1e-5)),
    ("bouncing_ball", "engines_e1", time_of_the_tenth_impact, (np.inf, 0.096, 0.0095)),
    ("bouncing_ball", "engines_e08", time_of_the_tenth_impact, (np.inf, 0.048, 0.0045)),
    ("block_incline_friction", "engines_stop", position_at_the_end, (0.015, 1.5e-3, 1.5e-4)),
    ("block_incline_friction", "engines_slide", position_at_the_end, (0.012, 1.2e-3, 1.2e-4)),
    ("billiard_ball", "engines", position_at_the_end, (4.3e-3, 4.3e-4, 4.3e-5)),
)


@pytest.mark.parametrize(
    ("name", "label", "measure", "published"), PUBLISHED, ids=[f"{name}-{label}" for name, label, *_ in PUBLISHED]
)
@pytest.mark.parametrize("which", [0, *(pytest.param(i, marks=pytest.mark.slow) for i in (1, 2))])
def test_errors_are_those_published(
    name: str, label: str, measure: Measure, published: tuple[float, ...], which: int
) -> None:
    """Within a factor of 2; in steps of 1e-2 s ten impacts never come."""
    error = measure(get(name, label).rounded(), STEPS[which])
    assert error == published[which] or published[which] / 2 < error < 2 * published[which]


def test_a_block_at_rest_creeps_by_less_than_published() -> None:
    error = position_at_the_end(get("block_incline_friction", "engines_stick").rounded(), 1e-2)
    assert 0 < error < 2.7e-4


def halved(policy: type[Dart], name: str, coarse: int) -> tuple[float, float]:
    """Largest errors with `coarse` steps a sample and with twice as many, over 8 time scales or the case's shorter span."""
    case = get(name, span=min(8 * get(name).time_scale, float(get(name).span))).rounded()
    first, second = (
        float(np.max(errors(policy, case, float(case.times[0]) / parts))) for parts in (coarse, 2 * coarse)
    )
    return first, second


@pytest.mark.parametrize("name", tenth(SMOOTH))
def test_scene_moves_as_its_case(name: str) -> None:
    """The next term of the error is a hundredth of the leading one, of order 1."""
    coarse, fine = halved(Dart, name, 64)
    assert coarse < 0.05
    assert np.log2(coarse / fine) == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("name", tenth([name for name in TAKEN if name not in SMOOTH]))
def test_scene_with_events_converges(name: str) -> None:
    """An event is late by at most a step, so errors are of first order, with a factor between 0 and 1 that looks random."""
    case = get(name).rounded()
    coarse, fine = (float(np.max(errors(Dart, case, float(case.times[0]) / parts))) for parts in (16, 256))
    assert fine < coarse / 4


def after(readings: Readings, accelerations: dict[str, Any], h: float) -> Readings:
    """The readings a time h later, to first order in h."""

    def line(x: Any, v: Any) -> Any:
        return tuple((np.array(x) + h * np.array(v)).tolist())

    bodies = {}
    for name, (place, attitude, velocity, spin) in readings.bodies.items():
        turned = Rotation.from_rotvec(h * np.array(spin)) * Rotation.from_quat(attitude)
        a, alpha = accelerations[name]
        bodies[name] = line(place, velocity), tuple(turned.as_quat().tolist()), line(velocity, a), line(spin, alpha)
    joints = {name: (q + h * rate, rate + h * accelerations[name]) for name, (q, rate) in readings.joints.items()}
    return Readings(joints, bodies)  # type: ignore[arg-type]


CONSTRAINED = {"rope", "driven_axis"}
"""Their forces are impulses of constraints and motors, which are not in accelerations without a step."""


UNCONSTRAINED = [name for name in SMOOTH if not get(name).scene.needs & CONSTRAINED]  # type: ignore[union-attr]


@pytest.mark.parametrize("name", tenth(UNCONSTRAINED))
def test_accelerations_are_those_of_the_equations(name: str) -> None:
    """DART's forward dynamics without a step, against the case's equations, at a state where in general no rate is zero.

    The slope of the state along the motion is a difference of order six: with h = 1e-2 time scales its own error is
    1e-12 of the largest rate, and rounding adds some ulp over h.
    """
    case = get(name).rounded()
    form, parameters = case.scene, tuple(map(float, case.parameter_values()))
    assert form is not None
    state = np.array(list(map(float, case.exact(case.times[2].item()))))
    world = World(dartpy, form, 1e-3, True)
    world.build(form.build((0.0,) * len(state), parameters))
    world.place(form.build(tuple(state.tolist()), parameters))
    world.push(0.0)
    accelerations: dict[str, Any] = {}
    for node in world.nodes.values():
        node.getSkeleton().computeForwardDynamics()
    for body in world.free:
        accelerations[body] = world.nodes[body].getLinearAcceleration(), world.nodes[body].getAngularAcceleration()
    for joint, made in world.joints.items():
        accelerations[joint] = made.getAcceleration(0)
    readings, h = world.read(), 1e-2 * case.fastest_time
    world.close()

    def shifted(steps: int) -> Floats:
        found = np.array(form.observe(after(readings, accelerations, steps * h), parameters)) - state
        angles = [coordinate.kind == "angle" for coordinate in case.state]
        found[angles] = np.remainder(found[angles] + np.pi, 2 * np.pi) - np.pi  # whole turns are ignored
        return found

    slope = sum(weight * (shifted(n) - shifted(-n)) for n, weight in ((1, 45), (2, -9), (3, 1))) / (60 * h)
    equations = next(found for found in map(first_order, case.all_forms()) if found is not None)
    expected = np.array(equations.equations(0.0, tuple(state.tolist()), parameters), dtype=float)
    for group in dict.fromkeys(coordinate.group for coordinate in case.state):
        members = [i for i, coordinate in enumerate(case.state) if coordinate.group == group]
        size = max(np.linalg.norm(expected[members]), np.linalg.norm(state[members]) / case.time_scale)
        assert np.linalg.norm((slope - expected)[members]) <= 1e-9 * size, (group, slope, expected)


def test_nothing_that_no_scene_declares_acts_on_a_joint() -> None:
    case = get("pendulum_simple", "engines").rounded()
    with running(Dart, case, 1e-2) as run:
        (joint,) = run.world.joints.values()
        assert joint.getDampingCoefficient(0) == joint.getSpringStiffness(0) == joint.getCoulombFriction(0) == 0
        assert joint.getVelocityUpperLimit(0) == joint.getForceUpperLimit(0) == np.inf
        assert not joint.areLimitsEnforced()


def test_the_options_recorded_are_the_options_used() -> None:
    case = get("billiard_ball", "engines").rounded()
    with running(Dart, case, 1e-2) as run:
        assert run.options == {
            "deactivation": False, "boxedLcpSolver": "NsgsFrictionSolver", "collisionDetector": "DART"
        }  # fmt: skip
        world = run.world.world
        solver = world.getConstraintSolver()
        assert not world.getDeactivationOptions().mEnabled
        assert isinstance(solver.getBoxedLcpSolver(), dartpy.constraint.NsgsFrictionSolver)
        assert isinstance(world.getCollisionDetector(), dartpy.collision.DARTCollisionDetector)
    with running(DartAsShipped, case, 1e-2) as run:
        assert not run.options


def test_the_line_of_each_option_sets_it() -> None:
    """Whatever is recorded on the scenes of the suite `engines` has a line, and the engine says what the line set."""
    assert not recorded(DartAsShipped)
    options = recorded(DartTight)
    assert recorded(Dart).keys() < options.keys() == DartTight.lines.keys()
    world = dartpy.simulation.World()
    names = {"dartpy": dartpy, "world": world}
    for option, line in DartTight.lines.items():
        exec(line.format(options[option]), names)
    assert not world.getDeactivationOptions().mEnabled
    solver = world.getConstraintSolver()
    assert solver.getBoxedLcpSolver().getType() == options["boxedLcpSolver"]
    assert solver.getCollisionDetector().getType() == options["collisionDetector"].lower()
    chosen = solver.getBoxedLcpSolver().getOptions()
    assert (chosen.maxSweeps, chosen.tolerance) == (options["maxSweeps"], options["tolerance"]) == (1000, 1e-5 / 100)


def test_a_tighter_solver_runs_where_there_are_contacts() -> None:
    """Elsewhere no solver iterates, and the motion would be the same."""
    for name in TAKEN:
        case = get(name).rounded()
        assert case.scene is not None
        scene = case.scene.build(tuple(initial_state(case).tolist()), tuple(map(float, case.parameter_values())))
        ropes = {rope.body for rope in scene.ropes}
        touches = any(contact.body not in ropes for contact in scene.contacts)
        assert (DartTight().unsupported(case.scene) is None) is touches, name


def stopped(policy: type[Dart], degrees: float) -> float:
    """How far a block at 3 m/s in this direction comes on a horizontal plane."""
    case = get("block_incline_friction", "engines_stop").rounded()
    scene = case.scene
    assert scene is not None
    direction = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), 0.0])

    def build(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
        made = scene.build(state, parameters)
        return replace(made, bodies=(replace(made.bodies[0], velocity=tuple((state[1] * direction).tolist())),))

    def distance(readings: Readings, parameters: tuple[float, ...]) -> tuple[float, ...]:
        return float(np.hypot(*readings.bodies["box"][0][:2])), 0.0

    problem = replace(problem_of(case, Dart.accepts), form=replace(scene, build=build, observe=distance))
    run = policy().prepare(problem, 1e-2)
    far = float(run(initial_state(case)[None]).states[0, -1, 0])
    run.close()
    return far


def test_friction_is_the_same_in_every_direction() -> None:
    """v0^2/(2 mu g), less v0 dt/2 (order 1)."""
    for degrees in (0.0, 30.0, 45.0):
        assert stopped(Dart, degrees) == pytest.approx(3.0**2 / (2 * 0.3 * 9.81) - 3.0 * 1e-2 / 2, abs=1e-3)


def test_friction_as_shipped_depends_on_the_direction() -> None:
    assert abs(stopped(DartAsShipped, 45.0) - stopped(DartAsShipped, 0.0)) > 0.1


@pytest.mark.parametrize("policy", INTEGRATORS)
def test_a_call_after_a_reset_builds_nothing(policy: type[Dart], monkeypatch: pytest.MonkeyPatch) -> None:
    case = get("pendulum_simple", "engines").rounded()
    with running(policy, case, 1e-2) as run:
        first = run(initial_state(case)[None]).states
        run.reset()
        monkeypatch.setattr(World, "build", lambda *_: pytest.fail("a world was built inside the call"))
        assert np.array_equal(run(initial_state(case)[None]).states, first)


def after_one_step(name: str, state: tuple[float, ...], parameters: tuple[float, ...]) -> Floats:
    form = get(name).scene
    assert form is not None
    world = World(dartpy, form, 1e-3, True)
    world.build(form.build((0.0,) * len(state), parameters))
    world.place(form.build(state, parameters))
    world.advance(1)
    found = np.array(form.observe(world.read(), parameters))
    world.close()
    return found


@pytest.mark.parametrize(("before", "rebound"), [(0.12, 0.0), (0.13, 0.104), (1.0, 0.8), (150.0, 100.0)])
def test_a_rebound_is_above_a_tenth_and_up_to_a_hundred_metres_a_second(before: float, rebound: float) -> None:
    """Without gravity; 1e-5 of an impulse is lost in DART's constraint force mixing."""
    _, after = after_one_step("bouncing_ball", (-1e-9, -before), (0.0, 0.8))
    assert after == pytest.approx(rebound, rel=3e-5, abs=2e-6)


def test_depth_turns_into_a_velocity_of_at_most_a_millimetre_a_second() -> None:
    for depth in (1e-3, 1e-1):
        _, velocity = after_one_step("bouncing_ball", (-depth, 0.0), (0.0, 0.0))
        assert velocity == pytest.approx(1e-3, rel=2e-5)


def test_what_dart_lacks_has_no_name_in_its_interface() -> None:
    """No joint, shape or constraint of it is a curve, a belt, a string, a blade or something that sticks."""
    known = [name.lower() for part in (dartpy.dynamics, dartpy.constraint, dartpy.collision) for name in dir(part)]
    for word in ("curve", "spline", "belt", "string", "knife", "blade", "adhes", "stick", "rolling"):
        assert not [name for name in known if word in name], word
    surface = {name for name in dir(dartpy.dynamics.DynamicsAspect) if name.startswith("set")}
    assert {"setFrictionCoeff", "setRestitutionCoeff"} <= surface
    assert not {name for name in surface if "tatic" in name or "orsion" in name or "pin" in name}
