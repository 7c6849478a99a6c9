"""Families of methods on a problem, and the separation of methods at equal cost."""

import math
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np
import pytest
from gnomon.cases.core.forms import Charged, Hybrid, Separable
from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.integrators.runge_kutta.explicit_pairs import DormandPrince5
from gnomon.harness.integrators.runge_kutta.nystrom import DormandPrinceNystrom6
from gnomon.harness.registry import lookup
from gnomon.harness.registry.families import FAMILIES, family_of, find_family
from gnomon.harness.reporting.report_run import Run
from gnomon.harness.results.equal_error import error_within, time_at
from gnomon.harness.results.families import Sweep, families, separation, sweeps
from planted import Sound
from synthetic import INTEGRATORS, write


def method(name: str, library: str, order: float, first: float, cost: float = 1.0) -> Sweep:
    """A method whose error falls by 10 at each doubling of its cost, from `first` at `cost`."""
    errors = tuple(first * 10.0**-k for k in range(8))
    seconds = tuple(cost * 2.0**k for k in range(8))
    return Sweep(name, library, order, errors, seconds, tuple(100 * value for value in seconds))


def test_every_integrator_is_of_a_family() -> None:
    """A new integrator without one would be in no table of families."""
    own = lookup.own()
    for name, one in own.items():
        write = (
            f"""families = {{ {one.name!r} = "..." }} into [{one.library}] of harness/adapters/libraries.toml"""
            if one.library in LIBRARIES
            else f"its folder into `sources` of a family in harness/registry/families.toml: {type(one).__module__}"
        )
        assert find_family(one) in FAMILIES, (
            f"{name} is of no family: write {write}; the families: {', '.join(FAMILIES)}"
        )
    assert {family_of(name) for name in own} == set(FAMILIES)


def test_a_new_method_is_of_the_family_of_its_form_its_class_or_its_folder() -> None:
    """No file names it."""

    class NewPair(DormandPrince5):
        pass

    class NewNystrom(DormandPrinceNystrom6):
        pass

    class NewSplitting(Sound):
        accepts = (Separable,)

    NewSplitting.__module__ = "gnomon.harness.integrators.geometric.new"
    assert find_family(NewPair()) == "Explicit Runge-Kutta"
    assert find_family(NewNystrom()) == "Nyström"
    for form, family in ((Separable, "Splitting and composition"), (Hybrid, "Event location"), (Charged, "Magnetic")):
        NewSplitting.accepts = (form,)
        assert find_family(NewSplitting()) == family
    assert find_family(Sound()) == ""


@pytest.mark.parametrize(
    ("library", "pattern"), [(name, pattern) for name, one in LIBRARIES.items() for pattern in one.families]
)
def test_every_pattern_of_a_library_names_an_integrator(library: str, pattern: str) -> None:
    """Else it is left from a method that went, or misspelt."""
    names = [one.id.partition(":")[2] for one in lookup.own().values() if one.library == library]
    assert any(fnmatchcase(name, pattern) for name in names), f"[{library}] of harness/adapters/libraries.toml"


def test_the_error_at_a_time_is_the_inverse_of_the_time_at_an_error() -> None:
    errors, seconds = [1e-2, 1e-4, 1e-5, 1e-9], [1.0, 2.0, 3.0, 7.0]
    for target in np.geomspace(9e-3, 2e-9, 20):
        assert error_within(errors, seconds, time_at(errors, seconds, target)[0]) == pytest.approx(target)
    assert error_within(errors, seconds, 0.5) == math.inf
    assert error_within(errors, seconds, 70) == 1e-9


def test_a_lucky_loose_setting_is_credited_with_the_error_of_the_tighter_ones() -> None:
    assert error_within([1e-8, 1e-3, 1e-4], [1.0, 2.0, 4.0], 1.0) == 1e-3


def test_the_median_is_taken_at_the_cost_of_the_best_method() -> None:
    """The best reaches 1e-9 at cost 2**6; there a method that starts at 1 has 1e-6, and one twice as dear 1e-5."""
    of = [
        method("scipy:DOP853", "scipy", 8, 1e-3),
        method("gnomon:Taylor", "gnomon", math.nan, 1.0),
        method("sksundae:CVODE", "sksundae", math.nan, 1.0, 2.0),
    ]
    found = separation(of)
    assert found is not None
    assert (found.best, found.methods, found.libraries) == ("scipy:DOP853", 3, 3)
    assert found.cost == pytest.approx(2**6)
    assert found.median == pytest.approx(1e-6)
    assert found.factor == pytest.approx(1e3)
    calls = separation(of, "calls")
    assert calls is not None
    assert calls.cost == pytest.approx(100 * 2**6)


def test_methods_of_low_order_may_be_the_best_but_are_not_in_the_median() -> None:
    of = [method(f"{library}:x", library, 4, 1.0) for library in ("a", "b", "c")]
    found = separation([*of, method("a:verlet", "a", 2, 1e-4)])
    assert found is not None
    assert found.best == "a:verlet"
    assert found.methods == 3


@pytest.mark.parametrize("axis", ["time", "calls"])
def test_two_libraries_separate_nothing(axis: str) -> None:
    of = [method("a:x", "a", 4, 1.0), method("b:x", "b", 4, 1.0), method("c:verlet", "c", 2, 1.0)]
    assert separation(of, axis) is None


def test_a_method_without_an_answer_has_the_error_1_and_one_without_counts_is_left_out_of_evaluations() -> None:
    of = [method("a:x", "a", 4, 1e-3), Sweep("b:x", "b", 4), Sweep("c:x", "c", 4)]
    found = separation(of)
    assert found is not None
    assert found.median == 1.0
    uncounted = Sweep("d:x", "d", 4, (1e-3, 1e-9), (1.0, 2.0), (math.nan, math.nan))
    calls = separation([*of, uncounted], "calls")
    assert calls is not None
    assert calls.methods == 3


def test_a_family_has_its_fastest_and_its_closest_method() -> None:
    of = [
        method("scipy:RK45", "scipy", 5, 1e-1),
        method("scipy:DOP853", "scipy", 8, 1e-2, 4.0),
        Sweep("gnomon:RK4", "gnomon", 4),
    ]
    (found,) = families(of)
    assert (found.name, found.ran, found.succeed) == ("Explicit Runge-Kutta", 3, 2)
    assert (found.fastest, found.closest) == ("scipy:RK45", "scipy:DOP853")
    assert found.seconds == pytest.approx(2**5)


def test_a_method_that_is_exact_by_construction_is_left_out_and_an_accurate_one_is_not(tmp_path: Path) -> None:
    """The declaration decides, and not the error: IAS15 is accurate on an orbit, and WHFast solves it by its closed form."""
    whfast = ("rebound", "WHFast", "", 2, "step", 1e-7, "")
    timed = Run.read(write(tmp_path / "results.sqlite", integrators=(*INTEGRATORS, whfast))).frame
    kepler = (timed["library"] == "rebound") & (timed["case"] == "kepler_orbit")
    timed.loc[kepler, ["status", "error_max"]] = "ok", 1e-15
    found = {problem: {one.integrator for one in of} for problem, of in sweeps(timed).items()}
    assert "rebound:IAS15" in found["kepler_orbit", ""]
    assert "rebound:WHFast" not in found["kepler_orbit", ""] | found["kepler_orbit", "e09"]
    assert "rebound:WHFast" in found["pendulum_simple", ""]
