"""Which faults `gnomon verify` finds: mutants of right methods, rebuilt real defects, and runs of right integrators.

    make verification                                       everything, resumed where it ended; hours
    python tests/detection/measure.py --only "mutant rk4"   what has the word in "kind name condition"

Each is verified at depth normal until a claim fails. A mutant that changes no state beyond conditioning and round-off
changes no result: it is counted apart. Right integrators run under each condition of CONDITIONS at depth low. Each row is
measured in a process of its own, and kept as a line under the hash of the sources that it depends on.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import math
import os
import random
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Solution, Steps, solver_of
from gnomon.harness.contract.problem import takes
from gnomon.harness.registry import lookup
from gnomon.harness.scoring.reference_solution import CaseSpec
from gnomon.harness.verification.claims import Outcome
from gnomon.harness.verification.relation_claims import later
from gnomon.harness.verification.trials import DEPTHS, Trials
from gnomon.harness.verification.verify import CLAIMS, FIRST, FirstTrialError, Row, planned, verify
from gnomon.reference.storage.import_closure import closure

from gnomon import cases

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

import mutants  # noqa: E402 - beside this file
import planted  # noqa: E402
from defects import DEFECTS  # noqa: E402
from summary import NEEDED, published  # noqa: E402

DEPTH, RIGHT_DEPTH = "normal", "low"
EARLY = ("quadrature", "step_order", "order_short", "tolerance_short", "proportional", "symplectic", "reversible", "repeatable", "aliasing",
         "bad_setting")  # fmt: skip
"""Claims that cost little: they are verified on all cases before the others, so that most faults are found in seconds."""
DRAWN = 240
"""Mutants that are measured: the chosen faults, and a seeded draw of the others, as many of each method."""
RUNS = 204
"""Runs of right integrators: each under the first condition, the others by a seeded draw. Where no case states what an
integrator takes nothing is checked: such runs count as none, and 200 others are wanted."""
CONDITIONS: dict[str, dict[str, str]] = {
    "plain": {},
    "loaded machine": {},
    "NUMBA_CPU_NAME=generic": {"NUMBA_CPU_NAME": "generic"},
    "libm without AVX2 and FMA": {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-AVX512F"},
}
"""The environment of each; for a loaded machine a process for each processor is busy beside it."""
BEYOND = 10.0
"""A state is changed if it differs by more than so many times the error that rounding may cause."""
SECONDS = 1800.0


@dataclass(frozen=True)
class Task:
    """What is measured in one process: a right integrator under a condition, a defect or a mutant."""

    kind: str
    name: str
    condition: str = "plain"

    def __str__(self) -> str:
        return f"{self.kind} {self.name} {self.condition}"


@dataclass(frozen=True)
class Measured:
    """What became of one faulty or right integrator; `error` where the measurement itself failed."""

    kind: str
    name: str
    condition: str
    changed: bool
    claim: str | None
    case: str | None
    checked: int
    seconds: float
    sources: str
    error: str | None = None


class Found(Exception):  # noqa: N818 - a result, not an error
    """Raised by the first claim that fails."""


def first_failure(integrator: Integrator, depth: str, only: Sequence[str] = ()) -> tuple[tuple[str, str] | None, int]:
    """The first claim (of `only`, if any) that fails, and its case, or None if none does; the number that passed."""
    found: list[tuple[str, str]] = []
    checked = 0

    def look(row: Row) -> None:
        nonlocal checked
        checked += row.finding.outcome == Outcome.PASSED
        if row.finding.outcome == Outcome.FAILED:
            found.append((row.claim, row.case))
            raise Found

    steps = isinstance(integrator.sweep, Steps)
    later = [name for name, claim in CLAIMS.items() if name not in EARLY and not (steps and claim.hard)]
    try:
        for claims in (only,) if only else (EARLY, later):
            verify(integrator, depth=depth, claims=claims, workers=1, progress=look)
    except Found:
        return found[0], checked
    except FirstTrialError:
        return (FIRST, ""), checked
    return None, checked


def changes(faulty: Integrator, right: Integrator) -> bool:
    """Whether a state, an event or the start differs beyond rounding on any case: those that are verified first, at three
    settings of the sweep, then all others at the usual setting, and each by a later clock.

    Two motions are solved at once: from the start, and from a state that the exact motion passes.
    """
    first = [case.id for case, _ in planned(right, None, "low")]
    others = [case.id for case in map(cases.get, cases.names()) if takes(right, case) and case.id not in first]
    for name in [*first, *others]:
        spec = CaseSpec.of(cases.get(*name.split("/")).rounded())
        ours, theirs = (Trials.of(each, spec, DEPTHS["low"]) for each in (right, faulty))
        if not ours.settings:  # every step of the sweep is shorter than this depth allows
            continue
        for setting in (ours.settings[0], ours.usual(), ours.settings[-1]) if name in first else (ours.usual(),):
            if any(_differ(ours, theirs, setting, problem) for problem in (ours.problem(), later(ours.problem()))):
                return True
    return False


def _differ(ours: Trials, theirs: Trials, setting: float, problem: Problem | None) -> bool:
    """Whether a faulty integrator has another result than the right one, where that has one."""
    answer = ours.whole(setting)
    if problem is None or not math.isfinite(answer.error):
        return False
    starts = ours.start[None]
    if answer.events is None:
        starts = np.array([ours.start, ours.reference.exact[8]])
    expected, _ = called(ours, problem, setting, starts)
    try:
        found, changed = called(theirs, problem, setting, starts)
    except Exception:  # a fault may raise anything
        return True
    allowed = BEYOND * answer.roundoff
    pairs = [pair for pair in zip(found.states, expected.states, strict=True) if np.all(np.isfinite(pair[1]))]
    return (
        changed
        or any(not np.max(ours.distance(*pair)) <= allowed for pair in pairs)
        or not _same_events(found.events or (), expected.events or (), allowed * ours.reference.time_scale)
    )


def called(trials: Trials, problem: Problem, setting: float, starts: Floats) -> tuple[Solution, bool]:
    """What an integrator returns from starts (n, dim), and whether it changed them."""
    given = starts.copy()
    solution = solver_of(trials.integrator, problem, setting)(given)
    return solution, not np.array_equal(given, starts)


def _same_events(found: Sequence[tuple[float, str]], expected: Sequence[tuple[float, str]], allowed: float) -> bool:
    """Whether the same events are at the same times but for rounding."""
    return [name for _, name in found] == [name for _, name in expected] and all(
        abs(ours - theirs) <= allowed + 8 * math.ulp(theirs)
        for (ours, _), (theirs, _) in zip(found, expected, strict=True)
    )


def right() -> dict[str, Integrator]:
    """The right methods of which there are mutants."""
    return mutants.right() | planted.more_right()


def faulty() -> list[mutants.Mutant]:
    """The mutants that are measured: those of the draw, and the planted faults."""
    return [*mutants.drawn(DRAWN), *planted.planted()]


def tasks() -> list[Task]:
    """Everything that is measured, the sum of all kinds."""
    draw = random.Random(20)
    names = [name for name, integrator in lookup.everything().items() if lookup.missing(integrator) is None]
    names += [f"{method} of right_methods.py" for method in right()]
    conditions = [*CONDITIONS][1:]
    each = {condition: draw.sample(names, len(names)) for condition in conditions}
    more = [Task("right", each[condition][k], condition) for k in range(len(names)) for condition in conditions]
    runs = [Task("right", name) for name in names] + more[: max(0, RUNS - len(names))]
    defects = [Task("defect", defect.link) for defect in DEFECTS]
    return [*defects, *(Task("mutant", mutant.id) for mutant in faulty()), *runs]


def measured(task: Task, sources: str, added: Sequence[str], before: Measured | None) -> Measured:
    """The row of a task, measured in this process; with `before`, where no claim failed, by the claims `added` alone."""
    began = time.monotonic()
    if task.kind == "right":
        integrator = right().get(task.name.removesuffix(" of right_methods.py")) or lookup.find_one(task.name)
    elif task.kind == "defect":
        integrator = next(defect for defect in DEFECTS if defect.link == task.name).integrator()
    else:
        mutant = next(mutant for mutant in faulty() if mutant.id == task.name)
        integrator = mutant.integrator()
    failure, checked = first_failure(
        integrator, RIGHT_DEPTH if task.kind == "right" else DEPTH, added if before else ()
    )
    changed = failure is not None or task.kind == "defect" or (before is not None and before.changed)
    if task.kind == "mutant" and failure is None and before is None:
        changed = changes(integrator, right()[mutant.method.name])
    claim, case = failure or (None, None)
    seconds = time.monotonic() - began
    if before is not None:
        checked, seconds = checked + before.checked, seconds + before.seconds
    return Measured(task.kind, task.name, task.condition, changed, claim, case, checked, round(seconds, 2), sources)


@contextlib.contextmanager
def busy(processes: int) -> Iterator[None]:
    """So many processes beside this one that never wait."""
    started = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(processes)]
    try:
        yield
    finally:
        for process in started:
            process.kill()
            process.wait()


def in_process(task: Task, sources: str, added: Sequence[str] = (), before: Measured | None = None) -> Measured:
    """The row of a task, measured in a process of its own under its condition."""
    chosen = [sys.executable, str(HERE / "measure.py"), "--task", json.dumps(asdict(task)), "--sources", sources]
    if before is not None:
        chosen += ["--before", json.dumps(asdict(before)), *(f"--added={name}" for name in added)]
    environment = os.environ | CONDITIONS[task.condition]
    with busy((os.cpu_count() or 1) if task.condition.startswith("loaded") else 0):
        try:
            done = subprocess.run(chosen, env=environment, capture_output=True, text=True, timeout=SECONDS, check=False)
            why = done.stderr[-2000:]
        except subprocess.TimeoutExpired:
            done, why = None, f"no result within {SECONDS:g} s"
    if done is None or done.returncode:
        return Measured(task.kind, task.name, task.condition, True, None, None, 0, 0.0, sources, why)
    return Measured(**json.loads(done.stdout.splitlines()[-1]))


def measure(
    chosen: Sequence[Task], known: dict[Task, Measured], file: Path, sources: str, workers: int,
    added: Sequence[str] = (), before: Mapping[Task, Measured] = MappingProxyType({}),
) -> None:  # fmt: skip
    """Add a row to `known` and to the file for each task that has none; loaded machines come last, one at a time."""
    waiting = [task for task in chosen if task not in known]
    beside = [task for task in waiting if not task.condition.startswith("loaded")]
    loaded = [task for task in waiting if task.condition.startswith("loaded")]
    with file.open("a") as rows:
        for some, count in ((beside, workers), (loaded, 1)):
            with ThreadPoolExecutor(count) as pool:
                for future in as_completed(
                    [pool.submit(in_process, task, sources, added, before.get(task)) for task in some]
                ):
                    row = future.result()
                    task = Task(row.kind, row.name, row.condition)
                    known[task] = row
                    rows.write(json.dumps(asdict(row)) + "\n")
                    rows.flush()
                    found = row.error or row.claim or ("nothing fails" if row.changed else "no change")
                    print(f"{found:16} {task} ({row.seconds:.0f} s)", flush=True)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--only", action="append", default=[], help="a part of `kind name condition`; repeatable")
    parser.add_argument("--rows", type=Path, default=Path("runs/verification.jsonl"))
    parser.add_argument("--to", type=Path, default=Path("reports/local/verification.json"))
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument(
        "--keep-found", action="store_true",
        help="keep the faults that a claim found with earlier sources: right where claims were added and none was changed",
    )  # fmt: skip
    parser.add_argument(
        "--added", action="append", default=[], metavar="CLAIM",
        help="claims added or changed since the kept rows were measured: what no claim found is verified by these alone, "
        "and what one of these found is measured again",
    )  # fmt: skip
    parser.add_argument("--task", help=argparse.SUPPRESS)
    parser.add_argument("--before", help=argparse.SUPPRESS)
    parser.add_argument("--sources", default="", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.task:
        before = None if given.before is None else Measured(**json.loads(given.before))
        row = measured(Task(**json.loads(given.task)), given.sources, given.added, before)
        print("\n" + json.dumps(asdict(row)))
        return 0
    sources = closure("gnomon.harness.verification.verify") or ""
    given.rows.parent.mkdir(parents=True, exist_ok=True)
    given.rows.touch()
    kept = [Measured(**json.loads(line)) for line in given.rows.read_text().splitlines()]
    keep = given.keep_found or given.added

    def holds(row: Measured) -> bool:
        """Whether a row was measured with these sources, or what found the fault is still there."""
        return row.sources == sources or (keep and row.kind != "right" and row.claim not in (None, *given.added))

    known = {Task(row.kind, row.name, row.condition): row for row in kept if row.error is None and holds(row)}
    earlier = {Task(row.kind, row.name, row.condition): row for row in kept if row.error is None and row.claim is None}
    chosen = [task for task in tasks() if not given.only or any(word in str(task) for word in given.only)]
    if not chosen:
        parser.error(f"--only {' '.join(given.only)}: nothing that is measured has this in its name")
    measure(chosen, known, given.rows, sources, given.workers, given.added, earlier if given.added else {})
    found = published([asdict(known[task]) for task in tasks() if task in known], DEPTH, RIGHT_DEPTH)
    given.to.parent.mkdir(parents=True, exist_ok=True)
    given.to.write_text(json.dumps(found, indent=1) + "\n")
    print(found["text"])
    wrong = found["false_alarms"] or found["not_measured"] or found["survivors_without_reason"]
    return int(bool(wrong) or any(not found[kind]["share"] >= least for kind, least in NEEDED.items()))


if __name__ == "__main__":
    sys.exit(main())
