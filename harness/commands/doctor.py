"""`gnomon doctor`: show the machine, the libraries, and the reasons why a library is missing."""

from gnomon.harness.commands.options import out
from rich.markup import escape
from rich.table import Table


def doctor() -> None:
    """Show the machine, the libraries that gnomon finds, and why a library is missing."""
    out.print(environment_table())
    out.print(libraries_table())


def environment_table() -> Table:
    """The machine, versions, and the folders of caches."""
    # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
    from gnomon.harness.kernels.kept_code import cache_folder
    from gnomon.harness.registry import environment
    from gnomon.harness.system.limitations import limitations
    from gnomon.reference.storage import diskcache

    table = Table("what", "found", title="Environment", show_header=False)
    for name, value in environment.describe().items():
        table.add_row(name, value)
    table.add_row("compiled equations", str(cache_folder()))
    table.add_row("exact results", str(diskcache.folder()))
    for what, consequence in limitations().items():
        table.add_row(what, consequence)
    return table


def libraries_table() -> Table:
    """Each library: ready, or the reason why it is missing."""
    from gnomon.harness.registry import lookup

    libraries: dict[str, str | None] = {}
    for integrator in lookup.everything().values():
        libraries.setdefault(integrator.library, lookup.missing(integrator))
    table = Table("library", "state", title="Libraries")
    for library, reason in libraries.items():
        table.add_row(library, "[green]ready[/]" if reason is None else f"[yellow]missing:[/] {escape(reason)}")
    return table
