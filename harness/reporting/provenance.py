"""Where the files beside a page come from: revision, sources, machine, versions and day of each; whether it is older.

A page calls `origins` with its folders and the environment of its last run, names those that are `older`, and says
`processors_text` at its head.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gnomon.harness.reporting import sidecars
from gnomon.harness.results import number_text

MADE_BY = {
    "benchmarks.json": "make bench",
    "orders.json": "make bench",
    "growth.json": "make bench",
    "certificates.json": "make certificates",
    "checks.json": "make certificates",
    "stability.json": "make stability",
    "engines.json": "make engines",
    "verification.json": "make verification",
    "outside.json": "make outside",
}
"""The files of a publication beside the results, and the command that makes each again."""
TIMED = ("benchmarks.json", "engines.json", "outside.json")
"""Of these, the files with times that a page shows."""
NOT_VERSIONS = ("machine", "cpu", "cores", "system", "sources", "revision", "date")
"""What an environment names besides versions."""


@dataclass(frozen=True)
class Origin:
    """The origin of a file; a text is empty where the file does not say it, as files of earlier revisions."""

    file: str
    command: str
    environment: Mapping[str, str]
    older: bool
    """Whether other sources made it than the page's run."""

    @property
    def part(self) -> str:
        """The name of the part: the file's."""
        return self.file.removesuffix(".json")

    @property
    def timed(self) -> bool:
        return self.file in TIMED

    @property
    def revision(self) -> str:
        return self.environment.get("revision", "")

    @property
    def date(self) -> str:
        return self.environment.get("date", "")

    @property
    def versions(self) -> dict[str, str]:
        """Python's, gnomon's and the libraries' versions."""
        return {name: value for name, value in self.environment.items() if name not in NOT_VERSIONS}


def origins(folders: Sequence[Path], run: Mapping[str, str | None]) -> list[Origin]:
    """The origin of each file that the first of `folders` with one has; `run`: the environment of the page's last run."""
    contents = {name: sidecars.first(name, *folders) for name in MADE_BY}
    made_by = {name: environment_of(content) for name, content in contents.items() if content is not None}
    return [Origin(name, MADE_BY[name], each, _is_older(each, run)) for name, each in made_by.items()]


def environment_of(content: Mapping[str, Any]) -> dict[str, str]:
    """The environment that a file names; of earlier files only the revisions, of rows or of the whole."""
    environment = {name: value for name, value in content.get("environment", {}).items() if value is not None}
    if environment:
        return environment
    rows = [row["revision"] for row in content.get("rows", ()) if row.get("revision")]
    revisions = dict.fromkeys([*rows, *([content["revision"]] if content.get("revision") else [])])
    return {"revision": ", ".join(revisions)} if revisions else {}


def _is_older(made_by: Mapping[str, str], run: Mapping[str, str | None]) -> bool:
    """Whether neither the hash of the sources nor a revision without changes is that of the run."""
    revision = made_by.get("revision", "")
    same = made_by.get("sources") is not None and made_by.get("sources") == run.get("sources")
    return not (same or (revision.isalnum() and revision == run.get("revision")))


def processors_text(environments: Sequence[Mapping[str, str | None]]) -> str:
    """The processors of the times, in a sentence: of the page's runs and of the origins that are `timed`."""
    known = [f"{each['cpu']} ({each.get('cores') or '?'} cores)" for each in environments if each.get("cpu")]
    models = list(dict.fromkeys(known))
    if not models:
        return "The processor of the times is unknown."
    if len(models) == 1:
        return f"All times are of one processor model, {models[0]}; others may order methods otherwise."
    return f"Times are of {len(models)} processor models: {number_text.join_words(models)}. Compare none of one with another's."
