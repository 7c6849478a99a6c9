"""The parts of a publication: what each measures, with which commands, how long it takes, and which are done.

All parts of one hash of the sources and one machine lie in one folder of runs/publication/. A part is done if its record
is there, which is written when its commands have ended and its file is whole.
"""

import json
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from gnomon.harness.registry import environment, lookup
from gnomon.harness.reporting.publication import whole
from gnomon.harness.results import study_file

RESULTS = "results.sqlite"
INTERRUPTED = 130
"""The exit code of a command that was interrupted, and goes on when it is called again."""
ENDING_SECONDS = 900.0
"""Seconds after which an interrupted command is killed: a part of `make verification` may take so long."""
MUTANTS = 60
"""Mutants that are drawn with the published seed: all of them would take hours."""
LAUNCHES = range(1, 6)
PROGRAMS = {
    "gnomon": ["-c", "from gnomon.harness.commands.cli import main; main()"],
    "python": [],
    "pytest": ["-m", "pytest"],
}


@dataclass(frozen=True)
class Part:
    """A part: `commands` write `file` and, `beside` it, other files. {} stands for the folder.

    `minutes`: predicted, on two cores. `resumes`: whether an interrupted command goes on when it is called again; the
    others begin anew. `codes`: the exit codes with which a file can be whole.
    """

    name: str
    file: str
    minutes: float
    commands: tuple[str, ...]
    beside: tuple[str, ...] = ()
    resumes: bool = False
    codes: frozenset[int] = frozenset({0})

    @property
    def files(self) -> tuple[str, ...]:
        return (self.file, *self.beside)


SPOILED = frozenset({0, 1})
"""Also the code of a command whose file says what is not as it should be."""
_MEASURE = (
    f"python tests/detection/measure.py --draw {MUTANTS} --rows {{}}/verification.jsonl --out {{}}/verification.json"
)
PARTS = (
    Part("foundation", RESULTS, 37, (f"gnomon run --suite foundation --out {{}}/{RESULTS}",), (), True, SPOILED),
    Part("hard", RESULTS, 20, (f"gnomon run --suite hard --out {{}}/{RESULTS}",), (), True, SPOILED),
    Part("full", RESULTS, 37, (f"gnomon run --suite {whole.SUITE} --out {{}}/{RESULTS}",), (), True, SPOILED),
    Part(
        "certificates", "certificates.json", 17,
        ("gnomon certify --all --out {}/certificates.json --independent {}/checks.json",), ("checks.json",), False, SPOILED,
    ),
    Part(
        "benchmarks", "benchmarks.json", 18,
        (
            *(f"pytest tests/benchmarks/test_pairs.py -q --benchmark-only --benchmark-json={{}}/launch_{k}.json" for k in LAUNCHES),
            f"python -m gnomon.harness.studies.benchmarks {' '.join(f'{{}}/launch_{k}.json' for k in LAUNCHES)} --out {{}}/benchmarks.json",
        ),
    ),
    Part("orders", "orders.json", 5, ("python -m gnomon.harness.studies.orders --out {}/orders.json",)),
    Part("growth", "growth.json", 8, ("python -m gnomon.harness.studies.growth --out {}/growth.json",)),
    Part(
        "engines", "engines.json", 20,
        (
            "gnomon run --suite engines --out {}/engines.sqlite",
            "python -m gnomon.harness.studies.league {}/engines.sqlite --out {}/engines.json",
        ),
        (), True, SPOILED,
    ),
    Part(
        "stability_long", "stability.json", 33,
        ("gnomon stability --depth high --panel long_time --out {}/stability.json",), (), True,
    ),
    Part("stability", "stability.json", 43, ("gnomon stability --depth high --out {}/stability.json",), (), True),
    Part(
        "outside", "outside.json", 22,
        (
            "python -m gnomon.harness.own_systems.outside --out {}/outside.sqlite",
            f"python -m gnomon.harness.own_systems.outside --out {{}}/outside.sqlite --judge {{}}/{RESULTS} --to {{}}/outside.json",
        ),
        (), True,
    ),
    Part("verification_right", "verification.json", 75, (f"{_MEASURE} --only right",), (), True, SPOILED),
    Part("verification", "verification.json", 25, (_MEASURE,), (), True, SPOILED),
)  # fmt: skip
"""In the sequence in which they are measured. Several parts of one file continue it."""


@dataclass(frozen=True)
class State:
    """Whether a part is done, and by which sources (`by`, an environment).

    `minutes`: predicted of what is left, as the last older publication took them; `took`: of its sittings so far.
    """

    part: Part
    word: str
    minutes: float
    by: Mapping[str, str] = field(default_factory=dict)
    took: float | None = None


@dataclass(frozen=True)
class Place:
    """The folders of all publications, of which one belongs to these sources on this machine."""

    root: Path = Path("runs/publication")
    parts: Sequence[Part] = PARTS

    @property
    def folder(self) -> Path:
        return self.root / f"{environment.sources()}-{environment.machine()}"

    @property
    def files(self) -> dict[str, list[Part]]:
        """The parts that make each file."""
        names = dict.fromkeys(name for part in self.parts for name in part.files)
        return {name: [part for part in self.parts if name in part.files] for name in names}

    def part(self, name: str) -> Part:
        """The part of this name. Raises ValueError for another name."""
        by_name = {part.name: part for part in self.parts}
        if name not in by_name:
            raise ValueError(f"--part {name}: no part is called so; the parts are {', '.join(by_name)}")
        return by_name[name]

    def others(self) -> list[Path]:
        """The folders of other sources or machines, the last one first."""
        folders = [folder for folder in self.root.glob("*-*") if folder != self.folder and folder.is_dir()]
        return sorted(folders, key=lambda folder: folder.stat().st_mtime, reverse=True)

    def record(self, part: Part, folder: Path | None = None) -> dict[str, Any] | None:
        """What was recorded when a part was done in a folder, by default the present one; None if it is not done."""
        record = self._read(part, folder or self.folder)
        return record if record and record["done"] else None

    def spent(self, part: Part) -> float | None:
        """The seconds of all sittings of a part in the present folder; None without one."""
        record = self._read(part, self.folder)
        return float(record["seconds"]) if record else None

    def add(self, part: Part, seconds: float, is_done: bool) -> None:
        """Record one more sitting of a part, and whether the part is done."""
        record = {"environment": environment.record(), "installed": environment.list_installed(), "done": is_done}
        record |= {"seconds": round((self.spent(part) or 0.0) + seconds)}
        record |= {"commands": [line(command, self.folder) for command in part.commands]}
        study_file.write(record, self._path(part, self.folder))

    def _path(self, part: Part, folder: Path) -> Path:
        return folder / "done" / f"{part.name}.json"

    def _read(self, part: Part, folder: Path) -> dict[str, Any] | None:
        path = self._path(part, folder)
        try:
            return dict(json.loads(path.read_text(encoding="utf-8"))) if path.is_file() else None
        except ValueError:
            raise ValueError(f"{path}: no record of a part; remove it, and the part is measured again") from None

    def states(self) -> Iterator[State]:
        """The state of each part: done, begun, of other sources or another machine (older), or missing."""
        for part in self.parts:
            finished, spent = self.record(part), self.spent(part)
            older = next(filter(None, (self.record(part, folder) for folder in self.others())), None)
            known = older["seconds"] / 60 if older else part.minutes
            if finished is not None:
                yield State(part, "done", known, finished["environment"], finished["seconds"] / 60)
            elif spent is not None:
                yield State(part, "begun", max(0.0, known - spent / 60), {}, spent / 60)
            else:
                yield State(part, "older" if older else "missing", known, older["environment"] if older else {})


def line(command: str, folder: Path) -> str:
    return command.replace("{}", str(folder))


def arguments(command: str, folder: Path) -> list[str]:
    """A command as a process takes it: its first word is one of PROGRAMS."""
    program, *words = shlex.split(command)
    return [sys.executable, *PROGRAMS[program], *(line(word, folder) for word in words)]


def ready() -> None:
    """Raise ValueError if what is measured could not be published: sources without a revision, a library that lacks."""
    revision = environment.describe().get("revision", "")
    if not revision.isalnum():
        raise ValueError(
            f"revision {revision or 'unknown'}: commit the sources first; a published file names its revision"
        )
    missing = sorted({method.library for method in lookup.everything().values() if lookup.missing(method) is not None})
    if missing:
        raise ValueError(
            f"{', '.join(missing)}: not installed, but a publication compares all libraries of the README;"
            " call `make publication` in a checkout with Python 3.11"
        )


def measure(part: Part, place: Place, ends: float | None = None) -> bool:
    """Run the commands of a part until it is done; return whether it is. `ends`: the time of `time.monotonic` to stop at.

    A launch of benchmarks that has been written is not repeated. Raises ValueError if a command fails or its file is not
    whole, and KeyboardInterrupt once the command that runs has ended.
    """
    ready()
    place.folder.mkdir(parents=True, exist_ok=True)
    began, is_done = time.monotonic(), False
    try:
        is_done = all(_succeeds(part, command, place.folder, ends) for command in part.commands)
        if is_done:
            try:
                whole.require(place.folder, part.name, part.files)
            except ValueError:
                is_done = False
                raise
    finally:
        place.add(part, time.monotonic() - began, is_done)
    return is_done


def _succeeds(part: Part, command: str, folder: Path, ends: float | None) -> bool:
    """Run a command; False if it was interrupted. Raises ValueError if it fails."""
    named_ = command.partition("--benchmark-json=")[2].partition(" ")[0]
    launch = Path(line(named_, folder)) if named_ else None
    if launch is not None and launch.is_file():
        return True
    code = INTERRUPTED
    try:
        code = _call(arguments(command, folder), ends)
    finally:
        if launch is not None and code not in part.codes:
            launch.unlink(missing_ok=True)  # pytest also writes a launch that was cut short
    if code in (INTERRUPTED, -signal.SIGINT):
        return False
    if code not in part.codes:
        raise ValueError(f"{part.name}: exit code {code} of {line(command, folder)}; when that is mended, call again")
    return True


def _call(command: list[str], ends: float | None) -> int:
    """The exit code of a command, which is interrupted, as by Ctrl-C, at the time to stop."""
    # A shell's background jobs ignore Ctrl-C, and so would the commands.
    process = subprocess.Popen(command, preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler))
    try:
        return process.wait(None if ends is None else max(0.0, ends - time.monotonic()))
    except subprocess.TimeoutExpired:
        process.send_signal(signal.SIGINT)
    except KeyboardInterrupt:  # the terminal has sent it to the command too
        _await_end(process)
        raise
    _await_end(process)
    return INTERRUPTED if process.returncode else 0


def _await_end(process: subprocess.Popen[bytes]) -> None:
    """Wait for the end of an interrupted command; kill it if it does not end."""
    try:
        process.wait(ENDING_SECONDS)
    except (subprocess.TimeoutExpired, KeyboardInterrupt):
        process.kill()
        process.wait()
