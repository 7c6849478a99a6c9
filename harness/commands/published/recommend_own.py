"""`gnomon recommend --equations`: the methods of the published advice, measured on the equations of a user."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from gnomon.harness.adapters import libraries
from gnomon.harness.commands.equations import once, read_system
from gnomon.harness.commands.options import out, problems
from gnomon.harness.results.advice import recommendations
from gnomon.harness.results.advice.code_lines import argument

if TYPE_CHECKING:
    from gnomon.harness.contract.integrator import Integrator
    from gnomon.harness.own_systems.own_system import OwnSystem
    from gnomon.harness.results.best import Best

Row = Mapping[str, Any]
ERROR = 1e-9
"""The error without --error, as in `gnomon run --equations`."""
LIMIT = 5.0
"""Seconds that a trial may take."""
EQUAL = 1.25
"""Two times of one launch within this factor are not told apart."""
ROUGH, ACCURATE = 1e-3, 1e-9
"""Errors from which on, and up to which, smooth systems have subjects of their own."""
BY_FORM = {"NBody": "gravitation", "RigidBody": "rigid", "Constrained": "constraints", "Charged": "magnetic"}
"""The subject of a smooth system that is stated in a form of more structure."""


@dataclass(frozen=True)
class Request:
    """The arguments of the command."""

    subject: str
    """Empty to find it from the equations."""
    error: float | None
    libraries: Sequence[str]
    place: str
    """Of the equations, as mine.py:f."""
    texts: tuple[str | None, str | None, str | None]
    """The texts of --span, --start and --parameters."""
    events: Sequence[str] | None
    accelerations: bool
    out_path: Path | None


@dataclass(frozen=True)
class Measured:
    """The measurements of the candidates on the equations, by method, at one error."""

    system: OwnSystem
    error: float
    rows: Mapping[str, Sequence[Row]]

    def best(self, methods: Sequence[str]) -> Best | None:
        """The fastest of these methods that reaches the error; None if none of them does."""
        # Imported here and not above: a wrong option is refused without numpy.
        from gnomon.harness.results.best import best

        rows = [row for name in methods for row in self.rows.get(name, ())]
        try:
            return best(rows, self.error, self.system.lines)
        except ValueError:
            return None

    def least_error(self, methods: Sequence[str]) -> float | None:
        """The least error of these methods; None without a solution."""
        rows = [row for name in methods for row in self.rows.get(name, ()) if _is_scored(row)]
        return min((_error(row) for row in rows), default=None)

    def explain_hidden(self, methods: Sequence[str]) -> str:
        """Why the error cannot be measured, if the reference is the limit of these methods; else ""."""
        from gnomon.harness.results.best import explain_hidden

        return explain_hidden([row for name in methods for row in self.rows.get(name, ())])

    def at(self, method: str, reliable: Mapping[str, Any]) -> Row | None:
        """The measurement at the loosest setting that is as tight as a published one; None without it."""
        most = reliable["relative"] * self.system.time_scale if reliable["kind"] == "step" else reliable["value"]
        run = [
            row for row in self.rows.get(method, ()) if row["setting"] is not None
        ]  # None: it declines the equations
        tight = [row for row in run if row["setting"] <= most * (1 + 1e-9)]
        return max(tight, key=lambda row: float(row["setting"]), default=None)

    def reason(self, method: str) -> str | None:
        """Why a method solved nothing; None if it did."""
        rows = self.rows.get(method, ())
        if not rows or any(_is_scored(row) for row in rows):
            return None
        return str(rows[0]["reason"] or rows[0]["status"])


def recommend_own(request: Request) -> None:
    """Measure the methods of the advice on the user's equations and print what holds there.

    Exit code 1 if no method reaches the error. Raises ValueError that names a wrong option.
    """
    error = ERROR if request.error is None else request.error
    key = recommendations.subject(request.subject) if request.subject else None
    recommendations.find(key or "smooth", error, request.libraries)  # refuses a wrong option before all work
    with _results(request.out_path) as path:
        system = read_system(request.place, request.texts, request.events, request.accelerations, path)
        subject = key or find_subject(system, error)
        advice = recommendations.find(subject, error, request.libraries)
        how = "" if key else ", found from the equations"
        out.print(f"\n[bold]{advice.title}[/]{how}; error at most {error:g}", highlight=False)
        measured = _measure(path, system, candidates(advice.rows), error)
        for line in _answers(measured, advice.rows):
            out.print(line, highlight=False, markup=False)
        best = measured.best(list(measured.rows))
        if best is None:
            least = measured.least_error(list(measured.rows))
            hidden = measured.explain_hidden(list(measured.rows))
            text = "nothing was solved" if least is None else f"the least error is {least:.2g}"
            text = f"no method of the advice reaches an error of {error:g} here; {text}"
            problems.print(f"an error of {error:g}: {hidden}" if hidden else text, highlight=False)
            raise typer.Exit(1)
        out.print(f"\nthe fastest of these here: {best}", highlight=False, markup=False)


def find_subject(system: OwnSystem, error: float) -> str:
    """The subject of a system: events, fast decays, the form in which it is stated, or else the error alone."""
    forms = {type(form).__name__ for form in system.forms}
    if not system.smooth:
        return "impact" if "Impact" in forms else "events"
    if system.rough.stiff:
        return "stiff"
    of_form = next((key for form, key in BY_FORM.items() if form in forms), None)
    return of_form or ("rough" if error >= ROUGH else "accurate" if error <= ACCURATE else "smooth")


def candidates(rows: Sequence[Row]) -> list[str]:
    """The methods of the advice that take equations: of each library the manual's choice, then its fastest."""
    forms = recommendations.read().forms
    named = [name for row in rows for name in (*row["methods"], *row.get("better", {}).get("methods", ()))]
    return [name for name in dict.fromkeys(named) if forms.get(name)]


@contextmanager
def _results(path: Path | None) -> Iterator[Path]:
    """The file or folder of the results: the user's, or a temporary one."""
    if path is not None:
        yield path
        return
    from gnomon.harness.system.locks import temporary_folder

    with tempfile.TemporaryDirectory(dir=temporary_folder()) as folder:
        yield Path(folder)


def _measure(path: Path, system: OwnSystem, methods: Sequence[str], error: float) -> Measured:
    """Run the methods that are installed; those that are not are named."""
    # Imported here and not above: `gnomon recommend` without equations starts without numpy, pandas and numba.
    from gnomon.harness.registry import lookup
    from gnomon.harness.results import reading
    from gnomon.harness.running import plan
    from gnomon.harness.running.planned_run import run
    from gnomon.harness.system.progress import Progress

    known = lookup.own()
    present: list[Integrator] = []
    for name in methods:
        absent = lookup.missing(known[name])
        if absent is None:
            present.append(known[name])
        else:
            problems.print(f"{name} is not measured: {absent}", highlight=False, markup=False)
    if not present:
        raise ValueError("no method of the advice is installed here; name another --library, or install one")
    suite = once(plan.suite("foundation").within(LIMIT))
    file = run(path, suite, [(system, "")], present, Progress())
    rows: dict[str, list[Row]] = {}
    for row in reading.rows(file):
        if row["case"] == system.name:
            rows.setdefault(row["integrator_id"], []).append(row)
    return Measured(system, error, {integrator.id: rows.get(integrator.id, []) for integrator in present})


def _answers(measured: Measured, rows: Sequence[Row]) -> Iterator[str]:
    """What was measured of each library, and whether the advice on it holds; then whether the published order does."""
    third = [row for row in rows if row["library"] != recommendations.OURS]
    for row in rows:
        named = [name for name in candidates([row]) if name in measured.rows]
        if named:
            yield from _answer(measured, row, named)
    published = {
        row["library"]: row["seconds"]
        for row in third
        if "seconds" in row and measured.best(candidates([row])) is not None
    }
    if len(published) > 1:
        yield from _order(measured, {row["library"]: row for row in third}, published)


def _answer(measured: Measured, row: Row, named: Sequence[str]) -> Iterator[str]:
    """The lines on one library."""
    from gnomon.harness.results.number_text import error_text, time_text

    title, best = libraries.title(row["library"]), measured.best(named)
    if best is None:
        least, hidden = measured.least_error(named), measured.explain_hidden(named)
        reasons = "; ".join(dict.fromkeys(filter(None, map(measured.reason, named))))
        text = reasons if least is None else f"its least error here is {error_text(least)}"
        yield f"\n{title}: {', '.join(named)}{f': {hidden}' if hidden else f' does not reach the error: {text}'}"
    else:
        yield (
            f"\n{title}: {best.method}, {_setting(best)}: {time_text(best.seconds)} a solve,"
            f" error {'below ' if best.below_reference else ''}{error_text(best.error)}"
        )
    for method, reliable in reliable_settings(row).items():
        at = measured.at(method, reliable)
        if at is not None and measured.reason(method) is None:
            yield f"    {_reliable_text(measured, method, reliable, at)}"
    if "better" in row and best is not None:
        yield f"    {_better_text(measured, row)}"


def reliable_settings(row: Row) -> dict[str, Mapping[str, Any]]:
    """The published recommended settings, by method."""
    if "reliable" not in row:
        return {}
    first = row["reliable"]
    return {reliable["method"]: reliable for reliable in (first, *first.get("others", ()))}


def _reliable_text(measured: Measured, method: str, reliable: Mapping[str, Any], at: Row) -> str:
    """Whether the published setting holds here."""
    from gnomon.harness.results.best import is_below_reference
    from gnomon.harness.results.number_text import error_text, time_text

    published = argument(reliable, measured.system.time_scale if reliable["kind"] == "step" else 1.0)
    if not _is_scored(at):
        return f"the published setting, {published} of {method}, does not hold here: {at['reason'] or at['status']}"
    error = _error(at)
    if error > measured.error and is_below_reference(at):
        return f"whether the published setting, {published} of {method}, holds here cannot be measured"
    holds = "holds here" if error <= measured.error else "does NOT hold here"
    cost = f", {time_text(at['seconds_median'])} a solve" if at["seconds_median"] else ""
    return f"the published setting, {published} of {method}, {holds}: error {error_text(error)}{cost}"


def _better_text(measured: Measured, row: Row) -> str:
    """Whether the method that was published as the library's fastest is faster here than the manual's choice."""
    fast, manual = row["better"]["methods"], row["methods"]
    best, other = measured.best(fast), measured.best(manual)
    text = f"published as its fastest: {', '.join(fast)}"
    if all(measured.reason(name) or name not in measured.rows for name in fast):
        return f"{text}; it did not solve these equations, or cannot state them"
    if best is None or other is None:
        return f"{text}; here {'only it reaches' if other is None and best else 'it does not reach'} the error"
    return f"{text}; here {_compare(best.seconds, other.seconds)} {', '.join(manual)}"


def _order(measured: Measured, rows: Mapping[str, Row], published: Mapping[str, float]) -> Iterator[str]:
    """Whether the published fastest library is the fastest here."""
    here = {name: best.seconds for name in published if (best := measured.best(candidates([rows[name]]))) is not None}
    first, fastest = (min(times, key=times.__getitem__) for times in (published, here))
    text = f"\nof these libraries the published fastest is {libraries.title(first)}, and the fastest here"
    if here[first] <= EQUAL * here[fastest]:
        is_apart = fastest != first
        yield f"{text} {f'too, within {EQUAL:g} of {libraries.title(fastest)}' if is_apart else 'too'}"
    else:
        yield f"{text} is {libraries.title(fastest)}, by a factor of {here[first] / here[fastest]:.2g}"


def _compare(seconds: float, other: float) -> str:
    """The words for a time beside another one."""
    if max(seconds, other) <= EQUAL * min(seconds, other):
        return f"it takes the time, within {EQUAL:g}, of"
    return f"it takes {seconds / other:.2g} of the time of"


def _setting(best: Best) -> str:
    """The setting of the best method in its words for `gnomon.solve`, in the time of the problem."""
    return f"{'step' if best.kind == 'step' else 'rtol'}={best.setting:.3g}"


def _is_scored(row: Row) -> bool:
    from gnomon.harness.contract.status import SCORED

    return row["status"] in SCORED


def _error(row: Row) -> float:
    """The error of a measurement, at least the bound of the error of its reference."""
    from gnomon.harness.results.best import error_of

    return error_of(row)
