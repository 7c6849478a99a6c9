"""The trial of recommendations on drawn systems: what is measured, kept, dropped and judged."""

import json
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import synthetic
from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.own_systems import outside
from gnomon.harness.own_systems.drawn import SEED, Drawn, draw
from gnomon.harness.own_systems.own_system import make_system
from gnomon.harness.registry import lookup
from gnomon.harness.results import reading
from gnomon.harness.running.own_functions import Arguments
from gnomon.harness.running.pieces import Stated
from gnomon.harness.system.progress import Progress


def decay(t: float, y: Any, rate: float) -> list[Any]:
    return [-rate * y[0]]


def without_formulas(t: float, y: Any, rate: float) -> list[Any]:
    return [-rate * (y[0] if y[0] > 0 else 0.0)]


def system(name: str, fun: Callable[..., Any] = decay, rate: float = 1.0) -> Drawn:
    return Drawn(name, "decay", "accurate", "test", Stated(fun, Arguments((rate,))), 2.0, (1.0,))


SYSTEMS = [system("drawn_decay_1"), system("drawn_decay_2", without_formulas), system("drawn_decay_3", rate=2.0)]


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three systems, one of which has no reference in high precision, with SciPy's method alone."""
    path = tmp_path_factory.mktemp("outside") / "outside.sqlite"
    with pytest.MonkeyPatch.context() as patched, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that a function has no formulas
        patched.setattr(outside, "methods_of", lambda own, need: (lookup.find_one("scipy:DOP853"),))
        outside.measure(path, SYSTEMS, SEED, 300.0, Progress(quiet=True))
    return path


def test_each_system_is_measured_or_dropped_with_its_reason(measured: Path) -> None:
    done = outside.read_ended(measured)
    assert set(done) == {one.name for one in SYSTEMS}
    assert "high precision" in done["drawn_decay_2"].why
    rows = reading.rows(measured)
    assert {row["case"] for row in rows} == {"drawn_decay_1", "drawn_decay_3"}
    assert {row["status"] for row in rows} <= {"ok", "inaccurate"}
    assert all(row["seconds_median"] > 0 for row in rows)


def test_what_is_measured_is_not_computed_again(measured: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Only the systems that the file lacks; a dropped one has its verdict too."""
    made: list[str] = []

    def counted(*given: Any, name: str, **limits: Any) -> Any:
        made.append(name)
        raise ValueError("no two methods agree")

    monkeypatch.setattr(outside, "make_system", counted)
    outside.measure(measured, [*SYSTEMS, system("drawn_decay_4")], SEED, 300.0, Progress(quiet=True))
    assert made == ["drawn_decay_4"]
    assert outside.read_ended(measured)["drawn_decay_4"].why == "no reference: no two methods agree"


def test_systems_of_another_seed_do_not_mix(measured: Path) -> None:
    with pytest.raises(ValueError, match=f"{SEED}, {SEED + 1}"):
        outside.measure(measured, SYSTEMS, SEED + 1, 300.0, Progress(quiet=True))


def table(measured: Any, margin: float = 1.0) -> list[dict[str, Any]]:
    """Every error by the tolerance 1e-12; the median setting is 1e-3."""
    return [
        {"subject": "accurate", "error": error, "library": "scipy", "why": "", "systems": 6}
        | {"setting": {"kind": "tolerance", "relative": 1e-3}}
        | {"reliable": {"method": "scipy:DOP853", "kind": "tolerance", "value": 1e-12}}
        for error in (1e-3, 1e-6, 1e-9)
    ]


@pytest.fixture
def catalogue(tmp_path: Path) -> Path:
    """A run of one case by two methods."""
    integrators = [
        ("scipy", "DOP853", "", 8, "tolerance", 4e-6, ""),
        ("heyoka", "Taylor", "", 8, "tolerance", 1e-7, ""),
    ]
    return synthetic.write(
        tmp_path / "run.sqlite", {"pendulum_simple": ("pendulum_simple", "1", 2, ("default",))}, integrators
    )


def test_a_run_is_judged_without_a_measurement(
    measured: Path, catalogue: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The file has what is published, and the command prints the share of it."""
    before = measured.read_bytes()
    dropped = {name for name, one in outside.read_ended(measured).items() if one.why}
    systems = [*SYSTEMS, *(system(name) for name in dropped - {one.name for one in SYSTEMS})]
    monkeypatch.setattr(outside, "draw", lambda seed=SEED: systems)
    monkeypatch.setattr(outside.recommending, "answers", table)
    to = tmp_path / "outside.json"
    outside.main(["--out", str(measured), "--judge", str(catalogue), "--to", str(to)])
    found = json.loads(to.read_text())
    assert (found["seed"], found["drawn"], found["systems"]) == (SEED, len(systems), 2)
    assert {one["name"] for one in found["dropped"]} == dropped
    assert (found["share"]["held"], found["share"]["of"]) == (6, 6)
    assert found["median_share"]["held"] < 6
    assert found["order"]["of"] == 0
    assert {"environment", "by_need", "by_library", "misses"} <= set(found)
    assert {"sources", "machine", "cpu", "date"} <= set(found["environment"])
    assert "6 of 6" in capsys.readouterr().out
    assert measured.read_bytes() == before


def test_a_part_of_the_draw_is_not_judged(measured: Path, catalogue: Path, tmp_path: Path) -> None:
    """A share of the systems that happened to be measured first is no share of the draw."""
    with pytest.raises(ValueError, match="are not measured yet"):
        outside.judge_file(measured, catalogue)
    with pytest.raises(ValueError, match="no systems were measured"):
        outside.judge_file(tmp_path / "none.sqlite", catalogue)


@pytest.mark.parametrize(
    ("name", "present", "absent"),
    [
        ("drawn_dashpots_4", {"scipy:Radau", "gnomon:Radau IIA 5"}, {"scipy:DOP853"}),
        ("drawn_walls_5", {"scipy:DOP853 [events]", "gnomon:DOP853 [events]"}, {"scipy:DOP853"}),
        ("drawn_charge_1", {"scipy:DOP853", "gnomon:DOP853"}, {"scipy:DOP853 [events]"}),
        ("drawn_surface_3", {"gnomon:DOP853"}, {"gnomon:DOP853 [events]"}),
        ("drawn_ball_1", {"scipy:RK45", "gnomon:DOP853"}, {"scipy:DOP853", "scipy:DOP853 [events]"}),
    ],
)
def test_the_methods_are_those_that_the_manuals_name(name: str, present: set[str], absent: set[str]) -> None:
    """By need: stiff, with events, across velocities, with a constraint, rough. Engines, which take no equations, do not run."""
    one = next(one for one in draw() if one.name == name)
    own = make_system(one.stated, (0.0, one.span), one.start, name=one.name)
    found = {method.id for method in outside.methods_of(own, one.need)}
    assert present <= found
    assert not absent & found
    engines = {library for library, of in LIBRARIES.items() if "engine" in of.calls.values()}
    assert not engines & {identity.partition(":")[0] for identity in found}


def test_an_unknown_system_names_the_families(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        outside.main(["--out", str(tmp_path / "any.sqlite"), "--only", "nothing"])
    assert "potential, springs" in capsys.readouterr().err
