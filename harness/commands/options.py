"""Parts that the commands share: consoles, common options, and the validation of arguments."""

from __future__ import annotations

import errno
import os
import shlex
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from gnomon.harness.registry.completion import complete_case, complete_integrator
from gnomon.harness.results.visible import shorten, show
from gnomon.harness.system import extras
from rich.console import Console
from rich.text import Text

if TYPE_CHECKING:
    from gnomon.cases import Case
    from gnomon.harness.contract.integrator import Integrator


class Shown(Console):
    """A console that shows no control characters, and no text that the log of a CI service would take as a command."""

    def render_str(self, text: str, **how: Any) -> Text:
        return super().render_str(show(text, lines=True), **how)


class Messages(Shown):
    """The console of messages. Each is cut to a few lines: names and texts from outside may have any length."""

    def render_str(self, text: str, **how: Any) -> Text:
        rendered, half = super().render_str(text, **how), MOST_MESSAGE // 2
        return rendered if len(rendered) <= MOST_MESSAGE else rendered[:half] + " ... " + rendered[-half:]


out = Shown(soft_wrap=True, emoji=False)
problems = Messages(stderr=True, soft_wrap=True, emoji=False)


def columns(least: int) -> int:
    """Columns to write: COLUMNS, or the width of the terminal; elsewhere `least`, with which a table shows whole names."""
    console = Shown()  # a console reads COLUMNS when it is made
    return console.width if console.is_terminal or os.environ.get("COLUMNS", "").isdigit() else least


Engine = Annotated[
    str | None, typer.Option(help="A physics engine, by its name as an integrator; its pre-flights run too.")
]
FmuOrder = Annotated[
    int | None, typer.Option(help="The order in the communication step that an FMU for co-simulation claims.")
]
Claims = Annotated[
    list[str] | None, typer.Option(help="A claim, or a pre-flight, by its id; repeatable. By default all.")
]
Depth = Annotated[str, typer.Option(help="low, normal or high: how many cases, and how short the steps.")]
MaxSeconds = Annotated[
    float | None, typer.Option(help="Claims that are not verified within this time are not checked: no exit code 0.")
]
Every = Annotated[
    bool,
    typer.Option("--all", help="Verify all claims on all cases; by default a known cause of failures ends the run."),
]
Parameters = Annotated[
    list[str] | None,
    typer.Option(
        "--set", help="A parameter of the case, or the start of a coordinate, as L=2 or L=2,theta=1; repeatable."
    ),
]

CASE = "A case, case/variant, 'pattern*' or package.module:Case"
INTEGRATOR = "An id, name, library, 'pattern*' or package.module:object"
CaseArgument = Annotated[str | None, typer.Argument(help=f"{CASE}.", autocompletion=complete_case)]
CaseOption = Annotated[
    str | None, typer.Option("--case", help="The case; the same as the argument.", autocompletion=complete_case)
]
Cases = Annotated[list[str] | None, typer.Option("--case", help=f"{CASE}; repeatable.", autocompletion=complete_case)]
IntegratorArgument = Annotated[str | None, typer.Argument(help=f"{INTEGRATOR}.", autocompletion=complete_integrator)]
IntegratorOption = Annotated[
    str | None,
    typer.Option("--integrator", help="The integrator; the same as the argument.", autocompletion=complete_integrator),
]
Integrators = Annotated[
    list[str] | None,
    typer.Option("--integrator", help=f"{INTEGRATOR}; repeatable.", autocompletion=complete_integrator),
]
Programs = Annotated[
    str | None,
    typer.Option("--command", help="A program that reads problems and writes states, as './mysolver --fast'."),
]

Libraries = Annotated[list[str] | None, typer.Option("--library", help="Only integrators of this library; repeatable.")]
Families = Annotated[
    list[str] | None, typer.Option("--family", help="Only cases of this folder of cases/, as orbits; repeatable.")
]
Kinds = Annotated[
    list[str] | None,
    typer.Option("--kind", help="Only cases that offer, and integrators that accept, this form, as NBody; repeatable."),
]

Equations = Annotated[
    str | None,
    typer.Option(
        help="Your own equations f(t, y, ...), as mine.py:f or package.module:f, in place of cases; with --span and"
        " --start. A reference is computed first."
    ),
]
Span = Annotated[str | None, typer.Option(help="The first and the last time of --equations, as 0,10.")]
Start = Annotated[str | None, typer.Option(help="The start of --equations, as 2,0,0,0.")]
Numbers = Annotated[
    str | None, typer.Option("--parameters", help="The further arguments of --equations, as 9.81,1.5: args in SciPy.")
]
Events = Annotated[
    list[str] | None,
    typer.Option("--event", help="A function of the same file whose zeros are events of --equations; repeatable."),
]
Accelerations = Annotated[
    bool, typer.Option("--accelerations", help="--equations gives accelerations f(t, q, ...); --start has q, then q'.")
]
Error = Annotated[
    float,
    typer.Option("--error", help="The error, relative to the size of the motion, for which a method is recommended."),
]

OUTSTANDING = "Exit with 0 although trials are outstanding: planned, and interrupted or not run yet."
MOST_WORKERS = 256
MOST_MESSAGE = 1600
"""Characters of a message: twenty lines of a terminal, so that the end of a traceback is there."""
DRAWINGS = (".svg", ".png", ".html")
"""Endings of files that a drawing is written to."""
PART = ".part.1234567.123456789012345."
"""A prefix as long as the prefix of the temporary name under which a file is written."""


def as_path(path: str | Path) -> Path:
    """A path of the command line, or a default; wrong usage if no file can have this name."""
    text = str(path)
    if not text.strip():
        raise typer.BadParameter("an empty name; give a path")
    try:
        os.stat(text)
    except FileNotFoundError:
        pass
    except OSError as error:
        if error.errno in (errno.ENAMETOOLONG, errno.ELOOP):
            raise typer.BadParameter(f"{shorten(text)}: {error.strerror}; give another path") from None
    except ValueError as error:  # a zero byte, half a surrogate pair
        raise typer.BadParameter(f"{shorten(text)}: {error}; give another path") from None
    return Path(text)


def path_option(text: str, *names: str) -> Any:
    """An option that is a path; `text` is its help."""
    return typer.Option(*names, help=text, parser=as_path)


ResultsFile = Annotated[Path, typer.Argument(help="A results file or its folder.", parser=as_path)]
Report = Annotated[
    Path | None,
    path_option(
        "A folder for the report of the results: written every 2 minutes between trials (with --dask at the end"
        " only), and at the end or when the run is interrupted."
    ),
]


def choose(
    names: list[str] | None, variants: bool, parameters: list[str] | None, rounded: bool = True
) -> list[tuple[Case, str]]:
    # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
    from gnomon.harness.registry import selection

    for position, name in enumerate(names or ()):
        if name in (names or ())[:position]:
            raise ValueError(f"--case {name}: named twice; name it once")
    values = read_parameters(parameters)
    for reserved in {"variant", "initial_state", "span"} & set(values):
        raise ValueError(f"--set {reserved}: not a parameter; a variant is chosen by case/variant")
    return selection.choose(names, variants, rounded=rounded, **values)


def choose_one(name: str, parameters: list[str] | None = None, rounded: bool = True) -> Case:
    """The only case that a name selects; ValueError if there are several."""
    cases = [case for case, _ in choose([name], False, parameters, rounded)]
    if len(cases) > 1:
        listed = ", ".join(case.id for case in cases[:5])
        raise ValueError(f"{name} names {len(cases)} cases, {listed}{' ...' if len(cases) > 5 else ''}; give one")
    return cases[0]


def one_of(argument: str | None, option: str | None, what: str) -> str | None:
    """The name that is given as an argument or by its option, --case or --integrator; None if neither is."""
    if argument is not None and option is not None:
        raise ValueError(f"--{what} {option}: {argument} is named too; name one {what}")
    return option if argument is None else argument


def one_case(argument: str | None, option: str | None) -> str:
    """The case, or the check, that is given as an argument or by --case."""
    name = one_of(argument, option, "case")
    if name is None:
        raise ValueError("name a case, as pendulum_simple: gnomon list cases has them all")
    return name


def validate_workers(workers: int) -> None:
    if not 1 <= workers <= MOST_WORKERS:
        raise ValueError(f"--workers {shorten(str(workers))}: give a number of processes from 1 to {MOST_WORKERS}")


def ensure_writable(path: Path, option: str) -> None:
    """Make the folder of a file to write; raise ValueError if the file could not be written."""
    if path.is_dir():
        raise ValueError(f"{option} {path} is a folder; name a file in it")
    if path.exists() and not path.is_file():  # it would be replaced
        raise ValueError(f"{option} {path} is a device or a pipe; name a file")
    ensure_folder(path.parent, option, path)


def ensure_drawing(path: Path, option: str) -> None:
    """Raise ValueError if a drawing could not be made or written to this file."""
    if path.suffix not in DRAWINGS:
        raise ValueError(f"{option} {path}: the name must end in one of {', '.join(DRAWINGS)}")
    extras.require("report", option)
    ensure_writable(path, option)


def ensure_folder(folder: Path, option: str, file: Path | None = None) -> None:
    """Make a folder to write to; raise ValueError if `file`, or without it any file, cannot be written there."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        # Permissions are not enough: system folders and full disks refuse files too.
        with tempfile.NamedTemporaryFile(dir=folder, prefix=PART, suffix=f".{file.name}" if file else ""):
            pass
    except OSError as error:
        raise ValueError(
            f"{option} {file or folder}: cannot be written ({error.strerror}); name another place with {option}"
        ) from None


def ensure_results(path: Path) -> None:
    """Raise ValueError if the results of a run could not be written, or if the file holds something else."""
    from gnomon.harness.results import opening

    file = path if path.suffix == ".sqlite" else path / "results.sqlite"
    if file.is_file() and file.stat().st_size:
        with opening.reading(file, ()):
            pass  # raises if the file does not hold results of gnomon
    else:
        ensure_writable(file, "--out")


def read_parameters(parameters: list[str] | None) -> dict[str, str]:
    """The parameters and starts of `--set name=value`, as text."""
    values: dict[str, str] = {}
    for text in (part for each in parameters or () for part in each.split(",")):
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (name and equals and value):
            raise ValueError(f"--set {text!r}: write name=value, as L=2 or L=2,theta=1")
        if name in values:
            raise ValueError(f"--set {name}: given twice, {values[name]} and {value}; give it once")
        values[name] = value
    return values


def integrator_or_program(integrator: str | None, command: str | None) -> tuple[Integrator, str]:
    """The integrator that a command line names, by its name or by --command, and the words that name it."""
    from gnomon.harness.registry import lookup
    from gnomon.harness.verification.function_adapter import from_name
    from gnomon.harness.verification.program_adapter import from_command

    if (integrator is None) == (command is None):
        raise ValueError("name one integrator: package.module:object, an id, a name, or a program with --command")
    if command is not None:
        return from_command(command), f"--command {shlex.quote(command)}"
    assert integrator is not None
    return from_name(integrator) or lookup.find_one(integrator), shlex.quote(integrator)
