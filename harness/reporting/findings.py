"""A run in a few sentences, each counted from the rows of the page's tables."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from gnomon.harness.reporting.tables import Cell
from gnomon.harness.results.analysis import own
from gnomon.harness.results.equal_error import TARGETS
from gnomon.harness.results.number_text import counted, join_words, power_text, ratio_text, short_text
from gnomon.harness.results.rankings import (
    ALONE,
    CONDITIONED,
    ONE_LAUNCH,
    RANKED,
    SOLVED,
    TOO_SHORT,
    exact,
    foremost,
    solved,
    telling,
)  # fmt: skip


def findings(
    equal: pd.DataFrame,
    policies: pd.DataFrame,
    kinds: Sequence[Mapping[str, Any]],
    reduced: pd.DataFrame,
    trusted: pd.DataFrame,
) -> list[str]:
    """The run in a few sentences, each counted from its rows.

    `equal`: `rankings.ranked`, `reduced`: `analysis.settings`. No integrator is named as faster or more reliable than another unless the measurements separate the two.
    """
    return [
        *_fastest(own(equal)),
        *_by_kind(kinds),
        *_libraries(own(equal)),
        *_most_reliable(reduced),
        *_tolerances(trusted),
        *_engines(policies),
    ]


def _fastest(equal: pd.DataFrame) -> list[str]:
    """The number of ranked cells, why others are not ranked, and the integrators separated from all others."""
    said = []
    for target in (TARGETS[1], TARGETS[-1]):
        rows = equal[equal["target"] == target]
        if rows.empty:
            continue
        cells = Counter(rows.drop_duplicates("case")["cell"])
        ranked = rows[rows["cell"] == RANKED]
        alone = ranked[ranked["tied"] & (ranked["leaders"] == 1)]["integrator_id"].value_counts()
        ties = cells[RANKED] - int(alone.sum())
        words = [f"{name} on {count}" for name, count in sorted(alone.items(), key=lambda item: (-item[1], item[0]))]
        why = {
            "tie" if ties == 1 else "ties": ties,
            "with one launch, which separates nothing": cells[ONE_LAUNCH],
            "too short to rank": cells[TOO_SHORT],
            "reached by one integrator alone": cells[ALONE],
        }
        rest = ", ".join(f"{count} {word}" for word, count in why.items() if count)
        fastest = f"the launches separate the fastest from all others on {int(alone.sum()) or 'none'}"
        said.append(
            f"At an error of {power_text(target)}, of the {counted(cells.total(), 'case')} where any integrator reaches it,"
            f" {fastest}{': ' if words else ''}{', '.join(words)}{f'; {rest}' if rest else ''}."
        )
    return said


def _by_kind(kinds: Sequence[Mapping[str, Any]]) -> list[str]:
    """The integrators separated from all others in the count of cells; kinds with one answer are joined."""
    answers: dict[str, list[str]] = {}
    for row in kinds:
        cell: Cell = row["cells"][1]
        if cell.kind != "none":
            head = str(row["head"]).partition(":")[0]
            answers.setdefault(cell.text, []).append(head[:1].lower() + head[1:])
    if not answers:
        return []
    words = [f"{name} for {join_words(heads)}" for name, heads in answers.items()]
    return [
        "By kind of system, the fastest or tied with it at 1e-6 on more cases than any other, where the cases separate"
        f" them: {'; '.join(words)}."
    ]


def _most_reliable(reduced: pd.DataFrame) -> list[str]:
    """The integrator that solves most hard variants, if at least half of the variants are known of it."""
    table = telling(solved(reduced), exact(reduced))
    found = foremost({"": table})[""]
    if len(found.counts) < 2:
        return []
    first = found.first
    near = [*first[:3], f"{len(first) - 3} more"] if len(first) > 3 else first
    alone = f"{first[0]} is separated from all others, by the variants that are known of both"
    claim = f"{join_words(near)} are not separated" if len(first) > 1 else alone
    shown = found.counts.loc[list(dict.fromkeys([*first, *found.counts.index]))[:3]]
    words = [f"{name} {held} of {known}" for name, held, known in shown.itertuples()]
    cases = table.index.get_level_values("case").nunique()
    return [
        f"A hard variant is solved by a setting with an error of at most {power_text(SOLVED)}, or {CONDITIONED:g} times the"
        f" conditioning where that is larger. Of the {len(found.counts)} integrators with a known result on at"
        f" least half of {counted(len(table), 'hard variant')} of {cases} cases, {claim}: of those known, {', '.join(words)}."
    ]


def _tolerances(trusted: pd.DataFrame) -> list[str]:
    rows = own(trusted)
    grouped = rows.dropna(subset=["over_tolerance"]).groupby("integrator_id")["over_tolerance"]
    middle = grouped.median()[grouped.size() >= rows["case"].nunique() / 2].sort_values()
    if len(middle) < 2:
        return []
    within = int((middle <= 1).sum())
    return [
        f"A tolerance bounds the error of a step, not of the motion: {within} of the {len(middle)} adaptive integrators that accept at least"
        f" half of the cases keep the error below it on half of these; {middle.index[-1]} exceeds it by a median factor of"
        f" {short_text(float(middle.iloc[-1]))}."
    ]


def _libraries(equal: pd.DataFrame) -> list[str]:
    """The number of ranked cases on which each library's best integrator is slower than the fastest; median factor."""
    rows = equal[(equal["target"] == TARGETS[1]) & (equal["cell"] == RANKED)]
    words = []
    for library, part in rows.groupby("library"):
        best = part.loc[part.groupby("case")["ratio"].idxmin()]
        slower = best.loc[best["slower"], "ratio"]
        if len(slower):
            words.append((float(slower.median()), f"{library} on {len(slower)} of {len(best)}, by a median factor of"))
    if not words:
        return []
    told = "; ".join(f"{text} {ratio_text(median)}" for median, text in sorted(words))
    return [
        f"At 1e-6, the best integrator of a library is slower than the fastest, of the ranked cases it reaches: {told}."
    ]


def _engines(policies: pd.DataFrame) -> list[str]:
    if policies.empty:
        return []
    step = float(policies.groupby("step")["problem"].nunique().idxmax())  # the step with the most problems
    at = policies[np.isclose(policies["step"], step)]
    at = at.assign(error=at["error"].fillna(np.inf))  # diverged to nan
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
