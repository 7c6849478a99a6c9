"""Reference solutions of several cases at a time."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest
from gnomon.harness.scoring import reference_solution as solutions
from gnomon.harness.scoring.reference_solution import CaseSpec
from gnomon.harness.system import child_process as processes

from gnomon import cases


def test_after_an_interruption_no_other_computation_begins(monkeypatch: pytest.MonkeyPatch) -> None:
    """Else Ctrl-C waits until all planned cases are computed: minutes, with an empty cache."""
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

    monkeypatch.setattr(processes, "ProcessPoolExecutor", Pool)
    monkeypatch.setattr(solutions, "reference_solution", compute)
    monkeypatch.setattr(solutions.diskcache, "load", lambda _key: None)
    specs = [CaseSpec.of(cases.get("harmonic_oscillator", k=k).rounded(), None) for k in range(1, 9)]
    with pytest.raises(KeyboardInterrupt):
        solutions.reference_solutions(specs, interrupt)
    assert len(begun) <= 2, "the one that was done and the one in progress"
