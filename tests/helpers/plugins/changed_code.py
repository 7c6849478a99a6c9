"""A pytest plugin that selects the tests nearest to changed code, by imports and names: `make test-changed`.

It reads the sources and keeps no record, so that it costs a second, and sees compiled functions, data files and declarations
as well as lines that Python executes. Of a changed module it selects

- the test files that import it, or, if there is none, those that import the modules that import it, and so on; for a case
  only those of cases and exact motions, as many others import one as an example;
- the tests of which a parameter names a case or an integrator whose module imports it, at any depth; of a case only in files
  that take many cases;
- the tests of cases and exact motions whose text names such a case.

It does not see a test that reaches the code through more modules, a command line, or a case that is a mere example:
`make test` runs all.
"""

import inspect
import re
import subprocess
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
FOLDERS = ("reference", "cases", "harness", "src", "tests")
NAMING = ("reference", "cases", "harness/kernels", "harness/integrators", "harness/adapters")
"""Folders in which imports are followed to the modules that declare cases and integrators."""
_IMPORT = re.compile(r"^ *(?:from ([\w.]+) import (\([^)]*\)|.+)|import ([\w.]+))", re.M)
_LISTS = re.compile(r"\b(?:\w*names|default_cases|every_variant|specs|stated|subjects)\(")
"""Functions from which test files take many cases; tests/test_changed_code.py verifies that no other is missing."""
_NAME = re.compile(r'^    name\b[^"\n]*= "([^"]+)"', re.M)


def changed_files(since: str, root: Path = ROOT) -> set[Path]:
    """Files that differ from a revision, and files that git does not know yet. Raises UsageError for an unknown revision."""
    found = set()
    for command in (["diff", "--name-only", "-z", since, "--"], ["ls-files", "--others", "--exclude-standard", "-z"]):
        done = subprocess.run(["git", *command], cwd=root, capture_output=True, text=True, check=False)
        if done.returncode:
            raise pytest.UsageError(f"--since {since}: {done.stderr.strip().splitlines()[0]}; give a revision of git")
        found |= {root / name for name in done.stdout.split("\0") if name.partition("/")[0] in FOLDERS}
    return found


class Selection:
    """Which tests of the project in `root` the files `changed` concern."""

    def __init__(self, changed: set[Path], root: Path = ROOT) -> None:
        self.root = root
        self.texts = {
            path: path.read_text(encoding="utf-8")
            for folder in FOLDERS
            for path in (root / folder).rglob("*.py")
            if path.is_file()
        }
        # A file of data is part of the modules that name it.
        data = [path.name for path in changed if path.suffix != ".py"]
        self.changed = {path for path in changed if path in self.texts} | {
            path for path, text in self.texts.items() if any(f'{name}"' in text for name in data)
        }

    @cached_property
    def importers(self) -> dict[Path, set[Path]]:
        """The files that import a file; all tests of a folder import its conftest.py."""
        found: dict[Path, set[Path]] = {path: set() for path in self.texts}
        helpers = {path.stem: path for path in self.texts if self._is_test(path) and not path.stem.startswith("test_")}
        for path, text in self.texts.items():
            for name in _imported(text):
                source = helpers.get(name) if self._is_test(path) else None
                for used in [source] if source else self._module(name):
                    found[used].add(path)
            if path.name == "conftest.py":
                found[path] |= {test for test in self.texts if path.parent in test.parents}
        return found

    @cached_property
    def files(self) -> set[Path]:
        """The changed test files, and those nearest to each other changed file."""
        found = set()
        for start in self.changed:
            seen, level = {start}, {start}
            while level and not (tests := {path for path in level if path.stem.startswith("test_")}):
                level = {path for one in level for path in self._users(one)} - seen
                seen |= level
            example = self.root / "cases" in start.parents
            found |= {test for test in tests if not example or self._is_of_cases(test)} if level else set()
        return found

    @cached_property
    def names(self) -> set[str]:
        """The cases and integrators whose modules are changed, or import a changed module at any depth.

        A case that imports another one, as the simpler model of its hierarchy, does not depend on its equations.
        """
        waiting = [path for path in self.changed if self._is_naming(path)]
        seen = set(waiting)
        while waiting:
            path = waiting.pop()
            if not (self._declares(path) and self.root / "cases" in path.parents):
                more = {user for user in self.importers[path] if self._is_naming(user)} - seen
                seen |= more
                waiting += more
        return {name for path in seen for name in self._declares(path)}

    def may_hold(self, path: Path) -> bool:
        """Whether a test file may hold a selected test: the others are not even imported."""
        if path in self.files:
            return True
        if not self.names or path not in self.texts:
            return False
        helpers = [used for used, users in self.importers.items() if path in users and self._is_test(used)]
        text = "\n".join(self.texts[one] for one in (path, *helpers))
        if self._is_of_cases(path) and self._named.search(text):
            return True
        return "parametrize" in text and (not self.names <= self._cases or bool(_LISTS.search(text)))

    def takes(self, item: pytest.Item) -> bool:
        """Whether a test is selected."""
        path, function = item.path, getattr(item, "function", None)
        parameters = getattr(getattr(item, "callspec", None), "params", {})
        words = [item.name, *(word for value in parameters.values() for word in _words(value))]
        if path in self.changed or (self.names and self._named.search("\n".join(words))):
            return True
        if path in self.files:  # but not with the parameters of another case, if cases are concerned
            return not self.names & self._cases or not any(
                isinstance(value, str) and value in self._cases - self.names for value in parameters.values()
            )
        if not self.names or not self._is_of_cases(path) or function is None:
            return False
        return bool(self._named.search(inspect.getsource(function)))

    @cached_property
    def _named(self) -> re.Pattern[str]:
        return re.compile(rf"(?<!\w)(?:{'|'.join(map(re.escape, sorted(self.names)))})(?!\w)")

    @cached_property
    def _cases(self) -> set[str]:
        """The names of all cases."""
        return {name for path in self.texts if self.root / "cases" in path.parents for name in self._declares(path)}

    def _declares(self, path: Path) -> list[str]:
        return _NAME.findall(self.texts[path])

    def _users(self, path: Path) -> Iterator[Path]:
        """The files that import a file; helpers of tests stand for the tests that import them."""
        for user in self.importers[path]:
            if self._is_test(user) and not user.stem.startswith("test_"):
                yield from (test for test in self._users(user) if test != user)
            else:
                yield user

    def _module(self, name: str) -> list[Path]:
        """The file of a module of gnomon."""
        package, _, rest = name.partition(".")
        if package != "gnomon" or not rest:
            return []
        places = (self.root / rest.replace(".", "/"), self.root / "src/gnomon" / rest.replace(".", "/"))
        return [
            path for place in places for path in (place.with_suffix(".py"), place / "__init__.py") if path in self.texts
        ]

    def _is_test(self, path: Path) -> bool:
        return self.root / "tests" in path.parents

    def _is_of_cases(self, test: Path) -> bool:
        return any(self.root / "tests" / folder in test.parents for folder in ("cases", "reference"))

    def _is_naming(self, path: Path) -> bool:
        return any(self.root / folder in path.parents for folder in NAMING)


def _imported(text: str) -> Iterator[str]:
    """Names of modules that a text imports; `from a import b` may mean the module a.b."""
    for source, names, module in _IMPORT.findall(text):
        yield source or module
        yield from (f"{source}.{name}" for name in re.findall(r"\w+", names))


def _words(value: object) -> Iterator[str]:
    """The texts among the values of a parameter, and the names of cases and integrators among them."""
    if isinstance(value, tuple | list):
        for each in value[:5]:
            yield from _words(each)
    name = value if isinstance(value, str) else getattr(value, "name", None)
    if isinstance(name, str):
        yield name[:200]


def pytest_addoption(parser: pytest.Parser) -> None:
    """The revision to compare with."""
    parser.addoption("--since", default="HEAD", help="select the tests nearest to the code changed since this revision")


def pytest_configure(config: pytest.Config) -> None:
    """Select once."""
    config.stash[_SELECTION] = Selection(changed_files(config.getoption("--since")))


_SELECTION = pytest.StashKey[Selection]()


def pytest_report_header(config: pytest.Config) -> list[str]:
    """What changed, and what it concerns."""
    selection = config.stash[_SELECTION]
    lines = [
        f"changed: {_few(path.relative_to(ROOT) for path in selection.changed) or 'no code, so that no test runs'}"
    ]
    if selection.files:
        lines.append(f"nearest test files: {_few(path.relative_to(ROOT) for path in selection.files)}")
    return [*lines, f"tests of: {_few(selection.names)}"] if selection.names else lines


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Skip files without a selected test; None lets other plugins decide."""
    is_test = collection_path.stem.startswith("test_") and collection_path.suffix == ".py"
    return True if is_test and not config.stash[_SELECTION].may_hold(collection_path) else None


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Keep the selected tests."""
    taken = [item for item in items if config.stash[_SELECTION].takes(item)]
    config.hook.pytest_deselected(items=[item for item in items if item not in {*taken}])
    items[:] = taken


def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    """Without changed code there is nothing to fail."""
    if exitstatus == pytest.ExitCode.NO_TESTS_COLLECTED and not session.config.stash[_SELECTION].changed:
        session.exitstatus = pytest.ExitCode.OK


def _few(names: object) -> str:
    """At most ten names, sorted."""
    every = sorted(map(str, names))  # type: ignore[call-overload]
    return ", ".join([*every[:10], *([f"and {len(every) - 10} more"] if len(every) > 10 else [])])
