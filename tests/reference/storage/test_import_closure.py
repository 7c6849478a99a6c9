"""The key of a result changes with each source that it depends on, in folders too, and with no other."""

import importlib
import sys
from fractions import Fraction

import pytest
from gnomon.reference.numerics import certified, table
from gnomon.reference.storage import diskcache, import_closure
from gnomon.reference.storage.import_closure import closure, modules_of

SOURCES = {
    "__init__": '"""Exports."""\nfrom closed.unused import NOTHING\n__all__ = ["NOTHING"]\n',
    "unused": "NOTHING = 0\n",
    "scenes/__init__": "",
    "scenes/plane/__init__": "",
    "scenes/plane/swing": "from closed.motions.plane.circle import Circle\n",
    "scenes/plane/fall": "import closed.motions.plane.line\n",
    "motions/__init__": "",
    "motions/plane/__init__": "",
    "motions/plane/circle": "from ..tools import turning\n\nclass Circle:\n    angle = turning.angle\n",
    "motions/plane/line": "def place():\n    from closed.motions.tools.adding import total\n    return total\n",
    "motions/tools/__init__": "",
    "motions/tools/turning": "def angle():\n    from . import numbers\n",
    "motions/tools/numbers": "PI = 3\n",
    "motions/tools/adding": "def total():\n    pass\n",
}
DEPENDS = {
    "swing": {"scenes/plane/swing", "motions/plane/circle", "motions/tools/turning", "motions/tools/numbers"},
    "fall": {"scenes/plane/fall", "motions/plane/line", "motions/tools/adding"},
}


@pytest.fixture(autouse=True)
def package(tmp_path, monkeypatch):
    """The package `closed`, and a cache that is empty."""
    monkeypatch.setattr(diskcache, "folder", lambda: tmp_path / "results")
    for name, text in SOURCES.items():
        write(tmp_path / "closed" / name, text)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    import_closure.forget()
    yield tmp_path / "closed"
    import_closure.forget()
    for name in [name for name in sys.modules if name.partition(".")[0] == "closed"]:
        del sys.modules[name]


def write(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.with_suffix(".py").write_text(text)


def key(name):
    import_closure.forget()
    return closure(f"closed.scenes.plane.{name}")


@pytest.mark.parametrize("scene", DEPENDS)
@pytest.mark.parametrize("edited", [name for name in SOURCES if not name.endswith("__init__")])
def test_a_key_changes_with_what_its_module_imports_and_with_nothing_else(package, scene, edited):
    """Every source is edited in turn: relative imports and those inside functions count, two folders down too."""
    before = key(scene)
    write(package / edited, SOURCES[edited] + "# edited\n")
    assert (key(scene) != before) == (edited in DEPENDS[scene])


def test_a_package_counts_where_importing_it_does_something(package):
    before = key("swing")
    write(package / "motions/__init__", '"""Exports."""\nfrom closed import unused\n')
    assert key("swing") == before, "it imports, and no more"
    write(package / "motions/__init__", "from closed import unused\nunused.NOTHING = 1\n")
    acting = key("swing")
    assert acting != before
    write(package / "unused", "NOTHING = 2\n")
    assert key("swing") != acting, "the modules with which it acts count too"


def test_a_module_that_moves_is_another(package):
    before = key("swing")
    (package / "motions/tools/turning.py").rename(package / "motions/plane/turning.py")
    write(package / "motions/plane/circle", SOURCES["motions/plane/circle"].replace("..tools", "."))
    assert key("swing") != before


def test_a_module_without_a_package_counts_with_its_neighbours(tmp_path):
    """A user may keep a case and its helper in two files of one folder."""
    write(tmp_path / "lone_case", "import lone_helper\nimport json\n")
    keys = set()
    for text in ("x = 1\n", "x = 1\n", "x = 2\n"):
        write(tmp_path / "lone_helper", text)
        import_closure.forget()
        keys.add(closure("lone_case"))
    assert len(keys) == 2
    write(tmp_path / "another", "x = 3\n")
    import_closure.forget()
    assert closure("lone_case") in keys


def test_what_has_no_file_has_no_key():
    """A class of a notebook has no file: its results are not kept."""
    assert closure("there_is_no_such_module") is None
    assert closure("closed.scenes.plane.swing", "there_is_no_such_module") is None


def test_the_closure_of_a_case_has_its_motion_and_not_the_list_of_cases():
    """A new line in the registry, or another case, leaves the kept results of this case valid."""
    own = closure("gnomon.cases.pendulums.pendulum_simple")
    assert own != closure("gnomon.cases.oscillators.duffing_unforced")
    reached = import_closure.sources("gnomon.cases.pendulums.pendulum_simple")
    assert {"gnomon.reference.pendulums.pendulum_simple", "gnomon.reference.numerics.elliptic"} <= reached.keys()
    assert not [name for name in reached if "registry" in name or ".orbits." in name or ".harness" in name]


MOTION = """
from dataclasses import dataclass
from fractions import Fraction
from gnomon.reference.numerics.motion import Motion
from .deeper.speeds import speed

@dataclass(frozen=True)
class Steady(Motion):
    start: Fraction

    def _guard(self, t):
        return 2

    def _state(self, mp, t):
        return [mp.mpf(self.start) + speed() * mp.mpf(t)]
"""


def steady(package, speed):
    """A motion in a folder of the package, whose speed stands in a file one folder further down."""
    for name, text in {"kept/__init__": "", "kept/steady": MOTION, "kept/deeper/__init__": ""}.items():
        write(package / name, text)
    write(package / "kept/deeper/speeds", f"def speed():\n    return {speed}\n")
    for name in [name for name in sys.modules if name.startswith("closed.kept")]:
        del sys.modules[name]
    importlib.invalidate_caches()
    import_closure.forget()
    return importlib.import_module("closed.kept.steady").Steady(Fraction(1))


def test_a_table_is_built_again_where_a_source_two_folders_down_was_edited(package, monkeypatch):
    """A table from before the edit would give states of another motion."""
    built = []
    build = table.build
    monkeypatch.setattr(table, "build", lambda *given: built.append(given) or build(*given))
    found = []
    for speed in (2, 2, 3):
        monkeypatch.setattr(table, "_kept", {})
        motion = steady(package, speed)
        table._cells(motion, ((Fraction(0), Fraction(1)),), 10_000)
        found.append(len(built))
        write(package / "unused", f"NOTHING = {speed}\n")
    assert found == [1, 1, 2]


def test_states_of_a_certified_motion_are_computed_again_where_its_rates_were_edited(package, monkeypatch):
    computed = []
    monkeypatch.setattr(
        certified.CertifiedMotion, "sample_each", lambda self, times: computed.append(self) or times[:, None]
    )
    rates = "from .deeper.speeds import speed\n\ndef rates(t, state):\n    return (speed(),)\n"
    found = []
    for speed in (2, 2, 3):
        write(package / "kept/rates", rates)
        steady(package, speed)
        field = importlib.import_module("closed.kept.rates").rates
        motion = certified.CertifiedMotion("steady", (Fraction(1),), Fraction(1), field)
        assert "closed.kept.rates" in modules_of(motion)
        motion.sample(certified.np.array([0.5, 1.0]))
        found.append(len(computed))
    assert found == [1, 1, 2]


def test_a_table_is_kept_for_its_pieces_and_its_numbers(package, monkeypatch):
    built = []
    build = table.build
    monkeypatch.setattr(table, "build", lambda *given: built.append(given) or build(*given))
    motion = steady(package, 2)
    for one, last in ((motion, 1), (motion, 2), (type(motion)(Fraction(2)), 1), (motion, 1)):
        monkeypatch.setattr(table, "_kept", {})
        table._cells(one, ((Fraction(0), Fraction(last)),), 10_000)
    assert len(built) == 3


def test_states_are_kept_for_their_times(package, monkeypatch):
    monkeypatch.setattr(certified.CertifiedMotion, "sample_each", lambda self, times: times[:, None])
    write(package / "kept/rates", "def rates(t, state):\n    return (1,)\n")
    steady(package, 2)
    field = importlib.import_module("closed.kept.rates").rates
    motion = certified.CertifiedMotion("steady", (Fraction(1),), Fraction(1), field)
    for times in ([0.5, 1.0], [0.25, 1.0], [0.5, 1.0]):
        assert motion.sample(certified.np.array(times))[:, 0].tolist() == times


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("return STEP", "return 2 * STEP"),
        ("STEP = 1", "STEP = 3"),
        ("return self.size", "return -self.size"),
        ("return 1 / STEP", "return 2 / STEP"),
    ],
    ids=["function", "constant", "method", "decorated function"],
)
def test_what_was_loaded_before_an_edit_has_no_key(tmp_path, old, new):
    """A process that runs while its sources are edited computes with the old code: under a key of the new text its results
    would be served to users who run the new code."""
    text = "STEP = 1\nclass Ball:\n    def radius(self):\n        return self.size\ndef step():\n    return STEP\n"
    text += "from numba import njit\n@njit\ndef inverse():\n    return 1 / STEP\n"
    write(tmp_path / "closed/edited_while_running", text)
    importlib.import_module("closed.edited_while_running")
    assert closure("closed.edited_while_running", within=()) is not None
    write(tmp_path / "closed/edited_while_running", text + "# more\n")
    import_closure.forget()
    assert closure("closed.edited_while_running") is not None, "the code is the same"
    write(tmp_path / "closed/edited_while_running", text.replace(old, new))
    import_closure.forget()
    assert closure("closed.edited_while_running", within=()) is None
    assert closure("closed.edited_while_running") is None
