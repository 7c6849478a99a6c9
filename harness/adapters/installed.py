"""The base class of integrators of an installed library."""

from collections.abc import Mapping
from importlib.metadata import version

from gnomon.harness.contract.integrator import Integrator


class Installed(Integrator):
    """An integrator of the distribution `library`, on whose version its results depend."""

    def versions(self) -> Mapping[str, str]:
        return {self.library: version(self.library)}
