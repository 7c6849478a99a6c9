"""The tables of `gnomon list`, `doctor` and `certify`."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from rich.box import SIMPLE_HEAD
from rich.markup import escape
from rich.table import Table

if TYPE_CHECKING:
    from gnomon.cases import Case, Check
    from gnomon.harness.certification.certify import Certificate


def cases_table() -> Table:
    from gnomon import cases  # slow to load: each table imports what it shows, `gnomon --help` none of it

    return _scenes_table("Cases", "case", [(name, cases.case_class(name)) for name in cases.names()])


def checks_table() -> Table:
    from gnomon import cases

    return _scenes_table("Checks, without motion", "check", [(n, cases.check_class(n)) for n in cases.check_names()])


def _scenes_table(title: str, column: str, kinds: Iterable[tuple[str, type[Case] | type[Check]]]) -> Table:
    """Cases, or checks: name, title and variants of each."""
    table = Table(title=title, box=SIMPLE_HEAD, padding=(0, 1))
    table.add_column(column, no_wrap=True)
    table.add_column("title")
    table.add_column("variants")
    for name, kind in kinds:
        table.add_row(name, kind.title, ", ".join(variant.name for variant in kind.variants))
    return table


def integrators_table() -> Table:
    from gnomon.harness.registry import lookup

    table = Table(title="Integrators", box=SIMPLE_HEAD, padding=(0, 1))
    table.add_column("id", no_wrap=True)
    table.add_column("order", justify="right")
    table.add_column("accepts", no_wrap=True)
    for identity, one in lookup.everything().items():
        accepted = ", ".join(kind.__name__ for kind in one.accepts)
        table.add_row(escape(identity), "" if one.order is None else str(one.order), accepted)
    return table


def environment_table() -> Table:
    """Machine, versions, and where results are cached."""
    from gnomon.harness.contract import environment
    from gnomon.harness.kernels.generated_modules import cache_folder
    from gnomon.reference.storage import diskcache

    table = Table("what", "found", title="Environment", show_header=False)
    for name, value in environment.describe().items():
        table.add_row(name, value)
    table.add_row("compiled equations", str(cache_folder()))
    table.add_row("exact results", str(diskcache.folder()))
    return table


def libraries_table() -> Table:
    """Each library: ready, or why not."""
    from gnomon.harness.registry import lookup

    libraries: dict[str, str | None] = {}
    for one in lookup.everything().values():
        libraries.setdefault(one.library, lookup.missing(one))
    table = Table("library", "state", title="Libraries")
    for library, reason in libraries.items():
        table.add_row(library, "[green]ready[/]" if reason is None else f"[yellow]missing:[/] {escape(reason)}")
    return table


def certificates_table(certificates: Iterable[Certificate]) -> Table:
    """Digits agreed, in all and by each way."""
    table = Table("case", "variant", "digits agreed", "by", title="Exact motions, confirmed")
    for certificate in certificates:
        ways = ", ".join(f"{way} {digits:.0f}" for way, digits in certificate.ways.items())
        colour = "green" if certificate.passed else "red"
        digits = f"[{colour}]{certificate.digits:.0f}[/]"
        table.add_row(certificate.case, certificate.variant, digits, ways or escape(certificate.note))
    return table
