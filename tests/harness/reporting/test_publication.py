"""The published report: written only by `make publish`, and only from measurements of the sources in the working tree."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import planted
import pytest
import synthetic
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


def sidecars(folder: Path, revision: str | None) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name in ("benchmarks", "orders", "growth"):
        found = {"launches": 5, "environment": {"revision": revision}, "rows": []}
        (folder / f"{name}.json").write_text(json.dumps(found))
    ways = {"residual": 50.0, "taylor": 50.0, "rounding": 50.0}
    row = {"case": "pendulum_simple", "variant": "default", "ways": ways, "digits": 50.0, "passed": True}
    (folder / "certificates.json").write_text(json.dumps([row | {"revision": revision}]))
    names = {"check": "moment_equipollent", "computation": "solve", "library": "numpy", "quantity": "force"}
    rest = {"variant": "default", "error": 1e-16, "seconds": 1e-5, "status": "ok", "reason": ""}
    (folder / "checks.json").write_text(json.dumps([names | rest | {"revision": revision}]))


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
        sidecars(Path("reports/local"), revision)
    return folder


@pytest.fixture
def tree(made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """The current folder is a copy of that tree; returns its revision."""
    shutil.copytree(made, tmp_path / "tree")
    monkeypatch.chdir(tmp_path / "tree")
    return git("rev-parse", "--short=12", "HEAD")


def publish() -> int:
    return publication.main(["runs/full.sqlite", "--from", "reports/local", "--to", "reports"])


@needs_git
def test_what_was_measured_is_published_with_its_revision(
    tree: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(report, "write_figures", lambda *_: None)  # they take most of the time, and tests of their own
    Path("README.md").write_text("documents may change after the measurement")
    assert publish() == 0
    assert "reports/index.html" in capsys.readouterr().out
    page = Path("reports/index.html").read_text()
    assert page.count(f"Of revision {tree}.") == 3, "orders, growth and certificates"
    for name in publication.MADE_BY:
        assert Path("reports", name).read_bytes() == Path("reports/local", name).read_bytes()


def remove(name: str) -> Callable[[], None]:
    return lambda: Path("reports/local", name).unlink()


def unfinished() -> None:
    with Store(Path("runs/full.sqlite")) as results:
        results.begin_run("catalogue", "gnomon run", {"revision": git("rev-parse", "--short=12", "HEAD")})


def edited() -> None:
    Path("harness/contract/sources.py").write_text("a = 2")


def of_an_edited_tree() -> None:
    sidecars(Path("reports/local"), git("rev-parse", "--short=12", "HEAD") + "+")


@needs_git
@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        *((remove(name), (name, "missing", command)) for name, command in publication.MADE_BY.items()),
        (lambda: Path("runs/full.sqlite").unlink(), ("full.sqlite", "no results here")),
        (unfinished, ("full.sqlite", "no finished run")),
        (edited, ("full.sqlite", "not that of these sources")),
        (lambda: commit("a = 3") and None, ("full.sqlite", "not that of these sources")),
        (of_an_edited_tree, ("benchmarks.json", "not that of these sources")),
        (lambda: sidecars(Path("reports/local"), None), ("benchmarks.json", "of revision unknown")),
        (lambda: Path("reports/local/checks.json").write_text("[1]") and None, ("checks.json", "make it again")),
        (lambda: Path("reports/local/growth.json").write_text("{}") and None, ("growth.json", "make it again")),
    ],
)
def test_what_is_missing_or_of_another_revision_is_refused_and_nothing_is_written(
    spoil: Callable[[], None], words: tuple[str, ...], tree: str, capsys: pytest.CaptureFixture[str]
) -> None:
    spoil()
    assert publish() == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("error: ")
    for word in words:
        assert word in line
    assert [path.name for path in Path("reports").iterdir()] == ["local"]


@pytest.mark.slow
def test_the_standard_run_continues_the_quick_one(tmp_path: Path) -> None:
    """In one file: measurements of the quick suite are kept, the others are added, and none is missing."""
    case, integrators = "planted:Short", [planted.Sound(), planted.NearDuplicate()]
    quick, whole = (replace(plan.suite(name).within(20.0), launches=1) for name in ("quick", "foundation"))
    path = run(tmp_path, quick, plan.choose([case], quick.variants), integrators, near_duplicates=False)
    first = store.load(path)
    assert set(first["integrator"]) == {"sound", "near_duplicate"}, "a near-duplicate runs on the default variant"
    run(tmp_path, whole, plan.choose([case], whole.variants), integrators, near_duplicates=False)
    both = store.load(path)
    alone = store.load(
        run(tmp_path / "alone", whole, plan.choose([case], whole.variants), integrators, near_duplicates=False)
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
        words[k + 1]
        for words in planned(target)
        for k, word in enumerate(words)
        if word in ("--to", "--independent", "--out")
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
