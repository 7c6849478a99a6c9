"""Tables of families of methods on each problem, and the problems that separate methods at equal cost."""

import math
from typing import Any

import pandas as pd
from gnomon.harness.registry.families import FAMILIES, OTHER, family_of
from gnomon.harness.registry.selection import DEFAULT
from gnomon.harness.reporting.page.case_tables import Tables
from gnomon.harness.reporting.page.representing import label
from gnomon.harness.reporting.report_run import Run
from gnomon.harness.results import families
from gnomon.harness.results.families import Family, Separation
from gnomon.harness.results.number_text import error_text, figures_text, power_text, time_text
from gnomon.harness.results.profiles import OURS
from gnomon.harness.studies.constraint_errors import COLUMNS
from markupsafe import escape

AXES = (families.TIME, families.CALLS)
APART = 1e3
"""Least ratio of the median error to the best one, at equal cost, with which a problem is listed."""


def family_tables(run: Run) -> Tables:
    """For every problem a table of its families."""
    tables: Tables = {}
    further = horizon_rows(run) | constraint_rows(run)
    for (case, variant), of in run.sweeps.items():
        rows = families.families(of)
        if any(math.isfinite(row.error) for row in rows):
            table = f"<tbody>{''.join(map(_row, rows))}</tbody>{further.get((case, variant or DEFAULT), '')}"
            tables.setdefault(case, {})[variant or DEFAULT] = table
    return tables


def horizon_rows(run: Run) -> dict[tuple[str, str], str]:
    """For each chaotic problem, how closely the methods of each family follow the motion, as further rows of its table.

    Its largest error says little where rounding alone has grown to the size of the motion: at each sample the error counts
    as a multiple of the conditioning there.
    """
    judged = run.along_the_way
    if judged.empty:
        return {}
    judged = judged.assign(family=judged["integrator_id"].map(family_of))
    order = [*FAMILIES, OTHER]
    tables = {}
    for (case, variant), rows in judged.groupby(["case", "variant"]):
        by = sorted(rows.groupby("family"), key=lambda group: order.index(group[0]))
        horizon = figures_text(float(rows["horizon"].iloc[0]), 3)
        head = (
            f"<tr><td colspan=4>Chaotic: at the horizon, {horizon} s, half an ulp of the numbers has grown to an error of 1. "
            "So each sample's error counts as a multiple of the conditioning there:</td></tr>"
        )
        names = "<tr><th>family</th><th>within 10 times</th><th>closest</th><th>its largest multiple</th></tr>"
        tables[case, variant] = f"<tbody>{head}{names}{''.join(_along(family, of) for family, of in by)}</tbody>"
    return tables


def _along(family: str, of: pd.DataFrame) -> str:
    best = of.groupby("integrator_id").agg({"to_the_end": "any", "times_conditioning": "min"})
    ratio = float(best["times_conditioning"].min())
    closest = (_name(best["times_conditioning"].idxmin()), error_text(ratio)) if math.isfinite(ratio) else ("–", "–")
    cells = (f"{int(best['to_the_end'].sum())} of {len(best)}", *closest)
    return f"<tr><th>{escape(family)}</th>{''.join(f'<td>{cell}</td>' for cell in cells)}</tr>"


def constraint_rows(run: Run) -> dict[tuple[str, str], str]:
    """For each constrained problem the errors apart, where they are smallest: of each method for constraints, and of each
    other family."""
    judged = run.constraints
    if judged.empty:
        return {}
    family = judged["integrator_id"].map(family_of)
    own = family == "Constrained coordinates"
    judged = judged.assign(family=family, of=judged["integrator_id"].where(own, family))
    order = [*FAMILIES, OTHER]
    tables = {}
    for (case, variant), rows in judged.groupby(["case", "variant"]):
        best = rows.loc[rows.groupby("of")["error_max"].idxmin().dropna()].to_dict("records")
        head = (
            "<tr><td colspan=4>Errors apart, at the setting with the smallest error: largest of the samples; the drift is "
            "the departure from the constraints of the start, in their units.</td></tr>"
        )
        names = "<tr><th>family</th><th>method</th><th>position, velocity, multiplier</th><th>drift, its rate</th></tr>"
        by = sorted(best, key=lambda row: (order.index(row["family"]), row["error_max"]))
        tables[case, variant] = f"<tbody>{head}{names}{''.join(map(_apart, by))}</tbody>"
    return tables


def _apart(row: dict[str, Any]) -> str:
    unbroken = {name: error_text(row[name]).replace("-", "\N{NON-BREAKING HYPHEN}") for name in COLUMNS}
    shown = [", ".join(unbroken[name] for name in names) for names in (COLUMNS[:3], COLUMNS[3:])]
    cells = (_name(row["integrator_id"]), *shown)
    return f"<tr><th>{escape(row['family'])}</th>{''.join(f'<td>{cell}</td>' for cell in cells)}</tr>"


def _row(row: Family) -> str:
    fastest = f"{_name(row.fastest)} <small>{time_text(row.seconds)}</small>" if math.isfinite(row.seconds) else "–"
    closest = f"{_name(row.closest)} <small>{error_text(row.error)}</small>" if math.isfinite(row.error) else "–"
    cells = (f"{row.succeed} of {row.ran}", fastest, closest)
    return f"<tr><th>{escape(row.name)}</th>{''.join(f'<td>{cell}</td>' for cell in cells)}</tr>"


def _name(integrator: str) -> str:
    return f"<b>{escape(label(integrator))}</b>"


def separating(run: Run) -> dict[str, Any]:
    """The problems on which the median third party is APART or more from the best, at equal time and at equal evaluations.

    At equal time alone, the overhead of a library separates methods too. The smaller of the two ratios sorts the rows.
    """
    third = {problem: [sweep for sweep in of if sweep.library != OURS] for problem, of in run.sweeps.items()}
    every = [(problem, {axis: families.separation(of, axis) for axis in AXES}) for problem, of in third.items()]
    both = [(problem, of) for problem, of in every if None not in of.values()]
    least = [(min(gap.factor for gap in of.values() if gap is not None), problem, of) for problem, of in both]
    apart = sorted((row for row in least if row[0] >= APART), key=lambda row: -row[0])
    return {
        "compared": len(both),
        "cases": len({case for _, (case, _), _ in apart}),
        "rows": [_separation(*problem, of) for _, problem, of in apart],
        "apart": power_text(APART),
        "order": families.HIGH_ORDER,
        "libraries": families.LIBRARIES,
    }


def _separation(case: str, variant: str, of: dict[str, Separation | None]) -> dict[str, Any]:
    return {"case": case, "variant": variant} | {axis: _text(gap, axis) for axis, gap in of.items() if gap is not None}


def _text(separation: Separation, axis: str) -> dict[str, str]:
    return {
        "best": label(separation.best),
        "family": family_of(separation.best),
        "error": power_text(separation.error),
        "cost": time_text(separation.cost) if axis == families.TIME else f"{separation.cost:.0f} evaluations",
        "median": "no answer" if separation.median >= 1 else error_text(separation.median),
        "among": f"{separation.methods} of {separation.libraries} libraries",
        "factor": f"{'' if separation.median < 1 else '> '}{error_text(separation.factor)}",
    }
