"""Another version of a package than the installed one, in its own folder, for `gnomon verify --against`."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from importlib import metadata, util

from gnomon.harness.results.visible import visible
from gnomon.harness.system.locks import temporary_folder

INSTALL_SECONDS = 600.0

REQUIREMENT = re.compile(
    r"[A-Za-z0-9][\w.-]*\s*(\[[\w\s,.-]*\])?\s*(@\s*\S+|((===?|[<>!~]=|<|>)\s*[\w.*+!-]+\s*,?\s*)*)", re.ASCII
)
"""A name, extras, and versions or an address; the installer validates the rest."""
ARCHIVES = (".whl", ".tar.gz", ".zip")


@dataclass(frozen=True)
class Other:
    """An installed version: its folder, name, version and modules."""

    folder: str
    name: str
    version: str
    modules: tuple[str, ...]

    @property
    def label(self) -> str:
        return f"{self.name} {self.version}"


def install(requirement: str) -> Other:
    """Install the version that a requirement names, as `mypackage==1.2`, a wheel or a project's folder, with uv or pip.

    The version is removed at the end of this process. Raises ValueError if it cannot be installed.
    """
    wanted = validate_requirement(requirement)
    shown = f"--against {visible(requirement)}"
    folder = temporary_folder() / "against"
    uv = shutil.which("uv")
    if uv is not None:
        command = [uv, "pip", "install", "--reinstall", "--python", sys.executable]
    elif util.find_spec("pip") is not None:
        command = [sys.executable, "-m", "pip", "install", "--disable-pip-version-check"]
    else:
        raise ValueError(f"{shown}: neither uv nor pip is installed; install one of them")
    command += ["--quiet", "--no-deps", "--target", str(folder), wanted]
    shutil.rmtree(folder, ignore_errors=True)
    try:
        process = subprocess.run(
            command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=INSTALL_SECONDS, check=False
        )
    except subprocess.TimeoutExpired:
        raise ValueError(f"{shown}: not installed within {INSTALL_SECONDS:g} s") from None
    installed = list(metadata.distributions(path=[str(folder)]))
    if process.returncode or len(installed) != 1:
        reason = visible(" ".join(process.stderr.split()))
        raise ValueError(f"{shown}: cannot be installed ({reason[:400] or 'no package'}); give another version")
    name, version = installed[0].name, installed[0].version
    if re.sub(r"[-_.]+", "-", name).lower() == "gnomon":
        raise ValueError(f"{shown}: gnomon times both versions, so it cannot be one of them; name your own package")
    files = [path.parts[0].partition(".")[0] for path in installed[0].files or () if path.suffix != ""]
    modules = {first for first in files if first.isidentifier() and first not in ("__pycache__", "bin")}
    return Other(str(folder), name, version, tuple(sorted(modules)))


def validate_requirement(requirement: str) -> str:
    """The requirement for the installer, a path in full. Raises ValueError for an invalid requirement."""
    text = requirement.strip()
    if "\0" not in text and (os.sep in text or text.endswith(ARCHIVES)) and os.path.exists(text):
        return os.path.abspath(text)
    if REQUIREMENT.fullmatch(text) is None or ("@" not in text and text.endswith(ARCHIVES)):
        shown = visible(requirement[:80])
        raise ValueError(f"--against {shown!r}: give a requirement as mypackage==1.2, or the path of a wheel or folder")
    return text
