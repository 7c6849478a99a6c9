"""Applies a change to a copy of the sources and runs the tests that reach it, which must fail.

    make mutation                                  all mutations of `mutations.py`, two at a time
    python tests/mutation/mutate.py splitting     those whose name has the word

A mutation names a function, not a line, so that it stays valid after other edits; if its text is not there exactly once,
the script stops with an error. Exit code 1 if the tests pass with a mutation, or fail without one.
"""

from __future__ import annotations

import ast
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = ("reference", "cases", "harness")
WORKERS = 2
LIMIT_SECONDS = 900.0
"""Seconds for the tests of a mutation: one that makes a loop endless counts as caught."""


@dataclass(frozen=True)
class Mutation:
    """In `function` of `file` (a class or "" for module level too), `before` becomes `after`; `tests` reach it."""

    name: str
    file: str
    function: str
    before: str
    after: str
    tests: tuple[str, ...]

    def applied(self, source: str) -> str:
        """The source with the change. Raises ValueError where the text is not in the function exactly once."""
        begin, end = _span(source, self.function)
        body = source[begin:end]
        if body.count(self.before) != 1:
            raise ValueError(f"{self.name}: {self.before!r} stands {body.count(self.before)} times in {self.function}")
        return source[:begin] + body.replace(self.before, self.after) + source[end:]


def _span(source: str, function: str) -> tuple[int, int]:
    """Where a function or class begins and ends in a source, as offsets; the whole source for ""."""
    if not function:
        return 0, len(source)
    names = function.split(".")
    nodes: list[ast.stmt] = ast.parse(source).body
    for depth, name in enumerate(names):
        kinds = (ast.FunctionDef, ast.ClassDef)
        found = [node for node in nodes if isinstance(node, kinds) and node.name == name]
        if len(found) != 1:
            raise ValueError(f"{'.'.join(names[: depth + 1])} is defined {len(found)} times")
        nodes = found[0].body
    lines = source.splitlines(keepends=True)
    return sum(map(len, lines[: found[0].lineno - 1])), sum(map(len, lines[: found[0].end_lineno]))


@contextmanager
def copied(mutation: Mutation | None) -> Iterator[Path]:
    """A folder from which `import gnomon` takes a copy of the sources, with the mutation."""
    with tempfile.TemporaryDirectory(prefix="mutation-") as name:
        package = Path(name) / "gnomon"
        shutil.copytree(ROOT / "src" / "gnomon", package)
        for folder in FOLDERS:
            shutil.copytree(ROOT / folder, package / folder, ignore=shutil.ignore_patterns("__pycache__"))
        if mutation is not None:
            path = package / mutation.file
            path.write_text(mutation.applied(path.read_text(encoding="utf-8")), encoding="utf-8")
        yield Path(name)


def passes(mutation: Mutation | None, tests: tuple[str, ...]) -> bool:
    """Whether the tests pass with the mutation in place; they stop at the first failure."""
    with copied(mutation) as folder:
        path = os.pathsep.join(filter(None, [str(folder), os.environ.get("PYTHONPATH")]))
        command = [sys.executable, "-m", "pytest", "-x", "-q", "--benchmark-disable", "-p", "no:cacheprovider"]
        try:
            ended = subprocess.run(
                [*command, "-m", "not slow", *tests], cwd=ROOT, env=os.environ | {"PYTHONPATH": path},
                capture_output=True, text=True, timeout=LIMIT_SECONDS,
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            return False
    if ended.returncode not in (0, 1):  # 1: a test failed; anything else: pytest itself could not work
        raise RuntimeError(f"pytest ended with {ended.returncode}:\n{ended.stdout[-2000:]}{ended.stderr[-2000:]}")
    return ended.returncode == 0


def main(words: list[str]) -> int:
    """Run the mutations whose names have all the words; returns the exit code."""
    from mutations import MUTATIONS

    chosen = [one for one in MUTATIONS if all(word in one.name for word in words)]
    if not chosen:
        print(f"no mutation has {' '.join(words)!r} in its name")
        return 2
    for one in chosen:  # before the long work: raises if the text of one is not there
        one.applied((ROOT / one.file).read_text(encoding="utf-8"))
    with ThreadPoolExecutor(WORKERS) as pool:
        files: dict[str, set[str]] = {}
        for test in (test for one in chosen for test in one.tests):
            files.setdefault(test.partition("::")[0], set()).add(test)
        # One run a file: starting and compiling take most of the time of a test.
        for file, passed in zip(files, pool.map(lambda file: passes(None, tuple(files[file])), files), strict=True):
            if not passed:
                print(f"{file} fails without a mutation")
                return 1
        missed = 0
        for one, passed in zip(chosen, pool.map(lambda one: passes(one, one.tests), chosen), strict=True):
            print(f"{'MISSED' if passed else 'caught'}  {one.name}", flush=True)
            missed += passed
    print(f"{len(chosen)} mutations, {missed} missed")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
