"""Read the data that a package of the harness declares in TOML files."""

import tomllib
from importlib.resources import files
from typing import Any


def read_declared(package: str, name: str) -> dict[str, Any]:
    """The contents of a TOML file in the folder `package` of the harness."""
    return tomllib.loads((files(f"gnomon.harness.{package}") / name).read_text("utf-8"))
