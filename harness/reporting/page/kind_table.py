"""The table of kinds of systems by libraries: how far each library is from the fastest, and one sentence for a choice.

All that the page can show of it is written here; its script only chooses.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from gnomon.harness.registry import lookup
from gnomon.harness.reporting.page.representing import Representatives, Stand, label
from gnomon.harness.results import profiles
from gnomon.harness.results.advice.code_lines import argument, choose_system, code_of, time_scale
from gnomon.harness.results.advice.needs import SUBJECTS, Measurements, Setting
from gnomon.harness.results.analysis import own, records
from gnomon.harness.results.contenders import OWN, THIRD
from gnomon.harness.results.equal_error import TARGETS
from gnomon.harness.results.number_text import count_text, join_words, power_text, ratio_text, short_text
from gnomon.harness.running.own_equations import form_names
from markupsafe import Markup, escape

CLOCKS = {"seconds": "whole call", "more_seconds": "one more period"}
"""Columns of `analysis.equal_error`, and their names on the page."""
GROUPS = {"third": "third parties", "all": "all"}
"""Which libraries are shown and set the scale."""
AT = 1e-6
"""The error that the page shows first."""
HALF = 0.5
"""Least share of the systems that a library reaches for being named before those that are faster on fewer."""


@dataclass(frozen=True)
class Entry:
    """A library on the systems of a kind at an error."""

    stand: Stand
    method: str
    system: str | None
    """The name of the system of `systems.toml` that its lines of code run; None for an engine."""
    factor: profiles.Median | None
    """Of its time over the least, on the systems that it reaches; None if it reaches none."""
    reached: int
    systems: int
    """Systems whose result is known."""
    exact: int
    """Systems on which its method is exact by construction, which are not among them."""
    setting: Setting | None
    """Of the median system."""
    span: tuple[float, float]
    """Its loosest and its tightest relative setting."""


class KindTable:
    """The entries of a run. `measured`: of its complete cases."""

    def __init__(self, libraries: Representatives, measured: Measurements) -> None:
        self.libraries, self.measured = libraries, measured
        rows = own(libraries.run.equal_error[libraries.run.equal_error["case"].isin(libraries.complete)])
        self.at = {
            (row["case"], row["integrator_id"], row["target"]): row
            for row in records(rows, ("case", "integrator_id", "target", *CLOCKS))
        }
        self.kinds = {
            kind: cases
            for kind, of in libraries.run.kinds.items()
            if (cases := [case for case in of if case in libraries.complete and (case, "") in measured.problems])
        }
        known = [name for name in CLOCKS if any(math.isfinite(row[name]) for row in self.at.values())]
        self.clocks = known or [next(iter(CLOCKS))]
        divisions = {stand.division for stand in libraries.stands}
        self.groups = ["third"] * (THIRD in divisions) + ["all"] * (divisions != {THIRD})

    def members(self, group: str) -> list[Stand]:
        """The libraries of a group; an integrator that the run was given is in both."""
        return [stand for stand in self.libraries.stands if group == "all" or stand.division != OWN]

    def systems(self, kind: str, stand: Stand) -> list[str]:
        """The systems of a kind on which the result of a library is known; those that it cannot state are among them.

        Not those on which its method is exact by construction, which show nothing about it.
        """
        method = stand.methods.get(kind)
        if method is None:
            return []
        cases = [case for case in self.kinds[kind] if (case, method) in self.libraries.known]
        return [case for case in cases if not self.measured.exact((case, ""), method)]

    def entries(self, kind: str, error: float, clock: str, group: str) -> list[Entry]:
        """The entry of each library that has a method for a kind."""
        members = [stand for stand in self.members(group) if stand.methods.get(kind) is not None]
        cases = {stand.name: self.systems(kind, stand) for stand in members}
        times = {
            stand.name: {
                case: float(row[clock])
                for case in cases[stand.name]
                if (row := self.at.get((case, str(stand.methods[kind]), error))) is not None
            }
            for stand in members
        }
        least: dict[str, float] = {}
        for stand in members:
            if group == "all" or stand.division == THIRD:
                for case, seconds in times[stand.name].items():
                    if math.isfinite(seconds):
                        least[case] = min(seconds, least.get(case, math.inf))
        return [self._entry(stand, kind, error, cases[stand.name], times[stand.name], least) for stand in members]

    def _entry(
        self,
        stand: Stand,
        kind: str,
        error: float,
        cases: Sequence[str],
        times: Mapping[str, float],
        least: Mapping[str, float],
    ) -> Entry:
        method = str(stand.methods[kind])
        factors = [at / least[case] for case, at in times.items() if math.isfinite(at) and case in least]
        reached = [self.measured.reached((case, ""), method, error) for case in times]
        settings = sorted((series.setting for series in reached if series is not None), key=lambda of: -of.relative)
        return Entry(
            stand,
            method,
            _system(kind, method),
            profiles.median(factors) if factors else None,
            len(times),
            len(cases),
            sum(self.measured.exact((case, ""), method) for case in self.kinds[kind]),
            settings[len(settings) // 2] if settings else None,
            (settings[0].relative, settings[-1].relative) if settings else (math.nan, math.nan),
        )


def _system(kind: str, method: str) -> str | None:
    """The system of a kind that the lines of a method run."""
    known = lookup.everything().get(method)
    subject = next((key for key, declared in SUBJECTS.items() if declared.kinds == (kind,)), None)
    return None if known is None else choose_system(form_names(known), subject)


def order(entries: Sequence[Entry]) -> list[Entry]:
    """The entries that reach the error, the best first: by factor those that reach HALF of the systems, then by reach."""
    some = [entry for entry in entries if entry.factor is not None]
    return sorted(
        some,
        key=lambda entry: (
            entry.reached < HALF * entry.systems,
            -entry.reached if entry.reached < HALF * entry.systems else 0,
            entry.factor.value if entry.factor is not None else math.inf,
        ),
    )


def kind_table(libraries: Representatives, measured: Measurements, limits: str) -> dict[str, Any] | None:
    """The table for the page: what it shows first, and all that the script may choose; None with fewer than two libraries.

    `limits`: the time limits of a trial in words.
    """
    table = KindTable(libraries, measured)
    if len(libraries.stands) < 2 or not table.kinds:
        return None
    shown: dict[str, Markup] = {}
    texts: dict[str, Markup] = {}
    orders: dict[str, list[str]] = {}
    systems: set[str] = set()
    for clock in table.clocks:
        for group in table.groups:
            for error in TARGETS:
                key = f"{clock}/{group}/{power_text(error)}"
                of = {kind: table.entries(kind, error, clock, group) for kind in table.kinds}
                shown[key] = _html(table, group, of)
                for kind, entries in of.items():
                    ordered = order(entries)
                    place = f"{key}/{kind}"
                    orders[place] = [entry.stand.name for entry in ordered]
                    systems |= {entry.system for entry in ordered if entry.system is not None}
                    texts |= {f"{place}/{entry.stand.name}": sentence(entry, error, clock, group) for entry in ordered}
    first = f"{table.clocks[0]}/{table.groups[0]}/{power_text(AT)}"
    opening = next((kind for kind in table.kinds if orders[f"{first}/{kind}"]), next(iter(table.kinds)))
    best = orders[f"{first}/{opening}"]
    return {
        "kinds": {kind: len(cases) for kind, cases in table.kinds.items()},
        "errors": [power_text(error) for error in TARGETS],
        "clocks": {name: CLOCKS[name] for name in table.clocks},
        "groups": {name: GROUPS[name] for name in table.groups},
        "libraries": {stand.name: stand.title for stand in libraries.stands},
        "opening": opening,
        "first": shown[first],
        "said": texts[f"{first}/{opening}/{best[0]}"] if best else nobody(limits),
        "at": power_text(AT),
        "limits": limits,
        "carried": {
            "tables": {key: str(html) for key, html in shown.items()},
            # Sentences on one library and kind beside each other repeat their numbers, and take fewer bytes.
            "said": {key: str(texts[key]) for key in sorted(texts, key=lambda key: key.split("/", 3)[::-1])},
            "orders": orders,
            "lines": {name: code_of(name) for name in sorted(systems)},
            "nobody": str(nobody(limits)),
        },
    }


def nobody(limits: str) -> Markup:
    """What is said where no chosen library reaches the error."""
    return Markup("<p>None of these libraries reaches this error on a system of this kind within {}.</p>").format(
        limits
    )


def sentence(entry: Entry, error: float, clock: str, group: str) -> Markup:
    """Method, setting, factor to the best with its interval; then the setting alone, in whose place the page puts the lines."""
    whose = "third party" if group == "third" else "library"
    of = "time" if clock == "seconds" else "time of one more period"
    text = Markup(
        "<p><b>{}</b>{}: <b>{} ×</b> the {} of the fastest {} ({}). It reaches an error of {} on {} of {}.</p>"
    ).format(
        label(entry.method),
        _setting(entry),
        _factor(entry),
        of,
        whose,
        interval_text(entry),
        power_text(error),
        entry.reached,
        count_text(entry.systems, "system"),
    )
    if entry.setting is None or entry.system is None:
        return text
    value = argument(vars(entry.setting), time_scale(entry.system))
    code = Markup('<details><summary>Lines of code</summary><pre data-lines="{}" data-method="{}">{}</pre></details>')
    return text + code.format(entry.system, entry.method, value)


def _factor(entry: Entry) -> str:
    value = entry.factor.value if entry.factor is not None else math.nan
    return short_text(value) if value > 9.95 else ratio_text(value) if not value < 0.95 else f"{value:.2g}"


def interval_text(entry: Entry) -> str:
    """The interval of a median in words, with the number of systems on which it rests."""
    factor = entry.factor
    if factor is None:
        return ""
    low, high, count = short_text(factor.low), short_text(factor.high), factor.count
    if factor.confident:
        return f"95 % interval of the median {low} to {high}, by order statistics over {count} independent systems"
    if count == 1:
        return "on one system alone"
    return f"range {low} to {high} over {count} systems, too few for an interval"


def _setting(entry: Entry) -> str:
    if entry.setting is None:
        return ""
    if entry.setting.kind == "tolerance":
        loose, tight = (power_text(end) for end in entry.span)
        several = f" ({loose} to {tight})" if loose != tight else ""
        name = "a tolerance" if entry.setting.name == "rtol" else f"an {entry.setting.name}"
        return f" with {name} of {power_text(entry.setting.value)}{several}"
    return f" with a step of {short_text(entry.setting.relative)} of the time scale"


def _html(table: KindTable, group: str, of: Mapping[str, Sequence[Entry]]) -> Markup:
    """The table of a clock, a group and an error, a row a kind, a column a library."""
    members = [stand for stand in table.members(group) if any(stand.methods.get(kind) for kind in table.kinds)]
    heads = Markup("").join(Markup('<th scope="col">{}</th>').format(stand.title) for stand in members)
    rows = []
    for kind, entries in of.items():
        by_name = {entry.stand.name: entry for entry in entries}
        best = next((entry.stand.name for entry in order(entries)), None)
        cells = Markup("").join(_cell(stand, by_name.get(stand.name), stand.name == best) for stand in members)
        name, _, more = kind.partition(":")
        cases = table.kinds[kind]
        rows.append(
            Markup('<tr><th scope="row" title="{}">{}<small>{}</small></th>{}</tr>').format(
                join_words(cases), name, count_text(len(cases), "system") + (f":{more}" if more else ""), cells
            )
        )
    return Markup('<thead><tr><th scope="col">kind of system</th>{}</tr></thead><tbody>{}</tbody>').format(
        heads, Markup("").join(rows)
    )


def _cell(stand: Stand, entry: Entry | None, best: bool) -> Markup:
    if entry is None:
        return Markup('<td class="none" data-label="{}">–</td>').format(stand.title)
    unmeasured = f"exact on {entry.exact}" if entry.exact else "not run"
    reached = f"{entry.reached} of {entry.systems}" if entry.systems else unmeasured
    if entry.factor is None:
        return Markup('<td class="none" data-label="{}"><small>{}</small></td>').format(stand.title, reached)
    low, high = (short_text(end) for end in (entry.factor.low, entry.factor.high))
    interval = "" if entry.factor.count == 1 else f"{low} – {high}"
    interval = interval if entry.factor.confident or not interval else f"[{interval}]"
    apart = f", factor on {entry.factor.count}" if entry.factor.count != entry.reached else ""
    return Markup('<td{} data-label="{}"><b>{} ×</b><small>{}</small><small>{}{}</small></td>').format(
        Markup(' class="best"') if best else "", stand.title, _factor(entry), interval, reached, escape(apart)
    )
