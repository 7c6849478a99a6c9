"""How an accuracy report was measured: method, certificates, versions, and the commands that repeat it."""

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.reporting.pdf.answers import join_names
from gnomon.harness.reporting.pdf.parts import Part, chapter, code, table, terms, words
from gnomon.harness.reporting.pdf.pictures import shorten
from gnomon.harness.reporting.pdf.subject import Subject
from gnomon.harness.reporting.report_checks import WAYS, certificate_rows, check_rows, motion_name
from gnomon.harness.results.number_text import count_text, error_text, join_words
from gnomon.harness.results.profiles import OURS
from gnomon.harness.running.plan import SUITES

CALLS = {
    "compiled": "The equations are compiled together with the method: a time has no cost of calls.",
    "direct": "It calls compiled equations directly.",
    "python": "It calls the equations through Python: a time includes one call of Python for each right-hand side.",
    "own": "It moves the bodies by its own equations: a time has no calls of the equations of the case.",
    "engine": "The engine moves a scene; docs/libraries.md has the part of Python in its steps.",
}
UNKNOWN = "not recorded"


def method(subject: Subject) -> dict[str, Any]:
    """How errors and times are measured."""
    rows = [
        (
            "Exact",
            "The exact motion of a case is the solution for the very binary64 numbers that the integrator was given, as"
            " exact fractions: a closed form, or an integration to 30 digits and more where none exists. It is rounded to"
            " binary64 once, at the 64 equally spaced sample times.",
        ),
        (
            "Error",
            "At each sample, each group of coordinates (position, velocity, angle, attitude) is compared with the exact one"
            " and divided by its size in the motion; whole turns of an angle do not count. The error is the largest over"
            " groups and samples, so that 1e-6 means six correct digits. It has no unit.",
        ),
        (
            "Status",
            "A setting is ok if its error is at most 0.1 or 10 times the conditioning; else it is inaccurate or, beyond the"
            " size of the motion, diverged. Settings that raise, crash, decline or pass the time limit are failures too.",
        ),
        (
            "Floor",
            "Half a unit in the last place of the exact states as an error: no binary64 answer can be closer, and no digits"
            " beyond it are stated.",
        ),
        (
            "Conditioning",
            "The effect of half a unit in the last place of initial state, parameters and time on the exact motion. The"
            " larger of floor and conditioning is the attainable error.",
        ),
        ("Orientation", "Where a case has a rotational symmetry and the suite asks for it, the error is the median over starts turned about"
         " its axis: one start may have a small error by chance."),
        ("Time", f"The median of repeated calls in a worker process of its own, from the call to the last sample. {_calls(subject)}"),
    ]  # fmt: skip
    return chapter("Method", terms(rows), begins="second page")


def _calls(subject: Subject) -> str:
    if subject.library == OURS:
        return CALLS["compiled"]
    known = LIBRARIES.get(subject.library)
    way = known.way(subject.name.partition(":")[2]) if known is not None else ""
    return CALLS.get(way or ("engine" if subject.engine else ""), "")


def chapters(subject: Subject, folders: Sequence[Path]) -> list[dict[str, Any]]:
    """Certificates, versions, and how to reproduce the report."""
    return [
        chapter("Certificates of the exact motions", *_certificates(subject, folders), begins="page"),
        chapter("Versions", _versions(subject)),
        chapter("How to reproduce", *_commands(subject)),
    ]


def _certificates(subject: Subject, folders: Sequence[Path]) -> list[Part]:
    """The certificates of the exact motions of this report, by way; then the independent computations."""
    ran = {(case, variant or "default") for case, variant in subject.ran[["case", "variant"]].itertuples(index=False)}
    rows = [row for row in certificate_rows(*folders) if (row["case"], row["variant"]) in ran]
    motions = count_text(len(ran), "exact motion")
    if not rows:
        return [words(
            f"The run has no file certificates.json, so this report states no certificates of its {motions}.",
            "gnomon certify writes this file; a report that is made beside the file shows the certificates.",
        ), _checks(folders)]  # fmt: skip
    good, bad = [row for row in rows if row["passed"]], [motion_name(row) for row in rows if not row["passed"]]
    least = min(rows, key=lambda row: float(row["digits"]))
    bare = len(ran) - len({(row["case"], row["variant"]) for row in rows})
    lacking = f" Without a certificate here: {bare}." if bare else ""
    failed = f" Not confirmed: {join_names(bad, 8)}: errors against these are not certified." if bad else ""
    revisions = join_words(sorted({str(row["revision"]) for row in rows if row["revision"]}))
    origin = f" The certificates are of revision {revisions}, this run is of {_revision(subject)}." if revisions else ""
    confirmed = words(
        f"Confirmed: {len(good)} of the {motions} of this report, by computations that share no formula with them;"
        f" the fewest digits are {float(least['digits']):.1f} ({motion_name(least)}), where binary64 has 16."
        f"{lacking}{failed}{origin}",
        "Required are 45 digits of a closed form, and 30 of a motion that is integrated in high precision, each by at"
        " least two independent ways; digits are counted relative to the size of the motion, 50 at most.",
    )
    by_way = []
    for way, meaning in WAYS.items():
        digits = [float(row["ways"][way]) for row in rows if way in row["ways"]]
        if digits:
            by_way.append([way, str(len(digits)), f"{min(digits):.1f}", meaning])
    heads = ["way", ">motions", ">fewest digits", "<>the exact motion agrees with"]
    return [confirmed, table(heads, by_way, size=8.5), _checks(folders)]


def _checks(folders: Sequence[Path]) -> Part:
    """The agreement of independent computations, which do not depend on the integrator."""
    rows = [row for row in check_rows(*folders) if row["variant"] == "default"]
    known = [row for row in rows if row["error"] is not None]
    if not known:
        return words()
    worst = max(known, key=lambda row: row["error"])
    checks = len({row["check"] for row in rows})
    others = len(rows) - len(known)
    return words(
        f"Beside the motions, {count_text(len(known), 'number')} of {count_text(checks, 'check')} without motion (moments of"
        " inertia, frequencies, reactions) were computed by independent libraries: the largest difference from the closed"
        f" form is {error_text(worst['error'])} ({worst['check']}, {worst['quantity']}, by {worst['library']})"
        + (f"; {others} could not be computed." if others else "."),
    )


def _revision(subject: Subject) -> str:
    return shorten(subject.environment.get("revision") or UNKNOWN, 60)


def _versions(subject: Subject) -> Part:
    known = {name: value for name, value in subject.environment.items() if value}
    first = [
        name
        for name in ("gnomon", "revision", "sources", "python", "system", "cpu", "cores", "machine")
        if name in known
    ]
    rows = [(shorten(name, 60), shorten(known[name], 60)) for name in (*first, *sorted(known.keys() - {*first}))]
    half = (len(rows) + 1) // 2
    rows += [("", "")] * (2 * half - len(rows))
    pairs = [[*rows[i], *rows[half + i]] for i in range(half)]
    return table(["", "<>", "", "<>"], pairs, size=8.5)


def dates(subject: Subject) -> str:
    """The dates of the runs."""
    first, last = subject.history[0], subject.history[-1]
    day, started, ended = first["started"][:10], first["started"][11:16], "not ended"
    if last["ended"]:
        ended = f"ended {last['ended'][:16].replace('T', ' ').removeprefix(day).strip()}"
    return f"started {day} {started} UTC, {ended}"


def _commands(subject: Subject) -> list[Part]:
    lines = list(dict.fromkeys(str(run["command"]) for run in subject.history if run["command"]))
    parts = [code(*(shorten(line, 400) for line in lines[-4:]), title="The run was made by")] if lines else []
    if subject.library in {OURS, *LIBRARIES}:
        parts.append(code(*_again(subject), title="In a clone of gnomon, with pip"))
        parts.append(words(
            "Errors and counts of evaluations do not depend on the speed of a machine; times, and settings that the time"
                " limit ended, do. compare reports each error, order, count and status that became worse.",
        ))  # fmt: skip
    else:
        parts.append(words(
            f"{shorten(subject.name, 60)} does not come with gnomon: the commands above name where it comes from.",
        ))  # fmt: skip
    return parts


def _again(subject: Subject) -> list[str]:
    quoted, environment = shlex.quote(subject.name), subject.environment
    library = LIBRARIES.get(subject.library)
    extras = ",".join(filter(None, ("report", library.extra if library else None)))
    wanted = ["numpy", "llvmlite", *(library.versions if library else ())]
    pins = [shlex.quote(f"{name}=={environment[name]}") for name in dict.fromkeys(wanted) if environment.get(name)]
    suite = str(subject.history[-1]["suite"])
    planned = {row.case for row in subject.run.outstanding.planned}
    run = ["gnomon run"]
    if suite in SUITES:
        run.append(f"--suite {suite}")
    if suite not in SUITES or planned != {name.partition("/")[0] for name in SUITES[suite].names()}:
        run += [f"--case {shlex.quote(name)}" for name in sorted(planned)]
    others = subject.run.frame["integrator_id"].nunique() > 1
    revision = environment.get("revision", "")
    changed = "  # the run was made with changes that this revision lacks" if revision.endswith("+") else ""
    return [
        f"git checkout {shlex.quote(revision.rstrip('+'))}{changed}" if revision else "",
        " ".join([f"pip install '.[{extras}]'", *pins]),
        " ".join([*run, f"--integrator {quoted}", "--out again.sqlite"]),
        f"gnomon compare {shlex.quote(subject.run.path.name)} again.sqlite" + (" --allow-missing" if others else ""),
        f"gnomon report again.sqlite --pdf {quoted} --out again.pdf",
    ]
