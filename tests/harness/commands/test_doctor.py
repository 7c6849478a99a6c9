"""`gnomon doctor`, and the message about a missing library."""

import pytest
from command_line import gnomon


@pytest.mark.parametrize(
    ("library", "python", "told"),
    [
        ("rebound", (3, 13, 0), "rebound is not installed: pip install 'gnomon[nbody]'"),
        ("heyoka", (3, 11, 0), "heyoka is not installed: pip install 'gnomon[peers]'"),
        ("sksundae", (3, 11, 0), "sksundae is not installed: pip install 'gnomon[peers]'"),
        ("diffrax", (3, 11, 0), "diffrax is not installed: pip install 'gnomon[peers]'"),
        ("pybullet", (3, 11, 9), "pybullet is not installed: pip install 'gnomon[engines]'"),
        ("pybullet", (3, 12, 0), "pybullet has wheels up to CPython 3.11 only"),
    ],
)
def test_what_is_missing_is_named_with_what_installs_it(
    library: str, python: tuple[int, ...], told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    from gnomon.harness.registry import lookup

    monkeypatch.setattr(lookup.sys, "version_info", python)
    assert lookup.absent(library) == told


def test_doctor_says_what_is_here(capfd: pytest.CaptureFixture[str]) -> None:
    assert gnomon("doctor") == 0
    text = capfd.readouterr().out
    assert "numpy" in text
    assert "rebound" in text
