"""The accuracy report of one integrator or engine: a PDF for those who do not have gnomon."""

import json
import re
from collections.abc import Mapping, Sequence
from datetime import datetime
from importlib.resources import files
from pathlib import Path
from typing import Any, Literal

import typst
from altair.utils import schemapi
from gnomon.cases.core.case import Case
from gnomon.harness.adapters.libraries import LIBRARIES, title
from gnomon.harness.reporting.pdf import answers, measured, provenance
from gnomon.harness.reporting.pdf.pictures import shorten
from gnomon.harness.reporting.pdf.subject import Subject
from gnomon.harness.reporting.report_run import Run
from gnomon.harness.reporting.style import DOCUMENT
from gnomon.harness.results import opening, store
from gnomon.reference.storage import diskcache


def write_accuracy(
    database: Path,
    name: str,
    to: Path,
    cases: Mapping[str, type[Case]] | None = None,
    beside: Sequence[Path] | None = None,
) -> Path:
    """Write the accuracy report of the integrator `name` of a run, and return its path.

    `to` is the file, or a folder for a file with the name of the integrator. `cases` and `beside` are those of
    `write_report`. The same run, with the same files beside it, gives the same bytes. Raises ValueError for a file
    without results, and for an integrator without results.
    """
    database = store.results_file(database)
    with opening.one_state(database):
        subject = Subject.of(Run.read(database, cases), name)
        file = to if to.suffix.lower() == ".pdf" else to / f"{file_name(subject.name)}.pdf"
        folders = beside or (database.parent, file.parent, file.parent.parent)
        with schemapi.debug_mode(False):  # else Altair validates every part of a chart
            content = contents(subject, folders)
    started = datetime.fromisoformat(subject.history[0]["started"])
    file.parent.mkdir(parents=True, exist_ok=True)
    with diskcache.whole(file) as part:
        part.write_bytes(typeset(content, started))
    return file


def file_name(name: str) -> str:
    """A file name for any id."""
    return re.sub(r"[^\w.]+", "-", name)[:80].strip("-.") or "integrator"


def contents(subject: Subject, folders: Sequence[Path]) -> dict[str, Any]:
    """All that the document shows, as its template reads it."""
    library = LIBRARIES.get(subject.library)
    version = subject.environment.get(library.package if library else subject.library)
    of = " ".join(filter(None, (title(subject.library), version)))
    name = shorten(subject.name, 100)
    return {
        "title": f"Accuracy of {name}",
        "name": name,
        "subtitle": f"{shorten(of, 80)}. Measured against exact motions by gnomon; run {provenance.dates(subject)}.",
        "footer": f"gnomon {shorten(subject.environment.get('gnomon', ''), 30)}, run {provenance.dates(subject)}",
        "chapters": [
            *answers.chapters(subject),
            provenance.method(subject),
            *measured.chapters(subject),
            *provenance.chapters(subject, folders),
        ],
    }


def typeset(content: Mapping[str, Any], moment: datetime, form: Literal["pdf", "png"] = "pdf") -> Any:
    """The document as bytes; as a list of pictures, a page each, if `form` is png."""
    return document(content).compile(format=form, ppi=80, timestamp=int(moment.timestamp()))


def document(content: Mapping[str, Any]) -> typst.Compiler:
    """The document, not yet set. Only fonts of typst are used."""
    template = (files("gnomon.harness.reporting.pdf") / "templates" / "accuracy.typ").read_bytes()
    inputs = {"data": json.dumps(content), "colours": json.dumps(DOCUMENT)}
    return typst.Compiler(template, ignore_system_fonts=True, sys_inputs=inputs)
