"""The accuracy report: its pages, its text as data, and statements that the run carries."""

import math
import re
from collections.abc import Iterable
from dataclasses import replace
from datetime import datetime
from html import escape
from pathlib import Path

import pytest
import synthetic
from gnomon.harness.contract.status import Status
from gnomon.harness.reporting.pdf.accuracy import contents, file_name, typeset, write_accuracy
from gnomon.harness.reporting.pdf.subject import Subject
from gnomon.harness.reporting.report_run import Run
from gnomon.harness.results import store

METHOD = "gnomon:DOP853"
EVIL = '../b *b* #panic("owned") $x$ <l> @r [c] `r` \\ #import "@preview/a:1.0.0" <script>alert(1)</script>'
MANY = 126
"""The number of cases of the catalogue that move."""


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return synthetic.write(tmp_path_factory.mktemp("run") / "run.sqlite")


def invented(path: Path, name: str, cases: Iterable[str]) -> Path:
    """A run of one integrator on the default variants of these cases."""
    several = {case: (case, "7.10", 2, ("default",)) for case in cases}
    return synthetic.write(path, several, (("mine", name, "", 8, "tolerance", 20e-9, ""),))


@pytest.fixture(scope="module")
def pdf(run: Path) -> bytes:
    return write_accuracy(run, METHOD, run.parent / "one.pdf").read_bytes()


def pages(pdf: bytes) -> int:
    return len(re.findall(rb"/Type ?/Page\b", pdf))


def test_a_run_of_few_cases_has_six_pages_or_more_and_names_the_integrator(pdf: bytes) -> None:
    assert 6 <= pages(pdf) <= 10
    assert METHOD.encode() in pdf, "in the title, for programs that list documents"


def test_names_are_text_also_on_one_case(tmp_path: Path) -> None:
    """Names that a typesetter would run, fetch or open as a file appear as they are; the file stays in its folder."""
    folder = tmp_path / "deep" / "er"
    written = write_accuracy(invented(tmp_path / "run.sqlite", EVIL, [EVIL]), f"mine:{EVIL}", folder)
    assert written.parent == folder
    found = written.read_bytes()
    assert 6 <= pages(found) <= 10
    assert escape(f"mine:{EVIL}"[:60], quote=False).encode() in found.replace(b"&quot;", b'"')
    assert b"/URI" not in found, "no link is made of the text of a run"


@pytest.mark.slow
def test_as_many_cases_as_the_catalogue_has_fit_on_ten_pages(tmp_path: Path) -> None:
    path = invented(
        tmp_path / "run.sqlite", "DOP853", [f"case_{place}_with_a_name_of_many_words" for place in range(MANY)]
    )
    assert 6 <= pages(write_accuracy(path, "mine:DOP853", tmp_path / "many.pdf").read_bytes()) <= 10


def test_the_same_run_gives_the_same_bytes_with_its_own_date(run: Path, pdf: bytes) -> None:
    started = re.sub(r"\D", "", store.runs(run)[0]["started"][:19])
    assert f"/CreationDate(D:{started}".encode() in pdf
    assert write_accuracy(run, METHOD, run.parent / "two.pdf").read_bytes() == pdf


@pytest.mark.parametrize("name", ["gnomon:DOP855", "multibody", ""])
def test_an_integrator_without_one_result_is_refused_with_those_present(run: Path, name: str, tmp_path: Path) -> None:
    """A name of several integrators too: `multibody` has two policies."""
    with pytest.raises(ValueError, match=re.escape("pybullet:multibody [as shipped]")):
        write_accuracy(run, name, tmp_path / "new")
    assert not (tmp_path / "new").exists()


def test_no_digits_beyond_the_floor(run: Path) -> None:
    """An error of zero is known to the rounding of the exact states alone."""
    subject = Subject.of(Run.read(run), "gnomon:RK4")
    assert (10 ** -subject.cases["digits"] >= synthetic.FLOOR * (1 - 1e-9)).all()
    assert subject.cases.loc["bouncing_ball", "at_floor"]


def test_few_cases_have_no_median_and_what_is_missing_is_said(run: Path) -> None:
    """Three cases show nothing about others; certificates that do not lie beside the run are not claimed."""
    found = {part["title"]: part for part in contents(Subject.of(Run.read(run), METHOD), [run.parent])["chapters"]}
    (answer, *_) = found["Answer"]["parts"]
    assert not any("median of" in text and "cases with an ok setting" in text for text in answer["texts"])
    assert all(name in answer["texts"][0] for name in synthetic.CASES)
    assert "No certificate" in found["Certificates of the exact motions"]["parts"][0]["texts"][0]


def test_a_file_name_is_plain_for_any_id() -> None:
    for name in (f"mine:{EVIL}", "..", "", "a/b", "C:\\x", "x" * 300):
        assert re.fullmatch(r"\w[\w.-]{0,79}", file_name(name)), name


def test_a_report_of_nothing_but_failures_says_so(run: Path) -> None:
    """No figure of errors, no digits, no time: each case is named with its failure."""
    read = Run.read(run)
    lost = read.reduced.assign(status=Status.DIVERGED, error_max=math.nan, seconds=math.nan)
    subject = Subject.of(replace(read, reduced=lost, timed=read.timed.iloc[:0]), METHOD)
    content = contents(subject, [run.parent])
    found = {chapter["title"]: chapter["parts"] for chapter in content["chapters"]}
    assert found["Answer"][0]["texts"][0].count("diverged") == len(synthetic.CASES)
    assert 6 <= pages(typeset(content, datetime.fromisoformat("2026-01-01T00:00:00+00:00"))) <= 10
