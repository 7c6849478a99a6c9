"""The reference solutions that come with gnomon: a damaged or exchanged entry is computed anew and never believed."""

import random
import re
import struct
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gnomon.harness.measuring import reference_solution
from gnomon.harness.measuring.reference_solution import CaseSpec
from gnomon.reference.storage import diskcache

from gnomon import cases

KEYS = ("first", "second", "third")
LOCAL, CENTRAL = b"PK\x03\x04", b"PK\x01\x02"
RANDOM_CHANGES = 150


@pytest.fixture
def pack(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A pack of three entries, each the number of its key; nothing else is kept on disk."""
    monkeypatch.setattr(diskcache, "folder", lambda: tmp_path / "empty")
    path = tmp_path / "pack.zip"
    diskcache.write_pack(path, {key: diskcache.Entry({"number": np.array([n])}) for n, key in enumerate(KEYS)})
    return path


@pytest.fixture(autouse=True)
def _quiet() -> Iterator[None]:
    """A warning of damage is expected, and is tested by itself."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def numbers(pack: Path) -> list[int | None]:
    """The entry under each key."""
    diskcache._packed.cache_clear()
    found = [diskcache.load(key, pack) for key in KEYS]
    return [None if entry is None else int(entry.arrays["number"][0]) for entry in found]


def with_header(content: bytes, number: int, local: int, value: int) -> bytes:
    """A zip file in whose entry of this number two bytes of both headers are replaced; `local` is their place in the local
    header, which in the central one is two bytes further."""
    changed = bytearray(content)
    for mark, place in ((LOCAL, local), (CENTRAL, local + 2)):
        start = [found.start() for found in re.finditer(re.escape(mark), content)][number]
        struct.pack_into("<H", changed, start + place, value)
    return bytes(changed)


HEADERS: dict[str, tuple[int, int]] = {
    "encrypted": (6, 1), "patched": (6, 1 << 5), "strongly encrypted": (6, 1 << 6), "method 99": (8, 99),
    "lzma": (8, 14), "bzip2": (8, 12), "stored": (8, 0), "version 14.8": (4, 148),
}  # fmt: skip


@pytest.mark.parametrize("change", HEADERS)
def test_an_entry_that_zipfile_cannot_read_is_absent(change: str, pack: Path) -> None:
    """zipfile raises RuntimeError, NotImplementedError or the error of a decompressor: each cold run ended with it."""
    assert numbers(pack) == [0, 1, 2], "the pack is sound before"
    content = pack.read_bytes()
    for entry in range(len(KEYS)):
        pack.write_bytes(with_header(content, entry, *HEADERS[change]))
        found = numbers(pack)
        assert found.count(None) == (len(KEYS) if change == "version 14.8" else 1), (
            "zipfile does not open such a version"
        )
        assert all(number in (None, right) for right, number in enumerate(found))


def test_contents_that_are_permuted_among_entries_are_not_believed(pack: Path) -> None:
    """Each content is whole and has the right CRC: only its binding to a name shows that it is another case's motion."""
    content = pack.read_bytes()
    first, second = (diskcache._name(key).encode() for key in KEYS[:2])
    swapped = content.replace(first, b"?" * len(first)).replace(second, first).replace(b"?" * len(first), second)
    pack.write_bytes(swapped)
    assert numbers(pack) == [None, None, 2]


def test_no_random_change_is_believed_or_raises(pack: Path) -> None:
    content, chance = pack.read_bytes(), random.Random(37)
    lost = 0
    for _ in range(RANDOM_CHANGES):
        changed = bytearray(content)
        for _ in range(chance.choice((1, 1, 4))):
            changed[chance.randrange(len(changed))] ^= 1 << chance.randrange(8)
        pack.write_bytes(changed)
        found = numbers(pack)
        assert all(number in (None, right) for right, number in enumerate(found)), bytes(changed)
        lost += None in found
    assert lost > RANDOM_CHANGES // 4, "most bytes of a pack are content or structure"


@pytest.mark.parametrize("change", ["encrypted", "version 14.8"])
def test_a_damaged_pack_is_computed_with_one_warning(
    change: str, tmp_path: Path, pack: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first run takes longer then, and the warning says why."""
    spec = CaseSpec.of(cases.get("harmonic_oscillator").rounded())
    key, computed = reference_solution._key(spec), []
    assert key is not None
    true: Callable[[CaseSpec], Any] = reference_solution._compute
    diskcache.write_pack(pack, {key: reference_solution._entry(true(spec))})
    pack.write_bytes(with_header(pack.read_bytes(), 0, *HEADERS[change]))
    diskcache._packed.cache_clear()
    monkeypatch.setattr(reference_solution, "PACK", pack)
    monkeypatch.setattr(reference_solution, "_compute", lambda given: computed.append(given) or true(given))
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        for _ in range(2):
            assert reference_solution.reference_solution(spec).exact.shape == (64, 2)
    assert computed == [spec], "the second time it is in the cache"
    (warning,) = told
    assert str(warning.message).startswith(f"{pack}: damaged")


def test_the_pack_that_comes_with_gnomon_is_sound() -> None:
    """Every entry can be read and is bound to its name, or every user would be told to install gnomon again."""
    diskcache._packed.cache_clear()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(diskcache._packed(reference_solution.PACK)) > 100
