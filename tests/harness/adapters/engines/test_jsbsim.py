"""JSBSim's integrators have their measured orders, reach the errors of their best known set-up, and see forces in time.

The multistep methods start with copies of the first derivative, so that all orders end at 2.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from gnomon.cases import Case, get, names
from gnomon.cases.core.scene import IDENTITY, TOKENS, Body, Scene, Torque
from gnomon.harness.adapters.engines import jsbsim_world
from gnomon.harness.adapters.engines.jsbsim import (
    INTEGRATORS,
    Jsbsim,
    JsbsimAB2,
    JsbsimAB3,
    JsbsimAB4,
    JsbsimAB5,
    JsbsimBuss2,
    JsbsimEuler,
    JsbsimLinearised,
    JsbsimTrapezoidal,
)
from gnomon.harness.adapters.engines.jsbsim_files import body_file, element, moment, rotation
from gnomon.harness.adapters.engines.jsbsim_world import attitude
from gnomon.harness.contract.integrator import Refused
from gnomon.harness.contract.problem import initial_state, problem_of
from gnomon.harness.kernels.traced import Trace
from on_cases import exact_states

jsbsim = pytest.importorskip("jsbsim")

Policy = type[Jsbsim]
RUN = [
    (policy, name)
    for policy in INTEGRATORS
    for name in names()
    if (scene := get(name).scene) is not None and policy().unsupported(scene) is None
]
QUICK = {
    "projectile_stokes_drag",
    "charge_in_E_and_B",
    "euler_top",
    "rigid_body_stokes_medium_torque",
    "dumbbell_free_flight",
}
RAPID = {"kepler_orbit", "central_force_fifth_power"}
"""Motions that pass a centre of attraction, where the steps that a test can afford are not yet small."""
HIGH = (JsbsimAB3, JsbsimAB4, JsbsimAB5)
"""At large steps the error of their formulas is above that of their start."""


def error_over_the_path(policy: Policy, case: Case, dt: float) -> float:
    run = policy().prepare(problem_of(case, policy.accepts), dt)
    found = run(initial_state(case)[None]).states[0]
    run.close()
    return float(np.max(case.metric.distance(found, exact_states(case))))


def at_the_end(policy: Policy, case: Case, dt: float) -> float:
    """The distance, or for a free body the angle between attitudes, |A - B| = 2 sqrt(2) sin(angle/2)."""
    run = policy().prepare(problem_of(case, policy.accepts), dt)
    off = run(initial_state(case)[None]).states[0, -1] - case.sample(case.times[-1:])[0]
    run.close()
    if case.name == "euler_top":
        return 2 * float(np.arcsin(min(np.linalg.norm(off[3:]) / 8**0.5, 1.0)))
    return float(
        np.linalg.norm([x for x, coordinate in zip(off, case.state, strict=True) if coordinate.kind == "length"])
    )


PUBLISHED: tuple[tuple[Policy, str, tuple[float, ...]], ...] = (
    (Jsbsim, "euler_top", (0.48, 0.047)),
    (Jsbsim, "kepler_orbit", (0.072, 1.1e-4)),
    (Jsbsim, "projectile_parabola", (8e-5, 8e-7)),
    (JsbsimEuler, "euler_top", (0.48, 0.047)),
    (JsbsimEuler, "kepler_orbit", (2.4, 2.6)),
    (JsbsimEuler, "projectile_parabola", (0.049, 0.0049)),
    (JsbsimTrapezoidal, "euler_top", (0.96, 0.094)),
    (JsbsimTrapezoidal, "kepler_orbit", (10.0, 3.3)),
    (JsbsimTrapezoidal, "projectile_parabola", (0.098, 0.0098)),
    (JsbsimAB2, "euler_top", (4.8e-3, 4.8e-5)),
    (JsbsimAB2, "kepler_orbit", (0.64, 0.0037)),
    (JsbsimAB2, "projectile_parabola", (4.9e-4, 4.9e-6)),
    (JsbsimAB3, "euler_top", (1e-4, 1.1e-7)),
    (JsbsimAB3, "kepler_orbit", (0.24, 0.0026)),
    (JsbsimAB3, "projectile_parabola", (8e-5, 8e-7)),
    (JsbsimAB4, "euler_top", (5.7e-6, 5.9e-8)),
    (JsbsimAB4, "kepler_orbit", (0.30, 0.0032)),
    (JsbsimAB5, "euler_top", (5.9e-6, 5.9e-8)),
    (JsbsimAB5, "kepler_orbit", (0.31, 0.0032)),
    (JsbsimBuss2, "euler_top", (1.4e-3, 1.4e-5)),
    (JsbsimLinearised, "euler_top", (1.8e-3, 1.7e-5)),
)


@pytest.mark.parametrize("step", [0, pytest.param(1, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("policy", "name", "published"), PUBLISHED, ids=[f"{p.name}-{n}" for p, n, _ in PUBLISHED])
def test_errors_are_those_published(policy: Policy, name: str, published: tuple[float, ...], step: int) -> None:
    """To the digits that are given, not only within a factor: these engines have no solver that depends on chance."""
    error = at_the_end(policy, get(name, "engines").rounded(), (1e-2, 1e-3)[step])
    assert error == pytest.approx(published[step], rel=0.06)


def order_of_a_scene(policy: Policy, name: str) -> int:
    """The declared order; with the default integrators attitudes are of first order, the rest of second."""
    if policy.order is not None:
        return policy.order
    scene = get(name).scene
    return 1 if scene is not None and "gyroscopic" in scene.needs else 2


@pytest.mark.parametrize(
    ("policy", "name"),
    [pytest.param(p, n, marks=[] if p in (Jsbsim, JsbsimAB2) and n in QUICK else pytest.mark.slow) for p, n in RUN],
)
def test_orders(policy: Policy, name: str) -> None:
    """Over 8 time scales; the next term of the error is some hundredths of the leading one."""
    case = get(name, span=min(8 * get(name).time_scale, float(get(name).span))).rounded()
    parts = 512 if policy in HIGH or name in RAPID else 64
    coarse, fine = (error_over_the_path(policy, case, float(case.times[0]) / n) for n in (parts, 2 * parts))
    if name in RAPID:
        assert fine < coarse / 1.3
    else:
        assert np.log2(coarse / fine) == pytest.approx(order_of_a_scene(policy, name), abs=0.05)


def test_a_token_is_run_or_lacking() -> None:
    assert set(Jsbsim.lacks) <= set(TOKENS)
    assert set(TOKENS) - set(Jsbsim.lacks) == {
        "gyroscopic", "position_force", "velocity_force", "time_force", "torque", "drag_torque",
    }  # fmt: skip


@pytest.mark.parametrize("name", sorted({name for _, name in RUN}))
def test_mass_and_moments_are_those_of_the_scene(name: str) -> None:
    """A mass that is given in slugs is 2.15e-7 too small, which would be the floor of all errors with forces."""
    case = get(name).rounded()
    run = Jsbsim().prepare(problem_of(case, Jsbsim.accepts), float(case.times[0]) / 64)
    run(initial_state(case)[None])
    (body,) = run.at_zero.bodies  # type: ignore[attr-defined]
    fdm = run.world.fdm  # type: ignore[attr-defined]
    assert fdm["inertia/mass-slugs"] == pytest.approx(body.mass, rel=1e-15)
    if any(body.inertia):
        assert [fdm[f"inertia/{axis}-slugs_ft2"] for axis in ("ixx", "iyy", "izz")] == list(body.inertia)
    run.close()


@pytest.mark.parametrize("policy", INTEGRATORS)
def test_options_are_the_integrators_that_differ_from_the_defaults(policy: Policy) -> None:
    """Read after a run: `run_ic` keeps them."""
    case = get("euler_top").rounded()
    run = policy().prepare(problem_of(case, policy.accepts), float(case.times[0]))
    run(initial_state(case)[None])
    defaults = dict(zip(jsbsim_world.SELECTORS, (1, 3, 1, 4), strict=True))
    held = {name: run.world.fdm[name] for name in defaults}  # type: ignore[attr-defined]
    run.close()
    assert tuple(held.values()) == (policy.methods or (1, 3, 1, 4))
    assert run.options == {name: value for name, value in held.items() if value != defaults[name]}


@pytest.mark.parametrize(
    "function", ["sin", "cos", "tan", "asin", "acos", "atan", "sqrt", "exp", "log", "atan2", "hypot", "power", "neg"]
)
def test_functions_are_those_of_python(function: str) -> None:
    """A constant force of this value at a known place gives its velocity after the first step, with Euler's method."""
    scene = Scene((0.0, 0.0, 0.0), (Body("b", 1.0, (0.0, 0.0, 0.0), (0.25, 0.5, 0.75)),))
    laws: dict[str, Callable[..., float]] = {
        "power": lambda trace, x, y: x**y,
        "neg": lambda trace, x, y: -x,
        "atan2": lambda trace, x, y: trace["atan2"](x, y),
        "hypot": lambda trace, x, y: trace["hypot"](x, y),
    }
    law = laws.get(function, lambda trace, x, y: trace[function](x))
    text = element(
        law((t := Trace(2, 0)).functions, *t.state), {"y[0]": "<value>0.25</value>", "y[1]": "<value>0.5</value>"}
    )
    expected = law({name: getattr(math, name) for name in (function,) if hasattr(math, name)}, 0.25, 0.5)
    pushed = body_file(scene, scene.bodies[0]).replace(
        "<external_reactions>",
        '<external_reactions><force name="f" frame="INERTIAL"><location unit="FT"><x>0</x><y>0</y><z>0</z></location>'
        f"<direction><x>0</x><y>1</y><z>0</z></direction><function><sum>{text}<value>0</value></sum></function></force>",
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(jsbsim_world, "body_file", lambda *_: pushed)
        world = jsbsim_world.World(jsbsim, 1.0, (1, 1, 1, 1))
        world.build(scene)
        world.place(scene)
        world.advance(1)
        velocity = world.read().bodies["b"][2]
        world.close()
    assert velocity == pytest.approx((0.0, expected, 0.0), abs=1e-15)


def test_torques_are_of_the_body_or_of_space() -> None:
    def frame(law: Callable[..., tuple[float, float, float]]) -> str:
        return moment(Torque("b", "torque", law))[0]

    assert frame(lambda t, attitude, spin: (0.0, t, 2.0)) == "INERTIAL"
    assert frame(lambda t, attitude, spin: (-spin[0], -spin[1], -spin[2])) == "BODY"
    with pytest.raises(Refused, match="attitude"):
        frame(lambda t, attitude, spin: (attitude[0], 0.0, 0.0))


def test_attitudes_return_from_their_matrices() -> None:
    for q in np.random.default_rng(0).normal(size=(50, 4)):
        q /= np.linalg.norm(q)
        found = np.array(attitude(rotation(tuple(q))))
        assert found * np.sign(found @ q) == pytest.approx(q, abs=1e-15)
    assert attitude(rotation(IDENTITY)) == IDENTITY


def test_two_bodies_are_refused() -> None:
    case = get("exploding_projectile").rounded()
    assert "one body" in (Jsbsim().unsupported(get("two_body").scene) or "")  # type: ignore[arg-type]
    form = replace(case.scene, needs=frozenset())  # type: ignore[type-var]
    with pytest.raises(Refused, match="one body"):
        Jsbsim().prepare(replace(problem_of(case, Jsbsim.accepts), form=form), float(case.times[0]))  # type: ignore[arg-type]


def test_nothing_is_printed_and_no_file_is_left(
    capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    case = get("projectile_stokes_drag").rounded()
    run = JsbsimAB2().prepare(problem_of(case, JsbsimAB2.accepts), float(case.times[0]))
    run(initial_state(case)[None])
    run.close()
    printed = capfd.readouterr()
    assert (printed.out, printed.err) == ("", "")
    assert not list(tmp_path.iterdir())


def test_runs_repeat_to_the_bit() -> None:
    case = get("rigid_body_stokes_medium_falling").rounded()
    run = JsbsimAB3().prepare(problem_of(case, JsbsimAB3.accepts), float(case.times[0]) / 4)
    start = initial_state(case)
    both = run(np.array([start, start])).states
    run.close()
    assert np.array_equal(both[0], both[1])
