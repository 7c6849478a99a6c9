"""Small multiples: every integrator in a picture of the digits that it reaches, with its numbers in a line."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from gnomon.harness.adapters.libraries import title
from gnomon.harness.reporting.page.case_tables import way
from gnomon.harness.reporting.page.representing import label
from gnomon.harness.reporting.report_run import Run
from gnomon.harness.reporting.tables import digits, first_use_text
from gnomon.harness.results import contenders
from gnomon.harness.results.analysis import first_uses, own
from gnomon.harness.results.number_text import count_text, short_text
from gnomon.harness.results.rankings import find_solved
from markupsafe import Markup

WIDTH, HEIGHT, MOST = 200, 64, 16
"""Pixels of a picture, and the digits at its upper edge."""


def multiples(run: Run, beside: Mapping[str, Any], cases: Sequence[str]) -> dict[str, list[dict[str, Any]]]:
    """For each integrator in its division a picture and its numbers, over the default variants of `cases` that it can run.

    The picture has the digits at the best setting on each case, the most first, and behind it those that double precision
    allows. `beside`: `orders` and `growth`, measured by `make bench`, and `stability`, where they were measured.
    """
    trusted, reduced, orders = (part[part["case"].isin(cases)] for part in (run.trusted, run.reduced, run.orders))
    trusted, hard = own(trusted), find_solved(reduced)
    slopes = {str(name): part for name, part in own(orders).groupby("integrator_id")}
    bench = {f"gnomon:{row['name']}": row for row in (beside.get("orders") or {"rows": []})["rows"]}
    energies, speeds = _energies(beside), _speeds(run, cases)
    uses = first_uses(run.frame).to_dict("index")
    place = {name: k for k, name in enumerate(run.look["series"])}
    by_division: dict[str, list[dict[str, Any]]] = {}
    parts = sorted(trusted.groupby("integrator_id"), key=lambda item: place[str(item[0])])
    for name, part in parts:
        good = part["best"].dropna()
        best = sorted((digits(error) for error in good), reverse=True)
        most = sorted((digits(error) for error in part["attainable"]), reverse=True)
        over = part["over_tolerance"].dropna()
        row = {
            "name": str(name),
            "label": label(str(name)),
            "library": title(str(part["library"].iloc[0])),
            "way": way(str(name)),
            "picture": _picture(best + [0.0] * (len(part) - len(best)), most),
            "cases": len(part),
            "within": int((good <= 1e-6).sum()),
            "failed": int(part["best"].isna().sum()),
            "digits": f"{np.median(best):.1f}" if best else "",
            "order": _order(slopes.get(str(name)), bench.get(str(name))),
            "over": short_text(float(over.median())) if len(over) else "",
            "hard": _say_solved(hard, str(name)),
            "speed": speeds.get(str(name), ""),
            "energy": energies.get(str(name), ""),
            "first": first_use_text(*uses[str(name)].values()) if str(name) in uses else "",
        }
        by_division.setdefault(contenders.division(str(part["library"].iloc[0])), []).append(row)
    return {
        division: by_division[division]
        for division in (contenders.YOURS, contenders.THIRD, contenders.OWN)
        if division in by_division
    }


def _speeds(run: Run, cases: Sequence[str]) -> dict[str, str]:
    """For each integrator the median of its time over the least of a third party, with the number of cases."""
    rows = own(run.equal)
    rows = rows[rows["case"].isin(cases) & (rows["target"] == 1e-6)]
    third = rows["division"] == contenders.THIRD
    factors = rows.assign(factor=rows["ratio"].where(third, rows["against"])).dropna(subset=["factor"])
    return {
        str(name): f"{short_text(float(part.median()))} × the least time to 1e-6 ({count_text(len(part), 'case')})"
        for name, part in factors.groupby("integrator_id")["factor"]
    }


def _energies(beside: Mapping[str, Any]) -> dict[str, str]:
    """For each integrator how its energy error grows over long spans: of `make bench`, else of `gnomon stability`."""
    stability = (beside.get("stability") or {"rows": []})["rows"]
    energies = {
        row["integrator"]: sentence.removesuffix(".")
        for row in reversed(stability)
        if row["panel"] == "long_time"
        for sentence in reversed(row["sentences"])
        if "energy" in sentence
    }
    for row in reversed((beside.get("growth") or {"rows": []})["rows"]):
        energies[f"gnomon:{row['name']}"] = f"{row['law']} over {row['periods']} periods of {row['case']}"
    return energies


def _picture(best: Sequence[float], most: Sequence[float]) -> Markup:
    """A step line of digits over cases, in front of the area that is attainable."""
    return Markup(
        f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" preserveAspectRatio="none" aria-hidden="true"><path class="attainable" d="{_steps(most)}V{HEIGHT}H0Z"/>'
        f'<path class="six" d="M0 {_height(6):.0f}H{WIDTH}"/><path class="reached" d="{_steps(best)}"/></svg>'
    )


def _steps(values: Sequence[float]) -> str:
    step = WIDTH / max(len(values), 1)
    return f"M0 {_height(values[0] if values else 0):.1f}" + "".join(
        f"V{_height(value):.1f}H{(k + 1) * step:.1f}" for k, value in enumerate(values)
    )


def _height(value: float) -> float:
    return HEIGHT * (1 - min(value, MOST) / MOST)


def _order(slopes: pd.DataFrame | None, bench: Mapping[str, str] | None) -> str:
    """The order from `make bench`, else the median of the orders measured in the run; empty without either."""
    if bench is not None:
        return f"{bench['order']} (declared {bench['declared']})"
    measured = slopes["order"].dropna() if slopes is not None else pd.Series(dtype=float)
    if slopes is None or measured.empty:
        return ""
    declared = float(slopes["declared"].iloc[0])
    suffix = f", declared {declared:.0f}" if math.isfinite(declared) else ""
    return f"{measured.median():.2f} (median of {len(measured)}{suffix})"


def _say_solved(hard: pd.DataFrame, name: str) -> str:
    """On how many hard variants of those known of it an integrator solves; empty if it was run on none."""
    known = hard[name].dropna() if name in hard else pd.Series(dtype=float)
    return f"{known.sum():.0f} of {len(known)}" if len(known) else ""
