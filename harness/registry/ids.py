"""The ids of the integrators without their modules, which take half a second to import: kept from the last time."""

import hashlib
from contextlib import suppress
from importlib.metadata import entry_points
from pathlib import Path

import platformdirs
from gnomon.reference.storage import cachefolder
from gnomon.reference.storage.version import VERSION

GROUP = "gnomon.integrators"
"""The group of entry points by which other packages register integrators."""
HARNESS = Path(__file__).parents[1]


def list_ids() -> list[str]:
    """The ids of `lookup.everything`, read again after an edit of gnomon's sources or another set of packages."""
    folder, name = Path(platformdirs.user_cache_dir("gnomon")) / "ids", _key()
    kept = cachefolder.load(folder, name)
    if kept is not None:
        return kept.decode().splitlines()
    from gnomon.harness.registry import lookup  # imports the integrators

    found = [*lookup.everything()]
    with suppress(OSError):  # without a folder the ids are read each time
        cachefolder.store(folder, name, "\n".join(found).encode())
    return found


def _key() -> str:
    """A name for the ids of these sources: a folder is changed when a file in it is written anew."""
    folders = [HARNESS / name for name in ("adapters", "integrators", "registry")]
    files = sorted(path for folder in folders for path in folder.rglob("*") if path.suffix in (".py", ".toml"))
    sources = [f"{path} {path.stat().st_mtime_ns}" for path in files]
    others = [f"{point.name} {point.value}" for point in entry_points(group=GROUP)]
    return hashlib.sha256("\n".join([VERSION, *sources, *others]).encode()).hexdigest()[:32]
