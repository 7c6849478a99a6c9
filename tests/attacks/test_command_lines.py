"""Command lines that are wrong, or end the programs that they call: one line that names the mistake, and its exit code.

They do no work, except for the probe of an ensemble: measuring, certifying and rendering are replaced by failures.
"""

import json
import os
import random
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from command_line import gnomon
from gnomon.harness.certification import certify_all
from gnomon.harness.reporting import images
from gnomon.harness.running import planned_run

sys.path.insert(0, str(Path(__file__).parent.parent / "harness"))

import synthetic

Line = tuple[list[str], int, tuple[str, ...]]
"""The arguments, the exit code, and words of the one line that names the mistake (exit code 0: no line)."""

LONG = "a" * 300
ZERO = "a\0b.sqlite"
HALF = "a\ud800.sqlite"
PENDULUM = ("--case", "pendulum_simple")
RK4 = (*PENDULUM, "--integrator", "gnomon:RK4")

RAISES = "from planted import Sound\n\nclass Thing(Sound):\n    def __init__(self): raise {}\n"
MODULES = {
    "exits": "import sys\nsys.exit(0)",
    "exits_with_text": "import sys\nsys.exit('all is well')",
    "interrupts": "raise KeyboardInterrupt",
    "raises": "raise RuntimeError('boom\\nand more \\x1b[31m')",
    "stops": "raise StopIteration",
    "unwritten": "def f(:",
    "imports": "import no_such_library",
    "empty": "",
    "wrong": "class Thing: pass",
    "undeclared": "from gnomon.harness.contract.integrator import Integrator\n\nclass Thing(Integrator): name = 'x'",
    "ends_when_made": RAISES.format("SystemExit(0)"),
    "interrupts_when_made": RAISES.format("KeyboardInterrupt"),
}
"""Modules in the folder where the commands run, by their source."""


def options() -> Iterator[Line]:
    for command in ("run", "show", "report", "plot", "compare", "certify", "export", "list", "doctor"):
        yield [command, "--no-such-option"], 2, ("--no-such-option", f"gnomon {command} --help")
        yield [command, "--help"], 0, ()
    yield ["no_such_command"], 2, ("no_such_command", "gnomon --help")
    yield [""], 2, ("No such command",)
    yield ["list", "planets"], 2, ("planets", "cases", "checks", "integrators")
    yield ["list", "cases", "checks"], 2, ("checks",)
    yield ["export"], 2, ("name a results file", "--schema")
    for command in ("report", "plot"):
        yield [command], 2, ("Missing argument", f"gnomon {command} --help")
    for command in ("show", "exact"):
        yield [command], 2, ("name a case",)
        yield [command, "pendulum_simple", "--case", "kepler_orbit"], 2, ("kepler_orbit", "pendulum_simple", "one case")
        yield [command, "kepler_orbit/e*"], 2, ("kepler_orbit/e*", "give one")
    yield ["verify", "RK4", "--integrator", "DOP853"], 2, ("DOP853", "RK4", "one integrator")
    yield ["compare", "results.sqlite"], 2, ("Missing argument",)
    for limit in ("0", "-1", "-0.0", "1e-320", "1e308", "1e400", "inf", "-inf", "nan", "1e-7", "1e7"):
        yield ["run", *RK4, "--limit", limit], 2, ("--limit", "positive number of seconds", "1e-06", "1e+06")
    for limit in ("", "fast", "1,5", "0x10", "1e", "\u221e"):
        yield ["run", *RK4, "--limit", limit], 2, ("--limit",)
    for workers in ("0", "-1", "257", "1" + "0" * 23):
        yield ["run", *RK4, "--workers", workers], 2, (f"--workers {workers}", "from 1 to 256")
        yield ["certify", "projectile_parabola", "--workers", workers], 2, (f"--workers {workers}", "from 1 to 256")
    for workers in ("", "two", "1.5", "9" * 5000):
        yield ["run", *RK4, "--workers", workers], 2, ("--workers",)
    for settings in ("", "x", "nan", "-1", "0", "1e-6,", "order=3", "tolerance=1e-6", "=1", "inf", "1e-6 1e-9"):
        yield ["run", *RK4, "--settings", settings], 2, ("settings",)
    for suite in ("", "slow", "STANDARD", "standard ", "../standard"):
        yield ["run", "--suite", suite], 2, ("no suite is called", "standard")
        yield ["certify", "--suite", suite], 2, ("no suite is called", "standard")
    yield ["certify", "projectile_parabola", "--suite", "quick"], 2, ("--suite quick", "not both")
    for form in ("", "xls", "CSV"):
        yield ["export", "results.sqlite", "--format", form], 2, ("csv", "json", "parquet")


def names() -> Iterator[Line]:
    for case in ("", " ", "pendulum_simpel", "Pendulum", "../pendulum_simple", "pendulum_simple\n", LONG, "\u03c0"):
        yield ["run", "--case", case, "--integrator", "gnomon:RK4"], 2, ("no case is named",)
        yield ["show", case], 2, ("no case is named",)
    yield ["run", "--case", "pendulum_simple/separatrx", "--integrator", "gnomon:RK4"], 2, ("separatrx", "separatrix")
    yield ["show", "pendulum_simple/"], 2, ("pendulum_simple", "variant")
    yield ["certify", "pendulum_simple/wrong"], 2, ("no variant 'wrong'",)
    yield ["certify", ""], 2, ("no case is named",)
    yield ["run", *RK4, *PENDULUM], 2, ("--case pendulum_simple", "twice")
    yield ["run", "--case", "moment_equipollent"], 2, ("is a check", "gnomon certify moment_equipollent")
    yield ["show", "moment_equipollent", "--plot", "a.svg"], 2, ("is a check", "nothing to draw")
    for integrator in ("", " ", "RK44", "rk4;", LONG, "gnomon:", "\u03c0"):
        yield ["run", *PENDULUM, "--integrator", integrator], 2, ("no integrator is called",)
    for integrator in (":", ":X:", "no_such_module:Thing", "os:path", "a b:c"):
        yield ["run", *PENDULUM, "--integrator", integrator], 2, (integrator, "give package.module:Class")
    ended = {"exits": "SystemExit: 0", "interrupts": "KeyboardInterrupt", "raises": "RuntimeError: boom and more"}
    of_integrators = {
        "exits_with_text": "SystemExit: all is well", "stops": "StopIteration", "unwritten": "SyntaxError",
        "imports": "no_such_library", "empty": "AttributeError", "wrong": "wrong", "undeclared": "abstract",
        "ends_when_made": "SystemExit: 0", "interrupts_when_made": "KeyboardInterrupt",
    }  # fmt: skip
    for module, words in (ended | of_integrators).items():
        yield ["run", *PENDULUM, "--integrator", f"{module}:Thing"], 2, (f"{module}:Thing", words)
    for module, words in (ended | {"wrong": "is not a subclass of gnomon.cases.Case"}).items():
        for command in (["run", "--case"], ["show"], ["certify"], ["report", "results.sqlite", "--case"]):
            yield [*command, f"{module}:Thing"], 2, (f"{module}:Thing", words)


def numbers() -> Iterator[Line]:
    for text in ("", "g", "=", "=9.81", "g=", " = "):
        yield ["show", "pendulum_simple", "--set", text], 2, (repr(text), "write name=value")
    yield ["show", "pendulum_simple", "--set", "g=1", "--set", "g=2"], 2, ("--set g", "twice", "1 and 2")
    yield ["run", *RK4, "--set", "g=1", "--set", " g = 1"], 2, ("--set g", "twice")
    for reserved in ("variant=long", "initial_state=1", "span=3"):
        name = reserved.partition("=")[0]
        yield ["show", "pendulum_simple", "--set", reserved], 2, (f"--set {name}", "not a parameter")
    yield ["show", "pendulum_simple", "--set", "length=1"], 2, ("no parameter 'length'",)
    outside, malformed = (
        ("-1", "0", "nan", "inf", "1e400", "1e100000000", "1e-400", "1/0"),
        ("ten", "1j", "True", "0x1p3"),
    )
    for value in (*outside, *malformed, "1__0"):
        yield ["show", "pendulum_simple", "--set", f"g={value}"], 2, ("pendulum_simple", "g = ")
    yield ["show", "pendulum_simple", "--set", "g=" + "9" * 5000], 2, ("pendulum_simple", "g = ")


def paths() -> Iterator[Line]:
    reading = (["report"], ["plot"], ["export"], ["compare", "results.sqlite"])
    for path, words in (
        *(("", "empty name"), (" ", "empty name"), (LONG, "File name too long"), (ZERO, "embedded null")),
        *((HALF, "surrogate"), ("loop.sqlite", "loop.sqlite")),
    ):
        for command in (*reading, ["run", *RK4, "--out"]):
            yield [*command, path], 2, (words,)
        yield ["certify", "projectile_parabola", "--out", path], 2, (words,)
    odd = ("notes.txt", "notes.sqlite", "folder.sqlite", "pipe.sqlite", "/dev/null")
    for path in (*odd, "no_such_folder", "empty.sqlite"):
        for command in reading:
            yield [*command, path], 2, (path,)
    for path in odd:
        yield ["run", *RK4, "--out", path], 2, (path,)
    for path in ("folder", "pipe.sqlite", "/dev/null", "notes.txt/a.json"):
        yield ["certify", "projectile_parabola", "--out", path], 2, (f"--out {path}",)
        yield ["certify", "projectile_parabola", "--independent", path], 2, (f"--independent {path}",)
        yield ["export", "results.sqlite", "--out", path], 2, (f"--out {path}",)
    yield ["certify", "projectile_parabola", "--out", "a.json", "--independent", "a.json"], 2, ("--independent a.json",)
    yield ["export", "results.sqlite", "--out", "results.sqlite"], 2, ("--out results.sqlite", "these are the results")
    for path in ("notes.txt", "/dev/null", "notes.txt/page"):
        yield ["report", "results.sqlite", "--out", path], 2, (f"--out {path}",)
    yield ["export", "results.sqlite", "--to", "a.csv"], 2, ("--out",)  # as it was called once
    for path in ("motion.docx", "motion", ".svg/"):
        yield ["show", "pendulum_simple", "--plot", path], 2, ("the name must end in one of .svg, .png",)
    yield ["show", "pendulum_simple", "--plot", "drawing.svg"], 2, ("--plot drawing.svg is a folder",)
    yield ["show", "pendulum_simple", "--plot", "notes.txt/a.svg"], 2, ("--plot notes.txt/a.svg",)
    if Path("/proc").is_dir():  # nobody can write there, and permissions say that root could
        for command, option, name in (
            *((["certify", "projectile_parabola"], "--out", "a.json"), (["run", *RK4], "--out", "a.sqlite")),
            *((["export", "results.sqlite"], "--out", "a.csv"), (["report", "results.sqlite"], "--out", "page")),
            (["show", "pendulum_simple"], "--plot", "a.svg"),
        ):
            yield [*command, option, f"/proc/{name}"], 2, (f"{option} /proc/{name}", "cannot be written")


VERIFY = ("verify", "planted_methods:good_rk4")
WRONG_VERIFY = {
    ("--claim", "time"): "--claim time needs the other version",
    ("--against", "-r x"): "give a requirement as mypackage==1.2",
    ("--claim", "order", "--picture", "a.svg"): "give one --case and one --claim",
    (*PENDULUM, "--claim", "order", "--claim", "runs", "--picture", "a.svg"): "give one --case and one --claim",
    (*PENDULUM, "--claim", "order", "--picture", "a.txt"): "must end in one of .svg, .png, .html",
    ("--depth", "deep"): "deep",
    ("--claim", "ordr"): "ordr",
    ("--max-seconds", "0"): "--max-seconds",
    ("--case", "pendulm"): "pendulm",
}
WRONG_EXACT = {
    ("--times", "1,two"): "'two' is not a number",
    ("--times", "no_such_file.txt"): "no file has this name",
    ("--times=-1,2",): "the motion starts at 0",
    ("--times", "nan"): "not finite",
    ("--times", "0xg"): "hexadecimal digits",
    ("--times", ","): "no times",
    ("--digits", "0"): "from 1 to 1000",
    ("--set", "mass=1"): "no parameter 'mass'",
    ("--set", "L=-1"): "outside",
    ("--times", "1e299"): "1,000,000 time scales",
}
ENSEMBLE = ("ensemble", *PENDULUM, "--integrator", "planted_ensembles:Fails", "--samples", "64")
WRONG_ENSEMBLE = {
    ("--samples", "0"): "--samples 0: give a whole number from 1 to 2**30",
    ("--samples", "-4"): "give a whole number",
    ("--samples", "2**31"): "give a whole number",
    ("--samples", "many"): "--samples many",
    ("--seed", "-1"): "--seed -1: give a number from 0",
    ("--times", "0"): "--times 0",
    ("--worst", "-1"): "--worst -1",
    ("--workers", "0"): "--workers 0",
    ("--vary", "thet"): "did you mean theta",
    ("--vary", "L", "--set", "L=2"): "--set L: it varies",
    ("--map", "theta", "omega"): "--map: the map is a picture beside --out",
    ("--map", "theta", "L", "--out", "a.json"): "--map L: it does not vary",
    ("--out", "a.png"): "end it in .json",
    ("--parquet", "."): "holds files already",
    ("--setting", "0"): "--setting 0.0: give a positive number",
    ("--case", "pendulum_simpel"): "did you mean pendulum_simple",
    ("--case", "bouncing_ball"): "has no form SecondOrder",
    ("--integrator", "RK44"): "did you mean RK4",
    ("--integrator", "planted_ensembles:EndsAlways"): "ended its process in the first 32 samples",
}


def common() -> Iterator[Line]:
    """Mistakes that are often made, each with its remedy."""
    folder, pipe = "is a folder; name a file in it", "is a device or a pipe; name a file"
    for arguments, word in (
        (["show", "pendulum_simpel"], "no case is named 'pendulum_simpel'; did you mean pendulum_simple"),
        (["show", "pendulum_simple/separatrx"], "has no variant 'separatrx'; did you mean separatrix"),
        (["show", "pendulum_simple", "--set", "g=-1"], "g = -1 is outside (0, inf)"),
        (["show", "pendulum_simple", "--set", "g=nan"], "g = nan is not finite"),
        (["show", "pendulum_simple", "--set", "g=1e400"], "g = 1e400 (about) is too large"),
        (["show", "euler_top", "--set", "I3=50"], "the triangle inequality"),
        (["show", "pendulum_simple", "--set", "length=1"], "has no parameter 'length'"),
        (["show", "pendulum_simple", "--set", "g"], "write name=value"),
        (["show", "pendulum_simple", "--plot", "motion.docx"], "motion.docx: the name must end in one of .svg, .png"),
        (["export"], "name a results file"),
        (["export", "results.sqlite", "--format", "xls"], "is not one of 'csv', 'json', 'parquet'"),
        (["run", "--case", "pendulum_simple", "--integrator", "RK44"], "did you mean RK4 or RK45"),
        (["run", "--integrator", "no_such_module:Thing"], "give package.module:Class"),
        (["run", "--integrator", "folder/my_method.py:step"], "give the module and not its file: my_method:step"),
        (["run", "--integrator", "planted:SUITE"], "give package.module:Class"),
        (["run", "--integrator", ":X:"], ":X:: ValueError: Empty module name"),
        (["run", "--case", "moment_equipollent"], "is a check, without motion: `gnomon certify moment_equipollent`"),
        (["run", "--workers", "0"], "--workers 0: give a number of processes from 1 to"),
        (["run", "--no-such-option"], "No such option: --no-such-option (see gnomon run --help)"),
        (["no_such_command"], "No such command 'no_such_command'. (see gnomon --help)"),
        (["run", "--suite", "slow"], "no suite is called 'slow'"),
        (["run", "--suite", "standart"], "did you mean standard"),
        (["run", "--limit", "-1", "--case", "pendulum_simple"], "a trial needs a positive number of seconds"),
        *(([*command, "no_such_folder"], "no results here") for command in (["report"], ["export"])),
        (["compare", "no_such_folder", "no_such_folder"], "no results here"),
        (["run", "--case", "keppler*"], "nothing matches 'keppler*'; did you mean kepler_orbit"),
        (["run", "--case", "kepler*", "--family", "contact"], "--family contact"),
        (["run", "--integrator", "gnomon:RK4", "--library", "scipy"], "--library scipy"),
        (["list", "--family", "orbit"], "--family orbit: no integrator that is named has it; did you mean orbits"),
        (["list", "--library", "spicy"], "did you mean scipy?"),
        (["list", "--kind", "hybird"], "did you mean Hybrid"),
        (["list", "integrators", "spicy*"], "nothing matches 'spicy*'"),
        (["list", "kepler*"], "is not one of 'cases', 'checks', 'integrators'"),
        (["list", "cases", "--library", "scipy"], "cases: --family narrows cases, --library integrators"),
        (["list", "checks", "--kind", "Hybrid"], "checks: --family narrows cases"),
        (["stability", "--panel", "linaer"], "no panel is called 'linaer'; did you mean linear"),
        (["stability", "--integrator", "RK44"], "did you mean RK4 or RK45"),
        (["stability", "--depth", "deep"], "no depth is called 'deep'"),
        (["stability", "--workers", "0"], "--workers 0: give a number of processes from 1 to"),
        (["stability", "--out", "folder"], f"--out folder {folder}"),
        (["certify", "projectile_parabola", "--out", "folder"], f"--out folder {folder}"),
        (["certify", "projectile_parabola", "--out", "/dev/null"], f"--out /dev/null {pipe}"),
        (["run", *RK4, "--out", "notes.txt"], "results.sqlite: cannot be written (File exists); name another place"),
        (["run", *RK4, "--integrator", "raises:Thing"], "raises:Thing: RuntimeError: boom"),
        (["run", *RK4, "--integrator", "unwritten:Thing"], "unwritten:Thing: SyntaxError: "),
        (["run", *RK4, "--integrator", "imports:Thing"], "ModuleNotFoundError: No module named 'no_such_library'"),
        (["run", *RK4, "--integrator", "undeclared:Thing"], "abstract"),
        (["run", *RK4, "--integrator", "wrong:Thing"], "is not a gnomon.Integrator"),
        (["run", *PENDULUM, "--command", "no_such_program_anywhere -x"], "no program has this name"),
        (["run", *PENDULUM, "--command", "'unclosed"], "quotation"),
        (["run", *PENDULUM, "--command", ""], "no program"),
        (["verify", "--command", "sh", "--against", "paced==1.0"], "a program of --command has none"),
        *(([*VERIFY, *wrong], word) for wrong, word in WRONG_VERIFY.items()),
        *((["exact", "pendulum_simple", *wrong], word) for wrong, word in WRONG_EXACT.items()),
        *(([*ENSEMBLE, *wrong], word) for wrong, word in WRONG_ENSEMBLE.items()),
        (["exact", "pendulum_simpel"], "did you mean"),
        *(
            (["run", "--case", "pendulum_simple", "--shard", shard], f"--shard {shard}: write k/n")
            for shard in ("0/3", "4/3", "3", "1/0", "-1/2", "1/2/3", "one/two", "1/99999999")
        ),
    ):
        yield arguments, 2, (word,)


COMMON = list(common())
LINES = list({json.dumps(line[0]): line for line in (*options(), *names(), *numbers(), *paths(), *COMMON)}.values())
CHOSEN = [*COMMON, *random.Random(17).sample(LINES, len(LINES) // 10)]
"""Common mistakes and a tenth of all lines run in `make test`."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder in which the commands run: results, modules, and files with contents of another kind than their name."""
    made = tmp_path_factory.mktemp("commands")
    synthetic.write(made / "results.sqlite")
    (made / "notes.txt").write_text("mine")
    (made / "notes.sqlite").write_text("no database, though it is as long as the header of one would have to be" * 5)
    (made / "empty.sqlite").touch()
    for name in ("folder", "folder.sqlite", "drawing.svg"):
        (made / name).mkdir()
    os.mkfifo(made / "pipe.sqlite")
    (made / "loop.sqlite").symlink_to(made / "loop.sqlite")
    for name, source in MODULES.items():
        (made / f"{name}.py").write_text(source)
    return made


@pytest.fixture
def at(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working directory is that folder, and functions that start the work of a command raise."""

    def works(*_: Any, **__: Any) -> Any:
        raise AssertionError("this is work: the command line is wrong, and should have been refused before")

    monkeypatch.chdir(folder)
    monkeypatch.syspath_prepend(folder)
    for module, name in ((planned_run, "run"), (certify_all, "certificates"), (images, "write_images")):
        monkeypatch.setattr(module, name, works)
    for name in MODULES:
        monkeypatch.delitem(sys.modules, name, raising=False)
    return folder


def _named(line: Line) -> str:
    return json.dumps(" ".join(line[0]))[:60]


@pytest.mark.parametrize(
    "line", [line if line in CHOSEN else pytest.param(line, marks=pytest.mark.slow) for line in LINES], ids=_named
)
def test_a_command_line(line: Line, at: Path, capfd: pytest.CaptureFixture[str]) -> None:
    arguments, code, words = line
    before = list_files(at)
    assert gnomon(*arguments) == code
    captured = capfd.readouterr()
    if code == 0:
        assert captured.err == ""
        return
    assert captured.out == ""
    (told,) = captured.err.splitlines()
    assert told.startswith("error: ")
    assert told.isprintable()
    for word in words:
        assert word in told
    assert list_files(at) == before, "a refused command leaves nothing behind"


def list_files(folder: Path) -> list[str]:
    """The files in a folder and its subfolders, without those that Python and SQLite write beside files that they read."""
    names = (str(path.relative_to(folder)) for path in folder.rglob("*"))
    return sorted(name for name in names if not name.startswith(("__pycache__", "results.sqlite-")))


def test_there_are_enough_of_them() -> None:
    assert len(LINES) >= 150
