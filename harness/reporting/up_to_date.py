"""Whether a report in a folder is up to date with results, files and sources, so that it need not be written.

One hash stands for all that a report depends on; hashes of the written files are kept under it, in the user's cache.
"""

import gc
import hashlib
import platform
from collections.abc import Iterator, Mapping, Sequence
from importlib.metadata import entry_points, version
from importlib.resources import as_file, files
from pathlib import Path

from gnomon.cases.core.case import Case
from gnomon.harness.reporting import sidecars
from gnomon.harness.results.opening import results_file
from gnomon.harness.system.locks import find_held
from gnomon.reference.storage import diskcache

WRITTEN = ("index.html", "summary.md", "figures/figures.json")
"""The files of a report; the last one lists its figures, if there are any."""
LIBRARIES = ("numpy", "pandas", "altair", "vl-convert-python", "jinja2", "jsonschema")
PACKAGES = ("gnomon.harness", "gnomon.cases", "gnomon.reference")


def refresh(database: Path, folder: Path, cases: Mapping[str, type[Case]]) -> Path:
    """The page of a report in `folder`, which `write_report` writes unless it is up to date.

    A report with `cases` that are not installed is always written. Raises ValueError as `write_report` does.
    """
    database = results_file(database)
    key = None if cases else key_of(database, (database.parent, folder, folder.parent))
    if key is not None and _is_written(key, folder):
        return folder / WRITTEN[0]
    from gnomon.harness.reporting.report import write_report  # takes 2 s to load

    gc.freeze()  # else the garbage collector visits all imported modules again and again
    page = write_report(database, folder, cases)
    if key is not None:
        diskcache.store_or_warn(_entry(key), diskcache.Entry(notes=_state(folder)))
    return page


def key_of(database: Path, folders: Sequence[Path]) -> str | None:
    """The hash of all that the report of a results file depends on; None if installed packages add cases."""
    if entry_points(group="gnomon.cases"):
        return None
    database = database.resolve()  # SQLite writes beside the target of a symbolic link
    parts = [str(database.parts[-2:]), platform.python_version(), *map(version, LIBRARIES)]
    beside = [folder / name for folder in folders for name in sidecars.NAMES]
    for path in (database, database.with_name(database.name + "-wal"), *beside, *_sources()):
        parts.append(_digest(path) if path.is_file() else "")
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()


def _is_written(key: str, folder: Path) -> bool:
    """Whether the files in `folder` were written under this key."""
    known = diskcache.load(_entry(key))
    return known is not None and known.notes == _state(folder)


def _entry(key: str) -> str:
    return f"report {key}"


def _state(folder: Path) -> list[str]:
    paths = [folder / name for name in WRITTEN]
    return [_digest(path) if path.is_file() else "" for path in paths]


def _sources() -> Iterator[Path]:
    for package in PACKAGES:
        with as_file(files(package)) as root:
            yield from sorted(
                path for path in root.rglob("*") if path.suffix not in (".pyc", ".zip") and path.is_file()
            )


def _digest(path: Path) -> str:
    held = find_held(path)  # held open during a run
    with path.open("rb") if held is None else open(held, "rb", closefd=False) as file:
        file.seek(0)
        return hashlib.file_digest(file, "sha256").hexdigest()
