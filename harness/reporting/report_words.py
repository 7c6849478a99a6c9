"""The rows and sentences of the page and the summary."""

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from gnomon.harness.adapters.absent import ABSENT
from gnomon.harness.adapters.libraries import title
from gnomon.harness.contract.status import Status
from gnomon.harness.registry import environment
from gnomon.harness.registry.representatives import representative
from gnomon.harness.reporting import (
    provenance,
    report_benchmarks,
    report_checks,
    report_stability,
    sidecars,
    style,
    tables,
)
from gnomon.harness.reporting.page.case_tables import WAYS, case_tables
from gnomon.harness.reporting.page.family_tables import family_tables, separating
from gnomon.harness.reporting.page.first_screen import first_screen
from gnomon.harness.reporting.page.league import league
from gnomon.harness.reporting.page.multiples import multiples
from gnomon.harness.reporting.page.need_cards import make_need_cards
from gnomon.harness.reporting.page.representing import Representatives
from gnomon.harness.reporting.report_charts import Problems
from gnomon.harness.reporting.report_missing import missing
from gnomon.harness.reporting.report_run import Run
from gnomon.harness.results import analysis, number_text, store, summary
from gnomon.harness.results.advice import recommendations
from gnomon.harness.results.break_even import break_even
from gnomon.harness.results.contenders import ALONE, OWN, THIRD, UNDECIDED, YOURS
from gnomon.harness.results.equal_error import TARGETS
from gnomon.harness.results.profiles import OURS
from gnomon.harness.results.time_ratios import FASTEST, OPEN
from gnomon.harness.running.call_cost import PYTHON_CALL
from gnomon.harness.studies.drift import laws

MARKS = {"reaches": "●", "rough": "◐", "fails": "✕", "cannot": "–", "unrun": "○"}
DIVISIONS = {
    "yours": "Yours",
    "third": "Third-party libraries",
    "own": "gnomon’s own methods, in a division of their own",
}


def page_words(run: Run, folders: Sequence[Path], work: dict[str, Problems]) -> dict[str, Any]:
    """The values of the templates of page and summary, without the charts.

    Certificates and benchmarks are read from the first of `folders` that has them.
    """
    ran = run.reduced[~run.reduced["status"].isin(analysis.NEVER_RAN)]
    own = ran[ran["variant"] == ""].drop_duplicates(["case", "formulation"])
    problems = [
        (name, formulation)
        for name in run.names
        for formulation in own.loc[own["case"] == name, "formulation"].tolist() or [""]
    ]
    runs = [each for each in store.runs(run.path) if each["run"] in set(run.frame["run"])]
    environments = [each["environment"] for each in runs]
    ran_libraries = set(ran["library"])
    libraries = Representatives(run)
    first = first_screen(libraries)
    unknown = dict.fromkeys(set(run.names) - set(own["case"]), "default variant not run")
    unknown |= dict.fromkeys(set(run.names) - set(libraries.complete), "not all has run yet")
    beside = _beside(folders, environments)
    return {
        "results": "/".join(run.path.resolve().parts[-2:]),
        "runs": runs,
        "missing": missing(run.outstanding),
        "history": runs[-1],
        "environment": together(environments),
        "made": tell_origin(environments, environment.describe()),
        "limits": libraries.limits,
        "limited": {status: f" ({libraries.limit_seconds})" if status in LIMITED else "" for status in style.MEANINGS},
        "machines": machines_text(run.frame),
        **_comparisons(run),
        **_load(run.frame),
        **beside,
        "first": first,
        "opened": first["lead"]["case"] if first["lead"] else str(run.frame["case"].iloc[0]),
        "marks": MARKS,
        "chosen": list_chosen(first["stands"]),
        "needs": make_need_cards(libraries, beside["margin"]),
        "absent": ABSENT,
        "both_divisions": OURS in ran_libraries and len(ran_libraries) > 1,
        "divisions": DIVISIONS,
        "multiples": multiples(run, beside, libraries.complete),
        "fastest": tables.fastest(run.equal, problems, unknown, run.equal_later),
        "break_even": _break_even(run, libraries.complete),
        "solves": tables.BREAK_EVEN_HEADS,
        "times": case_tables(run),
        "families": family_tables(run),
        "separating": separating(run),
        "targets": [number_text.power_text(target) for target in TARGETS],
        "cases": _cases(run, work),
        "counts": _counts(run, ran),
        "shares": tables.status_shares(run.reduced),
        "chapters": run.chapters,
        "failures": tables.failure_groups(analysis.failures(run.reduced)),
        "hierarchies": hierarchy_rows(run.hierarchies),
        "engine_settings": engine_settings(run.frame),
        "tolerances": tolerances_text(run.trusted[run.trusted["case"].isin(libraries.complete)]),
        "engines": engines_text(run.policies),
        "python_call": PYTHON_CALL,
        "meanings": style.MEANINGS,
        "letters": {name: letter for name, letter in style.LETTERS.items() if letter.strip()},
        "colours": style.STATUS_COLOURS,
    }


def _comparisons(run: Run) -> dict[str, Any]:
    """What comparisons of times rest on: the scatter, the ways to the equations that tell it apart, the open cells."""
    return {"scatter": run.scatter[OWN], "ways": WAYS, "open": open_text(run.equal)}


def _break_even(run: Run, complete: Sequence[str]) -> list[dict[str, Any]]:
    """The costs of libraries for one solve and for many, on cases that all of them ran."""
    equal = run.equal_error[run.equal_error["case"].isin(complete)]
    return tables.break_even_parts(break_even(equal, analysis.load_seconds(run.frame).to_dict()))


def _load(frame: pd.DataFrame) -> dict[str, Any]:
    times = [*zip(frame["seconds_median"], frame["delay_seconds"], strict=True)]
    load = summary.load_of(times)
    share = "" if math.isnan(load.share) else f"{100 * load.share:.0f} %"
    return {"waited": number_text.tell_waits(*summary.count_waits(times)), "waits": share, "loaded": load.high}


def _beside(folders: Sequence[Path], environments: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """What the files beside the page say, and where they come from."""
    parts, outside = provenance.origins(folders, environments[-1]), sidecars.first("outside.json", *folders)
    return {
        "older": [_origin_text(part) for part in parts if part.older],
        "processors": provenance.processors_text([*environments, *(part.environment for part in parts if part.timed)]),
        "outside": "" if outside is None else recommendations.outside_text(outside),
        "margin": 1.0 if outside is None else outside["margin"],
        "certified": report_checks.render_certificates(*folders),
        "certified_lines": report_checks.list_certificates(*folders),
        "benchmarks": report_benchmarks.benchmarks(*folders),
        "orders": report_benchmarks.orders(*folders),
        "growth": report_benchmarks.growth(*folders),
        "league": league(*folders),
        "stability": report_stability.stability(*folders),
    }


def _origin_text(part: provenance.Origin) -> str:
    """A part of the page that other sources made."""
    details = [f"revision {part.revision}" if part.revision else "revision unknown", part.date[:10]]
    return f"{part.part} ({', '.join(filter(None, details))}; {part.command} makes it again)"


def _counts(run: Run, ran: pd.DataFrame) -> dict[str, Any]:
    libraries = set(ran["library"])
    own = len(run.own)
    known = len(run.names) - own
    subject = [
        f"{number_text.count_text(known, 'case')} of classical mechanics with exact solutions" if known else "",
        f"{number_text.count_text(own, 'problem')} of own equations, with a computed reference" if own else "",
    ]
    return {
        "subject": " · ".join(filter(None, subject)),
        "own": own,
        "cases": len(run.names),
        "problems": len(run.problems),
        "integrators": ran["integrator_id"].nunique(),
        "libraries": len(libraries),
        "not_installed": sorted(set(run.frame["library"]) - libraries),
        "trials": len(ran),
    }


def list_chosen(stands: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """For each library the methods that stand for it, with the kinds of systems and the words of its manual."""
    chosen = []
    for stand in stands:
        methods: dict[str, dict[str, Any]] = {}
        for kind, name in stand["methods"].items():
            method = representative(stand["name"], kind)
            if name is None or method is None:
                continue
            row = {"id": name, "kinds": [], "quote": method.quote, "source": method.source}
            methods.setdefault(name, row)["kinds"].append(number_text.lower_first(kind.partition(":")[0]))
        if len(methods) == 1:
            next(iter(methods.values()))["kinds"] = []
        if methods:
            chosen.append({"title": stand["title"], "methods": list(methods.values())})
    return chosen


def tolerances_text(trusted: pd.DataFrame) -> str:
    """How many adaptive integrators keep the error below the tolerance, in a sentence; empty if fewer than two ran."""
    rows = analysis.own(trusted)
    grouped = rows.dropna(subset=["over_tolerance"]).groupby("integrator_id")["over_tolerance"]
    middle = grouped.median()[grouped.size() >= rows["case"].nunique() / 2].sort_values()
    if len(middle) < 2:
        return ""
    within = int((middle <= 1).sum())
    return (
        f"A tolerance bounds the error of a step, not of the motion: {within} of the {len(middle)} adaptive integrators"
        " that accept at least half of the cases keep the error below it on half of these."
    )


def engines_text(policies: pd.DataFrame) -> str:
    """How much an engine's error changes if it is configured for the scene, in a sentence; empty without a comparison."""
    if policies.empty:
        return ""
    step = float(policies.groupby("step")["problem"].nunique().idxmax())  # the step with the most problems
    at = policies[np.isclose(policies["step"], step)]
    at = at.assign(error=at["error"].fillna(np.inf))  # diverged to nan
    wide = at.pivot_table(index=["engine", "problem"], columns="policy", values="error", aggfunc="min")
    both = wide.reindex(columns=["as shipped", "configured"]).dropna()
    if both.empty:
        return ""
    gain = float((both["as shipped"] / both["configured"]).median())
    alone = len(both) == 1
    factor = f"a {'' if alone else 'median '}factor of {number_text.ratio_text(gain)}"
    smaller = f"; configured for the scene, its error is smaller by {factor}" if np.isfinite(gain) else ""
    large = int((both["as shipped"] > 0.1).sum())
    where = f"{large} of {len(both)} problems"
    if alone:
        where = f"the only problem with both, {both.index[0][1]}" if large else "no problem, of one with both"
    return (
        f"At a step of {step:g} s the error of an engine as shipped is above a tenth of the motion on {where}{smaller}."
    )


def _cases(run: Run, work: dict[str, Problems]) -> list[dict[str, Any]]:
    """Each case with its variants and the rows of its tables."""
    limits = limits_text(run.reduced)
    grown = laws(run.path, run.frame, run.frame["variant"] == "", run.classes)
    parts = analysis.anatomy(run.frame[run.frame["variant"] == ""])
    stability = tables.stability_rows(run.matrix, run.trusted, run.orders, grown, parts)
    unrun, lacking = _not_run(run)
    return [
        {
            "name": name,
            "title": run.titles[name],
            "section": run.sections[name],
            "stresses": {label: problem["stresses"] for label, problem in work[name].items()},
            "unrun": unrun.get(name, []),
            "lacking": lacking.get(name, {}),
            "limit": limits.get(name, ""),
            "stability": stability.get(name, []),
        }
        for name in run.names
    ]


def _not_run(run: Run) -> tuple[dict[str, list[str]], dict[str, dict[str, str]]]:
    """By case the variants that nobody ran, and for other ones, and a case that is under way, in words what did not run."""
    matrix = run.matrix[run.matrix["formulation"] == ""]
    unrun: dict[str, list[str]] = {}
    lacking: dict[str, dict[str, str]] = {}
    for (case, variant), part in matrix[matrix["variant"] != ""].groupby(["case", "variant"], sort=False):
        missing_ = part["verdict"] == analysis.NOT_RUN
        if missing_.all():
            unrun.setdefault(str(case), []).append(str(variant))
            continue
        counts = part[missing_].groupby("library")["integrator_id"].nunique()
        if len(counts):
            words = ", ".join(f"{counted} of {title(str(name))}" for name, counted in counts.items())
            lacking.setdefault(str(case), {})[str(variant)] = f"Not run on this variant: {words}."
    outstanding: dict[str, list[str]] = {}
    for row in run.outstanding.planned:
        if row.measured < row.trials:
            outstanding.setdefault(row.case, []).append(f"{row.trials - row.measured} of {title(row.library)}")
    for case, words_ in outstanding.items():
        text = f"Trials of this case that have not run yet: {', '.join(words_)}. What they would reach is not known."
        lacking.setdefault(case, {})["default"] = text
    return unrun, lacking


def machines_text(frame: pd.DataFrame) -> str:
    """The number of machines that measured the trials that ran, in words."""
    count = frame.loc[~frame["status"].isin(analysis.NEVER_RAN), "machine"].nunique()
    if count == 1:
        return "one machine"
    return f"{count} machines: a time is compared only with times of the same machine"


def limits_text(reduced: pd.DataFrame) -> dict[str, str]:
    """By case the time limits of a trial on its default variant, in words. `reduced`: `analysis.settings`."""
    limits = reduced[(reduced["variant"] == "") & (reduced["limit_seconds"] > 0)].groupby("case")["limit_seconds"]
    return {
        str(name): f"Each trial may take {low:g} s{f', one of an engine {high:g} s' if high > low else ''}."
        for name, (low, high) in limits.agg(["min", "max"]).iterrows()
    }


LIMITED = (Status.TIMEOUT, Status.SKIPPED)
"""Statuses that depend on the time limit of a trial, which stands beside them."""


def tell_origin(environments: Sequence[Mapping[str, str | None]], writer: Mapping[str, str]) -> str:
    """Which code measured, and which wrote the page. `writer`: the environment of the process that writes it."""

    def code(versions: Sequence[tuple[str | None, str | None]]) -> str:
        texts = [
            f"gnomon {version or '?'}, " + (f"revision {at}" if at else "of no known revision")
            for version, at in versions
        ]
        return number_text.join_words(texts)

    measured = list(dict.fromkeys((record.get("gnomon"), record.get("revision")) for record in environments))
    return f"Measured by {code(measured)}; written by {code([(writer.get('gnomon'), writer.get('revision'))])}."


def open_text(equal: pd.DataFrame) -> str:
    """How many cells of each division are open, and of gnomon's methods how many pairs. `equal`: `Run.equal`."""
    own = analysis.own(equal)
    cells = own.drop_duplicates(["case", "target", "division"])
    words = {THIRD: "third parties", YOURS: "your integrators", OWN: "gnomon's methods"}
    parts = []
    for name, text in words.items():
        kinds = cells.loc[(cells["division"] == name) & (cells["cell"] != ALONE), "cell"]
        if len(kinds):
            parts.append(f"{(kinds == UNDECIDED).sum()} of {number_text.count_text(len(kinds), 'cell')} of {text}")
    pairs = own.loc[(own["division"] == OWN) & (own["cell"] != ALONE) & (own["state"] != FASTEST), "state"]
    if len(pairs):
        parts[-1] += f" ({(pairs == OPEN).sum()} of their {number_text.count_text(len(pairs), 'pair')})"
    return f"open: {', '.join(parts)}" if parts else "no cell has two integrators"


def together(environments: Sequence[dict[str, str | None]]) -> dict[str, str]:
    """The environments of several runs in one file as one: each name has all its values, in the order of the runs."""
    by_name: dict[str, list[str]] = {}
    for each in environments:
        for name, value in each.items():
            known = by_name.setdefault(name, [])
            if value is not None and value not in known:
                known.append(value)
    return {name: ", ".join(values) for name, values in by_name.items()}


def hierarchy_rows(levels: pd.DataFrame) -> list[dict[str, Any]]:
    """Rows of model hierarchies: the error without each effect, the time with it, and the shortest times."""
    return [
        level
        | {name: number_text.short_text(level[name]) if level[name] else "0" for name in ("error", "early")}
        | {"cost": f"{level['ratio']:.2f}" if np.isfinite(level["ratio"]) else "–", "shortest": _shortest(level)}
        for level in levels.to_dict("records")
    ]


def _shortest(level: Mapping[str, Any]) -> str:
    """The shortest time of a third party, then of a method of gnomon if it is shorter."""
    pairs = {level["third"]: level["third_seconds"], level["fastest"]: level["seconds"]}
    return "; ".join(f"{name} {number_text.time_text(seconds)}" for name, seconds in pairs.items() if name) or "–"


def engine_settings(frame: pd.DataFrame) -> list[dict[str, Any]]:
    """Changed engine settings, gathered by engine and setting: values and the policies that set them."""
    changed = frame.loc[~frame["settings_changed"].isin(("", "{}")), [*analysis.SERIES, "settings_changed"]]
    rows = [
        (row.library, row.integrator_id, name, str(value), row.case)
        for row in changed.drop_duplicates().itertuples()
        for name, value in json.loads(row.settings_changed).items()
    ]
    table = pd.DataFrame(rows, columns=["library", "integrator_id", "option", "value", "case"])
    gathered = []
    for (library, setting, value), part in table.groupby(["library", "option", "value"], sort=False):
        by = {str(name): own["case"] for name, own in part.groupby("integrator_id", sort=False)}
        cases = list(dict.fromkeys(case for own in by.values() for case in own))
        row = {"library": library, "setting": setting, "value": value, "integrators": list(by), "cases": cases}
        gathered.append(row)
    return gathered
