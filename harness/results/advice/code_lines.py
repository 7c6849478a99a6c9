"""Lines of Python that run a method on a system of a subject's kind, from `systems.toml`. Without the registry."""

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from gnomon.harness.contract.declared import read_declared

METHOD, SETTING = "{method}", "{setting}"
"""Placeholders in the lines, for the id of the method and for the argument of its setting."""


@cache
def systems() -> dict[str, dict[str, Any]]:
    """The systems of the file by name: their forms, subjects, time scale and code."""
    return read_declared("results", "advice/systems.toml")


def choose_system(forms: Sequence[str], subject: str | None = None) -> str | None:
    """The name of the system for a method that accepts these forms; None for a method without equations.

    It is a system of the subject if one has an accepted form, else the first system of an accepted form.
    """
    accepted = [name for form in forms for name, row in systems().items() if form in row["forms"]]
    of_subject = [name for name in accepted if subject in systems()[name]["subjects"]]
    return next(iter([*of_subject, *accepted]), None)


def code_of(system: str) -> str:
    """The lines of a system, with METHOD and SETTING in their places."""
    return str(systems()[system]["code"])


def code_for(forms: Sequence[str], method: str, subject: str | None, setting: Mapping[str, Any]) -> str | None:
    """The lines that run a method at a setting of the table of recommendations; None for a method without equations."""
    system = choose_system(forms, subject)
    if system is None:
        return None
    return code_of(system).replace(METHOD, method).replace(SETTING, argument(setting, time_scale(system)))


def time_scale(system: str) -> float:
    """The time in which the motion of a system changes, in its own unit."""
    return float(systems()[system].get("time_scale", 1.0))


def argument(setting: Mapping[str, Any], time_scale: float = 1.0) -> str:
    """The argument of `gnomon.solve` for a setting, whose steps are multiples of the time in which the motion changes."""
    if setting["kind"] == "step":
        return f"step={time_scale * setting['relative']:g}"
    return f"{setting.get('name', 'rtol')}={setting['value']:g}"
