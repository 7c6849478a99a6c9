"""Completes the names of cases, checks and integrators, for shells: their modules are not imported.

The integrators take half a second to import, so their ids are kept from the last time.
"""

import hashlib
from collections.abc import Iterable
from contextlib import suppress
from importlib.metadata import entry_points
from pathlib import Path

import platformdirs
from gnomon.reference.storage import cachefolder
from gnomon.reference.storage.version import VERSION

HARNESS = Path(__file__).parents[1]


def complete_case(incomplete: str) -> list[str]:
    """The cases whose names begin so; after a slash, the variants of a case."""
    from gnomon.cases.core import registry  # loads mpmath: the command line starts without

    return _complete_name(incomplete, registry.names())


def complete_subject(incomplete: str) -> list[str]:
    """As `complete_case`, and checks."""
    from gnomon.cases.core import registry

    return _complete_name(incomplete, (*registry.names(), *registry.check_names()))


def complete_integrator(incomplete: str) -> list[str]:
    """The integrators whose ids begin so."""
    return [name for name in list_ids() if name.startswith(incomplete)]


def _complete_name(incomplete: str, names: Iterable[str]) -> list[str]:
    from gnomon.cases.core import registry

    base, slash, _ = incomplete.partition("/")
    if slash:
        names = [f"{base}/{v}" for v in ("default", *registry.entry(base).variants)] if base in names else []
    return [name for name in names if name.startswith(incomplete)]


def list_ids() -> list[str]:
    """The ids of `lookup.everything`, read again after an edit of gnomon's sources or another set of packages."""
    folder, name = Path(platformdirs.user_cache_dir("gnomon")) / "ids", _key()
    content = cachefolder.load(folder, name)
    if content is not None:
        return content.decode().splitlines()
    from gnomon.harness.registry import lookup  # imports the integrators

    ids = [*lookup.everything()]
    with suppress(OSError):  # without a folder the ids are read each time
        cachefolder.store(folder, name, "\n".join(ids).encode())
    return ids


def _key() -> str:
    """A name for the ids that these sources, and the packages beside gnomon, have."""
    folders = [HARNESS / name for name in ("adapters", "integrators", "registry")]
    files = sorted(path for folder in folders for path in folder.rglob("*") if path.suffix in (".py", ".toml"))
    sources = [f"{path} {path.stat().st_mtime_ns}" for path in files]
    others = [f"{point.name} {point.value}" for point in entry_points(group="gnomon.integrators")]
    return hashlib.sha256("\n".join([VERSION, *sources, *others]).encode()).hexdigest()[:32]
