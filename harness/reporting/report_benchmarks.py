"""The results of `make bench` as rows: claims of speed, times of calls, measured orders, growth of energy errors."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from gnomon.harness.reporting import sidecars, tables
from gnomon.harness.results import number_text
from gnomon.harness.results.time_ratios import SLOWER, Compared, compare_ratios, discoveries, state
from gnomon.harness.studies.growth import name_law, possible
from gnomon.harness.studies.orders import BINARY64, WITHIN

SHOWN_SHARE = 0.1
"""Share of the null call in a time from which it is written beside it."""
KEPT = {
    "symplectic": "symplectic form",
    "volume": "volume in phase space",
    "reversible": "reversal of time",
    "momentum": "momentum",
    "attitude": "rotations",
    "constraint": "constraint",
}
"""Words for the properties that integrators claim to conserve."""


def benchmarks(*folders: Path) -> dict[str, Any] | None:
    """Rows of pairs and of single times, from the first folder that has the file; None without a file.

    `lacks` is empty, or names the numbers of an older file without which nothing can be claimed; it then has no rows.
    """
    contents = sidecars.first("benchmarks.json", *folders)
    if contents is None:
        return None
    lacks = _lacks(contents["rows"])
    rows = [] if lacks else contents["rows"]
    return {
        "lacks": lacks,
        "launches": contents["launches"],
        "environment": contents["environment"],
        "pairs": _pairs([row for row in rows if "first" in row]),
        "singles": [_single(row) for row in rows if "first" not in row],
    }


def _lacks(rows: Sequence[dict[str, Any]]) -> str:
    """What older files lack that a claim needs, in words; empty if nothing."""
    if any("first_name" not in row for row in rows):
        return "the names of the sides of its pairs"
    measured = [row for row in rows if None not in (row.get("first"), row.get("second"))]
    return "the ratios of single launches" if any("ratios" not in row for row in measured) else ""


def growth(*folders: Path) -> dict[str, Any] | None:
    """Growth laws of energy errors in words, from the first folder that has the file; None without a file."""
    contents = sidecars.first("growth.json", *folders)
    return None if contents is None else contents | {"rows": [_law(row) for row in contents["rows"]]}


def orders(*folders: Path) -> dict[str, Any] | None:
    """Measured orders in words, from the first folder that has the file; None without a file."""
    contents = sidecars.first("orders.json", *folders)
    return None if contents is None else contents | {"rows": [_describe_order(row) for row in contents["rows"]]}


def _describe_order(row: dict[str, Any]) -> dict[str, str]:
    off = abs(row["order"] - row["declared"])
    return {
        "name": row["integrator"],
        "case": row["case"],
        "arithmetic": "binary64" if row["digits"] == BINARY64 else f"{row['digits']} digits",
        "formula": "its formula at fixed steps" if row["at_fixed_steps"] else "as it runs",
        "points": str(row["points"]),
        "order": f"{row['order']:.2f}",
        "declared": str(row["declared"]),
        "verdict": "" if off <= WITHIN else f"off by {off:.2f}",
        "keeps": ", ".join(KEPT[word] for word in row["keeps"]),
    }


def _pairs(rows: Sequence[dict[str, Any]]) -> list[dict[str, str]]:
    """The rows in words, each with the state of the second side against the first, at one false discovery rate for all.

    The calls of a pair alternate in one process, so that a launch gives one ratio. The scatter of ratios is combined over
    all pairs.
    """
    timed = [row for row in rows if _has_times(row)]
    ratios = compare_ratios([row["ratios"] for row in timed])
    held = discoveries([ratio.p for ratio in ratios])
    states = {
        id(row): (ratio, state(ratio, bool(holds))) for row, ratio, holds in zip(timed, ratios, held, strict=True)
    }
    return [_pair(row, states.get(id(row))) for row in rows]


def _has_times(row: dict[str, Any]) -> bool:
    """Whether a row is of a pair of which both sides were timed."""
    return row.get("first") is not None and row.get("second") is not None


def _null_shares(row: dict[str, Any]) -> list[str]:
    """The sides whose null call takes a tenth of the time or more, in words."""
    sides = [side for side in ("first", "second") if row[side] is not None]
    shares = [(side, (row[f"{side}_null"] or 0.0) / row[side]) for side in sides]
    return [
        f"{round(100 * share)} % of the time of {row[f'{side}_name']} is overhead of its call"
        for side, share in shares
        if share >= SHOWN_SHARE
    ]


def _pair(row: dict[str, Any], judged: tuple[Compared, str] | None) -> dict[str, str]:
    words = {name: str(row[name]) for name in ("group", "problem", "first_name", "second_name")}
    words["level"] = f"{float(row['level']):.0e}".replace("e-0", "e-")
    for side in ("first", "second"):
        words[side] = "–" if row[side] is None else number_text.time_text(row[side])
        prepare = row.get(f"{side}_prepare")
        words[f"{side}_prepare"] = (
            "" if prepare is None else f"prepared in {number_text.time_text(prepare)} with filled caches"
        )
    missed = [str(row[f"{side}_name"]) for side in ("first", "second") if row[side] is None]
    if missed or judged is None:
        return words | {"ratio": "–", "range": "", "note": f"not so accurate: {' and '.join(missed)}"}
    return words | {
        "ratio": _times(judged[0].ratio),
        "range": f"{_times(judged[0].low)} – {_times(judged[0].high)}",
        "note": "; ".join([*_null_shares(row), *([judged[1]] if judged[1] != SLOWER else [])]),
    }


def _times(ratio: float) -> str:
    return f"{ratio:.2f}" if ratio < 9.95 else f"{ratio:.0f}"


def _single(row: dict[str, Any]) -> dict[str, str]:
    return {
        "group": row["group"],
        "name": row["first_name"],
        "median": number_text.time_text(row["median"]),
        "range": f"{number_text.time_text(row['low'])} – {number_text.time_text(row['high'])}",
    }


def _law(row: dict[str, Any]) -> dict[str, str]:
    low, high = row["low"], row["high"]
    expected = row["expected"]
    return {
        "name": row["integrator"],
        "case": row["case"],
        "setting": row["setting"].replace("e-0", "e-"),
        "periods": f"{row['periods']:.0e}".replace("e+0", "e"),
        "starts": str(row["starts"]),
        "size": number_text.error_text(row["size"]),
        "power": f"{row['power']:.2f} ({low:.2f} to {high:.2f})",
        "law": name_law(low, high, tables.LAWS),
        "expected": tables.LAWS.get(expected, expected),
        "verdict": "" if expected in possible(low, high) else "differs",
    }
