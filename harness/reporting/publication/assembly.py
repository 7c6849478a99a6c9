"""Writes reports/ from the parts of a publication, with exact versions, the hash of the raw results and the history."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gnomon.harness.registry import environment
from gnomon.harness.reporting import provenance, report, sidecars
from gnomon.harness.reporting.publication import numbers, whole
from gnomon.harness.reporting.publication.parts import RESULTS, Place
from gnomon.harness.reporting.report_charts import keep_figures_of_manifest
from gnomon.harness.reporting.report_run import Run
from gnomon.harness.results import publications, store, study_file
from gnomon.harness.results.advice import engine_facts
from gnomon.harness.running import recommending
from gnomon.reference.storage import diskcache

RAW, MOST_BYTES = Path("runs/raw.parquet"), 20_000_000
"""The raw results as a table, and the largest size of this file."""
OUTSIDE = "outside.json"
"""The file of the trial on systems outside of the catalogue, whose margin the table has."""
TABLE = Path("harness/results/advice/recommendations.jsonl")
"""The table of `gnomon recommend`, in the repository from which the publication is made."""


@dataclass(frozen=True)
class Found:
    """What is assembled: the results file, the file of each name, and the packages that were installed."""

    results: Path
    files: Mapping[str, Path]
    installed: Mapping[str, str]

    @property
    def run(self) -> dict[str, str]:
        """The environment of the last run of the results."""
        last = store.runs(self.results)[-1]
        made_by = {name: value for name, value in last["environment"].items() if value is not None}
        return {"sources": "", "machine": ""} | made_by | {"suite": last["suite"], "date": str(last["started"])[:10]}


def present(place: Place) -> Found:
    """The parts measured with these sources. Raises ValueError if one is missing or has other versions of libraries."""
    records = {part.name: place.record(part) for part in place.parts}
    lacking = [name for name, record in records.items() if record is None]
    if lacking:
        raise ValueError(
            f"{', '.join(lacking)}: not measured with these sources; `make publication` goes on,"
            " and with --with-older assembles with older parts"
        )
    installed = [record["installed"] for record in records.values() if record is not None]
    for name, versions in zip(records, installed, strict=True):
        if versions != installed[0]:
            other = sorted({*versions.items()} ^ {*installed[0].items()})[0][0]
            raise ValueError(
                f"{name}: measured with another version of {other} than {next(iter(records))};"
                f" install one version, and remove {place.folder / 'done' / name}.json"
            )
    publication = Found(
        place.folder / RESULTS, {name: place.folder / name for name in place.files if name != RESULTS}, installed[0]
    )
    for path in (publication.results, *publication.files.values()):
        whole.require_whole(path)
    made_by = {name: provenance.environment_of(sidecars.read(path)) for name, path in publication.files.items()}
    runs = [run["environment"] for run in store.runs(publication.results)]
    for path, each in [
        *((publication.results, origin) for origin in runs),
        *((publication.files[name], origin) for name, origin in made_by.items()),
    ]:
        if each.get("sources") != environment.sources():
            raise ValueError(
                f"{path}: made with other sources than these; remove it, and call `make publication` again"
            )
    return publication


def older(place: Place, to: Path, results: Path | None = None) -> Found:
    """Of each file the present one, else the newest older one: of other sources, or as it is published in `to`.

    `results`: the results file to take in any case. Raises ValueError without a results file, or if a file is nowhere.
    """
    folders = [place.folder, *place.others()]

    def newest(name: str) -> Path | None:
        complete = (folder for folder in folders if all(place.record(part, folder) for part in place.files[name]))
        return next((folder / name for folder in complete), to / name if (to / name).is_file() else None)

    database = store.results_file(results) if results is not None else newest(RESULTS)
    if database is None:
        raise ValueError("no results to assemble: measure --part full, or name a results file with --results")
    files = {name: newest(name) for name in place.files if name != RESULTS}
    lacking = [name for name, path in files.items() if path is None]
    if lacking:
        raise ValueError(f"{', '.join(lacking)}: not measured at all; `make publication` goes on")
    record = place.record(place.files[RESULTS][-1], database.parent) if results is None else None
    made_by = store.runs(database)[-1]["environment"]
    recorded = {name: made_by[name] for name in environment.DISTRIBUTIONS if made_by.get(name)}
    current = environment.list_installed()
    same = all(current.get(name) == version for name, version in recorded.items())
    installed = record["installed"] if record else current if same else recorded
    return Found(database, {name: path for name, path in files.items() if path is not None}, installed)


def assemble(publication: Found, to: Path, raw: Path = RAW, table: Path = TABLE) -> Path:
    """Write the published report into `to`, raw results to `raw`, recommendations to `table` and the league of engines
    beside it; return the page's path.

    Raises ValueError, and writes nothing into `to`, if the raw results or the table are too large, or if the results are
    of several machines or sources, which the table cannot name.
    """
    made_by = publication.run
    exported = _raw(publication, raw) | {"environment": made_by}
    contents = {name: path.read_bytes() for name, path in publication.files.items()}
    table.parent.mkdir(parents=True, exist_ok=True)
    recommending.write_table(Run.read(publication.results), table, publication.files.get(OUTSIDE))
    if engine_facts.FILE in publication.files:
        of_engines = sidecars.read(publication.files[engine_facts.FILE])
        study_file.write(engine_facts.reduce_to_installed(of_engines), table.with_name(engine_facts.FILE))
    to.mkdir(parents=True, exist_ok=True)
    for name, content in contents.items():
        diskcache.replace(to / name, content)
    study_file.write(exported, to / "raw.json")
    diskcache.replace(to / "requirements.txt", requirements(publication.installed, made_by).encode())
    page = report.write_report(publication.results, to, beside=(to,), figures=True)
    keep_figures_of_manifest(to / "figures")
    older_ = {origin.file for origin in provenance.origins([to], made_by) if origin.older}
    files = {name: sidecars.read(to / name) for name in publication.files if name not in older_}
    numbers_ = numbers.of_publication(publication.results, files)
    publications.append(to / publications.FILE.name, publications.Entry(made_by, numbers_))
    return page


def _raw(publication: Found, raw: Path) -> dict[str, Any]:
    """Write the raw results; returns the command that does, and the size and hash of the file."""
    raw.parent.mkdir(parents=True, exist_ok=True)
    store.export(publication.results, raw, "parquet")
    content = raw.read_bytes()
    if len(content) > MOST_BYTES:
        raise ValueError(
            f"{raw}: {len(content)} bytes; raw results may have {MOST_BYTES}: raise the compression in `export`"
        )
    return {
        "file": raw.name,
        "command": f"gnomon export {_name_path(publication.results)} --format parquet --out {_name_path(raw)}",
        "columns": "gnomon export --schema",
        "bytes": len(content),
        "sha256": hashlib.sha256(content).hexdigest(),
    }


def _name_path(path: Path) -> str:
    """A path as another machine can have it: from the current folder, else its name alone."""
    own = path.resolve()
    return own.relative_to(Path.cwd()).as_posix() if own.is_relative_to(Path.cwd()) else own.name


def requirements(installed: Mapping[str, str], made_by: Mapping[str, str]) -> str:
    """The lines of requirements.txt: all packages but gnomon, each in its exact version."""
    of = ", ".join(made_by[name] for name in ("revision", "date") if made_by.get(name))
    head = f"# What was installed beside gnomon ({of}) on Python {made_by.get('python', '3')}: pip install -r requirements.txt\n"
    return head + "".join(f"{name}=={version}\n" for name, version in installed.items())
