"""The comparison of times with another version of a package: its rule, the installation, and both in one command.

No test compares two times of the clock that are close: the rule is tested on given times, and the command on a version
that does ten times the work.
"""

import json
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from command_line import gnomon
from gnomon.harness.verification import against
from gnomon.harness.verification.against import LAUNCHES, finding
from gnomon.harness.verification.claims import Finding, Outcome
from gnomon.harness.verification.other_version import Other, install, validate_requirement

METHOD = """
def step(f, t, y, h):
    for _ in range({work}):
        a = f(t, y)
        b = f(t + h / 2, y + h / 2 * a)
        c = f(t + h / 2, y + h / 2 * b)
        d = f(t + h, y + h * c)
    return y + h / 6 * (a + 2 * b + 2 * c + d)
"""
VERIFIED = """
from gnomon.verify import from_step
from paced import step

mine = from_step(step, name="RK4", order=4)
"""
PENDULUM = ("--case", "pendulum_simple", "--depth", "low", "--claim", "time")


def wheel(folder: Path, version: str, work: int, name: str = "paced") -> Path:
    """A wheel of a package whose step does `work` times the work; it installs without a network and without a build."""
    info = f"{name}-{version}.dist-info"
    files = {
        f"{name}/__init__.py": METHOD.format(work=work),
        f"{name}/verified.py": VERIFIED,
        f"{info}/METADATA": f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n",
        f"{info}/WHEEL": "Wheel-Version: 1.0\nGenerator: test\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
    }
    files[f"{info}/RECORD"] = "".join(f"{path},,\n" for path in [*files, f"{info}/RECORD"])
    made = folder / f"{name}-{version}-py3-none-any.whl"
    with zipfile.ZipFile(made, "w") as archive:
        for path, text in files.items():
            archive.writestr(path, text)
    return made


@pytest.fixture
def present(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Version 2.0, which does ten times the work, is installed."""
    with zipfile.ZipFile(wheel(tmp_path, "2.0", work=10)) as archive:
        archive.extractall(tmp_path / "installed")
    monkeypatch.syspath_prepend(tmp_path / "installed")
    yield
    for name in [name for name in sys.modules if name.partition(".")[0] == "paced"]:
        del sys.modules[name]


def launches(*ratios: float, null: float = 0.0) -> list[dict[str, Any]]:
    """Launches whose times, without null calls, have these ratios."""
    return [
        {"seconds": [ratio + null, 1.0 + null], "null": [null, null], "error": [1e-6, 1e-6], "named": "h = 1"}
        for ratio in ratios
    ]


def found(*ratios: float, null: float = 0.0) -> Finding:
    return finding(launches(*ratios, null=null), "paced 1.0")


def test_slower_is_what_every_launch_shows_beyond_the_factor_that_noise_has() -> None:
    """The range of the launches holds their median: if it holds 1.2, the difference may be smaller."""
    slower = found(1.25, 1.3, 1.22, 1.4, 1.3)
    assert (slower.outcome, slower.setting) == (Outcome.FAILED, "h = 1")
    assert slower.expected == "at most 1.2 times the time of paced 1.0"
    assert slower.got.startswith("1.3 times the time of paced 1.0 (1.22 to 1.4 over 5 launches)")
    assert slower.why
    for ratios in ((1.0,) * 5, (1.3, 1.3, 1.3, 1.3, 1.19), (0.7, 0.8, 0.7, 0.84, 0.8), (0.1, 1.0, 10.0, 1.0, 1.0)):
        none = found(*ratios)
        assert none.outcome == Outcome.PASSED
        assert none.got.startswith("no difference of 1.2 times or more is shown: ")
    assert found(0.5, 0.6, 0.8, 0.4, 0.5).got.startswith("faster: 0.5 times the time of paced 1.0 (0.4 to 0.8 ")


def test_the_null_call_is_subtracted_and_a_time_that_is_mostly_overhead_is_not_compared() -> None:
    assert found(1.3, 1.3, 1.3, 1.3, 1.3, null=0.9).outcome == Outcome.FAILED, "with the null call it is 1.16 times"
    overhead = found(10.0, 10.0, 10.0, 10.0, 10.0, null=30.0)
    assert overhead.outcome == Outcome.NOT_APPLICABLE
    assert "is its overhead" in overhead.why


def test_a_version_that_declines_the_case_is_not_compared() -> None:
    declined = finding([{"declined": "paced 1.0: no"}, *launches(9.0)], "paced 1.0")
    assert (declined.outcome, declined.why) == (Outcome.NOT_APPLICABLE, "paced 1.0: no")


@pytest.mark.parametrize(
    "nonsense",
    ["", " ", "-r x", "--index-url=http://x", "paced==", "paced 1.0", "paced==1 --pre", "p\0q", "p\n-r x", "no/p.whl", "p.whl",
     "https://x.org/p.whl", "paced;1"],
)  # fmt: skip
def test_what_is_no_requirement_is_refused_before_an_installer_sees_it(nonsense: str) -> None:
    """An installer takes a word that begins with a dash as an option of its own."""
    with pytest.raises(ValueError, match=r"--against .*give a requirement as mypackage==1\.2, or the path of"):
        validate_requirement(nonsense)


@pytest.mark.parametrize(
    "sound", ["paced", "paced==1.2", "a.b_c[fast,more] >= 1.0, < 2", "paced~=1.2rc1", "paced @ https://x.org/p.whl"]
)
def test_requirements_are_accepted(sound: str) -> None:
    assert validate_requirement(sound) == sound


def test_a_wheel_is_installed_beside_the_environment(tmp_path: Path) -> None:
    other = install(str(wheel(tmp_path, "1.0", work=1)))
    assert (other.label, other.modules) == ("paced 1.0", ("paced",))
    assert (Path(other.folder) / "paced" / "verified.py").is_file()
    assert other.folder not in sys.path


def test_what_cannot_be_installed_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("PIP_NO_INDEX", "UV_NO_INDEX", "UV_OFFLINE"):
        monkeypatch.setenv(name, "1")
    with pytest.raises(ValueError, match=r"--against paced==9\.9: cannot be installed \(.*paced") as told:
        install("paced==9.9")
    assert "\n" not in str(told.value)
    with pytest.raises(ValueError, match="gnomon times both versions"):
        install(str(wheel(tmp_path, "9.9", 1, name="gnomon")))


class Answers:
    """A process that has imported these files."""

    def __init__(self, *files: str) -> None:
        self.files = files

    def ask(self, line: str, seconds: float) -> str:
        return json.dumps({"version": "2.0", "files": self.files})


def test_one_version_in_both_processes_is_an_error() -> None:
    other = Other("/other", "paced", "1.0", ("paced",))
    here, there = Answers("/here/paced/__init__.py"), Answers("/other/paced/__init__.py")
    told = against._list_loaded(here, there, other)  # type: ignore[arg-type]
    assert told == "paced 2.0 (/here/paced/__init__.py) against 1.0 (/other/paced/__init__.py)"
    with pytest.raises(ValueError, match=r"both processes load /here/paced/__init__\.py"):
        against._list_loaded(here, here, other)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="the integrator does not import paced"):
        against._list_loaded(here, Answers(), other)  # type: ignore[arg-type]


def compared(folder: Path, capsys: pytest.CaptureFixture[str]) -> str:
    """The output of the command on version 2.0 against 1.0; its exit code is 1 and its files hold the comparison."""
    before, files = str(wheel(folder, "1.0", work=1)), (folder / "a.json", folder / "a.md")
    written = ("--json", str(files[0]), "--markdown", str(files[1]))
    assert gnomon("verify", "paced.verified:mine", *PENDULUM, "--against", before, *written) == 1
    result = json.loads(files[0].read_text())
    assert result["against"]["requirement"] == before
    ((row,),) = [result["rows"]]
    assert (row["claim"], row["outcome"]) == ("time", "failed")
    assert row["command"].endswith(f"--claim time --depth low --against {before}")
    assert "| time | pendulum\\_simple |" in files[1].read_text()
    return capsys.readouterr().out


@pytest.mark.slow
@pytest.mark.usefixtures("present")
def test_a_version_that_does_ten_times_the_work_is_slower(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(against, "LAUNCHES", 1)
    monkeypatch.setattr(against, "ROUNDS", 1)
    shown = compared(tmp_path, capsys)
    assert "expected: at most 1.2 times the time of paced 1.0" in shown
    assert f"time: paced 2.0 ({tmp_path}/installed/paced/__init__.py) against 1.0 (" in shown


@pytest.mark.slow
@pytest.mark.usefixtures("present")
def test_five_launches_show_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert LAUNCHES == 5
    assert "over 5 launches)" in compared(tmp_path, capsys)
