"""The published report: writes reports/ from earlier measurements. Nothing is measured here.

`make publish` is `python -m gnomon.harness.reporting.publication runs/full.sqlite --from reports/local --out reports`.
"""

import argparse
import json
import subprocess
import sys
from collections.abc import Iterable, Iterator, Mapping, Set
from pathlib import Path

from gnomon.harness.certification import certify_all, independent_checks
from gnomon.harness.contract.status import Status
from gnomon.harness.registry import lookup
from gnomon.harness.reporting import report, sidecars
from gnomon.harness.results import store
from gnomon.reference.storage import diskcache

MADE_BY = {
    "benchmarks.json": "make bench",
    "orders.json": "make bench",
    "growth.json": "make bench",
    "certificates.json": "make certificates",
    "checks.json": "make report",
}
"""The files that the page shows beside the results, and the command that makes each."""
KEPT = {"stability.json": "make stability", "verification.json": "make verification"}
"""Files that take hours. A new one is published; without one, the published file stays, of the revision that made it."""
PARTS = {
    "certificates.json": ("case", "variant"),
    "checks.json": ("check", "variant", "computation"),
    "stability.json": ("integrator",),
}
"""Files that may hold a part of all subjects, and the keys of a row that name its subject."""
SUITE = "full"
SOURCES = ("reference", "cases", "harness", "src", "pyproject.toml")
"""The paths that must be equal in a revision and the working tree; documents and tests may differ."""


Subjects = Mapping[str, Set[tuple[str, ...]]]
"""By file, the subjects that it must have, as the values of the keys in PARTS."""


def publish(results: Path, local: Path, to: Path, wanted: Subjects | None = None) -> Path:
    """Write the published report and the JSON files beside it into `to`, and return the page's path.

    `wanted`: the subjects of the files, by default all that there are. Raises ValueError, and writes nothing, if something
    is missing, unfinished, or was made with other sources than the working tree has.
    """
    database = store.results_file(results)
    named = {str(database): _finished(database)}
    made = {name: local / name for name in MADE_BY}
    made |= {name: (local if (local / name).is_file() else to) / name for name in KEPT}
    for name, command in (MADE_BY | KEPT).items():
        if not made[name].is_file():
            raise ValueError(f"{made[name]}: missing; `{command}` makes it")
        if name in MADE_BY:
            named[str(made[name])] = list(_revisions(made[name]))
    for path, revisions in named.items():
        for revision in dict.fromkeys(revisions):
            if revision is None or not is_current(revision):
                raise ValueError(
                    f"{path}: of revision {revision or 'unknown'}, but these sources have another;"
                    " remove it and measure again, from sources that are committed"
                )
    for name, subjects in (all_subjects() if wanted is None else wanted).items():
        _require_all(made[name], subjects, (MADE_BY | KEPT)[name])
    verified = json.loads(made["verification.json"].read_text(encoding="utf-8"))
    for key in ("not_measured", "survivors_without_reason"):
        if verified[key]:
            raise ValueError(f"{made['verification.json']}: {key}: {len(verified[key])}; `make verification` resumes")
    to.mkdir(parents=True, exist_ok=True)
    for name, file in made.items():
        diskcache.replace(to / name, file.read_bytes())
    return report.write_report(database, to, beside=(to,), figures=True)


def all_subjects() -> Subjects:
    """The subjects that the published files must have: every case and check with its variants, every integrator."""
    checks = independent_checks.everything()
    return {
        "certificates.json": {(name, variant or "default") for name, variant in certify_all.subjects((), True)},
        "checks.json": {
            (check.name, check.variant or "default", computation.name)
            for check in checks
            for computation in independent_checks.COMPUTATIONS
            if computation.check == check.name
        },
        "stability.json": {(name,) for name in lookup.own()},
    }


def _require_all(path: Path, subjects: Set[tuple[str, ...]], command: str) -> None:
    """Raise ValueError, with the first subjects that a file lacks, if it lacks any."""
    found = sidecars.read(path)
    rows = found["rows"] if isinstance(found, dict) else found
    lacking = sorted(subjects - {tuple(row[key] for key in PARTS[path.name]) for row in rows})
    if lacking:
        some = ", ".join("/".join(subject) for subject in lacking[:3])
        raise ValueError(
            f"{path}: lacks {len(lacking)} of {len(subjects)} subjects ({some}); `{command}` measures them"
        )


def _finished(database: Path) -> list[str | None]:
    """The revisions of the runs whose measurements count. Raises ValueError if trials are still to be run."""
    runs, frame = store.runs(database), store.load(database)
    if not any(run["suite"] == SUITE and run["ended"] for run in runs) or not runs[-1]["ended"]:
        raise ValueError(
            f"{database}: holds no finished run of the suite {SUITE}; `make report SUITE={SUITE}` resumes it"
        )
    cut_short = int((frame["status"] == Status.INTERRUPTED).sum())
    if cut_short:
        raise ValueError(
            f"{database}: {cut_short} trials were interrupted; `make report SUITE={SUITE}` runs them again"
        )
    return [run["environment"].get("revision") for run in runs if run["run"] in set(frame["run"])]


def _revisions(path: Path) -> Iterator[str | None]:
    """The revisions that a JSON file names: of its environment, or of each row."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
        rows = found if isinstance(found, list) else [found["environment"]]
        if not rows:
            raise ValueError("no rows")
        for row in rows:
            yield row.get("revision")
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        why = f"gnomon did not write this ({type(error).__name__}: {error})"
        raise ValueError(f"{path}: {why}; make it again") from None


def is_current(revision: str, folder: Path | None = None) -> bool:
    """Whether the sources in the working tree of `folder`, by default the current one, equal a revision.

    A revision that ends in "+" had uncommitted changes and is never current.
    """
    if not revision.isalnum():
        return False
    command = ["git", "diff", "--quiet", revision, "--", *(f":/{name}" for name in SOURCES)]
    try:
        return subprocess.run(command, cwd=folder, capture_output=True, check=False).returncode == 0
    except OSError:  # no git
        return False


def main(arguments: Iterable[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("results", type=Path)
    parser.add_argument("--from", dest="local", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    given = parser.parse_args(None if arguments is None else list(arguments))
    try:
        page = publish(given.results, given.local, given.out)
    except (ValueError, OSError) as error:
        print(f"error: {' '.join(str(error).split())}", file=sys.stderr)
        return 2
    print(f"The published report is {page}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
