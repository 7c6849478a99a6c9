"""The command line. Exit codes: 0 success, 1 failure of a run or a comparison, 2 wrong usage, 130 interrupted."""

import errno
import io
import os
import re
import shlex
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout, suppress
from typing import Annotated, Any

import typer
from gnomon.harness.commands import interruption
from gnomon.harness.commands.baseline import baseline
from gnomon.harness.commands.certify import certify
from gnomon.harness.commands.check import check
from gnomon.harness.commands.compare import compare
from gnomon.harness.commands.doctor import doctor
from gnomon.harness.commands.ensemble import ensemble
from gnomon.harness.commands.exact import exact
from gnomon.harness.commands.export import export
from gnomon.harness.commands.list import list_
from gnomon.harness.commands.merge import merge
from gnomon.harness.commands.options import out, problems
from gnomon.harness.commands.plot import plot
from gnomon.harness.commands.published.engine import engine
from gnomon.harness.commands.published.history import history
from gnomon.harness.commands.published.recommend import recommend
from gnomon.harness.commands.report import report
from gnomon.harness.commands.run import run
from gnomon.harness.commands.scene import scene
from gnomon.harness.commands.show import show
from gnomon.harness.commands.stability import stability
from gnomon.harness.commands.verify import verify
from gnomon.harness.results.visible import visible
from gnomon.harness.system.child_process import ServerFailed
from gnomon.harness.system.streams import open_standard_streams
from gnomon.reference.storage.version import VERSION
from rich.markup import escape

app = typer.Typer(
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    help="Compares integrators with exact motions of classical mechanics, in error and in speed.",
)


def _version(asked: bool) -> None:
    if asked:
        out.print(f"gnomon {VERSION}", highlight=False)
        raise typer.Exit


@app.callback()
def gnomon(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    pass


app.command("list")(list_)
for command in (
    *(
        show,
        exact,
        check,
        scene,
        run,
        merge,
        ensemble,
        report,
        plot,
        recommend,
        engine,
        compare,
        verify,
        stability,
        certify,
        export,
        history,
        doctor,
    ),
):
    app.command()(command)
app.add_typer(baseline, name="baseline")

USAGE: Any = typer.BadParameter.__mro__[1]
"""The exception for wrong usage; releases of Typer keep it in different modules."""

ONE_THREAD = ("OPENBLAS_NUM_THREADS", "1")
"""Set before numpy is loaded, unless the user has set it: with two threads `scipy.linalg.expm` of a matrix of 6 by 6 takes
3.6 ms of processor time instead of 0.02 ms, and a run has a worker on each processor anyway."""
UNREAD = 141
"""The exit code if the program that reads the output ends first (`gnomon list | head`), as in a shell for SIGPIPE."""
ASKED = "_GNOMON_COMPLETE"
COMPLETION = {ASKED, "--show-completion", "--install-completion"}
"""Signs of a request for the completion of the shell: an environment variable, or the first word."""
LINE = "_TYPER_COMPLETE_ARGS"
"""The environment variable in which zsh and fish send the line to the cursor."""
FORMER = "--to"
"""What --out was called in some commands: its error names --out."""
FULL = (errno.ENOSPC, errno.EDQUOT)
WRITING = (*FULL, errno.EACCES, errno.EROFS, errno.ENOENT, errno.EEXIST, errno.ENOTDIR, errno.EISDIR)


def main() -> None:
    """Run the command line. Wrong usage prints one line, not a traceback, and exits with 2; Ctrl-C exits with 130."""
    open_standard_streams()
    os.environ.setdefault(*ONE_THREAD)
    sys.path.append(os.getcwd())  # a user's module:Class is imported from the working directory
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")  # not every output is UTF-8
    warnings.showwarning = _warning
    with interruption.acknowledge() as asked:
        code = _exit_code()
        sys.exit(interruption.INTERRUPTED if asked.is_set() else code)


def _exit_code() -> int:
    """The exit code of the command, or UNREAD if the program that reads its output ended first."""
    try:
        code = _run()
        sys.stdout.flush()  # Python's own flush at the end would print its failure
        return code
    except BrokenPipeError:
        pass
    except SystemExit as end:  # Rich and Typer make one of a BrokenPipeError
        if not _is_unread(end):
            raise
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # discards buffered text
    return UNREAD


def _is_unread(end: SystemExit) -> bool:
    return isinstance(end.__context__, BrokenPipeError)


@contextmanager
def _whole_words() -> Iterator[None]:
    """Ask for the completion of a whole word, and print the text that the shell is to insert.

    Bash divides a word at its colons, as an id has one, and replaces the text after the last colon. It reads a space or a
    bracket of an id as its own, unless a backslash is before it or the word is in quotes. Zsh and fish send the whole line
    and quote the answer themselves, but replace the whole word, also before the sign in `--case=kepler`.
    """
    shell = os.environ.get(ASKED, "").removeprefix("complete_")
    if shell == "bash":
        fit = _join_words()
    elif shell in ("zsh", "fish") and LINE in os.environ:
        fit = _close_word(shell)
    else:
        yield
        return
    answer = io.StringIO()
    try:
        with redirect_stdout(answer):
            yield
    finally:
        for word in answer.getvalue().splitlines():
            print(fit(word))


def _join_words() -> Callable[[str], str]:
    """Join the words of bash in its variables; the function gives the part of an answer that readline inserts."""
    words, place = os.environ["COMP_WORDS"].split("\n"), int(os.environ["COMP_CWORD"])
    whole: list[str] = []
    for number, word in enumerate(words[: place + 1]):
        joins = number > 1 and (word.startswith(":") or words[number - 1].endswith(":"))
        whole[-1:] = [whole[-1] + word] if joins else [*whole[-1:], word]
    if whole[-2:-1] == ["="]:  # between an option and its value
        del whole[-2]
    os.environ |= {"COMP_WORDS": "\n".join(whole), "COMP_CWORD": str(len(whole) - 1)}
    fixed, quoted = whole[-1].rfind(":") + 1, whole[-1][:1] in ("'", '"')
    return lambda word: word if quoted else re.sub(r"([^\w.:/%+=@,-])", r"\\\1", word[fixed:])


def _close_word(shell: str) -> Callable[[str], str]:
    """Close the last word of LINE; the function gives the line of an answer with the `--option=` of this word.

    Typer takes each last space for the end of a word, and ids have spaces: a quote after the space keeps it in the word.
    """
    line, option = os.environ[LINE], ""
    for end in ("'", '"', "''"):
        with suppress(ValueError):  # the quote opens a word, or another quote is open
            last = shlex.split(line + end)[-1]
            os.environ[LINE] = line + end if line.endswith(" ") else line
            option = last[: last.find("=") + 1] if last.startswith("--") else ""
            break
    if shell == "fish":
        return lambda word: option + word
    return lambda word: re.sub(r'^(_arguments .*?\(\()?"', lambda found: found[0] + option, word)


def _run() -> int:
    code = 2
    try:
        with _whole_words():
            return int(app(prog_name="gnomon", standalone_mode=False) or 0)
    except SystemExit as end:
        if _is_unread(end):
            raise
        if COMPLETION & {*os.environ, *sys.argv[1:2]}:  # Typer ends with this exception
            return int(end.code or 0)
        # Raised by imported code: Typer returns its other exit codes.
        text = f"SystemExit: code that was imported or called ended with sys.exit({end.code!r}); there is no result"
    except (ValueError, OSError, ArithmeticError) as error:
        text = f"{type(error).__name__}: {error}" if isinstance(error, ArithmeticError) else str(error)
        if isinstance(error, OSError) and error.errno in WRITING:
            way_out = "free some space or name" if error.errno in FULL else "name"
            text = f"{error.filename or 'the disk'}: {error.strerror}; {way_out} another place to write to"
    except ServerFailed as error:
        text, code = str(error), 1
    except (KeyboardInterrupt, typer.Abort):
        return interruption.INTERRUPTED
    except USAGE as error:
        if len(sys.argv) == 1:
            error.show()  # `gnomon` alone: its help
            return 2
        message = error.format_message().replace("Value error, ", "")  # a prefix that a library adds
        if getattr(error, "option_name", None) == FORMER:
            message = f"{FORMER} is no option: results go to --out"
        text = f"{message} (see {error.ctx.command_path if error.ctx else 'gnomon'} --help)"
    problems.print(f"[bold red]error:[/] {escape(_line(text))}")
    return code


def _line(text: str) -> str:
    """The text on one line, without control characters for a terminal."""
    return visible(" ".join(text.split()))


def _warning(message: Warning | str, *_: Any, **__: Any) -> None:
    """Print a warning on one line, without the source line that gave it."""
    problems.print(f"[bold yellow]warning:[/] {escape(_line(str(message)))}", highlight=False)
