"""Unpacks an FMU into a temporary folder and reads its description. Nothing of the FMU is executed here."""

from __future__ import annotations

import hashlib
import stat
import tempfile
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

from gnomon.harness.results.visible import shorten
from gnomon.harness.system import extras
from gnomon.harness.system.locks import temporary_folder

MOST_FILES, MOST_BYTES = 10_000, 2**30
"""The largest number of files in an archive, and of bytes when they are unpacked."""
DESCRIPTION, MOST_DESCRIPTION = "modelDescription.xml", 2**26
"""The description of an FMU, and its largest number of bytes."""
NEEDED = (DESCRIPTION, "binaries", "resources")
"""The parts of an archive that are unpacked; sources and documentation are not."""
VERSIONS = ("2.0", "3.0")


@dataclass(frozen=True)
class Archive:
    """An unpacked FMU. `path`: the file; `folder`: the folder with its parts; `description`: as fmpy reads it.

    `kind`: "CoSimulation" or "ModelExchange"; `digest`: a hash of the file; `invalid`: the first rule that its description
    breaks, "" if it breaks none.
    """

    path: str
    folder: str
    description: Any
    kind: str
    digest: str
    invalid: str

    @property
    def version(self) -> int:
        """The major version of FMI."""
        return int(self.description.fmiVersion[0])

    @property
    def interface(self) -> Any:
        """The part of the description about the kind of the FMU that is used."""
        described = self.description
        return described.coSimulation if self.kind == "CoSimulation" else described.modelExchange


def unpack(path: Path, is_model_exchange: bool = False) -> Archive:
    """Unpack an FMU for this machine. An FMU of both kinds is used for co-simulation unless `is_model_exchange`.

    Raises ValueError, in one line, for a file that is not an FMU, that is too large, whose paths leave the folder, or
    that has no binary for this machine.
    """
    extras.require("fmu", f"--fmu {path}")
    if not path.is_file():
        raise ValueError(f"--fmu {path}: {'a folder' if path.is_dir() else 'no such file'}; give a file as model.fmu")
    folder = Path(tempfile.mkdtemp(prefix="fmu-", dir=temporary_folder()))
    try:
        with zipfile.ZipFile(path) as archive:
            _extract(archive, path, folder)
        digest = hashlib.sha256(path.read_bytes()).hexdigest()[:32]
    except (OSError, zipfile.BadZipFile, zlib.error, RuntimeError, NotImplementedError, EOFError) as error:
        raise ValueError(f"--fmu {path}: it cannot be unpacked ({shorten(str(error))}); export it again") from None
    description, invalid = _read_description(path, folder)
    kinds = {"CoSimulation": description.coSimulation, "ModelExchange": description.modelExchange}
    if is_model_exchange:
        del kinds["CoSimulation"]
    kind = next((kind for kind, interface in kinds.items() if interface is not None), None)
    if kind is None:
        wanted = " or ".join(kinds)
        raise ValueError(f"--fmu {path}: it is not an FMU for {wanted}; export it as one")
    unpacked = Archive(str(path), str(folder), description, kind, digest, invalid)
    _require_binary(unpacked)
    return unpacked


def _extract(archive: zipfile.ZipFile, path: Path, folder: Path) -> None:
    """Extract the needed parts, after all names and sizes are found to be allowed."""
    members = archive.infolist()
    if len(members) > MOST_FILES or sum(member.file_size for member in members) > MOST_BYTES:
        raise ValueError(f"--fmu {path}: more than {MOST_FILES} files or {MOST_BYTES} bytes; export a smaller one")
    for member in members:
        name = PurePosixPath(member.filename)
        outside = name.is_absolute() or ".." in name.parts or "\\" in member.orig_filename or ":" in member.filename
        if outside or stat.S_ISLNK(member.external_attr >> 16):
            raise ValueError(
                f"--fmu {path}: the path {shorten(member.orig_filename)!r} in it leads out of its folder; it is not unpacked"
            )
    for member in members:
        if PurePosixPath(member.filename).parts[:1] and PurePosixPath(member.filename).parts[0] in NEEDED:
            archive.extract(member, folder)


def _read_description(path: Path, folder: Path) -> tuple[Any, str]:
    """The description, and the first rule that it breaks: many tools break one that does no harm."""
    from fmpy import read_model_description  # of the extra `fmu`, like the imports below
    from fmpy.model_description import ValidationError

    file = folder / DESCRIPTION
    if not file.is_file() or file.stat().st_size > MOST_DESCRIPTION:
        raise ValueError(f"--fmu {path}: it has no {DESCRIPTION} of at most {MOST_DESCRIPTION} bytes; export it again")
    invalid = ""
    try:
        try:
            described = read_model_description(str(folder))
        except ValidationError as error:
            invalid = shorten(" ".join(str(error.problems[0]).split()))
            described = read_model_description(str(folder), validate=False)
    except Exception as error:  # fmpy raises plain exceptions, and those of lxml
        why = invalid or shorten(" ".join(str(error).split()))
        raise ValueError(f"--fmu {path}: {DESCRIPTION}: {why}; export it again") from None
    if described.fmiVersion not in VERSIONS:
        raise ValueError(f"--fmu {path}: FMI {described.fmiVersion}; export it as FMI {' or '.join(VERSIONS)}")
    return described, invalid


def _require_binary(archive: Archive) -> None:
    import fmpy

    if not archive.interface.modelIdentifier:
        raise ValueError(f"--fmu {archive.path}: {DESCRIPTION}: {archive.invalid}; export it again")
    system = fmpy.platform if archive.version == 2 else fmpy.platform_tuple
    name = f"{archive.interface.modelIdentifier}{fmpy.sharedLibraryExtension}"
    binaries = Path(archive.folder, "binaries")
    if PurePosixPath(name).name != name or not (binaries / system / name).is_file():
        present = sorted(each.name for each in binaries.iterdir()) if binaries.is_dir() else []
        raise ValueError(
            f"--fmu {archive.path}: it has no binaries/{system}/{shorten(name)} for this machine"
            f" (it has {shorten(', '.join(present)) or 'none'}); export it for this system"
        )
