"""Which integrator to choose: by kind of system, and each on one line."""

from __future__ import annotations

import math

import pandas as pd
import pytest
from gnomon.harness.reporting.findings import findings
from gnomon.harness.reporting.report_card import CARD, card, kind_rows, kinds, lines_of, solved
from gnomon.harness.reporting.tables import Cell


def test_the_most_structured_form_names_the_kind() -> None:
    forms = {
        "swing": {"FirstOrder", "Separable"}, "orbit": {"Separable", "NBody"}, "ball": {"Hybrid"}, "odd": {"Mine"},
    }  # fmt: skip
    found = kinds(forms, ["odd", "swing", "orbit", "ball"])
    assert list(found.items()) == [
        ("Impact, friction and changing contact", ["ball"]),
        ("Bodies under gravitation", ["orbit"]),
        ("Forces of position and time alone", ["swing"]),
    ]


def _equal(*rows: tuple[str, str, float]) -> pd.DataFrame:
    """Ratios at 1e-6 by case and integrator."""
    table = pd.DataFrame(rows, columns=["case", "integrator_id", "ratio"])
    return table.assign(
        target=1e-6, variant="", formulation="", library=table["integrator_id"].str[0], tied=table["ratio"] < 1.2,
        preparation=table["case"].map({"a": 0.01, "b": 0.03, "c": math.nan}),
        first_use=0.5,
        first_case="a",
    )  # fmt: skip


EQUAL = _equal(
    ("a", "x:one", 1.0), ("a", "x:two", 1.1), ("a", "y:all", 4.0), ("a", "y:easy", 1.5),
    ("b", "x:one", 3.0), ("b", "x:two", 1.0), ("b", "y:all", 6.0),
    ("c", "y:easy", 1.0),
)  # fmt: skip
MATRIX = pd.DataFrame(
    [
        ("a", "stiff", "x:one", 1e-9, "ok"),
        ("a", "long", "x:one", math.nan, "timeout"),
        ("a", "stiff", "x:two", 1e-9, "partly"),
        ("a", "long", "x:two", 1e-3, "ok"),
        ("a", "long", "y:all", math.nan, "unsupported"),
        ("b", "", "x:one", 1e-9, "ok"),
    ],
    columns=["case", "variant", "integrator_id", "best", "verdict"],
).assign(formulation="")


def test_what_is_most_often_fastest_is_shown_with_the_other_library_that_reaches_the_error_most_often() -> None:
    """x:two wins both cases, x:one one; y:easy is faster than y:all but reaches the error once."""
    smooth, other = kind_rows(EQUAL, MATRIX, {"smooth": ["a", "b"], "other": ["c"]})
    assert [cell.text for cell in smooth["cells"]] == ["not reached", "x:two", "not reached", "not reached", "x:two"]
    assert smooth["cells"][1].note.replace("\N{NO-BREAK SPACE}", " ") == "fastest on 2 of 2; y:all 5.0 × on 2"
    assert smooth["cells"][-1].note == "2 of 2"
    assert other["cells"][1].note == "fastest on 1 of 1"
    assert (other["cells"][-1].text, other["cells"][-1].note) == ("–", "no hard variant was run")


def test_of_two_with_equal_wins_the_one_that_is_never_slow_is_named() -> None:
    """x:easy has the smaller median; on one case it takes a hundred times as long."""
    equal = _equal(
        ("a", "x:easy", 1.0), ("b", "x:easy", 1.3), ("c", "x:easy", 100.0),
        ("a", "x:even", 1.4), ("b", "x:even", 1.4), ("c", "x:even", 1.0),
    )  # fmt: skip
    (row,) = kind_rows(equal, MATRIX, {"all": ["a", "b", "c"]})
    assert (row["cells"][1].text, row["cells"][1].note) == ("x:even", "fastest on 1 of 3")


def _with_decoys(table: pd.DataFrame, **other: object) -> pd.DataFrame:
    """The table with further rows of other numbers: of a hard variant, and in a formulation."""
    decoys = table.assign(**other)
    return pd.concat([table, decoys.assign(variant="stiff"), decoys.assign(formulation="sundman")], ignore_index=True)


def test_only_default_variants_in_their_own_coordinates_count() -> None:
    trusted = pd.DataFrame(
        [("a", "x:one", 1e-9, 1e-12, 7.0), ("a", "x:two", 1e-9, 1e-12, 0.5)],
        columns=["case", "integrator_id", "best", "attainable", "over_tolerance"],
    ).assign(variant="", formulation="")
    orders = pd.DataFrame([("a", "x:one", 3.9, 4.0)], columns=["case", "integrator_id", "order", "declared"])
    orders = orders.assign(variant="", formulation="")
    members = {"smooth": ["a", "b"], "other": ["c"]}
    equal = _with_decoys(EQUAL, integrator_id="x:decoy", tied=True, ratio=1.0)
    bent = _with_decoys(trusted, best=0.5, over_tolerance=1e6)
    matrix = pd.concat([MATRIX, MATRIX.assign(formulation="sundman", best=1e-9)])
    rows, expected = kind_rows(equal, matrix, members), kind_rows(EQUAL, MATRIX, members)
    assert rows == expected
    said = findings(equal, pd.DataFrame(), rows, matrix, bent)
    assert said == findings(EQUAL, pd.DataFrame(), expected, MATRIX, trusted)
    tighter = pd.concat([_with_decoys(EQUAL, tied=True, ratio=1.0), EQUAL.assign(target=1e-9, ratio=50.0)])
    found = card(tighter, bent, _with_decoys(orders, order=1.0), matrix, None, None)
    assert found == card(EQUAL, trusted, orders, MATRIX, None, None)


def test_one_answer_for_all_kinds_is_no_finding() -> None:
    rows = kind_rows(EQUAL, MATRIX, {"smooth": ["a", "b"], "stiff": ["b"]})
    empty = pd.DataFrame(columns=["case", "variant", "formulation", "integrator_id", "over_tolerance"])
    assert not any("By kind" in sentence for sentence in findings(EQUAL, pd.DataFrame(), rows, MATRIX, empty))


def test_of_two_with_equal_wins_the_one_that_reaches_more_is_named() -> None:
    """x:more and x:few win once each; z:near and y:far reach both cases, z:once to one."""
    equal = _equal(
        ("a", "x:few", 1.0), ("a", "x:more", 5.0), ("b", "x:more", 1.0), ("a", "y:far", 9.0), ("b", "y:far", 9.0),
        ("a", "z:near", 2.0), ("b", "z:near", 2.0), ("a", "z:once", 1.5),
    )  # fmt: skip
    (row,) = kind_rows(equal, MATRIX, {"all": ["a", "b"]})
    note = row["cells"][1].note.replace("\N{NO-BREAK SPACE}", " ")
    assert (row["cells"][1].text, note) == ("x:more", "fastest on 1 of 2; z:near 2.0 × on 2")


@pytest.mark.parametrize(
    ("count", "note"),
    [
        (1, "2 of 3"),
        (2, "2 of 3; so does x:1"),
        (3, "2 of 3; so do x:1, x:2"),
        (5, "2 of 3; so do x:1, x:2 and 2 more"),
    ],
)
def test_which_integrators_solve_most_hard_variants(count: int, note: str) -> None:
    """Of three, each ran two; another one solved the third."""
    rows = [("a", variant, f"x:{k}", 1e-9, "ok") for k in range(count) for variant in ("long", "stiff")]
    rows += [("a", "far", "y:one", 1e-9, "ok")]
    matrix = pd.DataFrame(rows, columns=MATRIX.columns[:5]).assign(formulation="")
    (row,) = kind_rows(EQUAL, matrix, {"all": ["a"]})
    assert (row["cells"][-1].text, row["cells"][-1].note) == ("x:0", note)


def test_digits_of_what_is_exact_or_better_than_attainable() -> None:
    """Seventeen where the error is zero; nothing is short of the attainable that is below it."""
    columns = ["case", "integrator_id", "best", "attainable", "over_tolerance"]
    trusted = pd.DataFrame([("a", "x:one", 0.0, 1e-12, math.nan)], columns=columns).assign(variant="", formulation="")
    empty = pd.DataFrame(columns=["case", "variant", "formulation", "integrator_id", "order", "declared"])
    (row,) = card(EQUAL, trusted, empty, MATRIX, None, None)
    assert [cell.text for cell in row.cells[4:6]] == ["17.0", "0.0"]


def test_kinds_with_one_answer_are_one_part_of_the_sentence() -> None:
    rows = kind_rows(EQUAL, MATRIX, {"Smooth: of any kind": ["a", "b"], "Stiff ones": ["b"], "Other": ["c"]})
    empty = pd.DataFrame(columns=["case", "variant", "formulation", "integrator_id", "over_tolerance"])
    said = findings(EQUAL, pd.DataFrame(), rows, MATRIX, empty)
    assert (
        "By kind of system, most often the fastest at 1e-6: x:two for smooth and stiff ones; y:easy for other." in said
    )


def test_a_hard_variant_is_solved_where_some_setting_is_ok() -> None:
    each, problems = solved(MATRIX)
    assert problems == 2
    assert each.to_dict("index") == {"x:one": {"solved": 1, "ran": 2}, "x:two": {"solved": 2, "ran": 2}}


def test_every_integrator_on_one_line() -> None:
    trusted = pd.DataFrame(
        [
            ("a", "x:one", 1e-9, 1e-12, 7.0),
            ("b", "x:one", 1e-11, 1e-12, 9.0),
            ("a", "x:new", math.nan, math.nan, math.nan),
        ],
        columns=["case", "integrator_id", "best", "attainable", "over_tolerance"],
    ).assign(variant="", formulation="")
    orders = pd.DataFrame(
        [("a", "x:one", 3.9, 4.0), ("b", "x:one", 4.0, 4.0), ("c", "x:one", math.nan, 4.0)],
        columns=["case", "integrator_id", "order", "declared"],
    ).assign(variant="", formulation="")
    growth = {"rows": [{"name": "one", "law": "t"}]}
    one, new = card(EQUAL, trusted, orders, MATRIX, growth, None)
    assert (one.head, new.head) == ("x:one", "x:new")
    told = dict(zip(CARD, [(cell.text, cell.note) for cell in one.cells], strict=True))
    assert told == {
        "cases": ("2", ""),
        "fastest at 1e-6": ("1", "of 2"),
        "time over the fastest’s": ("2.0 ×", ""),
        "preparation": ("20.0 ms", "500 ms at first use (on a)"),
        "digits at best": ("10.0", ""),
        "short of attainable": ("2.0", ""),
        "order": ("3.95", "on 2, declared 4"),
        "error / tolerance": ("8", ""),
        "hard variants solved": ("50 %", "1 of 2"),
        "energy over long spans": ("–", ""),  # the laws are those of gnomon's own
    }
    assert [cell.text for cell in new.cells] == ["1", *["–"] * 9]
    assert [cell.sorts for cell in new.cells[:3]] == ["1", "0", ""]
    trusted["integrator_id"] = "gnomon:one"
    bench = {"rows": [{"name": "one", "order": "16.03", "declared": "16"}]}
    (mine,) = card(EQUAL, trusted, orders, MATRIX, growth, bench)
    assert mine.cells[-1].text == "t"
    assert (mine.cells[6].text, mine.cells[6].note) == ("16.03", "declared 16")


@pytest.mark.parametrize("growth", [None, {"rows": []}])
def test_without_laws_the_card_has_none(growth: dict[str, list[str]] | None) -> None:
    empty = pd.DataFrame(columns=["case", "variant", "formulation", "integrator_id", "order", "declared"])
    trusted = pd.DataFrame([("a", "", "", "x:one", 1e-9, 1e-9, math.nan)], columns=[
        "case", "variant", "formulation", "integrator_id", "best", "attainable", "over_tolerance",
    ])  # fmt: skip
    (row,) = card(EQUAL, trusted, empty, MATRIX, growth, growth)
    assert row.cells[-1].text == "–"


def test_lines_are_given_for_known_integrators_alone() -> None:
    """The names come from a results file: what it names is looked up, and neither imported nor run."""
    rows = [{"head": "all", "cells": [Cell("gnomon:RK4"), Cell("not reached", kind="none"), Cell("os:system")]}]
    found = lines_of(rows)
    assert list(found) == ["gnomon:RK4"]
    assert 'solve(swing, 0.0, [1.2, 0.0], [0.5, 1.0, 1.5], 2**-7, "gnomon:RK4")' in found["gnomon:RK4"]
