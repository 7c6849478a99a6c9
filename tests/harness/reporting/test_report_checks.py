"""The report's rows on certificates and on the independent computations of checks."""

import json
import re
from pathlib import Path
from typing import Any

import pytest
from command_line import numbers_in
from gnomon.harness.reporting.report_checks import (
    certificate_rows,
    computation_rows,
    list_certificates,
    render_certificates,
)


def certificate(case: str, variant: str, digits: float, passed: bool = True) -> dict[str, Any]:
    ways = {"residual": 50.0, "taylor": digits}
    return {"case": case, "variant": variant, "ways": ways, "digits": digits, "passed": passed, "note": "a note"}


def measured(variant: str, quantity: str, error: float | None, status: str = "ok") -> dict[str, Any]:
    names = {"check": "moment_equipollent", "computation": "solve", "library": "numpy", "reason": "why <it> fails"}
    return names | {"variant": variant, "quantity": quantity, "error": error, "seconds": 2e-5, "status": status}


@pytest.fixture
def folders(tmp_path: Path) -> tuple[Path, Path]:
    published, results = tmp_path / "reports", tmp_path / "runs"
    for folder in (published, results):
        folder.mkdir()
    old = [
        certificate("pendulum_simple", "long_1e6", 49.96),
        certificate("pendulum_simple", "default", 3.0, passed=False),
        certificate("euler_top", "flat", 20.5, passed=False),
    ]
    (published / "certificates.json").write_text(json.dumps(old))
    (results / "certificates.json").write_text(json.dumps([certificate("pendulum_simple", "default", 48.0)]))
    rows = [
        measured("default", "force", 1e-16),
        measured("default", "moment", 2.5e-15),
        measured("parallel", "force", 0.3, "inaccurate"),
        measured("parallel", "moment", None, "diverged"),
    ]
    (results / "checks.json").write_text(json.dumps(rows))
    return results, published


def test_the_last_certificate_of_a_setting_counts_and_defaults_come_first(folders: tuple[Path, Path]) -> None:
    rows = certificate_rows(*folders)
    assert [(row["case"], row["variant"], row["digits"]) for row in rows] == [
        ("pendulum_simple", "default", 48.0),
        ("pendulum_simple", "long_1e6", 49.96),
        ("euler_top", "flat", 20.5),
    ]


def test_certificates_that_were_made_without_git_have_no_revision(folders: tuple[Path, Path]) -> None:
    without = certificate("pendulum_simple", "default", 47.0) | {"revision": None}
    (folders[0] / "certificates.json").write_text(json.dumps([without]))
    assert certificate_rows(*folders)[0]["digits"] == 47.0


def test_the_summary_counts_and_names_what_is_not_confirmed(folders: tuple[Path, Path]) -> None:
    lines = list_certificates(*folders)
    assert [numbers_in(line) for line in lines] == [["1", "1", "48.0"], ["1", "2", "20.5"], ["20.5"]]
    assert ["euler_top/flat" in line for line in lines] == [False, True, True]


def test_an_independent_computation_is_shown_by_its_worst_quantity_and_variant(folders: tuple[Path, Path]) -> None:
    (row,) = computation_rows(*folders)
    assert (row["default"], row["quantity"], row["time"]) == ("2.5e-15", "moment", "20.0 µs")
    assert (row["hard"], row["where"]) == ("diverged", "parallel, moment")


def test_the_page_never_rounds_digits_up_and_escapes(folders: tuple[Path, Path]) -> None:
    page = render_certificates(*folders)
    # 49.96 digits are 49
    assert "taylor 49, residual 50" in page
    assert "moment_<wbr>equipollent" in page, "a long name may break"
    assert "<it>" not in page


def test_without_measurements_there_are_no_lines(tmp_path: Path) -> None:
    assert not render_certificates(tmp_path, tmp_path).strip()
    assert list_certificates(tmp_path, tmp_path) == []


def test_a_certificate_that_fails_is_named_beside_the_count_of_those_confirmed(folders: tuple[Path, Path]) -> None:
    default, hard, *_ = re.findall(r"<summary>(.*?)</summary>", render_certificates(*folders), re.DOTALL)
    assert numbers_in(default) == ["1", "1", "48.0"]
    assert numbers_in(hard) == ["1", "2", "1", "20.5"], "one of two, one not"
    assert "euler_top/flat" in hard
