"""Infinitely many events in a finite time, as the impacts of a ball that comes to rest: how a method says so."""

from gnomon.cases.core.forms import Hybrid, Transition

MOST_RAPID = 1000
"""More consecutive rapid events count as an accumulation. An event is rapid if it occurs again within `settle`, or
within the spacing of times."""


def accumulation(form: Hybrid, transition: Transition, t: float) -> str:
    """The reason for an end at an accumulation of a transition, and how to state the motion after it."""
    limit = next((mode for name, mode, _ in form.limits if name == transition.name), None)
    settle = f"settle = {form.settle:g}"
    where = f"events accumulate at t = {t:.9g}: `{transition.name}` occurs without end"
    if limit is not None:
        return f"{where}; the form enters its limit mode `{limit}` only if it occurs twice within {settle} s: give more"
    more = f"`settle` ({form.settle:g} s)" if form.settle > 0 else f"`settle`, above 0 s (now {settle})"
    return (
        f'{where}. State the mode after it in the form: limits=(("{transition.name}", mode, map of the state),), entered'
        f" once it occurs twice within {more}"
    )
