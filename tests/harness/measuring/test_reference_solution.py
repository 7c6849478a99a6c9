"""Reference solutions of several cases at a time."""

import os
import signal
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from gnomon.harness.measuring import reference_solution
from gnomon.harness.measuring.reference_solution import CaseSpec
from gnomon.harness.system import supervisor
from gnomon.reference.storage import import_closure

from gnomon import cases


def test_after_an_interruption_no_other_computation_begins(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Else Ctrl-C waits until all planned cases are computed: minutes, with an empty cache."""

    def compute(spec: CaseSpec) -> None:
        (tmp_path / str(os.getpid())).touch()
        if spec != specs[0]:
            signal.pause()

    def interrupt() -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(reference_solution, "calls", partial(supervisor.calls, method="fork"))
    monkeypatch.setattr(reference_solution, "reference_solution", compute)
    monkeypatch.setattr(reference_solution.diskcache, "load", lambda *_: None)
    specs = [CaseSpec.of(cases.get("harmonic_oscillator", k=k).rounded(), None) for k in range(1, 9)]
    with pytest.raises(KeyboardInterrupt):
        reference_solution.reference_solutions(specs, interrupt)
    begun = [path.name for path in tmp_path.iterdir()]
    assert 1 <= len(begun) <= (os.cpu_count() or 1)
    for number in begun:
        with pytest.raises(ProcessLookupError):
            os.kill(int(number), 0)


def test_a_reference_solution_is_computed_again_if_a_source_of_its_case_was_edited(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A helper two folders down is a source of the case, a file beside the helper is not."""
    computed: list[CaseSpec] = []
    empty = reference_solution.ReferenceSolution(*[np.zeros(1)] * 8, 1.0, *[np.zeros(1)] * 3)
    monkeypatch.setattr(reference_solution, "_compute", lambda spec: computed.append(spec) or empty)
    monkeypatch.setattr(reference_solution.diskcache, "folder", lambda: tmp_path / "results")
    monkeypatch.syspath_prepend(str(tmp_path))
    deep = tmp_path / "kept_package" / "inner" / "deeper"
    deep.mkdir(parents=True)
    (tmp_path / "kept_package" / "case.py").write_text("from .inner.deeper import motion\n")
    spec = CaseSpec("kept_package.case:Own", None, ("1",), (), "1")
    counts = []
    for motion, other in (("1", "1"), ("1", "1"), ("1", "2"), ("2", "2"), ("2", "2")):
        (deep / "motion.py").write_text(f"PERIOD = {motion}\n")
        (deep / "other.py").write_text(f"PERIOD = {other}\n")
        import_closure.forget()
        reference_solution.reference_solution(spec)
        counts.append(len(computed))
    assert counts == [1, 1, 1, 2, 2]


def test_the_reference_solution_of_a_case_without_a_file_is_not_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    """A case in a notebook may be redefined under the same name."""
    computed: list[CaseSpec] = []
    empty = reference_solution.ReferenceSolution(*[np.zeros(1)] * 8, 1.0, *[np.zeros(1)] * 3)
    monkeypatch.setattr(reference_solution, "_compute", lambda spec: computed.append(spec) or empty)
    for _ in range(2):
        reference_solution.reference_solution(CaseSpec("in_no_file:Own", None, ("1",), (), "1"))
    assert len(computed) == 2


def test_the_key_of_a_reference_solution_has_every_number_the_variant_and_the_formulation() -> None:
    """Default variants alone have turned starts, and each formulation has a start and times of its own."""
    case = cases.get("kepler_orbit").rounded()
    spec, *others = (CaseSpec.of(case, formulation) for formulation in (None, *case.formulations))
    assert others
    others += [
        replace(spec, **{name: value})
        for name, value in {
            "variant": "near_parabolic_bound",
            "initial_state": ("1", *spec.initial_state[1:-1], "7/8"),
            "parameters": tuple((name, "2") for name, _ in spec.parameters),
            "span": "3",
        }.items()
    ]
    assert len({reference_solution._key(one) for one in (spec, *others)}) == 1 + len(others)
