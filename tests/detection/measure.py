"""Which faults `gnomon verify` finds: mutants of right methods, rebuilt real defects, and runs of right integrators.

    make verification                                       everything, resumed where it ended; hours
    python tests/detection/measure.py --only "mutant rk4"   rows with the word in "kind name condition depth"
    python tests/detection/measure.py --depth low           mutants and defects at one of the two depths
    python tests/detection/measure.py --draw 90             so many mutants, a random draw with the published SEED
    python tests/detection/measure.py --load 8 --draw 40    as many runs of right integrators, beside 8 busy processes

Each fault is verified at both depths until a claim fails. A mutant that changes no state beyond conditioning and round-off
on any case changes no result: it is counted apart. Right integrators run under each condition of CONDITIONS at depth low.
A row is measured in parts of two minutes or one case, each in a process of its own. Each part is kept as a line under the
hash of the sources that it depends on, and the next launch continues after the last one.
"""

import argparse
import contextlib
import json
import math
import os
import random
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
from gnomon.cases.core.scene import SceneForm
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Solution, Steps, solver_of
from gnomon.harness.contract.problem import takes
from gnomon.harness.measuring.reference_solution import CaseSpec
from gnomon.harness.measuring.trials import Trials
from gnomon.harness.registry import lookup
from gnomon.harness.studies import preflight
from gnomon.harness.studies.related_motions import later
from gnomon.harness.verification.claims import DEPTHS, Outcome
from gnomon.harness.verification.engine_preflights import preflight_rows
from gnomon.harness.verification.verify import CLAIMS, FIRST, FirstTrialError, Row, plan_verification, verify
from gnomon.reference.storage.import_closure import closure

from gnomon import cases

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

import family_faults  # noqa: E402 - beside this file
import mutants  # noqa: E402
import planted_faults  # noqa: E402
from defects import DEFECTS  # noqa: E402
from summary import NEEDED, published  # noqa: E402

METHODS = (*mutants.METHODS, *planted_faults.MORE, *family_faults.FAMILIES)
"""The right methods of which there are mutants."""
FAULT_DEPTHS, RIGHT_DEPTH = ("low", "normal"), "low"
EARLY = ("follows", "quadrature", "many_samples", "error_norm", "backward", "scene", "attitude", "constraint", "time_structure", "step_order", "order_short", "tolerance_short",
         "proportional", "symplectic", "reversible", "repeatable", "aliasing", "bad_setting")  # fmt: skip
"""Claims that cost little: they are verified on all cases before the others, so that most faults are found in seconds."""
DRAWN = 240
"""Mutants that are measured: the chosen faults, and a seeded draw of the others, as many of each method."""
RUNS = 204
"""Runs of right integrators: each under the first condition, the others by a seeded draw. If no case has a form that an
integrator takes, nothing is checked: such runs do not count, and 200 others are wanted."""
OTHERS = 60
"""Least number of runs under the other conditions, as many of each."""
SEED = 41
"""Of a draw of mutants. A larger draw contains a smaller one."""
CONDITIONS: dict[str, dict[str, str]] = {
    "plain": {},
    "loaded machine": {},
    "NUMBA_CPU_NAME=generic": {"NUMBA_CPU_NAME": "generic"},
    "libm without AVX2 and FMA": {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-AVX512F"},
}
"""The environment of each; for a loaded machine a process for each processor is busy beside it."""
BEYOND = 10.0
"""A state is changed if it differs by more than so many times the error that rounding may cause."""
PART, SECONDS = 120.0, 900.0
"""Seconds after which a part ends with its case, and after which it is given up."""


@dataclass(frozen=True)
class Task:
    """A measurement: of a right integrator under a condition and beside a load, of a defect or mutant at a depth."""

    kind: str
    name: str
    condition: str = "plain"
    depth: str = RIGHT_DEPTH
    load: int = 0

    def __str__(self) -> str:
        return f"{self.kind} {self.name} {self.condition} {self.depth}"


@dataclass(frozen=True)
class Measured(Task):
    """The outcome of one faulty or right integrator; `error` where the measurement itself failed.

    `parts`: the number of parts that are measured; `whole`: whether no more are to come.
    """

    changed: bool = False
    claim: str | None = None
    case: str | None = None
    checked: int = 0
    seconds: float = 0.0
    sources: str = ""
    error: str | None = None
    parts: int = 0
    whole: bool = False

    @property
    def task(self) -> Task:
        return Task(self.kind, self.name, self.condition, self.depth, self.load)


class Found(Exception):  # noqa: N818 - a result, not an error
    """Raised by the first claim that fails."""


def parts(integrator: Integrator, depth: str) -> list[tuple[Sequence[str], str | None]]:
    """(claims, case) in the sequence in which they are verified; an engine's pre-flights, without a case, come last.

    Engines of libraries are not without faults: what fails on their pre-flights is published with the suite of engines.
    """
    steps = isinstance(integrator.sweep, Steps)
    later = [name for name, claim in CLAIMS.items() if name not in EARLY and not (steps and claim.hard)]
    ours = SceneForm in integrator.accepts and integrator.id not in lookup.everything()
    on_cases = [
        (claims, case.id) for claims in (EARLY, later) for case, _ in plan_verification(integrator, None, depth, claims)
    ]
    return [*on_cases, *([(tuple(preflight.TEXTS), None)] if ours else [])]


def first_failure(
    integrator: Integrator, depth: str, begin: int = 0, seconds: float = math.inf
) -> tuple[tuple[str, str] | None, int, int, bool]:
    """(the first claim that fails and its case, None if none does; the number that passed; parts that are done; whether
    these are all). Begins with a part, and ends after one when so many seconds are over."""
    found: list[tuple[str, str]] = []
    checked, ends, everything = 0, time.monotonic() + seconds, parts(integrator, depth)

    def look(row: Row) -> None:
        nonlocal checked
        checked += row.finding.outcome == Outcome.PASSED
        if row.finding.outcome == Outcome.FAILED:
            found.append((row.claim, row.case))
            raise Found

    for k, (claims, case) in enumerate(everything[begin:], begin):
        if k > begin and time.monotonic() > ends:
            return None, checked, k, False
        try:
            if case is None:
                preflight_rows(integrator, None, depth, claims, 1, look)
            else:
                verify(integrator, [case], depth, claims, workers=1, progress=look)
        except Found:
            return found[0], checked, k + 1, True
        except FirstTrialError:
            return (FIRST, ""), checked, k + 1, True
    return None, checked, len(everything), True


def changes(faulty: Integrator, right: Integrator) -> bool:
    """Whether a state, an event or the start differs beyond rounding on any case: the cases verified first at three
    settings of the sweep, then all other cases at the usual setting, and each by a later clock.

    Two motions are solved at once: from the start, and from a state that the exact motion passes.
    """
    first = [case.id for case, _ in plan_verification(right, None, "low")]
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
    """The solution of an integrator from starts (n, dim), and whether it changed the starts."""
    given = starts.copy()
    solution = solver_of(trials.integrator, problem, setting)(given)
    return solution, not np.array_equal(given, starts)


def _same_events(found: Sequence[tuple[float, str]], expected: Sequence[tuple[float, str]], allowed: float) -> bool:
    """Whether the same events are at the same times but for rounding."""
    return [name for _, name in found] == [name for _, name in expected] and all(
        abs(ours - theirs) <= allowed + 8 * math.ulp(theirs)
        for (ours, _), (theirs, _) in zip(found, expected, strict=True)
    )


@cache
def right() -> dict[str, Integrator]:
    """The right methods of which there are mutants."""
    return {method.name: mutants.made(method, family_faults.source(method)) for method in METHODS}


def faulty() -> list[mutants.Mutant]:
    """The mutants that are measured: the drawn mutants, and the planted faults."""
    return [*mutants.drawn(DRAWN), *planted_faults.planted(), *family_faults.family_planted()]


def some(mutants: Sequence[str], count: int | None) -> list[str]:
    """A random draw of so many mutants with SEED; all for None."""
    return random.Random(SEED).sample(mutants, len(mutants))[:count] if count is not None else [*mutants]


def tasks(load: int = 0, count: int | None = None) -> list[Task]:
    """Everything that is measured, the sum of all kinds, with a draw of `count` mutants.

    Beside a load right ones alone, of which `count` are drawn.
    """
    draw = random.Random(20)
    names = [name for name, integrator in lookup.everything().items() if lookup.missing(integrator) is None]
    names += [f"{method.name} of right_methods.py" for method in METHODS]
    conditions = [*CONDITIONS][1:]
    each = {condition: draw.sample(names, len(names)) for condition in conditions}
    more = [Task("right", each[condition][k], condition) for k in range(len(names)) for condition in conditions]
    runs = [Task("right", name) for name in names] + more[: max(OTHERS, RUNS - len(names))]
    if load:
        return [replace(task, load=load) for task in random.Random(SEED).sample(runs, len(runs))[:count]]
    mutants_ = some([mutant.id for mutant in faulty()], count)
    faults = [*(("defect", defect.link) for defect in DEFECTS), *(("mutant", name) for name in mutants_)]
    return [*(Task(*fault, depth=depth) for depth in FAULT_DEPTHS for fault in faults), *runs]


def measured(begun: Measured) -> Measured:
    """The row with one more part, measured in this process."""
    began, task, depth = time.monotonic(), begun.task, begun.depth
    if task.kind == "right":
        integrator = right().get(task.name.removesuffix(" of right_methods.py")) or lookup.find_one(task.name)
    elif task.kind == "defect":
        integrator = next(defect for defect in DEFECTS if defect.link == task.name).integrator()
    else:
        mutant = next(mutant for mutant in faulty() if mutant.id == task.name)
        integrator = mutant.integrator()
    failure, checked, done, whole = first_failure(integrator, depth, begun.parts, PART)
    changed = failure is not None or task.kind == "defect"
    if whole and task.kind == "mutant" and failure is None:
        changed = mutant.elsewhere or changes(integrator, right()[mutant.method.name])
    claim, case = failure or (None, None)
    seconds = round(begun.seconds + time.monotonic() - began, 2)
    return replace(
        begun, changed=changed, claim=claim, case=case, checked=begun.checked + checked, seconds=seconds, parts=done, whole=whole
    )  # fmt: skip


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


def in_process(begun: Measured) -> Measured:
    """The row with one more part, measured in a process of its own under its condition."""
    chosen = [sys.executable, str(HERE / "measure.py"), "--begun", json.dumps(asdict(begun))]
    environment = os.environ | CONDITIONS[begun.condition]
    with busy((os.cpu_count() or 1) if begun.condition.startswith("loaded") else 0):
        try:
            done = subprocess.run(chosen, env=environment, capture_output=True, text=True, timeout=SECONDS, check=False)
            why = done.stderr[-2000:]
        except subprocess.TimeoutExpired:
            done, why = None, f"no result within {SECONDS:g} s"
    if done is None or done.returncode:
        return replace(begun, changed=True, error=why, whole=True)
    return Measured(**json.loads(done.stdout.splitlines()[-1]))


def measure(chosen: Sequence[Task], known: dict[Task, Measured], file: Path, sources: str, workers: int) -> None:
    """Add rows to `known`, and each part to the file, until each task is whole; loaded machines come last, one at a time.

    An interruption lets the parts that run come to their ends, and then is raised.
    """
    lock, interrupted = threading.Lock(), threading.Event()

    def complete(task: Task) -> None:
        row = known.get(task) or Measured(**asdict(task), sources=sources)
        while not row.whole and not interrupted.is_set():
            row = in_process(row)
            if row.error is not None and interrupted.is_set():  # Ctrl-C ends the process of a part too
                return
            with lock, file.open("a") as rows:
                known[task] = row
                rows.write(json.dumps(asdict(row)) + "\n")
            found = row.error or row.claim or ("nothing fails" if row.changed else "no change")
            print(f"{found if row.whole else 'goes on':16} {task} ({row.seconds:.0f} s)", flush=True)

    waiting = [task for task in chosen if task not in known or not known[task].whole]
    loaded = [task for task in waiting if task.condition.startswith("loaded")]
    for tasks_, count in (([task for task in waiting if task not in loaded], workers), (loaded, 1)):
        with ThreadPoolExecutor(count) as pool:
            try:
                for future in [pool.submit(complete, task) for task in tasks_]:
                    future.result()
            except KeyboardInterrupt:
                interrupted.set()
                pool.shutdown(wait=False, cancel_futures=True)
                raise


def read(file: Path, sources: str, keep_found: bool) -> dict[Task, Measured]:
    """The rows that were measured with these sources, and with `keep_found` the faults that others found."""
    kept = [Measured(**json.loads(line)) for line in file.read_text().splitlines()]
    return {
        row.task: row
        for row in kept
        if row.error is None
        and (row.sources == sources or (keep_found and row.kind != "right" and row.claim is not None))
    }


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--only", action="append", default=[], help="a part of `kind name condition depth`; repeatable")
    parser.add_argument("--depth", choices=FAULT_DEPTHS, help="of mutants and defects; by default both")
    parser.add_argument(
        "--draw", type=int,
        help="so many mutants, or with --load runs, drawn with the published seed; by default all",
    )  # fmt: skip
    parser.add_argument("--load", type=int, default=0, help="right integrators alone, beside so many busy processes")
    parser.add_argument("--rows", type=Path, default=Path("runs/verification.jsonl"))
    parser.add_argument("--out", type=Path, default=Path("reports/local/verification.json"))
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument(
        "--keep-found", action="store_true",
        help="keep the faults that a claim found with earlier sources: right where claims were added and none was changed",
    )  # fmt: skip
    parser.add_argument("--begun", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.begun:
        print("\n" + json.dumps(asdict(measured(Measured(**json.loads(given.begun))))))
        return 0
    sources = closure("gnomon.harness.verification.verify") or ""
    given.rows.parent.mkdir(parents=True, exist_ok=True)
    given.rows.touch()
    known = read(given.rows, sources, given.keep_found)
    if given.draw is not None and not 0 < given.draw <= len(faulty()):
        parser.error(f"--draw {given.draw}: there are {len(faulty())} mutants to draw from")
    wanted = tasks(given.load, given.draw)
    chosen = [task for task in wanted if not given.only or any(word in str(task) for word in given.only)]
    chosen = [task for task in chosen if given.depth in (None, task.depth)]
    if not chosen:
        parser.error(f"--only {' '.join(given.only)}: nothing that is measured has this in its name")
    try:
        with busy(given.load):
            measure(chosen, known, given.rows, sources, given.workers)
    except KeyboardInterrupt:
        print("interrupted; the same command continues")
        return 130
    shown = [*tasks(), *wanted] if given.load else wanted
    rows = [known[task] for task in shown if task in known and known[task].whole]
    draw = given.draw and not given.load and {"seed": SEED, "mutants": given.draw, "of": len(faulty())}
    found = published([asdict(row) for row in dict.fromkeys(rows)], FAULT_DEPTHS, RIGHT_DEPTH, draw)
    given.out.parent.mkdir(parents=True, exist_ok=True)
    given.out.write_text(json.dumps(found, indent=1) + "\n")
    print(found["text"])
    wrong = found["false_alarms"] or found["not_measured"] or found["survivors_without_reason"]
    return int(bool(wrong) or any(not found[kind]["share"] >= least for kind, least in NEEDED.items()))


if __name__ == "__main__":
    sys.exit(main())
