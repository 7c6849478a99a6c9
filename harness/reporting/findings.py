"""A run in a few sentences, each counted from the same rows as the tables of the page."""

from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from typing import Any

import numpy as np
import pandas as pd
from gnomon.harness.reporting.report_card import solved
from gnomon.harness.reporting.tables import Cell, other_side, ratio_text, short_text
from gnomon.harness.results.analysis import CLAIM, TARGETS
from gnomon.harness.results.profiles import OURS
from gnomon.harness.results.rankings import Comparison, comparison, library_ratios, standings, winner


def findings(
    equal: pd.DataFrame,
    policies: pd.DataFrame,
    kinds: Sequence[Mapping[str, Any]],
    matrix: pd.DataFrame,
    trusted: pd.DataFrame,
    changed: Mapping[Any, Comparison] | None = None,
) -> list[str]:
    """The run in a few sentences, each counted from its rows.

    A sentence on which integrator or library is faster is left out if it does not hold in one of the tables `changed` (see
    `rankings.alternatives`), and so is one on reliability that does not hold without one of the kinds of systems.
    """
    tables = list((changed or {}).values())
    return [
        *_fastest(equal, tables),
        *_by_kind(kinds, tables),
        *_libraries(equal, tables),
        *_most_reliable(matrix, [row["cases"] for row in kinds] if len(kinds) > 1 else ()),
        *_tolerances(trusted),
        *_engines(policies),
    ]


def _fastest(equal: pd.DataFrame, changed: Sequence[Comparison]) -> list[str]:
    said = []
    own = equal[(equal["variant"] == "") & (equal["formulation"] == "")]
    for target in (TARGETS[1], TARGETS[-1]):
        rows = own[own["target"] == target]
        counts = standings(rows)
        if counts.empty or _others(changed, target) - {str(counts.index[0])}:
            continue
        first, second = counts.iloc[0], counts.iloc[1:2]
        _, beside = other_side(counts, first["library"])
        second = beside.iloc[:1] if OURS in set(counts["library"]) else second
        said.append(
            f"At an error of {target:.0e}".replace("e-0", "e-")
            + f", {first.name} is the fastest or on a par with it on {first['wins']} of the {rows['case'].nunique()}"
            " cases where any integrator reaches it"
            + "".join(f", {_side(counts, one)}{one.name} on {one['wins']}" for _, one in second.iterrows())
            + "."
        )
    return said


def _side(counts: pd.DataFrame, row: pd.Series) -> str:
    """Which side the best of the other side is, if there are two."""
    if not counts["library"].eq(OURS).nunique() > 1:
        return ""
    return f"the best {'in-house' if row['library'] == OURS else 'third-party'} one "


def _others(changed: Sequence[Comparison], target: float, cases: Sequence[str] | None = None) -> AbstractSet[str]:
    """The integrators that are most often the fastest in the changed comparisons."""
    found = {winner(one.get(target, ()), cases) for one in changed}
    return {name for name in found if name is not None}


def _by_kind(kinds: Sequence[Mapping[str, Any]], changed: Sequence[Comparison]) -> list[str]:
    """What is most often fastest, kinds with the same answer together."""
    answers: dict[str, list[str]] = {}
    for row in kinds:
        cell: Cell = row["cells"][1]
        if cell.kind != "none" and not _others(changed, TARGETS[1], row["cases"]) - {cell.text}:
            head = str(row["head"]).partition(":")[0]
            answers.setdefault(cell.text, []).append(head[:1].lower() + head[1:])
    if len(answers) < 2:
        return []
    words = [f"{name} for {_listed(heads)}" for name, heads in answers.items()]
    return [f"By kind of system, most often the fastest at 1e-6: {'; '.join(words)}."]


def _listed(words: Sequence[str]) -> str:
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def _most_reliable(matrix: pd.DataFrame, kinds: Sequence[Sequence[str]]) -> list[str]:
    """Of the integrators that ran on at least half of the hard variants, those that solved the largest share."""
    share = _shares(matrix)
    if share.empty:
        return []
    for cases in kinds:
        rest = _shares(matrix[~matrix["case"].isin(cases)])
        if len(rest) and rest.get(share.index[0], 0.0) < rest.iloc[0]:
            return []
    each, problems = solved(matrix)
    words = [f"{name} on {each.loc[name, 'solved']} of {each.loc[name, 'ran']}" for name in share.index[:3]]
    return [
        f"Of those that accept at least half of the {problems} hard variants, most reliable (some setting is ok within the time limit): {', '.join(words)}."
    ]


def _shares(matrix: pd.DataFrame) -> pd.Series:
    """The share that each solved, of the integrators that ran on at least half of the hard variants; the largest first."""
    each, problems = solved(matrix)
    most = each[each["ran"] >= problems / 2]
    return (most["solved"] / most["ran"]).sort_values(ascending=False, kind="stable")


def _tolerances(trusted: pd.DataFrame) -> list[str]:
    own = trusted[(trusted["variant"] == "") & (trusted["formulation"] == "")]
    grouped = own.dropna(subset=["over_tolerance"]).groupby("integrator_id")["over_tolerance"]
    middle = grouped.median()[grouped.size() >= own["case"].nunique() / 2].sort_values()
    if len(middle) < 2:
        return []
    within = int((middle <= 1).sum())
    return [
        f"A tolerance bounds the error of a step, not of the motion: {within} of the {len(middle)} adaptive integrators that accept at least"
        f" half of the cases keep the error below it on half of these; {middle.index[-1]} exceeds it by a median factor of"
        f" {short_text(float(middle.iloc[-1]))}."
    ]


def _libraries(equal: pd.DataFrame, changed: Sequence[Comparison]) -> list[str]:
    target = TARGETS[1]
    found = library_ratios(comparison(equal).get(target, ()))
    again = [library_ratios(one.get(target, ())) for one in changed]
    slower = {
        library: ratio
        for library, ratio in sorted(found.items(), key=lambda item: item[1][0])
        if all(each[library][0] >= CLAIM for each in (found, *again) if library in each)
    }
    if not slower:
        return []
    words = [f"{library} {ratio_text(median)} times on {count}" for library, (median, count) in slower.items()]
    return [
        "At 1e-6, the time of the best integrator of each other library over that of the fastest, as a median over the"
        f" cases that it reaches: {', '.join(words)}."
    ]


def _engines(policies: pd.DataFrame) -> list[str]:
    if policies.empty:
        return []
    step = float(policies.groupby("step")["problem"].nunique().idxmax())  # the step with the most problems
    at = policies[np.isclose(policies["step"], step)]
    at = at.assign(error=at["error"].fillna(np.inf))  # diverged to what is no number
    wide = at.pivot_table(index=["engine", "problem"], columns="policy", values="error", aggfunc="min")
    both = wide.reindex(columns=["as shipped", "configured"]).dropna()
    if both.empty:
        return []
    gain = float((both["as shipped"] / both["configured"]).median())
    smaller = f"; configured for the scene, its error is smaller by a median factor of {ratio_text(gain)}"
    return [
        f"At a step of {step:g} s the error of an engine as shipped is above a tenth of the motion on"
        f" {(both['as shipped'] > 0.1).sum()} of {len(both)} problems{smaller if np.isfinite(gain) else ''}."
    ]
