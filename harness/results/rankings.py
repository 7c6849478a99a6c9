"""Rankings of integrators from a results file, and whether they survive changes of what was compared.

The ranking at an error is by the area under the performance profile: the mean over the default cases of the logarithm of
the ratio to the fastest, where a ratio above MOST and a case that is not solved count as MOST. Everything is computed from
the measurements that are there; what other default numbers would give is not known from them. A longer time limit can add
no solve that is faster than the limit was, so that its largest effect is known.
"""

import itertools
import math
import statistics
from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd
from gnomon.harness.contract.status import STOPPED
from gnomon.harness.results.analysis import CLAIM, compared, times_to
from gnomon.harness.results.profiles import OURS

MOST = 1e3
"""The largest ratio of a performance profile."""
LIMIT_SHARE = 0.1
"""The share of its time limit that a solve may take, in the ranking with a shorter limit."""

KIND, ERROR, LAUNCH, LIMIT, LONGER = (
    "one kind of system left out",
    "another error measure",
    "one launch left out",
    "a tenth of the time limit",
    "any longer time limit, at most",
)


class Pair(NamedTuple):
    """An integrator that reaches an error on a default case: the ratio of its time to the fastest's."""

    case: str
    name: str
    library: str
    ratio: float

    @property
    def tied(self) -> bool:
        return self.ratio < CLAIM


Comparison = Mapping[float, Sequence[Pair]]
"""The pairs by error."""
Alternatives = dict[tuple[str, str], Comparison]
"""Comparisons by the kind of change and the change."""


def comparison(equal: pd.DataFrame) -> Comparison:
    """The pairs of default variants in their own formulation, from what `analysis.equal_error` returns."""
    rows, columns = _own(equal), ("target", "case", "integrator_id", "library", "ratio")
    found: dict[float, list[Pair]] = {}
    for target, *pair in zip(*(rows[name].tolist() for name in columns), strict=True):
        found.setdefault(target, []).append(Pair(*pair))
    return found


def third_party(equal: pd.DataFrame) -> pd.DataFrame:
    """The rows of third-party integrators, with ratios to the fastest of these."""
    return compared(equal[equal["library"] != OURS])


def without_ours(compared_: Comparison) -> Comparison:
    """`third_party` for a comparison."""
    found = {}
    for target, pairs in compared_.items():
        others = [pair for pair in pairs if pair.library != OURS]
        least: dict[str, float] = {}
        for pair in others:
            least[pair.case] = min(pair.ratio, least.get(pair.case, math.inf))
        found[target] = [pair._replace(ratio=pair.ratio / least[pair.case]) for pair in others]
    return found


def alternatives(frame: pd.DataFrame, equal: pd.DataFrame, kinds: Mapping[str, Sequence[str]]) -> Alternatives:
    """The default variants compared again: without each kind of system, with two other error measures, without each
    launch, without solves that took more than a tenth of their time limit, and with all that the limit stopped solved just
    then.

    `frame`: `analysis.tidy`, `equal`: `analysis.equal_error` of it, `kinds`: the cases of each kind.
    """
    base, frame = comparison(equal), _own(frame)
    found: Alternatives = {}
    for name, cases in kinds.items() if len(kinds) > 1 else ():
        found[KIND, name] = {target: [one for one in pairs if one.case not in cases] for target, pairs in base.items()}
    for column, words in (("error_end", "error at the end"), ("error_rms", "root mean square error")):
        found[ERROR, words] = _again(frame.assign(error_max=frame[column]))
    repeated = frame[frame.groupby("case")["launch"].transform("max") > 1]
    often = set(repeated["case"])
    for launch in sorted(repeated["launch"].unique()):
        again = _again(repeated[repeated["launch"] != launch])
        found[LAUNCH, f"launch {launch}"] = {
            target: [one for one in base.get(target, ()) if one.case not in often] + list(again.get(target, ()))
            for target in {**base, **again}
        }
    quick = ~(frame["seconds_median"] > LIMIT_SHARE * frame["limit_seconds"].astype(float))
    found[LIMIT, LIMIT] = _again(frame[quick])
    found[LONGER, LONGER] = _at_the_limit(base, _own(equal), frame)
    return found


def _at_the_limit(base: Comparison, equal: pd.DataFrame, frame: pd.DataFrame) -> Comparison:
    """The comparison if each integrator that the time limit stopped on a case reached every error there, at the limit.

    With a longer limit a solve takes longer than that, or fails: its ranking is between this one and that of `base`.
    """
    names = ("case", "integrator_id", "library", "limit_seconds")
    stopped: dict[tuple[str, str, str], float] = {}
    rows = frame[frame["status"].isin(STOPPED) & frame["limit_seconds"].notna()]
    for *key, limit in zip(*(rows[name].tolist() for name in names), strict=True):
        case, name, library = key
        stopped[case, name, library] = min(float(limit), stopped.get((case, name, library), math.inf))
    fastest = equal.groupby(["target", "case"])["seconds"].min().to_dict()
    found = {}
    for target, pairs in base.items():
        reached = {(pair.case, pair.name) for pair in pairs}
        found[target] = list(pairs) + [
            Pair(case, name, library, max(1.0, limit / fastest.get((target, case), limit)))
            for (case, name, library), limit in stopped.items()
            if (case, name) not in reached
        ]
    return found


def _again(frame: pd.DataFrame) -> Comparison:
    return comparison(compared(times_to(frame)))


def _own(table: pd.DataFrame) -> pd.DataFrame:
    """The rows of default variants in the case's own formulation."""
    return table[(table["variant"] == "") & (table["formulation"] == "")]


def scores(pairs: Sequence[Pair]) -> dict[str, float]:
    """By integrator the mean logarithm of its ratio over the cases that some integrator solves, smaller is better."""
    most, cases = math.log10(MOST), {pair.case for pair in pairs}
    found: dict[str, float] = {}
    for pair in pairs:
        gain = most - min(math.log10(pair.ratio), most)
        found[pair.name] = found.get(pair.name, most) - gain / len(cases)
    return found


def kendall(first: Mapping[str, float], second: Mapping[str, float]) -> float:
    """Kendall's tau-b of two scores of the same names; a name that one lacks has the worst score there. nan for fewer
    than two names, or if all scores of one are equal. Scores closer than 1e-9 are equal."""
    names = sorted({*first, *second})
    if len(names) < 2:
        return math.nan
    signs = []
    for values in (first, second):
        held = np.array([round(values.get(name, math.log10(MOST)), 9) for name in names])
        signs.append(np.sign(held[:, None] - held[None, :]))
    product = math.sqrt(np.sum(signs[0] ** 2) * np.sum(signs[1] ** 2))
    return float(np.sum(signs[0] * signs[1]) / product) if product else math.nan


def winner(pairs: Sequence[Pair], cases: Collection[str] | None = None) -> str | None:
    """The integrator that is the fastest or on a par with it on most cases, of all or of these; None without pairs.

    Of several the one that reaches more cases, then the one with the smaller mean logarithm of its ratio (`standings`).
    """
    counts: dict[str, list[float]] = {}
    for pair in pairs:
        if cases is None or pair.case in cases:
            count = counts.setdefault(pair.name, [0, 0, 0.0])
            count[0] -= pair.tied
            count[1] -= 1
            count[2] += math.log10(pair.ratio)
    return min(
        counts, key=lambda name: (counts[name][0], counts[name][1], counts[name][2] / -counts[name][1]), default=None
    )


def library_ratios(pairs: Sequence[Pair]) -> dict[str, tuple[float, int]]:
    """By library the median of the ratios of its best integrator, and on how many cases."""
    best: dict[str, dict[str, float]] = {}
    for pair in pairs:
        own = best.setdefault(pair.library, {})
        own[pair.case] = min(pair.ratio, own.get(pair.case, math.inf))
    return {library: (statistics.median(own.values()), len(own)) for library, own in sorted(best.items())}


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


def taus(base: Comparison, changed: Alternatives, targets: Sequence[float]) -> pd.DataFrame:
    """For each kind of change and error the smallest tau of its rankings with that of all, which change that is, and how
    many there are: columns change, target, tau, worst, count."""
    rows = []
    for kind, members in itertools.groupby(changed, key=lambda name: name[0]):
        names = list(members)
        for target in targets:
            before = scores(base.get(target, ()))
            found = {name: kendall(before, scores(changed[name].get(target, ()))) for name in names}
            known = {name: tau for name, tau in found.items() if math.isfinite(tau)}
            worst = min(known, key=lambda name: known[name], default=("", ""))
            rows.append((kind, target, known.get(worst, math.nan), worst[1], len(names)))
    return pd.DataFrame(rows, columns=["change", "target", "tau", "worst", "count"])
