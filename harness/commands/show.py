"""`gnomon show`: print a case or a check, and draw a motion."""

from pathlib import Path
from typing import Annotated

import typer
from gnomon.harness.commands import options
from gnomon.harness.commands.options import out
from gnomon.harness.registry.completion import complete_subject


def show(
    case: Annotated[
        str | None, typer.Argument(help=f"{options.CASE}; a check or check/variant.", autocompletion=complete_subject)
    ] = None,
    named: options.CaseOption = None,
    parameters: options.Parameters = None,
    plot: Annotated[Path | None, options.path_option("Draw the motion to this file: .svg, .png or .html.")] = None,
    source: Annotated[bool, typer.Option("--source", help="Print equations as the functions of the case.")] = False,
    latex: Annotated[bool, typer.Option("--latex", help="Print only the equations of motion, in LaTeX.")] = False,
) -> None:
    """Print a case (equations, parameters, quantities, variants) or a check; draw the motion to a file."""
    # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
    from gnomon.harness.commands.show_case import describe, describe_check
    from gnomon.harness.kernels.case_equations import equations_in_latex

    from gnomon import cases

    name = options.one_case(case, named)
    if name.partition("/")[0] in cases.check_names():
        if plot is not None or latex:
            raise ValueError(f"{name} is a check, without motion: there are no equations, and there is nothing to draw")
        check, _, variant = name.partition("/")
        describe_check(cases.get_check(check, variant or None, **options.read_parameters(parameters)), out)
        return
    chosen = options.choose_one(name, parameters, rounded=False)
    if plot is not None:
        options.ensure_drawing(plot, "--plot")
    if latex:
        for text in equations_in_latex(chosen):
            print(text)
    else:
        describe(chosen, out, source)
    if plot is not None:
        from gnomon.harness.reporting.pictures.motion_picture import draw

        draw(chosen, plot)
        out.print(f"The motion is drawn in {plot}.")
