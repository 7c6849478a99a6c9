"""Which integrator to choose: by kind of system, and each on one line."""

import math

import pandas as pd
import pytest
from gnomon.harness.reporting.findings import findings
from gnomon.harness.reporting.report_integrators import HEADS, integrator_rows, kind_rows, kinds, lines_of
from gnomon.harness.results.rankings import ONE_LAUNCH, RANKED


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
    """Ratios at 1e-6 by case and integrator; ratios from 1.2 are separated."""
    table = pd.DataFrame(rows, columns=["case", "integrator_id", "ratio"])
    table = table.assign(
        target=1e-6, variant="", formulation="", library=table["integrator_id"].str[0], tied=table["ratio"] < 1.2,
        slower=table["ratio"] >= 1.2, cell=RANKED, preparation=table["case"].map({"a": 0.01, "b": 0.03, "c": math.nan}),
        first_use=0.5, first_case="a",
    )  # fmt: skip
    return table.assign(leaders=table.groupby("case")["tied"].transform("sum"))


EQUAL = _equal(
    ("a", "x:one", 1.0), ("a", "x:two", 1.1), ("a", "y:all", 4.0), ("a", "y:easy", 1.5),
    ("b", "x:one", 3.0), ("b", "x:two", 1.0), ("b", "y:all", 6.0),
    ("c", "y:easy", 1.0),
)  # fmt: skip
REDUCED = pd.DataFrame(
    [
        ("a", "stiff", "x:one", 1e-9, "ok"), ("a", "long", "x:one", math.nan, "timeout"),
        ("a", "stiff", "x:two", 1e-9, "ok"), ("a", "long", "x:two", 1e-8, "ok"),
        ("a", "long", "y:all", math.nan, "unsupported"), ("a", "long", "y:easy", math.nan, "skipped"),
        ("b", "", "x:one", 1e-9, "ok"),
    ],
    columns=["case", "variant", "integrator_id", "error_max", "status"],
).assign(formulation="", conditioning=1e-15, setting=0.1)  # fmt: skip
ORDERS = pd.DataFrame(
    [("a", "x:one", 3.9, 4.0), ("b", "x:one", 4.0, 4.0), ("c", "x:one", math.nan, 4.0)],
    columns=["case", "integrator_id", "order", "declared"],
).assign(variant="", formulation="")


def _trusted(*rows: tuple[str, str, float, float, float]) -> pd.DataFrame:
    columns = ["case", "integrator_id", "best", "attainable", "over_tolerance"]
    return pd.DataFrame(rows, columns=columns).assign(variant="", formulation="")


def test_of_fewer_than_five_cases_nothing_is_said() -> None:
    """Neither of four ranked cases, nor of two hard variants of one."""
    (row,) = kind_rows(_many(4), REDUCED, {"all": ["a", *(f"c{k}" for k in range(4))]})
    assert {(cell.text, cell.kind) for cell in row["cells"]} == {("–", "none")}
    assert row["cells"][1].note == "fewer than 5 cases are ranked"
    assert row["cells"][-1].note == "hard variants of fewer than 5 cases"
    assert row["named"] == []


def _hard(*solvers: tuple[str, int], variants: int = 2) -> pd.DataFrame:
    """Each integrator solves the variants of the first cases of six, as many as stand beside it."""
    rows = [
        (f"c{k}", f"hard{n}", name, 1e-9 if k < count else math.nan, "ok" if k < count else "timeout")
        for name, count in solvers
        for k in range(6)
        for n in range(variants)
    ]
    table = pd.DataFrame(rows, columns=["case", "variant", "integrator_id", "error_max", "status"])
    return table.assign(formulation="", conditioning=1e-15, setting=0.1)


def test_a_cell_names_the_cases_on_which_it_rests() -> None:
    (row,) = kind_rows(_many(6), _hard(("x:one", 6), ("y:two", 3)), {"all": [f"c{k}" for k in range(6)]})
    assert row["cells"][1].note == "of 6 cases ranked: x:one 6 of 6"
    assert row["cells"][-1].note == "of 12 variants of 6 cases: x:one 12 of 12, y:two 6 of 12"
    assert row["named"] == ["x:one", "y:two"]


def _exact_on(cases: int, setting: float = 0.5, error: float = 1e-15) -> pd.DataFrame:
    """Default variants on which x:one has this error at this setting; at a smaller setting its error is round-off."""
    rows = [
        (f"c{k}", "", "x:one", each, "ok", at) for k in range(cases) for each, at in ((error, setting), (1e-15, 0.1))
    ]
    table = pd.DataFrame(rows, columns=["case", "variant", "integrator_id", "error_max", "status", "setting"])
    return table.assign(formulation="", conditioning=1e-16)


def test_cases_on_which_a_method_is_exact_by_construction_do_not_count_for_it() -> None:
    """WHFast moves two bodies on Kepler's orbits at any step: of nineteen gravitating problems thirteen are such ones."""
    hard, kinds_of = _hard(("x:one", 6), ("y:two", 6)), {"all": [f"c{k}" for k in range(6)]}
    (row,) = kind_rows(_many(6), pd.concat([hard, _exact_on(3)]), kinds_of)
    assert row["cells"][1].note == "fewer than 5 cases are ranked", "three are left"
    assert row["cells"][-1].note == "of 12 variants of 6 cases: x:one 6 of 6, y:two 12 of 12", (
        "all that count are solved"
    )
    (row,) = kind_rows(_many(6), pd.concat([hard, _exact_on(3, error=1e-7)]), kinds_of)
    assert row["cells"][1].note == "of 6 cases ranked: x:one 6 of 6", "accurate at a small step, and not exact"


def _many(count: int) -> pd.DataFrame:
    """On each of `count` cases x:one is the fastest."""
    return _equal(*[(f"c{k}", name, ratio) for k in range(count) for name, ratio in (("x:one", 1.0), ("y:two", 3.0))])


@pytest.mark.parametrize(("count", "text"), [(5, "2 not separated"), (6, "x:one")])
def test_one_is_named_for_a_kind_where_its_cases_separate_it(count: int, text: str) -> None:
    """If one of two is ahead on five of five cases, the sign test has a p value of 6 %; on six of six, of 3 %."""
    (row,) = kind_rows(_many(count), REDUCED, {"all": [f"c{k}" for k in range(count)]})
    assert row["cells"][1].text == text


def test_cells_that_are_not_ranked_are_not_counted() -> None:
    (row,) = kind_rows(_many(6).assign(cell=ONE_LAUNCH), REDUCED, {"all": [f"c{k}" for k in range(6)]})
    assert (row["cells"][1].text, row["cells"][1].note) == ("–", "fewer than 5 cases are ranked")


def _with_decoys(table: pd.DataFrame, **other: object) -> pd.DataFrame:
    """The table with further rows of other numbers: of a hard variant, and in a formulation."""
    decoys = table.assign(**other)
    return pd.concat([table, decoys.assign(variant="stiff"), decoys.assign(formulation="sundman")], ignore_index=True)


def test_only_default_variants_in_their_own_coordinates_count() -> None:
    trusted, orders = _trusted(("a", "x:one", 1e-9, 1e-12, 7.0), ("a", "x:two", 1e-9, 1e-12, 0.5)), ORDERS[:1]
    members = {"smooth": ["a", "b"], "other": ["c"]}
    equal = _with_decoys(EQUAL, integrator_id="x:decoy", tied=True, ratio=1.0)
    bent = _with_decoys(trusted, best=0.5, over_tolerance=1e6)
    reduced = pd.concat([REDUCED, REDUCED.assign(formulation="sundman", error_max=1e-9, status="ok")])
    rows, expected = kind_rows(equal, reduced, members), kind_rows(EQUAL, REDUCED, members)
    assert repr(rows) == repr(expected)  # a cell without a number has nan
    said = findings(equal, pd.DataFrame(), rows, reduced, bent)
    assert said == findings(EQUAL, pd.DataFrame(), expected, REDUCED, trusted)
    tighter = pd.concat([_with_decoys(EQUAL, tied=True, ratio=1.0), EQUAL.assign(target=1e-9, ratio=50.0)])
    found = integrator_rows(tighter, bent, _with_decoys(orders, order=1.0), reduced, None, None)
    assert repr(found) == repr(integrator_rows(EQUAL, trusted, orders, REDUCED, None, None))


def test_digits_of_what_is_exact_or_better_than_attainable() -> None:
    """Seventeen where the error is zero; nothing is short of the attainable that is below it."""
    (row,) = integrator_rows(EQUAL, _trusted(("a", "x:one", 0.0, 1e-12, math.nan)), ORDERS[:0], REDUCED, None, None)
    assert [cell.text for cell in row.cells[4:6]] == ["17.0", "0.0"]


def test_kinds_with_one_answer_are_one_part_of_the_sentence_and_undecided_ones_none() -> None:
    equal = pd.concat([_many(20), EQUAL])
    members = {"Smooth: of any kind": [f"c{k}" for k in range(10)], "Stiff ones": [f"c{k}" for k in range(10, 20)]}
    rows = kind_rows(equal, REDUCED, members | {"Other": ["a", "b"]})
    empty = _trusted()
    (said,) = (one for one in findings(equal, pd.DataFrame(), rows, REDUCED, empty) if "By kind" in one)
    assert said.endswith(": x:one for smooth and stiff ones.")
    rows = kind_rows(EQUAL, REDUCED, {"Other": ["a", "b"]})
    assert not any("By kind" in one for one in findings(EQUAL, pd.DataFrame(), rows, REDUCED, empty))


def test_every_integrator_on_one_line() -> None:
    first, second = ("a", "x:one", 1e-9, 1e-12, 7.0), ("b", "x:one", 1e-11, 1e-12, 9.0)
    trusted = _trusted(first, second, ("a", "x:new", math.nan, math.nan, math.nan))
    growth = {"rows": [{"name": "one", "law": "t"}]}
    one, new = integrator_rows(EQUAL, trusted, ORDERS, REDUCED, growth, None)
    assert (one.head, new.head) == ("x:one", "x:new")
    told = dict(zip(HEADS, [(cell.text, cell.note) for cell in one.cells], strict=True))
    assert told == {
        "cases": ("2", ""),
        "fastest at 1e-6": ("alone 0, tied 1", "of 2 ranked · 2.0\N{NO-BREAK SPACE}×"),
        "time over the least": ("2.0 ×", ""),
        "preparation": ("20.0 ms", "500 ms at first use (on a)"),
        "digits at best": ("10.0", ""),
        "short of attainable": ("2.0", ""),
        "order": ("3.95", "on 2, declared 4"),
        "error / tolerance": ("8", ""),
        "hard variants solved": ("50 %", "1 of 2"),
        "energy over long spans": ("–", ""),  # the laws are of gnomon's own integrators
    }
    assert [cell.text for cell in new.cells] == ["1", *["–"] * 9]
    assert [cell.sorts for cell in new.cells[:3]] == ["1", "0", ""]
    trusted["integrator_id"] = "gnomon:one"
    bench = {"rows": [{"name": "one", "order": "16.03", "declared": "16"}]}
    (mine,) = integrator_rows(EQUAL, trusted, ORDERS, REDUCED, growth, bench)
    assert mine.cells[-1].text == "t"
    assert (mine.cells[6].text, mine.cells[6].note) == ("16.03", "declared 16")


@pytest.mark.parametrize("growth", [None, {"rows": []}])
def test_without_laws_the_card_has_none(growth: dict[str, list[str]] | None) -> None:
    (row,) = integrator_rows(EQUAL, _trusted(("a", "x:one", 1e-9, 1e-9, math.nan)), ORDERS[:0], REDUCED, growth, growth)
    assert row.cells[-1].text == "–"


def test_lines_are_given_for_known_integrators_alone() -> None:
    """The names come from a results file: they are looked up, and neither imported nor run."""
    rows = [{"head": "all", "cells": [], "named": ["gnomon:RK4", "os:system"]}]
    found = lines_of(rows)
    assert list(found) == ["gnomon:RK4"]
    assert 'gnomon.solve(swing, (0, 1.5), [1.2, 0.0], "gnomon:RK4"' in found["gnomon:RK4"]
