"""Truths of many cases at a time."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gnomon.harness.scoring import reference_solution
from gnomon.harness.scoring.reference_solution import CaseSpec
from gnomon.harness.system import child_process
from gnomon.reference.storage import import_closure

from gnomon import cases


def test_an_interruption_begins_no_other_truth(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C once waited until all that were planned were computed: minutes, with a cold cache."""
    begun: list[CaseSpec] = []
    shutting_down = threading.Event()

    class Pool(ThreadPoolExecutor):
        _processes = None

        def __init__(self, *_: Any, **__: Any) -> None:
            super().__init__(1)

        def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
            super().shutdown(wait=False, cancel_futures=cancel_futures)
            shutting_down.set()
            super().shutdown(wait=wait)

    def compute(spec: CaseSpec) -> None:
        begun.append(spec)
        if len(begun) > 1:
            shutting_down.wait()

    def interrupt() -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(child_process, "ProcessPoolExecutor", Pool)
    monkeypatch.setattr(reference_solution, "reference", compute)
    monkeypatch.setattr(reference_solution.diskcache, "load", lambda _key: None)
    specs = [CaseSpec.of(cases.get("harmonic_oscillator", k=k).rounded(), None) for k in range(1, 9)]
    with pytest.raises(KeyboardInterrupt):
        reference_solution.reference_solutions(specs, interrupt)
    assert len(begun) <= 2, "the one that was done, the one under way"


def test_a_reference_solution_is_computed_again_where_a_source_of_its_case_was_edited(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A helper two folders down is a source of it, and a file beside the helper is none."""
    computed: list[CaseSpec] = []
    empty = reference_solution.ReferenceSolution(*[np.zeros(1)] * 8, 1.0, *[np.zeros(1)] * 3)
    monkeypatch.setattr(reference_solution, "_compute", lambda spec: computed.append(spec) or empty)
    monkeypatch.setattr(reference_solution.diskcache, "folder", lambda: tmp_path / "results")
    monkeypatch.syspath_prepend(str(tmp_path))
    deep = tmp_path / "kept_package" / "inner" / "deeper"
    deep.mkdir(parents=True)
    (tmp_path / "kept_package" / "scene.py").write_text("from .inner.deeper import motion\n")
    spec = CaseSpec("kept_package.scene:Scene", None, ("1",), (), "1")
    counts = []
    for motion, other in (("1", "1"), ("1", "1"), ("1", "2"), ("2", "2"), ("2", "2")):
        (deep / "motion.py").write_text(f"PERIOD = {motion}\n")
        (deep / "other.py").write_text(f"PERIOD = {other}\n")
        import_closure.forget()
        reference_solution.reference(spec)
        counts.append(len(computed))
    assert counts == [1, 1, 1, 2, 2]


def test_what_is_written_in_no_file_is_computed_each_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """A case of a notebook may be another one under the same name a moment later."""
    computed: list[CaseSpec] = []
    empty = reference_solution.ReferenceSolution(*[np.zeros(1)] * 8, 1.0, *[np.zeros(1)] * 3)
    monkeypatch.setattr(reference_solution, "_compute", lambda spec: computed.append(spec) or empty)
    for _ in range(2):
        reference_solution.reference(CaseSpec("in_no_file:Scene", None, ("1",), (), "1"))
    assert len(computed) == 2
