"""Find integrators by id, name, library or path. Their modules are imported on first use."""

import importlib
import importlib.util
import sys
import warnings
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path, PurePath

from gnomon.cases.core.numbers import is_pattern, matching, nearest
from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.contract.declared import read_declared
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.registry import declaration
from gnomon.harness.system import extras
from gnomon.reference.storage.importing import confined

_SEQUENCE: list[str] = read_declared("registry", "modules.toml")["sequence"]
_FILES = sorted((Path(__file__).parents[1] / "integrators").glob("*/*.py"))
_FOUND = (f"{file.parent.name}.{file.stem}" for file in _FILES if "\nINTEGRATORS" in file.read_text(encoding="utf-8"))
_FOLDER = "gnomon.harness.integrators."
IN_HOUSE = [_FOLDER + name for name in dict.fromkeys((*_SEQUENCE, *_FOUND))]
"""Modules of harness/integrators with a tuple `INTEGRATORS`: in the sequence of modules.toml, then by file."""
ADAPTERS = [f"gnomon.harness.adapters.{name}" for library in LIBRARIES.values() for name in library.modules]
STIFF = frozenset(read_declared("registry", "stiff.toml")["ids"])
"""The ids of methods for stiff equations."""

GROUP = "gnomon.integrators"


@cache
def own() -> dict[str, Integrator]:
    """The integrators that come with gnomon, by id."""
    by_id: dict[str, Integrator] = {}
    for name in (*IN_HOUSE, *ADAPTERS):
        for item in importlib.import_module(name).INTEGRATORS:
            integrator = make(item, name)
            if integrator.id in by_id:
                raise ValueError(f"two integrators have the id {integrator.id}; the second is in {name}")
            by_id[integrator.id] = integrator
    return by_id


def in_house() -> list[Integrator]:
    """Gnomon's own methods, in the sequence of IN_HOUSE."""
    return [integrator for integrator in own().values() if type(integrator).__module__.startswith(_FOLDER)]


def general() -> dict[str, Integrator]:
    """Those of `own` that are measured wherever no integrator is named: without libraries of one suite alone."""
    return {name: x for name, x in own().items() if x.library not in LIBRARIES or LIBRARIES[x.library].suite is None}


def list_registered() -> dict[str, Integrator]:
    """The integrators of the entry point group `gnomon.integrators`, by id; those that fail to load give warnings."""
    by_id: dict[str, Integrator] = {}
    for point in dict.fromkeys(entry_points(group=GROUP)):
        try:
            with confined():
                integrator = make(point.load(), point.name)
            if integrator.id in by_id:
                raise ValueError(f"another package registers {integrator.id}")
        except BaseException as error:  # one package that fails must not end the run
            cause = f"{type(error).__name__}: {error}"
            warnings.warn(f"integrator {point.name} ({point.value}) cannot be loaded: {cause}", stacklevel=2)
            continue
        by_id[integrator.id] = integrator
    return by_id


def everything() -> dict[str, Integrator]:
    return own() | list_registered()


def find(name: str, known: Mapping[str, Integrator] | None = None) -> tuple[Integrator, ...]:
    """The integrators that `name` selects.

    `name`: an id, a name (all policies), a library, a pattern of ids with * and ?, or `package.module:Class`. `known`:
    the integrators to select from, by default `everything`. Raises ValueError for an unknown name, with the nearest
    valid names, and for a name in several libraries.
    """
    known = everything() if known is None else known
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


def find_one(name: str, known: Mapping[str, Integrator] | None = None) -> Integrator:
    """The only integrator that `name` selects, as in `find`; raises ValueError if there are several."""
    selected = find(name, known)
    if len(selected) > 1:
        raise ValueError(f"{name} names {', '.join(integrator.id for integrator in selected)}; give one id")
    return selected[0]


def find_all(chosen: Sequence[str | Integrator | type[Integrator]] | None) -> tuple[Integrator, ...]:
    """The integrators that several names, objects and classes select, each once; all integrators for None.

    Raises ValueError as `find`, `make` and `require_distinct` do.
    """
    known = everything()
    if not chosen:
        return tuple(known.values())
    selected: dict[int, Integrator] = {}
    for item in chosen:
        named = find(item, known) if isinstance(item, str) else [make(item, getattr(item, "__name__", f"{item!r}"))]
        selected |= {id(integrator): integrator for integrator in named}
    require_distinct(selected.values())
    return tuple(selected.values())


def require_distinct(integrators: Iterable[Integrator]) -> None:
    """Raise ValueError if two integrators have one id: results could not show which of them ran."""
    seen = set[str]()
    for name in (integrator.id for integrator in integrators):
        if name in seen:
            raise ValueError(f"two integrators have the id {name}; name one of them, or give each its own name")
        seen.add(name)


def from_path(path: str) -> Integrator:
    """An integrator from `package.module:Class`."""
    module, _, attribute = path.partition(":")
    try:
        with confined():
            item = getattr(importlib.import_module(module), attribute)
            item = item() if isinstance(item, type) and issubclass(item, Integrator) else item
    except BaseException as error:  # a user's module may raise anything when it is imported
        wanted = "; give package.module:Class of a subclass of Integrator"
        if module.endswith(".py"):
            wanted = f"; give the module and not its file: {PurePath(module).stem}:{attribute or 'Class'}"
        if module and not isinstance(error, ImportError | AttributeError):  # the user's code raised it
            wanted = ""
        raise ValueError(f"{path}: {type(error).__name__}: {error}{wanted}") from None
    return make(item, path)


def missing(integrator: Integrator) -> str | None:
    """The reason why an integrator's library cannot be used here; None if it can."""
    if type(integrator).__module__.startswith("gnomon.harness.adapters.") and not _is_importable(integrator.library):
        return absent(integrator.library)
    try:
        integrator.versions()
    except ImportError as error:
        return f"{error}"
    return None


def absent(library: str) -> str:
    """The reason why a library is missing, and the command that installs it."""
    known = LIBRARIES[library]
    if known.last_wheels is not None and sys.version_info[:2] > known.last_wheels:
        return f"{library} has wheels up to CPython {known.last_wheels[0]}.{known.last_wheels[1]} only"
    return (
        f"{library} is not installed: {extras.install(known.extra) if known.extra else f'pip install {known.package}'}"
    )


def make(item: object, origin: str) -> Integrator:
    """Make an integrator from its class, or take it as an object; `origin` names it in messages.

    Raises ValueError for a wrong declaration, and for a user's integrator with an id of gnomon's own.
    """
    integrator = item() if isinstance(item, type) and issubclass(item, Integrator) else item
    if not isinstance(integrator, Integrator):
        raise ValueError(f"{origin}: {item!r} is not a gnomon.Integrator; give package.module:Class")
    if undeclared := [attribute for attribute in ("name", "accepts", "sweep") if not hasattr(integrator, attribute)]:
        raise ValueError(
            f"{origin}: {type(integrator).__name__} does not declare {', '.join(undeclared)}; "
            "a base class that several integrators share is not an integrator: name a subclass that declares them"
        )
    if is_users_own(integrator):  # a test validates gnomon's own
        declaration.validate(integrator, origin if ":" in origin else "")
        if integrator.id in own():
            raise ValueError(f"{origin}: {integrator.id} comes with gnomon; give yours a name or a library of its own")
    return integrator


def is_users_own(integrator: Integrator) -> bool:
    """Whether an integrator is a user's: it does not come with gnomon, or `verification` made it for a user."""
    module = type(integrator).__module__
    return not module.startswith("gnomon.") or module.startswith("gnomon.harness.verification.")


@cache
def _is_importable(library: str) -> bool:
    known = LIBRARIES.get(library)
    return (known is not None and known.debian is not None) or importlib.util.find_spec(library) is not None
