"""Compares the times of two versions of a package under one integrator: `gnomon verify --against mypackage==1.2`.

The other version is installed, without its dependencies, into a temporary folder. A child process looks for modules in
this folder first, and takes all other modules from the present environment. In each launch two new processes, one with
each version, are timed in turn (A B B A), so that a slow phase of the machine affects both.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Sequence
from itertools import cycle, islice
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import Any

from gnomon.harness.contract.integrator import Integrator, Refused
from gnomon.harness.contract.validation import Unusable
from gnomon.harness.measuring.null_call import null_call
from gnomon.harness.measuring.perturbed_starts import perturb_start
from gnomon.harness.measuring.prepared import Prepared
from gnomon.harness.measuring.reference_solution import CaseSpec
from gnomon.harness.measuring.trials import Trials
from gnomon.harness.registry import lookup, selection
from gnomon.harness.registry.environment import library_version
from gnomon.harness.studies.benchmarks import spread
from gnomon.harness.verification.claims import DEPTHS, TEXTS, TIME, Finding, Outcome, fail_claim, not_applicable
from gnomon.harness.verification.other_version import Other
from gnomon.harness.verification.program_process import ProgramProcess

CLAIM = 1.2
"""A version is slower, or faster, if the ratio of the times exceeds this factor in every launch."""
LEAST_SHARE = 0.1
"""Least share of the whole time that remains without the null call: a smaller share is measurement noise."""
LAUNCHES = 5
"""The range of 5 ratios contains their true median with a probability of 1 - 2^(1 - 5) = 94 %."""
ROUNDS = 4
"""Number of times that A B B A is timed in a launch."""
BLOCK_SECONDS, LONGEST = 0.02, 0.05
"""Seconds of repeated calls in one turn; longest duration of a call, in seconds, at the setting that is timed."""
MOST_NULL = 0.5
"""Largest share of the null call in a time. It is subtracted, and its noise of 10 % would distort larger shares."""
ANSWER_SECONDS = 600.0


def compare_versions(named: str, names: Sequence[str], depth: str, other: Other) -> tuple[str, dict[str, Finding]]:
    """Compare both versions under the integrator `named`: (text with versions and files, finding by case).

    Raises ValueError if a process cannot import the integrator, ends, or imports the files of the wrong version.
    """
    times: dict[str, list[dict[str, Any]]] = {name: [] for name in names}
    settings: dict[str, dict[str, Any]] = {}
    loaded = ""
    for _ in range(LAUNCHES):
        present, before = sides = [_start(named, paths) for paths in (sys.path, [other.folder, *sys.path])]
        try:
            for name in names:
                if name not in settings:
                    settings[name] = _ask(present, other, case=name, depth=depth)
                if "declined" in settings[name]:
                    times[name].append({"declined": f"the present version: {settings[name]['declined']}"})
                else:
                    times[name].append(_launch(sides, other, case=name, depth=depth, **settings[name]))
            loaded = loaded or _list_loaded(present, before, other)
        finally:
            for side in sides:
                side.close()
    return loaded, {name: finding(times[name], other.label) for name in names}


def _start(named: str, paths: Sequence[str]) -> ProgramProcess:
    """A process that looks for modules in `paths` and answers the requests of `serve`."""
    program = f"import sys; sys.path[:] = {list(paths)!r}; from {__name__} import serve; serve({named!r})"
    return ProgramProcess([sys.executable, "-c", program], os.getcwd())


def _ask(side: ProgramProcess, other: Other, **request: Any) -> dict[str, Any]:
    """The answer of a process to a request. Raises ValueError without an answer, or without the integrator."""
    try:
        answer: dict[str, Any] = json.loads(side.ask(json.dumps(request), ANSWER_SECONDS))
    except (Unusable, TimeoutError) as error:
        raise ValueError(f"--against {other.label}: a process that is timed gave no answer: {error}") from None
    if "unknown" in answer:
        raise ValueError(f"--against {other.label}: {answer['unknown']}; both versions must have the integrator")
    return answer


def _launch(sides: Sequence[ProgramProcess], other: Other, **request: Any) -> dict[str, Any]:
    """Time both sides in turn, A B B A.

    Returns `named`, the setting, and pairs (present, other): `seconds`, the least time of a call; `null`, the least time of
    a null call (`measuring.null_call`); `error`. Other processes can only add to a time. If a side has no time, the only
    entry is the reason, `declined`.
    """
    turns: tuple[list[dict[str, Any]], list[dict[str, Any]]] = ([], [])
    for side in islice(cycle((0, 1, 1, 0)), 4 * ROUNDS):
        times = _ask(sides[side], other, **request)
        if "declined" in times:
            return {"declined": f"{('the present version', other.label)[side]}: {times['declined']}"}
        turns[side].append(times)
    least = {name: [min(each[name] for each in own) for own in turns] for name in ("seconds", "null")}
    return least | {"error": [own[0]["error"] for own in turns], "named": turns[0][0]["named"]}


def _list_loaded(present: ProgramProcess, before: ProgramProcess, other: Other) -> str:
    """The files that both processes imported, as text. Raises ValueError if both are of one version."""
    now, then = (_ask(side, other, package=other.name, modules=other.modules) for side in (present, before))
    if not now["files"] or not then["files"]:
        raise ValueError(f"--against {other.label}: the integrator does not import {' or '.join(other.modules)}")
    theirs = [file for file in then["files"] if Path(file).is_relative_to(Path(other.folder).resolve())]
    if not theirs:
        raise ValueError(f"--against {other.label}: both processes load {then['files'][0]}, which is one version")
    return f"{other.name} {now['version']} ({now['files'][0]}) against {other.version} ({theirs[0]})"


def finding(launches: Sequence[dict[str, Any]], label: str) -> Finding:
    """The finding from the launches of one case: slower, faster, or no difference of 1.2 times or more."""
    declined = [launch["declined"] for launch in launches if "declined" in launch]
    if declined:
        return not_applicable(declined[0])
    shares = [launch["null"][side] / launch["seconds"][side] for launch in launches for side in (0, 1)]
    if median(shares) > MOST_NULL:
        return not_applicable(f"{median(shares):.0%} of a call's time is its overhead, which is not compared")
    now, then = ([_net(launch, side) for launch in launches] for side in (0, 1))
    ratio = spread([a / b for a, b in zip(now, then, strict=True)])
    errors = " and ".join(f"{error:.2g}" for error in launches[-1]["error"])
    got = (
        f"{ratio['median']:.3g} times the time of {label} ({ratio['low']:.3g} to {ratio['high']:.3g} over"
        f" {len(launches)} launches), with errors of {errors}"
    )
    if ratio["low"] > CLAIM:
        return fail_claim(
            launches[-1]["named"], f"at most {CLAIM} times the time of {label}", got, TEXTS[TIME]["reason"]
        )
    faster = ratio["high"] < 1 / CLAIM
    verdict = "faster" if faster else f"no difference of {CLAIM} times or more is shown"
    return Finding(Outcome.PASSED, setting=launches[-1]["named"], got=f"{verdict}: {got}")


def _net(launch: dict[str, Any], side: int) -> float:
    """The time of a call without the null call, so that the work of the steps is compared."""
    seconds, null = float(launch["seconds"][side]), float(launch["null"][side])
    return max(seconds - null, LEAST_SHARE * seconds)


def serve(named: str) -> None:
    """Answer requests, one a line, in a child process; discard all that the integrator prints."""
    answers, null = os.fdopen(os.dup(1), "w", buffering=1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, 1)
    os.dup2(null, 2)
    series: dict[str, _Series] = {}
    for line in sys.stdin:
        request, stage = json.loads(line), "unknown"
        try:
            integrator = lookup.find_one(named)
            stage = "declined"
            if "package" in request:
                answer = _describe_imported(request["package"], request["modules"])
            else:
                case, setting = request["case"], request.get("setting")
                case_series = series[case] = series.get(case) or _Series(integrator, case, request["depth"])
                answer = {"setting": case_series.find_setting()} if setting is None else case_series.time_calls(setting)
        except Exception as error:  # the user's code may raise anything: it is shown
            answer = {stage: f"{type(error).__name__}: {error}"}
        answers.write(json.dumps(answer) + "\n")


def _describe_imported(package: str, modules: Sequence[str]) -> dict[str, Any]:
    """The version of a package, and the files of its modules that this process has imported."""
    own = [module for name, module in sorted(sys.modules.items()) if name.partition(".")[0] in modules]
    files = [str(Path(file).resolve()) for module in own if (file := getattr(module, "__file__", None))]
    return {"version": library_version(package) or "of unknown version", "files": files}


class _Series:
    """One integrator on one case, with a solver for each setting that was used so far."""

    def __init__(self, integrator: Integrator, name: str, depth: str) -> None:
        ((case, _),) = selection.choose([name], variants=False)
        self.trials = Trials.of(integrator, CaseSpec.of(case), DEPTHS[depth])
        near = islice(perturb_start(case, None, self.trials.reference.sizes), 64)
        self.starts = cycle([self.trials.start, *near])
        self.solvers: dict[float, tuple[Prepared, float]] = {}

    def find_setting(self) -> float:
        """The setting to compare at: the finest one, from the usual one on, whose call takes at most LONGEST seconds."""
        finest = self.trials.usual()
        for setting in self.trials.settings[self.trials.settings.index(finest) + 1 :]:
            solver, _ = self._prepare(setting)
            if min(self._time_call(solver), self._time_call(solver)) > LONGEST:
                break
            finest = setting
        return finest

    def time_calls(self, setting: float) -> dict[str, Any]:
        """Time calls for BLOCK_SECONDS: the least `seconds` of a call, of its `null` call, its `error`, the setting's name."""
        solver, error = self._prepare(setting)
        seconds: list[float] = []
        end = perf_counter() + BLOCK_SECONDS
        while not seconds or perf_counter() < end:
            seconds.append(self._time_call(solver))
        null, _ = null_call(self.trials.integrator, self.trials.problem, setting, self.starts)
        null = null or 0.0  # None: the null call failed
        return {"seconds": min(seconds), "null": null, "error": error, "named": self.trials.named(setting)}

    def _prepare(self, setting: float) -> tuple[Prepared, float]:
        """The solver at a setting, after its first call, and the error of its solution."""
        if setting not in self.solvers:
            answer = self.trials.whole(setting)
            if answer.declined:
                raise Refused(answer.why)
            solver = self.trials.prepared(self.trials.problem(), setting)
            self._time_call(solver)
            self.solvers[setting] = solver, answer.error
        return self.solvers[setting]

    def _time_call(self, solver: Prepared) -> float:
        """The seconds of one call from the next start."""
        return solver.timed(next(self.starts), keep=False).seconds
