"""Every scene starts in the state of its case, and an engine's readings of that start give the same state."""

from functools import cache

import numpy as np
import pytest
from breadth import cheap_and_tenth
from gnomon.cases import Case, case_class, names
from gnomon.cases.core.scene import Readings, Scene
from gnomon.cases.scenes.attitude import matrix, quaternion

EPS = np.finfo(float).eps
WITHOUT = {("lagrange_top_attitude", "homoclinic")}
"""A variant whose attitude is not a rotation, which no engine takes. The others have a scene if the default has one."""
VARIANTS = [
    (name, label)
    for name in names()
    if case_class(name)().scene is not None
    for label in (None, *(v.name for v in case_class(name).variants))
    if (name, label) not in WITHOUT
]


@cache
def rounded(name: str, label: str | None = None) -> Case:
    """The case of a scene, which several tests use."""
    return case_class(name)(label).rounded()


def start(scene: Scene) -> Readings:
    """The readings of an engine without any error before the first step."""
    joints = {hinge.name: (hinge.angle, hinge.rate) for hinge in scene.hinges}
    joints |= {slider.name: (slider.position, slider.rate) for slider in scene.sliders}
    joints |= {guide.name: (guide.coordinate, guide.rate) for guide in scene.guides}
    bodies = {b.name: (b.position, b.quaternion, b.velocity, b.angular_velocity) for b in scene.bodies}
    return Readings(joints, bodies)


@pytest.mark.parametrize(("name", "label"), VARIANTS)
def test_start_is_read_back(name: str, label: str | None) -> None:
    case = rounded(name, label)
    form = case.scene
    assert form is not None
    state = tuple(map(float, case.initial_state))
    parameters = tuple(map(float, case.parameter_values()))
    scene = form.build(state, parameters)
    found = np.array(form.observe(start(scene), parameters))
    rates = [x for body in scene.bodies for x in (*body.velocity, *body.angular_velocity)]
    # Conversions (an attitude to a quaternion and back, a height and the ball's radius) round the state and the rates
    # a few times.
    assert np.max(np.abs(found - state)) <= 8 * EPS * max(1.0, *np.abs([*state, *rates]))


@pytest.mark.parametrize("name", cheap_and_tenth(sorted({name for name, _ in VARIANTS})))
def test_a_moving_state_is_read_back(name: str) -> None:
    """At the third sample, where rates are not zero: it shows wrong signs and sequences. Whole turns are ignored.

    A tenth of the cases whose motion is expensive in `make test`.
    """
    case = rounded(name)
    form = case.scene
    assert form is not None
    state = tuple(map(float, case.exact(case.times[2].item())))
    parameters = tuple(map(float, case.parameter_values()))
    scene = form.build(state, parameters)
    found = np.array(form.observe(start(scene), parameters))
    rates = [x for body in scene.bodies for x in (*body.velocity, *body.angular_velocity)]
    turn = np.array([2 * np.pi if c.kind == "angle" else np.inf for c in case.state])
    off = found - state
    off -= np.where(np.isfinite(turn), 2 * np.pi * np.round(off / turn), 0.0)
    # as above, and for an angle the rounding of its turns
    assert np.max(np.abs(off)) <= 16 * EPS * max(1.0, *np.abs([*state, *rates]))


@pytest.mark.parametrize(("name", "label"), VARIANTS)
def test_a_scene_consists_of_the_same_things_in_every_state(name: str, label: str | None) -> None:
    case = rounded(name, label)
    form = case.scene
    assert form is not None
    parameters = tuple(map(float, case.parameter_values()))
    here, nowhere = (
        form.build(state, parameters) for state in (tuple(map(float, case.initial_state)), (0.0,) * len(case.state))
    )
    assert here.gravity == nowhere.gravity
    assert here.contacts == nowhere.contacts
    assert [(b.name, b.mass, b.inertia, b.radius, b.half_extents) for b in here.bodies] == [
        (b.name, b.mass, b.inertia, b.radius, b.half_extents) for b in nowhere.bodies
    ]
    assert [(h.name, h.body, h.anchor, h.axis, h.arm) for h in here.hinges] == [
        (h.name, h.body, h.anchor, h.axis, h.arm) for h in nowhere.hinges
    ]
    assert [(f.body, f.token) for f in here.forces] == [(f.body, f.token) for f in nowhere.forces]
    assert {force.token for force in here.forces} <= form.needs


@pytest.mark.parametrize("name", sorted({name for name, _ in VARIANTS}))
def test_forces_depend_on_what_their_tokens_say(name: str) -> None:
    """No force depends on velocity or time without the token; with a token, some force does for some variant."""
    random, seen, declared = np.random.default_rng(5), set(), set()
    for case in (rounded(name, label) for each, label in VARIANTS if each == name):
        assert case.scene is not None
        declared |= case.scene.needs
        scene = case.scene.build(tuple(map(float, case.initial_state)), tuple(map(float, case.parameter_values())))
        for force in scene.forces:
            for _ in range(8):
                place, velocity, other = (tuple(v) for v in random.uniform(0.3, 1.5, (3, 3)))
                t = random.uniform(0, float(case.span))
                here = force.law(t, place, velocity)
                found = {
                    token
                    for token, there in (
                        ("velocity_force", force.law(t, place, other)),
                        ("time_force", force.law(0.37 * t, place, velocity)),
                    )
                    if there != here
                }
                assert found <= case.scene.needs
                seen |= found
    # Random times miss a short pulse.
    pulses = {"time_force"} if name == "impulse_instantaneous" else set()
    assert declared & {"velocity_force", "time_force"} <= seen | pulses


def test_quaternions_and_matrices_agree_in_all_four_branches() -> None:
    random = np.random.default_rng(1)
    axes = np.eye(4)
    for q in (*axes, *random.normal(size=(200, 4))):
        q = q / np.linalg.norm(q)
        found = np.array(quaternion(matrix(tuple(q))))
        # The largest component is at least 1/2, so nothing is divided by less than that.
        assert min(np.max(np.abs(found - q)), np.max(np.abs(found + q))) <= 8 * EPS
        r = np.array(matrix(tuple(q))).reshape(3, 3)
        assert np.max(np.abs(r @ r.T - np.eye(3))) <= 8 * EPS
        assert np.linalg.det(r) == pytest.approx(1.0, abs=8 * EPS)
