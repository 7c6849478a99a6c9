"""The second derivation of each case by name, and the rates of the state that follow from it."""

import random
from collections.abc import Callable
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import flint
from gnomon.cases import case_class
from independent_mechanics import SMALL, Derivation, System, coefficient, rate


@dataclass(frozen=True)
class Model:
    """A second derivation, and how the state of a case follows from its coordinates; by default it is (q..., q'...).

    `there(p, s)` -> (q, q') and `back(p, s, q)` -> the state, from series of the coordinates; `momenta(p)` -> the
    momenta that determine the velocities of some coordinates. `prepare(random, p, s, mode)` changes a random state to one
    of a mode, or to one at a transition (`at` and its name); it returns the time of that state, or None.
    `about(p, s)`: the equations are linear about that state; `limit(p, s, small)`: the limit as `small` tends to zero.
    `guards[transition](p, s, multipliers)`: the guard, if it is a force. `own(p, t, s)`: the rates of a case that is not a
    mechanical system.
    """

    derivation: Derivation
    there: Callable[..., Any] | None = None
    back: Callable[..., Any] | None = None
    momenta: Callable[..., dict[int, Any]] | None = None
    prepare: Any = None
    about: Callable[..., Any] | None = None
    limit: Callable[..., Any] | None = None
    guards: Any = None
    own: Callable[..., list[Any]] | None = None

    def system(self, p: Any, t: Any, s: Any, mode: str) -> tuple[System, list[Any], list[Any]]:
        found = System(self.derivation, p, t, s, mode)
        values = list(vars(s).values())
        half = len(values) // 2
        q, v = self.there(p, s) if self.there else (values[:half], values[half:])
        if self.momenta:
            v = found.velocities(q, v, self.momenta(p))
        return found, [flint.arb(x) for x in q], [flint.arb(x) for x in v]

    def rates(self, p: Any, t: Any, s: Any, mode: str = "") -> list[Any]:
        """The derivative of the state."""
        if self.own:
            return self.own(p, t, s)
        if self.limit:
            p, s = self.limit(p, s, SMALL)
            return replace(self, limit=None).rates(p, t, s, mode)
        if self.about:
            return self._linear(p, t, s, mode)
        system, q, v = self.system(p, t, s, mode)
        a, _ = system.accelerations(q, v)
        path = [flint.arb_series([x, y, z / 2], 3) for x, y, z in zip(q, v, a, strict=True)]
        state = self.back(p, s, path) if self.back else [*path, *map(rate, path)]
        return [coefficient(x, 1) for x in state]

    def _linear(self, p: Any, t: Any, s: Any, mode: str) -> list[Any]:
        assert self.about is not None
        full = replace(self, about=None)
        rest = self.about(p, s)
        near = {name: getattr(rest, name) + SMALL * (x - getattr(rest, name)) for name, x in vars(s).items()}
        zero, one = full.rates(p, t, rest, mode), full.rates(p, t, SimpleNamespace(**near), mode)
        return [a + (b - a) / SMALL for a, b in zip(zero, one, strict=True)]

    def after(self, p: Any, t: Any, s: Any, transition: str) -> list[Any]:
        """The state after the impulses of a transition."""
        system, q, v = self.system(p, t, s, f"at {transition}")
        new = system.jump(q, v)
        path = [flint.arb_series([x, y, 0], 3) for x, y in zip(q, new, strict=True)]
        state = self.back(p, s, path) if self.back else [*path, *map(rate, path)]
        return [coefficient(x, 0) for x in state]

    def multipliers(self, p: Any, t: Any, s: Any, mode: str) -> list[Any]:
        system, q, v = self.system(p, t, s, mode)
        return system.accelerations(q, v)[1]


class _Models(dict[str, Model]):
    """The models by the name of their case."""

    def __missing__(self, name: str) -> Model:
        raise LookupError(
            f"{name} has no second derivation: write tests/cases/mass_points/independent_{name}.py with a function "
            f'@model("{name}") that gives the positions of its points and the forces, or add one to a file there'
        )


MODELS: dict[str, Model] = _Models()


def model(*names: str, **how: Any) -> Callable[[Derivation], Derivation]:
    """Registers the second derivation of the cases with these names."""

    def keep(derivation: Derivation) -> Derivation:
        for name in names:
            assert name not in MODELS, name
            MODELS[name] = Model(derivation, **how)
        return derivation

    return keep


def at_rest(p: Any, s: SimpleNamespace) -> SimpleNamespace:
    """The state in which everything is zero, about which motions are small."""
    return SimpleNamespace(**{name: flint.arb(0) for name in vars(s)})


def drawn(name: str, mode: str, seed: int) -> tuple[SimpleNamespace, Any, SimpleNamespace]:
    """Random parameters, time and state of a case, in the mode or at the transition.

    A coordinate whose initial value the domain fixes (a start at rest) is random too.
    """
    kind, source = case_class(name), random.Random(f"{name} {mode} {seed}")
    parameters = [parameter.name for parameter in kind.parameter_list]
    found = kind.domain.draw([*parameters, *(c.name for c in kind.state)], source.random)
    p = SimpleNamespace(**{label: flint.arb(found[label]) for label in parameters})
    values = {}
    for coordinate in kind.state:
        allowed = kind.domain.ranges.get(coordinate.name)
        pinned = allowed is not None and allowed.typical[0] == allowed.typical[1]
        values[coordinate.name] = flint.arb(source.uniform(-1, 1) if pinned else found[coordinate.name])
    s = SimpleNamespace(**values)
    prepare = MODELS[name].prepare
    t = prepare(source, p, s, mode) if prepare else None
    return p, flint.arb(source.uniform(0, 3) if t is None else t), s
