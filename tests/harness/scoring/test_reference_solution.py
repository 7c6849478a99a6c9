"""Truths of many cases at a time."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest
from gnomon.harness.scoring import reference_solution
from gnomon.harness.scoring.reference_solution import CaseSpec
from gnomon.harness.system import child_process

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
