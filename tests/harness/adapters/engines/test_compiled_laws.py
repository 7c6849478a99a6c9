"""Compiled laws give the loads of the functions of Python, and say where these are not finite."""

import math
from typing import Any

import pytest
from gnomon.cases.core.scene import Body, Force, Scene, Torque
from gnomon.harness.adapters.engines.compiled_laws import loads_if_compiled
from gnomon.harness.adapters.engines.scene_run import forces_at

BODIES = (Body("sun", 2.0, (0.0, 0.0, 0.0)), Body("moon", 1.0, (1.0, 2.0, 3.0)))
PLACES = {"moon": (3.0, 1.0, 0.0), "sun": (0.0, 0.5, 2.0)}
VELOCITIES = {"moon": (0.25, 0.0, 0.0), "sun": (0.0, 0.0, 0.0)}
APART = (3.0, 0.5, -2.0), (0.25, 0.0, 0.0)
"""Position and velocity of the moon relative to the sun."""


def pull(t: Any, x: Any, v: Any) -> Any:
    r = math.hypot(*x)
    return tuple(-(1 + t) * each / r**3 - 0.1 * rate for each, rate in zip(x, v, strict=True))


def brake(t: Any, attitude: Any, spin: Any) -> Any:
    return tuple(-0.5 * each * attitude[3] for each in spin)


def looked_up(t: Any, x: Any, v: Any) -> Any:
    return {1: 2.0}[int(x[0])], 0.0, 0.0


def scene(law: Any) -> Scene:
    return Scene(
        (0.0,) * 3,
        BODIES,
        forces=(Force("moon", "mutual_force", law, "sun"),),
        torques=(Torque("moon", "drag_torque", brake),),
    )


def test_the_loads_of_a_pair_are_those_of_its_laws() -> None:
    loads = loads_if_compiled(scene(pull))
    assert loads is not None
    assert loads.parts.keys() == {"moon", "sun"}
    for name, (spin, velocity, place, attitude, _, _) in loads.parts.items():
        place[0], place[1], place[2] = PLACES[name]
        velocity[0], spin[2], attitude[0] = VELOCITIES[name][0], 4.0, 0.5
    loads.update(2.0)
    force = pull(2.0, *APART)
    *_, moved, turned = loads.parts["moon"]
    assert moved.tolist() == pytest.approx(force, rel=1e-15)
    assert turned.tolist() == pytest.approx(brake(2.0, (0.0, 0.0, 0.0, 0.5), (0.0, 0.0, 4.0)))
    assert loads.parts["sun"][4].tolist() == pytest.approx([-each for each in force], rel=1e-15)


def test_the_forces_of_a_pair_that_python_computes_are_opposite() -> None:
    """An adapter takes these where a law is not compiled: each body has a force at its own centre of mass."""
    found = list(forces_at(scene(pull), 2.0, lambda body: (PLACES[body], VELOCITIES[body])))
    force = pull(2.0, *APART)
    opposite = tuple(-each for each in force)
    assert found == [("moon", force, PLACES["moon"]), ("sun", opposite, PLACES["sun"])]


def test_a_singular_force_is_an_error_as_in_python() -> None:
    """DART ignores a force that is not finite: the body would go on as if it were free."""
    loads = loads_if_compiled(scene(pull))
    assert loads is not None
    with pytest.raises(FloatingPointError, match=r"at t = 0\.5 are not finite"):
        loads.update(0.5)


def test_a_law_that_only_python_computes_is_left_to_the_adapter() -> None:
    assert loads_if_compiled(scene(looked_up)) is None
    assert loads_if_compiled(Scene((0.0,) * 3, BODIES)) is None
