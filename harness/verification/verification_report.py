"""The report of a verification as text, JSON, JUnit XML, Markdown, annotations, a badge; the file of known failures."""

from __future__ import annotations

import html
import json
import re
import shlex
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from gnomon.cases.core.numbers import nearest
from gnomon.harness.results.visible import visible
from gnomon.harness.studies import preflight
from gnomon.harness.system.files import read_text
from gnomon.harness.verification.claims import TEXTS, TIME, Outcome
from gnomon.harness.verification.diagnosis import HISTORY
from gnomon.harness.verification.verify import Report, Row
from gnomon.reference.numerics.precision import shortened

SCHEMA = 1
"""Version of the JSON result; it changes when a key disappears or changes its meaning."""
PASSED, FAILED, NOT_VERIFIED = 0, 1, 2
"""Exit codes; NOT_VERIFIED means that nothing failed, but `Report.gaps` are left."""
WORDS = {PASSED: "verified", FAILED: "failed", NOT_VERIFIED: "not verified"}

Known = Mapping[tuple[str, str], str]
"""(claim, case) -> the reason why the failure is known."""


def read_known(path: Path) -> dict[tuple[str, str], str]:
    """The known failures of a text file, a line each: `CLAIM CASE REASON`; empty lines and lines with # are comments.

    Raises ValueError for an unknown claim, a line without a reason, a duplicate line, and a file that is not text.
    """
    known: dict[tuple[str, str], str] = {}
    for number, line in enumerate(read_text(path).splitlines(), 1):
        words = line.split(maxsplit=2)
        if not words or words[0].startswith("#"):
            continue
        if len(words) < 3:
            raise ValueError(f"{path}:{number}: {shortened(line.strip())}; write CLAIM CASE REASON")
        claim, case, reason = words
        if claim not in TEXTS:
            raise ValueError(f"{path}:{number}: no claim is called {shortened(claim)}; {nearest(claim, TEXTS)}")
        if (claim, case) in known:
            raise ValueError(f"{path}:{number}: {claim} {case} is listed twice; list it once")
        known[claim, case] = reason
    return known


def new_failures(report: Report, known: Known) -> list[Row]:
    """The failures that are not known."""
    return [row for row in report.of(Outcome.FAILED) if (row.claim, row.case) not in known]


def exit_code(report: Report, known: Known) -> int:
    """1 if a claim failed and the failure is not known, 2 if `Report.gaps` are left, else 0."""
    if new_failures(report, known):
        return FAILED
    return NOT_VERIFIED if report.gaps() else PASSED


def counts(report: Report, known: Known) -> dict[str, int]:
    """The numbers of claims on cases: checked, passed, failed, known failures, not applicable, not checked."""
    failures = report.of(Outcome.FAILED)
    return {
        "checked": report.checked,
        "passed": len(report.of(Outcome.PASSED)),
        "failed": len(failures),
        "known": len(failures) - len(new_failures(report, known)),
        "not_applicable": len(report.of(Outcome.NOT_APPLICABLE)),
        "not_checked": len(report.of(Outcome.NOT_CHECKED)),
    }


def command(report: Report, row: Row, how: str) -> str:
    """The command that verifies one claim on one case and draws a failure; `how` is its name of the integrator.

    If solutions depend on earlier calls, a claim may fail only after other claims, so the command verifies all claims.
    """
    if row.claim in preflight.TEXTS:
        return f"gnomon verify {how} --claim {row.claim}" + f" --case {row.case}" * (
            row.claim == preflight.ACCELERATION
        )
    if row.claim != TIME and (report.diagnosis or "").startswith(HISTORY):
        named = "".join(f" --claim {claim}" for claim in report.claims)
        return f"gnomon verify {how} --case {row.case}{named} --depth {report.depth}"
    more = "--picture failure.svg" if row.claim != TIME else f"--against {shlex.quote((report.against or ('',))[0])}"
    return f"gnomon verify {how} --case {row.case} --claim {row.claim} --depth {report.depth} {more}"


def failure(row: Row, explained: bool = True) -> list[str]:
    """A failure as text: place, expected and actual result; `explained`: also statement, reason, bound of the claim."""
    finding = row.finding
    at = f", {finding.setting}" if finding.setting else ""
    claim = [f"  claim:    {TEXTS[row.claim]['states']}"] if explained else []
    reasons = [f"  why:      {finding.why}", f"  bound:    {TEXTS[row.claim]['bound']}"] if explained else []
    measured = [f"  expected: {finding.expected}", f"  got:      {finding.got}"]
    return [f"FAILED {row.claim} on {row.case}{at}", *claim, *measured, *reasons]


def cause(report: Report) -> list[str]:
    """The likely cause of all failures as a line, if one is known."""
    return [] if report.diagnosis is None else [f"likely cause: {report.diagnosis.partition(': ')[2]}"]


def lines(report: Report, known: Known, how: str) -> list[str]:
    """The report as text: failures, each claim explained once, their likely cause, times, reasons why claims do not
    apply, known failures, notes, counts."""
    lines: list[str] = []
    failures = new_failures(report, known)
    for claim in dict.fromkeys(row.claim for row in failures):
        for number, row in enumerate(row for row in failures if row.claim == claim):
            lines += [*failure(row, number == 0), f"  command:  {command(report, row, how)}"]
    lines += cause(report) if failures else []
    lines += times(report)
    for outcome in (Outcome.NOT_APPLICABLE, Outcome.NOT_CHECKED):
        reasons: dict[str, list[Row]] = {}
        for row in report.of(outcome):
            reasons.setdefault(row.finding.why, []).append(row)
        for why, rows in reasons.items():
            claims, cases = Counter(row.claim for row in rows), Counter(row.case for row in rows)
            counted, what = claims, ""
            if outcome == Outcome.NOT_CHECKED:
                counted, what = cases, f"{next(iter(claims)) if len(claims) == 1 else 'claims'} on "
            lines.append(f"{outcome}: {what}{', '.join(f'{name} ({count})' for name, count in counted.items())}: {why}")
    for row in report.rows:
        reason = known.get((row.claim, row.case))
        if reason is not None and row.finding.outcome == Outcome.FAILED:
            lines.append(f"known failure: {row.claim} on {row.case}: {reason}")
        if reason is not None and row.finding.outcome == Outcome.PASSED:
            lines.append(f"passes now: {row.claim} on {row.case}; take it from the file of known failures ({reason})")
    lines += [*gaps(report, known), *notes(report)]
    return [visible(line) for line in [*lines, total(report, known)]]


def gaps(report: Report, known: Known) -> list[str]:
    """The reasons, a line each, why an integrator without failures does not count as verified."""
    return [f"not verified: {gap}" for gap in report.gaps()] if exit_code(report, known) == NOT_VERIFIED else []


def notes(report: Report) -> list[str]:
    """The notes, a line each, marked as information beside the verdict."""
    return [f"for information: {note}" for note in report.notes]


def times(report: Report) -> list[str]:
    """The comparison with another version as text: the files of both, then a line for each case that is not slower."""
    if report.against is None:
        return []
    timed = [row for row in report.rows if row.claim == TIME and row.finding.outcome == Outcome.PASSED]
    return [
        f"time: {report.against[1]}",
        *(f"time on {row.case}, {row.finding.setting}: {row.finding.got}" for row in timed),
    ]


def total(report: Report, known: Known) -> str:
    """The counts as a sentence."""
    number = counts(report, known)
    more = f" (about {report.more_seconds:.2g} s more)" if number["not_checked"] and report.more_seconds else ""
    return (
        f"{report.integrator}: {number['checked']} claims checked on {report.cases_checked} cases, {number['passed']} passed,"
        f" {number['failed']} failed ({number['known']} known), {number['not_applicable']} not applicable,"
        f" {number['not_checked']} not checked{more}: {WORDS[exit_code(report, known)]}"
    )


def as_json(report: Report, known: Known, how: str) -> str:
    """The report as JSON, with the version of its schema."""
    rows: list[dict[str, Any]] = [
        {
            "claim": row.claim,
            "case": row.case,
            "outcome": row.finding.outcome.value,
            "known": known.get((row.claim, row.case)),
            "setting": row.finding.setting,
            "expected": row.finding.expected,
            "got": row.finding.got,
            "why": row.finding.why,
            "command": command(report, row, how),
        }
        for row in report.rows
    ]
    claims = {name: {"states": text["states"], "bound": text["bound"]} for name, text in TEXTS.items()}
    versions = None if report.against is None else {"requirement": report.against[0], "versions": report.against[1]}
    whole = {"schema": SCHEMA, "integrator": report.integrator, "depth": report.depth, "counts": counts(report, known)}
    whole |= {"verdict": WORDS[exit_code(report, known)], "gaps": report.gaps(), "diagnosis": report.diagnosis}
    whole |= {"against": versions, "notes": report.notes, "rows": rows, "claims": claims}
    return json.dumps(whole, indent=1) + "\n"


def as_junit(report: Report, known: Known, how: str) -> str:
    """The report as JUnit XML: a test case for each claim on each case, and one for the verdict.

    Known and inapplicable claims are skipped; claims that were not checked, and a missing verdict, are errors.
    """
    number, open_ = counts(report, known), gaps(report, known)
    suite = ElementTree.Element(
        "testsuite",
        name=f"gnomon verify {_xml(report.integrator)}",
        tests=str(len(report.rows) + 1),
        failures=str(number["failed"] - number["known"]),
        skipped=str(number["not_applicable"] + number["known"]),
        errors=str(number["not_checked"] + bool(open_)),
    )
    for row in report.rows:
        test = ElementTree.SubElement(suite, "testcase", classname=row.case, name=row.claim)
        finding, reason = row.finding, known.get((row.claim, row.case))
        if finding.outcome == Outcome.NOT_APPLICABLE:
            ElementTree.SubElement(test, "skipped", message=_xml(finding.why))
        elif finding.outcome == Outcome.NOT_CHECKED:
            ElementTree.SubElement(test, "error", message=_xml(f"not checked: {finding.why}"))
        elif finding.outcome == Outcome.FAILED and reason is not None:
            ElementTree.SubElement(test, "skipped", message=_xml(f"known failure: {reason}"))
        elif finding.outcome == Outcome.FAILED:
            message = _xml(f"{finding.setting}: expected {finding.expected}, got {finding.got}")
            text = ElementTree.SubElement(test, "failure", message=message)
            text.text = _xml(f"{finding.why}\n{command(report, row, how)}")
    verdict = ElementTree.SubElement(suite, "testcase", classname="all cases", name="verified")
    if open_:
        ElementTree.SubElement(verdict, "error", message=_xml("\n".join(open_)))
    return ElementTree.tostring(suite, encoding="unicode", xml_declaration=True) + "\n"


def as_markdown(report: Report, known: Known, how: str) -> str:
    """The report for a pull request: the counts, then a table of the new failures."""
    lines = ["### gnomon verify", "", _cell(total(report, known)), ""]
    failures = new_failures(report, known)
    if failures:
        lines += ["| claim | case | setting | expected | got | alone |", "|---|---|---|---|---|---|"]
    for row in failures:
        finding = row.finding
        cells = [row.claim, row.case, finding.setting, finding.expected, finding.got, command(report, row, how)]
        lines.append(f"| {' | '.join(map(_cell, cells))} |")
    lines += ["", *map(_cell, cause(report))] if failures else []
    for more in (gaps(report, known), times(report), notes(report)):
        lines += ["", *(f"- {_cell(line)}" for line in more)] if more else []
    return "\n".join(lines) + "\n"


def _cell(text: str) -> str:
    """Text that Markdown shows as it is, on one line."""
    plain = " ".join(visible(line) for line in text.splitlines())
    return html.escape(re.sub(r"([\\`*_\[\]|~#])", r"\\\1", plain), quote=False)


def workflow_commands(report: Report, known: Known, how: str) -> list[str]:
    """A line for each failure that is not known, and each gap, in the notation of GitHub Actions' workflow commands."""
    commands = []
    for row in new_failures(report, known):
        text = "\n".join([*failure(row), command(report, row, how)])
        title = _workflow(f"gnomon: {row.claim} on {row.case}").replace(":", "%3A").replace(",", "%2C")
        commands.append(f"::error title={title}::{_workflow(text)}")
    return commands + [f"::error title=gnomon::{_workflow(gap)}" for gap in gaps(report, known)]


def _workflow(text: str) -> str:
    """Text for a workflow command: % and line ends are encoded."""
    return "%0A".join(visible(line).replace("%", "%25") for line in text.splitlines())


def as_badge(report: Report, known: Known, how: str) -> str:
    """The JSON of a badge for shields.io's endpoint: passed of checked claims; grey if it is not verified."""
    number = counts(report, known)
    colour = {PASSED: "brightgreen", FAILED: "red", NOT_VERIFIED: "lightgrey"}[exit_code(report, known)]
    message = f"{number['passed']} of {number['checked']} claims"
    if exit_code(report, known) == NOT_VERIFIED:
        message = f"not verified: {message}" if number["checked"] else "nothing checked"
    return json.dumps({"schemaVersion": 1, "label": "gnomon", "message": message, "color": colour}) + "\n"


def _xml(text: str) -> str:
    """Text without characters that XML 1.0 does not allow."""
    return "\n".join(visible(line) for line in text.split("\n"))


WRITERS: Mapping[str, Callable[[Report, Known, str], str]] = {
    "json": as_json, "junit": as_junit, "markdown": as_markdown, "badge": as_badge
}  # fmt: skip
"""The writer of each kind of file, from the report, the known failures and the integrator's name on a command line."""
