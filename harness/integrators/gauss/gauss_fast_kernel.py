"""The fast Gauss method compiled for the equations of one case: the generated module and what is substituted in it."""

from __future__ import annotations

import hashlib
import re
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from gnomon.cases.core.forms import Form, SecondOrder
from gnomon.harness.contract.integrator import Refused
from gnomon.harness.contract.sources import cached_by_content
from gnomon.harness.integrators.gauss import gauss_fast_ensemble, gauss_fast_text
from gnomon.harness.kernels.derivatives import jacobian
from gnomon.harness.kernels.equations import INNER, OPTIONS
from gnomon.harness.kernels.equations import compiled as compiled_function
from gnomon.harness.kernels.staged_code import code, expensive, pairs, poles
from gnomon.harness.kernels.traced import ROUND, Node, Trace, Value, number, reached, traced

SIGNATURE = (
    '"int64(float64[::1], float64[:, ::1], float64[:, ::1], float64[::1], float64, float64[:, :, ::1], int64[::1])"'
)

LANES = ("lanes", "lanes_math", "gauss_fast_text")

MOST_NEWTON = 3
"""The derivatives are used up to this number of components."""

FEWEST_GROUPED, MOST_GROUPS = 8, 3
"""From this number of components on a round is done in groups, of which there are at most MOST_GROUPS. Each group waits
for the one before it, which costs no time only in a large round: Kepler's orbit in Sundman time, with five components,
takes two thirds of the rounds and the same time."""


@dataclass(frozen=True)
class Layout:
    """What is substituted into the stepping: the unknown slopes, and the derivatives where they save time.

    `kind`: the name of the templates' substitutions: FIRST_ORDER for y' = f(t, y), SECOND_ORDER for q'' = a(t, q),
    WITH_VELOCITY for q'' = a(t, q, q'). `derivatives`: (slope, component of the state, value) of each that is not 0.
    `frozen`: components of the state that never change; the equations take them after the parameters. `groups`: slopes
    that are computed together in a round, one group after the other; empty where all are computed together.
    """

    kind: str
    values: tuple[Value, ...]
    derivatives: tuple[tuple[int, int, Value], ...]
    frozen: tuple[int, ...] = ()
    groups: tuple[tuple[int, ...], ...] = ()

    @property
    def all_values(self) -> tuple[Value, ...]:
        return (*self.values, *(value for _, _, value in self.derivatives))

    @property
    def poles(self) -> tuple[Value, ...]:
        """The divisors of the slopes that may change their sign."""
        return poles(self.values)

    @property
    def second_order(self) -> bool:
        return self.kind != "FIRST_ORDER"


@cached_by_content
def layout(form: Form, parameters: int, dimension: int, freezing: bool = True) -> Layout:
    """The layout with which the equations of a form are solved in the least time. Raises Refused where they branch."""
    trace = Trace(dimension, parameters)
    try:
        values = traced(form, trace)
    except ValueError as error:
        raise Refused(str(error)) from None
    kind, half, state = "FIRST_ORDER", dimension // 2, trace.state
    if isinstance(form, SecondOrder):
        kind, state = "SECOND_ORDER", state[:half]
    elif dimension % 2 == 0 and all(x is y for x, y in zip(values[:half], state[half:], strict=True)):
        kind, values = "WITH_VELOCITY", values[half:]
    elif freezing and 0 < len(still := [i for i, value in enumerate(values) if number(value, 0)]) < dimension:
        trace = Trace(dimension, parameters, tuple(still))
        both = (traced(form, trace), trace.state)
        values, state = (tuple(x for i, x in enumerate(of) if i not in still) for of in both)
        return laid_out(kind, values, state, tuple(still))
    return laid_out(kind, values, state)


def laid_out(kind: str, values: tuple[Value, ...], state: tuple[Node, ...], frozen: tuple[int, ...] = ()) -> Layout:
    found = derivatives(values, state)
    grouped = kind == "FIRST_ORDER" and not found and len(values) >= FEWEST_GROUPED
    return Layout(kind, values, found, frozen, groups(values, state) if grouped else ())


def groups(values: Sequence[Value], state: Sequence[Node]) -> tuple[tuple[int, ...], ...]:
    """Groups of slopes independent of one another, from the last component to the first: v' = a(q), then q' = v with the
    new v.

    Where that takes more than MOST_GROUPS, a slope joins the group with the fewest slopes that it is coupled with.
    """
    place = {x: i for i, x in enumerate(state)}
    needs = [{place[x] for x in reached([value]) if x in place} for value in values]
    found: list[list[int]] = []
    for i in reversed(range(len(values))):
        met = [sum(i in needs[j] or j in needs[i] for j in group) for group in found]
        if min(met, default=1) > 0 and len(found) < MOST_GROUPS:
            found.append([i])
        else:
            found[met.index(min(met))].append(i)
    return tuple(tuple(sorted(group)) for group in found) if len(found) > 1 else ()


def derivatives(values: Sequence[Value], state: Sequence[Node]) -> tuple[tuple[int, int, Value], ...]:
    """Those that are not 0; none where computing them takes more time than they save."""
    if len(values) > MOST_NEWTON or not any(expensive(x) for x in reached(values) if x.level == ROUND):
        return ()
    places = [(i, j) for i in range(len(values)) for j in range(len(state))]
    found = zip(places, jacobian(values, state), strict=True)
    return tuple((i, j, value) for (i, j), value in found if not number(value, 0))


@cached_by_content
def compiled(form: Form, parameters: int, dimension: int, counted: bool) -> Callable[..., int]:
    """`advance(parameters, table, initial, times, tolerance, out, stop)` around the equations of a form."""
    found = layout(form, parameters, dimension)
    count = len(found.values)
    frequency, control = step_control(found)
    stages = "".join(
        given(gauss_fast_text.STAGES_OF_A_STEP.replace("NAME", name).replace("INLINE", inline), seen)
        for name, inline, seen in (("stages", "forceinline=True,", frequency), ("aside", "", NO_FREQUENCY))
    )
    words = getattr(gauss_fast_text, found.kind)
    sums = words["sums"].replace("\n    ", "\n        ").replace("first", "STAGES").replace("once", "ONCE")
    by_turns = any(x.level == ROUND for pair in pairs(reached(found.all_values)).values() for x in pair)
    slopes = gauss_fast_text.SLOPES_BY_TURNS if by_turns else gauss_fast_text.SLOPES
    rounds = {"round": gauss_fast_text.ROUND, "slopes": slopes, "correct": correction(found), "sums_of_a_round": sums}
    rounds["legendre"] = gauss_fast_text.LEGENDRE_OF_ONE if count == 1 else gauss_fast_text.LEGENDRE_OF_MANY
    words = rounds | words | over_poles(len(found.poles)) | control
    body = stages + gauss_fast_text.ADVANCE
    if found.groups:
        words |= round_by_groups(found)
    body = given(body, words)
    module = filled(body.replace("SIGNATURE", SIGNATURE), found, count, parameters, dimension, counted)
    run: Callable[..., int] = compiled_function(module, "advance")
    return run


@cached_by_content
def compiled_ensemble(
    form: Form, parameters: int, dimension: int, counted: bool
) -> tuple[Callable[..., int], tuple[int, int]]:
    """`advance_eight(parameters, table, initial, times, tolerance, out, left_over, work)` and the shape of `work`."""
    found = layout(form, parameters, dimension, False)
    count = len(found.values)
    words = getattr(gauss_fast_text, found.kind)
    entries = [(i, j) for i, j, _ in found.derivatives]
    body, rows = gauss_fast_ensemble.text(getattr(gauss_fast_ensemble, found.kind), entries, count, len(found.poles))
    at_start = "<|y[@], |>" + ("<|y[N + @], |>" if found.kind == "WITH_VELOCITY" else "")
    body = body.replace("{placed_at_start}", at_start)
    for word in ("placed", "rate", "first"):
        body = body.replace("{" + word + "}", words[word])
    body = body.replace("TOGETHER", gauss_fast_ensemble.SIGNATURE)
    module = gauss_fast_ensemble.over_stages(filled(body, found, count, parameters, dimension, counted))
    return compiled_function(module, "advance_eight"), (rows, 8)


def filled(body: str, found: Layout, count: int, parameters: int, dimension: int, counted: bool) -> str:
    """The text of a module. It holds a hash of the sources of the lanes, so that an edit there compiles it again."""
    body = expanded(body, count, dimension - len(found.frozen))
    body = body.replace("N + ", f"{count} + ").replace("CORRECTED", str(bool(found.derivatives)))
    moving = [i for i in range(dimension) if i not in found.frozen]
    body = re.sub(r"(initial\[n|out\[n, sample), (\d+)\]", lambda x: f"{x[1]}, {moving[int(x[2])]}]", body)
    body = body.replace("FROZEN", "; ".join(f"out[n, sample, {i}] = initial[n, {i}]" for i in found.frozen) or "pass")
    given = [*(f"p_[{i}], " for i in range(parameters)), *(f"initial[n, {i}], " for i in found.frozen)]
    body = body.replace("PARAMETERS", "".join(given))
    body = body.replace("COUNT", f"p_[{parameters}] += 8 *") if counted else re.sub(r"\n *COUNT.*", "", body)
    equations = code(found.all_values, found.groups, found.poles)
    parts = (f"# {lanes_digest()}", gauss_fast_text.HEAD, *equations, body)
    return "\n".join(parts).replace("OPTIONS", OPTIONS).replace("INNER", INNER)


def correction(found: Layout) -> str:
    """The lines of a round that correct its new slopes g: with derivatives, by the changes that these predict."""
    if not found.derivatives:
        return "g@ = lanes(g[@])"
    count = len(found.values)
    lines = ["d@ = lanes(g[@]) - f@", "{shift}", "g@ = lanes(g[@])"]
    early, late = ["if exactly:", "    {stage_residual}"] if found.second_order else [], []
    for n, (i, j, _value) in enumerate(found.derivatives):
        place = found.second_order and j < count
        moves = ("hh * hh", "q") if place else ("hh", "r" if found.second_order else "q")
        # Terms that are known before the products are multiplied first, so that little waits for the products.
        early += [f"    g{i} = fma(lanes(g[{count + n}]), s{j}, g{i})"] if place else []
        late.append(f"g{i} = fma(lanes(g[{count + n}]) * ({moves[0]}), {moves[1]}[{j % count}], g{i})")
    return "\n        ".join(lines + early + late)


NO_FREQUENCY = {"squares": "", "at_end": "0.0"}


def given(body: str, words: Mapping[str, str]) -> str:
    """A text with its words in braces replaced, in their order: a replacement may contain words that come after it."""
    for word, meaning in words.items():
        body = body.replace("{" + word + "}", meaning)
    return body


def step_control(found: Layout) -> tuple[dict[str, str], dict[str, str]]:
    """Substitutions in the stages and in the stepping for the choice of step sizes.

    Equal steps, or also steps from the frequency, whose fourth power is the square of the norm of J.
    """
    count = len(found.values)
    by_position = [n for n, (_, j, _) in enumerate(found.derivatives) if found.second_order and j < count]
    equal = gauss_fast_text.EQUAL_STEPS.strip()
    if not by_position:
        return NO_FREQUENCY, {"none_seen": "", "shorter": "", "control": indented(equal, 12)}
    square = " + ".join(f"g[{count + n}] * g[{count + n}]" for n in by_position)
    # Extrapolated to the end of the step by a polynomial that may be inaccurate, so limited by the last stage's value.
    at_end = "min(max(total(row(table, ENDS) * squares), 0.25 * lane(squares, 7)), 4 * lane(squares, 7))"
    return {"squares": f"squares = lanes({square})", "at_end": at_end}, {
        "none_seen": indented(gauss_fast_text.NONE_SEEN.strip(), 8),
        "shorter": "stride = h * step_frequency",
        "control": indented(gauss_fast_text.BY_FREQUENCY.strip() + "\n" + textwrap.indent(equal, " " * 4), 12),
    }


def over_poles(count: int) -> dict[str, str]:
    """Substitutions in the stepping that keep a step from passing one of `count` poles."""
    if not count:
        return {"sides": "", "crossed": ""}
    first = ", ".join(f"lane(beyond[{i}], 0)" for i in range(count)) + ","
    changed = " or ".join(f"(lane(beyond[{i}], 0) < 0.0) != (sides[{i}] < 0.0)" for i in range(count))
    return {
        "sides": indented(gauss_fast_text.SIDES.replace("FIRST", first), 8),
        "crossed": indented(gauss_fast_text.CROSSED.replace("FIRST", first).replace("CHANGED", changed), 12),
    }


def indented(lines: str, depth: int) -> str:
    """Lines indented by `depth`, except the first, which is placed after such an indent."""
    return textwrap.indent(lines, " " * depth).lstrip()


def round_by_groups(found: Layout) -> dict[str, str]:
    """Substitutions for a round in which each group of slopes is computed with the new ones of the groups before it."""
    read = {x.operation for x in reached(found.values)}
    parts = []
    for n, group in enumerate(found.groups):
        lines = [f"g = slopes_{n}((<|x@, |>), w, k)", *(f"g{i} = g[{k}]" for k, i in enumerate(group))]
        # Components that no slope depends on are not updated within a round.
        places = [i for i in group if f"y[{i}]" in read]
        moves = [f"p = products(table, STAGES, ({', '.join(f'g{i}' for i in places)}, ))"] if places else []
        moves += [f"x{i} = fma(hh, p[{k}], lanes(y[{i}]))" for k, i in enumerate(places)]
        parts.append((lines, moves))
    *before, (last, moves) = parts
    lines = [line for part in before for line in (*part[0], *part[1])] + last
    place = getattr(gauss_fast_text, found.kind)["place"]
    return {"prepare": place, "round": "\n        ".join(lines), "sums_of_a_round": "\n        ".join(moves)}


def expanded(source: str, count: int, dimension: int) -> str:
    """The text with its lines and its `<| |>` repeated for each component."""

    def repeated(part: str) -> str:
        mark, most = ("@", count) if "@" in part else ("%", dimension)
        return "".join(part.replace(mark, str(i)) for i in range(most))

    source = re.sub(r"<\|(.*?)\|>", lambda found: repeated(found[1]), source)
    lines = source.splitlines(keepends=True)
    return "".join(repeated(x) if ("@" in x or "%" in x) and not x.startswith("@") else x for x in lines)


@cache
def lanes_digest() -> str:
    """A hash of the modules that generated modules import: an edit there compiles these again."""
    folder = Path(__file__).parent
    return hashlib.sha256(b"".join((folder / f"{name}.py").read_bytes() for name in LANES)).hexdigest()
