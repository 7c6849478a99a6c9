"""Texts of others on a terminal and in the log of a workflow: shown, without steering either, in any encoding."""

import io
import json
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest
from command_line import gnomon
from gnomon.harness.commands.options import Shown
from gnomon.harness.commands.stability import panel_table
from gnomon.harness.registry import environment
from gnomon.harness.results.visible import visible
from gnomon.harness.stability import panel_run
from gnomon.harness.stability.panel_run import Row
from gnomon.harness.verification import claim_tests
from gnomon.harness.verification.claims import fail_claim, not_applicable
from hypothesis import given
from hypothesis import strategies as st
from planted_texts import MESSAGE
from rich.markup import escape
from rich.table import Table
from waiting import LONG_SECONDS

CASE = ("--case", "planted:Short")
QUICK = ("--suite", "quick", "--limit", str(LONG_SECONDS), *CASE, "--integrator")


def commands(text: str) -> list[str]:
    """The lines that the runner of GitHub Actions takes for commands, of any name: actions/runner,
    src/Runner.Common/ActionCommand.cs."""
    found = []
    for line in text.replace("\r", "\n").split("\n"):
        _, mark, rest = line.partition("##[")
        start = line.lstrip()
        if (start.startswith("::") and "::" in start[2:]) or (mark and "]" in rest):
            found.append(line)
    return found


def is_harmless(text: str) -> bool:
    return visible(text, lines=True) == text and not commands(text)


@pytest.fixture
def workflow(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GITHUB_ACTIONS", "true")


def printed(width: int, *texts: str) -> str:
    """Texts on a console: each by itself, and together as the cells of a table, whose columns wrap them."""
    written = io.StringIO()
    console = Shown(file=written, width=width, soft_wrap=True, emoji=False)
    table = Table(*map(escape, texts), title=escape(texts[0]))
    table.add_row(*map(escape, texts))
    table.add_row("", *map(escape, texts[1:]))
    for text in texts:
        console.print(escape(text))
    console.print(table)
    return written.getvalue()


PIECES = st.lists(
    st.sampled_from(
        ["::", ":", "error", "##", "#", "[", "]", "[error]", "\\", "\x1b[31m", "\x9b", "\n", "\r", " ", "word ", "[/]"]
    ),
    max_size=12,
).map("".join)


def test_what_the_runner_takes_for_a_command() -> None:
    assert commands("a\n::error::b\r\t::x y=z::\n a ##[error]b") == ["::error::b", "\t::x y=z::", " a ##[error]b"]
    assert commands("a ::error::b\n::c\n##[d") == []
    assert not is_harmless(MESSAGE)


@given(PIECES, PIECES, st.sampled_from([12, 30, 200]))
def test_no_text_on_a_console_steers_the_terminal_or_the_log(first: str, second: str, width: int) -> None:
    """In a table a text begins a line where the cells before it are empty, or where a column wraps it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("GITHUB_ACTIONS", "true")
        assert is_harmless(printed(width, first, second))


def test_the_message_is_shown_and_elsewhere_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("GITHUB_ACTIONS", raising=False)
    text = printed(200, "std::vector ##[x] λ")
    assert text.count("std::vector ##[x] λ") == 4
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    assert "stolen" in printed(200, MESSAGE)


@pytest.mark.usefixtures("workflow")
@pytest.mark.parametrize("command", ["run", "verify", "stability"])
def test_the_message_of_an_integrator_is_harmless(
    command: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """In the traceback of a first trial, and as the reason why a panel was not measured."""
    lines = {
        "run": ("run", *QUICK, "planted_texts:RaisesText", "--out", str(tmp_path / "a.sqlite")),
        "verify": ("verify", "planted_texts:RaisesText", *CASE, "--claim", "order"),
        "stability": ("stability", "--integrator", "planted_texts:RaisesText", "--panel", "stiffness"),
    }
    assert gnomon(*lines[command]) in (1, 2)
    captured = capfd.readouterr()
    assert "stolen" in captured.out + captured.err, "it is shown"
    assert is_harmless(captured.out)
    assert is_harmless(captured.err)


@pytest.mark.usefixtures("workflow")
@pytest.mark.parametrize("finding", [fail_claim(MESSAGE, MESSAGE, MESSAGE, MESSAGE), not_applicable(MESSAGE)])
def test_a_test_of_a_claim_has_a_harmless_message(finding: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """pytest prints it as it is."""

    class Planted:
        def check(self, trials: Any) -> Any:
            return finding

    monkeypatch.setattr(claim_tests, "CLAIMS", {"order": Planted()})
    monkeypatch.setattr(claim_tests, "_trials", lambda *given: None)
    from gnomon.harness.registry.lookup import own
    from planted import Short

    check = claim_tests.ClaimTest(own()["gnomon:RK4"], Short(), "order", claim_tests.DEPTHS["low"], "m:r")
    with pytest.raises(BaseException, match="stolen") as raised:  # AssertionError, or pytest's own of a skipped test
        check()
    assert is_harmless(str(raised.value))
    (mark,) = check.marks({check.key: MESSAGE})
    assert is_harmless(mark.kwargs["reason"])


class Ascii:
    """Standard output of a system whose encoding is ASCII."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.bytes = io.BytesIO()
        self.stream = io.TextIOWrapper(self.bytes, encoding="ascii", write_through=True)
        monkeypatch.setattr(sys, "stdout", self.stream)

    def text(self) -> str:
        self.stream.flush()
        return self.bytes.getvalue().decode("ascii")


@pytest.mark.parametrize(
    ("arguments", "shown"),
    [
        (("list",), "Integrators"),
        (("show", "pendulum_simple"), "pendulum_simple"),
        (("doctor",), "Environment"),
        (("exact", "pendulum_simple", "--times", "1", "--digits", "20"), "sha256"),
    ],
)
def test_a_command_writes_in_an_encoding_without_its_characters(
    arguments: tuple[str, ...], shown: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    stdout = Ascii(monkeypatch)
    assert gnomon(*arguments) == 0
    assert shown in stdout.text()


@pytest.mark.usefixtures("workflow")
def test_a_run_is_summarized_in_an_encoding_without_its_characters(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """All trials were recorded, and then the run ended with an error and without its summary."""
    stdout = Ascii(monkeypatch)
    path = tmp_path / "ergebnis_ü.sqlite"
    assert gnomon("run", *QUICK, "planted_texts:RaisesTextAtSmallSteps", "--out", str(path)) == 0
    text = stdout.text()
    assert "raises text at small steps" in text
    assert "stolen" in text, "the reason of a crash"
    assert "ergebnis_?.sqlite" in text
    assert is_harmless(text)
    assert is_harmless(capfd.readouterr().err)


ROW = asdict(Row("gnomon:RK4", "linear", 1.0, {"refused": "planted"}, []))
DEEP = "[" * 2000 + "]" * 2000
CHANGED: dict[str, Any] = {
    "null": {"data": None},
    "a number": {"data": 7},
    "empty": {"data": {}},
    "a list": {"data": []},
    "another shape": {"data": {"imaginary": None, "real": [1]}},
    "nan": {"data": {"refused": float("nan")}},
    "infinite": {"seconds": float("inf")},
    "no seconds": {"seconds": float("nan"), "data": {"refused": "planted"}},
}


def with_rows(file: Path, *rows: Any) -> bytes:
    """A file of `gnomon stability` with these rows."""
    whole = json.loads(panel_run.as_json([], "normal"))
    file.write_text(json.dumps(whole | {"environment": environment.describe(), "rows": rows}))
    return file.read_bytes()


@pytest.fixture
def resumed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A file to resume from, where nothing may be measured."""

    def measures(*given: Any, former: list[Row], **named: Any) -> list[Row]:
        assert all((row.integrator, row.panel) == ("gnomon:RK4", "linear") for row in former)
        return list(former)

    monkeypatch.setattr(panel_run, "measure_panels", measures)
    return tmp_path / "stability.json"


def resume(file: Path) -> int:
    return gnomon("stability", "--integrator", "gnomon:RK4", "--panel", "linear", "--out", str(file))


@pytest.mark.parametrize("change", CHANGED)
def test_a_stability_file_with_other_data_is_refused_and_stays(
    change: str, resumed: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """One line that names the file: a traceback came after the file was written anew, or when it was to be written."""
    before = with_rows(resumed, ROW, ROW | {"integrator": "gnomon:Heun"} | CHANGED[change])
    assert resume(resumed) == 2
    (line,) = capfd.readouterr().err.splitlines()
    assert line.startswith(f"error: {resumed}: no result of `gnomon stability`")
    assert line.endswith("name another file with --out")
    assert resumed.read_bytes() == before


@pytest.mark.usefixtures("workflow")
def test_texts_of_a_stability_file_are_harmless(resumed: Path, capfd: pytest.CaptureFixture[str]) -> None:
    with_rows(resumed, ROW | {"data": {"refused": MESSAGE}, "sentences": [MESSAGE], "marks": [{"text": None}]})
    assert resume(resumed) == 2, "nothing was measured"
    captured = capfd.readouterr()
    assert "stolen" in captured.out
    assert is_harmless(captured.out)
    (row,) = json.loads(resumed.read_text())["rows"]
    assert (row["sentences"], row["marks"]) == ([], []), "sentences and marks that do not follow from data are not kept"


@pytest.mark.usefixtures("workflow")
def test_sentences_are_harmless_in_a_table() -> None:
    written = io.StringIO()
    console = Shown(file=written, width=60, emoji=False)
    console.print(panel_table("Linear stability", [Row(MESSAGE, "linear", 1.0, {}, [MESSAGE, "::error::x"])]))
    assert written.getvalue().count("stolen") >= 2
    assert is_harmless(written.getvalue())
