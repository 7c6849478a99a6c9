"""A run in a few sentences, each counted from the same rows as the tables of the page."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from gnomon.harness.reporting.report_card import solved
from gnomon.harness.reporting.tables import Cell, ratio_text, short_text
from gnomon.harness.results.analysis import CLAIM, TARGETS


def findings(
    equal: pd.DataFrame,
    policies: pd.DataFrame,
    kinds: Sequence[Mapping[str, Any]],
    matrix: pd.DataFrame,
    trusted: pd.DataFrame,
) -> list[str]:
    """The run in a few sentences, each counted from its rows."""
    return [
        *_fastest(equal),
        *_by_kind(kinds),
        *_libraries(equal),
        *_most_reliable(matrix),
        *_tolerances(trusted),
        *_engines(policies),
    ]


def _fastest(equal: pd.DataFrame) -> list[str]:
    own = equal[(equal["variant"] == "") & (equal["formulation"] == "")]
    said = []
    for target in (TARGETS[1], TARGETS[-1]):
        at = own[own["target"] == target]
        if at.empty:
            continue
        wins = at[at["tied"]].groupby("integrator_id")["case"].nunique().sort_values(ascending=False)
        said.append(
            f"At an error of {target:.0e}".replace("e-0", "e-")
            + f", {wins.index[0]} is the fastest or on a par with it on {wins.iloc[0]} of the {at['case'].nunique()}"
            f" cases where any integrator reaches it"
            + (f", {wins.index[1]} on {wins.iloc[1]}." if len(wins) > 1 else ".")
        )
    return said


def _by_kind(kinds: Sequence[Mapping[str, Any]]) -> list[str]:
    """What is most often fastest, kinds with the same answer together."""
    answers: dict[str, list[str]] = {}
    for row in kinds:
        cell: Cell = row["cells"][1]
        if cell.kind != "none":
            head = str(row["head"]).partition(":")[0]
            answers.setdefault(cell.text, []).append(head[:1].lower() + head[1:])
    if len(answers) < 2:
        return []
    words = [f"{name} for {_listed(heads)}" for name, heads in answers.items()]
    return [f"By kind of system, most often the fastest at 1e-6: {'; '.join(words)}."]


def _listed(words: Sequence[str]) -> str:
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def _most_reliable(matrix: pd.DataFrame) -> list[str]:
    """Of the integrators that ran on at least half of the hard variants, those that solved the largest share."""
    each, problems = solved(matrix)
    most = each[each["ran"] >= problems / 2]
    if most.empty:
        return []
    share = (most["solved"] / most["ran"]).sort_values(ascending=False, kind="stable")
    words = [f"{name} on {most.loc[name, 'solved']} of {most.loc[name, 'ran']}" for name in share.index[:3]]
    return [
        f"Of those that accept at least half of the {problems} hard variants, most reliable (some setting is ok within the time limit): {', '.join(words)}."
    ]


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


def _libraries(equal: pd.DataFrame) -> list[str]:
    own = equal[(equal["variant"] == "") & (equal["formulation"] == "")]
    middle = own[own["target"] == TARGETS[1]]
    best = middle.groupby(["library", "case"])["ratio"].min().groupby("library").agg(["median", "size"])
    slower = best[best["median"] >= CLAIM].sort_values("median")
    if slower.empty:
        return []
    words = [f"{library} {ratio_text(row['median'])} times on {row['size']:.0f}" for library, row in slower.iterrows()]
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
