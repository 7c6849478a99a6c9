"""The published report: writes reports/ from earlier measurements. Nothing is measured here.

`make publish` is `python -m gnomon.harness.reporting.publication runs/full.sqlite --from reports/local --to reports`.
"""

import argparse
import json
import subprocess
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

from gnomon.harness.contract.status import Status
from gnomon.harness.reporting import report
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
SUITE = "full"
SOURCES = ("reference", "cases", "harness", "src", "pyproject.toml")
"""The paths that must be equal in a revision and the working tree; documents and tests may differ."""


def publish(results: Path, local: Path, to: Path) -> Path:
    """Write the published report and the JSON files beside it into `to`, and return the page's path.

    Raises ValueError, and writes nothing, if something is missing, unfinished, or was made with other sources than the
    working tree has.
    """
    database = store.results_file(results)
    named = {str(database): _finished(database)}
    for name, command in MADE_BY.items():
        path = local / name
        if not path.is_file():
            raise ValueError(f"{path}: missing; `{command}` makes it")
        named[str(path)] = list(_revisions(path))
    for made, revisions in named.items():
        for revision in dict.fromkeys(revisions):
            if revision is None or not is_current(revision):
                raise ValueError(
                    f"{made}: of revision {revision or 'unknown'}, which is not that of these sources;"
                    " remove it and measure again, from sources that are committed"
                )
    to.mkdir(parents=True, exist_ok=True)
    for name in MADE_BY:
        diskcache.replace(to / name, (local / name).read_bytes())
    return report.write_report(database, to, beside=(to,), figures=True)


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
        raise ValueError(f"{path}: not what gnomon writes ({type(error).__name__}: {error}); make it again") from None


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
    parser.add_argument("--to", type=Path, required=True)
    given = parser.parse_args(None if arguments is None else list(arguments))
    try:
        page = publish(given.results, given.local, given.to)
    except (ValueError, OSError) as error:
        print(f"error: {' '.join(str(error).split())}", file=sys.stderr)
        return 2
    print(f"The published report is {page}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
