"""gnomon: exact motions as ground truth for the integrators of classical mechanics."""

from importlib.metadata import version

__version__ = version("gnomon")
