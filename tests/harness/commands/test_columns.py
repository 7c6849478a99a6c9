"""Tables and answers that are not on a terminal have the columns that COLUMNS says; the answer of `gnomon engine` has 100."""

import ast
from textwrap import dedent

import pytest
from command_line import gnomon
from gnomon.harness.results.advice import engine_facts

LEAGUE = engine_facts.read()
ENGINES = [*dict.fromkeys(one["library"] for one in LEAGUE["engines"])]


@pytest.mark.parametrize("command", ["scene --list", "list integrators gnomon:*8*"])
@pytest.mark.parametrize("columns", [70, 130])
def test_a_table_has_the_columns_of_the_environment(
    command: str, columns: int, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """A CI log or a pager says by COLUMNS how wide it is; without it names are shown whole."""
    monkeypatch.setenv("COLUMNS", str(columns))
    assert gnomon(*command.split()) == 0
    table, _, _ = capfd.readouterr().out.partition("Next:")
    assert max(map(len, table.splitlines())) <= columns
    monkeypatch.delenv("COLUMNS")
    assert gnomon(*command.split()) == 0
    assert "…" not in capfd.readouterr().out


@pytest.mark.parametrize("name", ENGINES)
def test_the_answer_on_an_engine_fits_100_columns_and_keeps_its_code(
    name: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """Lines of code are copied into a program: they stay code, and a comment without a place comes before its line."""
    monkeypatch.delenv("COLUMNS", raising=False)
    assert gnomon("engine", name) == 0
    text = capfd.readouterr().out
    assert max(map(len, text.splitlines())) <= 100
    shown = text.partition("set:\n")[2].partition("\n\n")[0]
    assert ast.unparse(ast.parse(dedent(shown))) == ast.unparse(ast.parse("\n".join(LEAGUE["lines"].get(name, ()))))
