"""A picture of an exact motion that moves: a pendulum, bodies in a plane, or a coordinate over time."""

from typing import Any

import numpy as np
from gnomon.cases import Case
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.measuring.drawn_motion import curve, planes
from markupsafe import Markup, escape

FRAMES = 60
SECONDS = 6.0
"""Seconds that one passage takes on the page."""
SCALES = 12.0
"""The largest number of time scales in a passage: more would be too fast to follow."""
SIZE, MIDDLE, REACH = 220.0, 110.0, 92.0
"""Pixels of the picture, of its middle, and from there to the farthest point."""
PENDULUM = "pendulum_simple"
"""The case whose first coordinate is the angle of a rod from the vertical."""


def moving(case: Case) -> Markup:
    """The picture as SVG, with its movement as CSS, which stops where readers prefer no motion."""
    times, states = curve(case)
    last = min(times[-1], SCALES * case.time_scale)
    at = np.linspace(0.0, last, FRAMES)
    values = np.column_stack([np.interp(at, times, column) for column in states.T])
    inside = times <= last
    if case.name == PENDULUM:
        body = _pendulum(values[:, 0])
    elif bodies := planes(case):
        body = _orbits(
            [values[:, list(pair)] for pair in bodies.values()], [states[inside][:, list(p)] for p in bodies.values()]
        )
    else:
        body = _trace(at, values[:, 0], times[inside], states[inside, 0])
    label = f"The exact motion of the case {case.name}, moving"
    return Markup(
        f'<svg class="moving" viewBox="0 0 {SIZE:.0f} {SIZE:.0f}" role="img" aria-label="{escape(label)}">{body}</svg>'
    )


def _pendulum(angles: Floats) -> str:
    turns = [f"rotate({-np.degrees(angle):.1f}deg)" for angle in angles]
    trail = "".join(
        f'<circle cx="{MIDDLE + 78 * np.sin(a):.0f}" cy="{MIDDLE + 78 * np.cos(a):.0f}" r="2" class="trail"/>'
        for a in angles[::2]
    )
    rod = f'<path d="M{MIDDLE:.0f} {MIDDLE:.0f}V188"/><circle cx="{MIDDLE:.0f}" cy="188" r="10"/>'
    return f'{trail}{_frames("m0", turns)}<g class="moves" style="animation-name:m0;transform-origin:{MIDDLE:.0f}px {MIDDLE:.0f}px">{rod}</g>'


def _orbits(frames: list[Floats], paths: list[Floats]) -> str:
    every = np.concatenate([*frames, *paths])
    middle, half = (every.max(axis=0) + every.min(axis=0)) / 2, float(np.ptp(every, axis=0).max()) / 2 or 1.0
    return "".join(
        _move_disc(
            f"m{k}",
            MIDDLE + (path - middle) * [REACH, -REACH] / half,
            MIDDLE + (places - middle) * [REACH, -REACH] / half,
        )
        for k, (places, path) in enumerate(zip(frames, paths, strict=True))
    )


def _trace(at: Floats, values: Floats, times: Floats, states: Floats) -> str:
    middle, half = (states.max() + states.min()) / 2, float(np.ptp(states)) / 2 or 1.0

    def placed(t: Floats, y: Floats) -> Any:
        return np.column_stack([MIDDLE + REACH * (2 * t / at[-1] - 1), MIDDLE - 0.7 * REACH * (y - middle) / half])

    return _move_disc("m0", placed(times, states), placed(at, values))


def _move_disc(name: str, path: Any, places: Any) -> str:
    """A path, and a disc that moves along `places`."""
    line = "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in path[:: max(len(path) // 400, 1)])
    steps = [f"translate({x:.1f}px,{y:.1f}px)" for x, y in places]
    return f'<path class="trail" d="{line}"/>{_frames(name, steps)}<circle class="moves" r="8" style="animation-name:{name}"/>'


def _frames(name: str, transforms: list[str]) -> str:
    steps = "".join(f"{100 * k / (len(transforms) - 1):.1f}%{{transform:{text}}}" for k, text in enumerate(transforms))
    return f"<style>@keyframes {name}{{{steps}}}</style>"
