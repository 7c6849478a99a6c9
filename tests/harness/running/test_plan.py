"""Pairs, sweeps and keys of a plan."""

import importlib
import itertools
import sys
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import planted
import pytest
from breadth import cheap_and_tenth
from gnomon.cases.core.forms import Separable
from gnomon.cases.core.numbers import Domain
from gnomon.harness.adapters.engines.scene_run import SceneIntegrator
from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.contract.integrator import Steps, Tolerance
from gnomon.harness.contract.problem import problem_of
from gnomon.harness.measuring.perturbed_starts import perturb_start, probe_state
from gnomon.harness.measuring.reference_solution import CaseSpec, reference_solution
from gnomon.harness.measuring.score import Scorer
from gnomon.harness.measuring.settings import FEWEST, sweep_settings
from gnomon.harness.registry import lookup, references, selection
from gnomon.harness.registry.representatives import representatives
from gnomon.harness.running import plan
from gnomon.reference.storage import import_closure

from gnomon import cases

CASE = cases.get("pendulum_simple").rounded()


def trials(case: cases.Case, integrator: Any) -> Any:
    (series,) = plan.list_series([(case, "")], [integrator], formulations=False)
    scorer = Scorer(case, None, reference_solution(CaseSpec.of(case)))
    return series.trials(scorer.problem(series.form))


def settings(sweep: Tolerance | Steps, interval: float = 1.0) -> tuple[float, ...]:
    """The settings of an integrator with this sweep, on a problem whose time scale is 1."""
    swept = type("Swept", (planted.Sound,), {"sweep": sweep})()
    problem = problem_of(CASE, swept.accepts)
    return sweep_settings(swept, CASE, replace(problem, times=interval * np.arange(1, 65), time_scale=1.0))


def test_steps_divide_the_interval_by_powers_of_two_exactly() -> None:
    interval = float(CASE.times[0])
    found = [trial.setting for trial in trials(CASE, planted.Sound())]
    assert len(found) >= FEWEST
    assert found[0] <= 0.5 * CASE.time_scale < 2 * found[0] or found[0] == interval
    for step in found:
        ratio = Fraction(interval) / Fraction(step)
        assert ratio.denominator == 1
        assert ratio.numerator & (ratio.numerator - 1) == 0
    assert all(a == 2 * b for a, b in itertools.pairwise(found))


def test_engine_variants_get_decimal_steps() -> None:
    case = cases.get("pendulum_simple", "engines").rounded()
    assert {1e-2, 1e-3, 1e-4} <= {trial.setting for trial in trials(case, planted.Sound())}


def test_a_near_duplicate_method_skips_hard_variants_unless_it_is_named() -> None:
    chosen = [(CASE, ""), (cases.get("pendulum_simple", "engines").rounded(), "")]
    in_suite = plan.list_series(chosen, [planted.NearDuplicate()], formulations=False, near_duplicates=False)
    assert [series.left_out for series in in_suite] == [None, plan.NEAR_DUPLICATE]
    assert [series.left_out for series in plan.list_series(chosen, [planted.NearDuplicate()], formulations=False)] == [
        None,
        None,
    ]


def test_a_method_for_stiff_equations_runs_on_stiff_variants_alone() -> None:
    """The table of stiff systems has SciPy's BDF, which would repeat its other methods everywhere else."""
    suite, bdf, other = plan.suite("standard"), lookup.find_one("scipy:BDF"), lookup.find_one("scipy:RK45")
    assert {bdf, other} <= set(suite.methods(lookup.everything().values()))
    chosen = selection.choose(["damped_oscillator", "damped_oscillator/stiff_1e6", "harmonic_oscillator/fast"], False)
    found = plan.list_series(chosen, [bdf, other], False, near_duplicates=False, always=suite.scope.for_stiff)
    ran = [(one.variant, one.integrator.id) for one in found if suite.has(one) and one.left_out is None]
    assert [variant for variant, name in ran if name == bdf.id] == ["stiff_1e6"]
    assert len([name for _, name in ran if name == other.id]) == 3


def test_a_method_for_events_runs_on_motions_with_events_alone() -> None:
    suite, engine = plan.suite("standard"), lookup.find_one("mujoco:mj_step implicitfast [configured]")
    chosen = [(cases.get(name), "") for name in ("pendulum_simple", "bouncing_ball")]
    assert [one.case.name for one in plan.list_series(chosen, [engine], False) if suite.has(one)] == ["bouncing_ball"]


def test_standard_runs_the_ways_that_manuals_name_of_engines_and_the_suite_of_engines_all() -> None:
    """`make report` has MuJoCo and PyBullet within its minutes; their other ways stand beside these in the suite `engines`."""
    every = [one for one in lookup.own().values() if isinstance(one, SceneIntegrator)]
    named = {one.integrator for one in representatives().values()}
    ran = {one.id for one in plan.suite("standard").methods(every)}
    assert ran == {one.id for one in every if one.id in named and LIBRARIES[one.library].suite is None}
    assert ran
    assert set(plan.suite("engines").methods(every)) == set(every)


def test_a_pair_takes_the_most_structured_form_that_is_accepted() -> None:
    class Splitting(planted.Sound):
        accepts = (Separable,)

    first, second = plan.list_series([(CASE, "")], [Splitting(), planted.Sound()], formulations=False)
    assert type(first.form).__name__ == "Separable"
    assert type(second.form).__name__ == "FirstOrder"


def test_every_case_is_paired_with_every_integrator_or_has_a_reason_why_not() -> None:
    chosen = selection.choose(None, variants=False)
    integrators = lookup.find_all(None)
    found = plan.list_series(chosen, integrators)
    own = [series for series in found if series.formulation is None]
    assert len(own) == len(chosen) * len(integrators)
    for series in found:
        assert series.left_out is None or all(series.left_out)
    assert len({series.id for series in found}) == len(found)


def test_keys_depend_on_every_number_and_on_nothing_else() -> None:
    key = trials(CASE, planted.Sound())[0].key
    assert trials(cases.get("pendulum_simple").rounded(), planted.Sound())[0].key == key
    ulp = np.nextafter(9.81, 10)
    assert trials(cases.get("pendulum_simple", g=ulp).rounded(), planted.Sound())[0].key != key
    assert (
        trials(cases.get("pendulum_simple", span=np.nextafter(float(CASE.span), 0)).rounded(), planted.Sound())[0].key
        != key
    )
    assert len({trial.key for trial in trials(CASE, planted.Sound())}) == 8
    assert trials(CASE, planted.Raises())[0].key != key


METHOD = """
from gnomon.harness.contract.integrator import Integrator, Solution, Steps
from gnomon.cases.core.forms import FirstOrder
from edited_package.inner.deeper.helping import HELP

class Edited(Integrator):
    name, library = "edited", "edited"
    accepts, sweep = (FirstOrder,), Steps()

    def prepare(self, problem, setting):
        raise NotImplementedError(HELP)
"""
EDITED_CASE = """
from gnomon.cases.pendulums.pendulum_simple import PendulumSimple
from gnomon.cases.core.forms import SecondOrder
from edited_package.inner.deeper import helping

def factor(g):
    return g

def pull(t, q, parameters):
    (theta,) = q
    g, length = parameters
    return (-factor(g) * theta / length,)

class Edited(PendulumSimple):
    name = "edited"
    forms = (SecondOrder(pull),)
"""


def fresh(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    for name in [name for name in sys.modules if name.startswith("edited_package")]:
        del sys.modules[name]
    importlib.invalidate_caches()
    import_closure.forget()


def test_an_edited_method_or_its_helper_runs_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)  # else two edits within a second share a cached module

    def key(helper: str, method: str, other: str = "") -> str:
        fresh(tmp_path / "edited_package" / "inner" / "deeper" / "helping.py", helper)
        fresh(tmp_path / "edited_package" / "inner" / "deeper" / "other.py", other)
        fresh(tmp_path / "edited_package" / "method.py", method)
        (found,) = lookup.find("edited_package.method:Edited")
        return str(trials(CASE, found)[0].key)

    first = key("HELP = 1", METHOD)
    assert key("HELP = 1", METHOD, "OTHER = 2") == first
    assert key("HELP = 2", METHOD) != first
    assert key("HELP = 1", METHOD + "# a line more") != first


def test_an_edited_case_or_its_helper_runs_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The equations, and a helper that only the exact motion may use."""
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)

    def key(helper: str, case: str, other: str = "") -> str:
        fresh(tmp_path / "edited_package" / "inner" / "deeper" / "helping.py", helper)
        fresh(tmp_path / "edited_package" / "inner" / "deeper" / "other.py", other)
        fresh(tmp_path / "edited_package" / "case.py", case)
        edited = importlib.import_module("edited_package.case").Edited
        return str(trials(edited().rounded(), planted.Sound())[0].key)

    first = key("HELP = 1", EDITED_CASE)
    assert key("HELP = 1", EDITED_CASE, "OTHER = 2") == first
    assert key("HELP = 2", EDITED_CASE) != first
    assert key("HELP = 1", EDITED_CASE.replace("return g", "return 2 * g")) != first


def test_a_key_depends_on_the_sources_that_compile_the_equations() -> None:
    """Modules of another folder generate the fast Gauss method: after a change of them it must be measured again."""
    method = lookup.find("gnomon:Gauss 8-stage SIMD")[0]
    found = import_closure.sources(type(method).__module__)
    assert {"gnomon.harness.kernels.traced", "gnomon.harness.kernels.equations"} <= found.keys()


def test_a_name_means_all_policies_and_a_path_means_a_class() -> None:
    assert len(lookup.find("gnomon:rk4")) == 2, "RK4 and RK4 [events]"
    with pytest.raises(ValueError, match=r"several libraries: name gnomon:DOP853 or scipy:DOP853, or \*:DOP853"):
        lookup.find("DOP853")
    assert {i.library for i in lookup.find("*:dop853*")} == {"gnomon", "scipy"}
    assert [i.id for i in lookup.find("rebound:bs [*")] == ["rebound:BS [ODE mode]"], "brackets are not a pattern"
    with pytest.raises(ValueError, match=r"nothing matches 'spicy:\*'; did you mean scipy:"):
        lookup.find("spicy:*")
    assert {i.library for i in lookup.find("scipy")} == {"scipy"}
    (one,) = lookup.find("planted:Sound")
    assert isinstance(one, planted.Sound)
    assert references.dereference(references.reference(one)).id == one.id


def test_every_integrator_is_found_again_by_a_worker() -> None:
    for identity, one in lookup.everything().items():
        again = references.dereference(references.reference(one))
        assert (again.id, type(again)) == (identity, type(one))


RELATED = "holonomic_constraint_dae"
"""The case whose components a rule relates."""


@pytest.mark.parametrize("name", [RELATED, *cheap_and_tenth(name for name in cases.names() if name != RELATED)])
def test_perturbed_states_are_distinct_near_and_in_the_domain(name: str) -> None:
    """A tenth of the cases whose exact motions are expensive in `make test`."""
    case = cases.get(name).rounded()
    sizes = reference_solution(CaseSpec.of(case)).sizes
    state = np.array([float(x) for x in case.initial_state])
    found = list(itertools.islice(perturb_start(case, None, sizes), 100))
    assert len({x.tobytes() for x in found} | {state.tobytes()}) == 101
    unit = np.spacing(np.maximum(np.abs(state), 1e-3 * sizes))
    # one ulp for the nearest; four where a rule relates components, which are then perturbed together by 2^-51 of their
    # values; 100 states of one component of which one side is in the domain need 100 times as many
    nearest = 4 if name == RELATED else 1
    assert np.all(np.abs(found[0] - state) <= nearest * unit)
    assert all(np.all(np.abs(x - state) <= 100 * nearest * unit) for x in found)
    for x in found:
        case.with_numbers(x.tolist(), case.parameters)  # raises outside the domain


@pytest.mark.parametrize("name", ["amusement_park", "bead_leaving_sphere", "holonomic_constraint_dae"])
def test_few_states_are_tried_where_rules_fix_components(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The search runs within the deadline of a trial, and a sweep of 12 settings takes up to 500 perturbed states."""
    looked = 0
    admits = Domain.admits

    def counting(self: Domain, numbers: Mapping[str, Fraction]) -> bool:
        nonlocal looked
        looked += 1
        return admits(self, numbers)

    monkeypatch.setattr(Domain, "admits", counting)
    case = cases.get(name).rounded()
    found = list(itertools.islice(perturb_start(case, None, np.ones(len(case.state))), 500))
    assert len(found) == 500
    assert looked < 3000


def test_a_probe_changes_every_component_that_the_domain_allows() -> None:
    """Next to the cusp the angle can change to one side; the effect of a change of speed alone is lost within a step."""
    case = cases.get("cycloidal_pendulum", "cusp_to_cusp").rounded()
    start = np.array([float(x) for x in case.initial_state])
    assert np.all(probe_state(case, None, np.ones(2)) != start)


def test_at_the_edge_of_a_formulation_the_encoded_state_is_perturbed() -> None:
    """In arc length the neighbours of the cusp round to the cusp."""
    case = cases.get("cycloidal_pendulum", "cusp_to_cusp").rounded()
    (formulation,) = case.formulations
    found = list(itertools.islice(perturb_start(case, formulation, np.ones(2)), 10))
    arcs = [float(arc) for arc, _ in found]
    assert len(set(arcs)) == 10
    assert all(1 - 10 * 2**-52 <= arc < 1 for arc in arcs)


def test_the_sweep_of_an_integrator_with_steps_starts_below_its_coarsest() -> None:
    assert settings(Steps(coarsest=0.1, halvings=3), 1.0)[0] == 1 / 16
    assert settings(Steps(coarsest=0.1, halvings=3), 1 / 128)[0] == 1 / 128


def test_the_quick_suite_has_a_method_of_every_library_and_several_for_each_of_its_cases() -> None:
    integrators = lookup.find_all(plan.SUITES["quick"].scope.integrators)
    assert {one.id for one in integrators} == set(plan.SUITES["quick"].scope.integrators)
    everywhere = (lookup.general() | lookup.list_registered()).values()
    assert {one.library for one in integrators} == {one.library for one in everywhere}
    for name in plan.SUITES["quick"].scope.cases:
        able = [one for one in plan.list_series([(cases.get(name), "")], integrators, False) if one.form is not None]
        assert len({one.integrator.library for one in able}) >= 2, name


def test_a_suite_is_changed_by_the_names_of_fields() -> None:
    """No two parts of a suite share a name: suites.toml and `change` go without the names of the parts."""
    names = [name for part in (*plan.FIELDS.values(), plan.Suite.__annotations__) for name in part]
    assert len(names) == len({*names})
    quick = plan.suite("quick")
    changed = quick.change(launches=3, limit_seconds=300.0, shard=(1, 2))
    assert (changed.timing.launches, changed.limits.limit_seconds, changed.shard) == (3, 300.0, (1, 2))
    assert (changed.scope, quick.shard) == (quick.scope, (1, 1))
    with pytest.raises(TypeError, match="lunches"):
        quick.change(lunches=3)


@pytest.mark.parametrize("name", ["standard", "full", "catalogue"])
def test_these_suites_have_every_case_and_take_the_foundation_further(name: str) -> None:
    suite = plan.suite(name)
    assert set(cases.names()) < set(suite.names())
    inside, outside = cases.get("pendulum_simple"), cases.get("bead_leaving_sphere")
    assert suite.of(inside) is suite
    method, engine = lookup.find_all(["gnomon:RK4", "mujoco:mj_step RK4 [configured]"])
    assert suite.of(inside).limit(inside, method) > suite.of(outside).limit(outside, method)
    assert suite.of(outside).limit(outside, engine) >= 1.0, "of which a step takes microseconds at the least"
    assert suite.of(outside).timing.launches == 1
    assert suite.within(200.0).of(outside).limit(outside, engine) == 200


def test_suites_differ_in_their_hard_variants() -> None:
    """Each suite has the variants of the suites before it: run into one file, it adds the missing variants."""
    inside, outside = "pendulum_simple/long_1e4", "bead_leaving_sphere/near_top"
    named = {name: set(plan.suite(name).names()) for name in ("foundation", "standard", "full", "catalogue")}
    assert {name: (inside in found, outside in found) for name, found in named.items()} == {
        "foundation": (True, False), "standard": (False, False), "full": (True, False), "catalogue": (True, True)
    }  # fmt: skip
    assert named["standard"] < named["full"] < named["catalogue"]
    assert named["foundation"] < named["full"]


def test_the_standard_suite_has_a_hard_variant_of_each_foundation_case_that_has_one() -> None:
    """None is longer than the rule in suites.toml allows."""
    suite = plan.suite("standard")
    for name in plan.FOUNDATION:
        hard = [cases.get(*each.split("/")) for each in suite.scope.hardest if each.startswith(f"{name}/")]
        assert all(float(case.span) <= 1e4 * case.time_scale for case in hard)
        short = [
            v
            for v in cases.case_class(name).variants
            if float((c := cases.get(name, v.name)).span) <= 1e4 * c.time_scale
        ]
        assert len(hard) == min(1, len(short))
    assert {each.split("/")[0] for each in suite.scope.hardest} <= set(plan.FOUNDATION)
    assert suite.names()[len(cases.names()) :] == [*suite.scope.hardest, *suite.scope.further]


def test_peers_that_are_not_installed_give_a_run_no_more_minutes(monkeypatch: pytest.MonkeyPatch) -> None:
    """A run without peers would else go on as long as one with them."""
    suite, peers = plan.suite("standard"), lookup.find("diffrax")
    monkeypatch.setattr(lookup, "missing", lambda one: "not installed")
    assert suite.budget(peers) == suite.limits.minutes
    monkeypatch.setattr(lookup, "missing", lambda one: None)
    assert suite.budget(peers) == suite.limits.minutes_with_peers > suite.limits.minutes
