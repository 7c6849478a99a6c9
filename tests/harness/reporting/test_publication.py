"""The published report: made part by part, resumed, and written only from files of one state of the sources."""

import hashlib
import itertools
import json
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import planted
import planted_sidecars
import pyarrow.parquet
import pytest
import synthetic
from gnomon.cases import check_names, names
from gnomon.harness.registry import environment, lookup, selection
from gnomon.harness.reporting import provenance, report
from gnomon.harness.reporting.publication import __main__, assembly, parts, whole
from gnomon.harness.reporting.publication.parts import Part, Place
from gnomon.harness.reporting.report_run import Run
from gnomon.harness.results import publications, store
from gnomon.harness.results.store import Store
from gnomon.harness.running import plan, recommending
from gnomon.harness.running.planned_run import run
from packaging.requirements import Requirement
from waiting import LIMIT_SECONDS, wait_until

ROOT = Path(__file__).parents[3]
MAKE = shutil.which("make")
RESULTS, REPORTS = parts.RESULTS, Path("reports")
WANTED: whole.Subjects = {
    "certificates.json": {("kepler_orbit", "default")},
    "checks.json": {("inertia_tensor_special_bodies", "default", "cubature")},
    "stability.json": {("gnomon:RK4", "linear")},
}
"""The subjects of the planted files."""
NOW = {
    "revision": "abc123abc123",
    "sources": environment.sources(),
    "machine": environment.machine(),
    "cpu": "Invented",
}
COPY = "import shutil, sys; [shutil.copy(f'made/{one}', sys.argv[1]) for one in sys.argv[2:]]"
"""In place of a measurement."""


def tiny(name: str, *files: str, **more: Any) -> Part:
    return Part(name, files[0], 2, (f"python copy.py {{}} {' '.join(files)}",), files[1:], **more)


PARTS = (
    tiny("begun", RESULTS, resumes=True),
    tiny("full", RESULTS, resumes=True),
    tiny("certificates", "certificates.json", "checks.json"),
    *(
        tiny(name, f"{name}.json")
        for name in ("benchmarks", "orders", "growth", "engines", "stability", "verification", "outside")
    ),
)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What the commands of the parts find."""
    folder = tmp_path_factory.mktemp("made")
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(synthetic, "MADE_BY", NOW)
        synthetic.write(folder / RESULTS)
    plant(folder, **NOW)
    return folder


def plant(folder: Path, **made_by: str) -> None:
    """The files beside the results, of an environment."""
    for name, content in planted_sidecars.files().items():
        (folder / name).write_text(json.dumps(content | {"environment": made_by}))


@pytest.fixture
def place(made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Place:
    """Parts that take no time, in the current folder."""
    shutil.copytree(made, tmp_path / "made")
    (tmp_path / "copy.py").write_text(COPY)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(parts, "ready", lambda: None)
    monkeypatch.setattr(whole, "CONTINUED", ("begun",))
    monkeypatch.setattr(whole, "all_subjects", lambda: WANTED)
    monkeypatch.setattr(report, "write_figures", lambda *_: None)  # they take most of the time, and tests of their own
    here = Place(Path("runs/publication"), PARTS)
    monkeypatch.setattr(__main__, "Place", PlaceOf(here))
    return here


class PlaceOf:
    """In place of the class `Place`: its folder of all publications, and tiny parts."""

    root = Place.root

    def __init__(self, place: Place) -> None:
        self.place = place

    def __call__(self, root: Path) -> Place:
        return replace(self.place, root=root)


def words(place: Place) -> dict[str, str]:
    return {state.part.name: state.word for state in place.states()}


def test_all_parts_are_measured_once_and_assembled_with_their_origin(
    place: Place, capsys: pytest.CaptureFixture[str]
) -> None:
    """Each published file names revision, sources, machine and versions; the raw results have the hash that is published."""
    assert __main__.main([]) == 0
    assert set(words(place).values()) == {"done"}
    for name in provenance.MADE_BY:
        assert (REPORTS / name).read_bytes() == (Path("made") / name).read_bytes()
    origins = provenance.origins([REPORTS], NOW)
    assert {one.file for one in origins} == set(provenance.MADE_BY)
    assert not any(one.older for one in origins)
    installed = json.loads(assembly.TABLE.with_name("engines.json").read_text())
    assert installed["rows"]
    assert all("points" not in row for row in installed["rows"])
    raw, told = Path("runs/raw.parquet").read_bytes(), json.loads((REPORTS / "raw.json").read_text())
    assert (told["sha256"], told["bytes"]) == (hashlib.sha256(raw).hexdigest(), len(raw))
    again = Path("again.parquet")
    store.export(place.folder / RESULTS, again, "parquet")
    assert again.read_bytes() == raw, "anyone who has the results file makes the same bytes"
    for line in (REPORTS / "requirements.txt").read_text().splitlines():
        assert line.startswith("#") or re.fullmatch(r"[\w.-]+==[^\s=]+", line)
        assert line.startswith("#") or Requirement(line).specifier
    table = recommending.write_table(Run.read(place.folder / RESULTS), Path("table.jsonl"), REPORTS / "outside.json")
    assert assembly.TABLE.read_bytes() == table.read_bytes(), "recommendations are of the same results"
    head = json.loads(table.read_text().splitlines()[0])
    assert {name: head[name] for name in NOW} == NOW
    assert head["margin"] == 0.1, "the table has the margin that the trial outside of the catalogue found"
    (entry,) = publications.read(REPORTS / "history.json")
    assert entry.environment["suite"] in head["suites"]
    assert entry.numbers["order/gnomon:RK4"] == 3.9487
    assert entry.numbers["trials/ok"] > 0
    before = (place.folder / RESULTS).stat().st_mtime_ns
    capsys.readouterr()
    assert __main__.main([]) == 0, "a second call measures nothing"
    assert (place.folder / RESULTS).stat().st_mtime_ns == before
    assert len(publications.read(REPORTS / "history.json")) == 1


def test_the_schema_of_the_raw_results_names_type_unit_and_meaning(made: Path, tmp_path: Path) -> None:
    """A column without values has its type too."""
    store.export(made / RESULTS, tmp_path / "raw.parquet", "parquet")
    schema = pyarrow.parquet.read_schema(tmp_path / "raw.parquet")
    assert {str(field.type) for field in schema} <= {"string", "double", "int64"}
    assert str(schema.field("turned_starts").type) == "int64"
    assert all(field.metadata[b"meaning"] for field in schema)


def test_one_part_is_measured_alone_and_a_list_measures_nothing(
    place: Place, capsys: pytest.CaptureFixture[str]
) -> None:
    assert __main__.main(["--list"]) == 0
    assert set(words(place).values()) == {"missing"}
    listed = capsys.readouterr().out
    assert all(part.name in listed for part in PARTS)
    assert __main__.main(["--part", "growth"]) == 0
    assert {name for name, word in words(place).items() if word == "done"} == {"growth"}
    assert not REPORTS.exists()


def set_clock(monkeypatch: pytest.MonkeyPatch, clock: Callable[[], float]) -> None:
    """Replace the clock by which sittings are measured and ended."""
    for module in (__main__, parts):
        monkeypatch.setattr(module, "time", SimpleNamespace(monotonic=clock))


def test_the_time_of_a_sitting_is_kept(
    place: Place, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A part that cannot be resumed is not begun if it would take longer; what remains is told."""
    set_clock(monkeypatch, lambda: 0.0)
    assert __main__.main(["--minutes", "1.5"]) == 1
    assert {name for name, word in words(place).items() if word == "done"} == {"begun", "full"}
    last = capsys.readouterr().out.splitlines()[-1]
    assert all(part.name in last for part in PARTS[2:])


WAITS = """
import pathlib, shutil, signal, sys
try:
    if not pathlib.Path("interrupted").exists():
        pathlib.Path("begun").touch()
        signal.pause()
except KeyboardInterrupt:
    pathlib.Path("interrupted").touch()
    sys.exit(130)
shutil.copy("made/growth.json", sys.argv[1])
"""
"""A command that waits for ever, until it is interrupted, and does its work when it is called again."""


def test_a_part_is_interrupted_in_time_and_goes_on(place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    """The command hears Ctrl-C, even where a shell's background job would ignore it; its time counts on."""
    Path("wait.py").write_text(WAITS)
    part = Part("growth", "growth.json", 2, ("python wait.py {}",), resumes=True)
    own = replace(place, parts=(part,))
    readings = itertools.count()

    def passing() -> float:
        """The time is over at the second reading, for which the command must have begun."""
        if next(readings) == 0:
            return 0.0
        wait_until(Path("begun").exists, "the command has begun")
        return 3.0

    ignored = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with monkeypatch.context() as patch:
            set_clock(patch, passing)
            patch.setattr(parts, "ENDING_SECONDS", LIMIT_SECONDS)
            assert not parts.measure(part, own, 2.0)
    finally:
        signal.signal(signal.SIGINT, ignored)
    assert Path("interrupted").exists()
    assert words(own) == {"growth": "begun"}
    assert own.spent(part) == 3
    assert parts.measure(part, own)
    assert words(own) == {"growth": "done"}


class Interrupted(subprocess.Popen[bytes]):
    """A command during which a user types Ctrl-C, once it has begun; it hears nothing of it."""

    def wait(self, timeout: float | None = None) -> int:
        wait_until(Path("begun").exists, "the command has begun")
        signal.raise_signal(signal.SIGINT)
        raise AssertionError("not interrupted")


def test_ctrl_c_tells_what_remains(
    place: Place, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("wait.py").write_text(WAITS)
    waiting = Part("growth", "growth.json", 2, ("python wait.py {}",), resumes=True)
    monkeypatch.setattr(__main__, "Place", PlaceOf(replace(place, parts=(waiting,))))
    monkeypatch.setattr(
        parts, "subprocess", SimpleNamespace(Popen=Interrupted, TimeoutExpired=subprocess.TimeoutExpired)
    )
    monkeypatch.setattr(parts, "_await_end", lambda process: process.kill())  # a terminal would send Ctrl-C to it too
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs ignore it
    try:
        assert __main__.main([]) == 130
    finally:
        signal.signal(signal.SIGINT, before)
    assert "remaining: growth" in capsys.readouterr().out


def failing(name: str) -> Callable[[Place], object]:
    return lambda place: Path("copy.py").write_text(f"import sys; sys.exit('{name}.json' in sys.argv)")


def replaced(name: str, **keys: Any) -> Callable[[Place], object]:
    def change(place: Place) -> None:
        path = Path("made") / name
        path.write_text(json.dumps(json.loads(path.read_text()) | keys))

    return change


def unfinished(place: Place) -> None:
    with Store(Path("made") / RESULTS) as results:
        results.begin_run("catalogue", "gnomon run", NOW)


def lacks(name: str) -> Callable[[Place], object]:
    return lambda place: (Path("made") / name).unlink()


@pytest.mark.parametrize(
    ("spoil", "told"),
    [
        *((lacks(name), (name.removesuffix(".json"),)) for name in ("growth.json", "certificates.json")),
        (failing("growth"), ("results.sqlite",)),
        (unfinished, (RESULTS, "no finished run")),
        (replaced("growth.json", rows=[{}]), ("growth.json", "make it again")),
        (replaced("certificates.json", rows=[]), ("certificates.json", "lacks 1 of 1", "kepler_orbit/default")),
        (replaced("checks.json", rows=[]), ("checks.json", "lacks 1 of 1")),
        (replaced("stability.json", rows=[]), ("stability.json", "lacks 1 of 1")),
        (replaced("verification.json", not_measured={"a": "b"}), ("verification.json", "not_measured")),
        (replaced("verification.json", survivors_without_reason=["a"]), ("verification.json", "survivors")),
        (replaced("orders.json", environment=NOW | {"sources": "others"}), ("orders.json", "other sources")),
        (replaced("orders.json", environment={}), ("orders.json", "other sources")),
    ],
)
def test_what_is_missing_or_of_other_sources_is_refused_in_one_line_and_nothing_is_written(
    spoil: Callable[[Place], object], told: Sequence[str], place: Place, capsys: pytest.CaptureFixture[str]
) -> None:
    spoil(place)
    assert __main__.main([]) == 2
    (line,) = [one for one in capsys.readouterr().err.splitlines() if one.startswith("error: ")]
    assert all(word in line for word in told), line
    assert not REPORTS.exists()


def test_older_parts_are_named_and_their_numbers_are_not_of_this_revision(
    place: Place, capsys: pytest.CaptureFixture[str]
) -> None:
    """A file that was measured with other sources, or that stands in reports/ already, is published again, if asked."""
    assert __main__.main(["--with-older"]) == 2, "without results there is nothing to publish"
    for name in ("begun", "full", "growth"):
        assert __main__.main(["--part", name]) == 0
    elsewhere = place.root / "othersources-machine"
    shutil.copytree("made", elsewhere)
    plant(elsewhere, **NOW | {"revision": "def456", "sources": "others", "date": "2026-01-02"})
    for part in PARTS[2:]:
        if part.name not in ("orders", "growth"):
            (elsewhere / "done").mkdir(exist_ok=True)
            record = {"environment": {"revision": "def456"}, "installed": {}, "seconds": 600, "done": True}
            (elsewhere / "done" / f"{part.name}.json").write_text(json.dumps(record))
    assert words(place)["stability"] == "older"
    assert {state.part.name: state.minutes for state in place.states()}["stability"] == 10, "as it took before"
    REPORTS.mkdir()
    (REPORTS / "orders.json").write_text(json.dumps({"environment": {}, "rows": [planted_sidecars.ORDER]}))
    assert __main__.main(["--with-older"]) == 0
    origins = {one.file: one for one in provenance.origins([REPORTS], NOW)}
    assert {name for name, one in origins.items() if not one.older} == {"growth.json"}
    assert (origins["stability.json"].revision, origins["stability.json"].date) == ("def456", "2026-01-02")
    told = [line.split()[1].rstrip(",") for line in capsys.readouterr().out.splitlines() if line.startswith("older: ")]
    assert {*told} == {name for name, one in origins.items() if one.older}
    (entry,) = publications.read(REPORTS / "history.json")
    assert not any(name.startswith(("order/", "certificates/")) for name in entry.numbers)


def test_a_file_of_results_is_published_without_the_paths_of_its_machine(made: Path, place: Place) -> None:
    """Under a name that the reader's machine can have too: relative, or the name alone."""
    REPORTS.mkdir()
    plant(REPORTS, **NOW)
    outside = made / RESULTS
    assert (
        __main__.main(["--with-older", "--results", str(outside), "--raw", str(Path.cwd() / "runs/raw.parquet")]) == 0
    )
    for path in filter(Path.is_file, REPORTS.rglob("*")):
        for folder in (made, Path.cwd(), Path(sys.prefix)):
            assert str(folder).encode() not in path.read_bytes(), path
    command = json.loads((REPORTS / "raw.json").read_text())["command"]
    assert command.split()[:3] == ["gnomon", "export", RESULTS]
    assert command.endswith("--out runs/raw.parquet")


def test_figures_of_an_earlier_publication_are_gone(place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also one that no manifest lists: it would be published as of this run."""

    def write(run: Run, work: object, charts: object, folder: Path) -> None:
        (folder / "figures.json").write_text('["kept"]')
        (folder / "kept.svg").touch()

    (REPORTS / "figures").mkdir(parents=True)
    (REPORTS / "figures" / "charge_in_E.svg").touch()
    monkeypatch.setattr(report, "write_figures", write)
    assert __main__.main([]) == 0
    assert {path.name for path in (REPORTS / "figures").iterdir()} == {"figures.json", "kept.svg"}


def test_a_table_that_is_too_large_publishes_nothing(place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recommending, "MOST_BYTES", 1000)
    assert __main__.main([]) == 2
    assert not REPORTS.exists()
    assert not assembly.TABLE.exists()


def test_raw_results_that_are_too_large_are_refused(place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(assembly, "MOST_BYTES", 1000)
    assert __main__.main([]) == 2
    assert not REPORTS.exists()


def test_packages_of_several_versions_are_refused(place: Place, capsys: pytest.CaptureFixture[str]) -> None:
    for part in PARTS:
        assert __main__.main(["--part", part.name]) == 0
    path = place.folder / "done" / "growth.json"
    record = json.loads(path.read_text())
    path.write_text(json.dumps(record | {"installed": record["installed"] | {"numpy": "0.1"}}))
    assert __main__.main([]) == 2
    assert "another version of numpy" in capsys.readouterr().err


@pytest.mark.parametrize("arguments", [["--part", "nothing"], ["--minutes", "0"], ["--results", "a.sqlite"]])
def test_bad_input_is_told_in_one_line(arguments: list[str], place: Place, capsys: pytest.CaptureFixture[str]) -> None:
    assert __main__.main(arguments) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("error: ")
    assert arguments[1] in line


def test_a_library_that_lacks_and_sources_without_a_revision_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """A published time names its revision; and all libraries of the README take part."""
    monkeypatch.setattr(environment, "describe", lambda: {"revision": "abc123+"})
    with pytest.raises(ValueError, match=r"abc123\+: commit"):
        parts.ready()
    monkeypatch.setattr(environment, "describe", lambda: {"revision": "abc123"})
    monkeypatch.setattr(lookup, "missing", lambda one: "not here" if one.library == "rebound" else None)
    with pytest.raises(ValueError, match=r"^rebound: not installed"):
        parts.ready()


def test_every_part_takes_at_most_75_minutes_and_all_take_six_hours() -> None:
    assert max(part.minutes for part in parts.PARTS) <= 75
    assert sum(part.minutes for part in parts.PARTS) <= 360
    assert {name for name in Place().files if name != RESULTS} == set(provenance.MADE_BY)


def test_every_command_of_a_part_is_one_that_gnomon_has() -> None:
    """Each names a program of PROGRAMS, and files or modules that exist."""
    for part in parts.PARTS:
        for each in part.commands:
            words = parts.arguments(each, Path("folder"))
            assert words[0] == sys.executable
            assert str(Path("folder") / part.file) in words or each != part.commands[-1], "the last one writes the file"
            for word in each.split():
                assert (ROOT / word).is_file() or not word.startswith("tests/"), word


def test_every_case_check_and_integrator_must_be_published() -> None:
    subjects = whole.all_subjects()
    assert {name for name, _ in subjects["certificates.json"]} == {*names(), *check_names()}
    assert {name for name, *_ in subjects["checks.json"]} <= {*check_names()}
    assert {name for name, _ in subjects["stability.json"]} == lookup.general().keys()
    assert {scene for _, scene in subjects["engines.json"]} == {*plan.SUITES["engines"].scope.cases}


@pytest.mark.slow
def test_the_standard_run_continues_the_quick_one(tmp_path: Path) -> None:
    """In one file: measurements of the quick suite are kept, the others are added, and none is missing."""
    case, integrators = "planted:Short", [planted.Sound(), planted.NearDuplicate()]
    quick, whole = (plan.suite(name).within(300.0).change(launches=1) for name in ("quick", "foundation"))
    path = run(tmp_path, quick, selection.choose([case], quick.scope.variants), integrators, near_duplicates=False)
    first = store.load(path)
    assert set(first["integrator"]) == {"sound", "near_duplicate"}, "a near-duplicate runs on the default variant"
    run(tmp_path, whole, selection.choose([case], whole.scope.variants), integrators, near_duplicates=False)
    both = store.load(path)
    alone = store.load(
        run(
            tmp_path / "alone",
            whole,
            selection.choose([case], whole.scope.variants),
            integrators,
            near_duplicates=False,
        )
    )
    named = ["trial_key", "launch"]
    assert both[named].sort_values(named).to_numpy().tolist() == alone[named].sort_values(named).to_numpy().tolist()
    assert set(first["measurement"]) <= set(both["measurement"]), "none was measured again"


def planned(target: str) -> list[list[str]]:
    assert MAKE is not None
    done = subprocess.run([MAKE, "-n", target], cwd=ROOT, capture_output=True, text=True, check=True)
    return [line.split() for line in done.stdout.splitlines()]


@pytest.mark.skipif(MAKE is None, reason="make is not installed")
@pytest.mark.parametrize("target", ["report", "bench", "certificates", "publication"])
def test_only_publication_writes_what_is_tracked_in_reports(target: str) -> None:
    """Every file that a command of make writes is named on its line."""
    ignored = (ROOT / ".gitignore").read_text().splitlines()
    assert {"runs/", "reports/local/"} <= {*ignored}
    written = [
        words[k + 1] for words in planned(target) for k, word in enumerate(words) if word in ("--independent", "--out")
    ]
    assert written
    tracked = [path for path in written if not path.startswith(("runs/", "reports/local"))]
    assert tracked == (["reports"] if target == "publication" else [])


@pytest.mark.skipif(MAKE is None, reason="make is not installed")
def test_a_report_begins_with_a_page_of_the_quick_suite_and_continues_in_the_same_file() -> None:
    """Each command ends before the next begins; both runs write the page anew as results come."""
    steps = [words[1:] for words in planned("report") if words and words[0].endswith("/gnomon")]
    results, page = steps[0][4], ["--report", "reports/local"]
    assert steps[0] == ["run", "--suite", "quick", "--out", results, *page]
    assert steps[-1] == ["run", "--suite", "standard", "--out", results, *page]
