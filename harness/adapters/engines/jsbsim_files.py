"""The XML files of JSBSim for a scene of one body: its planet, and the body with forces and torques as functions.

A law of the scene is evaluated once on symbols (`kernels.traced`), and each operation becomes an element of a function. The
present attitude is no property of JSBSim, so a torque is a function of the rates in the body, or the same at every attitude.
"""

import random
from collections.abc import Callable
from math import hypot
from typing import Any

from gnomon.cases.core.arithmetic import rebind
from gnomon.cases.core.scene import IDENTITY, Body, Quaternion, Scene, Torque, Vector
from gnomon.harness.adapters.engines.vectors import ORIGIN, along, dot
from gnomon.harness.contract.integrator import Refused
from gnomon.harness.kernels.traced import Node, Trace

POUNDS_OF_A_SLUG = 32.174049
"""The engine's constant."""
Matrix = tuple[Vector, Vector, Vector]
PLANET = """<?xml version="1.0"?>
<planet name="sphere"><GM unit="FT3/SEC2">0</GM><semimajor_axis unit="FT">1</semimajor_axis>
<semiminor_axis unit="FT">1</semiminor_axis><rotation_rate unit="RAD/SEC">0</rotation_rate><J2>0</J2></planet>
"""
BODY = """<?xml version="1.0"?>
<fdm_config name="body" version="2.0" release="BETA">
<fileheader/>
<metrics><wingarea unit="FT2">1</wingarea><wingspan unit="FT">1</wingspan><chord unit="FT">1</chord>
<location name="AERORP" unit="FT"><x>0</x><y>0</y><z>0</z></location></metrics>
<mass_balance>
<ixx unit="SLUG*FT2">{}</ixx><iyy unit="SLUG*FT2">{}</iyy><izz unit="SLUG*FT2">{}</izz>
<emptywt unit="LBS">{}</emptywt><location name="CG" unit="FT"><x>0</x><y>0</y><z>0</z></location>
</mass_balance>
<ground_reactions/><propulsion/>
<property value="0">scene/x</property><property value="0">scene/y</property><property value="0">scene/z</property>
<external_reactions>{}</external_reactions>
<aerodynamics/>
</fdm_config>
"""
PLACES = (
    "<sum><property>scene/x</property><property>position/eci-z-ft</property></sum>",
    "<sum><property>scene/y</property><property>position/eci-y-ft</property></sum>",
    "<difference><property>scene/z</property><property>position/eci-x-ft</property></difference>",
)
VELOCITIES = (
    "<property>velocities/eci-z-fps</property>",
    "<property>velocities/eci-y-fps</property>",
    "<product><value>-1</value><property>velocities/eci-x-fps</property></product>",
)
RATES = tuple(f"<property>velocities/{axis}i-rad_sec</property>" for axis in "pqr")
TIME = "<property>simulation/sim-time-sec</property>"
AXES: tuple[Vector, ...] = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
DIRECTIONS: tuple[Vector, ...] = ((0, 0, 1), (0, 1, 0), (-1, 0, 0))
"""The inertial directions of the scene's axes."""
ELEMENTS = {"+": "sum", "-": "difference", "*": "product", "/": "quotient", "**": "pow", "log": "ln"}
SAME = {"sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sqrt", "exp"}


def body_file(scene: Scene, body: Body) -> str:
    """The body with its mass, moments, forces and torques. A point has any moments: no torque turns it."""
    pull = along(ORIGIN, scene.gravity, body.mass)
    parts = external("force", "INERTIAL", DIRECTIONS, [f"<value>{each!r}</value>" for each in pull])
    for force in scene.forces:
        parts += external("force", "INERTIAL", DIRECTIONS, write_functions(force.law, (*PLACES, *VELOCITIES)))
    for torque in scene.torques:
        parts += external("moment", *moment(torque))
    numbered = (part.format(number) for number, part in enumerate(parts))
    moments = body.inertia if any(body.inertia) else (1.0, 1.0, 1.0)
    return BODY.format(*map(repr, moments), repr(body.mass * POUNDS_OF_A_SLUG), "".join(numbered))


def external(kind: str, frame: str, axes: tuple[Vector, ...], functions: list[str]) -> list[str]:
    """External forces or moments along three axes, whose names are to be numbered; none for a component 0."""
    place = '<location unit="FT"><x>0</x><y>0</y><z>0</z></location>' if kind == "force" else ""
    return [
        f'<{kind} name="{kind}{{}}" frame="{frame}">{place}<direction><x>{x}</x><y>{y}</y><z>{z}</z></direction>'
        f"<function><sum>{function}<value>0</value></sum></function></{kind}>\n"
        for (x, y, z), function in zip(axes, functions, strict=True)
        if function not in ("<value>0.0</value>", "<value>-0.0</value>")
    ]


def moment(torque: Torque) -> tuple[str, tuple[Vector, ...], list[str]]:
    """Frame, axes and functions of a torque: of the rates in the body, along its axes, or of time alone, along those in space.

    Which of the two a law is, is tried at random times, attitudes and rates.
    """
    law, dice = torque.law, random.Random(1)
    in_body = in_space = True
    for _ in range(4):
        t, rates = dice.random(), (dice.gauss(0, 1), dice.gauss(0, 1), dice.gauss(0, 1))
        q = [dice.gauss(0, 1) for _ in range(4)]
        size = hypot(*q)
        attitude = (q[0] / size, q[1] / size, q[2] / size, q[3] / size)
        value = law(t, attitude, turn_axes(attitude, rates))
        bound = 1e-12 * max(map(abs, value))

        def same(other: Vector, value: Vector = value, bound: float = bound) -> bool:
            return all(abs(a - b) <= bound for a, b in zip(value, other, strict=True))

        in_body = in_body and same(turn_axes(attitude, law(t, IDENTITY, rates)))
        in_space = in_space and same(law(t, IDENTITY, ORIGIN))
    if not (in_body or in_space):
        raise Refused("its functions do not know the attitude, on which a torque depends")
    texts = write_functions(lambda t, rates, none: law(t, IDENTITY, rates), RATES)
    return ("BODY", AXES, texts) if in_body else ("INERTIAL", DIRECTIONS, texts)


def write_functions(law: Callable[..., Vector], arguments: tuple[str, ...]) -> list[str]:
    """The components of a law of (t, three arguments, three arguments) as functions of JSBSim."""
    trace = Trace(len(arguments), 0)
    names = {"t": TIME} | {f"y[{i}]": text for i, text in enumerate(arguments)}
    try:
        values = rebind(law, trace.functions)(trace.t, trace.state[:3], trace.state[3:])
        return [element(value, names) for value in values]
    except (TypeError, ValueError) as error:
        raise Refused(f"no function of JSBSim for a law of the scene: {error}") from error


def element(value: Any, names: dict[str, str]) -> str:
    """The text of a traced value."""
    if not isinstance(value, Node):
        return f"<value>{float(value)!r}</value>"
    if not value.arguments:
        return names[value.operation]
    inner = "".join(element(argument, names) for argument in value.arguments)
    if value.operation == "neg":
        return f"<product><value>-1</value>{inner}</product>"
    if value.operation == "hypot":
        squares = "".join(f"<pow>{element(each, names)}<value>2</value></pow>" for each in value.arguments)
        return f"<sqrt><sum>{squares}</sum></sqrt>"
    name = ELEMENTS.get(value.operation, value.operation if value.operation in SAME else None)
    if name is None:
        raise ValueError(value.operation)
    return f"<{name}>{inner}</{name}>"


def rotation(q: Quaternion) -> Matrix:
    """The matrix, row by row, that takes body components to space."""
    x, y, z, w = q
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    )


def turn_axes(attitude: Quaternion, vector: Vector) -> Vector:
    a, b, c = rotation(attitude)
    return dot(a, vector), dot(b, vector), dot(c, vector)
