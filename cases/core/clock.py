"""A form by another clock: one that shows 0 at the start of the motion."""

import dataclasses
import types
from collections.abc import Callable
from typing import Any

from gnomon.cases.core.arithmetic import calling
from gnomon.cases.core.scene import Scene, SceneForm


def from_start(form: Any, t0: float) -> Any:
    """The same form, or any part of one, with t0 + t in place of the time t in all its functions.

    Raises ValueError for a callable that is not a plain function.
    """
    if isinstance(form, SceneForm):
        build = form.build
        return dataclasses.replace(form, build=lambda state, parameters: _scene(build(state, parameters), t0))
    if isinstance(form, types.FunctionType):
        # Functions of the parameters, of a state or of bodies alone, without a time, have one argument.
        known = form.__code__.co_argcount - len(form.__defaults__ or ())
        return form if known == 1 else calling(form, f"{float(t0)!r} + t, state, parameters", "from_start")
    if dataclasses.is_dataclass(form) and not isinstance(form, type):
        values = {field.name: from_start(getattr(form, field.name), t0) for field in dataclasses.fields(form)}
        return dataclasses.replace(form, **values)
    if isinstance(form, tuple):
        return tuple(from_start(part, t0) for part in form)
    if callable(form):
        raise ValueError(f"{form!r} is not a plain function, so that its time cannot be shifted; start at t0 = 0")
    return form


def _scene(scene: Scene, t0: float) -> Scene:
    def later(function: Callable[..., Any] | None) -> Any:
        return None if function is None else lambda t, *state: function(t0 + t, *state)

    def changed(parts: tuple[Any, ...], *laws: str) -> Any:
        return tuple(dataclasses.replace(part, **{law: later(getattr(part, law)) for law in laws}) for part in parts)

    return dataclasses.replace(
        scene,
        forces=changed(scene.forces, "law", "fields"),
        sliders=changed(scene.sliders, "drive"),
        ropes=changed(scene.ropes, "length"),
        torques=changed(scene.torques, "law"),
        impulses=tuple(dataclasses.replace(impulse, time=impulse.time - t0) for impulse in scene.impulses),
    )
