"""The least of several times and its factors to the others: the one statistic of every comparison of times.

Calls within a launch are not independent, so a launch gives one value, the logarithm of a time. Its scatter between launches
is measured: a run launches one setting of some problems several times, spread over its length (`scatter_of`). The scatter of a class (library, its way to the equations, length of a call) is estimated from all launches of the class. The
scatter of a series combines the scatter of its class with its own (Smyth, Statistical Applications in Genetics and Molecular
Biology 3, 3, 2004). The degrees of freedom follow from the differences of single series from their class, so that heavy tails
widen all intervals. Launches of all series at one time share an effect, because a machine may slow down. The effect cancels
between series that share all launches; launches that only one of them has add to the scatter.

The fastest series of a cell is chosen by its times, so its pairs are corrected for the number of series that could be the
fastest (`compare`). A pair is slower if its claim holds at one false discovery rate for the page, equal if its interval
lies within EQUAL_WITHIN, and open otherwise (`states`).
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.results.equal_error import geometric_mean
from scipy.special import bdtr, digamma, ndtri, polygamma, stdtr, stdtrit

RATE = 0.05
"""The false discovery rate over the claims that are tested together; 1 - RATE is the coverage of intervals."""
EQUAL_WITHIN = 1.25
"""Times are equal if the interval of their ratio lies within this factor."""
NEAR = 1.5
"""Pairs within this factor of the fastest decide whether a cell is open."""
FASTEST, SLOWER, EQUAL, OPEN = "fastest", "slower", "equal", "open"
"""States of a row of a cell: exactly one holds."""
LENGTHS = (1e-4, 1e-2)
"""Bounds (s) between the lengths of calls: microseconds scatter more than seconds."""
LEAST = 0.01
"""Least standard deviation of the logarithm of a time: the resolution of clocks, and alignment of code."""
MOST_FREEDOM = 1e3
"""Degrees of freedom from which on a scatter counts as known."""
LEAST_FREEDOM = 2.0
"""Least degrees of freedom of a series about its class: with fewer, no number of launches would separate series."""
ASSUMED, ASSUMED_FREEDOM = 0.1, 4.0
"""The scatter where no setting of a file was launched twice: three times the one measured on quiet machines."""

Launch = tuple[int, int]
"""Run and launch."""
Class = tuple[str, str, int]
"""(library, its way to call the equations (`Library.way`), the number of LENGTHS that a call exceeds)."""


class Timed(NamedTuple):
    """The times (s) of an integrator by launch, on a problem at one error or one setting."""

    integrator_id: str
    times: Mapping[Launch, float]

    @property
    def kind(self) -> Class:
        """The class of its scatter."""
        library, _, name = self.integrator_id.partition(":")
        way = LIBRARIES[library].way(name) if library in LIBRARIES else ""
        return library, way, sum(self.middle > bound for bound in LENGTHS)

    @property
    def middle(self) -> float:
        """The geometric mean of the times."""
        return geometric_mean(self.times.values())


class Compared(NamedTuple):
    """A series against the fastest of its cell: the ratio of times, its interval, and the p value of "not slower"."""

    ratio: float
    low: float
    high: float
    p: float


class Known(NamedTuple):
    """A variance of logarithms of times, and the degrees of freedom with which it is known."""

    variance: float
    freedom: float


@dataclass(frozen=True)
class Scatter:
    """The scatter between launches of one setting: variances of the logarithm of a time.

    `classes`: the variance of a launch, by class. `whole`: this variance for a class that was not measured. `freedom`: degrees
    of freedom of the variance of a series about the variance of its class; few if series differ much. `shared`: the variance
    of the effect that launches at one time share. `counts`: (series, launches) behind each class; empty if the scatter is
    assumed.
    """

    classes: Mapping[Class, Known]
    whole: Known
    freedom: float
    shared: float
    counts: Mapping[Class, tuple[int, int]]

    def of(self, kind: Class) -> Known:
        """The variance of a class."""
        return self.classes.get(kind, self.whole)

    def scaled(self, factor: float) -> "Scatter":
        """The scatter of values that scatter this factor more than a time, such as differences of two times."""
        square = factor**2
        classes = {kind: known._replace(variance=known.variance * square) for kind, known in self.classes.items()}
        whole = self.whole._replace(variance=self.whole.variance * square)
        return replace(self, classes=classes, whole=whole, shared=self.shared * square)

    @property
    def typical(self) -> float:
        """The standard deviation of a launch over all series that were launched several times, or the assumed one."""
        return math.sqrt(self.whole.variance)

    def table(self) -> list[dict[str, Any]]:
        """Rows for a page: library, its way to the equations, the length of a call in words, the scatter, numbers of series and launches."""
        lengths = ("below 0.1 ms", "0.1 to 10 ms", "above 10 ms")
        return [
            {
                "library": library,
                "way": way,
                "length": lengths[length],
                "scatter": math.sqrt(self.classes[library, way, length].variance),
                "series": series,
                "launches": launches,
            }
            for (library, way, length), (series, launches) in sorted(self.counts.items())
        ]

    def text(self) -> str:
        """The scatter in words."""
        if not self.counts:
            return f"no setting was launched twice; a scatter of {ASSUMED:g} between launches is assumed"
        series, launches = (sum(each) for each in zip(*self.counts.values(), strict=True))
        return (
            f"launches of one setting scatter by {self.typical:.2g} (standard deviation of the logarithm of a time;"
            f" {series} settings, {launches} launches)"
        )


UNMEASURED = Scatter({}, Known(ASSUMED**2, ASSUMED_FREEDOM), ASSUMED_FREEDOM, ASSUMED**2, {})
"""The scatter of a file in which no setting was launched twice."""


def scatter_of(series: Iterable[Timed]) -> Scatter:
    """The scatter of series that were launched several times, each at one setting; others are passed over."""
    every = [timed for timed in series if len(timed.times) > 1]
    if not every:
        return UNMEASURED
    squares, effects = _without_shared(every)
    freedoms = [len(timed.times) - 1.0 for timed in every]
    of: dict[Class, list[int]] = {}
    for place, timed in enumerate(every):
        of.setdefault(timed.kind, []).append(place)
    sums = {kind: (float(squares[at].sum()), sum(freedoms[n] for n in at)) for kind, at in of.items()}
    total, freedom = (sum(each) for each in zip(*sums.values(), strict=True))
    whole = max(total / freedom, LEAST**2)
    # How much classes differ, then how much the series of a class do.
    between = _freedom([(value / number, number, whole) for value, number in sums.values()])
    classes = {
        kind: Known(max((between * whole + value) / (between + number), LEAST**2), min(between + number, MOST_FREEDOM))
        for kind, (value, number) in sums.items()
    }
    singles = [(squares[n] / freedoms[n], freedoms[n], classes[kind].variance) for kind, at in of.items() for n in at]
    within = max(_freedom(singles), LEAST_FREEDOM)
    counts = {kind: (len(at), sum(len(every[n].times) for n in at)) for kind, at in of.items()}
    return Scatter(classes, Known(whole, min(between, freedom)), within, effects, counts)


def _without_shared(every: Sequence[Timed]) -> tuple[Floats, float]:
    """For each series the sum of squares of its logarithms about their mean, without the effects of launches; their variance.

    An effect is the median over the series of that launch, found from SHARED series at least.
    """
    places = {key: place for place, key in enumerate(sorted(set().union(*(timed.times for timed in every))))}
    counts = np.array([len(timed.times) for timed in every])
    of = np.repeat(np.arange(len(every)), counts)
    launch = np.array([places[key] for timed in every for key in timed.times])
    logs = np.log(np.array([value for timed in every for value in timed.times.values()]))
    members = [np.flatnonzero(launch == place) for place in range(len(places))]
    effects, usable = np.zeros(len(places)), [place for place, at in enumerate(members) if len(at) >= SHARED]
    for _ in range(ROUNDS):
        means = np.bincount(of, logs - effects[launch]) / counts
        for place in usable:
            effects[place] = np.median(logs[members[place]] - means[of[members[place]]])
    left = logs - effects[launch]
    left -= (np.bincount(of, left) / counts)[of]
    squares: Floats = np.bincount(of, left**2).astype(np.float64)
    return squares, float(np.var(effects[usable], ddof=1)) if len(usable) > 1 else 0.0


SHARED = 8
"""Smallest number of series of a launch from which its shared effect is found."""
ROUNDS = 10
"""Rounds in which means of series and effects of launches are found in turn; they agree to 1e-3 after three."""


def _freedom(variances: Sequence[tuple[float, float, float]]) -> float:
    """The degrees of freedom of variances about their expectations, from (variance, its degrees of freedom, expectation).

    If all variances are as expected, their logarithms scatter by trigamma(n/2) each. The rest of the scatter is from
    differences between the variances.
    """
    usable = [(max(value, LEAST**2 / 4) / expected, n) for value, n, expected in variances if n > 0]
    if len(usable) < 2:
        return MOST_FREEDOM
    logs = np.array([math.log(value) - digamma(n / 2) + math.log(n / 2) for value, n in usable])
    excess = float(np.var(logs, ddof=1) - np.mean([polygamma(1, n / 2) for _, n in usable]))
    if excess <= polygamma(1, MOST_FREEDOM / 2):
        return MOST_FREEDOM
    low, high = 0.5, MOST_FREEDOM
    for _ in range(60):  # trigamma falls, so its inverse is found by halving
        middle = math.sqrt(low * high)
        low, high = (middle, high) if polygamma(1, middle / 2) > excess else (low, middle)
    return low


def compare(cell: Sequence[Timed], scatter: Scatter, first: int | None = None, candidates: int = 0) -> list[Compared]:
    """Compare each series of a cell with the fastest, or with the series `first` that is chosen among `candidates`.

    Intervals and p values are corrected for the number of series that could have been the fastest: the series that are
    behind by at most the half width of an interval that is corrected for all series.
    """
    means = np.array([math.log(timed.middle) for timed in cell])
    best = int(np.argmin(means)) if first is None else first
    parts = [_series(timed, scatter) for timed in cell]
    errors, freedoms = zip(*(_error(cell, parts, scatter, place, best) for place in range(len(cell))), strict=True)
    error, freedom, behind = np.array(errors), np.array(freedoms), means - means[best]
    chosen = candidates or len(cell) - 1
    if first is None and chosen > 1:
        wide = stdtrit(freedom, 1 - STRICT / chosen / 2) * error
        chosen = max(int(np.sum(behind <= wide)) - 1, 1)
    half = stdtrit(freedom, 1 - RATE / (2 * max(chosen, 1))) * error
    with np.errstate(invalid="ignore", divide="ignore"):
        p = np.minimum(1.0, 2 * max(chosen, 1) * stdtr(freedom, -np.abs(behind) / error))
    compared = []
    for place, (middle, width, value) in enumerate(zip(behind, half, p, strict=True)):
        ratio, low, high = (math.exp(x) for x in (middle, middle - width, middle + width))
        compared.append(Compared(1.0, 1.0, 1.0, 1.0) if place == best else Compared(ratio, low, high, float(value)))
    return compared


def compare_ratios(pairs: Sequence[Sequence[float]]) -> list[Compared]:
    """Compare the two sides of each pair by the ratios of their times, one ratio a launch.

    The scatter of a pair is combined with the scatter of all pairs.
    """
    # Both sides of a pair ran in one launch, so that its effect cancels: launches of different pairs share none.
    every = [Timed("", {(pair, n): ratio for n, ratio in enumerate(ratios)}) for pair, ratios in enumerate(pairs)]
    scatter = scatter_of(every)
    compared = []
    for timed in every:
        known, share = _series(timed, scatter)
        part = known.variance / len(timed.times)
        freedom = 1 / (1 / known.freedom + share**2 / scatter.of(timed.kind).freedom)
        middle, width = math.log(timed.middle), float(stdtrit(freedom, 1 - RATE / 2)) * math.sqrt(part)
        p = min(1.0, 2 * float(stdtr(freedom, -abs(middle) / math.sqrt(part))))
        compared.append(Compared(timed.middle, math.exp(middle - width), math.exp(middle + width), p))
    return compared


STRICT = 0.01
"""The level at which a series counts as one that could have been the fastest."""


def _series(timed: Timed, scatter: Scatter) -> tuple[Known, float]:
    """The variance of a launch of a series, its class's combined with its own; and the weight of its class in it."""
    of, own = scatter.of(timed.kind), len(timed.times) - 1
    if own < 1:
        return Known(of.variance, scatter.freedom), 1.0
    logs = np.log([*timed.times.values()])
    about = scatter.freedom + own
    share = scatter.freedom / about
    return Known(share * of.variance + float(np.sum((logs - logs.mean()) ** 2)) / about, about), share


def _error(
    cell: Sequence[Timed], parts: Sequence[tuple[Known, float]], scatter: Scatter, first: int, second: int
) -> tuple[float, float]:
    """The standard error of the difference of two series' mean logarithms, and its degrees of freedom.

    By Welch and Satterthwaite; an error of a class is shared by both series if it is the class of both.
    """
    if first == second:
        return 0.0, MOST_FREEDOM
    weights = [{key: 1 / len(cell[n].times) for key in cell[n].times} for n in (first, second)]
    unlike = sum((weights[0].get(key, 0.0) - weights[1].get(key, 0.0)) ** 2 for key in weights[0] | weights[1])
    total = scatter.shared * unlike
    single, classes = 0.0, dict[Class, float]()
    for n in (first, second):
        known, share = parts[n]
        part = known.variance / len(cell[n].times)
        total += part
        single += part**2 / known.freedom
        kind = cell[n].kind
        classes[kind] = classes.get(kind, 0.0) + share * part
    spread = single + sum(value**2 / scatter.of(kind).freedom for kind, value in classes.items())
    return math.sqrt(total), min(max(total**2 / spread, 1.0), MOST_FREEDOM)


def states(cells: Sequence[Sequence[Compared]]) -> list[list[str]]:
    """The state of each row of the cells of a page, for which one false discovery rate holds."""
    firsts = [[(row.ratio, -row.p) for row in rows].index(min((row.ratio, -row.p) for row in rows)) for rows in cells]
    claims = [(c, n) for c, rows in enumerate(cells) for n in range(len(rows)) if n != firsts[c]]
    held = discoveries([cells[c][n].p for c, n in claims])
    by_cell = [[FASTEST] * len(rows) for rows in cells]
    for (c, n), holds in zip(claims, held, strict=True):
        by_cell[c][n] = state(cells[c][n], bool(holds))
    return by_cell


def state(row: Compared, claimed: bool) -> str:
    """The state of a pair; `claimed`: whether the claim holds that its sides are not equally fast."""
    if claimed and not row.low <= 1 <= row.high:
        return SLOWER
    return EQUAL if row.low >= 1 / EQUAL_WITHIN and row.high <= EQUAL_WITHIN else OPEN


def above(differences: Floats) -> float:
    """The p value that differences have mean zero, if larger ones are expected: Student's t; 1 for fewer than two."""
    count = len(differences)
    if count < 2:
        return 1.0
    mean, scatter = float(np.mean(differences)), float(np.std(differences, ddof=1))
    return float(stdtr(count - 1, -mean * np.sqrt(count) / scatter)) if scatter else float(mean <= 0)


def run_paired_test(differences: Sequence[float] | Floats) -> float:
    """The p value that differences, one a system, have mean zero: two-sided t test. Raises ValueError for fewer than two."""
    values = np.asarray(differences, dtype=float)
    if len(values) < 2:
        raise ValueError(f"{len(values)} differences: a t test needs two at least")
    return min(1.0, 2 * above(values if np.sum(values) > 0 else -values))


def signs(first: int, second: int) -> float:
    """The p value that two methods are ahead equally often, on the problems on which they differ.

    Two-sided sign test (McNemar, exact).
    """
    return float(min(1.0, 2 * bdtr(min(first, second), first + second, 0.5))) if first + second else 1.0


def wilson(part: float, count: int) -> tuple[float, float]:
    """The 95 % interval of a probability, from the share `part` of `count` independent trials; (0, 1) without a trial.

    Wilson, Journal of the American Statistical Association 22, 209 (1927).

    Examples
    --------
    >>> [round(end, 2) for end in wilson(1.0, 4)]
    [0.51, 1.0]
    """
    if not count:
        return 0.0, 1.0
    z = float(ndtri(1 - RATE / 2))
    middle = (part + z * z / (2 * count)) / (1 + z * z / count)
    half = z * math.sqrt(part * (1 - part) / count + (z / (2 * count)) ** 2) / (1 + z * z / count)
    # Without round-off the ends are 0 and 1 for shares of 0 and 1.
    return middle - half if part > 0 else 0.0, middle + half if part < 1 else 1.0


def discoveries(p: Sequence[float] | Floats) -> np.ndarray:
    """Whether each of these claims holds at the false discovery rate `RATE`, for claims that are tested together.

    This is the step-up procedure of Benjamini and Hochberg, Journal of the Royal Statistical Society B 57, 289 (1995).
    """
    values = np.asarray(p, dtype=float)
    ordered = np.sort(values)
    below = np.flatnonzero(ordered <= RATE * np.arange(1, len(values) + 1) / max(len(values), 1))
    return values <= (ordered[below[-1]] if len(below) else -1.0)
