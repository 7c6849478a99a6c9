"""Newton's solvers converge to the exact motion with order 1 until float32 ends it, and say what they lack.

Kernels are compiled at their first use, for a minute and more a solver: the tests that step a world are slow.
"""

import subprocess
import sys
from importlib.util import find_spec
from typing import Any

import numpy as np
import pytest
from gnomon.cases import Case, get, names
from gnomon.cases.core.scene import TOKENS
from gnomon.harness.adapters.engines.newton import (
    INTEGRATORS,
    VBD,
    XPBD,
    Featherstone,
    FeatherstoneAsShipped,
    Newton,
    SemiImplicit,
    SemiImplicitAsShipped,
    VBDAsShipped,
    XPBDAsShipped,
    XPBDTight,
)
from gnomon.harness.adapters.engines.newton_world import World
from gnomon.harness.adapters.engines.scene_run import SceneRun
from gnomon.harness.contract.integrator import Floats, Refused
from gnomon.harness.contract.problem import initial_state, problem_of
from on_cases import exact_states, recorded

CONFIGURED = (Featherstone, SemiImplicit, XPBD, VBD)
steps_a_world = pytest.mark.skipif(find_spec("newton") is None, reason="newton is not installed")


def over_eight_time_scales(name: str) -> Case:
    case = get(name)
    return get(name, span=min(8 * case.time_scale, float(case.span))).rounded()


def states(policy: type[Newton], case: Case, dt: float) -> Floats:
    run = policy().prepare(problem_of(case, policy.accepts), dt)
    try:
        return run(initial_state(case)[None]).states[0]
    finally:
        run.close()


def error(policy: type[Newton], case: Case, parts: int) -> float:
    """The largest distance from the exact motion, with this number of steps a sample."""
    found = states(policy, case, float(case.times[0]) / parts)
    return float(np.max(case.metric.distance(found, exact_states(case))))


def test_what_is_lacking_is_said_of_tokens() -> None:
    for policy in INTEGRATORS:
        assert policy.lacks.keys() <= TOKENS.keys()
        assert all(policy.lacks.values())


def test_every_scene_runs_or_names_what_is_lacking() -> None:
    for policy in CONFIGURED:
        for name in names():
            if (scene := get(name).scene) is None:
                continue
            answer = policy().unsupported(scene)
            missing = scene.needs & policy.lacks.keys()
            assert (answer is None) == (not missing), name
            assert all(policy.lacks[token] in str(answer) for token in missing), name


def test_only_a_world_imports_the_library() -> None:
    code = (
        "import sys, gnomon.harness.adapters.engines.newton; sys.exit('newton' in sys.modules or 'warp' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_without_the_library_a_run_is_not_prepared(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "warp", None)
    case = get("pendulum_simple", "engines").rounded()
    with pytest.raises(ImportError):
        Featherstone().prepare(problem_of(case, Featherstone.accepts), 1e-2)


RATIOS = [
    *(
        (policy, name)
        for policy in (Featherstone, SemiImplicit, XPBD)
        for name in ("harmonic_oscillator", "projectile_stokes_drag", "lagrange_top")
    ),
    (Featherstone, "double_pendulum"),  # point masses on a hinge that moves
    (Featherstone, "planet_tunnel_rotating"),  # 6e6 m from the origin
    (SemiImplicit, "block_incline_friction"),
    (XPBD, "wedge_block_energy_momentum"),  # a rail that is not along a coordinate
    (XPBD, "sliding_ladder"),
    (XPBD, "swinging_atwood"),
    (XPBD, "central_force_shortened_string"),
    (XPBD, "newtons_cradle"),
    *((VBD, name) for name in ("harmonic_oscillator", "projectile_stokes_drag", "euler_top")),
    *((VBD, name) for name in ("block_incline_friction", "coulomb_friction_oscillator")),
]


@pytest.mark.slow
@steps_a_world
@pytest.mark.parametrize(("policy", "name"), RATIOS, ids=[f"{policy.name}-{name}" for policy, name in RATIOS])
def test_order_one_above_the_rounding_of_float32(policy: type[Newton], name: str) -> None:
    """A quarter of the step has a quarter of the error; the next power of the step changes that by less than a fourth root."""
    case = over_eight_time_scales(name)
    ratio = error(policy, case, 4) / error(policy, case, 16)
    assert 4**0.75 < ratio < 4**1.25


PUBLISHED = [
    (Featherstone, "projectile_parabola", (0.049, 0.0049)),
    (SemiImplicit, "projectile_parabola", (0.049, 0.0049)),
    (XPBD, "projectile_parabola", (0.049, 0.0049)),
    (Featherstone, "euler_top", (0.48, 0.047)),
    (SemiImplicit, "euler_top", (0.48, 0.064)),
    (XPBD, "euler_top", (0.48, 0.067)),
]


@pytest.mark.slow
@steps_a_world
@pytest.mark.parametrize(("policy", "name", "published"), PUBLISHED)
def test_errors_are_those_published(policy: type[Newton], name: str, published: tuple[float, float]) -> None:
    """At the end, with steps of 1e-2 and 1e-3 s: a distance, or the angle between two attitudes."""
    case = get(name, "engines").rounded()
    for dt, expected in zip((1e-2, 1e-3), published, strict=True):
        off = states(policy, case, dt)[-1] - case.sample(case.times[-1:])[0]
        if name == "euler_top":  # |A - B| = 2 sqrt(2) sin(angle/2) in the Frobenius norm
            found = 2 * float(np.arcsin(np.linalg.norm(off[3:]) / 8**0.5))
        else:
            found = float(np.linalg.norm(off[[i for i, x in enumerate(case.state) if x.kind == "length"]]))
        assert expected / 2 < found < 2 * expected


@pytest.mark.slow
@steps_a_world
def test_rounding_of_the_state_ends_convergence_long_before_float32_does() -> None:
    """A second in 1e4 steps rounds positions of 3 m as often, to 1e-7: the error of the method is 9.81 dt / 2 = 4.9e-4 m.

    Start, gravity and time rounded once to float32 would move the end by 1e-6 m.
    """
    case = get("projectile_parabola", "engines").rounded()
    off = states(SemiImplicit, case, 1e-4)[-1, 1] - case.sample(case.times[-1:])[0, 1]
    assert 1e-4 < abs(off + 9.81 * 1e-4 / 2) < 1e-3


@pytest.mark.slow
@steps_a_world
@pytest.mark.parametrize("policy", CONFIGURED, ids=lambda policy: policy.name)
def test_runs_repeat_to_the_bit(policy: type[Newton]) -> None:
    case = get("euler_top", "engines").rounded()
    start = initial_state(case)
    run = policy().prepare(problem_of(case, policy.accepts), 1e-2)
    try:
        first = run(start[None]).states[0]
        pair = run(np.array([start, start])).states
        run.reset()
        again = run(start[None]).states[0]
    finally:
        run.close()
    for other in (pair[0], pair[1], again, states(policy, case, 1e-2)):
        assert np.array_equal(first, other)


@pytest.mark.slow
@steps_a_world
def test_replayed_steps_are_the_steps_of_the_solver() -> None:
    """To the bit, with contacts, with a rope, with forces and with a driven body."""
    names = ("newtons_cradle", "swinging_atwood", "projectile_stokes_drag", "central_force_shortened_string")
    for case in map(over_eight_time_scales, names):
        run = XPBD().prepare(problem_of(case, XPBD.accepts), float(case.times[0]) / 4)
        assert isinstance(run, SceneRun)
        world, ends = run.world, []
        assert isinstance(world, World)
        scene = run.form.build(tuple(initial_state(case).tolist()), run.parameters)
        for replayed in (True, False):
            world.build(scene)
            world.place(scene)
            old, new = world.states
            for step in range(101):
                if replayed:
                    world.advance(1)
                    continue
                world._drive(old, step * world.dt)
                world._push(old, step * world.dt)
                if world.contacts is not None:
                    world.pipeline.collide(old, world.contacts)
                world.solver.step(old, new, world.control, world.contacts, world.dt)
                old, new = new, old
            ends.append((world.states[0] if replayed else old).body_q.numpy().copy())
        assert np.array_equal(*ends), case.name
        run.close()


@pytest.mark.slow
@steps_a_world
def test_the_line_of_each_option_sets_it() -> None:
    """Whatever is recorded on the scenes of the suite `engines` has a line, which the engine takes."""
    import newton

    for policy in (*CONFIGURED, XPBDTight, XPBDAsShipped, VBDAsShipped):
        options = recorded(policy)
        assert options.keys() <= policy.lines.keys()
        names: dict[str, Any] = {"newton": newton, "builder": newton.ModelBuilder(), "mass": 1.0, "body": 0}
        names |= {"inertia": tuple(np.eye(3).flatten()), "model": newton.ModelBuilder().finalize()}
        for option, value in options.items():
            exec(policy.lines[option].format(value), names)
            held = next(
                (names[name] for name in ("solver", "config", "guide") if hasattr(names.get(name), option)), None
            )
            assert held is None or getattr(held, option) == value
        assert names["builder"].body_lock_inertia == [True]


@pytest.mark.slow
@steps_a_world
@pytest.mark.parametrize(("policy", "moves"), [(XPBD, False), (SemiImplicit, True)])
def test_xpbd_sets_slow_speeds_to_zero(policy: type[Newton], moves: bool) -> None:
    """A drop starts from rest, and no step of it adds 1e-4 m/s: it never moves. With the other solver it does."""
    case = over_eight_time_scales("millikan_oil_drop")
    found = states(policy, case, float(case.times[0]) / 4)
    assert bool(np.any(found[:, 1])) is moves
    assert 0 < np.max(np.abs(np.diff(exact_states(case)[:, 1]))) < 1e-4


@pytest.mark.slow
@steps_a_world
def test_xpbd_brakes_rotation_on_a_hinge() -> None:
    """w' = -w^3 dt/2, of order 1: in 1/48 s at 30 rad/s and with steps of 1/768 s a wheel loses 0.37 rad/s."""
    case = over_eight_time_scales("flywheel")
    span, rate = float(case.times[0]), float(initial_state(case)[1])
    for parts in (16, 64):
        dt = span / parts
        lost = case.sample(case.times[:1])[0, 1] - states(XPBD, case, dt)[0, 1]
        assert lost == pytest.approx(rate**3 * dt / 2 * span, rel=0.15)


@pytest.mark.slow
@steps_a_world
def test_vbd_brakes_a_free_rotation() -> None:
    """A step turns a body by 2 atan(w dt/2), from which the rate follows: w' = -w^3 dt/12. Steps of 0.1 rad and more show it."""
    import newton

    builder = newton.ModelBuilder(gravity=(0.0, 0.0, 0.0))
    builder.add_body(mass=1.0, inertia=tuple(np.eye(3).flatten()))
    builder.color()
    model = builder.finalize()
    rate, dt, steps = 30.0, 5e-3, 20
    solver, (old, new) = newton.solvers.SolverVBD(model), (model.state(), model.state())
    spin = old.joint_qd.numpy()
    spin[-1] = rate
    old.joint_qd.assign(spin)
    newton.eval_fk(model, old.joint_q, old.joint_qd, old)
    for _ in range(steps):
        solver.step(old, new, model.control(), None, dt)
        old, new = new, old
    expected = 1 / np.sqrt(1 / rate**2 + dt * steps * dt / 6)  # the exact solution of w' = -w^3 dt/12
    assert old.body_qd.numpy()[0, 5] == pytest.approx(expected, rel=0.005)
    assert expected < 0.97 * rate


@pytest.mark.slow
@steps_a_world
def test_as_shipped_one_solver_damps_rotation_and_one_only_says_so() -> None:
    """The default is 0.05/s: over T seconds rates fall to exp(-T/20). SolverFeatherstone stores the value and never reads it."""
    case = get("euler_top", "engines").rounded()
    kept, lost = (states(each, case, 1e-2)[-1, :3] for each in (SemiImplicit, SemiImplicitAsShipped))
    assert np.linalg.norm(lost) < np.linalg.norm(kept) * np.exp(-float(case.times[-1]) / 40)
    kept, same = (states(each, case, 1e-2)[-1, :3] for each in (Featherstone, FeatherstoneAsShipped))
    assert np.array_equal(kept, same)


@pytest.mark.slow
@steps_a_world
def test_a_point_mass_on_a_moving_hinge_is_refused_in_coordinates_of_bodies() -> None:
    case = over_eight_time_scales("double_pendulum")
    for policy in (SemiImplicit, XPBD):
        with pytest.raises(Refused, match="does not turn"):
            states(policy, case, float(case.times[0]))


@pytest.mark.slow
@steps_a_world
def test_a_man_on_a_cart_is_refused() -> None:
    case = over_eight_time_scales("man_on_cart")
    with pytest.raises(Refused, match="no moving body carries"):
        states(XPBD, case, float(case.times[0]))


@pytest.mark.slow
@steps_a_world
def test_springs_at_contacts_know_no_restitution() -> None:
    """The coefficient of restitution that a shape is given changes nothing in a solver with springs and dampers."""
    import newton

    ends = []
    for restitution in (0.0, 1.0):
        builder = newton.ModelBuilder()
        ball = builder.add_body(xform=(0.0, 0.0, 0.2, 0.0, 0.0, 0.0, 1.0))
        config = newton.ModelBuilder.ShapeConfig(restitution=restitution)
        builder.add_shape_sphere(ball, radius=0.1, cfg=config)
        builder.add_ground_plane(cfg=config)
        model = builder.finalize()
        old, new = model.state(), model.state()
        pipeline = newton.CollisionPipeline(model)
        contacts = pipeline.contacts()
        solver = newton.solvers.SolverSemiImplicit(model)
        for _ in range(300):
            pipeline.collide(old, contacts)
            solver.step(old, new, None, contacts, 1e-3)
            old, new = new, old
        ends.append(old.body_q.numpy())
    assert np.array_equal(*ends)
    assert ends[0][0, 2] < 0.2


@pytest.mark.slow
@steps_a_world
def test_the_solver_of_mujoco_needs_other_packages() -> None:
    import newton

    if find_spec("mujoco_warp") is not None:
        pytest.skip("mujoco-warp is installed: its solver can take part")
    builder = newton.ModelBuilder()
    builder.add_body(mass=1.0)
    with pytest.raises(ImportError, match="MuJoCo backend not installed"):
        newton.solvers.SolverMuJoCo(builder.finalize())
