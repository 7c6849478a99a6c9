"""Writes docs/cases.md, the list of all cases and checks with their files.

`make catalogue` is `python -m gnomon.harness.reporting.publication.catalogue`, in a working tree.
"""

from itertools import groupby
from pathlib import Path

from gnomon.cases.core.registry import Entry, entry
from gnomon.harness.registry.selection import source_file
from gnomon.harness.reporting.report_charts import slug

from gnomon import cases

PAGE = Path("docs/cases.md")
HEAD = """# Cases and checks

Each case has its file, the file of its exact motion, and a chart if the published report has one. `gnomon show NAME` prints the
equations, numbers, quantities and variants of a case. Sections are sections of Beatty, *Dynamics*.
"""


def page() -> str:
    """The text of docs/cases.md."""
    text = HEAD
    own = [row for row in map(entry, cases.names()) if row.path.startswith("gnomon.cases.")]
    for folder, rows in groupby(sorted(own, key=_folder), key=_folder):
        table = "\n".join(map(_case_row, rows))
        text += f"\n## {folder}\n\n| case | title | section | file | exact motion | chart |\n|---|---|---|---|---|---|\n{table}\n"
    table = "\n".join(map(_check_row, map(entry, cases.check_names())))
    return text + f"\n## Checks, without motion\n\n| check | title | section | file |\n|---|---|---|---|\n{table}\n"


def _folder(row: Entry) -> str:
    return row.path.split(".")[2].replace("_", " ")


def _case_row(row: Entry) -> str:
    case = cases.get(row.name)
    chart = f"reports/figures/{slug(row.name)}.svg"
    shown = f"`{chart}`" if Path(chart).is_file() else ""
    files = f"`{source_file(type(case))}` | `{source_file(type(case.motion()))}`"
    return f"| {row.name} | {row.title} | {case.section} | {files} | {shown} |"


def _check_row(row: Entry) -> str:
    kind = cases.check_class(row.name)
    return f"| {row.name} | {row.title} | {kind.section} | `{source_file(kind)}` |"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
