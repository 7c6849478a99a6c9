"""The optional parts of gnomon, which pyproject.toml declares as extras: what needs one says which it lacks."""

from collections.abc import Mapping
from importlib.util import find_spec

EXTRAS: Mapping[str, tuple[str, ...]] = {
    "report": ("altair", "jinja2", "jsonschema", "pandas", "PIL", "pyarrow", "typst", "vl_convert"),
    "files": ("h5py", "pyarrow"),
    "fmu": ("fmpy",),
    "cluster": ("dask", "distributed"),
    "test": ("pytest",),
}
"""The modules by which each extra is used. The extras of libraries stand in `adapters/libraries.toml`."""


def lacking(extra: str) -> str | None:
    """The first module of an extra that is not installed; None if all are. Imports none of them."""
    return next((name for name in EXTRAS[extra] if find_spec(name) is None), None)


def require(extra: str, what: str) -> None:
    """Raise ValueError if a module of an extra is not installed; it names `what` needs it, and the way out."""
    name = lacking(extra)
    if name is not None:
        raise ValueError(f"{what} needs the extra {extra} ({name} is not installed): {install(extra)}")


def install(extra: str) -> str:
    """The command that installs an extra."""
    return f"pip install 'gnomon[{extra}]'"
