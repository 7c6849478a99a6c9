"""Builds FMUs of a pendulum from fmu_model.c, with the mistakes that its macros plant."""

import shutil
import subprocess
import zipfile
from pathlib import Path

SOURCE = Path(__file__).with_name("fmu_model.c")
COMPILER = shutil.which("cc") or shutil.which("gcc")
BINARY = "binaries/linux64/swing.so"
DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="swing" guid="1">
{kinds}
<ModelVariables>
{variables}
</ModelVariables>
<ModelStructure>
<Outputs><Unknown index="1"/><Unknown index="2"/></Outputs>
<Derivatives><Unknown index="3"/><Unknown index="4"/></Derivatives>
</ModelStructure>
</fmiModelDescription>
"""
VARIABLES = (
    ("theta", 'causality="output" variability="continuous" initial="exact"', '<Real start="2"/>'),
    ("omega", 'causality="output" variability="continuous" initial="exact"', '<Real start="0"/>'),
    ("der(theta)", 'causality="local" variability="continuous" initial="calculated"', '<Real derivative="1"/>'),
    ("der(omega)", 'causality="local" variability="continuous" initial="calculated"', '<Real derivative="2"/>'),
    ("g", 'causality="parameter" variability="tunable" initial="exact"', '<Real start="9.81"/>'),
    ("L", 'causality="parameter" variability="tunable" initial="exact"', '<Real start="1"/>'),
)
"""The variables in the sequence of their references: name, attributes, type."""
COSIMULATION = '<CoSimulation modelIdentifier="swing" canHandleVariableCommunicationStepSize="true"/>'
EXCHANGE = '<ModelExchange modelIdentifier="swing" completedIntegratorStepNotNeeded="true"/>'


def library(folder: Path, *macros: str) -> bytes:
    """The compiled model."""
    assert COMPILER is not None
    made = folder / f"swing{''.join(filter(str.isalnum, ''.join(macros)))}.so"
    if not made.exists():
        command = [COMPILER, "-O2", "-w", "-shared", "-fPIC", "-ffp-contract=off", *(f"-D{macro}" for macro in macros)]
        subprocess.run([*command, "-o", made, SOURCE, "-lm"], check=True)
    return made.read_bytes()


def described(
    kinds: str = COSIMULATION, variables: tuple[tuple[str, str, str], ...] = VARIABLES, replaced: dict[str, str] | None = None
) -> str:
    """The text of modelDescription.xml."""
    lines = [
        f'<ScalarVariable name="{name}" valueReference="{place}" {attributes}>{kind}</ScalarVariable>'
        for place, (name, attributes, kind) in enumerate(variables)
    ]
    text = DESCRIPTION.format(kinds=kinds, variables="\n".join(lines))
    for old, new in (replaced or {}).items():
        assert old in text
        text = text.replace(old, new)
    return text


def fmu(path: Path, description: str, binary: bytes | None, **more: str) -> Path:
    """Write an FMU; `more`: further files by path, with `/` written as `__`."""
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", description)
        if binary is not None:
            archive.writestr(BINARY, binary)
        for name, text in more.items():
            archive.writestr(name.replace("__", "/"), text)
    return path
