"""Hand an integrator to a worker process: as a pickle, from which the process makes the same object again."""

from __future__ import annotations

import importlib
import io
import pickle
import sys
from collections.abc import Iterable
from contextlib import suppress
from types import FunctionType
from typing import Any
from weakref import WeakKeyDictionary

from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.contract.validation import TEXT
from gnomon.harness.registry import environment

MAIN = "__main__"
"""The module of a notebook, or of the script that runs. Only a fork of its process has its classes and functions."""

Reference = bytes | Integrator
"""A pickle; or the object itself if MAIN defines a part of it, for forked processes, which have the object."""

_VERSIONED = {*sys.stdlib_module_names, *environment.DISTRIBUTIONS}
"""Packages whose versions are part of results, so that their sources need not be compared."""
_PROTOCOL = 5
_GIVEN: WeakKeyDictionary[Integrator, bytes] = WeakKeyDictionary()
"""The pickle from which an integrator was made. A second pickle of equal content may have other bytes."""


class _Pickler(pickle.Pickler):
    """Writes a pickle, and collects in `modules` the modules of its classes and functions."""

    def __init__(self, file: io.BytesIO) -> None:
        super().__init__(file, _PROTOCOL)
        self.modules = set[str]()

    def persistent_id(self, item: Any) -> None:
        """Note the module of a class or function. `pickle` calls this for each object, and None lets it go on as usual."""
        if isinstance(item, type | FunctionType):
            self.modules.add(item.__module__ or MAIN)


class _Held:
    """Stands in a pickle for an integrator that a module holds under a name, or at a place in its INTEGRATORS."""

    def __init__(self, integrator: Integrator, module: str, name: str, place: int | None = None) -> None:
        self.module, self.where = module, (module, name, place, integrator.id)

    def __reduce__(self) -> tuple[Any, ...]:
        return _find_held, self.where


def _find_held(module: str, name: str, place: int | None, wanted: str) -> Integrator:
    """The integrator at its place in a module. Raises ValueError if its id is not `wanted`: the file may have changed."""
    value = getattr(importlib.import_module(module), name, None)
    if place is not None:
        value = value[place] if isinstance(value, tuple | list) and place < len(value) else None
    if not isinstance(value, Integrator) or value.id != wanted:
        where = name if place is None else f"{name}[{place}]"
        raise ValueError(
            f"{module}.{where} is not {wanted} any more; start again, and leave {module} as it is meanwhile"
        )
    return value


def _find_holder(integrator: Integrator) -> _Held | None:
    """The place at which a module holds an integrator; None if no module holds it."""
    for module in dict.fromkeys((type(integrator).__module__, *sys.modules)):
        variables: dict[str, Any] = dict(getattr(sys.modules.get(module), "__dict__", {}))
        for name, value in variables.items() if module != MAIN else ():
            if value is integrator:
                return _Held(integrator, module, name)
            if name == "INTEGRATORS" and isinstance(value, tuple | list):
                for place, item in enumerate(value):
                    if item is integrator:
                        return _Held(integrator, module, name, place)
    return None


def pickle_integrator(integrator: Integrator) -> tuple[bytes | None, tuple[str, ...]]:
    """(pickle, modules): a pickle of an integrator, and the modules that define its class and the classes of its parts.

    If an integrator cannot be pickled, the pickle is None if MAIN defines a part of it; else it names the variable of a
    module that holds the integrator. Raises ValueError if no module holds it.
    """
    file, kind = io.BytesIO(), type(integrator)
    pickler = _Pickler(file)
    modules, content = pickler.modules, None
    try:
        pickler.dump(integrator)
        content = file.getvalue()
    except Exception as error:  # a user's own class may raise anything
        if MAIN not in {kind.__module__, *modules}:
            holder = _find_holder(integrator)
            if holder is None:
                raise ValueError(_explain_refusal(integrator, f"{type(error).__name__}: {str(error)[:TEXT]}")) from None
            modules, content = {holder.module}, pickle.dumps(holder, _PROTOCOL)
    parts = {name for name in modules if name.partition(".")[0] not in _VERSIONED}
    return content and _GIVEN.get(integrator, content), tuple(sorted({kind.__module__, *parts}))


def reference(integrator: Integrator) -> Reference:
    """The reference from which `dereference` makes the integrator. Raises ValueError as `pickle_integrator` does."""
    content, modules = pickle_integrator(integrator)
    return integrator if content is None or MAIN in modules else content


def dereference(pointer: Reference) -> Integrator:
    """The integrator behind a `reference`; imports the modules that define it."""
    if isinstance(pointer, Integrator):
        return pointer
    integrator: Integrator = pickle.loads(pointer)
    _GIVEN[integrator] = pointer
    return integrator


def start_method(integrators: Iterable[Integrator]) -> str:
    """How worker processes of these integrators start (see `system.child_process`). Raises ValueError as `process_method` does."""
    of_main = [integrator for integrator in integrators if isinstance(reference(integrator), Integrator)]
    return next(map(process_method, of_main), "forkserver")


def process_method(integrator: Integrator) -> str:
    """How a process for an integrator starts: "fork", or "forkserver" if JAX has computed here, as no fork can use JAX then.

    Raises ValueError if JAX has computed and MAIN defines the integrator, which only a fork has.
    """
    if not getattr(sys.modules.get("jax._src.xla_bridge"), "backends_are_initialized", lambda: False)():
        return "fork"
    if isinstance(reference(integrator), Integrator):
        raise ValueError(
            f"{integrator.id}: JAX has computed in this process, so a fork of the process cannot use JAX; define the"
            " method in a module of its own, or start again and do not compute before"
        )
    return "forkserver"


def require_rebuilt(integrator: Integrator) -> None:
    """Raise ValueError if the pickle of an integrator gives a worker process another object than this one."""
    pickled = reference(integrator)
    if isinstance(pickled, Integrator):
        return
    try:
        copy = pickle.loads(pickled)
        why = None if type(copy) is type(integrator) else f"it becomes a {type(copy).__qualname__}"
    except BaseException as error:  # a user's own class may raise anything
        why = f"{type(error).__name__}: {str(error)[:TEXT]}"
    if why is None:
        here, there = vars(integrator), vars(copy)
        changed = [name for name in here.keys() & there.keys() if not _is_same(here[name], there[name])]
        why = f"its {min(changed)} becomes another" if changed else None
    if why is not None:
        raise ValueError(_explain_refusal(integrator, why))


def _is_same(first: Any, second: Any) -> bool:
    """Whether two values are equal or have equal pickles; also for values that cannot be compared."""
    with suppress(Exception):  # arrays are compared element by element
        if first == second:
            return True
    try:
        return _settle(first) == _settle(second)
    except Exception:  # a value that cannot be pickled, such as a lock, is made anew
        return True


def _settle(value: Any) -> bytes:
    """The pickle of an unpickled copy of a value: a copy may share other equal parts, which changes the first pickle."""
    return pickle.dumps(pickle.loads(pickle.dumps(value, _PROTOCOL)), _PROTOCOL)


def _explain_refusal(integrator: Integrator, why: str) -> str:
    kind = type(integrator)
    return (
        f"{integrator.id}: a worker process cannot make this {kind.__module__}:{kind.__qualname__} again ({why}); define"
        " its class at the top level of a module, and keep only picklable objects in it or assign it to a variable there"
    )
