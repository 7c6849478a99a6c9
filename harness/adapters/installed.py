"""The base class of integrators of an installed library."""

from collections.abc import Mapping
from importlib.metadata import version

from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.contract.integrator import Integrator


class Installed(Integrator):
    """An integrator of a declared library: its results depend on the versions that the declaration names."""

    def versions(self) -> Mapping[str, str]:
        return {name: version(name) for name in LIBRARIES[self.library].versions}
