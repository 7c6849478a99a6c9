"""No test measures the machine: the sources of the tests compare no times, and hand no short limits to runs.

Such a test fails on a machine that is slow or busy. Instead a test counts work (calls, steps, trials, imports), waits
for an event, or turns a clock (`helpers/turned_clock.py`); what takes long is measured by tests/benchmarks/.
"""

import ast
import itertools
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from waiting import LIMIT_SECONDS

TESTS = Path(__file__).parent
APART = ("benchmarks", "programs", "example_project", "test_clocks.py")
"""Measurements, and sources that are no tests."""
CLOCKS = re.compile(
    r"(.*\.)?(perf_counter|monotonic|process_time|thread_time|default_timer)(_ns)?|time\.time(_ns)?|timeit\..*"
)
PAUSES = re.compile(r"(.*\.)?(sleep|Timer)|signal\.(alarm|setitimer)")
MEASURED = re.compile(r"(first|prepare|null|delay|reset)_seconds|seconds_(median|low|high)|.*\.seconds")
"""Times that are measured: keys and attributes of results."""
ARITHMETIC = ("min", "max", "abs", "round", "sum", "float", "int")
"""Functions of times that are times."""
LIMITS = re.compile(r"(\w+_)?limit_seconds|prepare_seconds|seconds|max_seconds|timeout|limit")
"""Arguments by which a limit is handed on."""
OPTIONS = ("--limit", "--max-seconds")
TURNED = {"clock", "turned_clock"}
"""A test that has a clock which it turns may hand any limit to a run."""
TINY, ENOUGH = 1e-6, LIMIT_SECONDS
"""Seconds. Nothing ends within the former; nothing that a test waits for takes a twentieth of the latter on a quiet
machine."""
WORDS = re.compile(
    "seconds|limit|timeout|within|sleep|Timer|alarm|itimer|clock|counter|monotonic|_time|timer|time[.]time|timeit"
)
"""A source without any of these words is not read further: this halves the time."""
EXCEPTIONS = {
    "attacks/conftest.py::no_hang": "a guard",
    "attacks/planted_attacks.py::fork": "a guard: tests wait less long for the end of the fork",
    "attacks/planted_attacks.py::the module": "a signal ends a process that waits for ever",
    "detection/measure.py::first_failure": "divides hours of measurements into parts; its test gives it no time",
    "harness/commands/test_interruption.py::until": "a guard",
    "harness/measuring/test_solved.py::test_a_call_without_end_is_given_up": "nothing ends",
    "harness/reporting/page/test_recomputed.py::expected_share": "a page is computed again from the times in its file",
    "harness/reporting/page/test_recomputed.py::test_other_divisions_stand_beside_the_least_of_third_parties":
        "a page is computed again from the times in its file",
    "harness/running/test_first_trials.py::test_a_run_in_which_everything_hangs_fails_and_says_so": "nothing ends",
    "harness/running/test_first_use.py::test_it_is_measured_at_the_first_trial_of_a_series_once": "no pause is shorter than asked",
    "harness/running/test_first_use.py::test_its_caches_are_empty_and_end_with_it": "no pause is shorter than asked",
    "harness/running/test_planned_run.py::the module": "for a turned clock",
    "harness/running/test_pool.py::test_no_trial_overlaps_an_interlude": "pauses that let a wrong pool show itself",
    "harness/running/test_sweep.py::the module": "outcomes and their times are invented",
    "harness/stability/test_linear.py::on_axes": "a time that is given: no point costs any",
    "harness/system/test_locks.py::test_a_forked_child_does_not_keep_the_lock": "a guard",
    "harness/verification/odd_program.py::main": "uses at least so much processor time",
    "harness/verification/test_program_adapter.py::test_the_time_of_a_program_is_that_of_its_solutions":
        "a program uses at least the processor time that it reads itself",
    "helpers/planted.py::SlowAtFirst": "no pause is shorter than asked",
    "helpers/planted_ensembles.py::EndsLate": "a guard for a wait",
    "helpers/waiting.py::wait_until": "a guard for a wait",
    "mutation/mutate.py::_pytest": "a guard",
}  # fmt: skip
"""The reason for each place that is found and does not depend on the speed of the machine."""


def word(node: ast.AST | None) -> str:
    """The dotted name of a variable, an attribute or a key; "" for anything else."""
    if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Constant):
        return str(node.slice.value)
    if isinstance(node, ast.Attribute):
        return f"{word(node.value)}.{node.attr}"
    return node.id if isinstance(node, ast.Name) else ""


def parts(node: ast.AST) -> Iterator[ast.AST]:
    """The parts of an expression, without the arguments of functions whose results need not be times."""
    yield node
    if not (isinstance(node, ast.Call) and word(node.func) not in ARITHMETIC):
        for part in ast.iter_child_nodes(node):
            yield from parts(part)


def is_time(node: ast.AST, times: set[str]) -> bool:
    """Whether an expression has a reading of a clock, a name in `times`, or a measured time in it."""
    return any(
        (isinstance(part, ast.Call) and CLOCKS.fullmatch(word(part.func)))
        or word(part) in times
        or MEASURED.fullmatch(word(part))
        for part in parts(node)
    )


def times_in(nodes: list[ast.AST]) -> set[str]:
    """The names of a scope that have a reading of a clock, or a value that is made of such names."""
    assigned = [node for node in nodes if isinstance(node, ast.Assign | ast.AnnAssign | ast.NamedExpr)]
    found, before = set[str](), None
    while found != before:
        before = set(found)
        for node in assigned:
            if node.value is not None and is_time(node.value, found):
                targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                found |= {name.id for target in targets for name in ast.walk(target) if isinstance(name, ast.Name)}
    return found


def number(node: ast.AST, known: dict[str, float]) -> float:
    """The number of an expression, perhaps as a text; nan if it is made of names that are not `known`."""
    if isinstance(node, ast.Call) and word(node.func) in ("str", "float") and node.args:
        return number(node.args[0], known)
    try:
        value: Any = known[node.id] if isinstance(node, ast.Name) else ast.literal_eval(node)
        return math.nan if isinstance(value, bool) else float(value)
    except (KeyError, TypeError, ValueError):
        return math.nan


def limits(node: ast.AST) -> Iterator[ast.AST]:
    """The limits in a call or a list of words: arguments by their names or of `within`, values after an option."""
    if isinstance(node, ast.Call):
        yield from (given.value for given in node.keywords if given.arg and LIMITS.fullmatch(given.arg))
        if word(node.func).endswith("within"):
            yield from node.args[:1]
    words = node.args if isinstance(node, ast.Call) else getattr(node, "elts", [])
    for option, value in itertools.pairwise(words):
        if isinstance(option, ast.Constant) and option.value in OPTIONS:
            yield value


def compares_times(node: ast.Compare, times: set[str]) -> bool:
    """Whether a comparison decides by the length of a time. Every measured time is above zero, and below infinity."""
    sides = [node.left, *node.comparators]
    ordered = any(isinstance(one, ast.Lt | ast.LtE | ast.Gt | ast.GtE) for one in node.ops)
    trivial = any(number(side, {}) == 0 or word(side) == "math.inf" for side in sides)
    return ordered and not trivial and any(is_time(side, times) for side in sides)


def places(source: str) -> Iterator[tuple[str, int, str]]:
    """(function or class, line, what is found) in a source, also in the sources that are texts in it."""
    module = ast.parse(source)
    known = {
        word(target): number(node.value, {})
        for node in module.body
        if isinstance(node, ast.Assign)
        for target in node.targets
    }
    for scope in module.body:
        name, nodes = getattr(scope, "name", "the module"), list(ast.walk(scope))
        times = times_in(nodes)
        turns = any(getattr(node, "arg", getattr(node, "id", None)) in TURNED for node in nodes)
        for node in nodes:
            line = getattr(node, "lineno", 0)
            if isinstance(node, ast.Compare) and compares_times(node, times):
                yield name, line, f"compares times: {ast.unparse(node)}"
            if isinstance(node, ast.Call) and PAUSES.fullmatch(word(node.func)):
                yield name, line, f"pauses: {ast.unparse(node)}"
            for limit in limits(node):
                if not turns and TINY < number(limit, known) < ENOUGH:
                    yield name, line, f"has a short limit: {ast.unparse(limit)}"
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and "\n" in node.value.strip():
                try:
                    yield from ((name, line + inner - 1, what) for _, inner, what in places(node.value))
                except SyntaxError:
                    continue  # a text that is no source


def find_measurements() -> dict[str, list[str]]:
    """What is found, by file and function or class."""
    found: dict[str, list[str]] = {}
    for path in sorted(TESTS.rglob("*.py")):
        file = path.relative_to(TESTS)
        source = path.read_text(encoding="utf-8")
        if file.parts[0] not in APART and WORDS.search(source):
            for name, line, what in places(source):
                found.setdefault(f"{file}::{name}", []).append(f"tests/{file}:{line} {what}")
    return found


def test_no_test_measures_the_machine() -> None:
    found = find_measurements()
    new = [text for place, texts in found.items() if place not in EXCEPTIONS for text in texts]
    assert not new, "\n".join(["count work, wait for an event, or turn a clock:", *new])
    assert EXCEPTIONS.keys() <= found.keys(), "an exception for something that is gone"


@pytest.mark.parametrize(
    ("source", "what"),
    [
        ("def f():\n    began = time.perf_counter()\n    g()\n    assert time.perf_counter() - began < 1", "compares"),
        ("def f():\n    a = monotonic()\n    b = monotonic() - a\n    assert 3 > b", "compares"),
        ("def f():\n    while time.process_time() < ends:\n        pass", "compares"),
        ("def f(row):\n    assert row['seconds_median'] < 2", "compares"),
        ("def f(call):\n    assert max(call.seconds, 1) <= 2", "compares"),
        ("def f():\n    run(SUITE.change(limit_seconds=2.0))", "has a short limit: 2.0"),
        ("S = plan.suite('quick').within(20)", "has a short limit: 20"),
        ("SOON = 0.2\ndef f():\n    job = Job(1, limit=SOON)", "has a short limit: SOON"),
        ("COMMAND = ['run', '--limit', '1']", "has a short limit: '1'"),
        ("def f():\n    assert gnomon('verify', '--max-seconds', str(60)) == 0", "has a short limit: str(60)"),
        ("def f():\n    process.communicate(timeout=5)", "has a short limit: 5"),
        ("def f():\n    time.sleep(0.3)", "pauses"),
        ("def f():\n    threading.Timer(1, g).start()", "pauses"),
        ("SCRIPT = '''\nimport time\ntime.sleep(1)\n'''", "pauses"),
    ],
)
def test_each_measurement_is_found(source: str, what: str) -> None:
    ((_, line, found),) = places(source)
    assert found.startswith(what)
    assert line == {"SCRIPT": 3}.get(source[:6], len(source.splitlines()) - source.count("pass"))


@pytest.mark.parametrize(
    "source",
    [
        "def f(clock):\n    run(SUITE.change(limit_seconds=2.0))",
        "def f():\n    run(SUITE.within(LONG_SECONDS))",
        "def f():\n    verify('--max-seconds', '1e-9')",
        "COMMAND = ['run', '--limit', str(LONG_SECONDS)]",
        "def f(row):\n    assert row['seconds_median'] > 0",
        "def f(row):\n    assert row['seconds_median'] == 0.0005",
        "def f():\n    process.communicate(timeout=600)",
        "def f():\n    began = Rounds(time.monotonic())\n    assert began.rounds < 3",
    ],
)
def test_work_events_and_turned_clocks_are_no_measurements(source: str) -> None:
    assert not list(places(source))
