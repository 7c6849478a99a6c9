"""The systems of a draw: fixed by the seed, of every kind that is spoken of, and right by laws that their source does not use."""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.forms import Constrained, FirstOrder, Hybrid, RigidBody
from gnomon.harness.contract.declared import read_declared
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.own_systems import drawn_equations
from gnomon.harness.own_systems.drawn import FAMILIES, MARGIN, MEMBERS, SEED, TEST, Drawn, draw

DRAWN = draw()
STEP = 1e-5
"""Of central differences, whose error is about 1e-10 of numbers near 1."""
CLOSE = {"rel": 1e-6, "abs": 1e-6}


def family(name: str) -> list[Drawn]:
    return [one for one in DRAWN if one.family == name]


def numbers(one: Drawn) -> list[float]:
    return one.stated.arguments.numbers


def of_function(name: str) -> list[Drawn]:
    """The systems of one function."""
    return [one for one in DRAWN if one.stated.fun is getattr(drawn_equations, name)]


def rates(one: Drawn, start: Sequence[float] | None = None, t: float = 0.3) -> Floats:
    """The values of its function at its start, of accelerations at the places of the start."""
    state, fun = one.start if start is None else start, one.stated.fun
    if one.stated.accelerations:
        return np.array(fun(t, state[: len(state) // 2], *numbers(one)))  # type: ignore[operator]
    if isinstance(fun, FirstOrder):
        return np.array(fun.equations(t, tuple(state), tuple(numbers(one))))
    return np.array(fun(t, state, *numbers(one)))  # type: ignore[operator]


def slope(value: Callable[[Floats], float], place: Sequence[float]) -> Floats:
    """The gradient of a function by central differences."""
    at = np.array(place, dtype=float)
    steps = STEP * np.eye(len(at))
    return np.array([(value(at + h) - value(at - h)) / (2 * STEP) for h in steps])


def test_the_seed_fixes_the_draw() -> None:
    assert [(one.name, one.start, one.span, numbers(one)) for one in draw()] == [
        (one.name, one.start, one.span, numbers(one)) for one in DRAWN
    ]
    assert all(a.start != b.start for a, b in zip(draw(SEED + 1), DRAWN, strict=True) if a.family == "charge")


def test_the_draw_is_as_large_as_is_promised() -> None:
    """At least 72 systems in families of six, half of each in each half, each of a need that is known."""
    assert len(DRAWN) >= 72
    assert len({one.name for one in DRAWN}) == len(DRAWN)
    for name in FAMILIES:
        assert [one.half for one in family(name)] == [MARGIN, TEST] * (MEMBERS // 2)
    assert {one.need for one in DRAWN} <= set(read_declared("results", "advice/needs.toml"))


def test_another_family_changes_no_system(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each family has random numbers of its own."""
    monkeypatch.setitem(FAMILIES, "more", FAMILIES["charge"])
    assert [one.start for one in draw()][: len(DRAWN)] == [one.start for one in DRAWN]


@pytest.mark.parametrize(
    "one", [one for one in DRAWN if one.stated.fun in (drawn_equations.valley, drawn_equations.deep_valley)]
)
def test_a_potential_is_one_and_confines(one: Drawn) -> None:
    p = numbers(one)

    def plane(q: Floats) -> float:
        (x, y), (a, b, c, d, e, f) = q, p
        return float(a * x**2 / 2 + b * y**2 / 2 + c * x**2 * y + d * y**3 + (e * x**2 + f * y**2) ** 2 / 4)

    def space(q: Floats) -> float:
        (x, y, z), (a, b, c, d, e, f, g, h, k, m) = q, p
        cubic = d * x**2 * y + e * y**2 * z + f * z**2 * x + g * x * y * z
        return float((a * x**2 + b * y**2 + c * z**2) / 2 + cubic + (h * x**2 + k * y**2 + m * z**2) ** 2 / 4)

    potential = plane if len(one.start) == 4 else space
    place = one.start[: len(one.start) // 2]
    # V = (e x^2 + f y^2)^2/4 has the gradient (e x^2 + f y^2) e x: the function has it too.
    assert rates(one) == pytest.approx(-slope(potential, place), **CLOSE)
    far = 100 * np.random.default_rng(1).normal(size=(20, len(place)))
    assert all(potential(q) > 0 for q in far)


@pytest.mark.parametrize("one", family("springs"))
def test_a_network_of_springs_has_an_energy(one: Drawn) -> None:
    p, count = numbers(one), len(one.start) // 4

    def energy(q: Floats) -> float:
        places = q.reshape(count, 2)
        found, springs = 0.0, iter(p[4 * count :])
        for i in range(count):
            _, x, y, k = p[4 * i : 4 * i + 4]
            found += k * float(np.sum((places[i] - (x, y)) ** 2)) / 2
            for j in range(i):
                stiffness, rest, cubic = next(springs), next(springs), next(springs)
                stretch = math.dist(places[i], places[j]) - rest
                found += stiffness * stretch**2 / 2 + cubic * stretch**4 / 4
        return found

    masses = np.repeat([p[4 * i] for i in range(count)], 2)
    assert rates(one) * masses == pytest.approx(-slope(energy, one.start[: 2 * count]), **CLOSE)


@pytest.mark.parametrize("one", family("pendulums"))
def test_friction_alone_changes_the_energy_of_a_pendulum(one: Drawn) -> None:
    """Energy from the places and speeds of the masses; the power of friction from the rates of the joints."""
    count, p = len(one.start) // 2, numbers(one)
    masses, lengths, friction, g = p[:count], p[count : 2 * count], p[2 * count : 3 * count], p[-1]

    def energy(y: Floats) -> float:
        angles, turning = y[:count], y[count:]
        across = np.cumsum(lengths * np.cos(angles) * turning)
        up = np.cumsum(lengths * np.sin(angles) * turning)
        heights = -np.cumsum(lengths * np.cos(angles))
        return float(np.sum(masses * (across**2 + up**2) / 2 + g * np.array(masses) * heights))

    joints = np.diff([0.0, *one.start[count:]])
    power = float(slope(energy, one.start) @ rates(one))
    assert power == pytest.approx(-float(np.sum(friction * joints**2)), rel=1e-6, abs=1e-5)


@pytest.mark.parametrize("one", family("centre"))
def test_a_satellite_feels_the_potential_of_its_body(one: Drawn) -> None:
    mu, j2 = [*numbers(one), 0.0][:2]

    def potential(q: Floats) -> float:
        r = float(np.linalg.norm(q))
        flat = j2 * (3 * q[2] ** 2 / r**2 - 1) / (2 * r**2) if len(q) == 3 else 0.0
        return -mu / r * (1 - flat)

    assert rates(one) == pytest.approx(-slope(potential, one.start[: len(one.start) // 2]), **CLOSE)


@pytest.mark.parametrize("one", [one for one in DRAWN if one.stated.fun is drawn_equations.ATTRACTING])
def test_attracting_bodies_rest_as_a_whole(one: Drawn) -> None:
    """The centre of mass is the origin and stays there; two bodies are on an orbit with the eccentricity of their place."""
    masses, bodies = np.array(numbers(one)), np.array(one.start).reshape(-1, 6)
    assert masses @ bodies == pytest.approx(0, abs=1e-12)
    if len(bodies) == 2:
        apart = bodies[1] - bodies[0]
        r, v = np.linalg.norm(apart[:3]), np.linalg.norm(apart[3:])
        length = 1 / (2 / r - v**2 / masses.sum())
        sixth = int(one.name[-1]) - 1
        assert 0.95 * sixth / MEMBERS <= 1 - r / length <= 0.95 * (sixth + 1) / MEMBERS
        assert 0.99 <= one.span / (2 * math.pi * math.sqrt(length**3 / masses.sum())) <= 100.01


@pytest.mark.parametrize("one", family("top"))
def test_a_top_is_a_body_whose_weight_has_a_potential(one: Drawn) -> None:
    """Moments of inertia that a body can have; a rotation at the start; the torque's power is the loss of potential energy."""
    form, p = one.stated.fun, numbers(one)
    assert isinstance(form, RigidBody)
    assert all(2 * p[k] < sum(p[:3]) for k in range(3))
    turn = np.array(one.start[3:]).reshape(3, 3)
    assert turn @ turn.T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(turn) == pytest.approx(1)
    spin = np.array(one.start[:3])
    torque = np.array(form.torque(0.0, one.start, tuple(p)))
    velocity = turn @ np.cross(spin, p[3:6])  # of the centre, in space
    assert torque @ spin == pytest.approx(float(velocity @ p[6:9]), **CLOSE)


@pytest.mark.parametrize("one", family("charge"))
def test_a_magnetic_field_has_no_sources_and_does_no_work(one: Drawn) -> None:
    p, form = tuple(numbers(one)), one.stated.fun
    place, speed = np.array(one.start[:3]), np.array(one.start[3:])

    def field(at: Floats) -> Floats:
        return np.array(form.fields(0.3, tuple(at), p))  # type: ignore[union-attr]

    sources = sum(slope(lambda at, k=k: float(field(at)[3 + k]), place)[k] for k in range(3))  # type: ignore[misc]
    assert sources == pytest.approx(0, abs=1e-8)
    push = rates(one)[3:]
    assert push == pytest.approx(field(place)[:3] + np.cross(speed, field(place)[3:]), **CLOSE)


@pytest.mark.parametrize("one", family("dashpots"))
def test_dashpots_between_masses_keep_their_momentum(one: Drawn) -> None:
    """Without walls and drive. Masses follow from the ratios with the first one: those of the other pairs need not fit."""
    count, p = len(one.start), numbers(one)
    own = [0.0] * count + p[count:-2] + [0.0, 1.0]
    alone = np.array(drawn_equations.dashpots(0.0, one.start, *own))
    level = np.array(drawn_equations.dashpots(0.0, [1.0] * count, *own))
    assert level == pytest.approx(0, abs=1e-9)
    if count == 2:
        ratio = p[3]
        assert ratio * alone[1] + alone[0] == pytest.approx(0, abs=1e-9 * abs(alone[0]))


@pytest.mark.parametrize("one", family("dashpots") + family("thick"))
def test_stiff_systems_decay_a_thousand_times_faster_than_they_move(one: Drawn) -> None:
    at = np.array(one.start)
    jacobian = np.array([slope(lambda y, k=k: float(rates(one, y.tolist())[k]), at) for k in range(len(at))])  # type: ignore[misc]
    found = np.linalg.eigvals(jacobian).real
    assert -found.min() * one.span > 1e3
    assert abs(found).max() > 100 * abs(found).min()


@pytest.mark.parametrize("one", of_function("stiff_springs"))
def test_a_chain_has_an_energy_and_fast_vibrations(one: Drawn) -> None:
    count, p = len(one.start) // 2, numbers(one)

    def energy(q: Floats) -> float:
        stretch = np.diff([0.0, *q, 0.0])
        springs = np.array(p[count:]).reshape(-1, 2)
        return float(np.sum(springs[:, 0] * stretch**2 / 2 + springs[:, 1] * stretch**4 / 4))

    pull = -slope(energy, one.start[:count])
    assert rates(one) * p[:count] == pytest.approx(pull, rel=1e-5, abs=1e-5 * max(abs(pull)))


@pytest.mark.parametrize("one", of_function("spring_pendulum"))
def test_a_spring_pendulum_has_an_energy(one: Drawn) -> None:
    stiffness, length, g = numbers(one)

    def energy(q: Floats) -> float:
        return float(stiffness / length * (np.linalg.norm(q) - length) ** 2 * length / 2 + g * q[2])

    pull = -slope(energy, one.start[:3])
    assert rates(one) == pytest.approx(pull, rel=1e-4, abs=1e-3)


@pytest.mark.parametrize("one", family("ball"))
def test_lift_does_no_work_in_the_wind(one: Drawn) -> None:
    g, k, _, wind, shear, _ = numbers(one)
    _, h, _, u, v, w = one.start
    own = np.array([u - wind - shear * h, v, w])
    push = np.add(rates(one)[3:], (0, g, 0))
    assert push @ own == pytest.approx(-k * np.linalg.norm(own) ** 3)


@pytest.mark.parametrize("one", family("surface"))
def test_a_constraint_holds_along_the_motion(one: Drawn) -> None:
    """Its gradient is its derivative, its rate vanishes at the start, and the equations let its second derivative vanish."""
    form, p = one.stated.fun, tuple(numbers(one))
    assert isinstance(form, Constrained)
    half = len(one.start) // 2
    place, speed = one.start[:half], np.array(one.start[half:])

    def gap(q: Floats) -> float:
        return float(form.constraint(0.0, tuple(q.tolist()), p)[0])

    def rate(y: Floats) -> float:
        return float(np.array(form.gradient(0.0, tuple(y[:half].tolist()), p)) @ y[half:])

    gradient = np.array(form.gradient(0.0, place, p))
    assert gradient == pytest.approx(slope(gap, place), **CLOSE)
    assert rate(np.array(one.start)) == pytest.approx(0, abs=1e-12)
    along = rates(one)
    assert along[:half] == pytest.approx(speed)
    assert slope(rate, one.start) @ along == pytest.approx(0, abs=1e-5)
    reaction = along[half:] - np.array(form.force(0.0, place, p))
    assert np.linalg.norm(np.cross(reaction[:3], gradient[:3])) == pytest.approx(0, abs=1e-9 * np.linalg.norm(reaction))


@pytest.mark.parametrize("one", family("walls") + family("belt"))
def test_each_transition_leaves_its_guard_at_zero(one: Drawn) -> None:
    """A reset changes speeds and no place, so that a body leaves a wall from where it met it; it gains no energy."""
    form, p = one.stated.fun, tuple(numbers(one))
    assert isinstance(form, Hybrid)
    dimension = len(one.start) // 2
    for transition in form.transitions:
        after = transition.reset(0.3, one.start, p)
        assert tuple(after[:dimension]) == one.start[:dimension]
        assert sum(x * x for x in after[dimension:]) <= sum(x * x for x in one.start[dimension:])
        assert transition.lands(0.3, after, p) in {mode.name for mode in form.modes}


def test_static_friction_is_the_larger_one() -> None:
    for one in family("belt"):
        *_, kinetic, static = numbers(one)
        assert 0 < kinetic < static


@pytest.mark.parametrize("one", family("long"))
def test_a_long_motion_has_hundreds_of_periods_in_a_single_well(one: Drawn) -> None:
    a, b, c = numbers(one)
    assert b * b < 4 * a * c, "another equilibrium"
    assert one.span * math.sqrt(a) / (2 * math.pi) >= 300


def test_the_equations_are_plain_functions_of_their_module() -> None:
    """A process that runs them finds them by their names."""
    for one in DRAWN:
        fun: Any = one.stated.fun
        assert any(value is fun for value in vars(drawn_equations).values()), one.name
