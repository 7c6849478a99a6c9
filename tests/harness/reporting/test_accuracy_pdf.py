"""The accuracy report: its pages, its text as data, and statements that the run carries."""

import json
import math
import re
from collections.abc import Iterable
from dataclasses import replace
from datetime import datetime
from html import escape
from pathlib import Path
from typing import Any

import pytest
import synthetic
from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.contract.status import Status
from gnomon.harness.reporting.pdf import provenance
from gnomon.harness.reporting.pdf.accuracy import contents, document, file_name, typeset, write_accuracy
from gnomon.harness.reporting.pdf.subject import Subject
from gnomon.harness.reporting.report_run import Run
from gnomon.harness.results import store
from gnomon.harness.results.summary import KINDS

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
def content(run: Path) -> dict[str, Any]:
    return contents(Subject.of(Run.read(run), METHOD), [run.parent])


@pytest.fixture(scope="module")
def pdf(run: Path) -> bytes:
    return write_accuracy(run, METHOD, run.parent / "one.pdf").read_bytes()


def pages(pdf: bytes) -> int:
    return len(re.findall(rb"/Type ?/Page\b", pdf))


def test_a_run_of_few_cases_has_six_pages_or_more_and_names_the_integrator(pdf: bytes) -> None:
    assert 6 <= pages(pdf) <= 10
    assert METHOD.encode() in pdf, "in the title, for programs that list documents"


def test_pages_are_numbered_in_their_order(content: dict[str, Any]) -> None:
    """A break that depends on its own page has no settled place: typst warns, and miscounts the pages."""
    _, warnings = document(content).compile_with_warnings()
    assert not warnings


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


def test_the_same_run_gives_the_same_bytes_with_its_own_date(run: Path, pdf: bytes, content: dict[str, Any]) -> None:
    started = store.runs(run)[0]["started"]
    date = re.sub(r"\D", "", started[:19])
    assert f"/CreationDate(D:{date}".encode() in pdf
    assert typeset(content, datetime.fromisoformat(started)) == pdf, "from another reading of the run"


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


def test_an_error_that_does_not_fall_has_no_order(run: Path) -> None:
    """Four equal errors lie on a line, of slope 0 without scatter: that is a finding, and no order."""
    read = Run.read(run)
    level = read.reduced.assign(**dict.fromkeys(KINDS, 1e-3))
    subject = Subject.of(replace(read, reduced=level), "gnomon:RK4")
    assert subject.cases["flat"].any()
    assert not (subject.cases["order"] <= subject.cases["margin"]).any()


def test_a_third_party_is_said_to_call_the_equations_as_its_library_declares() -> None:
    """Its ways are declared by patterns of names: each names a way that has words."""
    for library in LIBRARIES.values():
        assert set(library.calls.values()) <= set(provenance.CALLS)


def test_few_cases_have_no_median_and_what_is_missing_is_said(content: dict[str, Any]) -> None:
    """Three cases show nothing about others; certificates that do not lie beside the run are not claimed."""
    found = {part["title"]: part for part in content["chapters"]}
    (answer, *_) = found["Answer"]["parts"]
    assert not any("median of" in text and "cases with an ok setting" in text for text in answer["texts"])
    assert all(name in answer["texts"][0] for name in synthetic.CASES)
    assert "certificates.json" in found["Certificates of the exact motions"]["parts"][0]["texts"][0]


def test_certificates_and_checks_beside_the_run_are_stated(run: Path, tmp_path: Path) -> None:
    """Each with its number: the digits of the one motion that is certified, the error of the one check."""
    names = {"note": "", "variant": "default"}
    certified = {"case": next(iter(synthetic.CASES)), "ways": {"residual": 47.5}, "digits": 47.5, "passed": True}
    checked = {"check": "a_check", "computation": "solve", "library": "numpy", "reason": "", "quantity": "force"}
    (tmp_path / "certificates.json").write_text(json.dumps([certified | names]))
    (tmp_path / "checks.json").write_text(
        json.dumps([checked | {"variant": "default", "error": 2.5e-15, "seconds": 1e-5, "status": "ok"}])
    )
    said = json.dumps(provenance.chapters(Subject.of(Run.read(run), METHOD), [tmp_path])[0])
    assert "47.5" in said
    assert "2.5e-15 (a_check, force, by numpy)" in said


def test_a_file_name_is_plain_for_any_id() -> None:
    for name in (f"mine:{EVIL}", "..", "", "a/b", "C:\\x", "x" * 300):
        assert re.fullmatch(r"\w[\w.-]{0,79}", file_name(name)), name


def test_a_report_of_nothing_but_failures_says_so(run: Path) -> None:
    """No figure of errors, no digits, no time: each case is named with its failure."""
    read = Run.read(run)
    lost = read.reduced.assign(status=Status.DIVERGED, error_max=math.nan, seconds=math.nan)
    subject = Subject.of(replace(read, reduced=lost, frame=read.frame.assign(seconds_median=math.nan)), METHOD)
    content = contents(subject, [run.parent])
    found = {chapter["title"]: chapter["parts"] for chapter in content["chapters"]}
    assert found["Answer"][0]["texts"][0].count("diverged") == len(synthetic.CASES)
    assert 6 <= pages(typeset(content, datetime.fromisoformat("2026-01-01T00:00:00+00:00"))) <= 10
