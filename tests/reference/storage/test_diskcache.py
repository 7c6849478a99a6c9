"""The cache returns the kept results, and never a damaged file."""

import numpy as np
import pytest
from gnomon.reference.storage import diskcache
from gnomon.reference.storage.diskcache import Entry, cached


@pytest.fixture
def home(tmp_path, monkeypatch):
    monkeypatch.setattr(diskcache, "folder", lambda: tmp_path / "results")
    return tmp_path / "results"


class Builder:
    """Counts its calls."""

    def __init__(self):
        self.calls = 0

    def __call__(self):
        self.calls += 1
        return Entry({"x": np.array([1.0, np.pi, -0.0])}, {"period": "2.5", "rows": [1, 2]})


def test_second_call_reads_what_the_first_one_kept(home):
    build = Builder()
    first, second = cached("key", build), cached("key", build)
    assert build.calls == 1
    assert first.arrays["x"].tobytes() == second.arrays["x"].tobytes()
    assert second.notes == {"period": "2.5", "rows": [1, 2]}


def test_another_key_is_another_entry(home):
    build = Builder()
    cached("key", build)
    cached("key2", build)
    assert build.calls == 2


@pytest.mark.parametrize(
    "damage", [lambda b: b[:-1], lambda b: b"", lambda b: b[:-9] + b"\1" + b[-8:], lambda b: b * 2]
)
def test_damaged_file_is_built_anew(home, damage):
    build = Builder()
    cached("key", build)
    (path,) = home.glob("*.bin")
    path.write_bytes(damage(path.read_bytes()))
    assert cached("key", build).notes["period"] == "2.5"
    assert build.calls == 2
    cached("key", build)
    assert build.calls == 2


def test_file_of_another_key_is_not_read(home):
    """A file moved onto another key's name fails its code, which covers the name."""
    build = Builder()
    cached("a", build)
    (path,) = home.glob("*.bin")
    content = path.read_bytes()
    path.unlink()
    cached("b", build)
    (other,) = home.glob("*.bin")
    other.write_bytes(content)
    cached("b", build)
    assert build.calls == 3


def test_in_a_folder_that_cannot_be_written_entries_are_built_and_not_kept(home):
    home.parent.mkdir(exist_ok=True)
    home.write_text("a file where the folder should be")
    build = Builder()
    with pytest.warns(UserWarning, match="cannot be written"):
        assert cached("key", build).notes["period"] == "2.5"


def test_reserved_array_name_is_refused(home):
    with pytest.raises(ValueError, match="notes"):
        diskcache.store("key", Entry({"notes": np.zeros(1)}))
