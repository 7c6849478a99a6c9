"""`gnomon list` leaves nothing out."""

import pytest
from command_line import gnomon


def test_list_names_every_case_and_integrator(capfd: pytest.CaptureFixture[str]) -> None:
    from gnomon.harness.registry import lookup

    from gnomon import cases

    assert gnomon("list") == 0
    text = capfd.readouterr().out
    for name in (*cases.names(), *lookup.everything()):
        assert name in text
