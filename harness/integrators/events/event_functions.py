"""Compile the functions of a hybrid form as one function, which the loop of steps calls by address."""

from dataclasses import replace

from gnomon.cases.core.forms import Equations, Hybrid, Mode, Transition
from gnomon.harness.contract.sources import cache_by_content
from gnomon.harness.kernels import emission, ir
from gnomon.harness.kernels.equations import Kernel, check_source, check_values, content, write


def compile_parts(form: Hybrid, dimension: int, parameters: int) -> int:
    """Address of the functions of a form, compiled as one: out[0] selects the function, and out[:] gets its values.

    Their sequence: the right-hand side of each mode, which also adds 1 to p[parameters]; the guard of each transition,
    signed so that it is positive before the event; the reset of each transition; its map into the limit mode, or its
    reset if it has no limit mode.
    """
    plain = tuple(replace(transition, target="") for transition in form.transitions)  # a target is not compiled
    return _parts(form.modes, plain, form.limits, dimension, parameters).address


@cache_by_content
def _parts(
    modes: tuple[Mode, ...],
    transitions: tuple[Transition, ...],
    limits: tuple[tuple[str, str, Equations], ...],
    dimension: int,
    parameters: int,
) -> Kernel:
    maps = {name: to_limit for name, _, to_limit in limits}
    resets = [g.reset for g in transitions]
    to_limits = [maps.get(g.name, g.reset) for g in transitions]
    functions = [*(m.equations for m in modes), *(g.guard for g in transitions), *resets, *to_limits]
    first_guard, first_reset = len(modes), len(modes) + len(transitions)
    for k, function in enumerate(functions):
        given = parameters + (len(modes[k].constants) if k < first_guard else 0)
        check_values(function, (dimension, given), 1 if first_guard <= k < first_reset else dimension)
        check_source(function, set())

    def body(t: ir.Value, y: ir.Array, p: ir.Array, out: ir.Array) -> None:
        translation, which = emission.Translation(), emission.integer(out[0])
        for k, function in enumerate(functions):
            for chosen in ir.branch(which == k):
                if chosen:
                    constants = modes[k].constants if k < first_guard else ()
                    values = translation.inline(function)(t, content(y), (*content(p), *constants))
                    if first_guard <= k < first_reset:
                        values = (-transitions[k - first_guard].direction * values[0],)
                    write(out, values)
                    if k < first_guard:
                        count = ir.Array(p.pointer, (parameters + 1,))
                        count[parameters] += 1.0

    prints = [emission.fingerprint(function) for function in functions]
    key = f"{[m.constants for m in modes]} {[g.direction for g in transitions]}"
    return Kernel("\n".join([key, *prints]), body, (dimension, parameters, dimension))
