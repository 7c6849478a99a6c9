"""A shell completes the names of cases and integrators. Bash gets the text after the last colon, zsh and fish whole words."""

import re
import subprocess
import sys
from pathlib import Path

import platformdirs
import pytest
from command_line import gnomon
from gnomon.harness.registry import completion, lookup

from gnomon import cases


@pytest.fixture
def completed(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    """A function that gives the answer to words as bash divides them, of which the last one is incomplete."""

    def ask(*words: str) -> list[str]:
        monkeypatch.setenv("_GNOMON_COMPLETE", "complete_bash")
        monkeypatch.setenv("COMP_WORDS", "\n".join(["gnomon", *words]))
        monkeypatch.setenv("COMP_CWORD", str(len(words)))
        assert gnomon() == 0
        return [line for line in capsys.readouterr().out.splitlines() if line]

    return ask


@pytest.mark.parametrize(
    "before",
    [
        *(("show",), ("exact",), ("scene",), ("certify",), ("run", "--case"), ("check", "a.csv", "--case")),
        *(("ensemble", "--case"), ("verify", "--case"), ("baseline", "write", "--case"), ("show", "--case")),
    ],
)
def test_cases_are_completed(completed, before: tuple[str, ...]) -> None:
    assert "kepler_orbit" in completed(*before, "kepler")
    variants = {f"kepler_orbit/{one.name}" for one in cases.case_class("kepler_orbit").variants}
    assert {*completed(*before, "kepler_orbit/")} == variants | {"kepler_orbit/default"}
    assert not completed(*before, "no_such_case")


@pytest.mark.parametrize("command", ["show", "certify"])
def test_a_command_that_takes_checks_completes_them(completed, command: str) -> None:
    assert completed(command, "capstan") == ["capstan_belt"]


@pytest.mark.parametrize(
    "before",
    [
        *(("verify",), ("verify", "--integrator"), ("run", "--integrator"), ("baseline", "write"), ("stability",)),
        *(("ensemble", "--integrator"), ("stability", "--integrator"), ("baseline", "write", "--integrator")),
    ],
)
def test_integrators_are_completed(completed, before: tuple[str, ...]) -> None:
    """After a colon, by which bash divides words, and before one."""
    libraries = {name.partition(":")[0] for name in lookup.own()}
    assert {word.partition(":")[0] for word in completed(*before, "")} >= libraries
    assert completed(*before, "gnomon", ":", "RKMK") == [r"RKMK\ 4"]
    assert completed(*before, "gnomon", ":", r"DOP853\ ") == [r"DOP853\ \[events\]"]
    assert completed(*before, "'gnomon:RKMK") == ["gnomon:RKMK 4"], "in quotes a word is whole"


def test_bash_divides_an_option_and_its_value(completed) -> None:
    assert completed("run", "--integrator", "=", "gnomon", ":", "RKMK") == [r"RKMK\ 4"]
    assert "kepler_orbit" in completed("run", "--case", "=")


@pytest.mark.parametrize("shell", ["zsh", "fish"])
@pytest.mark.parametrize(
    ("words", "ids"),
    [
        ("verify scipy:ode\\ d", {"scipy:ode dop853"}),
        *(
            (f"verify {word}", {"gnomon:DOP853 [events]"})
            for word in (r"gnomon:DOP853\ ", "'gnomon:DOP853 ", '"gnomon:DOP853 ')
        ),
        ("verify kepler", set()),
        ("run --integrator gnomon:RK4 ", set()),  # the next word is another argument
        ("run --integrator=gnomon:RKMK", {"--integrator=gnomon:RKMK 4"}),
        ("run --integrator='scipy:ode d", {"--integrator=scipy:ode dop853"}),
    ],
)
def test_zsh_and_fish_get_whole_words(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], shell: str, words: str, ids: set[str]
) -> None:
    """They send the line as it is typed, where a space with a backslash or in open quotes belongs to the word."""
    monkeypatch.setenv("_GNOMON_COMPLETE", f"complete_{shell}")
    monkeypatch.setenv("_TYPER_COMPLETE_FISH_ACTION", "get-args")
    monkeypatch.setenv("_TYPER_COMPLETE_ARGS", f"gnomon {words}")
    assert gnomon() == 0
    answer = capsys.readouterr().out.replace(r"\\:", ":")  # zsh reads a bare colon as the start of a description
    known = {option + name for name in lookup.everything() for option in ("", "--integrator=")}
    assert {word for word in known if re.search(rf'(^|"){re.escape(word)}("|$)', answer, re.M)} == ids


def test_names_are_completed_without_the_modules_that_hold_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Who presses a key waits for the answer: numpy alone would double the time. The ids are kept from the first time."""
    monkeypatch.setattr(platformdirs, "user_cache_dir", lambda name: str(tmp_path / name))
    assert completion.list_ids() == [*lookup.everything()]
    program = f"""
import sys, platformdirs
platformdirs.user_cache_dir = lambda name: {str(tmp_path)!r} + "/" + name
from gnomon.harness.registry import completion
assert completion.complete_integrator("gnomon:RK4") and completion.complete_case("kepler") and completion.complete_subject("cap")
print(*sys.modules)
"""
    loaded = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout.split()
    assert not {"numpy", "scipy", "numba", "gnomon.harness.registry.lookup"} & {*loaded}


def test_kept_ids_follow_an_edit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source = tmp_path / "integrators" / "mine.py"
    source.parent.mkdir()
    source.touch()
    monkeypatch.setattr(platformdirs, "user_cache_dir", lambda name: str(tmp_path / name))
    monkeypatch.setattr(completion, "HARNESS", tmp_path)
    monkeypatch.setattr(lookup, "everything", lambda: {"mine:one": None})
    assert completion.list_ids() == ["mine:one"]
    monkeypatch.setattr(lookup, "everything", lambda: {"mine:two": None})
    assert completion.list_ids() == ["mine:one"], "kept"
    source.with_name("other.py").touch()
    assert completion.list_ids() == ["mine:two"]
