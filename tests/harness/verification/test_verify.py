"""`gnomon verify`: exit codes, the first trial, hangs, known failures, and the files that it writes."""

import json
import os
import shlex
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import planted_methods
import planted_right
import pytest
from command_line import gnomon
from gnomon.harness.system.supervisor import ASLEEP
from gnomon.harness.verification.claims import Finding, Outcome, fail_claim, not_applicable, not_checked, pass_claim
from gnomon.harness.verification.function_adapter import from_step
from gnomon.harness.verification.verification_report import (
    as_badge,
    as_json,
    as_junit,
    as_markdown,
    exit_code,
    lines,
    read_known,
    workflow_commands,
)
from gnomon.harness.verification.verify import CLAIM_SECONDS, FirstTrialError, Report, Row, verify
from passing_time import hang
from turned_clock import Clock

ALONE = ("--case", "pendulum_simple", "--depth", "low", "--claim")
FOLLOWED = [Row("follows", "pendulum_simple", pass_claim()), Row("error", "pendulum_simple", pass_claim())]
"""What counts as verified on a case."""
ROWS = [
    *FOLLOWED,
    Row("order", "pendulum_simple", fail_claim("h = 1 to 2", "h^4", "h^1 <&\x1b", "It is wrong.")),
    Row("repeatable", "pendulum_simple", pass_claim()),
    Row("symplectic", "pendulum_simple", not_applicable("it does not declare symplectic")),
]
REPORT = Report("mine:RK4", "low", ROWS)
KNOWN = {("order", "pendulum_simple"): "a coefficient"}


def test_markdown_shows_the_counts_and_each_new_failure_as_plain_text() -> None:
    """An integrator's message is text, not markup: it cannot add a column, a link or a tag."""
    text = as_markdown(REPORT, {}, "m:r")
    assert "4 claims checked on 1 cases, 3 passed, 1 failed (0 known), 1 not applicable, 0 not checked: failed" in text
    (row,) = [line for line in text.splitlines() if line.startswith("| order")]
    assert "h^1 &lt;&amp;" in row
    odd = Report("m", "low", [*FOLLOWED, Row("order", "a", fail_claim("x|y", "[a](b)", "<b>`c`\nd"))])
    (row,) = [line for line in as_markdown(odd, {}, "m:r").splitlines() if line.startswith("| order")]
    assert row.count("|") - row.count(r"\|") == 7
    assert "<b>" not in row
    assert r"\[a\](b)" in row
    assert "| order" not in as_markdown(REPORT, KNOWN, "m:r")


def test_annotations_are_one_line_for_each_new_failure() -> None:
    rows = [*FOLLOWED, Row("order", "a", fail_claim("50%", "1", "::error::2\n::stop"))]
    (line,) = workflow_commands(Report("m", "low", rows), {}, "m:r")
    assert line.startswith("::error title=gnomon%3A order on a::FAILED order on a, 50%25%0A")
    assert "\n" not in line
    assert workflow_commands(REPORT, KNOWN, "m:r") == []


def test_the_badge_is_never_green_with_nothing_checked() -> None:
    reports = (REPORT, Report("m", "low", FOLLOWED), Report("m", "low", ROWS[3:]), Report("m", "low", ROWS[4:]))
    badges = [json.loads(as_badge(report, {}, "m:r")) for report in reports]
    assert [badge["color"] for badge in badges] == ["red", "brightgreen", "lightgrey", "lightgrey"]
    assert [badge["message"] for badge in badges[2:]] == ["not verified: 1 of 1 claims", "nothing checked"]


def test_exit_codes_say_what_was_found() -> None:
    """0 only where the motion was followed and accuracy was checked, and 1 only for failures that are not known."""
    assert exit_code(REPORT, {}) == 1
    assert exit_code(REPORT, KNOWN) == 0
    assert exit_code(Report("mine:RK4", "low", FOLLOWED), {}) == 0
    assert exit_code(Report("mine:RK4", "low", []), {}) == 2


SIDE = Row("repeatable", "pendulum_simple", pass_claim())
UNSUPPORTED = Row("follows", "kepler_orbit", not_applicable("unsupported: this case"))
CUT = Row("error", "pendulum_simple", not_checked("the time of --max-seconds is over"))


@pytest.mark.parametrize(
    ("rows", "names", "code"),
    [
        ([SIDE], (), 2),
        ([FOLLOWED[0], SIDE], (), 2),
        ([FOLLOWED[0], CUT], (), 2),
        ([*FOLLOWED, UNSUPPORTED], (), 0),
        ([*FOLLOWED, UNSUPPORTED], ("pendulum_simple", "kepler_orbit"), 2),
        ([UNSUPPORTED], (), 2),
        ([*FOLLOWED, Row("hard", "pendulum_simple/rotation", not_applicable("no answer"))], (), 0),
        (
            [*FOLLOWED, Row("follows", "pendulum_simple/rotation", not_checked("no solution"))],
            ("pendulum_simple/rotation",),
            2,
        ),
    ],
)
def test_each_case_must_be_followed_with_a_known_accuracy(rows: list[Row], names: tuple[str, ...], code: int) -> None:
    """Claims that hold for zeros too (units, mirror, history) verify nothing; nor does one case speak for another."""
    assert exit_code(Report("m", "low", rows, cases=names), {}) == code


@pytest.mark.parametrize(
    ("findings", "names", "code"),
    [
        ([pass_claim()], ("a",), 0),
        ([not_applicable("it has none")], ("a",), 2),
        ([pass_claim(), not_applicable("it has none")], ("a", "b"), 2),
        ([pass_claim(), not_applicable("it has none")], (), 0),
        ([pass_claim(), not_checked("the time is over")], (), 2),
        ([not_applicable("it has none"), not_applicable("it has none")], (), 2),
        ([], (), 2),
    ],
)
def test_a_named_claim_must_be_checked(findings: list[Finding], names: tuple[str, ...], code: int) -> None:
    """On each named case; of a depth's own cases on one, as not each has, for example, a symmetry."""
    rows = [Row("turned", case, finding) for case, finding in zip("ab", findings, strict=False)]
    assert exit_code(Report("m", "low", rows, claims=("turned",), cases=names), {}) == code


def test_the_text_ends_with_counts_and_shows_failures_alone() -> None:
    text = lines(REPORT, {}, "'my module:rk4'")
    assert text[-1] == (
        "mine:RK4: 4 claims checked on 1 cases, 3 passed, 1 failed (0 known), 1 not applicable, 0 not checked: failed"
    )
    whole = "\n".join(text)
    for part in ("h = 1 to 2", "expected: h^4", "got:      h^1", "It is wrong.", "it does not declare symplectic"):
        assert part in whole
    assert "gnomon verify 'my module:rk4' --case pendulum_simple --claim order --depth low" in whole
    assert "\x1b" not in whole
    assert "known failure: order on pendulum_simple: a coefficient" in lines(REPORT, KNOWN, "m:r")


def test_a_claim_is_explained_at_its_first_failure_and_the_cause_once() -> None:
    twice = [Row("order", case, fail_claim("h = 1", "h^4", f"h^{k}", "It is wrong.")) for k, case in enumerate("ab")]
    text = lines(Report("m", "low", [*FOLLOWED, *twice], diagnosis="order: it converges with order 1.0"), {}, "m:r")
    for part in ("  claim: ", "  why: ", "  bound: ", "likely cause: it converges with order 1.0"):
        assert sum(line.startswith(part) for line in text) == 1
    assert sum(line.startswith("  expected: ") for line in text) == 2
    known = {("order", case): "known" for case in "ab"}
    assert not any(
        line.startswith("likely cause")
        for line in lines(Report("m", "low", [*FOLLOWED, *twice], diagnosis="x: y"), known, "m")
    )


def test_a_failure_that_needs_earlier_calls_is_shown_by_a_command_with_these_calls(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """The claim that fails passes alone. The command that is named runs the claims before it too."""
    path = "planted_methods:wrong_from_the_seventh"
    both = ("--claim", "history", "--claim", "repeatable")
    assert gnomon("verify", path, *ALONE[:4], *both) == 1
    shown = capsys.readouterr().out.splitlines()
    (line,) = {line for line in shown if line.startswith("  command: ")}
    assert gnomon("verify", path, *ALONE, "history") == 0
    capsys.readouterr()
    assert gnomon(*shlex.split(line.partition("gnomon ")[2])) == 1
    assert [each for each in shown if each.startswith("FAILED")] == [
        each for each in capsys.readouterr().out.splitlines() if each.startswith("FAILED")
    ]


def test_only_cases_on_which_a_claim_was_checked_are_counted() -> None:
    """A hard variant without a claim that applies is no case on which anything was verified."""
    rows = [*FOLLOWED, Row("hard", "kepler_orbit/plunge", not_applicable("its setting is a step size"))]
    report = Report("m", "low", [*rows, Row("runs", "two_body", not_checked("no time"))])
    assert "2 claims checked on 1 cases, 2 passed" in lines(report, {}, "m:r")[-1]
    assert "2 claims checked on 1 cases: 2 passed" in repr(report)


def test_claims_that_were_not_checked_are_named_with_their_cases() -> None:
    """A claim that passed on one case, and was not checked on another, is not shown as unchecked everywhere."""
    open_ = [Row(claim, "b", not_checked("a known cause ended the run")) for claim in ("runs", "follows")]
    rows = [*FOLLOWED, *open_, Row("error", "c", not_checked("no steady order"))]
    text = lines(Report("m", "low", rows), {}, "m:r")
    assert "not checked: claims on b (2): a known cause ended the run" in text
    assert "not checked: error on c (1): no steady order" in text


@pytest.mark.parametrize(
    ("order", "case", "claims", "advice"),
    [
        (4, "kepler_orbit", ["order_short", "step_order"], ["order 4 is declared"]),
        (3, "kepler_orbit", ["step_order"], ["order 3 is declared: declare order=4 to verify it"]),
        (None, "kepler_orbit", ["error"], ["no order is declared: declare order=4 to verify it"]),
        (5, "pendulum_simple", ["order", "step_order"], []),
    ],
)
def test_the_order_that_was_seen_stands_beside_the_declared_one(
    order: int | None, case: str, claims: list[str], advice: list[str]
) -> None:
    """RK4 that declares order 3 keeps all its claims. After a failure, here of `step_order`, the failure tells the order."""
    method = from_step(planted_methods.good_rk4.function, name="RK4", order=order)
    report = verify(method, [case], "low", claims, workers=1)
    told = [line for line in lines(report, {}, "m:r") if line.startswith("for information: errors fall as h^")]
    assert [line.partition("; ")[2] for line in told] == advice
    assert any(row.finding.outcome == Outcome.PASSED for row in report.rows)


def test_a_known_failure_that_passes_is_reported() -> None:
    known = {("repeatable", "pendulum_simple"): "a clock"}
    assert any(line.startswith("passes now: repeatable on pendulum_simple") for line in lines(REPORT, known, "m:r"))


def test_json_and_junit_hold_every_row() -> None:
    found = json.loads(as_json(REPORT, {}, "m:r"))
    assert found["schema"] == 1
    counts = {"checked": 4, "passed": 3, "failed": 1, "known": 0, "not_applicable": 1, "not_checked": 0}
    assert (found["counts"], found["verdict"], found["gaps"]) == (counts, "failed", [])
    assert [row["outcome"] for row in found["rows"]] == ["passed", "passed", "failed", "passed", "not applicable"]
    suite = ElementTree.fromstring(as_junit(REPORT, {}, "m:r"))
    assert (suite.get("tests"), suite.get("failures"), suite.get("skipped")) == ("6", "1", "1")
    claims = ["follows", "error", "order", "repeatable", "symplectic"]
    assert [test.get("name") for test in suite.iter("testcase")] == [*claims, "verified"]
    assert ElementTree.fromstring(as_junit(REPORT, KNOWN, "m:r")).get("failures") == "0"


def test_no_file_is_green_where_a_claim_was_not_checked() -> None:
    """JUnit has errors, which no reader takes for skipped tests; Markdown and annotations name what is missing."""
    report = Report("m", "low", [FOLLOWED[0], CUT], more_seconds=12.0)
    suite = ElementTree.fromstring(as_junit(report, {}, "m:r"))
    assert (suite.get("errors"), len(list(suite.iter("error")))) == ("2", 2)
    assert json.loads(as_json(report, {}, "m:r"))["verdict"] == "not verified"
    assert "not verified: pendulum\\_simple" in as_markdown(report, {}, "m:r")
    (line,) = workflow_commands(report, {}, "m:r")
    assert line.startswith("::error title=gnomon::not verified: pendulum_simple")
    assert "1 not checked (about 12 s more): not verified" in lines(report, {}, "m:r")[-1]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("order pendulum_simple\n", "write CLAIM CASE REASON"),
        ("ordr pendulum_simple a reason\n", "no claim is called 'ordr'"),
        ("order a b\n# comment\n\norder a c\n", ":4: order a is listed twice"),
    ],
)
def test_a_file_of_known_failures_is_validated(text: str, told: str, tmp_path: Path) -> None:
    path = tmp_path / "known.txt"
    path.write_text(text)
    with pytest.raises(ValueError, match=told):
        read_known(path)


def test_a_right_method_passes_and_files_are_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = ("--json", str(tmp_path / "a.json"), "--junit", str(tmp_path / "a.xml"))
    assert gnomon("verify", "planted_methods:good_rk4", *ALONE, "step_order", *files) == 0
    assert "1 claims checked on 1 cases, 1 passed" in capsys.readouterr().out
    assert json.loads((tmp_path / "a.json").read_text())["integrator"] == "mine:RK4"
    root = ElementTree.parse(tmp_path / "a.xml").getroot()
    assert (root.get("tests"), root.get("errors")) == ("2", "0"), "the claim, and the verdict"


def test_a_fault_is_an_exit_code_of_1_unless_it_is_known(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    named = ("verify", "planted_methods:signed", *ALONE, "step_order")
    assert gnomon(*named) == 1
    shown = capsys.readouterr().out
    assert "FAILED step_order on pendulum_simple" in shown
    known = tmp_path / "known.txt"
    known.write_text("step_order pendulum_simple the sign of the last half step\n")
    assert gnomon(*named, "--known-failures", str(known)) == 0


def test_nothing_checked_is_an_exit_code_of_2(capsys: pytest.CaptureFixture[str]) -> None:
    assert gnomon("verify", "planted_methods:good_rk4", *ALONE, "symplectic") == 2
    assert "not verified: pendulum_simple: symplectic was not checked: it does not declare" in capsys.readouterr().out


def test_the_traceback_of_a_first_trial_is_shown_and_nothing_else_runs(capsys: pytest.CaptureFixture[str]) -> None:
    assert gnomon("verify", "planted_methods:broken", *ALONE, "order") == 1
    shown = capsys.readouterr()
    assert "NameError: name 'undefined' is not defined" in shown.err
    assert 'planted_methods.py", line ' in shown.err
    assert "trials.py" not in shown.err, "the frames of the harness are left out"
    assert shown.out == ""


@pytest.mark.parametrize(
    ("step", "told"),
    [
        (lambda f, t, y, h: None, "returned None: a step returns the state at t + h"),
        (lambda f, y, t, h: y + h * f(t, y), "f(t, y) takes arguments of shape () and (2,)"),
        (lambda f, t, y, h: y + h * f(t + h), "f(t, y) takes arguments of shape () and (2,)"),
    ],
)
def test_a_mistake_in_a_step_is_told_without_frames_of_the_harness(step: Any, told: str) -> None:
    with pytest.raises(FirstTrialError) as raised:
        verify(from_step(step, name="mistaken", order=1), ["pendulum_simple"], "low", ["runs"])
    assert told in str(raised.value).splitlines()[-1]
    assert "/harness/verification/" not in str(raised.value).replace(__file__, "")


def test_a_hang_and_a_crash_are_failures_of_their_claim(clock: Clock) -> None:
    """The claims after it are verified in a new process."""
    report = verify(planted_methods.ends_its_process, ["pendulum_simple"], "low", ["bad_start", "bad_setting"])
    by_claim = {row.claim: row.finding for row in report.rows}
    assert by_claim["bad_start"].outcome == Outcome.FAILED
    assert "exit code 7" in by_claim["bad_start"].got
    assert by_claim["bad_setting"].outcome == Outcome.PASSED
    with pytest.raises(FirstTrialError, match=f"no answer within {ASLEEP * CLAIM_SECONDS['low']:g} s, twice"):
        verify(planted_methods.hanging, ["pendulum_simple"], "low", ["runs"])
    hard = ["pendulum_simple/rotation"], "low", ["hard"]  # it may take longer, but not end its process
    assert [row.finding.outcome for row in verify(planted_methods.hanging, *hard).rows] == [Outcome.NOT_APPLICABLE]
    with pytest.raises(FirstTrialError, match="exit code 7"):
        verify(planted_right.waiting(1, lambda _: os._exit(7)), *hard)


def test_a_limit_is_processor_time_and_ten_times_that_for_what_sleeps(clock: Clock) -> None:
    """A busy machine makes a right method wait: the wait is not a fault. A method that only waits is ended too."""
    limit = CLAIM_SECONDS["low"]
    (row,) = verify(planted_right.waiting(4 * limit), ["pendulum_simple"], "low", ["repeatable"]).rows
    assert row.finding.outcome == Outcome.PASSED
    assert clock.now >= 8 * limit, "two solutions"
    waits = planted_right.waiting(1, lambda _: hang())
    with pytest.raises(FirstTrialError, match=f"no answer within {ASLEEP * limit:g} s, twice"):
        verify(waits, ["pendulum_simple"], "low", ["repeatable"])
    clock.burning = True
    with pytest.raises(FirstTrialError, match=f"no answer within {limit:g} s of processor time, twice"):
        verify(waits, ["pendulum_simple"], "low", ["repeatable"])


def test_what_has_no_answer_in_time_is_tried_once_more(clock: Clock, tmp_path: Path) -> None:
    """A method that hangs once, as on a machine that swaps, is right the second time."""

    def once(_seconds: float) -> None:
        if not (tmp_path / "been").exists():
            (tmp_path / "been").touch()
            hang()

    (row,) = verify(planted_right.waiting(1, once), ["pendulum_simple"], "low", ["repeatable"]).rows
    assert row.finding.outcome == Outcome.PASSED
    assert (tmp_path / "been").exists()


def test_a_named_case_that_the_integrator_cannot_take_is_refused() -> None:
    """It would be verified without equations."""
    with pytest.raises(ValueError, match="takes SecondOrder, which euler_top does not offer"):
        verify(planted_methods.good_verlet, ["euler_top"], "low")
