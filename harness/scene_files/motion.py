"""The exact motion of a scene: at each time the state of the case, and what an engine without error would read."""

import csv
import io
from collections.abc import Sequence

from gnomon.cases.core.case import Case
from gnomon.cases.core.scene import Scene
from gnomon.harness.scene_files.tree import readings_of, word
from gnomon.harness.scene_files.xml import number

PARTS = (
    (("x", "y", "z"), "m"),
    (("qx", "qy", "qz", "qw"), "1"),
    (("vx", "vy", "vz"), "m/s"),
    (("wx", "wy", "wz"), "rad/s"),
)
"""What is read from a body without a scalar joint, as in `Readings`: position, attitude, velocity, angular velocity."""
ATTITUDE, SPIN = 1, 3


def motion_of(case: Case) -> tuple[dict[str, str], str]:
    """The motion as CSV, at the start and at the sample times of the case, and the unit of each column."""
    form = case.scene
    assert form is not None
    parameters = tuple(map(float, case.parameter_values()))
    states = [tuple(map(float, case.initial_state)), *map(tuple, case.sample(case.times).tolist())]
    scenes = [form.build(state, parameters) for state in states]
    parts, first = _parts_read(scenes), scenes[0]
    units = {"t": "s"} | {f"state.{coordinate.name}": coordinate.unit for coordinate in case.state}
    for joints, unit in ((first.hinges, "rad"), (first.sliders, "m")):
        for joint in joints:
            units |= {f"joint.{word(joint.name)}.position": unit, f"joint.{word(joint.name)}.rate": f"{unit}/s"}
    for name, read in parts.items():
        units |= {f"body.{word(name)}.{axis}": PARTS[part][1] for part in read for axis in PARTS[part][0]}
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(units)
    for t, state, scene in zip((0.0, *case.times.tolist()), states, scenes, strict=True):
        readings = readings_of(scene)
        row = [t, *state, *(value for pair in readings.joints.values() for value in pair)]
        row += (value for name, read in parts.items() for part in read for value in readings.bodies[name][part])
        rows.writerow(map(number, row))
    return units, text.getvalue()


def _parts_read(scenes: Sequence[Scene]) -> dict[str, tuple[int, ...]]:
    """The parts of `PARTS` that are known of each body without a scalar joint.

    A point mass has no attitude. The attitude of a body that turns is not known if the state of the case lacks it: then all
    scenes have the same.
    """
    parts: dict[str, tuple[int, ...]] = {}
    inertia = {body.name: body.inertia for body in scenes[0].bodies}
    readings = [readings_of(scene).bodies for scene in scenes]
    for name in readings[0]:
        turns = any(any(each[name][SPIN]) for each in readings)
        still = all(each[name][ATTITUDE] == readings[0][name][ATTITUDE] for each in readings)
        lacking = {ATTITUDE, SPIN} if not any(inertia[name]) else {ATTITUDE} if turns and still else set()
        parts[name] = tuple(part for part in range(len(PARTS)) if part not in lacking)
    return parts
