"""The reference solutions that come with gnomon are those that its sources compute, and others are computed again."""

import random
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gnomon.harness.measuring import reference_solution
from gnomon.harness.measuring.reference_solution import PACK, CaseSpec, ReferenceSolution
from gnomon.harness.running.kept_solutions import specs
from gnomon.reference.storage import diskcache

from gnomon import cases

MOST_BYTES = 5 * 2**20


def read_pack(spec: CaseSpec) -> ReferenceSolution | None:
    key = reference_solution._key(spec)
    assert key is not None
    content = diskcache._packed(PACK).get(diskcache._name(key))
    return None if content is None else reference_solution._read(diskcache._entry(content))


FEW = 10
"""A solution costs up to 40 s. Each has the hash of its sources in its key, so that only the way in and out of the file, or
the arithmetic of another machine, could make it differ: both show in any solution."""


def test_a_seeded_few_are_what_the_sources_compute() -> None:
    """Exact states have the same bits; conditioning is a sum of float64, which libraries of other machines may round
    otherwise. One that was made from other sources is not used, and not compared."""
    for spec in random.Random(21).sample(specs(), FEW):
        kept = read_pack(spec)
        if kept is None:
            assert reference_solution.reference_solution(spec).exact.shape == (64, len(spec.initial_state))
            continue
        made = reference_solution._compute(spec)
        for name in ReferenceSolution.__dataclass_fields__:
            rounding = 1e-12 if name in ("conditioning", "sizes") else 0.0
            np.testing.assert_allclose(
                getattr(kept, name), getattr(made, name), rtol=rounding, atol=0, err_msg=f"{spec.path}: {name}"
            )


@pytest.mark.slow
def test_all_default_cases_are_in_the_pack() -> None:
    """`make solutions` renews it after a change of cases/ or reference/; until then such cases take their time."""
    lost = [spec.path for spec in specs() if read_pack(spec) is None]
    assert lost == [], "`make solutions` writes harness/measuring/reference_solutions.zip"
    assert PACK.stat().st_size < MOST_BYTES


@pytest.mark.filterwarnings("ignore:.*damaged")
def test_an_absent_or_damaged_pack_costs_only_time(tmp_path: Path) -> None:
    entry = diskcache.Entry({"numbers": np.arange(3.0)}, ["a note"])
    pack = tmp_path / "pack.zip"
    diskcache.write_pack(pack, {"key": entry})
    found = diskcache.load("key", pack)
    assert found is not None
    assert found.notes == ["a note"]
    np.testing.assert_array_equal(found.arrays["numbers"], np.arange(3.0))
    assert diskcache.load("other", pack) is None
    damaged = tmp_path / "damaged.zip"
    damaged.write_bytes(pack.read_bytes()[:-40])
    assert diskcache.load("key", damaged) is None
    assert diskcache.load("key", tmp_path / "absent.zip") is None


def test_a_solution_of_the_pack_is_not_computed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A user's first run would else wait for minutes; a case of other numbers is not in the pack."""
    spec = CaseSpec.of(cases.get("harmonic_oscillator").rounded())
    other = CaseSpec.of(cases.get("harmonic_oscillator", k="3").rounded())
    key, pack = reference_solution._key(spec), tmp_path / "pack.zip"
    assert key is not None
    diskcache.write_pack(pack, {key: reference_solution._entry(reference_solution._compute(spec))})
    monkeypatch.setattr(reference_solution, "PACK", pack)
    monkeypatch.setattr(diskcache, "folder", lambda: tmp_path / "empty")

    def fail(spec: CaseSpec) -> Any:
        raise AssertionError(spec)

    monkeypatch.setattr(reference_solution, "_compute", fail)
    assert reference_solution.reference_solution(spec).exact.shape == (64, 2)
    with pytest.raises(AssertionError):
        reference_solution.reference_solution(other)
