"""A pool that answers without processes, so that a test decides how each trial ends."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import pytest
from gnomon.harness.contract.status import Status
from gnomon.harness.measuring.outcome import Outcome
from gnomon.harness.running import planned_run
from gnomon.harness.running.sweep import Sweep

How = Callable[[Sweep, float], tuple[Status, str] | None]
"""How a trial at a setting ends: status and reason, None for the exact motion; it may raise KeyboardInterrupt."""


class Answering:
    """In place of `Pool`. `asked` are the trials that it was asked for: integrator, setting, launch."""

    def __init__(self, how: How) -> None:
        self.how = how
        self.asked: list[tuple[str, float, int]] = []

    def __call__(self, *_: Any, **__: Any) -> Answering:
        return self

    def run(self, jobs: Iterable[Sweep | None], *_: Any) -> None:
        for job in jobs:
            assert job is not None, "nothing is under way"
            while (request := job.next()) is not None:
                self.asked.append((job.series.integrator.name, request.setting, job.launch))
                ended = self.how(job, request.setting)
                if ended is not None:
                    job.failed(*ended, "")
                    continue
                exact = job.scorer.reference.exact
                job.done(Outcome(exact, None, None, 8, 32, (1e-3,), 0.0, None))


def answering(monkeypatch: pytest.MonkeyPatch, how: How = lambda *_: None) -> Answering:
    """Replace the pool of a run."""
    found = Answering(how)
    monkeypatch.setattr(planned_run, "Pool", found)
    monkeypatch.setattr("gnomon.harness.running.first_trials.crashes", lambda *_: [])
    return found
