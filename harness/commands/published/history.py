"""`gnomon history`: numbers over the published revisions."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from gnomon.harness.commands import options
from gnomon.harness.commands.options import out, problems
from rich.box import SIMPLE_HEAD
from rich.markup import escape
from rich.table import Column, Table

if TYPE_CHECKING:
    from gnomon.harness.results.publications import Entry

SHOWN = 6
"""The number of publications in a table: the last ones."""
MOST = 7
"""The largest number of lines in a figure, whose colours can be told apart."""
WIDTH, HEIGHT = 640, 320


def history(
    name: Annotated[
        list[str] | None, typer.Argument(help="A number, or a 'pattern*'; several. By default their kinds are listed.")
    ] = None,
    source: Annotated[
        Path, options.path_option("The file that `make publication` writes: a publication after the other.", "--from")
    ] = Path("reports/history.json"),
    drawing: Annotated[Path | None, options.path_option("Draw them too: a file .html, .svg or .png.", "--out")] = None,
) -> None:
    """Follow numbers over the published revisions: errors and counts; times on one machine only."""
    # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
    from gnomon.harness.results import number_text, publications

    if drawing is not None:
        if not name:
            raise ValueError(f"--out {drawing}: name the numbers to draw")
        options.ensure_drawing(drawing, "--out")
    entries = publications.read(source)
    if not entries:
        raise ValueError(f"{source}: holds no publication; `make publication` records one")
    if not name:
        out.print(kinds_table(publications.names(entries)))
        out.print(
            f"{number_text.count_text(len(entries), 'publication')}, the last one {escape(entries[-1].label)}",
            highlight=False,
        )
        return
    chosen = publications.choose(entries, name)
    if drawing is not None and len(chosen) > MOST:
        raise ValueError(f"--out {drawing}: {len(chosen)} numbers, of which {MOST} can be told apart; name fewer")
    rows = {each: publications.values(entries, each) for each in chosen}
    out.print(numbers_table(entries, rows))
    apart = sum(each in entry.numbers for each in chosen for entry in entries) - sum(
        value is not None for values in rows.values() for value in values
    )
    if apart:
        problems.print(f"{apart} times of other machines are left out", highlight=False)
    if drawing is not None:
        from gnomon.harness.reporting.images import save

        save(specification(entries, rows), drawing)
        out.print(f"drawn: {escape(str(drawing))}", highlight=False)


def kinds_table(names: Sequence[str]) -> Table:
    """What is recorded: each kind of number, an example and their count."""
    counts = Counter(each.partition("/")[0] for each in names)
    table = Table("kind", "numbers", Column("as", no_wrap=True), box=SIMPLE_HEAD, padding=(0, 1))
    for kind, count in counts.items():
        table.add_row(kind, str(count), escape(next(each for each in names if each.startswith(f"{kind}/"))))
    return table


def numbers_table(entries: Sequence[Entry], rows: dict[str, list[float | None]]) -> Table:
    """A row for each number, a column for each of the last publications."""
    shown = entries[-SHOWN:]
    columns = [Column(escape(entry.label), justify="right") for entry in shown]
    table = Table(Column("number", no_wrap=True), *columns, box=SIMPLE_HEAD, padding=(0, 1))
    for each, values in rows.items():
        table.add_row(escape(each), *("–" if value is None else f"{value:g}" for value in values[-SHOWN:]))
    return table


def specification(entries: Sequence[Entry], rows: dict[str, list[float | None]]) -> dict[str, Any]:
    """Lines over the publications, a colour each, as a specification of Vega-Lite."""
    import altair  # slow to load: only a drawing needs it
    from gnomon.harness.reporting.style import dress

    places = [f"{number + 1}: {entry.label}" for number, entry in enumerate(entries)]
    points = [
        {"publication": place, "number": each, "value": value}
        for each, values in rows.items()
        for place, value in zip(places, values, strict=True)
        if value is not None
    ]
    chart = (
        altair.Chart(altair.NamedData("history"), width=WIDTH, height=HEIGHT)
        .mark_line(point=True)
        .encode(
            x=altair.X("publication:O", title="publication", sort=places, scale=altair.Scale(domain=places)),
            y=altair.Y("value:Q", title="value", scale=altair.Scale(zero=False)),
            color=altair.Color("number:N", title=None, sort=[*rows]),
        )
    )
    return dict(dress(chart).to_dict(validate=False)) | {"datasets": {"history": points}}
