"""Parts of a report that are kept on disk between reports, because they are expensive and rarely change."""

import hashlib
from collections.abc import Callable
from typing import Any

from gnomon.reference.storage import diskcache
from gnomon.reference.storage.import_closure import closure


def keep_result(modules: tuple[str, ...], inputs: str | bytes, build: Callable[[], Any]) -> Any:
    """The result of `build` as JSON gives it back. It must depend only on the sources of `modules` and on `inputs`.

    An exception of `build` is raised, and nothing is kept.
    """
    sources = closure(*modules, within=())
    if sources is None:  # the sources were edited after they were loaded
        return build()
    digest = hashlib.sha256(inputs.encode() if isinstance(inputs, str) else inputs).hexdigest()
    return diskcache.cached(f"part of a report\n{sources}\n{digest}", lambda: diskcache.Entry(notes=build())).notes
