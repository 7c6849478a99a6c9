"""The numbers of tables, on rows whose numbers are known."""

import math
from typing import Any

import numpy as np
import pandas as pd
import pytest
from gnomon.harness.reporting import tables
from gnomon.harness.results import number_text
from gnomon.harness.results.equal_error import TARGETS
from gnomon.harness.results.rankings import ONE_LAUNCH, RANKED, TOO_SHORT
from gnomon.harness.results.summary import waited
from said import numbers_in


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


@pytest.mark.parametrize(("error", "right"), [(0.0, 17), (1e-3, 3), (9.9e-4, 3), (1.1e-3, 2), (0.5, 0), (3.0, 0)])
def test_digits_are_never_rounded_up(error: float, right: int) -> None:
    assert tables.digits(error) == right


def _equal(*rows: tuple[str, str, float, float, float, bool]) -> pd.DataFrame:
    """Case, integrator (library:name), target, seconds, ratio, at_loosest; ratios from 1.2 are separated."""
    columns = ["case", "integrator_id", "target", "seconds", "ratio", "at_loosest"]
    table = pd.DataFrame(rows, columns=columns).assign(variant="", formulation="", launches=5, cell=RANKED)
    library = table["integrator_id"].str.partition(":")[0]
    low, high = table["seconds"] * 0.9, table["seconds"] * 1.1
    preparation = table["integrator_id"].map({"x:one": 0.03, "x:two": 0.02})
    known = {"library": library, "low": low, "high": high, "null_share": 0.034, "preparation": preparation}
    one = table["integrator_id"] == "x:one"
    firsts = {"first_use": np.where(one, 4.2, math.nan), "first_case": np.where(one, "a", None)}
    table = table.assign(tied=table["ratio"] < 1.2, slower=table["ratio"] >= 1.2, **known, **firsts)
    return table.assign(leaders=table.groupby(["case", "target"])["tied"].transform("sum"))


EQUAL = _equal(
    ("a", "x:one", 1e-6, 1e-3, 1.0, False),
    ("a", "x:two", 1e-6, 1.1e-3, 1.1, False),
    ("a", "y:three", 1e-6, 3e-3, 3.0, True),
    ("b", "x:two", 1e-6, 2e-3, 1.0, True),
    ("b", "y:three", 1e-6, 1e-2, 5.0, False),
    ("c", "y:three", 1e-6, 1e-2, 1.0, False),
)
SIX = TARGETS.index(1e-6)


def _plain(text: str) -> str:
    return text.replace("\N{NO-BREAK SPACE}", " ")


def test_a_cell_names_the_one_that_is_separated_from_all_others_or_the_tie() -> None:
    first, second, third = tables.fastest(EQUAL, [("a", ""), ("b", ""), ("d", "")])
    assert (first.cells[SIX].text, first.cells[SIX].note) == ("tie of 2", "x:one 1.00 ms, x:two 1.10 ms")
    assert second.cells[SIX].text == "x:two"
    assert _plain(second.cells[SIX].note) == (
        "≤ 2.00 ms · null call 3 % · prepared in 20.0 ms with filled caches, first use not measured"
    )
    assert third.cells[SIX].text == first.cells[0].text == "not reached"


def test_the_best_of_the_other_side_stands_beside_the_one_that_is_named() -> None:
    ours = EQUAL.assign(library=EQUAL["library"].replace({"x": "gnomon", "y": "scipy"}))
    _, second = tables.fastest(ours, [("a", ""), ("b", "")])
    assert _plain(second.cells[SIX].note).endswith("first use not measured · best third-party: y:three 5.0 ×")


def test_a_users_own_integrator_is_no_third_party_and_has_no_ratio_to_compiled_code() -> None:
    """It may run in Python: neither as the best beside gnomon's own, nor with the best of the others beside it."""
    for library, other in (("gnomon", "mine"), ("mine", "scipy")):
        given = EQUAL.assign(library=EQUAL["library"].replace({"x": library, "y": other}))
        _, second = tables.fastest(given, [("a", ""), ("b", "")])
        assert "best" not in second.cells[SIX].note


@pytest.mark.parametrize(
    ("cell", "share", "text", "note"),
    [
        (ONE_LAUNCH, 0.034, "not separated", "one launch: x:one 1.00 ms, x:two 1.10 ms"),
        (TOO_SHORT, 0.34, "too short to rank", "null call 34 %: x:one 1.00 ms, x:two 1.10 ms"),
        (TOO_SHORT, math.nan, "too short to rank", "null call not measured: x:one 1.00 ms, x:two 1.10 ms"),
    ],
)
def test_a_cell_that_is_not_ranked_says_why(cell: str, share: float, text: str, note: str) -> None:
    (row,) = tables.fastest(EQUAL.assign(cell=cell, slower=False, null_share=share), [("a", "")])
    assert (row.cells[SIX].text, _plain(row.cells[SIX].note)) == (text, note)


def test_over_all_cases_ranked_cells_are_counted() -> None:
    cells = {row.head: row.cells[SIX] for row in tables.overall(EQUAL)}
    assert {name: (cell.text, _plain(cell.note)) for name, cell in cells.items()} == {
        "x:one": ("alone 0, tied 1", "of 1 ranked · 1.0 ×"),
        "x:two": ("alone 1, tied 1", "of 2 ranked · 1.0 ×"),
        "y:three": ("alone 1, tied 0", "of 3 ranked · 3.0 ×"),
    }
    assert {row.head: row.note for row in tables.overall(EQUAL)} == {
        "x:one": "prepared in 30.0 ms with filled caches, 4.20 s at first use (on a)",
        "x:two": "prepared in 20.0 ms with filled caches, first use not measured",
        "y:three": "",
    }
    assert tables.overall(EQUAL.assign(cell=ONE_LAUNCH)) == [], "nothing is ranked"


def test_a_library_is_as_fast_as_its_best_on_each_case_and_slower_where_that_is_separated() -> None:
    cells = {row.head: row.cells[SIX] for row in tables.libraries(EQUAL)}
    assert (cells["x"].text, cells["x"].note) == ("1.0 ×", "2 of 3 cases, slower on 0 of 2 ranked")
    assert (cells["y"].text, cells["y"].note) == ("3.0 ×", "3 of 3 cases, slower on 2 of 3 ranked")
    once = {row.head: row.cells[SIX] for row in tables.libraries(EQUAL.assign(cell=ONE_LAUNCH, slower=False))}
    assert once["y"].note == "3 of 3 cases"


def _ran() -> pd.DataFrame:
    """Rows of `analysis.settings` for the cases and integrators of EQUAL."""
    names = (
        EQUAL[["case", "integrator_id", "library"]].drop_duplicates().assign(variant="", formulation="", status="ok")
    )
    return names.assign(prepare_seconds=0.013, setting=1e-6)


def test_times_of_a_case_say_how_they_compare_and_from_how_many_launches() -> None:
    never = pd.DataFrame(
        [{"case": "a", "integrator_id": "x:no", "variant": "", "formulation": "", "status": "refused"}]
    )
    ran = pd.concat([_ran(), never.assign(library="x", prepare_seconds=math.nan, setting=1e-6)])
    uses = pd.DataFrame({"first_use": [2.5], "first_case": ["b"]}, index=["x:two"])
    rows = {row.head: row for row in tables.equal_error_rows(EQUAL, ran, uses)["a"]}
    assert [row.cells[-1].text for row in rows.values()] == ["13.0 ms"] * 3 + ["–"], "preparation is beside it"
    firsts = [row.cells[-1].note for row in rows.values()]
    assert firsts == ["first use not measured", "2.50 s at first use (on b)", "first use not measured", ""]
    assert list(rows) == ["x:one", "x:two", "y:three", "x:no"]
    cells = {name: row.cells[SIX] for name, row in rows.items()}
    assert [cell.note for cell in cells.values()] == ["tied", "tied", "3.0 ×", ""]
    assert [cell.text for cell in cells.values()] == ["1.00 ms", "1.10 ms", "≤ 3.00 ms", "–"]
    assert _plain(cells["y:three"].aside) == " · null call 3 % · 2.70 ms – 3.30 ms"
    alone = tables.equal_error_rows(EQUAL, ran, uses)["b"]
    assert [row.cells[SIX].note for row in alone] == ["fastest", "5.0 ×"]


@pytest.mark.parametrize("cell", [ONE_LAUNCH, TOO_SHORT])
def test_times_of_a_cell_that_is_not_ranked_have_no_ratio(cell: str) -> None:
    rows = tables.equal_error_rows(EQUAL.assign(cell=cell, slower=False), _ran(), pd.DataFrame())["a"]
    assert [(row.cells[SIX].note, row.cells[SIX].kind) for row in rows] == [(cell, "")] * 3


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
    assert (best.text, best.note) == ("3.0e-14", "3 × attainable")
    assert (knob.text, knob.note) == ("order 3.98 ± 0.05", "declared 4")
    assert (parts.text, parts.note) == ("phase 2.0e-6", "shape 3.0e-7")
    assert (growth.text, growth.note) == ("t²", "power 2.01 (1.90 to 2.12); reaches 1.0e-5")
    assert drift.note == "the energy: power 0.60 (0.10 to 1.10) (2.0e-9); spin: round-off (2.0e-14)"


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
    assert [number_text.counted(n, "case") for n in (0, 1, 2)] == ["0 cases", "1 case", "2 cases"]
    assert [number_text.counted(n, "library") for n in (1, 5)] == ["1 library", "5 libraries"]


def test_the_measurements_that_waited_for_a_processor_are_counted() -> None:
    """A delay that is not known is stated, so that it does not count as no wait."""
    frame = pd.DataFrame({"seconds_median": [1.0, 1.0, 1.0], "delay_seconds": [0.0, 0.1, 0.2]})
    older = frame.assign(delay_seconds=[None, None, 0.2]).astype(float)
    known, unknown = (
        numbers_in(number_text.waited_text(*waited(zip(each["seconds_median"], each["delay_seconds"], strict=True))))
        for each in (frame, older)
    )
    assert known[:2] == ["2", "3"]
    assert unknown == ["1", *known[1:], "2"]
