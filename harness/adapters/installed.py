"""The base class of integrators of an installed library, and the message for a library of the system that is missing."""

from collections.abc import Mapping
from importlib.metadata import version

from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.contract.integrator import Integrator


class Installed(Integrator):
    """An integrator of a declared library: its results depend on the versions that the declaration names."""

    def versions(self) -> Mapping[str, str]:
        return {name: version(name) for name in LIBRARIES[self.library].versions}


def not_installed(library: str) -> str:
    """The reason why a library of the system is missing, and how to install it."""
    return (
        f"{library} is not installed: apt-get install {LIBRARIES[library].debian} on Debian, other systems have it too"
    )
