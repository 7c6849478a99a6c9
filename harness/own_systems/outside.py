"""Tries the recommendations on systems that are drawn at random: runs each library's methods on them, and judges a table.

`python -m gnomon.harness.own_systems.outside --out runs/outside.sqlite` measures; an equal call goes on after an
interruption, and no reference of a measured system is computed again. Then, without a measurement,
`python -m gnomon.harness.own_systems.outside --out runs/outside.sqlite --judge RUN.sqlite --to reports/outside.json` judges
what a run of the catalogue recommends, and its order of the libraries.
"""

from __future__ import annotations

import argparse
import json
import shlex
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from time import monotonic
from typing import Any

from gnomon.cases.core.forms import Hybrid
from gnomon.cases.core.scene import SceneForm
from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.own_systems.drawn import SEED, Drawn, draw
from gnomon.harness.own_systems.own_system import OwnSystem, make_system
from gnomon.harness.registry import environment, kinds, lookup, representatives
from gnomon.harness.results import reading, study_file
from gnomon.harness.results.advice import outside
from gnomon.harness.results.advice.needs import SUBJECTS
from gnomon.harness.results.contenders import OURS
from gnomon.harness.results.opening import results_file
from gnomon.harness.results.store import Store
from gnomon.harness.running import plan, recommending
from gnomon.harness.running.planned_run import run
from gnomon.harness.system.progress import Progress
from gnomon.harness.system.streams import has_terminal

SUITE = "outside"
NOTE = "drawn "
"""Begins the name of a note about a system, in the environment of a run: how it ended, as JSON."""
LIMIT_SECONDS = 1.0
EXPLICIT_WORK = 600_000
"""Work of a reference, four times that of a user's own equations: some 2 min."""
BOUND = 1e-10
"""The largest bound of a reference's error: a tenth of the least error that is judged."""


@dataclass(frozen=True)
class Ended:
    """What a results file notes of a drawn system that is done."""

    seed: int
    why: str
    """Why it was dropped; "" if it was measured."""
    reference: str
    seconds: float
    """Of the computation of its reference."""


def measure(path: Path, systems: Sequence[Drawn], seed: int, limit_seconds: float, progress: Progress) -> None:
    """Measure the systems that the file does not have yet, family by family.

    Raises ValueError for a file with systems of another seed.
    """
    left = [system for system in systems if system.name not in read_ended(path, seed)]
    suite = plan.suite("foundation").within(limit_seconds)
    suite = suite.change(name=SUITE, launches=1, timing_spans=False, turned=False)
    for _, family in groupby(left, key=lambda system: system.family):
        ready: dict[str, tuple[OwnSystem, Ended]] = {}
        needs: dict[str, str] = {}
        for system in family:
            own, end = _make(system, seed)
            progress.tell(f"{system.name}: {end.why or end.reference} ({end.seconds:.0f} s)")
            if own is None:
                _note(path, {system.name: end})
            else:
                ready[system.name], needs[system.name] = (own, end), system.need
        for methods, names in _by_methods({name: methods_of(own, needs[name]) for name, (own, _) in ready.items()}):
            run(path, suite, [(ready[name][0], "") for name in names], methods, progress)
            _note(path, {name: ready[name][1] for name in names})


def _make(drawn: Drawn, seed: int) -> tuple[OwnSystem | None, Ended]:
    """A system with its reference; None if it is dropped."""
    began = monotonic()
    try:
        own = make_system(drawn.stated, (0.0, drawn.span), drawn.start, name=drawn.name, explicit_work=EXPLICIT_WORK)
    except (ArithmeticError, ValueError) as error:
        return None, Ended(seed, f"no reference: {error}", "", monotonic() - began)
    text, why = own.reference.text(), ""
    if own.reference.why:
        why = f"no reference in high precision: {own.reference.why}"
    elif own.reference_error > BOUND:
        why = f"the two methods of its reference differ: {text}"
    return None if why else own, Ended(seed, why, text, monotonic() - began)


def methods_of(own: OwnSystem, need: str) -> tuple[Integrator, ...]:
    """The method that stands for each library, and for gnomon, for a need on a system; without engines and missing ones."""
    # Smooth equations are offered as one mode without events too.
    stated = {type(form).__name__ for form in own.forms if not (own.smooth and isinstance(form, Hybrid))}
    kind = kinds.kind_of(stated)
    assert kind is not None, f"{own.name} is of no kind"
    known = lookup.own()
    stand = [representatives.standing(library, kind, SUBJECTS[need].stands) for library in (*LIBRARIES, OURS)]
    integrators = [known[choice.integrator] for choice in stand if choice is not None]
    return tuple(x for x in integrators if x.accepts != (SceneForm,) and lookup.missing(x) is None)


def _by_methods(methods: Mapping[str, tuple[Integrator, ...]]) -> Iterator[tuple[tuple[Integrator, ...], list[str]]]:
    """The systems that the same methods run on: systems of one family may have several forms."""
    for chosen in dict.fromkeys(methods.values()):
        yield chosen, [name for name, own in methods.items() if own == chosen]


def _note(path: Path, ends: Mapping[str, Ended]) -> None:
    """Record that systems are done."""
    with Store(path) as results:
        number = results.begin_run(SUITE, shlex.join(sys.argv), environment.describe())
        for name, end in ends.items():
            results.note(number, NOTE + name, json.dumps(vars(end)))
        results.end_run(number)


def read_ended(path: Path, seed: int | None = None) -> dict[str, Ended]:
    """The systems that a results file notes as done; none without a file.

    Raises ValueError for systems of several seeds, or of another one than `seed`.
    """
    if not path.exists():
        return {}
    notes = [item for row in reading.runs(path) for item in row["environment"].items() if item[0].startswith(NOTE)]
    ended = {name.removeprefix(NOTE): Ended(**json.loads(text)) for name, text in notes}
    seeds = {end.seed for end in ended.values()} | (set() if seed is None else {seed})
    if len(seeds) > 1:
        raise ValueError(f"{path}: systems of the seeds {', '.join(map(str, sorted(seeds)))}; give another --out")
    return ended


def judge_file(path: Path, catalogue: Path) -> dict[str, Any]:
    """The judgement of a run of the catalogue on a results file, with what was dropped and where it was measured.

    Raises ValueError for a file without systems, and for a file that has not all of its draw.
    """
    ended = read_ended(path)
    if not ended:
        raise ValueError(f"{path}: no systems were measured; run this command without --judge first")
    (seed,) = {end.seed for end in ended.values()}
    drawn = {system.name: system for system in draw(seed)}
    lacking = [name for name in drawn if name not in ended]
    if lacking:
        raise ValueError(
            f"{path}: {len(lacking)} systems of the draw are not measured yet, as {lacking[0]}; repeat the command"
            " without --judge"
        )
    systems = {name: outside.System(x.need, x.family, x.half) for name, x in drawn.items() if not ended[name].why}
    last = [row for row in reading.runs(path) if row["suite"] == SUITE][-1]
    measured = outside.measurements(results_file(catalogue))
    judgement = outside.judge(
        outside.Trials(reading.rows(path), systems),
        lambda margin: recommending.answers(measured, margin),
        outside.find_published_order(measured),
    )
    dropped = [{"name": name, "why": end.why} for name, end in ended.items() if end.why]
    made_by = {name: value for name, value in last["environment"].items() if not name.startswith(NOTE)}
    made_by["date"] = str(last["ended"] or last["started"])[:10]
    return {"environment": made_by, "seed": seed, "drawn": len(drawn), "dropped": dropped} | judgement


def main(words: Sequence[str] | None = None) -> None:
    """The command."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--out", type=Path, required=True, metavar="FILE", help="results file (.sqlite)")
    parser.add_argument("--limit", type=float, default=LIMIT_SECONDS, metavar="S", help="limit of a trial (s)")
    parser.add_argument("--only", nargs="+", default=[], metavar="NAME", help="systems or families, for a try")
    parser.add_argument("--judge", type=Path, metavar="RUN", help="judge this run of the catalogue; measure nothing")
    parser.add_argument("--to", type=Path, default=Path("reports/outside.json"), metavar="FILE")
    options = parser.parse_args(words)
    try:
        if options.judge is not None:
            judgement = judge_file(options.out, options.judge)
            study_file.write(judgement, options.to)
            print(sentence(judgement))
            return
        systems = [system for system in draw() if not options.only or {system.name, system.family} & set(options.only)]
        if not systems:
            names = ", ".join(dict.fromkeys(system.family for system in draw()))
            raise ValueError(f"--only {' '.join(options.only)}: no system of the draw; its families are {names}")
        measure(options.out, systems, SEED, options.limit, Progress(quiet=not has_terminal()))
    except ValueError as error:
        parser.exit(2, f"{error}\n")


def sentence(judgement: Mapping[str, Any]) -> str:
    """The judgement in one sentence."""
    of, by_order = judgement["share"], judgement["order"]
    text = f"{judgement['systems']} systems outside the catalogue: the recommended setting reaches the error"
    if not of["of"]:
        return f"{text} in no trial that counts"
    text += f" in {of['held']} of {of['of']} trials ({_percent(of)})"
    if by_order["of"]:
        text += f", and the published order of two libraries holds in {by_order['held']} of {by_order['of']} ({_percent(by_order)})"
    return text


def _percent(of: Mapping[str, Any]) -> str:
    return f"{100 * of['share']:.3g} %, 95 % interval {100 * of['low']:.3g} to {100 * of['high']:.3g} %"


if __name__ == "__main__":
    main()
