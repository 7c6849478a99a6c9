"""Newton's solvers converge to the exact motion with order 1 until float32 ends it, and say what they lack.

Kernels are compiled at their first use, for a minute and more a solver: the tests that step a world are slow.
"""

import subprocess
import sys
from importlib.util import find_spec

import numpy as np
import pytest
from gnomon.cases import Case, get, names
from gnomon.cases.core.scene import TOKENS
from gnomon.harness.adapters.engines.newton import (
    INTEGRATORS,
    XPBD,
    Featherstone,
    FeatherstoneAsShipped,
    Newton,
    SemiImplicit,
    SemiImplicitAsShipped,
)
from gnomon.harness.contract.integrator import Floats, Refused
from gnomon.harness.contract.problem import initial_state, problem_of

CONFIGURED = (Featherstone, SemiImplicit, XPBD)
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
    return float(np.max(case.metric.distance(found, case.sample(case.times))))


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


@pytest.mark.slow
@steps_a_world
@pytest.mark.parametrize("policy", CONFIGURED, ids=lambda policy: policy.name)
@pytest.mark.parametrize("name", ["harmonic_oscillator", "projectile_stokes_drag", "spherical_pendulum"])
def test_order_one_above_the_rounding_of_float32(policy: type[Newton], name: str) -> None:
    """A quarter of the step has a quarter of the error, within the next power: 4 to the power of 1 +- 0.25."""
    case = over_eight_time_scales(name)
    ratio = error(policy, case, 4) / error(policy, case, 16)
    assert 4**0.75 < ratio < 4**1.25 if policy is not SemiImplicit else ratio > 4**0.75


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
@pytest.mark.parametrize(
    ("policy", "shipped"), [(Featherstone, FeatherstoneAsShipped), (SemiImplicit, SemiImplicitAsShipped)]
)
def test_as_shipped_rotation_is_damped(policy: type[Newton], shipped: type[Newton]) -> None:
    """The default damping is 0.05/s, so over T seconds the angular velocity falls to exp(-T/20)."""
    case = get("euler_top", "engines").rounded()
    kept, lost = (np.linalg.norm(states(each, case, 1e-2)[-1, :3]) for each in (policy, shipped))
    assert lost < kept * np.exp(-float(case.times[-1]) / 40)


@pytest.mark.slow
@steps_a_world
def test_a_point_mass_on_a_moving_hinge_is_refused_in_coordinates_of_bodies() -> None:
    case = over_eight_time_scales("double_pendulum")
    for policy in (SemiImplicit, XPBD):
        with pytest.raises(Refused, match="does not turn"):
            states(policy, case, float(case.times[0]))
    assert error(Featherstone, case, 16) < error(Featherstone, case, 4) / 3


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
