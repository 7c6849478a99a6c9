"""What to use for a need, in words: a card for each need, a line for each library."""

import math
from collections.abc import Sequence, Set
from typing import Any

from gnomon.harness.adapters.libraries import title
from gnomon.harness.contract.integrator import Tolerance
from gnomon.harness.registry import lookup
from gnomon.harness.reporting.page.case_tables import way
from gnomon.harness.reporting.page.representing import Representatives, label
from gnomon.harness.results.advice.needs import OWN, YOURS, Answer, Cost, Need, Reliable, Setting, needs
from gnomon.harness.results.number_text import count_text, error_text, join_words, power_text, short_text, time_text
from gnomon.harness.results.profiles import OURS
from gnomon.harness.running.own_equations import lines

NONE = "ran on no such system: it cannot state them, or was not asked to"


def make_need_cards(found: Representatives, margin: float) -> list[dict[str, Any]]:
    """The needs with their answers in words; empty if the complete cases of the run carry no recommendation.

    `margin`: the factor of the tolerances to rely on (see `Reliable`).
    """
    all_ = needs(found.measured, margin=margin)
    present = {one.name for one in found.stands}
    return (
        [_card(one, present) for one in all_] if any(one.recommended for need in all_ for one in need.answers) else []
    )


def _card(need: Need, present: Set[str]) -> dict[str, Any]:
    """A card in words, of the libraries that are `present`: those that ran at all."""
    answers = [
        _line(one) | ({} if one.tried else {"why": NONE})
        for one in need.answers
        if one.tried or (one.methods and one.library in present)
    ]
    methods = dict.fromkeys(name for one in need.answers if one.recommended for name in one.methods)
    known = lookup.everything()
    code = {
        label(name): text
        for name in methods
        if name in known and (text := lines(known[name], subject=need.subject.key)) is not None
    }
    return {
        "key": need.subject.key,
        "title": need.subject.title,
        "about": need.subject.about,
        "error": power_text(need.error),
        "systems": need.systems,
        "answers": answers,
        "lines": code,
        "costs": _costs(need.costs),
    }


def _line(one: Answer) -> dict[str, Any]:
    methods = join_words([label(name).removeprefix(f"{title(one.library)} ") for name in one.methods])
    row = {
        "library": title(one.library),
        "division": {OWN: "own", YOURS: "yours"}.get(one.division, "third"),
        "method": methods,
    }
    row |= {"way": way(one.methods[0]) if one.methods else "", "why": one.why, "better": ""}
    if one.systems:
        between = f" ({time_text(one.low)} to {time_text(one.high)})" if one.systems > 1 else ""
        row["time"] = f"{time_text(one.seconds)}{between}"
        row["calls"] = (
            f"{one.evaluations:.0f} evaluations" if math.isfinite(one.evaluations) else "evaluations not counted"
        )
        row["on"] = "; ".join([f"on {_share(one)}", *_settings(one), *_rests(one)])
    else:
        least = f"; on half of them it reaches {error_text(one.best_error)}" if math.isfinite(one.best_error) else ""
        row |= {"time": "", "calls": "", "on": f"reaches it on {_share(one)}{least}" if one.tried else ""}
    if one.better is not None:
        best = one.better
        row["better"] = (
            f"best of its {best.among} methods, found after the run: {join_words([label(n) for n in best.methods])}, {time_text(best.seconds)} on {best.systems} of {best.tried}; {best.how}"
        )
    return row


def _share(one: Answer) -> str:
    """The systems that are reached, with the 95 % interval of their share."""
    low, high = (f"{100 * end:.0f}" for end in one.share)
    share = (
        f"at least {low} %"
        if one.systems == one.tried
        else f"{low} to {high} %"
        if one.systems
        else f"at most {high} %"
    )
    return f"{one.systems} of {count_text(one.tried, 'system')} ({share})"


def _settings(one: Answer) -> list[str]:
    """The setting to rely on of each method, and the setting of the median problem."""
    if one.setting is None:
        return []
    found = []
    for each in one.reliable:
        of = f" of {label(each.integrator)}" if len(one.reliable) > 1 else ""
        on = "" if each.systems == each.of else f" on {each.systems} of {each.of}"
        found.append(f"to rely on: {_setting(each)}{of}{on} ({time_text(each.seconds)})")
    return [*found, f"often enough: {_setting(one.setting)}"]


def _setting(one: Setting | Reliable) -> str:
    if one.kind == Tolerance.kind:
        return f"{'tolerance' if one.name == 'rtol' else one.name} {power_text(one.relative)}"
    return f"step {short_text(one.relative)} of the time scale"


def _rests(one: Answer) -> list[str]:
    """The systems that the answer rests on."""
    if one.rests_on is None:
        return []
    spans = f"spans of {short_text(one.rests_on.shortest)} to {short_text(one.rests_on.longest)} time scales"
    orbits = one.rests_on.eccentricity
    return [spans + (f", eccentricities up to {short_text(orbits)}" if math.isfinite(orbits) else "")]


def _costs(costs: Sequence[Cost]) -> dict[str, Any] | None:
    """The times of each method by stiffness: a row a method, a column a problem, in the order of the stiffness."""
    if not costs:
        return None
    columns = sorted({(one.decays, one.case, one.variant) for one in costs})
    by_pair = {(one.integrator, one.case, one.variant): one for one in costs}
    rows = []
    names = dict.fromkeys(one.integrator for one in costs)
    for name in sorted(names, key=lambda one: one.startswith(f"{OURS}:")):  # third parties first
        cells = [by_pair.get((name, case, variant)) for _, case, variant in columns]
        rows.append({
            "name": label(name), "division": "own" if name.startswith(f"{OURS}:") else "third",
            "time": ["" if one is None else time_text(one.seconds) if math.isfinite(one.seconds) else "✕" for one in cells],
            "calls": ["" if one is None else f"{one.evaluations:.0f}" if math.isfinite(one.evaluations) else "✕" if not math.isfinite(one.seconds) else "–" for one in cells],
        })  # fmt: skip
    return {"heads": [(power_text(decays), f"{case}/{variant}") for decays, case, variant in columns], "rows": rows}
