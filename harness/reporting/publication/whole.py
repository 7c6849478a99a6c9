"""Whether the files of a publication are whole: every subject, no trial left to run, no fault without a reason."""

from collections.abc import Callable, Mapping, Sequence, Set
from pathlib import Path

from gnomon.harness.certification import certify_all, independent_checks
from gnomon.harness.contract.status import Status
from gnomon.harness.registry import lookup
from gnomon.harness.reporting import sidecars
from gnomon.harness.results import store
from gnomon.harness.running.plan import SUITES
from gnomon.harness.stability.panel import panels
from gnomon.harness.studies import league

SUITE = "full"
KEYS = {
    "certificates.json": ("case", "variant"),
    "checks.json": ("check", "variant", "computation"),
    "stability.json": ("integrator", "panel"),
    "engines.json": ("integrator", "scene"),
}
"""Files that may hold a part of all subjects, and the keys of a row that name its subject."""
UNEXPLAINED = ("not_measured", "survivors_without_reason")
"""Keys of verification.json that must be empty."""
CONTINUED = ("foundation", "hard", "stability_long", "verification_right")
"""Parts whose file another part continues."""

Subjects = Mapping[str, Set[tuple[str, ...]]]
"""By file, the subjects that it must have, as the values of the keys in KEYS."""


def require(folder: Path, part: str, names: Sequence[str]) -> None:
    """Raise ValueError if a file of a part in `folder` is missing, or lacks what the part measures."""
    for name in names:
        if not (folder / name).is_file():
            raise ValueError(f"{folder / name}: missing, though the commands of {part} have ended")
        if part not in CONTINUED:
            require_whole(folder / name)


def require_whole(path: Path, subjects: Callable[[], Subjects] | None = None) -> None:
    """Raise ValueError if a file lacks a subject, has trials left to run, or faults without a reason."""
    if path.suffix == ".sqlite":
        require_finished(path)
        return
    contents = sidecars.read(path)
    wanted = (subjects or all_subjects)().get(path.name) if path.name in KEYS else None
    if wanted is not None:
        lacking = sorted(wanted - {tuple(row[key] for key in KEYS[path.name]) for row in contents["rows"]})
        if lacking:
            some = ", ".join("/".join(subject) for subject in lacking[:3])
            raise ValueError(f"{path}: lacks {len(lacking)} of {len(wanted)} subjects ({some})")
    for key in UNEXPLAINED if path.name == "verification.json" else ():
        if contents.get(key):
            raise ValueError(
                f"{path}: {key}: {len(contents[key])}; name their reasons in tests/detection, and measure again"
            )


def all_subjects() -> Subjects:
    """The subjects that the published files must have: every case and check with its variants, every integrator."""
    return {
        "certificates.json": {(name, variant or "default") for name, variant in certify_all.subjects((), True)},
        "checks.json": {
            (check.name, check.variant or "default", computation.name)
            for check in independent_checks.everything()
            for computation in independent_checks.COMPUTATIONS
            if computation.check == check.name
        },
        "stability.json": {(name, panel) for name in lookup.general() for panel in panels()},
        "engines.json": {
            (integrator.id, scene)
            for integrator in league.choose_shown(lookup.own().values())
            for scene in SUITES["engines"].scope.cases
        },
    }


def require_finished(database: Path) -> None:
    """Raise ValueError if trials of the published suite are still to be run."""
    runs, frame = store.runs(database), store.load(database)
    if not any(run["suite"] == SUITE and run["ended"] for run in runs) or not runs[-1]["ended"]:
        raise ValueError(f"{database}: holds no finished run of the suite {SUITE}; the same command resumes it")
    cut_short = int((frame["status"] == Status.INTERRUPTED).sum())
    if cut_short:
        raise ValueError(f"{database}: {cut_short} trials were interrupted; the same command runs them again")
