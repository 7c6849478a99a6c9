"""Mutants of the right methods: every constant, sign, term and time argument changed in turn, and chosen faults."""

import ast
import copy
import itertools
import random
import re
import sys
import types
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

from gnomon.harness.contract.integrator import Integrator, Steps, Tolerance
from special_adapters import from_engine_class, from_events, from_rising, from_rotation

from gnomon.verify import from_step

TEXT = Path(__file__).with_name("right_methods.py").read_text()
TREE = ast.parse(TEXT)
Floats = Any
SEED = 300
"""The seed of the draw: a draw of fewer mutants is the beginning of a draw of more."""


@dataclass(frozen=True)
class Method:
    """A function or class of right_methods.py, its declarations, and the names there that belong to it."""

    name: str
    make: Callable[..., Integrator]
    declared: dict[str, Any]
    parts: tuple[str, ...] = ()


SYMPLECTIC = ("symplectic", "reversible")
TOKENS = ("position_force", "time_force", "mutual_force")
METHODS = (
    Method("rk4", from_step, {"order": 4}),
    Method("verlet", from_step, {"order": 2, "accelerations": True, "conserves": (*SYMPLECTIC, "momentum")}),
    Method("yoshida", from_step, {"order": 4, "accelerations": True, "conserves": (*SYMPLECTIC, "momentum")}),
    Method("implicit_midpoint", from_step, {"order": 2, "conserves": SYMPLECTIC, "sweep": Steps(0.125, 8)}),
    Method("gauss4", from_step, {"order": 4, "conserves": SYMPLECTIC, "sweep": Steps(0.125, 8)}),
    Method("adams", from_rising, {"order": 4, "sweep": Steps(0.125, 8)}),
    Method("dormand_prince", from_rising, {"order": 5, "dense_order": 4}, ("A", "C", "D", "E")),
    Method("bogacki_shampine", from_rising, {"order": 3, "sweep": Tolerance(1e-3, 1e-10)}),
    Method("richardson", from_rising, {"order": 6}),
    Method("rk4_events", from_events, {"order": 4, "sweep": Steps(0.25, 10)}),
    Method(
        "rotation", from_rotation, {"order": 4, "conserves": ("attitude",), "sweep": Steps(0.25, 5)}, ("exponential",)
    ),
    Method("LeapfrogEngine", from_engine_class, {"order": 2, "tokens": TOKENS}),
)
CHOSEN = (
    ("rk4", "stages in another order", "(a + 2 * b + 2 * c + d)", "(a + 2 * b + 2 * d + c)"),
    ("rk4", "single precision inside", "    a = f(t, y)", "    y = y.astype('f4').astype('f8')\n    a = f(t, y)"),
    ("rk4", "one stage in single precision", "    c = f(t + h / 2, y + h / 2 * b)",
     "    c = f(t + h / 2, (y + h / 2 * b).astype('f4').astype('f8'))"),
    ("rk4", "a slope is kept for the next step", "    a = f(t, y)",
     "    a = KEPT.pop('a', None) if KEPT.get('n') == len(y) else f(t, y)\n    a = f(t, y) if a is None else a\n    KEPT['n'] = len(y)"),
    ("rk4", "the state is changed in place", "    b = f(t + h / 2, y + h / 2 * a)", "    y += 0 * a\n    b = f(t + h / 2, y + h / 2 * a)"),
    ("rk4", "the state of the start is changed", "    a = f(t, y)", "    a = f(t, y)\n    y[0] += 1e-12 * h"),
    ("rk4", "the last slope at the middle", "f(t + h, y + h * c)", "f(t + h / 2, y + h * c)"),
    ("rk4", "slopes replaced where they are not finite", "    return y +", "    a, b, c, d = map(np.nan_to_num, (a, b, c, d))\n    return y +"),
    ("rk4", "nonsense is made finite", "    return y + h / 6 * (a + 2 * b + 2 * c + d)",
     "    return np.nan_to_num(y + h / 6 * (a + 2 * b + 2 * c + d))"),
    ("rk4", "steps are never longer than .01", "    a = f(t, y)", "    h = min(h, 0.01)\n    a = f(t, y)"),
    ("rk4", "a slow random force", "    return y +", "    y = y * (1 + 1e-13 * np.random.default_rng().standard_normal(len(y)))\n    return y +"),
    ("verlet", "the half kick at the end is left out", "    v = middle + h / 2 * f(t + h, q)", "    v = middle"),
    ("verlet", "Euler's method called Verlet", "    middle = v + h / 2 * f(t, q)\n    q = q + h * middle\n    v = middle + h / 2 * f(t + h, q)",
     "    middle = v\n    q = q + h * middle\n    v = middle + h * f(t, q)"),
    ("verlet", "position and velocity take turns a step apart", "    q = q + h * middle", "    q = q + h * v"),
    ("verlet", "the old force is kept", "    v = middle + h / 2 * f(t + h, q)", "    v = middle + h / 2 * KEPT.setdefault(len(q), f(t + h, q))"),
    ("yoshida", "the middle step is positive", "1 - 2 * outer", "2 * outer - 1"),
    ("yoshida", "the time does not advance", "        t = t + part * h\n", ""),
    ("implicit_midpoint", "one iteration", "range(100)", "range(1)"),
    ("implicit_midpoint", "three iterations", "range(100)", "range(3)"),
    ("implicit_midpoint", "a loose stopping rule", "1e-16", "1e-6"),
    ("gauss4", "two iterations", "range(100)", "range(2)"),
    ("gauss4", "a loose stopping rule", "1e-16", "1e-6"),
    ("adams", "started by Euler's method", "y = rk4(f, t, y, h)", "y = y + h * slopes[-1]"),
    ("adams", "the time starts at 0 of each step", "f(t, y)]", "f(t - k * h, y)]"),
    ("adams", "one slope late", "w, x, u, s = slopes", "x, u, s, w = slopes[0], slopes[1], slopes[2], slopes[3]"),
    ("dormand_prince", "FSAL is not passed on", "new, k[6]", "new, k[5]"),
    ("dormand_prince", "rejected steps are accepted", "if error <= 1:", "if error <= 1e9:"),
    ("dormand_prince", "the error estimate is divided by the step", "np.linalg.norm(h * sum(", "np.linalg.norm(sum("),
    ("dormand_prince", "linear interpolation", "(r1 + (1 - x) * (r2 + x * (r3 + (1 - x) * r4)))", "r1"),
    ("dormand_prince", "cubic interpolation", "(r3 + (1 - x) * r4)", "r3"),
    ("dormand_prince", "a sample takes the state of the step's end", "x = (times[len(found)] - t) / h", "x = 1.0"),
    ("dormand_prince", "the tolerance is squared", "return max(np.linalg.norm(y), 1e-3) * tolerance", "return tolerance**0.5"),
    ("dormand_prince", "the tolerance is a constant", "return max(np.linalg.norm(y), 1e-3) * tolerance", "return 1e-6"),
    ("dormand_prince", "the 4th-order row is passed on", "t + h, new, k[6]", "t + h, new - h * sum(e * s for e, s in zip(E, k, strict=True)), k[6]"),
    ("dormand_prince", "single precision inside", "            new = y +", "            y = y.astype('f4').astype('f8')\n            new = y +"),
    ("dormand_prince", "the step size is kept between runs", "t, y, h = t0, y0, 1e-3 * times[-1]", "t, y, h = t0, y0, KEPT.get('h', 1e-3 * times[-1])\n    KEPT['h'] = h / 3"),
    ("bogacki_shampine", "the last step is not shortened", "step = end - t if last else h", "step = h"),
    ("bogacki_shampine", "the second-order row is passed on", "else t + step, new, d", "else t + step, y + step * (7 / 24 * a + 1 / 4 * b + 1 / 3 * c + 1 / 8 * d), d"),
    ("bogacki_shampine", "no step is rejected", "if error <= 1:", "if True:"),
    ("bogacki_shampine", "what diverges is made finite", "np.full((len(times), len(y0)), np.nan)", "np.tile(y0, (len(times), 1))"),
    ("richardson", "the smoothing step is left out", "(z + w + step / n * f(t + step, w)) / 2", "w"),
    ("richardson", "numbers of an expansion in h", "(16 * rows[1] - 4 * rows[0]) / 12", "(4 * rows[1] - 2 * rows[0]) / 2"),
    ("richardson", "the last step is not shortened", "step = end - t if last else h", "step = h"),
    ("rk4_events", "an event is at the end of its step", "first = high, event", "first = last, event"),
    ("rk4_events", "an event is at the start of its step", "first = high, event", "first = low * 0.0, event"),
    ("rk4_events", "an event is reported one step late", "events.append((t, event.name))", "events.append((t + step, event.name))"),
    ("rk4_events", "the time of an event by linear interpolation", "first = high, event",
     "a, b = side(0.0), side(last)\n                    first = (last * a / (a - b) if a < 0 else high), event"),
    ("rk4_events", "three bisections", "while low < (low + high) / 2 < high:", "for _ in range(3):"),
    ("rk4_events", "bisection to 1e-6 of a step", "while low < (low + high) / 2 < high:", "while high - low > 1e-6 * step:"),
    ("rk4_events", "events in the wrong direction", "event.direction * event.guard", "-event.direction * event.guard"),
    ("rk4_events", "events in both directions", "if side(last) > 0:", "if side(last) * side(1e-9 * step) < 0:"),
    ("rk4_events", "the sign is looked at only in every second step", "if side(last) > 0:", "if k % 2 and side(last) > 0:"),
    ("rk4_events", "the reset is applied twice", "y = np.array(event.reset(t, tuple(y), p), dtype=float)",
     "y = np.array(event.reset(t, event.reset(t, tuple(y), p), p), dtype=float)"),
    ("rk4_events", "the reset is left out", "y = np.array(event.reset(t, tuple(y), p), dtype=float)", "pass"),
    ("rk4_events", "the rest of the step is left out", "events.append((t, event.name))", "events.append((t, event.name))\n                t = end"),
    ("rk4_events", "a second event in a step is missed", "if first is None:", "if first is None or (events and t == events[-1][0]):"),
    ("rk4_events", "the mode before the event goes on", "mode = form.mode(event.lands(t, tuple(y), p))", "pass"),
    ("rk4_events", "the limit of accumulating events is ignored", "if limit and", "if not limit and"),
    ("rk4_events", "no events are reported", "events.append((t, event.name))", "pass"),
    ("rk4_events", "the last of two events in a step is taken", "last = end - t if first is None else first[0]", "last = end - t"),
    ("rk4_events", "the constants of a mode are forgotten", "p + mode.constants", "p + tuple(abs(c) for c in mode.constants)"),
    ("rotation", "the small-angle formula of the exponential", "return np.eye(3) + np.sin(angle) / angle * hat(s) + half * half / 2 * hat(s) @ hat(s)", "return np.eye(3) + hat(s) + hat(s) @ hat(s) / 2"),
    ("rotation", "the small-angle formula below 0.1", "if angle < 1e-8:", "if angle < 0.1:"),
    ("rotation", "Cayley's transform in place of the exponential", "half = np.sin(angle / 2) / (angle / 2)",
     "angle = 2 * np.arctan(angle / 2)\n    s = s * (angle / np.linalg.norm(s))\n    half = np.sin(angle / 2) / (angle / 2)"),
    ("rotation", "the rotation from the other side", "R @ exponential(change[1])", "exponential(change[1]) @ R"),
    ("rotation", "the rotation is transposed", "R @ exponential(change[1])", "R @ exponential(-change[1])"),
    ("rotation", "the rotation rotates twice as fast", "R @ exponential(change[1])", "R @ exponential(2 * change[1])"),
    ("rotation", "the gyroscopic term is left out", "(torque(t, w, R @ exponential(s)) - hat(w) @ (moments * w)) / moments", "torque(t, w, R @ exponential(s)) / moments"),
    ("rotation", "commutators are left out", "w + hat(s) @ w / 2 + hat(s) @ hat(s) @ w / 12", "w + 0 * s"),
    ("rotation", "the double commutator is left out", " + hat(s) @ hat(s) @ w / 12", ""),
    ("rotation", "the torque has the attitude of the step's start", "torque(t, w, R @ exponential(s))", "torque(t, w, R)"),
    ("rotation", "the attitude in single precision", "return w + change[0], R @ exponential(change[1])", "return w + change[0], (R @ exponential(change[1])).astype('f4').astype('f8')"),
    ("rotation", "moments are exchanged", "moments * w)", "moments[::-1] * w)"),
    ("LeapfrogEngine", "position and velocity take turns: symplectic Euler",
     "dt / 4 * self.a[name]\n                self.x[name] = self.x[name] + dt / 2 * self.v[name]\n            self.t = self.t + dt / 2\n            self.a = self.accelerations()\n            for name in self.m:\n                self.v[name] = self.v[name] + dt / 4 * self.a[name]\n",
     "dt / 2 * self.a[name]\n                self.x[name] = self.x[name] + dt / 2 * self.v[name]\n            self.t = self.t + dt / 2\n            self.a = self.accelerations()\n"),
    ("LeapfrogEngine", "a forgotten substep", "for _ in range(2):", "for _ in range(1):"),
    ("LeapfrogEngine", "the last half kick is left out", "            for name in self.m:\n                self.v[name] = self.v[name] + dt / 4 * self.a[name]\n\n", "\n"),
    ("LeapfrogEngine", "a stale read", "def read(self):", "def read(self):\n        x, self.kept = getattr(self, 'kept', self.x), dict(self.x)\n        self = type('Shown', (), {'m': self.m, 'x': x, 'v': self.v})"),
    ("LeapfrogEngine", "forces of an earlier scene", "        self.a = self.accelerations()\n\n    def accelerations", "        self.a = KEPT.get(len(self.m)) or self.accelerations()\n        KEPT[len(self.m)] = self.a\n\n    def accelerations"),
    ("LeapfrogEngine", "the force on the partner is left out", "total[force.partner] = total[force.partner] - value / self.m[force.partner]", "pass"),
    ("LeapfrogEngine", "the force on the partner has the body's mass", "value / self.m[force.partner]", "value / self.m[force.body]"),
    ("LeapfrogEngine", "the clock does not advance", "self.t = self.t + dt / 2", "pass"),
    ("LeapfrogEngine", "the clock starts where the last scene ended", "self.t, self.scene = 0.0, scene", "self.t, self.scene = getattr(self, 't', 0.0), scene"),
    ("LeapfrogEngine", "forces a step late", "            self.a = self.accelerations()\n            for", "            late, self.a = self.a, self.accelerations()\n            self.a, late = late, self.a\n            for"),
    ("LeapfrogEngine", "positions in single precision", "self.x[name] = self.x[name] + dt / 2 * self.v[name]", "self.x[name] = np.float32(self.x[name] + dt / 2 * self.v[name]).astype(float)"),
    ("LeapfrogEngine", "gravity acts twice", "self.v[name] = self.v[name] + dt / 4 * self.a[name]\n                self.x", "self.v[name] = self.v[name] + dt / 4 * (self.a[name] + self.scene.gravity)\n                self.x"),
    ("LeapfrogEngine", "velocities above 10 are clipped", "self.x[name] = self.x[name] + dt / 2 * self.v[name]", "self.x[name] = self.x[name] + dt / 2 * np.clip(self.v[name], -10, 10)"),
)  # fmt: skip
"""(method, fault, text before, text after)."""
RELATIVE = (1e-5, 1e-10)


@dataclass(frozen=True)
class Mutant:
    """A method with one fault; `changed` makes the module's text, which takes a while.

    `elsewhere`: whether the fault may show only in motions that are none of the cases, as backward.
    """

    method: Method
    fault: str
    changed: Callable[[], str]
    elsewhere: bool = False

    @property
    def text(self) -> str:
        return self.changed()

    @property
    def id(self) -> str:
        return f"{self.method.name}: {self.fault}"

    def integrator(self) -> Integrator:
        return made(self.method, self.text, self.fault)


def made(method: Method, text: str, fault: str = "") -> Integrator:
    """The integrator of a method in a module of this text; the module can be found by the name of the integrator."""
    module = types.ModuleType(f"detection_{method.name}_{abs(hash(text))}")
    module.__dict__.update(KEPT={}, TEXT=text)
    sys.modules[module.__name__] = module
    exec(compile(text, f"<{module.__name__}>", "exec"), module.__dict__)
    declared = {"name": f"{method.name} {fault}".strip(), "library": "detection", **method.declared}
    integrator = method.make(getattr(module, method.name), **declared)
    return integrator


@cache
def right() -> dict[str, Integrator]:
    return {method.name: made(method, TEXT) for method in METHODS}


@cache
def mutants() -> list[Mutant]:
    """All mutants, method by method: the chosen faults first."""
    found = []
    for method in METHODS:
        for name, fault, before, after in CHOSEN:
            if name == method.name:
                found.append(Mutant(method, fault, partial(replaced, method, before, after)))
        found += [Mutant(method, fault, changed) for fault, changed in _automatic(method)]
    return found


def drawn(count: int) -> list[Mutant]:
    """The chosen faults and a seeded draw of the others, so many in all: as many of each method and way as there are."""
    draw, everything = random.Random(SEED), mutants()
    groups: dict[tuple[str, str], list[Mutant]] = {}
    for mutant in everything:
        if ", line " in mutant.fault:
            groups.setdefault((mutant.method.name, mutant.fault.split(", line ")[0]), []).append(mutant)
    for group in groups.values():
        draw.shuffle(group)
    turns = [mutant for row in itertools.zip_longest(*groups.values()) for mutant in row if mutant is not None]
    chosen = [mutant for mutant in everything if ", line " not in mutant.fault]
    return [*chosen, *turns[: max(0, count - len(chosen))]]


def replaced(method: Method, before: str, after: str, text: str = TEXT) -> str:
    """The text with a change in the function of a method or, where it is not there, in the constants of the module."""
    found = re.search(rf"^(def|class) {method.name}\b.*?(?=^\S|\Z)", text, re.MULTILINE | re.DOTALL)
    assert found is not None
    if before in found[0]:
        if found[0].count(before) != 1:
            raise ValueError(f"{method.name}: {before!r} is {found[0].count(before)} times in its function")
        return text[: found.start()] + found[0].replace(before, after) + text[found.end() :]
    if text.count(before) != 1:
        raise ValueError(f"{method.name}: {before!r} is not in the text exactly once")
    return text.replace(before, after)


def _automatic(method: Method) -> Iterator[tuple[str, Callable[[], str]]]:
    """(fault, maker of the text) for every place of the method's function and parts that an operator changes."""
    for part in TREE.body:
        name = getattr(part, "name", "") or getattr(getattr(part, "targets", [None])[0], "id", "")
        if name not in (method.name, *method.parts):
            continue
        parents = {child: parent for parent in ast.walk(part) for child in ast.iter_child_nodes(parent)}
        for (place, node), way in itertools.product(enumerate(ast.walk(part)), WAYS):
            if WAYS[way].applies(node, parents):
                where = f"line {node.lineno} column {node.col_offset}"  # type: ignore[attr-defined]
                yield f"{way}, {where}: {ast.unparse(node)}", partial(_with_change, part, place, way)


def _with_change(part: ast.stmt, place: int, way: str) -> str:
    """The module's text in which one node of a part is changed."""
    twin = copy.deepcopy(part)
    WAYS[way].change(list(ast.walk(twin))[place])
    return ast.unparse(ast.Module([twin if each is part else each for each in TREE.body], []))


@dataclass(frozen=True)
class Way:
    """How a node is changed: whether it may be, given each node's parent, and the change in place."""

    applies: Callable[[Any, dict[ast.AST, ast.AST]], bool]
    change: Callable[[Any], None]


def _is_coefficient(node: Any, parents: dict[ast.AST, ast.AST]) -> bool:
    """A number that is multiplied, divided or subtracted: not an index, a count, a power or a limit of step control."""
    if not isinstance(node, ast.Constant) or type(node.value) not in (int, float) or not node.value:
        return False
    above: Any = parents.get(node)
    if not isinstance(above, ast.BinOp) or not isinstance(above.op, ast.Mult | ast.Div | ast.Sub):
        return False
    while above is not None:
        called = isinstance(above, ast.Call) and getattr(above.func, "id", "")
        if isinstance(above, ast.Subscript | ast.Compare) or called in ("range", "max", "min"):
            return False
        above = parents.get(above)
    return True


def _is_sum(node: Any, parents: dict[ast.AST, ast.AST]) -> bool:
    return isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub)


def _has_term(node: Any, parents: dict[ast.AST, ast.AST]) -> bool:
    return _is_sum(node, parents) and isinstance(node.op, ast.Add) and not isinstance(node.right, ast.Constant)


def _has_time(node: Any, parents: dict[ast.AST, ast.AST]) -> bool:
    named = isinstance(node, ast.Call) and getattr(node.func, "id", "") == "f"
    return named and isinstance(node.args[0], ast.BinOp)


def _scale(relative: float) -> Callable[[Any], None]:
    def change(node: Any) -> None:
        node.value *= 1 + relative

    return change


def _turn(node: Any) -> None:
    node.op = ast.Sub() if isinstance(node.op, ast.Add) else ast.Add()


def _drop(node: Any) -> None:
    node.op, node.right = ast.Mult(), ast.Constant(1)


def _stop(node: Any) -> None:
    node.args[0] = ast.Name("t", ast.Load())


WAYS = {
    "coefficient, 5th digit": Way(_is_coefficient, _scale(RELATIVE[0])),
    "coefficient, 10th digit": Way(_is_coefficient, _scale(RELATIVE[1])),
    "sign": Way(_is_sum, _turn),
    "missing term": Way(_has_term, _drop),
    "time argument": Way(_has_time, _stop),
}
