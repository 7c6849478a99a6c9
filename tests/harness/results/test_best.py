"""The fastest measured method names those from which its launches do not separate it."""

from typing import Any

import pytest
from gnomon.harness.contract.status import Status
from gnomon.harness.results.best import best


def _row(name: str, seconds: float, launch: int = 1, **changed: Any) -> dict[str, Any]:
    return {
        "case": "c", "variant": "", "formulation": "", "integrator_id": name, "machine": "m", "run": 1, "launch": launch,
        "setting": 1e-6, "setting_kind": "tolerance", "status": Status.OK, "error_max": 1e-7, "floor": 1e-16,
        "seconds_median": seconds, "prepare_seconds": 0.0, "delay_seconds": None,
    } | changed  # fmt: skip


def _lines(method: str, setting: float, kind: str) -> str:
    return method


def test_a_method_that_is_nearly_as_fast_is_named() -> None:
    """With one launch each a scatter is assumed that leaves 5 % open, but not a factor of five."""
    found = best([_row("x:a", 1.0), _row("x:b", 1.05), _row("x:c", 5.0)], 1e-6, _lines)
    assert found.method == "x:a"
    (other,) = found.equally_fast
    assert other.startswith("x:b ")
    assert "x:b" in str(found)
    assert "x:c" not in str(found)


@pytest.mark.parametrize("second", [1.0, 3.0])
def test_the_time_is_that_of_all_launches(second: float) -> None:
    """Their geometric mean: a method that was faster in one launch alone is not the fastest."""
    rows = [_row("x:a", 1.0), _row("x:a", second, launch=2), _row("x:b", 1.2), _row("x:b", 1.2, launch=2)]
    found = best(rows, 1e-6, _lines)
    assert found.method == ("x:a" if second == 1.0 else "x:b")
    assert found.seconds == pytest.approx(1.0 if second == 1.0 else 1.2)


@pytest.mark.parametrize(
    ("floor", "words"), [(1e-2, "may itself be wrong by 1.0e-2"), (14.0, "no reference at the end")]
)
def test_where_the_reference_is_the_limit_the_methods_are_not_blamed(floor: float, words: str) -> None:
    with pytest.raises(ValueError, match=words) as raised:
        best([_row("x:a", 1.0, floor=floor)], 1e-6, _lines)
    assert "no method" not in str(raised.value)
