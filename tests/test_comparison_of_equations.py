"""`compare` and `run` on a user's own equations: answers with their settings, failures with their reasons, files as of cases."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gnomon.harness.commands import cli
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.reporting.report import write_report
from gnomon.harness.results import reading
from published_systems import SYSTEMS

import gnomon

METHODS = ["gnomon:DOP853", "scipy:RK45", "gnomon:Blanes-Moan 6", "gnomon:RKMK 4"]
LONG = 300.0
SETTINGS = {"tolerance": [1e-4, 1e-7, 1e-10], "step": [0.1, 0.05, 0.01]}


def swing(t: float, y: Floats, g: float) -> list[Any]:
    return [y[1], -g * np.sin(y[0])]


@pytest.fixture(scope="module")
def found() -> gnomon.Comparison:
    return gnomon.compare(
        swing, (0, 5), [1.2, 0.0], METHODS, args=(9.81,), settings=SETTINGS, limit_seconds=LONG
    )  # fmt: skip


def errors(found: gnomon.Comparison, method: str) -> list[float]:
    return [row["error_max"] for row in found.rows if row["integrator_id"] == method]


def test_errors_are_those_of_the_case_with_the_same_equations(found: gnomon.Comparison) -> None:
    """The pendulum of gnomon has an exact motion; with the same numbers a method has the same errors at its samples."""
    case = gnomon.compare(gnomon.case("pendulum_simple", g=9.81, L=1, theta=1.2, omega=0, span=5), "gnomon:DOP853",
                          settings=SETTINGS["tolerance"], limit_seconds=LONG)  # fmt: skip
    ratio = np.array(errors(found, "gnomon:DOP853")) / errors(case, "gnomon:DOP853")
    assert np.all((ratio > 0.2) & (ratio < 5)), "sizes differ by the groups of coordinates alone"


def test_tighter_settings_have_smaller_errors(found: gnomon.Comparison) -> None:
    for method in METHODS[:3]:
        series = errors(found, method)
        assert series[0] > 10 * series[1] > 100 * series[2]


def test_the_best_method_reaches_the_error_and_its_lines_run(found: gnomon.Comparison) -> None:
    best = found.best(1e-6)
    assert best.error <= 1e-6
    known = [row for row in found.rows if row["status"] == "ok" and row["error_max"] <= 1e-6]
    loosest = {row["integrator_id"]: row["seconds_median"] for row in sorted(known, key=lambda row: row["setting"])}
    assert best.seconds == pytest.approx(min(loosest.values()))
    names: dict[str, Any] = {"swing": swing}
    exec(best.lines.replace(f"from {swing.__module__} import swing", ""), names)
    assert names["found"].success
    exact = gnomon.case("pendulum_simple", g=9.81, L=1, theta=1.2, omega=0, span=5)
    assert np.max(np.abs(names["found"].y.T - exact.sample(names["found"].t))) < 20e-6
    assert best.rival != best.method
    assert str(best).startswith(best.method)


def test_an_error_that_no_method_reaches_is_answered_with_the_least_one(found: gnomon.Comparison) -> None:
    with pytest.raises(ValueError, match=r"error=1e-17: no method that was compared reaches it; the least error is"):
        found.best(1e-17)


def test_print_says_what_can_be_reached_and_who_needs_another_form(found: gnomon.Comparison) -> None:
    text = " ".join(str(found).split())
    assert "rounding the start to double precision changes the state at t = 5 by" in text
    assert "reference with" in text
    assert "gnomon:RKMK 4: takes RigidBody, which swing does not state. State it as" in text


def test_in_a_notebook_the_table_shows_itself(found: gnomon.Comparison) -> None:
    shown = found._repr_mimebundle_()
    assert "gnomon:DOP853" in shown["text/html"]
    assert "y[1]" in gnomon.solve(swing, (0, 1), [1.0, 0.0], args=(9.81,)).plot().to_json()


@pytest.mark.filterwarnings("ignore:.*has no formulas")
def test_errors_below_a_reference_in_binary64_are_told_so() -> None:
    def table(t: float, y: Floats) -> list[Any]:
        return [y[1], -np.interp(y[0], [-5.0, 0.0, 5.0], [-5.0, 0.0, 5.0])]

    found = gnomon.compare(
        table, (0, 20), [1.0, 0.0], ["gnomon:DOP853", "gnomon:Taylor"], settings=[1e-6, 1e-13], limit_seconds=LONG
    )
    bound = max(row["floor"] for row in found.rows if row["floor"] is not None)
    assert f"< {bound:.1e}"[:4] in str(found)
    assert found.best(1e-6).error <= 1e-6
    assert "needs the formulas of equations" in " ".join(str(found).split()), "Taylor's method"


def test_equations_with_an_event_are_for_methods_with_events() -> None:
    def lowest(t: float, y: Floats, g: float) -> float:
        return y[0]

    found = gnomon.compare(
        swing, (0, 3), [1.2, 0.0], ["gnomon:DOP853 [events]", "gnomon:DOP853"], args=(9.81,), events=lowest,
        settings=[1e-6, 1e-10], limit_seconds=LONG,
    )  # fmt: skip
    assert errors(found, "gnomon:DOP853 [events]")[1] < 1e-8
    assert all(row["events_missing"] == 0 for row in found.rows if row["status"] == "ok")
    assert "swing has events" in " ".join(str(found).split())


@pytest.mark.parametrize(
    ("given", "named", "words"),
    [
        ((swing, (0, 5)), {}, r"write compare\(cases, integrators\), or compare\(fun, t_span, y0, integrators\)"),
        (("pendulum_simple", METHODS), {"args": (1.0,)}, "args=.*belongs to own equations"),
        ((swing, (0, 5), [1.0, 0.0], METHODS[:1]), {}, "swing .* raised TypeError"),
    ],
)
def test_wrong_calls_are_named(given: tuple[Any, ...], named: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        gnomon.compare(*given, **named)


QUICK = ("arenstorf", "lorenz", "torque", "bead", "ball")


@pytest.mark.filterwarnings("ignore:.*has no formulas")
@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=() if n in QUICK else pytest.mark.slow) for n in SYSTEMS if n != "beam"]
)
def test_published_systems_are_compared_in_one_call(name: str) -> None:
    """As their users write them: a tighter tolerance has a smaller error against the reference, whose end is published.

    The beam is left out: its 80 equations, called from Python, make a reference that takes more than 7 minutes.
    """
    known = SYSTEMS[name]
    methods = ["gnomon:DOP853"]
    if isinstance(known.f, gnomon.Hybrid):
        methods = ["gnomon:DOP853 [events]"]
    elif known.stiff:
        methods = [
            "scipy:LSODA",
            *(["scipy:Radau"] if name != "beam" else []),
        ]  # Radau takes minutes on its 80 equations
    found = gnomon.compare(
        known.f, known.t_span, known.start, methods, args=known.args, settings=[1e-5, 1e-11], limit_seconds=LONG
    )
    if (
        name == "e5"
    ):  # relative to its largest value a component is 1e-13 and less at the samples: SciPy's steps collapse
        assert {row["status"] for row in found.rows} == {"diverged"}
        return
    for method in methods:
        loose, tight = errors(found, method)
        assert tight < 1e-4, "ten revolutions of Lorenz's system lose seven digits"
        assert tight < loose / 10 or loose < 1e-12


MINE = """
import numpy as np


def swing(t, y, g):
    return [y[1], -g * np.sin(y[0])]


def lowest(t, y, g):
    return y[0]
"""


def test_from_a_file_with_a_function_to_a_recommendation_in_one_command(tmp_path: Path) -> None:
    """As a new user does it; the file of the results is one that the other commands read."""
    (tmp_path / "own_swing.py").write_text(MINE, encoding="utf-8")
    words = (
        "--equations own_swing.py:swing --span 0,3 --start 1.2,0 --parameters 9.81 --out runs/mine.sqlite --limit 300"
    )
    methods = ["--integrator", "gnomon:DOP853", "--integrator", "scipy:RK45"]
    gnomon_run = [sys.executable, "-c", "from gnomon.harness.commands.cli import main; main()", "run"]
    ended = subprocess.run(
        [*gnomon_run, *words.split(), *methods, "--settings", "1e-4,1e-8"], cwd=tmp_path, text=True, capture_output=True,
        check=False,
    )  # fmt: skip
    assert ended.returncode == 0, ended.stderr
    assert "rounding the start" in ended.stderr
    assert "for an error of 1e-06: gnomon:DOP853 at rtol=1e-08" in ended.stdout
    lines = ended.stdout[ended.stdout.index("import gnomon\n") :]
    again = subprocess.run([sys.executable, "-c", lines], cwd=tmp_path, text=True, capture_output=True, check=False)
    assert again.returncode == 0, again.stderr
    rows = reading.rows(tmp_path / "runs" / "mine.sqlite")
    assert {row["case"] for row in rows} == {"swing 0,3 from 1.2,0 with 9.81"}, (
        "with another start it is another problem"
    )
    assert {row["status"] for row in rows} == {"ok"}
    page = write_report(tmp_path / "runs" / "mine.sqlite", tmp_path / "page")
    summary = page.with_name("summary.md").read_text(encoding="utf-8")
    (line,) = [line for line in summary.splitlines() if line.startswith("| swing")]
    assert "scipy:RK45" in line, "a result"
    shown = page.read_text(encoding="utf-8").partition("<script")[0]
    assert "1 problem of own equations" in shown
    for false in ("not recorded", "not run", "with exact solutions", "Beatty", 'id="needs"'):
        assert false not in shown, "of the catalogue"


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ("--equations own_swing.py:swing", "give --span, as 0,10, and --start"),
        ("--equations own_swing.py:swing --span 0 --start 1,0", "--span 0: give the first and the last time"),
        ("--equations own_swing.py:swing --span 0,1 --start 1,x", "--start 1,x: write numbers"),
        ("--equations own_swing.py:swung --span 0,1 --start 1,0", "has no attribute 'swung'"),
        ("--equations yours.py:swing --span 0,1 --start 1,0", "there is no file yours.py"),
        ("--equations mine --span 0,1 --start 1,0", "write mine.py:f or package.module:f"),
        ("--equations own_swing.py:swing --span 0,1 --start 1,0 --case kepler_orbit", "--case belongs to cases"),
    ],
)
def test_wrong_options_are_named(
    words: str, says: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "own_swing.py").write_text(MINE, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["gnomon", "run", *words.split()])
    with pytest.raises(SystemExit) as ended:
        cli.main()
    assert ended.value.code == 2
    assert says in " ".join(capsys.readouterr().err.split())
