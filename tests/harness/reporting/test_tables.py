"""The numbers of tables, on rows whose numbers are known."""

import math
from typing import Any

import pandas as pd
import pytest
from command_line import numbers_in
from gnomon.harness.reporting import tables
from gnomon.harness.results import number_text
from gnomon.harness.results.contenders import ALONE, ANSWERED, division
from gnomon.harness.results.equal_error import TARGETS
from gnomon.harness.results.summary import count_waits
from gnomon.harness.results.time_ratios import EQUAL as SAME
from gnomon.harness.results.time_ratios import FASTEST, SLOWER


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (2.5, "2.50 s"), (0.99951, "1.00 s"), (0.99949, "999 ms"), (12.34e-3, "12.3 ms"), (1.0e-6, "1.00 µs"),
        (20.2e-9, "20.2 ns"), (math.nan, "–"),
    ],
)  # fmt: skip
def test_times_have_three_figures_and_their_unit(seconds: float, text: str) -> None:
    assert number_text.time_text(seconds) == text


@pytest.mark.parametrize(
    ("value", "error", "short", "ratio"),
    [
        (0.43, "4.3e-1", "0.43", "0.4"), (9.96, "1.0e1", "10", "10"), (1234.0, "1.2e3", "1.2e3", "1\u202f234"),
        (456.0, "4.6e2", "456", "456"), (0.0096, "9.6e-3", "9.6e-3", "0.0"), (math.nan, "–", "–", "–"),
    ],
)  # fmt: skip
def test_numbers_have_two_figures(value: float, error: str, short: str, ratio: str) -> None:
    assert (number_text.error_text(value), number_text.short_text(value), number_text.ratio_text(value)) == (
        error,
        short,
        ratio,
    )


@pytest.mark.parametrize(
    ("error", "right"), [(0.0, 17), (1e-3, 3), (2.9e-12, 11.54), (1.26e-6, 5.9), (0.5, 0.3), (3.0, 0), (1e-30, 17)]
)
def test_digits_keep_their_fraction(error: float, right: float) -> None:
    """Cut to whole digits, 2.9e-12 would look like 1e-11, and 5.9 digits like a tenth of their accuracy."""
    assert tables.digits(error) == pytest.approx(right, abs=0.01)


def _equal(*rows: tuple[str, str, float, float, float, bool]) -> pd.DataFrame:
    """Case, integrator (library:name), target, seconds, ratio, at_loosest; ratios from 1.2 are slower."""
    columns = ["case", "integrator_id", "target", "seconds", "ratio", "at_loosest"]
    table = pd.DataFrame(rows, columns=columns).assign(variant="", formulation="", cell=ANSWERED, null_share=0.034)
    table["more_seconds"] = math.nan
    table["library"] = table["integrator_id"].str.partition(":")[0]
    table["division"] = table["library"].map(division)
    state = [FASTEST if ratio == 1 else SAME if ratio < 1.2 else SLOWER for ratio in table["ratio"]]
    return table.assign(state=state, low=0.9 * table["ratio"], high=1.1 * table["ratio"])


EQUAL = _equal(
    ("a", "scipy:one", 1e-6, 1e-3, 1.0, False),
    ("a", "scipy:two", 1e-6, 1.1e-3, 1.1, False),
    ("a", "heyoka:three", 1e-6, 3e-3, 3.0, True),
    ("b", "scipy:two", 1e-6, 2e-3, 1.0, True),
    ("b", "heyoka:three", 1e-6, 1e-2, 5.0, False),
)
SIX = TARGETS.index(1e-6)


def _plain(text: str) -> str:
    return text.replace("\N{NO-BREAK SPACE}", " ")


def test_a_cell_names_the_fastest_and_those_near_it_or_the_next() -> None:
    first, second, third = tables.fastest(EQUAL, [("a", ""), ("b", ""), ("d", "")])
    assert first.cells[SIX].text == "scipy:one"
    assert "equal: scipy:two 1.1 (0.99 – 1.2)" in first.cells[SIX].note
    assert "heyoka" not in first.cells[SIX].note
    assert second.cells[SIX].text == "scipy:two"
    assert "≤ 2.00 ms · null call 3 %" in _plain(second.cells[SIX].note)
    assert "slower: heyoka:three 5.0 (4.5 – 5.5)" in second.cells[SIX].note
    assert third.cells[SIX].text == first.cells[0].text == "not reached"


@pytest.mark.parametrize(
    ("later", "said"),
    [
        ([("two", 0.5, 1.0), ("one", 1.0, 2.0)], ["2.0", "1.8", "2.2"]),
        ([("two", 0.9, 1.0), ("one", 1.0, 1.1)], []),  # not apart
        ([("one", 0.5, 1.0), ("two", 1.0, 2.0)], []),  # the same order
        ([("two", 0.5, 1.0), ("three", 1.0, 2.0)], []),  # of the first nothing is known
    ],
)
def test_a_cell_says_where_one_more_period_has_another_order(
    later: list[tuple[str, float, float]], said: list[str]
) -> None:
    """With the factor of the fastest of the whole call to the fastest of one more period, and its interval."""
    (plain,) = tables.fastest(EQUAL, [("a", "")])
    of_later = _equal(*(("a", f"scipy:{name}", 1e-6, seconds, ratio, False) for name, seconds, ratio in later))
    (row,) = tables.fastest(EQUAL, [("a", "")], later=of_later)
    note = row.cells[SIX].note.removeprefix(plain.cells[SIX].note)
    assert numbers_in(note) == said
    assert ("scipy:two" in note) == bool(said)


@pytest.mark.parametrize("library", ["gnomon", "mine"])
def test_only_third_parties_are_named_unless_there_are_none(library: str) -> None:
    """gnomon publishes the page, and nobody else has a user's own integrator."""
    other = _equal(("a", f"{library}:far", 1e-6, 1e-6, 1.0, False), ("c", f"{library}:far", 1e-6, 1e-6, 1.0, False))
    problems = [("a", ""), ("b", ""), ("c", "")]
    found = tables.fastest(pd.concat([EQUAL, other]), problems)
    assert found[:2] == tables.fastest(EQUAL, problems[:2])
    assert found[2].cells[SIX].text == "not reached", "by any third party"
    assert [row.cells[SIX].text for row in tables.fastest(other, problems)] == [
        f"{library}:far",
        "not reached",
        f"{library}:far",
    ]


def test_one_that_alone_gets_there_is_said_to_be_alone() -> None:
    """Without another to compare it with, it is not the fastest of several."""
    (alone,) = tables.fastest(EQUAL[3:4].assign(cell=ALONE), [("b", "")])
    (first,) = tables.fastest(EQUAL[3:], [("b", "")])
    assert alone.cells[SIX].text == first.cells[SIX].text == "scipy:two"
    assert "no other" in alone.cells[SIX].note
    assert "no other" not in first.cells[SIX].note


def test_a_small_share_of_the_null_call_is_no_zero() -> None:
    assert [_plain(tables.share_text(x)) for x in (0.004, 0.006, 0.5, math.nan)] == [
        "null call below 1 %", "null call 1 %", "null call 50 %", "",
    ]  # fmt: skip


def _stability(**changed: Any) -> list[tables.Cell]:
    key = {"case": "a", "variant": "", "formulation": "", "library": "x", "integrator_id": "x:one"}
    series = {
        "verdict": "partly", "settings_ok": 3, "settings": 4, "counts": {"ok": 3}, "failure": "diverged",
        "reason": "why",
    }  # fmt: skip
    nothing = {"over_tolerance": math.nan, "worst_over_tolerance": math.nan}
    trial = nothing | {"best": 3e-14, "attainable": 1e-14} | changed.get("trial", {})
    order = {"order": 3.98, "margin": 0.05, "lowest": 3.95, "highest": 4.01, "declared": 4.0, "why": ""} | changed.get(
        "order", {}
    )
    part = {"error_phase": 2e-6, "error_shape": 3e-7, "events_missing": math.nan, "events_extra": math.nan}
    part |= {"events_time_error": math.nan, "turns": 0} | changed.get("part", {})
    laws = [
        {"quantity": "error", "law": "t^2", "power": 2.01, "low": 1.9, "high": 2.12, "size": 1e-5},
        {"quantity": "the_energy", "law": "", "power": 0.6, "low": 0.1, "high": 1.1, "size": 2e-9},
        {"quantity": "spin", "law": "round-off", "power": math.nan, "low": math.nan, "high": math.nan, "size": 2e-14},
    ]
    frames = [pd.DataFrame([key | row]) for row in (series, trial, order, part)]
    matrix, trusted, orders, parts = frames
    drifts = pd.DataFrame([key | law for law in changed.get("laws", laws)])
    return tables.stability_rows(matrix, trusted, orders, drifts, parts)["a"][0].cells


def test_a_row_of_the_stability_table() -> None:
    status, best, knob, parts, growth, drift = _stability()
    assert (status.text, status.note, status.kind) == ("3 of 4 ok", "diverged: why", "partly")
    assert (best.text, best.note) == ("3.0e-14", "3.0 × attainable")
    assert (knob.text, knob.note) == ("order 3.98 ± 0.05", "declared 4")
    assert (parts.text, parts.note) == ("phase 2.0e-6", "shape 3.0e-7")
    assert (growth.text, growth.note) == ("t²", "power 2.01 (1.90 to 2.12); reaches 1.0e-5")
    assert drift.note == "the energy: power 0.6 (0.1 to 1.1) (2.0e-9); spin: round-off (2.0e-14)"


def test_an_error_below_the_attainable_is_at_it() -> None:
    assert _stability(trial={"best": 0.9e-14})[1].note == "at the attainable"


def test_an_error_that_is_a_median_over_orientations_has_its_range_beside_it() -> None:
    spread = {"turned_starts": 9.0, "error_low": 2e-15, "error_high": 5e-14}
    assert _stability(trial=spread)[1].aside == " · 2.0e-15 to 5.0e-14 over 9 orientations"
    assert _stability(trial=spread | {"error_high": math.nan})[1].aside.startswith(" · 2.0e-15 to not finite")
    assert _stability()[1].aside == ""


def test_where_points_lie_on_no_line_that_is_said_and_no_order_printed() -> None:
    knob = _stability(order={"order": math.nan, "lowest": 1.24, "highest": 6.0})[2]
    assert (knob.text, knob.note) == ("no line", "slopes from 1.2 to 6.0; declared 4")
    few = _stability(order={"order": math.nan, "lowest": math.nan, "highest": math.nan})[2]
    assert (few.text, few.note) == ("–", "declared 4")


def test_error_over_tolerance_stands_where_an_order_would() -> None:
    knob = _stability(trial={"over_tolerance": 12.0, "worst_over_tolerance": 340.0})[2]
    assert (knob.text, knob.note) == ("12 × tolerance", "worst 340 ×")


def test_events_and_lost_turns_are_told() -> None:
    events = {"error_phase": math.nan, "events_missing": 1.0, "events_extra": 2.0, "events_time_error": 3e-9}
    parts = _stability(part=events | {"turns": 4})[3]
    assert (parts.text, parts.note) == ("events: 1 missing, 2 too many", "times within 3.0e-9 s; up to 4 turns off")


def test_failures_count_trials_and_keep_reasons() -> None:
    columns = ["status", "integrator_id", "reason", "trials", "where"]
    rows = [("diverged", "x:one", "far", 3, ["a", "b"]), ("diverged", "x:one", "farther", 2, ["b", "c"])]
    rows += [("diverged", "x:two", f"reason {k}", 1, ["a"]) for k in range(4)]
    (group,) = tables.failure_groups(pd.DataFrame(rows, columns=columns))
    one, two = group["rows"]
    assert (group["trials"], one["trials"], one["where"], one["more"]) == (9, 5, ["a", "b", "c"], 0)
    assert (two["reasons"], two["more"]) == (["reason 0", "reason 1"], 2)


def test_shares_are_of_the_trials_that_could_run() -> None:
    reduced = pd.DataFrame({"status": ["ok"] * 3 + ["skipped"] + ["unsupported"] * 6})
    assert tables.status_shares(reduced) == [
        {"status": "ok", "trials": 3, "share": 0.75},
        {"status": "skipped", "trials": 1, "share": 0.25},
    ]


def test_a_count_has_its_noun_in_the_right_number() -> None:
    assert [number_text.count_text(n, "case") for n in (0, 1, 2)] == ["0 cases", "1 case", "2 cases"]
    assert [number_text.count_text(n, "library") for n in (1, 5)] == ["1 library", "5 libraries"]


def test_the_measurements_that_waited_for_a_processor_are_counted() -> None:
    """A delay that is not known is stated, so that it does not count as no wait."""
    frame = pd.DataFrame({"seconds_median": [1.0, 1.0, 1.0], "delay_seconds": [0.0, 0.1, 0.2]})
    older = frame.assign(delay_seconds=[None, None, 0.2]).astype(float)
    known, unknown = (
        numbers_in(
            number_text.tell_waits(*count_waits(zip(each["seconds_median"], each["delay_seconds"], strict=True)))
        )
        for each in (frame, older)
    )
    assert known[:2] == ["2", "3"]
    assert unknown == ["1", *known[1:], "2"]
