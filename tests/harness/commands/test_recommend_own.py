"""`gnomon recommend --equations`: measured on a user's own equations, with lines that run; the advice is judged there."""

import re
import runpy
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import own_motions
import pytest
from command_line import gnomon
from gnomon.harness.commands.published import recommend_own
from gnomon.harness.results.advice import recommendations
from own_motions import Floats, linear_motion, solved

MINE = """
from math import cos, sin

import gnomon


def double_pendulum(t, y, g):  # with friction in both joints
    a, b, u, v = y
    c, s = cos(a - b), sin(a - b)
    top = -s * v * v - 2 * g * sin(a) - 0.2 * u - 0.1 * (u - v)
    low = s * u * u - g * sin(b) - 0.1 * (v - u)
    return u, v, (top - c * low) / (2 - c * c), (2 * low - c * top) / (2 - c * c)


def chain(t, y):  # light masses between stiff springs with strong dampers; its first end is pulled
    a, b, u, v = y
    left, middle, right = 1e4 * (a - sin(t) + u - cos(t)), 1e4 * (b - a + v - u), 1e4 * (b + v)
    return u, v, middle - left, -right - middle


def satellite(t, q):
    x, y = q
    r3 = (x * x + y * y) ** 1.5
    return -x / r3, -y / r3


def falling(t, y, p):
    return y[1], -9.81


def resting(t, y, p):
    return 0.0 * y[0], 0.0 * y[1]


def ground(t, y, p):
    return (y[0],)


def bounce(t, y, p):
    return y[0], -0.5 * y[1]


def start(t, y, p):
    return "flight"


impact = gnomon.Transition("impact", "flight", ground, -1, bounce, "flight")
modes = gnomon.Mode("flight", falling), gnomon.Mode("rest", resting)
ball = gnomon.Hybrid(modes, start, (impact,), settle=1e-9, limits=(("impact", "rest", resting),))
"""
CHAIN = [[0, 0, 1, 0], [0, 0, 0, 1], [-2e4, 1e4, -2e4, 1e4], [1e4, -2e4, 1e4, -2e4]]
SWING = ["--equations", "own_systems_of_a_user.py:double_pendulum", "--span", "0,3", "--parameters", "9.81"]


def pendulum_motion(t: float, y: Floats) -> list[float]:
    a, b, u, v = y
    c, s = np.cos(a - b), np.sin(a - b)
    joints = np.array([-0.2 * u - 0.1 * (u - v), -0.1 * (v - u)])
    forces = joints + np.array([-s * v * v - 2 * 9.81 * np.sin(a), s * u * u - 9.81 * np.sin(b)])
    return [u, v, *np.linalg.solve([[2, c], [c, 1]], forces)]


def ellipse(times: Floats) -> Floats:
    """An orbit of eccentricity .9 that starts in its perigee at a distance of 1."""
    axis, e, found = 10.0, 0.9, []
    for t in times:
        mean, anomaly = t / axis**1.5, np.pi
        for _ in range(100):
            anomaly -= (anomaly - e * np.sin(anomaly) - mean % (2 * np.pi)) / (1 - e * np.cos(anomaly))
        c, s, root, turn = np.cos(anomaly), np.sin(anomaly), np.sqrt(1 - e * e), axis**-0.5
        speed = np.array([-s, root * c]) * turn / (1 - e * c)
        found.append([axis * (c - e), axis * root * s, *speed])
    return np.array(found)


Motion = Callable[[Floats], Floats]
SYSTEMS: dict[str, tuple[list[str], str, Motion]] = {
    "double_pendulum": (
        ["--span", "0,3", "--start", "2,0,0,0", "--parameters", "9.81"],
        "High accuracy, found",
        lambda times: solved(pendulum_motion, [2.0, 0.0, 0.0, 0.0], times),
    ),
    "chain": (
        ["--span", "0,1", "--start", "0,0,0,0", "--error", "1e-6"],
        "Stiff systems, found",
        lambda times: linear_motion(CHAIN, [0, 0, 1e4 - 1e4j, 0], 1.0, [0] * 4, times),
    ),
    "satellite": (
        ["--span", "0,600", "--start", f"1,0,0,{1.9**0.5!r}", "--accelerations", "--error", "1e-6"],
        "All smooth systems, found",
        ellipse,
    ),
    "ball": (["--span", "0,3", "--start", "1,0"], "Events and contact, found", own_motions.bounced),
}


@pytest.fixture(autouse=True)
def _in_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "own_systems_of_a_user.py").write_text(MINE)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)


@pytest.mark.parametrize("name", SYSTEMS)
def test_the_printed_lines_run_and_reach_the_error(name: str, capfd: pytest.CaptureFixture[str]) -> None:
    """On systems that are no case: measured, with the subject that the equations belong to, against other equations."""
    options, title, motion = SYSTEMS[name]
    error = float(dict(pairwise(options)).get("--error", "1e-9"))
    words = "recommend", "--equations", f"own_systems_of_a_user.py:{name}", "--library", "gnomon", *options
    assert gnomon(*words) == 0
    told = capfd.readouterr().out
    assert title in told
    Path("lines.py").write_text(told[told.index("\nimport gnomon") :])
    found = runpy.run_path("lines.py")["found"]
    right = motion(found.t[1:])
    half = right.shape[1] // 2
    for part in (slice(half), slice(half, None)):
        assert np.max(abs(found.y.T[1:, part] - right[:, part])) <= error * np.max(abs(right[:, part]))


def advise(monkeypatch: pytest.MonkeyPatch, **changes: Any) -> None:
    """Put other advice on gnomon's methods in the place of the published one."""
    table = recommendations.read()
    own = [{key: row[key] for key in ("subject", "error", "library")} for row in table.rows]
    rows = [row | changes for row in own if row["library"] == "gnomon"]
    names = "gnomon:DOP853", "gnomon:Explicit Euler", "gnomon:RK4", "gnomon:RKMK 4"
    forms = {name: ["FirstOrder"] for name in names}
    changed = replace(table, rows=rows, forms={**table.forms, **forms})
    monkeypatch.setattr(recommendations, "read", lambda: changed)


@pytest.mark.parametrize(("tolerance", "words"), [(1e-3, "does NOT hold here: error"), (1e-12, "holds here: error")])
def test_the_published_setting_is_judged_on_the_equations(
    tolerance: float, words: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """And the error beside it is the one that was found at this setting, and lies on its side of the bound."""
    method = "gnomon:DOP853"
    better = {"methods": ["gnomon:RK4"], "why": "", "systems": 6, "tried": 6, "among": 9, "how": "invented"}
    declines = {"method": "gnomon:RKMK 4", "kind": "step", "relative": 0.1}  # it takes rigid bodies alone
    reliable = {"method": method, "kind": "tolerance", "value": tolerance, "seconds": 1e-5, "others": [declines]}
    advise(monkeypatch, methods=[method, "gnomon:RKMK 4"], why="", reliable=reliable, better=better)
    assert gnomon("recommend", "smooth", *SWING, "--start", "2,0,0,0", "--error", "1e-8", "--library", "gnomon") == 0
    told = capfd.readouterr().out
    found = re.search(rf"rtol={tolerance:g} of {method}, {words} ([\d.e-]+)", told)
    assert found is not None, told
    assert (float(found[1]) <= 1e-8) == words.startswith("holds")
    assert "published as its fastest: gnomon:RK4; here it" in told
    assert "of gnomon:RKMK 4" not in told, "of a method that did not run nothing is said"


def test_without_a_method_that_reaches_the_error_the_exit_code_is_1(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    advise(monkeypatch, methods=["gnomon:Explicit Euler"], why="")
    assert gnomon("recommend", "smooth", *SWING, "--start", "1,0,0,0", "--error", "1e-9", "--library", "gnomon") == 1
    told = capfd.readouterr()
    assert "gnomon:Explicit Euler does not reach the error" in told.out
    assert re.search(r"no method of the advice reaches an error of 1e-09 here; the least error is \d", told.err)


def test_where_the_reference_is_the_limit_no_method_is_blamed() -> None:
    row = {
        "integrator_id": "scipy:RK45", "setting": 1e-9, "setting_kind": "tolerance", "status": "ok", "error_max": 1e-8,
        "floor": 1e-2, "launch": 1, "seconds_median": 1.0, "prepare_seconds": 0.0, "reason": None,
    }  # fmt: skip
    system: Any = SimpleNamespace(lines=str)
    measured = recommend_own.Measured(system, 1e-6, {"scipy:RK45": [row]})
    reliable = {"method": "scipy:RK45", "kind": "tolerance", "value": 1e-6, "name": "rtol"}
    answer = {"library": "scipy", "methods": ["scipy:RK45"], "reliable": reliable}
    first, second = recommend_own._answer(measured, answer, ["scipy:RK45"])
    assert "so small an error cannot be measured" in first
    assert "holds here cannot be measured" in second
    assert "not reach" not in first


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--equations", "none.py:f", "--span", "0,1", "--start", "1"], "there is no file none.py"),
        (SWING, "give --span, as 0,10, and --start, as 2,0,0,0"),
        ([*SWING, "--start", "2,x"], "--start 2,x: write numbers"),
        ([*SWING, "--start", "2,0"], "double_pendulum"),
        (["zork", *SWING, "--start", "2,0,0,0"], "no subject is called 'zork'"),
        ([*SWING, "--start", "2,0,0,0", "--error", "1e-20"], "errors were measured down to"),
        ([*SWING, "--start", "2,0,0,0", "--library", "zork"], "no library is called 'zork'"),
    ],
)
def test_bad_input_is_named(words: list[str], said: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert gnomon("recommend", *words) == 2
    told = capfd.readouterr().err
    assert said in " ".join(told.split())
    assert told.startswith("error: ")
