"""The pytest plugin: `pytest --gnomon package.module:Class` runs a test for each claim on each case.

Every pytest in an environment with gnomon loads this file, so it imports only pytest until the option is given.
"""

from __future__ import annotations

import shlex
import sys
from typing import TYPE_CHECKING, Any, TypeAlias

import pytest

if TYPE_CHECKING:
    from gnomon.harness.verification.claim_tests import ClaimTest

Planned: TypeAlias = "tuple[str, ClaimTest, list[pytest.MarkDecorator]]"
"""(the integrator as the user named it, the test of one of its claims, its marks)"""
PLANNED = pytest.StashKey[list[Planned]]()


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("gnomon", "integrators against exact motions")
    group.addoption(
        "--gnomon", action="append", default=[], metavar="MODULE:OBJECT", help="Verify this integrator; repeatable."
    )
    group.addoption(
        "--gnomon-depth", default="low", metavar="DEPTH", help="low, normal or high, as gnomon verify --depth."
    )
    group.addoption("--gnomon-known-failures", metavar="FILE", help="Known failures, a line each: CLAIM CASE REASON.")


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "gnomon: a claim about an integrator, verified by gnomon")
    config.stash[PLANNED] = [planned for named in config.getoption("--gnomon") for planned in _plan(config, named)]
    config.pluginmanager.register(_Applied(), "gnomon-applied")


@pytest.hookimpl(tryfirst=True)  # before -k and -m select tests
def pytest_collection_modifyitems(session: pytest.Session, config: pytest.Config, items: list[pytest.Item]) -> None:
    for named, test, marks in config.stash[PLANNED]:
        item = _Claim.from_parent(session, name=test.id, nodeid=f"gnomon::{named}::{test.id}", claim_test=test)
        for mark in (pytest.mark.gnomon, *marks):
            item.add_marker(mark)
        items.append(item)


def _plan(config: pytest.Config, named: str) -> list[Planned]:
    # Imported here because most runs of pytest need neither numpy nor numba.
    from gnomon.harness.registry import lookup
    from gnomon.harness.results.visible import show
    from gnomon.harness.verification.claim_tests import claim_tests
    from gnomon.harness.verification.verification_report import read_known

    path = config.getoption("--gnomon-known-failures")
    sys.path.append(str(config.invocation_params.dir))  # the command `pytest` does not look in the working directory
    try:
        integrator = lookup.find_one(named)
        known = {} if path is None else read_known(config.invocation_params.dir / path)
        tests = claim_tests(integrator, config.getoption("--gnomon-depth"), how=shlex.quote(named))
        return [(named, test, test.marks(known)) for test in tests]
    except (OSError, ValueError) as error:
        raise pytest.UsageError(show(f"--gnomon {named}: {error}")) from None


class _Applied:
    """Ends a session with the exit code for no tests if no claim applied and no other test ran."""

    def __init__(self) -> None:
        self.ran, self.not_applicable = 0, 0

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.when == "call":
            none = report.nodeid.startswith("gnomon::") and report.skipped and not hasattr(report, "wasxfail")
            self.not_applicable += none
            self.ran += not none

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        if self.not_applicable and not self.ran:
            session.exitstatus = pytest.ExitCode.NO_TESTS_COLLECTED


class _Claim(pytest.Item):
    """One claim on one case."""

    def __init__(self, *, claim_test: ClaimTest, **attributes: Any) -> None:
        super().__init__(**attributes)
        self.claim_test = claim_test

    def runtest(self) -> None:
        self.claim_test()

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        return str(excinfo.value) if isinstance(excinfo.value, AssertionError) else super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Any, int | None, str]:
        return self.path, None, self.nodeid
