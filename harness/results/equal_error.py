"""Time at equal error, by which the report and `gnomon.compare` rank methods. Plain rows, without pandas."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple, TypeVar

import numpy as np
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.measuring.outcome import DELAYED

K = TypeVar("K")
TARGETS = (1e-3, 1e-6, 1e-9, 1e-12)


class Reached(NamedTuple):
    """The time of a series at a target that it reaches.

    `seconds`: the geometric mean over launches of the time of a whole call; `low` and `high`: its range. `null_share`: the
    share of the null call in it, nan without a measurement. `times`: the seconds by (run, launch). A run interleaves its
    launches, so that times of equal keys share an effect (see `time_ratios`). `at_loosest`: whether the loosest setting
    reaches the target, so that the time is an upper bound. `calls`: evaluations of the equations at the target, nan if
    they were not counted. `settings`: the settings from whose times the time is computed.
    """

    target: float
    seconds: float
    low: float
    high: float
    launches: int
    times: dict[tuple[int, int], float]
    at_loosest: bool
    null_share: float
    calls: float
    settings: tuple[float, ...]


def find_reached(series: Sequence[Mapping[str, Any]], targets: Sequence[float] = TARGETS) -> Iterator[Reached]:
    """The times of a series at the targets that it reaches.

    `series`: run, launch, setting, error_max, seconds_median, null_seconds and rhs_calls of its timed settings, loosest
    first. The error of a setting that diverged is infinite.
    """
    at: dict[float, dict[int, tuple[float, bool]]] = {}
    errors: dict[int, dict[float, float]] = {}
    for row in series:
        at.setdefault(row["setting"], {})[row["launch"]] = row["seconds_median"], has_waited(row)
        errors.setdefault(row["launch"], {})[row["setting"]] = row["error_max"]
    # Slow settings are launched once. So the launch with the most settings gives the errors, and the settings from whose times
    # the time at a target is computed; another launch counts if it timed these settings.
    whole = max(sorted(errors), key=lambda launch: len(errors[launch]))
    sweep = errors[whole]
    credited = credit_errors(list(sweep.values()))
    runs = {row["launch"]: row["run"] for row in series}
    seconds = [at[setting][whole][0] for setting in sweep]
    nulls = [row["null_seconds"] for row in series if math.isfinite(row["null_seconds"])]
    null = float(np.median(nulls)) if nulls else math.nan
    # Later launches do not count evaluations.
    known = {row["setting"]: float(row["rhs_calls"]) for row in series if (row["rhs_calls"] or 0) > 0}
    counted = [known.get(setting, math.nan) for setting in sweep]
    for target in targets:
        places, loosest = beside(credited, seconds, target)
        if places:
            settings = [[*sweep][place] for place in places]
            launched = {
                (runs[n], n): (
                    _interpolate(
                        [credited[place] for place in places], [at[setting][n][0] for setting in settings], target
                    ),
                    any(at[setting][n][1] for setting in settings),
                )
                for n in sorted(runs)
                if all(n in at[setting] for setting in settings)
            }
            times = without_waits({key: each for key, each in launched.items() if math.isfinite(each[0])})
            middle = geometric_mean(times.values())
            yield Reached(
                target, middle, min(times.values()), max(times.values()), len(times), times,
                loosest, null / middle, crossing(credited, counted, target)[0],
                tuple(sorted(settings, reverse=True)),
            )  # fmt: skip


def _interpolate(errors: Sequence[float], seconds: Sequence[float], target: float) -> float:
    """The time at which the error is `target`, linear in the logarithms between two settings; with one setting, its time."""
    if len(errors) == 1:
        return seconds[0]
    upper, lower = math.log(errors[0]), math.log(max(errors[1], np.finfo(float).tiny))
    share = (upper - math.log(target)) / (upper - lower)
    return float(np.exp(np.log(seconds[0]) + share * np.log(seconds[1] / seconds[0])))


def has_waited(row: Mapping[str, Any]) -> bool:
    """Whether a measurement waited for a processor for more than `DELAYED` of its time."""
    delay = row.get("delay_seconds")
    return delay is not None and delay > DELAYED * row["seconds_median"]


def without_waits(times: Mapping[K, tuple[float, bool]]) -> dict[K, float]:
    """The times of the launches that did not wait for a processor, as up to half of a time may be waiting; else all times."""
    quiet = {key: seconds for key, (seconds, has_waited) in times.items() if not has_waited}
    return quiet or {key: seconds for key, (seconds, _) in times.items()}


def geometric_mean(values: Iterable[float]) -> float:
    """The geometric mean of positive values."""
    logs = [math.log(value) for value in values]
    return math.exp(math.fsum(logs) / len(logs))


def credit_errors(errors: Sequence[float] | Floats) -> Floats:
    """The errors of a sweep, loosest setting first, without errors that are small by chance; inf for settings left out.

    The error of a loose setting may be small by chance, where it changes sign. So each setting is credited with the largest
    error of all settings that are at least as tight. At the tightest settings round-off makes errors grow again. So the
    sweep ends with the tightest setting within 3 times the second smallest error; the smallest may be small by chance.
    """
    values = np.asarray(errors, dtype=float)
    finite = np.sort(values[np.isfinite(values)])
    if len(finite) == 0:
        return np.full(len(values), math.inf)
    second = finite[min(1, len(finite) - 1)]
    last = int(np.flatnonzero(values <= 3 * second)[-1])
    credited = np.maximum.accumulate(values[: last + 1][::-1])[::-1]
    return np.concatenate([credited, np.full(len(values) - last - 1, math.inf)])


def time_at(errors: Sequence[float] | Floats, seconds: Sequence[float] | Floats, target: float) -> tuple[float, bool]:
    """(seconds, loosest): the least time in which a sweep, loosest setting first, reaches an error; nan if it does not.

    The time is interpolated linearly in the logarithms between the last setting above the error and the first one below.
    `loosest`: whether no setting lies above. Settings with an infinite credited error do not count.

    A still tighter setting may take less time: the order of a Taylor series follows its tolerance, and a low order takes more
    steps. This setting reaches the error too, so the minimum of these times counts.
    """
    return crossing(credit_errors(errors), seconds, target)


def beside(held: Floats, seconds: Sequence[float] | Floats, target: float) -> tuple[list[int], bool]:
    """(places, loosest): the settings of a sweep from whose times `crossing` computes its time; none if it is nan."""
    time, loosest = crossing(held, seconds, target)
    if math.isnan(time):
        return [], loosest
    tight = np.flatnonzero(held <= target).tolist()
    least = min(tight, key=lambda place: math.inf if math.isnan(seconds[place]) else seconds[place])
    if seconds[least] <= time:
        return [least], loosest
    return ([tight[0]] if loosest else [tight[0] - 1, tight[0]]), loosest


def crossing(held: Floats, seconds: Sequence[float] | Floats, target: float) -> tuple[float, bool]:
    """`time_at` for errors that are already `credit_errors`."""
    reached = np.flatnonzero(held <= target)
    if len(reached) == 0:
        return math.nan, False
    i = int(reached[0])
    loosest = i == 0 or math.isinf(held[i - 1])
    first = i if loosest else i - 1
    there = _interpolate(held[first : i + 1].tolist(), [float(each) for each in seconds[first : i + 1]], target)
    # nan if the time near the target is missing; tighter settings without a time are ignored
    return (math.nan if math.isnan(there) else min(there, *(float(seconds[k]) for k in reached.tolist()))), loosest


def error_within(errors: Sequence[float] | Floats, seconds: Sequence[float] | Floats, cost: float) -> float:
    """The least error that a sweep, loosest setting first, reaches within a time; inf if every setting takes longer.

    Between a setting within the time and a next setting beyond it, the error is interpolated as in `time_at`.
    """
    held, times = credit_errors(errors), np.asarray(seconds, dtype=float)
    errors_within = [math.inf, *held[times <= cost].tolist()]
    for i in np.flatnonzero((times[:-1] <= cost) & (times[1:] > cost)).tolist():
        if math.isfinite(held[i]) and math.isfinite(held[i + 1]):
            share = math.log(cost / times[i]) / math.log(times[i + 1] / times[i])
            upper, lower = (math.log(max(value, np.finfo(float).tiny)) for value in (held[i], held[i + 1]))
            errors_within.append(math.exp(upper + share * (lower - upper)))
    return float(min(errors_within))
