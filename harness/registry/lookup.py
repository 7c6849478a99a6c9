"""Integrators by id, name, library or path. Their modules are imported on first use."""

import importlib
import importlib.util
import sys
import warnings
from collections.abc import Iterator, Sequence
from functools import cache
from importlib.metadata import entry_points
from pathlib import PurePath

from gnomon.cases.core.numbers import is_pattern, matching, nearest
from gnomon.harness.contract.declared import declared
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.registry import declaration

MODULES: list[str] = declared("registry", "modules.toml")["modules"]
"""Modules with a tuple `INTEGRATORS`."""

GROUP = "gnomon.integrators"

OPTIONAL = {"heyoka": "heyoka", "sksundae": "scikit-sundae", "diffrax": "diffrax"}
"""Libraries that are not installed with gnomon, and the packages that have them."""

LAST_WHEELS = {"pybullet": (3, 11)}
"""The newest Python for which a library has wheels."""


@cache
def own() -> dict[str, Integrator]:
    """The integrators that come with gnomon, by id, in the sequence of MODULES."""
    found: dict[str, Integrator] = {}
    for name in MODULES:
        for item in importlib.import_module(name).INTEGRATORS:
            integrator = _instance(item, name)
            if integrator.id in found:
                raise ValueError(f"two integrators have the id {integrator.id}; the second is in {name}")
            found[integrator.id] = integrator
    return found


def registered() -> dict[str, Integrator]:
    """The integrators of the entry point group `gnomon.integrators`, by id; one that cannot be loaded is a warning."""
    found: dict[str, Integrator] = {}
    for point in entry_points(group=GROUP):
        try:
            integrator = _instance(point.load(), point.name)
        except (Exception, SystemExit, KeyboardInterrupt) as error:  # one package that fails must not end the run
            cause = f"{type(error).__name__}: {error}"
            warnings.warn(f"integrator {point.name} ({point.value}) cannot be loaded: {cause}", stacklevel=2)
            continue
        found[integrator.id] = integrator
    return found


def everything() -> dict[str, Integrator]:
    return own() | registered()


def find(name: str) -> tuple[Integrator, ...]:
    """The integrators that `name` selects: an id, a name (all policies), a library, a pattern of ids with * and ?, or
    `package.module:Class`.

    Raises ValueError for an unknown name, with the nearest valid ones, and for a name in several libraries.
    """
    known = everything()
    if name in known:
        return (known[name],)
    if is_pattern(name):
        return tuple(known[identity] for identity in matching(name, known))
    lowered = name.lower()
    if own := tuple(i for i in known.values() if i.library.lower() == lowered):
        return own
    same = tuple(i for i in known.values() if lowered in (i.name.lower(), f"{i.library}:{i.name}".lower()))
    libraries = dict.fromkeys(i.library for i in same)
    if len(libraries) > 1:
        ids = " or ".join(f"{library}:{same[0].name}" for library in libraries)
        raise ValueError(f"{name} is a method of several libraries: name {ids}, or *:{same[0].name} for all")
    if same:
        return same
    if ":" in name and name.partition(":")[0] not in {i.library for i in known.values()}:
        return (from_path(name),)
    names = {i.name for i in known.values()} | set(known)
    raise ValueError(f"no integrator is called {name!r}; {nearest(name, names)}")


def find_one(name: str) -> Integrator:
    """The only integrator that `name` selects; raises ValueError if there are several."""
    found = find(name)
    if len(found) > 1:
        raise ValueError(f"{name} names {', '.join(one.id for one in found)}; give one id")
    return found[0]


def find_all(names: Sequence[str] | None) -> tuple[Integrator, ...]:
    """The integrators that several names select, each once; all integrators for None."""
    if not names:
        return tuple(everything().values())
    return tuple({i.id: i for name in names for i in find(name)}.values())


def from_path(path: str) -> Integrator:
    """An integrator from `package.module:Class`."""
    module, _, attribute = path.partition(":")
    try:
        found = getattr(importlib.import_module(module), attribute)
        made = found() if isinstance(found, type) and issubclass(found, Integrator) else found
    except (Exception, SystemExit, KeyboardInterrupt) as error:  # of a user's module while it is imported
        wanted = "package.module:Class of a subclass of Integrator"
        if module.endswith(".py"):
            wanted = f"the module and not its file: {PurePath(module).stem}:{attribute or 'Class'}"
        raise ValueError(f"{path}: {type(error).__name__}: {error}; give {wanted}") from None
    if not isinstance(made, Integrator):
        raise ValueError(
            f"{path}: {made!r} is no gnomon.harness.contract.integrator.Integrator; give package.module:Class"
        )
    return _instance(made, path)


def reference(integrator: Integrator) -> tuple[str, str]:
    """(origin, id), from which a worker process loads the integrator."""
    return integrator.origin, integrator.id


def dereference(origin: str, identity: str) -> Integrator:
    """The integrator behind a `reference`: one of the module's INTEGRATORS, else a class or an instance defined in it, or
    the one that the module restores from text."""
    module, _, text = origin.partition(":")
    if text:
        return _instance(importlib.import_module(module).restored(text), module)
    for candidate in _declared(module):
        if candidate.id == identity:
            return candidate
    raise ValueError(f"{module} has no integrator {identity}")


def missing(integrator: Integrator) -> str | None:
    """Why an integrator's library cannot be used here, or None where it can."""
    if type(integrator).__module__.startswith("gnomon.harness.adapters.") and not _importable(integrator.library):
        return absent(integrator.library)
    try:
        integrator.versions()
    except ImportError as error:
        return f"{error}"
    return None


def absent(library: str) -> str:
    """Why a library is missing, and the command that installs it."""
    last = LAST_WHEELS.get(library)
    if last is not None and sys.version_info[:2] > last:
        return f"{library} has wheels up to CPython {last[0]}.{last[1]} only"
    return f"{library} is {'optional' if library in OPTIONAL else 'not installed'}: pip install {OPTIONAL.get(library, library)}"


def _declared(module: str) -> Iterator[Integrator]:
    loaded = importlib.import_module(module)
    for item in getattr(loaded, "INTEGRATORS", ()):
        yield _instance(item, module)
    for item in list(vars(loaded).values()):
        if isinstance(item, Integrator) and type(item).__module__ == module:  # made by gnomon.verify.from_step
            yield _instance(item, module)
        if isinstance(item, type) and issubclass(item, Integrator) and not getattr(item, "__abstractmethods__", None):
            try:
                made = item()
            except TypeError:
                continue  # the base class of a family takes arguments; its members are in INTEGRATORS
            if not _undeclared(made):  # else a base class that several integrators share
                yield made


def _instance(item: object, origin: str) -> Integrator:
    made = item() if isinstance(item, type) and issubclass(item, Integrator) else item
    if not isinstance(made, Integrator):
        raise ValueError(f"{origin}: {item!r} is no gnomon.harness.contract.integrator.Integrator")
    if undeclared := _undeclared(made):
        raise ValueError(
            f"{origin}: {type(made).__name__} does not declare {', '.join(undeclared)}; "
            "a base class that several integrators share is no integrator: name a subclass that declares them"
        )
    if users_own(made):  # a test validates those of gnomon
        declaration.validate(made, origin if ":" in origin else "")
    return made


def users_own(integrator: Integrator) -> bool:
    """Whether an integrator does not come with gnomon: `verification` makes integrators of what a user brings."""
    module = type(integrator).__module__
    return not module.startswith("gnomon.") or module.startswith("gnomon.harness.verification.")


def _undeclared(integrator: Integrator) -> list[str]:
    """The attributes that every integrator must declare and this one does not."""
    return [attribute for attribute in ("name", "accepts", "sweep") if not hasattr(integrator, attribute)]


@cache
def _importable(library: str) -> bool:
    return importlib.util.find_spec(library) is not None
