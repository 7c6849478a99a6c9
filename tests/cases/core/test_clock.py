"""A form by a clock that shows 0 at the start of the motion."""

from functools import partial
from inspect import getsource
from typing import Any

import pytest
from gnomon.cases.core.clock import from_start
from gnomon.cases.core.forms import FirstOrder, Form, Hybrid, RigidBody, SecondOrder, first_order
from gnomon.cases.core.scene import Body, Force, Rope, Scene, SceneForm, Slider
from timed_forms import FORMS, pull


def at(t: Any, state: Any, parameters: Any = (0,), factor: float = 2.0) -> Any:
    return (factor * t,)


def test_functions_of_time_get_a_later_one_and_others_stay() -> None:
    body = FORMS[RigidBody][0]
    late = from_start(body, 3.25)
    assert late.inertia is body.inertia
    assert late.torque(0.5, (), (0.0,)) == body.torque(3.75, (), (0.0,))


def test_default_values_are_no_arguments() -> None:
    assert from_start(at, 3.0)(1.0, (), ()) == (8.0,)


def test_modes_transitions_and_targets_are_reached() -> None:
    form = FORMS[Hybrid][0]
    late, state = from_start(form, 3.25), (1.0, -1.0)
    (first, _), (before, _) = late.transitions, form.transitions
    assert late.start(0.0, state, (0.0,)) == "late" != form.start(0.0, state, (0.0,))
    assert first.lands(0.0, state, (0.0,)) == "late"
    for name in ("guard", "reset"):
        assert getattr(first, name)(0.5, state, (0.0,)) == getattr(before, name)(3.75, state, (0.0,))
    assert late.modes[0].equations(0.5, state, (0.0,)) == form.modes[0].equations(3.75, state, (0.0,))
    assert (first.name, late.settle) == (before.name, form.settle)


def test_the_structured_form_behind_a_weaker_one_is_shifted_too() -> None:
    """It is compiled in place of the weaker one."""
    weaker = first_order(SecondOrder(pull))
    assert weaker is not None
    late = from_start(weaker, 3.25)
    assert isinstance(late.source, SecondOrder)
    assert late.source.acceleration(0.5, (1.0,), (0.0,)) == pull(3.75, (1.0,), (0.0,))
    assert late.equations(0.5, (1.0, 0.0), (0.0,)) == weaker.equations(3.75, (1.0, 0.0), (0.0,))


def test_a_shifted_function_has_source_text() -> None:
    """Compiled equations are made from it; the same function is shifted once, so its name stays unique."""
    late = from_start(pull, 3.25)
    assert getsource(late).splitlines()[0] == "def pull_from_start(t, state, parameters):"
    assert from_start(pull, 3.25) is late
    assert from_start(pull, 4.0) is not late


def test_laws_of_a_scene() -> None:
    def build(state: Any, parameters: Any) -> Scene:
        force = Force("a", "time_force", lambda t, x, v: (t, 0, 0), fields=lambda t, x: ((t, 0, 0), (0, 0, 0)))
        slider = Slider("s", "a", (0, 0, 0), (1, 0, 0), 0, 0, drive=lambda t: 2 * t)
        rope = Rope("a", (0, 0, 0), lambda t: 1 - t)
        return Scene((0, 0, 0), (Body("a", 1, (0, 0, 0)),), sliders=(slider,), forces=(force,), ropes=(rope,))

    scene = from_start(SceneForm(build, lambda readings, parameters: (), frozenset()), 3.0).build((), ())
    (force,), (slider,), (rope,) = scene.forces, scene.sliders, scene.ropes
    assert slider.drive is not None
    assert force.fields is not None
    assert (force.law(1, (), ()), force.fields(1, ())) == ((4, 0, 0), ((4, 0, 0), (0, 0, 0)))  # type: ignore[arg-type]
    assert (slider.drive(1), rope.length(1)) == (8, -3)


def test_what_cannot_be_shifted_is_named() -> None:
    form: Form = FirstOrder(partial(at, factor=3.0))
    with pytest.raises(
        ValueError, match="is not a plain function, so that its time cannot be shifted; start at t0 = 0"
    ):
        from_start(form, 3.25)
