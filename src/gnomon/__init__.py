"""gnomon: exact motions to verify the integrators of classical mechanics."""

from importlib.metadata import version

__version__ = version("gnomon")
