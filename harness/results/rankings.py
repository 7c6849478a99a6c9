"""Rankings of integrators from a results file, and whether they survive changes of what was compared.

The ranking at an error is by the area under the performance profile: the mean over the default cases of the logarithm of
the ratio to the fastest, where a ratio above MOST and a case that is not solved count as MOST. Everything is computed from
the measurements that are there; what a longer time limit or other numbers would give is not known from them.
"""

import itertools
import math
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from gnomon.harness.results.analysis import compared, equal_error
from gnomon.harness.results.profiles import OURS

MOST = 1e3
"""The largest ratio of a performance profile."""
LIMIT_SHARE = 0.1
"""The share of its time limit that a solve may take, in the ranking with a shorter limit."""

KIND, ERROR, LAUNCH, LIMIT = (
    "one kind of system left out",
    "another error measure",
    "one launch left out",
    "a tenth of the time limit",
)
Alternatives = dict[tuple[str, str], pd.DataFrame]
"""Tables as `analysis.equal_error` returns, by the kind of change and the change."""


def third_party(equal: pd.DataFrame) -> pd.DataFrame:
    """The rows of third-party integrators, with ratios to the fastest of these."""
    return compared(equal[equal["library"] != OURS])


def alternatives(frame: pd.DataFrame, equal: pd.DataFrame, kinds: Mapping[str, Sequence[str]]) -> Alternatives:
    """The default variants compared again: without each kind of system, with two other error measures, without each
    launch, and without solves that took more than a tenth of their time limit.

    `frame`: `analysis.tidy`, `equal`: `analysis.equal_error` of it, `kinds`: the cases of each kind.
    """
    equal = own(equal)
    frame = own(frame)
    found = {(KIND, name): equal[~equal["case"].isin(cases)] for name, cases in kinds.items()} if len(kinds) > 1 else {}
    for column, words in (("error_end", "error at the end"), ("error_rms", "root mean square error")):
        found[ERROR, words] = equal_error(frame.assign(error_max=frame[column]))
    repeated = frame[frame.groupby("case")["launch"].transform("max") > 1]
    rest = equal[~equal["case"].isin(repeated["case"])]
    for launch in sorted(repeated["launch"].unique()):
        again = equal_error(repeated[repeated["launch"] != launch])
        found[LAUNCH, f"launch {launch}"] = pd.concat([rest, again], ignore_index=True)
    quick = ~(frame["seconds_median"] > LIMIT_SHARE * frame["limit_seconds"].astype(float))
    found[LIMIT, LIMIT] = equal_error(frame[quick])
    return found


def own(table: pd.DataFrame) -> pd.DataFrame:
    """The rows of default variants in the case's own formulation."""
    return table[(table["variant"] == "") & (table["formulation"] == "")]


def scores(equal: pd.DataFrame, target: float) -> pd.Series:
    """By integrator the mean logarithm of its ratio over the cases that some integrator solves, smaller is better."""
    at = own(equal)
    at = at[at["target"] == target]
    if at.empty:
        return pd.Series(dtype=float)
    wide = np.log10(at["ratio"]).groupby([at["integrator_id"], at["case"]]).min().unstack()
    return wide.fillna(math.log10(MOST)).clip(upper=math.log10(MOST)).mean(axis=1)


def kendall(first: pd.Series, second: pd.Series) -> float:
    """Kendall's tau-b of two scores of the same names; a name that one lacks has the worst score there. nan for fewer
    than two names, or if all scores of one are equal."""
    names = first.index.union(second.index)
    if len(names) < 2:
        return math.nan
    signs = []
    for values in (first.reindex(names), second.reindex(names)):
        held = values.fillna(math.log10(MOST)).to_numpy(float)
        signs.append(np.sign(held[:, None] - held[None, :]))
    product = math.sqrt(np.sum(signs[0] ** 2) * np.sum(signs[1] ** 2))
    return float(np.sum(signs[0] * signs[1]) / product) if product else math.nan


def winner(equal: pd.DataFrame, target: float, cases: Sequence[str] | None = None) -> str | None:
    """The integrator that is the fastest or on a par with it on most default cases; None if the error is not reached.

    Of several the one that reaches more cases, then the one with the smaller mean logarithm of its ratio.
    """
    counts = standings(at(equal, target, cases))
    return None if counts.empty else str(counts.index[0])


def at(equal: pd.DataFrame, target: float, cases: Sequence[str] | None = None) -> pd.DataFrame:
    """The rows of default cases, of all or of these, at one error."""
    rows = own(equal)
    rows = rows[rows["target"] == target]
    return rows if cases is None else rows[rows["case"].isin(cases)]


def standings(rows: pd.DataFrame) -> pd.DataFrame:
    """By integrator: `wins` (cases on which it is fastest or on a par), cases `reached`, the median `ratio` of its time to
    the fastest's; the most wins first. `rows`: those of `equal_error` at one error.

    Those with equal wins and cases are sorted by `mean`, of the logarithms of the ratios, because a median ignores the
    few cases on which a method is slow.
    """
    pairs = rows.assign(decades=np.log10(rows["ratio"])).groupby("integrator_id")
    # One by one and by built-in names, and `size` for the cases, of which each has one row: a tenth of the time of `agg`.
    found = pd.DataFrame(
        {
            "library": pairs["library"].first(),
            "wins": pairs["tied"].sum(),
            "reached": pairs.size(),
            "ratio": pairs["ratio"].median(),
            "mean": pairs["decades"].mean(),
        }
    )
    return found.sort_values(["wins", "reached", "mean"], ascending=[False, False, True], kind="stable")


def taus(equal: pd.DataFrame, changed: Alternatives, targets: Sequence[float]) -> pd.DataFrame:
    """For each kind of change and error the smallest tau of its rankings with that of all, which change that is, and how
    many there are: columns change, target, tau, worst, count."""
    rows = []
    for kind, members in itertools.groupby(changed, key=lambda name: name[0]):
        names = list(members)
        for target in targets:
            base = scores(equal, target)
            found = {name: kendall(base, scores(changed[name], target)) for name in names}
            known = {name: tau for name, tau in found.items() if math.isfinite(tau)}
            worst = min(known, key=lambda name: known[name], default=("", ""))
            rows.append((kind, target, known.get(worst, math.nan), worst[1], len(names)))
    return pd.DataFrame(rows, columns=["change", "target", "tau", "worst", "count"])
