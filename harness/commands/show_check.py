"""What `gnomon show` prints of a check."""

from __future__ import annotations

import inspect
import textwrap

from gnomon.cases import Check
from gnomon.cases.core.numbers import show as number
from gnomon.harness.commands.source_file import source_file
from rich.console import Console
from rich.markup import escape
from rich.syntax import Syntax
from rich.table import Table


def describe_check(check: Check, out: Console) -> None:
    """Print title, conventions, closed forms, parameters, results and variants."""
    out.print(f"[bold]{escape(check.title)}[/]  {escape(check.id)}   (Beatty, Dynamics, {escape(check.section)})")
    out.print(f"Check: {escape(source_file(type(check)))}", soft_wrap=True)
    out.print(escape(check.conventions))
    out.print("\n[bold]Closed forms[/]")
    text = textwrap.dedent(inspect.getsource(type(check).formulas).rstrip())
    out.print(Syntax(text, "python", background_color="default", word_wrap=True))
    table = Table("name", "value", "unit", "meaning", "domain", title="Parameters", title_justify="left")
    for parameter in check.parameter_list:
        domain = str(check.domain.ranges.get(parameter.name, ""))
        value = number(check.parameters[parameter.name])
        table.add_row(parameter.name, value, parameter.unit, escape(parameter.meaning), escape(domain))
    out.print(table)
    for rule in check.domain.rules:
        out.print(f"Rule: {escape(rule.statement)}")
    table = Table("quantity", "value", title="Results, 15 digits", title_justify="left")
    for name, value in check.exact(15).items():
        table.add_row(name, str(value))
    out.print(table)
    if check.variants:
        table = Table("variant", "what it stresses", title="Variants", title_justify="left")
        for variant in check.variants:
            table.add_row(variant.name, escape(variant.stresses))
        out.print(table)
