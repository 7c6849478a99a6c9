"""Builds FMUs of a pendulum from fmu_model.c, with the mistakes that its macros plant."""

import shutil
import subprocess
import zipfile
from pathlib import Path

SOURCE = Path(__file__).with_name("fmu_model.c")
COMPILER = shutil.which("cc") or shutil.which("gcc")
COSIMULATION = '<CoSimulation modelIdentifier="swing" canHandleVariableCommunicationStepSize="true"/>'
EXCHANGE = '<ModelExchange modelIdentifier="swing"/>'
OUTPUT = 'causality="output" variability="continuous"'
PARAMETER = 'causality="parameter" variability="tunable" initial="exact"'
VARIABLES = {
    "theta": (0, f'{OUTPUT} initial="exact"', 'start="2"'),
    "omega": (1, f'{OUTPUT} initial="exact"', 'start="0"'),
    "der(theta)": (2, 'causality="local" initial="calculated"', 'derivative="1"'),
    "der(omega)": (3, 'causality="local" initial="calculated"', 'derivative="2"'),
    "g": (4, PARAMETER, 'start="9.81"'),
    "L": (5, PARAMETER, 'start="1"'),
}
"""The variables of the model: value reference, attributes, attributes of the type."""
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
DESCRIPTION_3 = f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="swing" instantiationToken="1">
{{kinds}}
<ModelVariables>
<Float64 name="time" valueReference="6" causality="independent" variability="continuous"/>
<Float64 name="theta" valueReference="0" {OUTPUT} initial="exact" start="2"/>
<Float64 name="omega" valueReference="1" {OUTPUT} initial="exact" start="0"/>
<Float64 name="der(theta)" valueReference="2" causality="local" initial="calculated" derivative="0"/>
<Float64 name="der(omega)" valueReference="3" causality="local" initial="calculated" derivative="1"/>
<Float64 name="g" valueReference="4" {PARAMETER} start="9.81"/>
<Float64 name="L" valueReference="5" {PARAMETER} start="1"/>
</ModelVariables>
<ModelStructure>
<Output valueReference="0"/><Output valueReference="1"/>
<ContinuousStateDerivative valueReference="2"/><ContinuousStateDerivative valueReference="3"/>
</ModelStructure>
</fmiModelDescription>
"""


def library(folder: Path, *macros: str) -> bytes:
    """The compiled model."""
    assert COMPILER is not None
    made = folder / f"swing{''.join(filter(str.isalnum, ''.join(macros)))}.so"
    if not made.exists():
        options = ["-O1", "-w", "-shared", "-fPIC", "-ffp-contract=off", *(f"-D{macro}" for macro in macros)]
        subprocess.run([COMPILER, *options, "-o", made, SOURCE, "-lm"], check=True)
    return made.read_bytes()


def describe(kinds: str = COSIMULATION, version: int = 2, **changed: tuple[int, str, str] | None) -> str:
    """The text of modelDescription.xml; `changed`: other or further variables of FMI 2.0, None to leave one out."""
    if version == 3:
        return DESCRIPTION_3.format(kinds=kinds)
    lines = [
        f'<ScalarVariable name="{name}" valueReference="{found[0]}" {found[1]}><Real {found[2]}/></ScalarVariable>'
        for name, found in (VARIABLES | changed).items()
        if found is not None
    ]
    return DESCRIPTION.format(kinds=kinds, variables="\n".join(lines))


def write_fmu(path: Path, description: str | None, binary: bytes | None, *names: str) -> Path:
    """Write an FMU with further empty files of these names."""
    folder = "x86_64-linux" if description is not None and 'fmiVersion="3.0"' in description else "linux64"
    with zipfile.ZipFile(path, "w") as archive:
        if description is not None:
            archive.writestr("modelDescription.xml", description)
        if binary is not None:
            archive.writestr(f"binaries/{folder}/swing.so", binary)
        for name in names:
            archive.writestr(name, "")
    return path
