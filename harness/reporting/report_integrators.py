"""The choice of an integrator: by kind of system, and every integrator on one line."""

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
    leads_cell,
)
from gnomon.harness.results.analysis import own
from gnomon.harness.results.equal_error import TARGETS
from gnomon.harness.results.number_text import counted, ratio_text, short_text, time_text
from gnomon.harness.results.rankings import (
    FEWEST,
    Foremost,
    exact,
    foremost,
    leading,
    solved,
    standings,
    telling,
)
from gnomon.harness.running.own_equations import lines

_PAGE = declared("reporting", "templates/page.toml")
KINDS: dict[str, list[str]] = _PAGE["kinds"]
"""Kinds of systems by the most structured form that a case offers; the first match counts."""
HEADS: list[str] = _PAGE["card"]["heads"]
SHOWN = 3
"""The number of integrators that a cell names with their counts."""


def kinds(forms: Mapping[str, AbstractSet[str]], names: Sequence[str]) -> dict[str, list[str]]:
    """The cases of each kind, in the order of KINDS, without empty kinds. `forms`: the forms that each case offers."""
    found: dict[str, list[str]] = {}
    for words, marks in KINDS.items():
        known = {name for members in found.values() for name in members}
        members = [name for name in names if name not in known and not forms[name].isdisjoint(marks)]
        if members:
            found[words] = members
    return found


def kind_rows(equal: pd.DataFrame, reduced: pd.DataFrame, members: Mapping[str, Sequence[str]]) -> list[dict[str, Any]]:
    """Per kind of system, the integrators that are fastest in most cells at each error and solve most hard variants.

    A cell names the integrator that is separated from all others, or gives the number of integrators that are not
    separated. Ties count. Cases that an integrator solves exactly by construction show nothing about it
    (`rankings.exact`), and fewer than `FEWEST` cases show nothing. `named`: the integrators in the cells. `equal`:
    `rankings.ranked`, `reduced`: `analysis.settings`.
    """
    default, hard, known = own(equal), solved(reduced), exact(reduced)
    fast = {
        (kind, target): telling(leading(default[default["case"].isin(cases) & (default["target"] == target)]), known)
        for kind, cases in members.items()
        for target in TARGETS
    }
    sturdy = {kind: telling(hard[hard.index.isin(cases, level="case")], known) for kind, cases in members.items()}
    fastest, solvers = foremost(fast), foremost(sturdy)
    rows = []
    for kind, cases in members.items():
        found = [fastest[kind, target] for target in TARGETS]
        cells = [_most(one, fast[kind, target], "ranked") for target, one in zip(TARGETS, found, strict=True)]
        cells.append(_most(solvers[kind], sturdy[kind], "variant"))
        named = dict.fromkeys(name for one in (*found, solvers[kind]) for name in _shown(one))
        rows.append({"head": kind, "cases": list(cases), "cells": cells, "named": list(named)})
    return rows


def _most(found: Foremost, table: pd.DataFrame, what: str) -> Cell:
    """A cell with the integrator separated from all others, or the number not separated, and counts of the first."""
    if found.counts.empty:
        few = f"fewer than {FEWEST} cases"
        return Cell("–", f"{few} are ranked" if what == "ranked" else f"hard variants of {few}", "none")
    words = ", ".join(f"{name} {held} of {known}" for name, held, known in found.counts.loc[_shown(found)].itertuples())
    text = found.first[0] if len(found.first) == 1 else f"{len(found.first)} not separated"
    cases = counted(table.index.get_level_values("case").nunique(), "case")
    said = f"{cases} ranked" if what == "ranked" else f"{counted(len(table), what)} of {cases}"
    return Cell(str(text), f"of {said}: {words or 'none'}", "none" if len(found.first) > 1 else "")


def _shown(found: Foremost) -> list[str]:
    """The integrators that a cell names: the first ones that hold on any problem."""
    return [str(name) for name in found.counts.index[found.counts["held"] > 0]][:SHOWN]


def lines_of(kinds: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    """The code lines that run each integrator on other equations, if rows of `kind_rows` name it and it is known."""
    known = lookup.everything()
    found = {
        name: lines(known[name]) for name in dict.fromkeys(n for row in kinds for n in row["named"]) if name in known
    }
    return {name: text for name, text in found.items() if text is not None}


def integrator_rows(
    equal: pd.DataFrame,
    trusted: pd.DataFrame,
    orders: pd.DataFrame,
    reduced: pd.DataFrame,
    growth: Mapping[str, Any] | None,
    benched: Mapping[str, Any] | None,
) -> list[Row]:
    """Every integrator on one line, with the columns of HEADS, over the default variants of the cases that it accepts.

    `growth` and `benched` are the laws and the orders of gnomon's own integrators, measured by `make bench`.
    """
    at = own(equal[equal["target"] == TARGETS[1]])
    counts, hard = standings(at).to_dict("index"), solved(reduced)
    preparing = at.groupby("integrator_id")["preparation"].median()
    firsts = at.groupby("integrator_id")[["first_use", "first_case"]].first().to_dict("index")
    laws: dict[str, list[str]] = {}
    for row in (growth or {"rows": []})["rows"]:
        laws.setdefault(f"gnomon:{row['name']}", []).append(str(row["law"]))
    bench = {f"gnomon:{row['name']}": row for row in (benched or {"rows": []})["rows"]}
    slopes = {str(name): part for name, part in own(orders).groupby("integrator_id")}
    rows = []
    for name, part in own(trusted).groupby("integrator_id", sort=False):
        good = part[part["best"].notna()]
        digits = -np.log10(good["best"].clip(lower=1e-17))
        lost = np.log10(good["best"].clip(lower=1e-17) / good["attainable"].clip(lower=1e-17)).clip(lower=0)
        speed = counts.get(name)
        cells = [
            Cell(str(len(part)), value=len(part)),
            leads_cell(speed),
            Cell("–") if speed is None else Cell(f"{ratio_text(speed['ratio'])} ×", value=speed["ratio"]),
            Cell("–")
            if name not in firsts
            else Cell(time_text(preparing[name]), first_use_text(*firsts[name].values()), value=preparing[name]),
            _median(digits, "{:.1f}"),
            _median(lost, "{:.1f}"),
            _order(slopes.get(str(name)), bench.get(str(name))),
            _median(part["over_tolerance"], ""),
            _share(hard[name].dropna() if name in hard else None, len(hard)),
            Cell("; ".join(dict.fromkeys(laws.get(str(name), ["–"])))),
        ]
        rows.append((0 if speed is None else -speed["leads"], -len(part), str(name), cells))
    return [Row(name, cells) for *_, name, cells in sorted(rows, key=lambda row: row[:3])]


def _median(values: pd.Series, form: str) -> Cell:
    found = values.dropna()
    if found.empty:
        return Cell("–")
    middle = float(found.median())
    return Cell(form.format(middle) if form else short_text(middle), value=middle)


def _order(slopes: pd.DataFrame | None, bench: Mapping[str, str] | None) -> Cell:
    """The order from `make bench`, else the median of the orders measured in the run, beside the declared one."""
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


def _share(known: pd.Series | None, problems: int) -> Cell:
    """The share of hard variants solved, of the variants with a known result, and the number of other variants."""
    if known is None or known.empty:
        return Cell("–")
    share, others = known.mean(), problems - len(known)
    note = f"{known.sum():.0f} of {len(known)}" + (f"; {others} not known" if others else "")
    return Cell(f"{100 * share:.0f} %", note, value=share)
