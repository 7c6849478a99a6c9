"""The documents are right: Python in docs/ runs, commands exist and run, pages are in the contents, paths exist."""

import json
import linecache
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from command_line import gnomon
from gnomon.harness.verification.claims import Outcome
from recipes import read_recipes

ROOT = Path(__file__).parent.parent
PAGES = sorted((ROOT / "docs").rglob("*.md"))
MEASURES = re.compile(r"^(.*gnomon\.compare\(.*|print\(found[.)].*)$", re.M)
"""Lines that measure for half a minute: only `make test-all` runs them."""
DOCUMENTS = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "SECURITY.md", *PAGES]
PATHS = re.compile(r"`((?:reference|cases|harness|tests|docs|src)/[a-z0-9_./*]*)`")


def _blocks(page: Path, language: str) -> list[str]:
    blocks = re.findall(r"^```(\w*)\n(.*?)^```$", page.read_text(), re.M | re.S)
    return [text for named, text in blocks if named == language]


def _commands(page: Path) -> list[list[str]]:
    lines = "\n".join(_blocks(page, "")).splitlines()
    return [shlex.split(line, comments=True) for line in lines if line.startswith("gnomon ")]


def _run(page: Path, leave_out: re.Pattern[str] | None = None) -> None:
    names: dict[str, object] = {"__name__": "page"}
    for number, block in enumerate(_blocks(page, "python")):
        text, file = leave_out.sub("", block) if leave_out else block, f"<{page.name}, block {number}>"
        # As a notebook does with its cells: equations are compiled from their source text.
        linecache.cache[file] = len(text), None, text.splitlines(keepends=True), file
        exec(compile(text, file, "exec", dont_inherit=True), names)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_the_python_of_a_page_runs(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The first block of docs/verify.md is a file, which a later one imports."""
    (tmp_path / "mine.py").write_text(_blocks(ROOT / "docs" / "verify.md", "python")[0])
    monkeypatch.syspath_prepend(tmp_path)
    _run(page, MEASURES)


@pytest.mark.slow
def test_the_lines_that_measure_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "mine.py").write_text(_blocks(ROOT / "docs" / "verify.md", "python")[0])
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.chdir(tmp_path)
    for page in PAGES:
        _run(page)


@pytest.mark.parametrize("cells", [4, pytest.param(None, marks=pytest.mark.slow)], ids=["first cells", "all cells"])
def test_the_quick_start_runs(cells: int | None, capsys: pytest.CaptureFixture[str]) -> None:
    """As a notebook runs it, and what it is to show is true: the motion, a comparison, a right and a wrong integrator."""
    notebook = json.loads((ROOT / "docs" / "quickstart.ipynb").read_text(encoding="utf-8"))
    names: dict[str, Any] = {"__name__": "notebook"}
    for number, cell in enumerate(notebook["cells"][:cells]):
        if cell["cell_type"] == "code":
            text, file = "".join(cell["source"]), f"<quick start, cell {number}>"
            linecache.cache[file] = len(text), None, text.splitlines(keepends=True), file
            exec(compile(text, file, "exec", dont_inherit=True), names)
    assert str(names["pendulum"].exact(1.5, 30)) in capsys.readouterr().out
    if cells is None:
        assert names["found"].times("gnomon:DOP853")["pendulum_simple"][1e-9] > 0
        assert names["found"].plot().to_dict()
        assert names["report"].of(Outcome.FAILED)


def test_the_case_of_a_page_is_certified_and_a_wrong_sign_in_it_is_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The page tells its reader to see both."""
    monkeypatch.syspath_prepend(tmp_path)
    source = _blocks(ROOT / "docs" / "own_case.md", "python")[0]
    wrong = source.replace("c * sine + s * cosine", "c * sine - s * cosine")
    assert wrong != source
    for name, text, code in (("morse", source, 0), ("wrong_morse", wrong, 1)):
        (tmp_path / f"{name}.py").write_text(text)
        assert gnomon("certify", f"{name}:Morse", "--out", str(tmp_path / "certificates.json")) == code


@pytest.mark.slow
def test_the_commands_of_the_pages_run(tmp_path: Path) -> None:
    """Unchanged, in the order of the contents, but for the reader's `mypackage`; a page's integrator has its page's name."""
    (tmp_path / "midpoint.py").write_text(_blocks(ROOT / "docs" / "integrator.md", "python")[0])
    (tmp_path / "mine.py").write_text(_blocks(ROOT / "docs" / "verify.md", "python")[0])
    (tmp_path / "morse.py").write_text(_blocks(ROOT / "docs" / "own_case.md", "python")[0])
    (tmp_path / "pendulums.py").write_text(_blocks(ROOT / "docs" / "compare.md", "python")[0])
    (tmp_path / "toy_engine.py").write_text(_blocks(ROOT / "docs" / "engine.md", "python")[0])
    commands = [words for page in PAGES for words in _commands(page) if not any("mypackage" in word for word in words)]
    assert commands
    for words in commands:
        command = [str(Path(sys.executable).parent / words[0]), *words[1:]]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr


def test_every_page_is_in_the_contents() -> None:
    """The navigation shows no other pages."""
    listed = set(re.findall(r": ([\w/]+\.md)$", (ROOT / "mkdocs.yml").read_text(), re.M))
    assert listed == {page.relative_to(ROOT / "docs").as_posix() for page in PAGES}


def test_every_command_is_described() -> None:
    """The table of commands is complete."""
    from gnomon.harness.commands import cli

    described = set(re.findall(r"^\| `gnomon (\w+)", (ROOT / "docs" / "commands.md").read_text(), re.M))
    names = {command.name or command.callback.__name__ for command in cli.app.registered_commands if command.callback}
    names |= {group.name for group in cli.app.registered_groups}
    assert described == names


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda document: document.stem)
def test_the_paths_of_a_document_exist(document: Path) -> None:
    """Files move; their names in texts move with them. A recipe names files that its reader writes."""
    written = {path for recipe in read_recipes() for path in recipe.files} if document.stem == "CONTRIBUTING" else set()
    missing = [path for path in PATHS.findall(document.read_text()) if not list(ROOT.glob(path.rstrip("/")))]
    assert {*missing} <= written


def test_the_folders_of_contributing_are_those_of_the_project() -> None:
    """Every folder of `harness`, `cases` and `reference` is named in the section "Folders"."""
    (text,) = re.findall(r"## Folders\n(.*?)\n## ", (ROOT / "CONTRIBUTING.md").read_text(), re.S)
    named = set(re.findall(r"(\w+)/", text))
    folders = {file.parent.name for top in ("harness", "cases", "reference") for file in (ROOT / top).glob("*/*.py")}
    assert folders <= named
