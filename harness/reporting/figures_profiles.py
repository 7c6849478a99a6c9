"""Integrators over all cases: performance profiles of libraries, and a row for each integrator by kind of system."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import altair as alt
import numpy as np
import pandas as pd
from gnomon.harness.contract.status import CANNOT_RUN
from gnomon.harness.reporting.report_stability import intervals
from gnomon.harness.reporting.style import INK, dressed, hues, records
from gnomon.harness.results import profiles
from gnomon.harness.results.analysis import own
from gnomon.harness.results.profiles import OURS, THIRD_PARTY, Profile
from gnomon.harness.results.rankings import MOST, RANKED, drawn, third_party

TARGETS = {"1e-3": 1e-3, "1e-6": 1e-6, "1e-9": 1e-9}
FACTORS = 10 ** np.linspace(0, 3, 61)
DIGITS = np.arange(0.5, 15.01, 0.25)
FEWEST = 12
"""Smallest number of problems in a profile: a share of all, or of zero, problems is uncertain by 3 over the number."""
KIND_TARGET, KIND_WIDTH = 1e-6, 104


def profile_charts(equal: pd.DataFrame, reduced: pd.DataFrame) -> dict[str, alt.LayerChart]:
    """The charts `profile_1e-3`, `profile_1e-6`, `profile_1e-9` and `profile_digits`, unless they have few problems.

    `equal`: from `rankings.ranked`; `reduced`: from `analysis.settings`. Charts whose names end in `_others` show
    third-party libraries alone, if there are in-house integrators too.
    """
    charts = _charts(equal, reduced)
    ours = reduced["library"] == OURS
    if ours.nunique() > 1:
        alone = _charts(third_party(equal), reduced[~ours], best=False)
        charts |= {f"{name}_others": chart for name, chart in alone.items()}
    return charts


def _charts(equal: pd.DataFrame, reduced: pd.DataFrame, best: bool = True) -> dict[str, alt.LayerChart]:
    """The charts of these rows; `best`: with the best of all third parties."""
    names = reduced.drop_duplicates("integrator_id").set_index("integrator_id")["library"]
    charts = {}
    for word, target in TARGETS.items():
        relative = profiles.ratios(profiles.by_library(profiles.times(equal, target), names.__getitem__))
        if len(relative) >= FEWEST:
            found = profiles.profiles(relative if best else relative.drop(columns=THIRD_PARTY), FACTORS.tolist())
            title = f"time over the least, to an error of {word}; ties are 1 ×"
            charts[f"profile_{word}"] = _chart(
                found, np.log10(FACTORS), title, "format(pow(10, datum.value), '~g') + ' ×'"
            )
    reached = profiles.digits(reduced)
    if len(reached) >= FEWEST:
        most = profiles.by_library(reached, names.__getitem__, "max")
        found = profiles.profiles(most if best else most.drop(columns=THIRD_PARTY), DIGITS.tolist(), above=True)
        charts["profile_digits"] = _chart(found, DIGITS, "decimal digits reached on a hard variant", "datum.value")
    return charts


def _chart(found: Sequence[Profile], places: np.ndarray, title: str, labels: str) -> alt.LayerChart:
    """A line a library with its band, the best of all third parties dashed."""
    names = [one.name for one in found]
    hue = hues(name for name in names if name != THIRD_PARTY) | {THIRD_PARTY: INK}
    colours = [hue[name] for name in names]
    rows = pd.concat(
        pd.DataFrame({"library": one.name, "at": places, "share": one.share, "low": one.low, "high": one.high})
        for one in found
    ).round(4)
    base = alt.Chart(alt.NamedData("profiles"))
    ends = alt.Scale(domain=[float(places[0]), float(places[-1])], nice=False)
    x = alt.X(
        "at:Q", title=title, scale=ends, axis=alt.Axis(labelExpr=labels, labelFlush=False, tickCount=6, tickMinStep=1)
    )
    scale = alt.Scale(domain=names, range=colours)
    colour = alt.Color(
        "library:N", scale=scale, legend=alt.Legend(title=None, orient="top", columns=3, symbolOpacity=1)
    )
    share = {"axis": alt.Axis(format=".0%", tickCount=5), "scale": alt.Scale(domain=[0, 1])}
    tooltip = [
        alt.Tooltip("library:N"),
        alt.Tooltip("share:Q", title="share of the problems", format=".0%"),
        alt.Tooltip("low:Q", title="from (95 %)", format=".0%"),
        alt.Tooltip("high:Q", title="to", format=".0%"),
    ]
    band = base.mark_area(opacity=0.13, interpolate="step-after").encode(
        x=x, y=alt.Y("low:Q", title="share of the problems", **share), y2=alt.Y2("high:Q"), color=colour
    )
    dash = alt.StrokeDashValue([1, 0], condition={"test": f"datum.library === '{THIRD_PARTY}'", "value": [6, 4]})
    lines = base.mark_line(strokeWidth=2.5, interpolate="step-after").encode(
        x=x, y=alt.Y("share:Q", **share), color=colour, strokeDash=dash, tooltip=tooltip
    )
    data = {"profiles": records(rows)}
    return dressed(alt.layer(band, lines).properties(width=640, height=300), data)


def kinds_charts(
    equal: pd.DataFrame, matrix: pd.DataFrame, members: Mapping[str, Sequence[str]]
) -> dict[str, alt.TopLevelMixin]:
    """The charts `kinds`, and `kinds_others` without in-house methods; empty if no integrator reaches the error.

    `equal`: `rankings.ranked`, `matrix`: `analysis.status_matrix`, `members`: the cases of each kind.
    """
    charts = {}
    for name, rows in (("kinds", equal), ("kinds_others", third_party(equal))):
        tried = matrix if name == "kinds" else matrix[matrix["library"].isin(set(rows["library"]))]
        marks = kind_marks(rows, tried, members)
        columns = [
            {"id": kind, "title": kind.partition(":")[0], "decades": True, "ends": (1.0, MOST)}
            for kind in members
            if any(mark["column"] == kind for mark in marks)
        ]
        if columns:
            charts[name] = intervals(columns, marks, KIND_WIDTH)
    return charts


def kind_marks(equal: pd.DataFrame, matrix: pd.DataFrame, members: Mapping[str, Sequence[str]]) -> list[dict[str, Any]]:
    """For each integrator and kind: the median, least and largest ratio of its time to the least time at 1e-6.

    Ties count as equal. The ratios are over the default cases that the integrator reaches; the text gives the number
    of cases that it can run. An integrator that can run no case of a kind has no mark there.
    """
    kind_of = {case: kind for kind, cases in members.items() for case in cases}
    rows = own(equal[equal["target"] == KIND_TARGET])
    rows = rows.assign(ratio=drawn(rows), ranked=rows["cell"] == RANKED)
    tried = own(matrix[~matrix["verdict"].isin(CANNOT_RUN)])
    cases = Counter(
        (name, kind_of[case])
        for name, case in zip(tried["integrator_id"], tried["case"], strict=True)
        if case in kind_of
    )
    known = {key: part for key, part in rows.groupby(["integrator_id", rows["case"].map(kind_of)])}
    found = []
    for (name, kind), count in sorted(cases.items()):
        mark = {"integrator": name, "column": kind, "at": None, "low": None, "high": None, "text": f"none of {count}"}
        part = known.get((name, kind))
        if part is not None:
            low, middle, high = (float(x) for x in np.quantile(part["ratio"], [0.0, 0.5, 1.0]))
            first = part["ranked"] & part["tied"]
            mark |= {"at": middle, "low": low, "high": high}
            mark["text"] = (
                f"{middle:.3g} times the least in the median of the {len(part)} of {count} cases on which it reaches the"
                f" error ({low:.3g} to {high:.3g}); of {part['ranked'].sum()} ranked, alone the fastest on"
                f" {(first & (part['leaders'] == 1)).sum()} and tied on {(first & (part['leaders'] > 1)).sum()}"
            )
        found.append(mark)
    return found
