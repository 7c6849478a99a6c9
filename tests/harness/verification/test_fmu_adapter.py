"""An FMU is verified in a worker: right where it is right, one clear reason where it is wrong or cannot be used."""

import json
import platform
import stat
import sys
import zipfile
from dataclasses import replace
from pathlib import Path

import fmu_files
import numpy as np
import pytest
from command_line import gnomon
from fmu_files import COSIMULATION, EXCHANGE, OUTPUT, PARAMETER, describe, library, write_fmu
from gnomon.harness.contract.integrator import Problem, Refused, Unsupported
from gnomon.harness.contract.problem import initial_state, problem_of, takes
from gnomon.harness.contract.validation import Unusable
from gnomon.harness.trajectories.fmu_columns import from_fmu
from gnomon.harness.verification.claims import Outcome
from gnomon.harness.verification.fmu import adapter, archive
from gnomon.harness.verification.verify import CLAIM_SECONDS, FirstTrialError, Report, verify

from gnomon import cases

pytest.importorskip("fmpy")
pytestmark = pytest.mark.skipif(
    fmu_files.COMPILER is None or sys.platform != "linux" or platform.machine() != "x86_64",
    reason="needs a C compiler on Linux and x86-64, for which the FMUs are built",
)
CASE = "pendulum_simple"
STARTLESS = (0, f'{OUTPUT} initial="calculated"', "")
"""The variable theta, without a start that can be set."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("fmu")


def built(folder: Path, *macros: str, kinds: str = COSIMULATION, version: int = 2) -> Path:
    name = "swing" + "".join(filter(str.isalnum, "".join([*macros, kinds[1:4], str(version)])))
    return write_fmu(folder / f"{name}.fmu", describe(kinds, version), library(folder, *macros))


def verified(path: Path, claims: list[str], order: int | None = 4, method: str | None = None) -> Report:
    return verify(from_fmu(path, cases.get(CASE), order=order, method=method)[0], [CASE], "low", claims, workers=1)


def swing(**numbers: str) -> tuple[Problem, np.ndarray]:
    case = cases.get(CASE, **numbers).rounded()
    return problem_of(case, adapter.FmuIntegrator.accepts), initial_state(case)[None]


def test_a_right_fmu_is_verified_in_another_process(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, report = write_fmu(tmp_path / "swing.fmu", describe(), library(folder)), tmp_path / "report.json"
    command = ["verify", "--fmu", str(path), "--order", "4", "--case", CASE, "--set", "L=2", "--depth", "low"]
    claims = ["--claim", "follows", "--claim", "order"]
    assert gnomon(*command, *claims, "--json", str(report), "--junit", str(tmp_path / "j.xml")) == 0
    told = capsys.readouterr()
    assert "is a program" in told.err
    assert "L sets L" in told.out
    rows = {row["claim"]: row for row in json.loads(report.read_text())["rows"]}
    assert {rows[name]["outcome"] for name in ("follows", "order")} == {"passed"}
    assert str(path) not in {one.archive.path for one in adapter._loaded.values()}  # it was never in this process


def test_claims_with_other_equations_do_not_apply(folder: Path) -> None:
    names = ["quadrature", "clock", "units", "more_variables", "blow_up", "other_problems"]
    rows = {row.claim: row.finding.outcome for row in verified(built(folder), names).rows}
    assert {rows[name] for name in names[:-1]} == {Outcome.NOT_APPLICABLE}
    assert rows["other_problems"] == Outcome.PASSED


@pytest.mark.parametrize(
    ("macro", "cause"),
    [
        ("GRAVITY_FACTOR=9.8/9.81", "g is 9.8"),
        ("GRAVITY_FACTOR=0.9", "a parameter, the start or a term"),
        ("EULER", "order 1.0 where 4"),
        ("LATE", "t - h"),
    ],
)
def test_a_wrong_fmu_fails_with_its_cause(folder: Path, macro: str, cause: str) -> None:
    report = verified(built(folder, macro), ["order_short"])
    assert report.of(Outcome.FAILED)
    assert report.diagnosis is not None
    assert cause in report.diagnosis


def test_the_equations_of_model_exchange_are_verified_by_a_method(folder: Path) -> None:
    """gnomon:RK4 declares its order."""
    rows = verified(built(folder, kinds=EXCHANGE), ["follows", "order", "blow_up"], order=None).rows
    assert [row.finding.outcome for row in rows] == [Outcome.PASSED, Outcome.PASSED, Outcome.NOT_APPLICABLE]


def test_model_exchange_moves_by_the_equations_of_the_fmu(folder: Path) -> None:
    """0.9 g for g is the motion of another case; the equations of the problem itself play no part."""
    problem, start = swing()
    made, _ = from_fmu(built(folder, "GRAVITY_FACTOR=0.9", kinds=EXCHANGE), cases.get(CASE), method="scipy:DOP853")
    states = made.prepare(problem, 1e-10)(start).states[0]
    assert np.max(np.abs(states - cases.get(CASE, g="8.829").rounded().sample(problem.times))) < 1e-6


def test_a_method_that_reads_formulas_declines_an_fmu(folder: Path) -> None:
    made, _ = from_fmu(built(folder, kinds=EXCHANGE), cases.get(CASE), method="gnomon:Taylor")
    with pytest.raises(Refused, match="needs the formulas of equations"):
        made.prepare(swing()[0], 1e-6)


def test_both_versions_and_both_kinds_compute_the_same_motion(folder: Path) -> None:
    """RK4 inside the FMU, and gnomon's RK4 on its derivatives, differ by round-off alone."""
    problem, start = swing(L="1.5")
    h, found = problem.interval / 32, []
    for version in (2, 3):
        for kinds, method in ((COSIMULATION, None), (EXCHANGE, "gnomon:RK4")):
            made, _ = from_fmu(built(folder, kinds=kinds, version=version), cases.get(CASE), method=method)
            found.append(made.prepare(problem, h)(start).states)
    assert np.max(np.abs(found - cases.get(CASE, L="1.5").rounded().sample(problem.times))) < 1e-3
    assert np.max(np.abs(np.array(found) - found[0])) < 1e-11
    assert np.array_equal(found[0], found[2])


def test_solvers_of_one_fmu_do_not_disturb_each_other(folder: Path) -> None:
    """An FMU has one instance at a time; a second problem with another length has its own motion."""
    made, _ = from_fmu(built(folder, kinds=EXCHANGE), cases.get(CASE))
    (one, start), (two, _) = swing(), swing(L="2")
    first, second = (made.prepare(problem, problem.interval / 32) for problem in (one, two))
    alone = first(start).states
    other = second(start).states[0]
    assert np.max(np.abs(other - cases.get(CASE, L="2").rounded().sample(two.times))) < 1e-3
    assert np.array_equal(first(start).states, alone)


def test_steps_end_at_samples_that_are_not_multiples_of_an_interval(folder: Path) -> None:
    made, _ = from_fmu(built(folder), cases.get(CASE))
    problem, start = swing()
    problem = replace(problem, times=np.array([0.1, 0.3, 1.0]))
    solution = made.prepare(problem, 1 / 256)(start)
    assert np.max(np.abs(solution.states[0] - cases.get(CASE).rounded().sample(problem.times))) < 1e-7
    assert solution.steps == 26 + 51 + 179
    with pytest.raises(Refused, match="longer than the sampling interval"):
        made.prepare(problem, 0.4)


def test_motions_with_events_are_taken_for_cosimulation_alone(folder: Path) -> None:
    """An FMU for co-simulation finds its events itself; those of model exchange are not located."""
    ball = cases.get("bouncing_ball")
    assert takes(from_fmu(built(folder), cases.get(CASE))[0], ball)
    assert not takes(from_fmu(built(folder, kinds=EXCHANGE), cases.get(CASE))[0], ball)


def test_units_of_variables_are_converted(folder: Path) -> None:
    degrees = (0, f'{OUTPUT} initial="exact"', 'start="2" unit="deg"')
    text = describe(theta=degrees, length=(5, PARAMETER, 'start="1"'), L=None)
    path = write_fmu(folder / "degrees.fmu", text, library(folder, "UNIT=57.29577951308232"))
    problem, start = swing()
    made, told = from_fmu(path, cases.get(CASE), "length=L:cm")
    wrong = made.prepare(problem, problem.interval / 32)(start).states  # 1 m is sent as 100
    made, _ = from_fmu(path, cases.get(CASE), ["length=L:m"])
    right = made.prepare(problem, problem.interval / 32)(start).states
    exact = cases.get(CASE).rounded().sample(problem.times)
    assert np.max(np.abs(right - exact)) < 1e-3 < np.max(np.abs(wrong - exact))
    assert "theta is theta (deg, by the FMU)" in told


def test_a_crash_and_a_hang_are_ended(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(FirstTrialError, match="SIGABRT"):
        verified(built(folder, "CRASHES"), ["follows"])
    monkeypatch.setitem(CLAIM_SECONDS, "low", 0.1)
    with pytest.raises(FirstTrialError, match="no answer within"):
        verified(built(folder, "HANGS"), ["follows"])


def test_an_fmu_that_declines_its_start_is_named(folder: Path) -> None:
    made, _ = from_fmu(built(folder, "NO_START"), cases.get(CASE))
    problem, start = swing()
    with pytest.raises(Unusable, match=r"cannot be initialized: .*ExitInitializationMode"):
        made.prepare(problem, problem.interval)(start)
    with pytest.raises(Refused, match="not finite"):
        made.prepare(problem, problem.interval)(start * np.nan)


def test_a_start_is_set_by_a_parameter_or_is_kept(folder: Path) -> None:
    """Value reference 0 is theta: a parameter with it sets the start; without one the FMU keeps its own, 2 rad."""
    problem, start = swing(theta="0.5")
    by_name = write_fmu(
        folder / "named.fmu", describe(theta=STARTLESS, theta_0=(0, PARAMETER, 'start="2"')), library(folder)
    )
    made, told = from_fmu(by_name, cases.get(CASE))
    assert made.prepare(problem, problem.interval)(start).steps == 64
    assert any("theta_0 sets the start of theta" in line for line in told)
    keeps = write_fmu(folder / "keeps.fmu", describe(theta=STARTLESS), library(folder))
    made, _ = from_fmu(keeps, cases.get(CASE))
    usual, two = swing()
    assert made.prepare(usual, usual.interval)(two).steps == 64
    with pytest.raises(Unsupported, match=r"starts at 2, not at 0.5"):
        made.prepare(problem, problem.interval)(start)
    made, _ = from_fmu(keeps, cases.get(CASE, theta="0.5"))
    with pytest.raises(Unusable, match=r"starts at 2, not at 0.5"):
        made.prepare(problem, problem.interval)(start)


def test_a_parameter_in_the_fmu_is_kept_only_if_you_say_so(folder: Path) -> None:
    path = write_fmu(folder / "inside.fmu", describe(g=None), library(folder))
    with pytest.raises(ValueError, match=r"no variable for g = 9.81 m/s.2; give --columns VARIABLE=g, or fixed=g"):
        from_fmu(path, cases.get(CASE))
    made, _ = from_fmu(path, cases.get(CASE), "fixed=g")
    (usual, start), (other, _) = swing(), swing(g="1")
    assert made.prepare(usual, usual.interval)(start).steps == 64
    with pytest.raises(Unsupported, match=r"sets g, which is 9.81"):
        made.prepare(other, other.interval)


CONSTANT = (4, 'causality="local" variability="constant" initial="exact"', 'start="9.8"')
KEPT = (0, 'causality="output" variability="constant" initial="exact"', 'start="1.9"')


@pytest.mark.parametrize(
    ("columns", "changed", "told"),
    [
        ("phi=theta", {}, "no real variable 'phi'"),
        ("theta=angle", {}, "has no number 'angle'; it has theta, omega, g, L"),
        ("theta=theta:kg", {}, "kg is not a unit of a number in rad"),
        ("theta=theta:deg:rad", {}, "two units, deg and rad"),
        ("theta=theta,omega=theta", {}, "theta is given twice"),
        ("theta", {}, "write VARIABLE=COORDINATE"),
        ("fixed=theta", {}, "stands for the variable of a parameter"),
        ("omega=g", {}, "omega is a output, which cannot be set"),
        (None, {"theta": None, "angle": (0, OUTPUT, "")}, "no variable for theta"),
        (None, {"g": CONSTANT}, "g cannot be set and is 9.8 m/s^2, in the case g = 9.81 m/s^2"),
        (None, {"theta": KEPT}, "theta cannot be set and starts at 1.9 rad, in the case theta = 2 rad"),
    ],
)
def test_a_wrong_mapping_is_one_line(
    folder: Path, columns: str | None, changed: dict[str, tuple[int, str, str] | None], told: str
) -> None:
    path = write_fmu(folder / "mapped.fmu", describe(**changed), library(folder))
    with pytest.raises(ValueError, match=r"^[^\n]*$") as raised:
        from_fmu(path, cases.get(CASE), columns)
    assert told in str(raised.value)


@pytest.mark.parametrize("name", ["../outside", "/outside", "resources/../../outside", "..\\outside", "C:outside"])
def test_a_path_that_leaves_the_folder_is_refused(folder: Path, name: str) -> None:
    path = write_fmu(folder / "outside.fmu", describe(), library(folder), name)
    with pytest.raises(ValueError, match="leads out of its folder"):
        from_fmu(path, cases.get(CASE))
    assert not (folder / "outside").exists()


def test_a_link_and_a_large_archive_are_refused(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_fmu(folder / "link.fmu", describe(), library(folder))
    link = zipfile.ZipInfo("resources/link")
    link.external_attr = (stat.S_IFLNK | 0o777) << 16
    with zipfile.ZipFile(path, "a") as file:
        file.writestr(link, "/etc")
    with pytest.raises(ValueError, match="leads out of its folder"):
        from_fmu(path, cases.get(CASE))
    monkeypatch.setattr(archive, "MOST_BYTES", 1000)
    with pytest.raises(ValueError, match="more than 10000 files or 1000 bytes"):
        from_fmu(built(folder), cases.get(CASE))


def broken(folder: Path, way: str) -> Path:
    path, binary = folder / f"{way}.fmu", library(folder)
    if way == "truncated":
        path.write_bytes(built(folder).read_bytes()[:-200])
    elif way == "damaged":
        content = bytearray(built(folder).read_bytes())
        content[200:260] = bytes(60)
        path.write_bytes(content)
    elif way == "text":
        path.write_text("not an archive")
    elif way != "absent":
        texts = {
            "undescribed": None,
            "xml": describe()[:-30],
            "invalid": describe().replace("modelIdentifier", "identifier"),
            "old": describe().replace('fmiVersion="2.0"', 'fmiVersion="1.0"'),
            "kindless": describe(""),
            "binary": describe(),
        }
        write_fmu(path, texts[way], None if way == "binary" else binary)
    return path


@pytest.mark.parametrize(
    "way", ["absent", "text", "truncated", "damaged", "undescribed", "xml", "invalid", "old", "kindless", "binary"]
)
def test_a_broken_archive_is_refused_in_one_line(folder: Path, way: str) -> None:
    path = broken(folder, way)
    with pytest.raises(ValueError, match=r"^--fmu [^\n]*$") as raised:
        from_fmu(path, cases.get(CASE))
    assert str(path) in str(raised.value)
    if way == "binary":
        assert "binaries/linux64/swing.so for this machine" in str(raised.value)


@pytest.mark.parametrize(
    "options",
    [
        ("gnomon:RK4", "--columns", "phi=theta"),
        ("gnomon:RK4", "--order", "4"),
        ("--fmu", "FMU"),
        ("--fmu", "FMU", "--case", CASE, "--case", "kepler_orbit"),
        ("--fmu", "FMU", "--case", CASE, "--command", "x"),
        ("--fmu", "FMU", "--case", CASE, "--order", "0"),
        ("gnomon:RK4", "--fmu", "FMU", "--case", CASE),
        ("gnomon:leapfrog", "--fmu", "EXCHANGE", "--case", CASE),
        ("gnomon:RK4", "--fmu", "EXCHANGE", "--case", CASE, "--order", "4"),
    ],
)
def test_options_that_do_not_fit_are_one_line(
    folder: Path, options: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    files = {"FMU": str(built(folder)), "EXCHANGE": str(built(folder, kinds=EXCHANGE))}
    assert gnomon("verify", *(files.get(word, word) for word in options)) == 2
    told = capsys.readouterr().err.splitlines()
    assert len(told) == 1
    assert told[0].startswith("error: ")
