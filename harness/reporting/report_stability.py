"""The result of `gnomon stability` as rows of the page: what follows from the numbers, an integrator a row."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

from gnomon.harness.contract.status import Status
from gnomon.harness.reporting import sidecars


def stability(*folders: Path) -> dict[str, Any] | None:
    """The panels with their rows, from the first of the folders that has `stability.json`; None if none has."""
    found: dict[str, Any] | None = sidecars.first("stability.json", *folders)
    if found is None:
        return None
    return found | {
        "panels": [
            {"id": name, "title": title, **_rows([row for row in found["rows"] if row["panel"] == name])}
            for name, title in found["panels"].items()
        ]
    }


def _rows(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """The integrators that were measured, and how many were not, by reason."""
    reasons = {word: word.replace("_", " ") for word in ("not_applicable", Status.REFUSED)}
    left_out = Counter(
        f"{text}: {row['data'][word]}" for row in rows for word, text in reasons.items() if word in row["data"]
    )
    measured = [row for row in rows if not set(reasons) & set(row["data"])]
    return {
        "rows": [{"name": row["integrator"], "sentences": row["sentences"]} for row in measured],
        "left_out": [f"{reason} ({count})" for reason, count in left_out.most_common()],
    }
