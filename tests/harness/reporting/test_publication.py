"""The published report: written only by `make publish`, and only from measurements of the sources in the working tree."""

import json
import re
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import planted
import planted_sidecars
import pytest
import synthetic
from gnomon.cases import check_names, names
from gnomon.harness.registry import lookup, selection
from gnomon.harness.reporting import publication, report
from gnomon.harness.results import store
from gnomon.harness.results.store import Store
from gnomon.harness.running import plan
from gnomon.harness.running.planned_run import run

ROOT = Path(__file__).parents[3]
MAKE, GIT = shutil.which("make"), shutil.which("git")
needs_git = pytest.mark.skipif(GIT is None, reason="git is not installed")


def git(*arguments: str) -> str:
    assert GIT is not None
    identity = ("-c", "user.name=Invented", "-c", "user.email=invented@example.org")
    done = subprocess.run([GIT, *identity, *arguments], capture_output=True, text=True, check=True)
    return done.stdout.strip()


def commit(text: str) -> str:
    Path("harness/contract").mkdir(parents=True, exist_ok=True)
    Path("harness/contract/sources.py").write_text(text)
    git("add", "harness")
    git("commit", "--quiet", "-m", text)
    return git("rev-parse", "--short=12", "HEAD")


LOCAL, REPORTS = Path("reports/local"), Path("reports")
WANTED = {
    "certificates.json": {("kepler_orbit", "default")},
    "checks.json": {("inertia_tensor_special_bodies", "default", "cubature")},
    "stability.json": {("gnomon:RK4",)},
}
"""The subjects of the planted files."""
VERIFIED: dict[str, list[str]] = {"not_measured": [], "survivors_without_reason": []}


def sidecars(revision: str | None, **others: str) -> None:
    """The files that were measured, of one revision or of others, and the findings of `gnomon verify`."""
    revisions = dict.fromkeys(publication.MADE_BY, revision)
    planted_sidecars.write(LOCAL, revisions | {f"{name}.json": other for name, other in others.items()})
    (LOCAL / "verification.json").write_text(json.dumps(VERIFIED))


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A working tree with results of its own revision."""
    folder = tmp_path_factory.mktemp("made")
    with pytest.MonkeyPatch.context() as patched:
        patched.chdir(folder)
        git("init", "--quiet")
        revision = commit("a = 1")
        Path("runs").mkdir()
        patched.setattr(synthetic, "REVISION", revision)
        synthetic.write(Path("runs/full.sqlite"))
        sidecars(revision)
    return folder


@pytest.fixture
def tree(made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """The current folder is a copy of that tree; returns its revision."""
    shutil.copytree(made, tmp_path / "tree")
    monkeypatch.chdir(tmp_path / "tree")
    return git("rev-parse", "--short=12", "HEAD")


def publish(wanted: publication.Subjects = WANTED) -> Path:
    return publication.publish(Path("runs/full.sqlite"), LOCAL, REPORTS, wanted)


@needs_git
def test_what_was_measured_is_published_with_its_revision(tree: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The page names the revision of each file. A file that takes hours may stand in reports/ already, and stays."""
    monkeypatch.setattr(report, "write_figures", lambda *_: None)  # they take most of the time, and tests of their own
    Path("README.md").write_text("documents may change after the measurement")
    revisions = {"orders": tree[:8], "growth": tree[:9], "certificates": tree[:10]}
    sidecars(tree, **revisions)
    (LOCAL / "verification.json").rename(REPORTS / "verification.json")
    page = publish().read_text()
    assert all(re.search(rf"\b{revision}\b", page) for revision in revisions.values())
    for name in (*publication.MADE_BY, "stability.json"):
        assert (REPORTS / name).read_bytes() == (LOCAL / name).read_bytes()
    assert (REPORTS / "verification.json").exists()


def unfinished() -> None:
    with Store(Path("runs/full.sqlite")) as results:
        results.begin_run("catalogue", "gnomon run", {"revision": git("rev-parse", "--short=12", "HEAD")})


def replaced(name: str, text: str) -> Callable[[], object]:
    return lambda: (LOCAL / name).write_text(text)


@needs_git
@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        *(
            ((LOCAL / name).unlink, (name, "missing", command))
            for name, command in (publication.MADE_BY | publication.KEPT).items()
        ),
        (Path("runs/full.sqlite").unlink, ("full.sqlite", "no results here")),
        (unfinished, ("full.sqlite", "no finished run")),
        (
            lambda: Path("harness/contract/sources.py").write_text("a = 2"),
            ("full.sqlite", "these sources have another"),
        ),
        (lambda: commit("a = 3"), ("full.sqlite", "these sources have another")),
        (lambda: sidecars(git("rev-parse", "HEAD") + "+"), ("benchmarks.json", "these sources have another")),
        (lambda: sidecars(None), ("benchmarks.json", "of revision unknown")),
        (replaced("checks.json", "[1]"), ("checks.json", "make it again")),
        (replaced("growth.json", "{}"), ("growth.json", "make it again")),
        *(
            (replaced("verification.json", json.dumps(VERIFIED | {key: ["a"]})), ("verification.json", key))
            for key in VERIFIED
        ),
    ],
)
def test_what_is_missing_or_of_another_revision_is_refused_and_nothing_is_written(
    spoil: Callable[[], object], words: tuple[str, ...], tree: str
) -> None:
    spoil()
    refused(WANTED, words)


@needs_git
@pytest.mark.parametrize("name", WANTED)
def test_a_file_that_lacks_a_subject_is_refused_and_nothing_is_written(name: str, tree: str) -> None:
    """A case, a check or an integrator that came after the measurement."""
    more = tuple(f"new {key}" for key in publication.PARTS[name])
    command = (publication.MADE_BY | publication.KEPT)[name]
    refused(WANTED | {name: WANTED[name] | {more}}, (name, "lacks 1 of 2", "/".join(more), command))


def refused(wanted: publication.Subjects, words: tuple[str, ...]) -> None:
    with pytest.raises(ValueError, match=re.escape(words[0])) as error:
        publish(wanted)
    assert all(word in str(error.value) for word in words)
    assert [path.name for path in REPORTS.iterdir()] == ["local"]


@needs_git
def test_the_command_refuses_in_one_line(tree: str, capsys: pytest.CaptureFixture[str]) -> None:
    Path("runs/full.sqlite").unlink()
    assert publication.main(["runs/full.sqlite", "--from", str(LOCAL), "--out", str(REPORTS)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("error: ")


def test_every_case_check_and_integrator_must_be_published() -> None:
    subjects = publication.all_subjects()
    assert {name for name, _ in subjects["certificates.json"]} == {*names(), *check_names()}
    assert {name for name, *_ in subjects["checks.json"]} <= {*check_names()}
    assert {name for (name,) in subjects["stability.json"]} == lookup.own().keys()


@pytest.mark.slow
def test_the_standard_run_continues_the_quick_one(tmp_path: Path) -> None:
    """In one file: measurements of the quick suite are kept, the others are added, and none is missing."""
    case, integrators = "planted:Short", [planted.Sound(), planted.NearDuplicate()]
    quick, whole = (replace(plan.suite(name).within(20.0), launches=1) for name in ("quick", "foundation"))
    path = run(tmp_path, quick, selection.choose([case], quick.variants), integrators, near_duplicates=False)
    first = store.load(path)
    assert set(first["integrator"]) == {"sound", "near_duplicate"}, "a near-duplicate runs on the default variant"
    run(tmp_path, whole, selection.choose([case], whole.variants), integrators, near_duplicates=False)
    both = store.load(path)
    alone = store.load(
        run(tmp_path / "alone", whole, selection.choose([case], whole.variants), integrators, near_duplicates=False)
    )
    named = ["trial_key", "launch"]
    assert both[named].sort_values(named).to_numpy().tolist() == alone[named].sort_values(named).to_numpy().tolist()
    assert set(first["measurement"]) <= set(both["measurement"]), "none was measured again"


def planned(target: str) -> list[list[str]]:
    assert MAKE is not None
    done = subprocess.run([MAKE, "-n", target], cwd=ROOT, capture_output=True, text=True, check=True)
    return [line.split() for line in done.stdout.splitlines()]


@pytest.mark.skipif(MAKE is None, reason="make is not installed")
@pytest.mark.parametrize("target", ["report", "bench", "certificates", "publish"])
def test_only_publish_writes_what_is_tracked_in_reports(target: str) -> None:
    """Every file that a command of make writes is named on its line."""
    ignored = (ROOT / ".gitignore").read_text().splitlines()
    assert {"runs/", "reports/local/"} <= {*ignored}
    written = [
        words[k + 1] for words in planned(target) for k, word in enumerate(words) if word in ("--independent", "--out")
    ]
    assert written
    tracked = [path for path in written if not path.startswith(("runs/", "reports/local"))]
    assert tracked == (["reports"] if target == "publish" else [])


@pytest.mark.skipif(MAKE is None, reason="make is not installed")
def test_a_report_begins_with_a_page_of_the_quick_suite_and_continues_in_the_same_file() -> None:
    """Each command ends before the next begins; both runs write the page anew as results come."""
    steps = [words[1:] for words in planned("report") if words and words[0].endswith("/gnomon")]
    results, page = steps[0][4], ["--report", "reports/local"]
    assert steps[0] == ["run", "--suite", "quick", "--out", results, *page]
    assert steps[-1] == ["run", "--suite", "standard", "--out", results, *page]
