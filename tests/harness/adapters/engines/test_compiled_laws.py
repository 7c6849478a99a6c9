"""Compiled laws give the loads of the functions of Python, and say where these are not finite."""

import math
from typing import Any

import pytest
from gnomon.cases.core.scene import Body, Force, Scene, Torque
from gnomon.harness.adapters.engines.compiled_laws import loads_if_compiled

BODIES = (Body("sun", 2.0, (0.0, 0.0, 0.0)), Body("moon", 1.0, (1.0, 2.0, 3.0)))


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
    places = {"moon": (3.0, 1.0, 0.0), "sun": (0.0, 0.5, 2.0)}
    for name, (spin, velocity, place, attitude, _, _) in loads.parts.items():
        place[0], place[1], place[2] = places[name]
        velocity[0], spin[2], attitude[0] = 0.25 if name == "moon" else 0.0, 4.0, 0.5
    loads.update(2.0)
    force = pull(2.0, (3.0, 0.5, -2.0), (0.25, 0.0, 0.0))
    *_, moved, turned = loads.parts["moon"]
    assert moved.tolist() == pytest.approx(force, rel=1e-15)
    assert turned.tolist() == pytest.approx(brake(2.0, (0.0, 0.0, 0.0, 0.5), (0.0, 0.0, 4.0)))
    assert loads.parts["sun"][4].tolist() == pytest.approx([-each for each in force], rel=1e-15)


def test_a_singular_force_is_an_error_as_in_python() -> None:
    """DART ignores a force that is not finite: the body would go on as if it were free."""
    loads = loads_if_compiled(scene(pull))
    assert loads is not None
    with pytest.raises(FloatingPointError, match=r"at t = 0\.5 are not finite"):
        loads.update(0.5)


def test_a_law_that_only_python_computes_is_left_to_the_adapter() -> None:
    assert loads_if_compiled(scene(looked_up)) is None
    assert loads_if_compiled(Scene((0.0,) * 3, BODIES)) is None
