"""The numbers of the README, of its figure and of pages it leads to agree with published reports, code and licences."""

import json
import math
import re
import tomllib
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, files, metadata
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from gnomon.cases import get
from gnomon.cases.core.sampling import SAMPLES
from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.reporting import live_page, sidecars, style
from gnomon.harness.running import plan
from page_parts import carried

README = Path(__file__).parent.parent / "README.md"
REPORTS = README.parent / "reports"
FIGURE = REPORTS / "figures" / "pendulum_simple.svg"
DETAILS = [README.parent / "docs" / name for name in ("install.md", "stability.md", "theory/errors.md")]

NUMBERS = {"release": 2.0, "g": 9.81, "length": 1.0}
"""Parameters and start of the pendulum in the figure, which is released at rest."""


def _text() -> str:
    """The README and the pages with its details, on one line."""
    return " ".join(word for page in (README, *DETAILS) for word in page.read_text().split())


def _match(pattern: str) -> tuple[str, ...]:
    """The groups of a pattern that the README or a page with its details must match."""
    found = re.search(pattern, _text())
    assert found is not None, pattern
    return found.groups()


def test_the_findings_of_verification_in_the_readme_were_measured() -> None:
    measured = json.loads((REPORTS / "verification.json").read_text())
    said = r"normal found (\d+) of (\d+) faults .*? \(95 % interval (\d+) to (\d+) %\) and (\d+) of (\d+) defects"
    found, of, low, high, defects, of_defects = map(int, _match(said))
    assert (found, of) == (measured["mutants"]["found"], measured["mutants"]["of"])
    assert [low, high] == [round(100 * share) for share in measured["mutants"]["interval"]]
    assert (defects, of_defects) == (measured["defects"]["found"], measured["defects"]["of"])
    runs, alarms = map(int, _match(r"In (\d+) runs of right integrators .*? it gave (\d+) false alarms"))
    assert runs == sum(measured["right_runs"].values())
    assert alarms == len(measured["false_alarms"])


def test_the_findings_about_libraries_are_those_of_the_summary() -> None:
    """Libraries in the order of README; the summary gives each its count and its time in the same words."""
    summary = (REPORTS / "summary.md").read_text()
    (counts,) = _match(r"reached an error of 1e-6 within the time limit of a trial: (.*?)\. ")
    found = re.findall(r"(\w+) on (\d+ of \d+)", counts)
    (times,) = _match(r"A simple pendulum to 1e-6 takes (.*?)\. ")
    found_times = re.findall(r"(\w+ \w+) ([\d.]+ [mµ]s)", times)
    assert len(found) > 3
    assert len(found_times) > 3
    for library, count in found:
        assert f"{library} on {count}" in summary
    for method, time in found_times:
        assert f" {method} {time}" in summary


def test_the_shares_outside_of_the_catalogue_were_measured() -> None:
    measured = json.loads((REPORTS / "outside.json").read_text())
    said = r"on (\d+) systems drawn at random.*? in (\d+) % .*?\(95 % interval (\d+) to (\d+) %\).*? in (\d+) % \((\d+) to (\d+) %\)"
    drawn, *shares = map(int, _match(said))
    assert drawn == measured["drawn"]
    found = [measured[name][part] for name in ("share", "order") for part in ("share", "low", "high")]
    assert shares == [round(100 * one) for one in found]


def test_documents_name_one_interval_of_the_page() -> None:
    """From one page to the next are EVERY_SECONDS, the end of the trials under way, and the writing."""
    assert 60 < live_page.EVERY_SECONDS < 120
    for name in (
        "CONTRIBUTING.md",
        "Makefile",
        "CHANGELOG.md",
        "docs/commands.md",
        "docs/install.md",
        "harness/commands/options.py",
    ):
        said = re.findall(r"every (\w+) (s|seconds|minutes)\b", (README.parent / name).read_text())
        assert set(said) <= {("two", "minutes"), ("2", "minutes")}, name
        assert said, name


def test_the_changelog_names_the_published_files_of_an_earlier_form() -> None:
    """Files of measurements are made from one publication to the next, and the code may be ahead of them."""
    lists = {path.name for path in REPORTS.glob("*.json") if isinstance(json.loads(path.read_text()), list)}
    told = re.search(r"\(([^()]*) of an earlier\s+revision,\s+and lists", (README.parent / "CHANGELOG.md").read_text())
    assert lists == set(re.findall(r"reports/(\w+\.json)", told[1] if told else ""))


def test_the_published_stability_is_of_so_many_integrators() -> None:
    published = json.loads((REPORTS / "stability.json").read_text())
    said = r"reports/stability.json has the eight panels of (\d+) integrators of (\d+) libraries at depth (\w+)\."
    *numbers, depth = _match(said)
    measured = {row["integrator"] for row in published["rows"]}
    assert [*map(int, numbers)] == [len(measured), len({name.partition(":")[0] for name in measured})]
    assert depth == published["depth"]
    assert len(published["panels"]) == 8


@pytest.fixture(scope="module")
def page() -> dict[str, Any]:
    """The data of the published page."""
    found: dict[str, Any] = carried(REPORTS / "index.html")
    return found


def test_the_digits_of_the_readme_are_those_of_the_certificates() -> None:
    closed, integrated = map(
        int,
        _match(
            r"agrees with it in at least (\d+) digits for closed forms and in at least (\d+) for integrated motions"
        ),
    )
    certificates = sidecars.read(REPORTS / "certificates.json")["rows"]
    assert all(each["passed"] and each["digits"] >= integrated for each in certificates)
    fewer = [each for each in certificates if each["digits"] < closed]
    # Cases whose exact motion is an integration, wholly or in part, require only the smaller number.
    assert all(each["required"] == integrated for each in fewer)


def test_the_numbers_of_the_readme_are_those_of_the_code() -> None:
    count = {"five": 5, "six": 6, "twelve": 12}
    cases, systems = _match(r"the (\w+) cases that exercise every form, and stiff variants of (\w+) systems")
    assert count[cases] == len(plan.FOUNDATION)
    assert count[systems] == len({name.partition("/")[0] for name in plan.SUITES["standard"].scope.further})
    assert count[_match(r"twelve cases and (\w+) launches")[0]] == plan.SUITES["full"].timing.launches
    assert int(_match(r"the largest of (\d+) samples")[0]) == SAMPLES
    (python,) = _match(r"With Python ([\d.]+) and make")
    assert _project()["requires-python"] == f">={python}"


def test_the_time_of_odeint_in_the_readme_is_that_of_the_page(page: dict[str, Any]) -> None:
    (time,) = _match(r"compiled odeint takes ([\d.]+ µs)")
    (row,) = re.findall(r"<tr><th>SciPy odeint<.*?</tr>", page["times"]["pendulum_simple/default"], re.S)
    assert re.findall(r'data-axis="time">([^<]*)', row)[1] == time, "at 1e-6"


def test_the_failures_in_the_figure_are_explained() -> None:
    """All that can be there: which ones are depends on the published run."""
    letters = set(re.findall(r">([A-Z])</text>", FIGURE.read_text()))
    (explained,) = _match(r"band above \((.*?)\)")
    assert letters <= set(re.findall(r"\b([A-Z])\b", explained))
    assert all(f"{style.LETTERS[word]} {word}" in explained for word in ("diverged", "skipped"))


def test_the_figure_of_the_readme_shows_the_published_points(page: dict[str, Any]) -> None:
    """A mark for each setting that did not fail, and the names in colour. Where marks are: `test_report.py`."""
    svg = FIGURE.read_text()
    points = page["work"]["cases"]["pendulum_simple"]["default"]["points"]
    shown = [k for k, failed in enumerate(points["failed"]) if not failed]
    assert svg.count('<use href="#m') == len(shown)
    legend = set(re.findall(r">(\w+:[^<]+)</text>", svg)) & set(points["series"]["words"])
    assert legend == {points["series"]["words"][points["series"]["codes"][k]] for k in shown if points["front"][k]}


def _pendulum(times: Sequence[Any], release: Any = 2, g: Any = 9.81, length: Any = 1) -> list[list[Any]]:
    """Angle and rate of the pendulum of the figure: sin(theta/2) = k cd(w t), where k = sin(release/2)."""
    w, k, rows = mpmath.sqrt(mpmath.mpf(g) / length), mpmath.sin(mpmath.mpf(release) / 2), []
    for t in times:
        sn, cn, dn = (mpmath.ellipfun(name, w * t, m=k * k) for name in ("sn", "cn", "dn"))
        rows.append([2 * mpmath.asin(k * cn / dn), -2 * k * w * mpmath.sqrt(1 - k * k) * sn / dn])
    return rows


def _runge_kutta(y: Any, h: float) -> Any:
    def f(y: Any) -> Any:
        return np.array([y[1], -9.81 * math.sin(y[0])])

    a = f(y)
    b = f(y + h / 2 * a)
    c = f(y + h / 2 * b)
    return y + h / 6 * (a + 2 * b + 2 * c + f(y + h * c))


def _leapfrog(y: Any, h: float) -> Any:
    half = y[1] - h / 2 * 9.81 * math.sin(y[0])
    angle = y[0] + h * half
    return np.array([angle, half - h / 2 * 9.81 * math.sin(angle)])


@pytest.mark.parametrize(("name", "step"), [("gnomon:RK4", _runge_kutta), ("gnomon:Störmer-Verlet", _leapfrog)])
def test_errors_in_the_figure_of_the_readme_are_found_again(page: dict[str, Any], name: str, step: Any) -> None:
    """With the method in five lines and Jacobi's functions of mpmath: only the sample times are gnomon's."""
    times = get("pendulum_simple").rounded().times
    with mpmath.workdps(30):
        exact = np.array(_pendulum(times.tolist()), dtype=np.float64)
    sizes = np.max(np.abs(exact), axis=0, initial=2.0)  # the largest angle is the angle of release
    points = page["work"]["cases"]["pendulum_simple"]["default"]["points"]
    own = points["series"]["words"].index(name)
    chosen = [k for k, code in enumerate(points["series"]["codes"]) if code == own and not points["failed"][k]][:4]
    assert len(chosen) == 4
    for k in chosen:
        count = round(times[0] / points["setting"][k])
        y, found = np.array([2.0, 0.0]), []
        for _ in times:
            for _ in range(count):
                y = step(y, times[0] / count)
            found.append(y)
        error = np.max(np.abs(np.array(found) - exact) / sizes)
        assert 100 * math.log10(error) == pytest.approx(points["error"][k], abs=0.51), "hundredths of a decade"


def test_the_limits_in_the_figure_of_the_readme(page: dict[str, Any]) -> None:
    """Half an ulp of the angle or the rate over their sizes; the effect of half an ulp of the release, g, L and t."""
    (words,) = _match(r"the effect of half an ulp in (.*?) on the exact motion")
    assert words == "the initial state, the parameters and the time"
    limits = page["work"]["cases"]["pendulum_simple"]["default"]["limits"]
    floor, conditioning = (next(x["at"] for x in limits if word in x["limit"]) for word in ("floor", "conditioning"))
    times = get("pendulum_simple").rounded().times.tolist()
    with mpmath.workdps(40):
        exact, later = _pendulum(times), _pendulum([mpmath.mpf(t) + mpmath.mpf(math.ulp(t)) / 2 for t in times])
        moved = [_pendulum(times, **{name: mpmath.mpf(x) + mpmath.mpf(math.ulp(x)) / 2}) for name, x in NUMBERS.items()]
        effects = np.array([np.array(other) - np.array(exact) for other in (*moved, later)], dtype=np.float64)
    states = np.abs(np.array(exact, dtype=np.float64))
    sizes = np.max(states, axis=0, initial=2.0)
    assert math.log10(np.max(np.spacing(states) / 2 / sizes)) == pytest.approx(floor, abs=1e-3)
    together = np.sqrt(np.sum(np.max(np.abs(effects) / sizes, axis=2) ** 2, axis=0))
    assert math.log10(np.max(together)) == pytest.approx(conditioning, abs=1e-3)


def _project() -> dict[str, Any]:
    found: dict[str, Any] = tomllib.loads((README.parent / "pyproject.toml").read_text())["project"]
    return found


def test_every_dependency_has_its_licence_and_its_reason_in_the_docs() -> None:
    rows = dict(re.findall(r"^\| ([^|]+?) \| ([^|]+?) \|$", DETAILS[0].read_text().split("## Licences")[1], re.M))
    licences = {name: rows[cell] for cell in rows for name in re.findall(r"[\w-]+", cell.partition(" (")[0])}
    needed = {re.split(r"[^\w-]", each)[0] for each in _project()["dependencies"]}
    extras = {
        name: each
        for name, each in _project()["optional-dependencies"].items()
        if name not in ("all", "dev", "docs", "league")
    }
    optional = {re.split(r"[^\w-]", each)[0] for named in extras.values() for each in named}
    wanted = needed | optional
    libraries = {one.package: one for one in LIBRARIES.values() if not one.debian}
    licences = {name: one.licence for name, one in libraries.items()} | licences
    assert set(licences) - {"package", "---"} == wanted
    reasons = (README.parent / "docs" / "development.md").read_text().split("each with its reason")[1]
    for name in sorted(wanted):
        assert name in libraries or re.search(rf"^\|.*\b{name}\b.*\|.*\|$", reasons, re.M), name
        try:
            about: Any = metadata(name)
        except PackageNotFoundError:
            assert name in optional
            continue
        told = " ".join(value for key, value in about.items() if key in ("Classifier", "License", "License-Expression"))
        if not told:  # some have it in a file alone
            told = " ".join(each.read_text() for each in files(name) or () if each.name.startswith("LICENSE"))
        for licence in re.findall(r"BSD|MIT|Apache|MPL|zlib|LGPL-3.0|GPL-3.0-only", licences[name]):
            assert licence in told, (name, told)
