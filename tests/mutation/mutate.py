"""Applies a change to a copy of the sources and runs the tests that reach it, which must fail.

    make mutants                                   all mutations of `mutations.toml`, one at a time
    python tests/mutation/mutate.py splitting     those whose name has the word

A mutation names a function and not a line, and is found when it is applied: it stays valid after other edits, and after a
module has moved. It is caught if one of its tests fails with it and passes without it. The script prints for each mutation the test that failed and why, and ends with exit code 1
if one survived without a reason that is listed, if one could not be applied or run, or if a test fails without it too.
Where the tests of a mutation need a library that is not installed, it is reported as not run.
"""

import ast
import os
import re
import resource
import shutil
import signal
import sys
import tempfile
import tomllib
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from time import monotonic

# Imported here for the forks: all tests need them, and they take longer than most tests.
import flint  # noqa: F401
import hypothesis  # noqa: F401
import mpmath  # noqa: F401
import numba  # noqa: F401
import pytest
import scipy.integrate  # noqa: F401

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = ("reference", "cases", "harness")
LIMIT_SECONDS = 300
"""Processor seconds for each test that is named: a mutation that makes a loop endless counts as caught."""
LONGEST_SECONDS = 3600
"""Seconds after which tests that wait are ended: a busy machine may be the reason, so that this shows nothing."""

CAUGHT, SURVIVED, NOT_RUN, IMPOSSIBLE = "caught", "SURVIVED", "not run", "IMPOSSIBLE"


@cache
def module(name: str, root: Path) -> Path:
    """The path in `root` of the module that has this name, in the folder that stands before it or further down."""
    folder, _, stem = name.rpartition("/")
    files = [*(root / folder).rglob(f"{stem}.py")]
    if len(files) != 1:
        raise ValueError(f"{name}: there are {len(files)} modules of that name; name a folder that has one")
    return files[0].relative_to(root)


@dataclass(frozen=True)
class Mutation:
    """At `place`, a module and perhaps a function or class of it, `before` becomes `after`; `tests` reach it."""

    name: str
    place: str
    before: str
    after: str
    tests: tuple[str, ...]
    survives: str = ""
    """Why no test catches it, for one that is known to survive."""

    def apply(self) -> tuple[Path, str]:
        """The path of the module and its source with the change. Raises ValueError unless the text is there exactly once."""
        name, _, function = self.place.partition(".")
        path = module(name, ROOT)
        source = (ROOT / path).read_text(encoding="utf-8")
        begin, end = _span(source, function)
        body = source[begin:end]
        if body.count(self.before) != 1:
            raise ValueError(f"{self.name}: {self.before!r} stands {body.count(self.before)} times in {self.place}")
        return path, source[:begin] + body.replace(self.before, self.after) + source[end:]

    def ids(self) -> list[str]:
        """The tests as pytest names them."""
        parts = [test.partition("::") for test in self.tests]
        return [f"tests/{module(name, ROOT / 'tests')}{colons}{test}" for name, colons, test in parts]


def mutations() -> list[Mutation]:
    """All of `mutations.toml`."""
    found = tomllib.loads(Path(__file__).with_name("mutations.toml").read_text(encoding="utf-8"))
    reasons = found["survives"]
    return [
        Mutation(name, place, before, after, tuple(tests), reasons.get(name, ""))
        for group in found["mutations"].values()
        for name, (place, before, after, *tests) in group.items()
    ]


def _span(source: str, function: str) -> tuple[int, int]:
    """Where a function or class begins and ends in a source, as offsets; the whole source for ""."""
    if not function:
        return 0, len(source)
    names = function.split(".")
    nodes = _statements(source)
    for depth, name in enumerate(names):
        kinds = (ast.FunctionDef, ast.ClassDef)
        found = [node for node in nodes if isinstance(node, kinds) and node.name == name]
        if len(found) != 1:
            raise ValueError(f"{'.'.join(names[: depth + 1])} is defined {len(found)} times")
        nodes = found[0].body
    lines = source.splitlines(keepends=True)
    return sum(map(len, lines[: found[0].lineno - 1])), sum(map(len, lines[: found[0].end_lineno]))


@cache
def _statements(source: str) -> list[ast.stmt]:
    return ast.parse(source).body


@contextmanager
def copied(mutation: Mutation | None) -> Iterator[Path]:
    """A folder from which `import gnomon` takes a copy of the sources, with the mutation."""
    change = mutation and mutation.apply()
    with tempfile.TemporaryDirectory(prefix="mutation-") as name:
        package = Path(name) / "gnomon"
        shutil.copytree(ROOT / "src" / "gnomon", package)
        for folder in FOLDERS:
            shutil.copytree(ROOT / folder, package / folder, ignore=shutil.ignore_patterns("__pycache__"))
        if change:
            path, source = change
            (package / path).write_text(source, encoding="utf-8")
        yield Path(name)


@dataclass(frozen=True)
class Outcome:
    """The outcome of a mutation; `failed` are the tests that failed, or all its tests if they did not end."""

    word: str
    reason: str = ""
    failed: tuple[str, ...] = ()
    seconds: float = 0.0
    """Processor seconds."""


def outcome(mutation: Mutation | None, tests: Sequence[str] = (), stop: bool = True) -> Outcome:
    """Run tests, by default the mutation's own, with the mutation in place, until the first failure if `stop`."""
    with tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace") as output:
        try:
            tests = mutation.ids() if mutation and not tests else tests
            with copied(mutation) as folder:
                code, seconds = _pytest(folder, [*(["-x"] if stop else []), *tests], output.fileno())
        except ValueError as error:  # the text to change is not there
            return Outcome(IMPOSSIBLE, str(error))
        output.seek(0)
        text = output.read()
    failures = re.findall(r"^(?:FAILED|ERROR) (\S+?::.+?)(?: - .*)?$", text, re.MULTILINE)
    missing = re.search(r"^SKIPPED .*: (\S+ is not installed)$", text, re.MULTILINE)
    if missing and code in (0, 4, 5) and not re.search(r"\d passed", text):  # 4, 5: a module is skipped as a whole
        return Outcome(NOT_RUN, missing[1], seconds=seconds)
    if code == 0:
        return Outcome(SURVIVED, seconds=seconds)
    if code == -signal.SIGXCPU:
        return Outcome(CAUGHT, "no end of its tests", tuple(tests), seconds)
    if code != 1 or not failures:  # 1: a test failed; anything else: pytest itself could not work
        return Outcome(IMPOSSIBLE, f"pytest ended with {code}:\n{text[-2000:]}", seconds=seconds)
    reason = re.search(r"^E +(\S.*)$", text, re.MULTILINE)
    return Outcome(CAUGHT, reason[1] if reason else "", tuple(failures), seconds)


def _pytest(folder: Path, arguments: list[str], output: int) -> tuple[int, float]:
    """Run pytest on the sources in `folder`, in a fork, which has the libraries that take seconds to import.

    Returns the exit code, negative for a signal, and the processor seconds.
    """
    if "gnomon" in sys.modules:
        raise RuntimeError("gnomon is imported already: a fork would not import the sources in its folder")
    skip = pytest.importorskip
    options = ["-q", "--benchmark-disable", "-p", "no:cacheprovider", "-m", "not slow", *arguments]
    child = os.fork()
    if child == 0:
        code: int = pytest.ExitCode.INTERNAL_ERROR
        try:
            os.setsid()
            os.dup2(output, 1)
            os.dup2(output, 2)
            os.chdir(ROOT)
            sys.path.insert(0, str(folder))
            path = filter(None, [str(folder), os.environ.get("PYTHONPATH")])
            os.environ["PYTHONPATH"] = os.pathsep.join(path)
            # The reason for which a test is skipped names the library.
            pytest.importorskip = lambda name, *_, **__: skip(name, reason=f"{name} is not installed")
            resource.setrlimit(resource.RLIMIT_CPU, (LIMIT_SECONDS * len(arguments), resource.RLIM_INFINITY))
            signal.alarm(LONGEST_SECONDS)
            code = int(pytest.main(options))
            sys.stdout.flush()
        finally:
            os._exit(code)
    _, status, usage = os.wait4(child, 0)
    with suppress(ProcessLookupError):
        os.killpg(child, signal.SIGKILL)  # worker processes that a test left
    return os.waitstatus_to_exitcode(status), usage.ru_utime + usage.ru_stime


def main(words: list[str]) -> int:
    """Run the mutations whose names have all the words; returns the exit code."""
    chosen = [one for one in mutations() if all(word in one.name for word in words)]
    if not chosen:
        print(f"no mutation has {' '.join(words)!r} in its name")
        return 2
    return summary(chosen)


def summary(chosen: Sequence[Mutation]) -> int:
    """Run mutations, print the outcome of each and the number of caught mutations; 0 if all were caught, else 1."""
    begin = monotonic()
    outcomes = []
    for one in chosen:
        outcomes.append(found := outcome(one))
        print(f"{found.word}  {one.name}  ({found.seconds:.0f} s)", flush=True)
        known = one.survives if found.word == SURVIVED else ""
        for line in filter(None, (*found.failed[:1], found.reason, known)):
            print(f"    {line}", flush=True)
    # Without a mutation, the tests that caught one must pass.
    catching = sorted({test for found in outcomes for test in found.failed})
    plain = outcome(None, catching, stop=False) if catching else Outcome(SURVIVED)
    if plain.word != SURVIVED:
        print(f"without a mutation: {plain.reason}", *plain.failed, sep="\n    ")
    number = Counter(found.word for found in outcomes)
    print(
        f"{len(chosen)} mutations: {number[CAUGHT]} caught, {number[SURVIVED]} survived, {number[NOT_RUN]} not run,"
        f" {number[IMPOSSIBLE]} could not be applied or run; {len(plain.failed)} tests fail without a mutation; {(monotonic() - begin) / 60:.0f} min,"
        f" {sum(found.seconds for found in (*outcomes, plain)) / 60:.0f} min of processor time"
    )
    explained = sum(found.word == SURVIVED and one.survives != "" for one, found in zip(chosen, outcomes, strict=True))
    return 0 if number[CAUGHT] + number[NOT_RUN] + explained == len(chosen) and plain.word == SURVIVED else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
