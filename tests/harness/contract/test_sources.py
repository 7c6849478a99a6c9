"""Compiled equations follow the numbers that they read, in one process and between runs."""

import importlib.util
import linecache
import math
import types
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.forms import FirstOrder, Form, Hybrid, Mode, Transition
from gnomon.harness.contract import sources
from gnomon.harness.contract.integrator import Problem
from gnomon.harness.integrators.gauss.gauss_fast_layout import layout
from gnomon.harness.kernels.equations import kernel
from gnomon.harness.registry import lookup

DECAY = """
RATE = 1.0
def inner(x):
    return RATE * x
def decay(t, state, parameters):
    x, y = state
    return -inner(x), -y
def low(t, state, parameters):
    (x,) = state
    return (x - RATE / 2,)
"""


def module(text: str, name: str = "written") -> types.ModuleType:
    """A module whose functions have a source."""
    path = f"<{name}>"
    linecache.cache[path] = (len(text), None, text.splitlines(keepends=True), path)
    made = types.ModuleType(name)
    exec(compile(text, path, "exec"), made.__dict__)
    return made


def end(form: Form, integrator: str, setting: float, start: tuple[float, ...]) -> float:
    """The first component of the state at t = 1."""
    times = np.arange(1, 65) / 64
    problem = Problem(form, len(start), np.array([]), times, 1.0)
    solution = lookup.find(integrator)[0].prepare(problem, setting)(np.array([start]))
    assert solution.stopped is None
    return float(solution.states[0, -1, 0])


METHODS = (
    pytest.param("gnomon:Gauss 8-stage SIMD", 1e-10, marks=pytest.mark.slow),  # two compilations of 6 s
    ("gnomon:Gauss 4-stage", 1 / 64),
    ("gnomon:DOP853", 1e-10),
    ("gnomon:Taylor", 1e-10),
    ("gnomon:Radau IIA 5", 1e-10),
    ("scipy:DOP853", 1e-10),
    ("scipy:Radau", 1e-8),
    ("heyoka:Taylor", 1e-10),
    ("sksundae:CVODE Adams [native]", 1e-8),
    ("sksundae:CVODE BDF [native]", 1e-8),
    ("sksundae:IDA [native]", 1e-8),
    ("sksundae:CVODE BDF [binding]", 1e-8),
    ("diffrax:Tsit5", 1e-8),
)


@pytest.mark.parametrize(("method", "setting"), METHODS)
def test_a_number_changed_in_the_same_process_is_seen(method: str, setting: float) -> None:
    """x' = -RATE x ends at exp(-RATE): exp(-1) and exp(-2) differ by far more than any tolerance here."""
    if (why := lookup.missing(lookup.find_one(method))) is not None:
        pytest.skip(why)
    equations = module(DECAY)
    form = FirstOrder(equations.decay)
    assert end(form, method, setting, (1.0, 1.0)) == pytest.approx(math.exp(-1), rel=1e-6)
    equations.RATE = 2.0  # type: ignore[attr-defined]
    assert end(form, method, setting, (1.0, 1.0)) == pytest.approx(math.exp(-2), rel=1e-6)


def test_a_number_changed_in_the_same_process_is_seen_by_a_guard() -> None:
    """x' = 1 from 0 is reset to 0 at x = RATE / 2: at t = 1 it is 1/2, and 1/4 with RATE = 3/2."""
    equations = module(DECAY + "\ndef one(t, state, parameters):\n    return (1.0,)\n"
                       "def zero(t, state, parameters):\n    return (0.0,)\n")  # fmt: skip
    mode = Mode("up", equations.one)
    form = Hybrid((mode,), start, (Transition("top", "up", equations.low, 1, equations.zero, "up"),), 1e-9)
    assert end(form, "gnomon:DOP853 [events]", 1e-10, (0.25,)) == pytest.approx(0.25)
    equations.RATE = 1.5  # type: ignore[attr-defined]
    assert end(form, "gnomon:DOP853 [events]", 1e-10, (0.25,)) == pytest.approx(0.5)


def test_the_layout_of_the_fast_gauss_method_follows_the_numbers_of_the_equations() -> None:
    equations = module(DECAY)
    form = FirstOrder(equations.decay)
    before = layout(form, 0, 2)
    assert layout(form, 0, 2) is before
    equations.RATE = 2.0  # type: ignore[attr-defined]
    assert layout(form, 0, 2).text() != before.text()


def start(t: Any, state: Any, parameters: Any) -> str:
    return "up"


def test_numbers_in_closures_and_default_values_belong_to_the_key() -> None:
    calls = []

    @sources.cache_by_content
    def rate(form: FirstOrder) -> float:
        calls.append(form)
        return float(form.equations(0.0, (1.0,), ())[0])

    factor = 1.0

    def closure(t: Any, state: Any, parameters: Any) -> Any:
        return (factor * state[0],)

    def default(t: Any, state: Any, parameters: Any, factor: float = 1.0) -> Any:
        return (factor * state[0],)

    forms = FirstOrder(closure), FirstOrder(default)
    assert [rate(form) for form in (*forms, *forms)] == [1.0] * 4
    assert len(calls) == 2
    factor = 2.0
    default.__defaults__ = (3.0,)
    assert [rate(form) for form in forms] == [2.0, 3.0]


def test_default_values_are_compiled_as_numbers() -> None:
    """The text of a default value is evaluated where the function is defined: elsewhere its names are undefined."""
    equations = module("G = 2.0\ndef fall(t, state, parameters, g=G, h=G * 3):\n    return (g - h,)\n")
    assert kernel(FirstOrder(equations.fall), 0, 1).array(0.0, np.zeros(1), np.zeros(1)).tolist() == [-4.0]
    equations.fall.__defaults__ = ((1, 2), 6.0)
    with pytest.raises(ValueError, match=r"fall has default values .*may have numbers there"):
        kernel(FirstOrder(equations.fall), 0, 1)


class Box:
    """An object whose number may change undetected."""

    rate = 1.0


@pytest.mark.parametrize("held", [Box(), Box, math], ids=["object", "class", "module"])
def test_values_whose_changes_are_not_detected_are_refused(held: Any) -> None:
    equations = module("def decay(t, state, parameters):\n    return (-held.rate * state[0],)\n")
    equations.held = held  # type: ignore[attr-defined]
    with pytest.raises(ValueError, match=r"decay reads held: .* may change unseen"):
        end(FirstOrder(equations.decay), "gnomon:Gauss 8-stage SIMD", 1e-10, (1.0,))


@pytest.mark.parametrize(
    ("before", "after"),
    [([1.0], [2.0]), ({"g": 1}, {"g": 2}), (Fraction(1, 3), Fraction(1, 5)), (np.ones(2), np.zeros(2)), (1, 1.0)],
    ids=["list", "dict", "Fraction", "array", "type"],
)
def test_the_key_of_a_trial_has_all_that_a_function_reads(before: Any, after: Any) -> None:
    """A run repeats a trial whose key has changed: without a number in the key the old result would be kept."""
    equations = module("def decay(t, state, parameters):\n    return held\n")
    equations.held = before  # type: ignore[attr-defined]
    first = sources.of_value(FirstOrder(equations.decay))
    equations.held = after  # type: ignore[attr-defined]
    assert sources.of_value(FirstOrder(equations.decay)) != first


def test_a_module_that_was_edited_and_loaded_again_is_compiled_again(tmp_path: Path) -> None:
    path = tmp_path / "edited.py"
    for rate in ("1.0", "2.50"):
        path.write_text(f"def decay(t, state, parameters):\n    return (-{rate} * state[0],)\n")
        specification = importlib.util.spec_from_file_location("edited", path)
        assert specification is not None
        assert specification.loader is not None
        edited = importlib.util.module_from_spec(specification)
        specification.loader.exec_module(edited)
        assert kernel(FirstOrder(edited.decay), 0, 1).array(0.0, np.ones(1), np.zeros(0)).tolist() == [-float(rate)]
