"""The versions of installed packages, which a publication names, are those that Python's own reader finds."""

from importlib.metadata import distributions

from gnomon.harness.registry.environment import list_installed


def test_versions_are_those_of_the_whole_metadata() -> None:
    """Read from their heads alone; the description below may have lines of the same words."""
    expected = {one.name.lower().replace("_", "-"): one.version for one in distributions()}
    assert list_installed() == {name: version for name, version in expected.items() if name != "gnomon"}
