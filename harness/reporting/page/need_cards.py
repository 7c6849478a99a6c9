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


def make_need_cards(libraries: Representatives, margin: float) -> list[dict[str, Any]]:
    """The needs with their answers in words; empty if the complete cases of the run carry no recommendation.

    `margin`: the factor of the recommended tolerances (see `Reliable`).
    """
    all_ = needs(libraries.measured, margin=margin)
    present = {stand.name for stand in libraries.stands}
    has_answer = any(answer.recommended for need in all_ for answer in need.answers)
    return [_card(need, present) for need in all_] if has_answer else []


def _card(need: Need, present: Set[str]) -> dict[str, Any]:
    """A card in words, of the libraries that are `present`: those that ran at all."""
    answers = [
        _line(answer) | ({} if answer.tried else {"why": NONE})
        for answer in need.answers
        if answer.tried or (answer.methods and answer.library in present)
    ]
    methods = dict.fromkeys(name for answer in need.answers if answer.recommended for name in answer.methods)
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


def _line(answer: Answer) -> dict[str, Any]:
    methods = join_words([label(name).removeprefix(f"{title(answer.library)} ") for name in answer.methods])
    row = {
        "library": title(answer.library),
        "division": {OWN: "own", YOURS: "yours"}.get(answer.division, "third"),
        "method": methods,
    }
    row |= {"way": way(answer.methods[0]) if answer.methods else "", "why": answer.why, "better": ""}
    if answer.systems:
        between = f" ({time_text(answer.low)} to {time_text(answer.high)})" if answer.systems > 1 else ""
        row["time"] = f"{time_text(answer.seconds)}{between}"
        row["calls"] = (
            f"{answer.evaluations:.0f} evaluations" if math.isfinite(answer.evaluations) else "evaluations not counted"
        )
        row["on"] = "; ".join([f"on {_share(answer)}", *_settings(answer), *_rests(answer)])
    else:
        error = answer.best_error
        least = f"; on half of them it reaches {error_text(error)}" if math.isfinite(error) else ""
        row |= {"time": "", "calls": "", "on": f"reaches it on {_share(answer)}{least}" if answer.tried else ""}
    if (best := answer.better) is not None:
        row["better"] = (
            f"best of its {best.among} methods, found after the run: {join_words([label(n) for n in best.methods])}, {time_text(best.seconds)} on {best.systems} of {best.tried}; {best.how}"
        )
    return row


def _share(answer: Answer) -> str:
    """The systems that are reached, with the 95 % interval of their share."""
    low, high = (f"{100 * end:.0f}" for end in answer.share)
    share = (
        f"at least {low} %"
        if answer.systems == answer.tried
        else f"{low} to {high} %"
        if answer.systems
        else f"at most {high} %"
    )
    return f"{answer.systems} of {count_text(answer.tried, 'system')} ({share})"


def _settings(answer: Answer) -> list[str]:
    """The recommended setting of each method, and the setting of the median problem."""
    if answer.setting is None:
        return []
    texts = []
    for each in answer.reliable:
        of = f" of {label(each.integrator)}" if len(answer.reliable) > 1 else ""
        on = "" if each.systems == each.of else f" on {each.systems} of {each.of}"
        texts.append(f"recommended: {_setting(each)}{of}{on} ({time_text(each.seconds)})")
    return [*texts, f"enough on half of the problems: {_setting(answer.setting)}"]


def _setting(setting: Setting | Reliable) -> str:
    if setting.kind == Tolerance.kind:
        return f"{'tolerance' if setting.name == 'rtol' else setting.name} {power_text(setting.relative)}"
    return f"step {short_text(setting.relative)} of the time scale"


def _rests(answer: Answer) -> list[str]:
    """The systems that the answer rests on."""
    if answer.rests_on is None:
        return []
    spans = f"spans of {short_text(answer.rests_on.shortest)} to {short_text(answer.rests_on.longest)} time scales"
    orbits = answer.rests_on.eccentricity
    return [spans + (f", eccentricities up to {short_text(orbits)}" if math.isfinite(orbits) else "")]


def _costs(costs: Sequence[Cost]) -> dict[str, Any] | None:
    """The times of each method by stiffness: a row a method, a column a problem, in the order of the stiffness."""
    if not costs:
        return None
    columns = sorted({(cost.decays, cost.case, cost.variant) for cost in costs})
    by_pair = {(cost.integrator, cost.case, cost.variant): cost for cost in costs}
    rows = []
    names = dict.fromkeys(cost.integrator for cost in costs)
    for name in sorted(names, key=lambda name: name.startswith(f"{OURS}:")):  # third parties first
        cells = [by_pair.get((name, case, variant)) for _, case, variant in columns]
        rows.append({
            "name": label(name), "division": "own" if name.startswith(f"{OURS}:") else "third",
            "time": ["" if cost is None else time_text(cost.seconds) if math.isfinite(cost.seconds) else "✕" for cost in cells],
            "calls": ["" if cost is None else f"{cost.evaluations:.0f}" if math.isfinite(cost.evaluations) else "✕" if not math.isfinite(cost.seconds) else "–" for cost in cells],
        })  # fmt: skip
    return {"heads": [(power_text(decays), f"{case}/{variant}") for decays, case, variant in columns], "rows": rows}
