"""The report's certificates of the exact motions, and the checks with their independent computations, from JSON files.

certificates.json (`gnomon certify`) and checks.json (`--independent`) are looked for in several folders. If several
folders have a certificate of one case variant, the first folder counts.
"""

from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from gnomon.harness.contract.declared import read_declared
from gnomon.harness.contract.status import Status
from gnomon.harness.reporting import sidecars
from gnomon.harness.results import number_text
from jinja2 import Environment, StrictUndefined
from markupsafe import Markup

WAYS: dict[str, str] = read_declared("reporting", "templates/ways.toml")
"""The ways in which an exact motion is confirmed: what it agrees with."""
SEVERITY = (Status.OK, Status.NOT_INSTALLED, Status.REFUSED, Status.INACCURATE, Status.DIVERGED, Status.CRASHED)


def render_certificates(*folders: Path) -> Markup:
    """Both parts as HTML; empty without files."""
    environment = Environment(undefined=StrictUndefined, autoescape=True, trim_blocks=True, lstrip_blocks=True)
    source = (files("gnomon.harness.reporting") / "templates" / "report_checks.html.j2").read_text(encoding="utf-8")
    rows = certificate_rows(*folders)
    return Markup(
        environment.from_string(source).render(
            ways=WAYS,
            parts=[part for part in _parts(rows) if part["rows"]],
            used={way for row in rows for way in row["ways"]},
            revisions=sorted({row["revision"] for row in rows if row["revision"]}),
            computations=computation_rows(*folders),
        )
    )


def list_certificates(*folders: Path) -> list[str]:
    """The lines of the summary on certificates: the number of confirmed ones, and each one that is not."""
    rows = certificate_rows(*folders)
    if not rows:
        return []
    lines = [
        f"{part['title']}: {part['confirmed']} of {len(part['rows'])} confirmed, {part['fewest']}"
        for part in _parts(rows)
        if part["rows"]
    ]
    return lines + [
        f"not confirmed: {motion_name(row)}, {row['digits']:.1f} digits" for row in rows if not row["passed"]
    ]


def certificate_rows(*folders: Path) -> list[dict[str, Any]]:
    """The certificates by case, the default variant first."""
    certificates: dict[tuple[str, str], dict[str, Any]] = {}
    for folder in reversed(folders):
        for row in _rows("certificates.json", folder):
            variant = row["variant"] or "default"
            certificates[row["case"], variant] = (
                {"required": None, "worst": "", "note": "", "revision": ""} | row | {"variant": variant}
            )
    order = {case: position for position, case in enumerate(dict.fromkeys(case for case, _ in certificates))}
    return sorted(certificates.values(), key=lambda row: (order[row["case"]], row["variant"] != "default"))


def _rows(name: str, folder: Path) -> list[dict[str, Any]]:
    contents = sidecars.first(name, folder)
    return [] if contents is None else list(contents["rows"])


def _parts(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The parts for default variants and for hard variants."""
    parts = []
    for title, default in (("default variants", True), ("hard variants", False)):
        chosen = [row for row in rows if (row["variant"] == "default") is default]
        least = min(chosen, key=lambda row: float(row["digits"]), default=None)
        fewest = f"the fewest digits are {least['digits']:.1f}, of {motion_name(least)}" if least else ""
        failed = [motion_name(row) for row in chosen if not row["passed"]]
        confirmed = len(chosen) - len(failed)
        part = {"title": title, "rows": chosen, "confirmed": confirmed, "failed": failed, "fewest": fewest}
        parts.append(part | {"grouped": not default})
    return parts


def check_rows(*folders: Path) -> list[dict[str, Any]]:
    """The checks of the first folder that has some."""
    return next(filter(None, (_rows("checks.json", folder) for folder in folders)), [])


def computation_rows(*folders: Path) -> list[dict[str, str]]:
    """A row for each independent computation of a check: its worst quantity on the default and on the hard variants."""
    groups: dict[tuple[str, str, str], list[dict[str, Any]]] = {}
    for row in check_rows(*folders):
        groups.setdefault((row["check"], row["computation"], row["library"]), []).append(row)
    rows = []
    for (check, computation, library), own in groups.items():
        default = _worst([row for row in own if row["variant"] == "default"])
        hard = _worst([row for row in own if row["variant"] != "default"])
        seconds = default["seconds"]
        rows.append(
            {
                "check": check,
                "computation": computation,
                "library": library,
                "default": _tell_row(default),
                "default_status": default["status"],
                "quantity": default["quantity"],
                "time": number_text.time_text(seconds) if seconds is not None else "–",
                "hard": _tell_row(hard),
                "hard_status": hard["status"],
                "where": ", ".join(word for word in (hard["variant"], hard["quantity"]) if word),
                "reason": hard["reason"],
            }
        )
    return rows


def _worst(rows: list[dict[str, Any]]) -> dict[str, Any]:
    nothing = {"status": Status.OK, "error": None, "seconds": None, "quantity": "", "variant": "", "reason": ""}
    return max(rows, key=lambda row: (SEVERITY.index(row["status"]), row["error"] or 0), default=nothing)


def _tell_row(row: dict[str, Any]) -> str:
    if row["error"] is None:
        return "–" if row["status"] == Status.OK else str(row["status"]).replace("_", " ")
    return "0" if row["error"] == 0 else number_text.short_text(row["error"])


def motion_name(row: Mapping[str, Any]) -> str:
    """The name of the exact motion of a certificate."""
    return str(row["case"]) if row["variant"] == "default" else f"{row['case']}/{row['variant']}"
