"""The environment of a run: machine, libraries, revision of the sources."""

import hashlib
import importlib
import os
import platform
import subprocess
import sys
from collections.abc import Mapping
from datetime import UTC, datetime
from email.parser import HeaderParser
from functools import cache
from importlib.metadata import Distribution, PackageNotFoundError, distributions, version
from pathlib import Path

import cpuinfo
from gnomon.harness.adapters.libraries import LIBRARIES

_DRIVEN = (name for library in LIBRARIES.values() for name in library.versions)
DISTRIBUTIONS = tuple(dict.fromkeys(("numpy", "scipy", "numba", *_DRIVEN, "mpmath", "python-flint", "llvmlite")))
"""The distributions whose versions results depend on: the ones that gnomon computes with, and the libraries'."""

VERSIONS = ("python", "gnomon", "sources", *DISTRIBUTIONS)
"""The names in the result of `versions`."""


@cache
def describe() -> dict[str, str]:
    """Names and values: machine, cpu, cores, system, python, versions of libraries, revision of gnomon's sources."""
    facts = {
        "machine": machine(),
        "cpu": _cpu(),
        "cores": str(os.cpu_count()),
        "system": f"{platform.system()} {platform.release()}",
    }
    revision = _revision()
    return facts | versions() | ({"revision": revision} if revision else {})


def record() -> dict[str, str]:
    """`describe` with the day in UTC, as a file of measurements holds it."""
    return describe() | {"date": datetime.now(UTC).date().isoformat()}


def comparable(environment: Mapping[str, str]) -> dict[str, str]:
    """What must be equal for measurements to go on in one file: all but the day, and the revision of equal sources."""
    return {name: value for name, value in environment.items() if name not in ("date", "revision")}


def list_installed() -> dict[str, str]:
    """The version of every installed distribution but gnomon, by its name."""
    installed = dict(map(_name_and_version, distributions()))
    return {name: installed[name] for name in sorted(installed) if name != "gnomon"}


def _name_and_version(distribution: Distribution) -> tuple[str, str]:
    """From the head of its metadata: `name` and `version` each parse the description below it too, often a README."""
    text = distribution.read_text("METADATA") or distribution.read_text("PKG-INFO") or ""
    head = HeaderParser().parsestr(text.partition("\n\n")[0])
    return head["Name"].lower().replace("_", "-"), head["Version"]


@cache
def versions() -> dict[str, str]:
    """Versions on which results depend on every machine: Python, gnomon and its sources, the installed libraries."""
    values = {"python": platform.python_version(), "gnomon": version("gnomon"), "sources": sources()}
    return values | {name: installed for name in DISTRIBUTIONS if (installed := library_version(name))}


@cache
def library_version(name: str) -> str | None:
    """The version of a distribution; None if it is not installed."""
    try:
        return version(name)
    except PackageNotFoundError:
        return None


@cache
def sources() -> str:
    """A hash of gnomon's own files, names and contents."""
    hasher = hashlib.sha256()
    for folder in ("reference", "cases", "harness"):
        (place,) = map(Path, importlib.import_module(f"gnomon.{folder}").__path__)
        for path in sorted(path for ending in ("py", "toml", "json") for path in place.rglob(f"*.{ending}")):
            hasher.update(f"{folder} {path.relative_to(place).as_posix()} ".encode())
            hasher.update(hashlib.sha256(path.read_bytes()).digest())
    return hasher.hexdigest()[:16]


@cache
def machine() -> str:
    """A short name, equal for machines whose timings are comparable: processor, cores, system. Not the host name."""
    parts = (_cpu(), str(os.cpu_count()), platform.system(), platform.machine())
    return f"{platform.machine()}-{hashlib.sha256(' '.join(parts).encode()).hexdigest()[:8]}"


@cache
def _cpu() -> str:
    if sys.platform == "linux":
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return str(cpuinfo.get_cpu_info().get("brand_raw", platform.processor()))  # about a second


def _revision() -> str | None:
    """The git revision from which gnomon runs, with + if files differ from it; None outside a working tree.

    Changes in reports/ and of the table of recommendations are ignored: what is measured is written there, and neither
    is among the `sources`.
    """

    def git(*words: str) -> str:
        folder = Path(__file__).resolve().parent
        command = ["git", *words]
        return subprocess.run(
            command, cwd=folder, capture_output=True, text=True, timeout=10, check=True
        ).stdout.strip()

    try:
        head = git("rev-parse", "--short=12", "HEAD")
        written = [f":(exclude,top){name}" for name in ("reports", "harness/results/advice/recommendations.jsonl")]
        changed = git("status", "--porcelain", "-uno", "--", ":/", *written)
    except (OSError, subprocess.SubprocessError):
        return None
    return f"{head}{'+' if changed else ''}"
