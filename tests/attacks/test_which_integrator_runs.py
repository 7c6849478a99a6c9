"""The given object runs: not the default of its class, nor another object with its id."""

import importlib
import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from importlib.metadata import EntryPoint
from pathlib import Path
from types import ModuleType
from typing import Any

import planted
import pytest
from command_line import gnomon
from gnomon.harness.cluster import identity
from gnomon.harness.contract.problem import problem_of
from gnomon.harness.registry import lookup, references, selection
from gnomon.harness.results import store
from gnomon.harness.running import plan
from gnomon.reference.storage import import_closure
from waiting import LIMIT_SECONDS, LONG_SECONDS

from gnomon import compare

CASE = "pendulum_simple"
THETAS = """
import numpy as np
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.contract.integrator import Integrator, Solution, Steps, each_start, Solver


class Theta(Integrator):
    '''y + h ((1 - theta) f(y) + theta f(y + h f(y))): of order 2 for theta = 1/2, else of order 1.'''

    name, library = "theta", "mine"
    accepts, sweep = (FirstOrder,), Steps(0.5, 7)

    def __init__(self, theta=0.0):
        self.theta = theta

    def weight(self):
        return self.theta

    def prepare(self, problem, setting):
        equations, numbers, weight = problem.form.equations, tuple(problem.parameters.tolist()), self.weight()

        def f(y):
            problem.buffer[-1] += 1
            return np.array(equations(0.0, tuple(y.tolist()), numbers))

        def follow(y, out):
            count = round(problem.interval / setting)
            for row in out:
                for _ in range(count):
                    slope = f(y)
                    y = y + setting * ((1 - weight) * slope + weight * f(y + setting * slope))
                row[:] = y
            return count * len(out), None

        return Solver(each_start(problem, follow))


class Half(Theta):
    '''Theta(0.5) of another id, whose class has the number.'''

    name = "half"

    def weight(self):
        return 0.5


class Told(Theta):
    '''Its number comes from a function that it is given.'''

    name = "told"

    def weight(self):
        return self.theta()


class Forgets(Theta):
    def __reduce__(self):
        return Forgets, ()


class Wakes(Theta):
    def __setstate__(self, state):
        raise OSError("asleep")


class Keeps(Theta):
    '''Nothing of it is lost, though a lock is made anew, and though its texts may become other objects.'''

    name = "keeps"

    def __init__(self, theta=0.0):
        self.theta, self.kind, self.words = theta, "kind", {"b", "a", "kind"}
        self.__setstate__(vars(self))

    def __getstate__(self):
        return {name: value for name, value in vars(self).items() if name != "lock"}

    def __setstate__(self, state):
        import threading

        vars(self).update(state)
        self.lock = threading.Lock()


class Compares(Theta):
    def __eq__(self, other):
        return self.theta == other.theta


class Named(Told):
    '''Holds a function without a name, so that only the module that holds it can make it again.'''

    name = "named"


class Listed(Named):
    name = "listed"


half = Theta(0.5)
named = Named(lambda: 0.5)
INTEGRATORS = [Theta, Listed(lambda: 0.5)]
"""
"""A module of a user."""
HELPERS = "def a_half():\n    return 0.5\n"


def written(folder: Path, name: str, text: str) -> ModuleType:
    (folder / f"{name}.py").write_text(text, encoding="utf-8")
    sys.modules.pop(name, None)
    importlib.invalidate_caches()
    import_closure.forget()
    return importlib.import_module(name)


@pytest.fixture(scope="module")
def thetas(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    folder = tmp_path_factory.mktemp("modules")
    sys.path.insert(0, str(folder))
    written(folder, "helping_thetas", HELPERS)
    yield written(folder, "thetas_of_a_user", THETAS)
    sys.path.remove(str(folder))


@pytest.fixture(scope="module")
def half(thetas: Any) -> dict[float, float]:
    """The errors by step size of the class that has the number itself."""
    return errors(compare(planted.Short(), thetas.Half, limit_seconds=LONG_SECONDS).frame(), "mine:half")


def errors(frame: Any, identity: str) -> dict[float, float]:
    rows = frame[(frame["integrator_id"] == identity) & (frame["status"] == "ok")]
    return dict(zip(rows["setting"], rows["error_max"], strict=True))


def are_alike(found: dict[float, float], expected: dict[float, float]) -> None:
    """Both have order 2, which no other number of the method gives."""
    both = found.keys() & expected.keys()
    assert len(both) >= 4
    assert [found[step] for step in both] == pytest.approx([expected[step] for step in both], rel=1e-6)
    assert all(expected[step] < 20 * step**2 for step in both)


def test_an_object_runs_with_its_own_numbers(thetas: Any, half: dict[float, float]) -> None:
    held = importlib.import_module("helping_thetas").a_half
    given = [thetas.half, thetas.Keeps(0.5), thetas.Told(held), thetas.named, thetas.INTEGRATORS[1]]
    frame = compare(planted.Short(), given, limit_seconds=LONG_SECONDS).frame()
    for name in ("theta", "keeps", "told", "named", "listed"):
        are_alike(errors(frame, f"mine:{name}"), half)


def test_an_object_of_a_module_runs_from_the_command_line(
    thetas: Any, half: dict[float, float], tmp_path: Path
) -> None:
    out = tmp_path / "results.sqlite"
    asked = ("--case", "planted:Short", "--integrator", f"{thetas.__name__}:half", "--suite", "quick")
    assert gnomon("run", *asked, "--limit", str(LONG_SECONDS), "--out", str(out)) == 0
    are_alike(errors(store.load(out), "mine:theta"), half)


NOTEBOOK = """
import json
from gnomon.cases.core.forms import FirstOrder
from gnomon import compare
from planted import Short
from thetas_of_a_user import Told, Theta


class Mine(Theta):
    name = "defined here"

    def weight(self):
        return self.theta()


mine = Mine(lambda: 0.5)


class Mine(Theta):
    name = "its class was defined anew"


def a_half():
    return 0.5


found = compare(Short(), [mine, Told(a_half)], limit_seconds=900.0)
print(json.dumps(found.frame()[["integrator_id", "status", "setting", "error_max"]].to_dict("list")))
"""


def test_what_a_notebook_defines_runs_as_it_is(half: dict[float, float], tmp_path: Path) -> None:
    """A class that its name no longer reaches, a function without a name, and a function given to a module's object."""
    import pandas

    script = tmp_path / "notebook.py"
    script.write_text(NOTEBOOK)
    paths = os.pathsep.join(path for path in sys.path if path)
    ran = subprocess.run(
        [sys.executable, script],
        capture_output=True, text=True, timeout=LIMIT_SECONDS, check=False, env=os.environ | {"PYTHONPATH": paths},
    )  # fmt: skip
    assert ran.returncode == 0, ran.stderr
    frame = pandas.DataFrame(json.loads(ran.stdout.splitlines()[-1]))
    for name in ("mine:defined here", "mine:told"):
        are_alike(errors(frame, name), half)


@pytest.mark.parametrize("later", ["another object", "a class", "nothing"])
def test_a_worker_refuses_another_integrator_at_the_place_of_the_given_one(
    thetas: Any, later: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An object that cannot be pickled travels as its place in a list, and the file may have changed in between."""
    held = {"another object": thetas.half, "a class": thetas.Half}
    for given, name, value in (
        (thetas.INTEGRATORS[1], "INTEGRATORS", [thetas.Theta, *([held[later]] if later in held else [])]),
        (thetas.named, "named", held.get(later)),
    ):
        reference = references.reference(given)
        assert references.dereference(reference) is given
        monkeypatch.setattr(thetas, name, value)
        with pytest.raises(ValueError, match=f"{name}.* is not {given.id} any more"):
            references.dereference(reference)


def local(thetas: Any) -> Any:
    class Local(thetas.Theta):  # type: ignore[misc, name-defined]
        name = "local"

    return Local(0.5)


def unnamed(_thetas: Any) -> Any:
    from gnomon.harness.verification.function_adapter import from_step

    return from_step(lambda f, t, y, h: y + h * f(t, y), name="unnamed", order=1)


LOST: dict[str, tuple[Callable[[Any], Any], str]] = {
    "a class within a function": (local, "mine:local: a worker process cannot make"),
    "a function without a name": (lambda t: t.Told(lambda: 0.5), "mine:told: a worker process cannot make"),
    "a file that is open": (lambda t: t.Theta(open(os.devnull)), "mine:theta: a worker process cannot make"),  # noqa: SIM115
    "a pickle without its number": (lambda t: t.Forgets(0.5), "mine:theta: .*its theta becomes another"),
    "a pickle that cannot be read": (lambda t: t.Wakes(0.5), "mine:theta: .*OSError: asleep"),
    "a step without a variable": (unnamed, "mine:unnamed: a worker process cannot make"),
}


@pytest.mark.parametrize("what", LOST)
def test_what_a_worker_could_not_make_again_is_refused_by_name(thetas: Any, what: str) -> None:
    make, words = LOST[what]
    with pytest.raises(ValueError, match=words):
        compare(CASE, [make(thetas)])


def test_two_objects_of_one_id_are_refused(thetas: Any, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    words = "two integrators have the id mine:theta"
    with pytest.raises(ValueError, match=words):
        compare(CASE, [thetas.Theta(0.0), thetas.Theta(0.5)])
    named = [f"--integrator={thetas.__name__}:{name}" for name in ("half", "Theta")]
    for command in (["run", "--case", CASE, "--out", str(tmp_path / "a.sqlite")], ["stability"]):
        assert gnomon(*command, *named) == 2
        assert words in " ".join(capfd.readouterr().err.split())
    assert not (tmp_path / "a.sqlite").exists()


def test_the_id_of_one_that_comes_with_gnomon_is_refused(
    thetas: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From a path, as an object, and from an installed package, which would otherwise run in the place of gnomon's."""
    module = written(
        Path(thetas.__file__).parent,
        "false_names",
        f"from {thetas.__name__} import Theta\nclass RK4(Theta):\n    name, library = 'RK4', 'gnomon'\n",
    )
    for given in ("false_names:RK4", module.RK4, module.RK4()):
        with pytest.raises(ValueError, match="gnomon:RK4 comes with gnomon; give yours a name"):
            compare(CASE, [given])
    points = [EntryPoint(name, f"{thetas.__name__}:{name}", lookup.GROUP) for name in ("half", "Theta")]
    points.append(EntryPoint("false", "false_names:RK4", lookup.GROUP))
    monkeypatch.setattr(lookup, "entry_points", lambda group: points)
    with pytest.warns(
        UserWarning, match=r"Theta \(.*\) cannot be loaded: .*another package registers mine:theta"
    ) as said:
        found = lookup.everything()
    assert any("gnomon:RK4 comes with gnomon" in str(one.message) for one in said)
    assert found["mine:theta"] is thetas.half
    assert found["gnomon:RK4"] is lookup.own()["gnomon:RK4"]


def keys(integrator: Any) -> set[str]:
    ((case, label),) = selection.choose([CASE], False)
    (series,) = plan.list_series([(case, label)], [integrator], formulations=False)
    return {trial.key for trial in series.trials(problem_of(case, integrator.accepts))}


def test_a_result_of_another_object_is_not_reused(thetas: Any) -> None:
    """Objects of one class and one id differ in their values; a trial of one object does not count for the other."""
    assert keys(thetas.Theta(0.5)) == keys(thetas.half)
    assert not keys(thetas.Theta(0.5)) & keys(thetas.Theta(0.25))
    folder = Path(thetas.__file__).parent
    told = [
        keys(thetas.Told(written(folder, "helping_thetas", text).a_half)) for text in (HELPERS, HELPERS, "\n" + HELPERS)
    ]
    assert told[0] == told[1]
    assert not told[0] & told[2]


def test_an_object_that_was_made_again_has_the_same_trials(thetas: Any) -> None:
    """The workers of a cluster name trials as the client does, and have the modules that the client has."""
    for one in (thetas.Keeps(0.5), thetas.half, thetas.named, lookup.own()["gnomon:RK4"]):
        again = references.dereference(references.reference(one))
        assert keys(again) == keys(one)
    told = thetas.Told(importlib.import_module("helping_thetas").a_half)
    wanted = identity.identity([], [told])
    assert {f"module {thetas.__name__}", "module helping_thetas"} <= wanted.keys()
    assert identity.difference(wanted) is None


def test_an_integrator_without_a_hash_is_refused_with_the_way_out(thetas: Any) -> None:
    """Plans and caches hold integrators as keys."""
    with pytest.raises(ValueError, match=r"no hash; with @dataclass write @dataclass\(eq=False\)"):
        compare(CASE, [thetas.Compares()])
