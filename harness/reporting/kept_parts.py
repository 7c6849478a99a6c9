"""Parts of a report that are kept on disk between reports: those that are expensive and rarely change."""

import hashlib
from collections.abc import Callable
from typing import Any

from gnomon.reference.storage import diskcache
from gnomon.reference.storage.import_closure import closure


def kept(modules: tuple[str, ...], given: str | bytes, build: Callable[[], Any]) -> Any:
    """What `build` returns, as JSON has it. It depends on nothing but the sources of `modules` and what is `given`.

    An exception of `build` is raised, and nothing is kept.
    """
    sources = closure(*modules, within=())
    if sources is None:  # edited since they were loaded
        return build()
    digest = hashlib.sha256(given.encode() if isinstance(given, str) else given).hexdigest()
    return diskcache.cached(f"part of a report\n{sources}\n{digest}", lambda: diskcache.Entry(notes=build())).notes
