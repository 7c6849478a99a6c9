"""The version of gnomon, for modules that `gnomon` itself imports."""

from importlib.metadata import version

VERSION = version("gnomon")
