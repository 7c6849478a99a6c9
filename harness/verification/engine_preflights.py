"""Pre-flights of a physics engine as rows of a report; each runs in a process that can be killed."""

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from gnomon.cases import Case
from gnomon.cases.core.scene import SceneForm
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.registry import selection
from gnomon.harness.studies import preflight
from gnomon.harness.system.limitations import need_fork
from gnomon.harness.system.supervisor import Job, Send, run
from gnomon.harness.verification.claims import Finding, fail_claim, not_applicable, not_checked, pass_claim
from gnomon.harness.verification.verify import CASES, CLAIM_SECONDS, OVER, Row, plan_verification


def preflight_rows(
    integrator: Integrator,
    names: Sequence[selection.CaseLike] | None,
    depth: str,
    chosen: Sequence[str] | None,
    workers: int,
    progress: Callable[[Row], None],
    ends: float = math.inf,
) -> list[Row]:
    """Run pre-flights of an engine.

    Parameters
    ----------
    integrator : Integrator
        The engine.
    names : sequence of str, Case or ExactCase, or None
        The cases of the pre-flight `acceleration`; None for all cases with a scene, or for `CASES` at depth low.
    depth : {"low", "normal", "high"}
        As in `verify`.
    chosen : sequence of str or None
        Claims and pre-flights by name; the pre-flights among them run. None for all pre-flights.
    workers : int
        The number of processes.
    progress : callable
        It is called with each row when it is known.
    ends : float
        The time of the clock `monotonic` after which pre-flights that have not run are not checked.

    Returns
    -------
    list of Row
        In the order of the pre-flights.

    Raises
    ------
    ValueError
        For an integrator that takes no scenes, and as `verify` does.
    """
    need_fork()
    if SceneForm not in integrator.accepts:
        raise ValueError(f"{integrator.id} takes no scenes; name it without --engine")
    # Raises for a wrong argument before anything runs.
    plan_verification(integrator, names, depth, [name for name in chosen or () if name not in preflight.TEXTS])
    parts: list[Part] = []
    for name in preflight.TEXTS:
        if not chosen or name in chosen:
            on = _cases(names, depth) if name == preflight.ACCELERATION else [None]
            parts += [(name, case) for case in on]
    rows = {part: list[Row]() for part in parts}

    def add(part: Part, row: Row) -> None:
        rows[part].append(row)
        progress(row)

    run([PreflightJob(integrator, parts[k::workers], add, CLAIM_SECONDS[depth]) for k in range(workers)], workers, ends)
    return [row for part_rows in rows.values() for row in part_rows]


def _cases(names: Sequence[selection.CaseLike] | None, depth: str) -> Sequence[Case]:
    if names:
        return selection.find_cases(names)
    return [case for case in preflight.smooth_cases() if depth != "low" or case.id in CASES]


Part = tuple[str, Case | None]
"""A pre-flight, for `acceleration` with a case."""


@dataclass(eq=False)
class PreflightJob(Job):
    """Pre-flights still to be run. One that ends its process, or hangs, fails."""

    integrator: Integrator
    parts: list[Part]
    add: Callable[[Part, Row], None]
    limit: float

    @property
    def pending(self) -> list[str]:  # type: ignore[override]
        return [name for name, _ in self.parts]

    def work(self, send: Send) -> None:
        for name, case in self.parts:
            on = None if case is None else [case]
            send([asdict(row) for row in preflight.preflights(self.integrator, [name], on)])

    def receive(self, message: Any) -> None:
        part = self.parts.pop(0)
        for values in message:
            row = preflight.Row(**values)
            self.add(part, Row(row.name, row.scene, finding(row)))

    def lose(self, why: str, late: bool = False) -> None:
        self._answer(fail_claim("", "an answer", why, preflight.TEXTS[self.parts[0][0]]["reason"]))

    def stop(self) -> None:
        while self.parts:
            self._answer(not_checked(OVER))

    def _answer(self, finding: Finding) -> None:
        part = self.parts.pop(0)
        self.add(part, Row(part[0], part[1].id if part[1] is not None else "all_scenes", finding))


def finding(row: preflight.Row) -> Finding:
    """The result of a pre-flight as the finding of a claim."""
    if row.verdict == preflight.UNSUPPORTED:
        return not_applicable(row.note)
    if row.verdict == preflight.PASSED:
        return pass_claim(f"{row.measured:.2g}")
    reason = preflight.TEXTS[row.name]["reason"]
    if math.isnan(row.bound):
        return fail_claim("", "an answer", row.note, reason)
    return fail_claim("", f"at most {row.bound:.2g}", f"{row.measured:.2g}, {row.note}", reason)
