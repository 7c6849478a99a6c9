"""Which integrator to choose: by kind of system, and every integrator on one line."""

import math
from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from typing import Any

import numpy as np
import pandas as pd
from gnomon.harness.contract.declared import declared
from gnomon.harness.registry import lookup
from gnomon.harness.reporting.tables import (
    Cell,
    Row,
    first_use_text,
    other_side,
    ratio_text,
    short_text,
    time_text,
)
from gnomon.harness.results.analysis import NEVER_RAN, TARGETS
from gnomon.harness.results.rankings import standings
from gnomon.harness.running.own_equations import lines

_PAGE = declared("reporting", "templates/page.toml")
KINDS: dict[str, list[str]] = _PAGE["kinds"]
"""Kinds of systems by the most structured form that a case offers; the first match counts."""
CARD: list[str] = _PAGE["card"]["heads"]


def kinds(forms: Mapping[str, AbstractSet[str]], names: Sequence[str]) -> dict[str, list[str]]:
    """The cases of each kind, in the order of KINDS, those without any left out. `forms`: what each case offers."""
    found: dict[str, list[str]] = {}
    for words, marks in KINDS.items():
        known = {name for members in found.values() for name in members}
        members = [name for name in names if name not in known and not forms[name].isdisjoint(marks)]
        if members:
            found[words] = members
    return found


def kind_rows(equal: pd.DataFrame, matrix: pd.DataFrame, members: Mapping[str, Sequence[str]]) -> list[dict[str, Any]]:
    """Per kind of system, what is most often fastest at each error, and what solves most of its hard variants.

    The note of a cell: on how many of the cases where any integrator reaches the error it is fastest or on a par; then
    the best of the other side (`other_side`), its median ratio of time, and on how many cases.
    """
    own = equal[(equal["variant"] == "") & (equal["formulation"] == "")]
    rows = []
    for words, cases in members.items():
        mine = own[own["case"].isin(cases)]
        cells = [_choice(mine[mine["target"] == target]) for target in TARGETS]
        rows.append({"head": words, "cases": list(cases), "cells": [*cells, _most_reliable(matrix, cases)]})
    return rows


def lines_of(kinds: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    """For each integrator named in rows of `kind_rows` that this gnomon has: the lines that run it on other equations."""
    named = dict.fromkeys(cell.text for row in kinds for cell in row["cells"])
    known = lookup.everything()
    found = {name: lines(known[name]) for name in named if name in known}
    return {name: text for name, text in found.items() if text is not None}


def _choice(rows: pd.DataFrame) -> Cell:
    """The integrator that is most often fastest or on a par; of several, the one that is less slow on the other cases.

    Then the best of the other side: third-party beside in-house and in-house beside third-party; if there is only one
    side, of another library. That is the one that reaches the error most often: ratios on a few easy cases do not compare.
    """
    if rows.empty:
        return Cell("not reached", kind="none")
    counts = standings(rows)
    best = counts.iloc[0]
    note = f"fastest on {best['wins']} of {rows['case'].nunique()}"
    word, others = other_side(counts, best["library"])
    if len(others):
        rival = others.sort_values(["reached", "ratio"], ascending=[False, True], kind="stable").iloc[0]
        note += f"; {word}{rival.name} {ratio_text(rival['ratio'])}\N{NO-BREAK SPACE}× on\N{NO-BREAK SPACE}{rival['reached']}"
    return Cell(str(best.name), note)


def _most_reliable(matrix: pd.DataFrame, cases: Sequence[str]) -> Cell:
    """The integrators with an ok setting on most hard variants of the cases."""
    each, problems = solved(matrix[matrix["case"].isin(cases)])
    if each.empty:
        return Cell("–", "no hard variant was run", "none")
    best = each[each["solved"] == each["solved"].max()].index.tolist()
    note = f"{each['solved'].max()} of {problems}"
    if len(best) > 1:
        note += f"; so {'does' if len(best) == 2 else 'do'} {', '.join(best[1:3])}"
    note += f" and {len(best) - 3} more" if len(best) > 3 else ""
    each = each.assign(library=[str(name).partition(":")[0] for name in each.index])
    word, others = other_side(each, each.loc[best[0], "library"])
    if word and len(others):
        rival = others.sort_values("solved", ascending=False, kind="stable").iloc[0]
        note += f"; {word}{rival.name} {rival['solved']}"
    return Cell(str(best[0]), note)


def solved(matrix: pd.DataFrame) -> tuple[pd.DataFrame, int]:
    """By integrator, `ran`: the hard variants that it ran, and `solved`: those with an ok setting; and how many there are."""
    ran = matrix[(matrix["variant"] != "") & (matrix["formulation"] == "") & ~matrix["verdict"].isin(NEVER_RAN)]
    right = ran.assign(right=ran["best"].notna())
    each = right.groupby("integrator_id").agg(solved=("right", "sum"), ran=("right", "size"))
    return each, len(ran.drop_duplicates(["case", "variant"]))


def card(
    equal: pd.DataFrame,
    trusted: pd.DataFrame,
    orders: pd.DataFrame,
    matrix: pd.DataFrame,
    growth: Mapping[str, Any] | None,
    benched: Mapping[str, Any] | None,
) -> list[Row]:
    """Every integrator on one line, with the columns of CARD, over the default variants of the cases that it accepts.

    `growth` and `benched` are the laws and the orders of gnomon's own integrators, measured by `make bench`.
    """
    own = trusted[(trusted["variant"] == "") & (trusted["formulation"] == "")]
    at = equal[(equal["variant"] == "") & (equal["formulation"] == "") & (equal["target"] == TARGETS[1])]
    counts, (hard, _) = standings(at), solved(matrix)
    preparing = at.groupby("integrator_id")["preparation"].median()
    firsts = at.groupby("integrator_id")[["first_use", "first_case"]].first().to_dict("index")
    laws: dict[str, list[str]] = {}
    for row in (growth or {"rows": []})["rows"]:
        laws.setdefault(f"gnomon:{row['name']}", []).append(str(row["law"]))
    bench = {f"gnomon:{row['name']}": row for row in (benched or {"rows": []})["rows"]}
    measured = orders[(orders["variant"] == "") & (orders["formulation"] == "")].groupby("integrator_id")
    slopes = {str(name): part for name, part in measured}
    rows = []
    for name, part in own.groupby("integrator_id", sort=False):
        good = part[part["best"].notna()]
        digits = -np.log10(good["best"].clip(lower=1e-17))
        lost = np.log10(good["best"].clip(lower=1e-17) / good["attainable"].clip(lower=1e-17)).clip(lower=0)
        speed = counts.loc[name] if name in counts.index else None
        cells = [
            Cell(str(len(part)), value=len(part)),
            Cell("–", value=0)
            if speed is None
            else Cell(f"{speed['wins']}", f"of {speed['reached']}", value=speed["wins"]),
            Cell("–") if speed is None else Cell(f"{ratio_text(speed['ratio'])} ×", value=speed["ratio"]),
            Cell("–")
            if name not in firsts
            else Cell(time_text(preparing[name]), first_use_text(*firsts[name].values()), value=preparing[name]),
            _median(digits, "{:.1f}"),
            _median(lost, "{:.1f}"),
            _order(slopes.get(str(name)), bench.get(str(name))),
            _median(part["over_tolerance"], ""),
            _share(hard.loc[name] if name in hard.index else None),
            Cell("; ".join(dict.fromkeys(laws.get(str(name), ["–"])))),
        ]
        rows.append((0 if speed is None else -speed["wins"], -len(part), str(name), cells))
    return [Row(name, cells) for *_, name, cells in sorted(rows, key=lambda row: row[:3])]


def _median(values: pd.Series, form: str) -> Cell:
    found = values.dropna()
    if found.empty:
        return Cell("–")
    middle = float(found.median())
    return Cell(form.format(middle) if form else short_text(middle), value=middle)


def _order(slopes: pd.DataFrame | None, bench: Mapping[str, str] | None) -> Cell:
    """The order from `make bench`, else the median of those measured in the run, beside the declared one."""
    if bench is not None:
        return Cell(bench["order"], f"declared {bench['declared']}", value=float(bench["order"]))
    if slopes is None:
        return Cell("–")
    declared = float(slopes["declared"].iloc[0])
    found = slopes["order"].dropna()
    said = f"declared {declared:.0f}" if math.isfinite(declared) else ""
    if found.empty:
        return Cell("–", said)
    return Cell(
        f"{found.median():.2f}", f"on {len(found)}" + (f", {said}" if said else ""), value=float(found.median())
    )


def _share(hard: pd.Series | None) -> Cell:
    if hard is None:
        return Cell("–")
    share = hard["solved"] / hard["ran"]
    return Cell(f"{100 * share:.0f} %", f"{hard['solved']} of {hard['ran']}", value=share)
