"""The script ends with exit code 0 only if every mutation is applied and caught by a test that passes without it."""

import signal
import subprocess
import sys
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any

import mutate
import pytest
from mutate import CAUGHT, IMPOSSIBLE, NOT_RUN, ROOT, SURVIVED, Mutation, Outcome

FAILED = "E       assert 1 == 2\nFAILED tests/test_a.py::test_b[c d] - assert 1...\n"
SKIPPED = "SKIPPED [1] tests/test_a.py:20: heyoka is not installed\n"
TEST = "harness/measuring/test_events::test_the_same_events_have_no_error"
SAME = Mutation(
    "nothing changes", "harness/measuring/events.score_events", "missing = extra = 0", "missing = extra = 0", (TEST,)
)


@pytest.mark.parametrize(
    ("code", "output", "word"),
    [
        (0, "", SURVIVED), (1, FAILED, CAUGHT), (-signal.SIGXCPU, "", CAUGHT), (-signal.SIGALRM, "", IMPOSSIBLE),
        (2, "ERROR tests/test_a.py - SyntaxError\n", IMPOSSIBLE), (1, "", IMPOSSIBLE),
        (4, "ERROR: not found: tests/test_a.py::test_b\n", IMPOSSIBLE), (5, "no tests ran\n", IMPOSSIBLE),
        (0, f"{SKIPPED}1 skipped in 0.1s\n", NOT_RUN), (4, f"{SKIPPED}1 skipped in 0.1s\nERROR: found no collectors\n", NOT_RUN),
        (5, f"{SKIPPED}1 skipped in 0.1s\n", NOT_RUN), (0, f"{SKIPPED}1 passed, 1 skipped in 0.1s\n", SURVIVED),
        (1, f"{SKIPPED}{FAILED}", CAUGHT), (0, "SKIPPED [1] tests/test_a.py:20: depends on the numbers\n", SURVIVED),
    ],
)  # fmt: skip
def test_a_mutation_is_caught_by_a_failed_test_alone(
    code: int, output: str, word: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Sources that cannot be imported, or a test that is not there or lacks a library, show nothing of the tests."""

    def run(folder: Path, arguments: list[str], file: int) -> tuple[int, float]:
        with open(file, "w", closefd=False, encoding="utf-8") as stream:
            stream.write(output)
        return code, 1.0

    monkeypatch.setattr(mutate, "copied", lambda mutation: nullcontext(Path()))
    monkeypatch.setattr(mutate, "_pytest", run)
    found = mutate.outcome(SAME)
    assert found.word == word
    assert found.failed == {CAUGHT: ("tests/test_a.py::test_b[c d]",) if output else (*SAME.ids(),)}.get(word, ())
    assert (found.reason == "assert 1 == 2") == (FAILED in output)


def test_every_mutation_changes_a_text_of_the_sources_and_names_tests_that_are_there() -> None:
    """A function, a variable or a test that gets another name would leave a mutation that nobody can apply."""
    lost = []
    for mutation in mutate.mutations():
        try:
            mutation.apply()
            tests = [test.partition("::") for test in mutation.ids()]
        except ValueError as error:
            lost.append(str(error))
        else:
            sources = [((ROOT / path).read_text(encoding="utf-8"), test.partition("[")[0]) for path, _, test in tests]
            lost += [f"{mutation.name}: no {test}" for source, test in sources if test and f"def {test}(" not in source]
    assert not lost


@pytest.mark.parametrize(
    ("changed", "reason"),
    [
        ({"before": "no such text"}, "'no such text' stands 0 times in harness/measuring/events.score_events"),
        ({"place": "harness/measuring/events.no_such"}, "no_such is defined 0 times"),
        ({"place": "harness/no_such.score_events"}, "harness/no_such: there are 0 modules of that name"),
        ({"tests": ("harness/test_no_such",)}, "harness/test_no_such: there are 0 modules of that name"),
    ],
)
def test_what_is_not_there_cannot_be_changed_or_run(changed: dict[str, Any], reason: str) -> None:
    found = mutate.outcome(replace(SAME, **changed))
    assert found.word == IMPOSSIBLE
    assert reason in found.reason


@pytest.mark.parametrize(
    ("words", "without", "code"),
    [
        ([CAUGHT, CAUGHT], SURVIVED, 0),
        ([CAUGHT, SURVIVED], SURVIVED, 1),
        ([CAUGHT, IMPOSSIBLE], SURVIVED, 1),
        ([CAUGHT, NOT_RUN], SURVIVED, 0),
        ([CAUGHT, CAUGHT], CAUGHT, 1),
    ],
)
def test_the_exit_code_is_0_only_if_all_are_caught_by_tests_that_pass_without_them(
    words: list[str], without: str, code: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    waiting = [Outcome(word, failed=(TEST,) if word == CAUGHT else ()) for word in words]

    def outcome(mutation: Mutation | None, tests: Sequence[str] = (), stop: bool = True) -> Outcome:
        return waiting.pop(0) if mutation is not None else Outcome(without, failed=(TEST,) * (without == CAUGHT))

    monkeypatch.setattr(mutate, "outcome", outcome)
    assert mutate.summary([SAME] * len(words)) == code
    last = capsys.readouterr().out.splitlines()[-1]
    said = {CAUGHT: "caught", SURVIVED: "survived", NOT_RUN: "not run"}
    counts = [f"{words.count(word)} {text}" for word, text in said.items()]
    assert last.startswith(f"2 mutations: {', '.join(counts)}, {words.count(IMPOSSIBLE)} could not be applied or run")
    assert f"{1 if without == CAUGHT else 0} tests fail without a mutation" in last


def test_a_survivor_with_a_reason_is_listed_with_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(mutate, "outcome", lambda *_, **__: Outcome(SURVIVED))
    assert mutate.summary([replace(SAME, survives="a choice")]) == 0
    assert "    a choice\n" in capsys.readouterr().out
    assert mutate.summary([SAME]) == 1


@pytest.mark.slow
def test_a_mutation_that_changes_nothing_survives() -> None:
    program = "import sys; sys.path.insert(0, sys.argv[1]); import mutate; from test_mutations import SAME; sys.exit(mutate.summary([SAME]))"
    run = subprocess.run(
        [sys.executable, "-c", program, str(Path(__file__).parent)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 1, run.stderr
    assert "SURVIVED  nothing changes" in run.stdout
    assert "1 mutations: 0 caught, 1 survived" in run.stdout
