"""gnomon: exact motions to verify and compare the integrators of classical mechanics.

    import gnomon

    gnomon.list_cases("kepler")
    gnomon.case("pendulum_simple", L=2).exact(1.5, digits=30)
    gnomon.solve(lambda t, y: [y[1], -y[0]], (0, 10), [1, 0], "scipy:Radau")
    gnomon.compare("pendulum_simple", ["gnomon:DOP853", "scipy:DOP853"])
    gnomon.compare(lambda t, y: [y[1], -y[0]], (0, 10), [1, 0], "scipy:*").best(1e-9)

The package `gnomon.cases` declares cases; the module `gnomon.verify` verifies an integrator of your own. `__init__.pyi` has
all names of this module; each is loaded on first use.
"""

import re
from importlib import import_module
from pathlib import Path
from typing import Any

_STUB = Path(__file__).with_name("__init__.pyi").read_text(encoding="utf-8")
_MODULES = {name: module for module, name in re.findall(r"^from (gnomon\.\S+) import (\w+) as ", _STUB, re.M)}
__all__ = [*_MODULES, "cases", "verify"]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return import_module("importlib.metadata").version("gnomon")
    if name in ("cases", "verify"):
        return import_module(f"gnomon.{name}")
    if name not in _MODULES:
        raise AttributeError(f"module 'gnomon' has no attribute {name!r}")
    found = globals()[name] = getattr(import_module(_MODULES[name]), name)
    return found


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
