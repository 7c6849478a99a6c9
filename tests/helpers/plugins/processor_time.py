"""A pytest plugin that sums the processor time of tests by file, in all workers, and names the files that take most."""

import os
from collections import Counter
from collections.abc import Iterator
from typing import Any

import pytest

FROM_SECONDS = 60.0
"""Runs that take less print nothing."""
FILES = 3
COLLECTION = "collection"


def processor_seconds() -> float:
    """Of this process and of its children that have ended."""
    return sum(os.times()[:4])


class ProcessorTime:
    """Measures the tests of this process; the controller of xdist adds up what its workers measured."""

    def __init__(self) -> None:
        self.seconds: Counter[str] = Counter()

    @pytest.hookimpl(wrapper=True)
    def pytest_collection(self) -> Iterator[None]:
        """Imports of test files, and the rewriting of their assertions."""
        return (yield from self._measured(COLLECTION))

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        """A test with its fixtures."""
        return (yield from self._measured(item.nodeid.partition("::")[0]))

    def _measured(self, name: str) -> Iterator[None]:
        begin = processor_seconds()
        result = yield
        self.seconds[name] += processor_seconds() - begin  # type: ignore[assignment]
        return result

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """A worker sends its sums."""
        if hasattr(session.config, "workeroutput"):
            session.config.workeroutput[COLLECTION] = dict(self.seconds)

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node: Any) -> None:
        """The controller receives them; a worker that crashed has sent none."""
        self.seconds.update(getattr(node, "workeroutput", {}).get(COLLECTION, {}))

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """One line."""
        total = sum(self.seconds.values())
        if total < FROM_SECONDS:
            return
        files = Counter({name: seconds for name, seconds in self.seconds.items() if name != COLLECTION})
        most = ", ".join(f"{name} {seconds:.0f} s" for name, seconds in files.most_common(FILES))
        terminalreporter.write_line(
            f"processor time: {total:.0f} s, of which collection {self.seconds[COLLECTION]:.0f} s; most in {most}"
        )
