"""`gnomon history`: a table and a figure of numbers over publications."""

from pathlib import Path

import pytest
from command_line import gnomon
from gnomon.harness.commands.published.history import specification
from gnomon.harness.results import publications
from gnomon.harness.results.publications import Entry


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "history.json"
    for sources, machine, number in (("a", "old", 5.0), ("b", "new", 7.0), ("c", "new", 9.0)):
        made_by = {"sources": sources, "machine": machine, "revision": f"{sources}" * 12, "date": "2026-01-02"}
        numbers = {f"digits/x:{k}": number + k for k in range(8)} | {"seconds_1e-6/y/x:0": number / 1000}
        publications.append(path, Entry(made_by, numbers))
    return path


def test_every_publication_has_a_column_and_times_of_another_machine_are_left_out(
    file: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    assert gnomon("history", "digits/x:0", "seconds*", "--from", str(file)) == 0
    told = capfd.readouterr()
    rows = {line.split()[0]: line.split()[1:] for line in told.out.splitlines() if "/" in line}
    assert rows == {"digits/x:0": ["5", "7", "9"], "seconds_1e-6/y/x:0": ["–", "0.007", "0.009"]}
    assert told.err.startswith("1 times of other machines")


def test_without_a_name_the_kinds_of_numbers_are_listed(file: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert gnomon("history", "--from", str(file)) == 0
    told = capfd.readouterr().out
    assert "digits/x:0" in told
    assert "3 publications" in told


def test_a_figure_has_a_line_for_each_number_over_all_publications(file: Path, tmp_path: Path) -> None:
    picture = tmp_path / "h.svg"
    assert gnomon("history", "digits/x:0", "digits/x:1", "--from", str(file), "--out", str(picture)) == 0
    assert picture.read_text().startswith("<svg")
    entries = publications.read(file)
    drawn = specification(entries, {"seconds_1e-6/y/x:0": publications.values(entries, "seconds_1e-6/y/x:0")})
    assert [point["value"] for point in drawn["datasets"]["history"]] == [0.007, 0.009]
    assert len(drawn["encoding"]["x"]["scale"]["domain"]) == len(entries), (
        "a publication without the number has its place"
    )


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["digits/x:0"], ("nowhere.json", "make publication")),
        (["nothing", "--from", "history.json"], ("'nothing'",)),
        (["--from", "history.json", "--out", "h.svg"], ("h.svg", "name the numbers")),
        (["digits/*", "--from", "history.json", "--out", "h.svg"], ("h.svg", "8 numbers")),
        (["digits/x:0", "--from", "history.json", "--out", "h.txt"], ("h.txt", ".svg")),
    ],
)
def test_bad_input_is_told_in_one_line(
    file: Path, arguments: list[str], words: tuple[str, ...], monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    monkeypatch.chdir(file.parent)
    assert gnomon("history", *(arguments if "--from" in arguments else [*arguments, "--from", "nowhere.json"])) == 2
    (line,) = capfd.readouterr().err.splitlines()
    assert all(word in line for word in words)
    assert not Path("h.svg").exists()
