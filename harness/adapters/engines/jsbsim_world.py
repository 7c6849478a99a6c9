"""A simulation of JSBSim that holds one free body, written as XML files of its own: planet, body and forces.

How it is driven, and why:

- The planet is a sphere that does not rotate and does not attract; a scene's gravity is an external force.
- Forces are functions in XML, traced from the laws of the scene, so they are evaluated at each new state. A force that is
  set from Python arrives a step late, which leaves order 1.
- The numbers of a scene, in SI units, are given as feet, slugs and pounds of force, in which the equations are the same.
- The body starts at latitude and longitude 0, far from the planet's centre, where directions have no singularity. The axes of the scene are north, east and down
  there, so that the usual start has no singular Euler angles.

Traps: a mass in slugs becomes too small by 2.15e-7, so it is given as a weight in pounds, 32.174049 for a slug. The
present attitude is no property, so a torque is either constant in space or a function of the rates in the body.
"""

import random
import tempfile
from collections.abc import Callable
from math import asin, atan2
from pathlib import Path
from typing import Any

from gnomon.cases.core.arithmetic import rebind
from gnomon.cases.core.scene import IDENTITY, Body, Readings, Scene, Torque, Vector
from gnomon.harness.adapters.engines.vectors import ORIGIN, along
from gnomon.harness.contract.integrator import Refused
from gnomon.harness.kernels.traced import Node, Trace

POUNDS_OF_A_SLUG = 32.174049
"""The engine's constant."""
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
INTEGRATORS = tuple(
    f"simulation/integrator/{part}"
    for part in ("rate/rotational", "rate/translational", "position/rotational", "position/translational")
)
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
DIRECTIONS = ((0, 0, 1), (0, 1, 0), (-1, 0, 0))
"""The inertial directions of the scene's axes."""
ELEMENTS = {"+": "sum", "-": "difference", "*": "product", "/": "quotient", "**": "pow", "log": "ln"}
SAME = {"sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sqrt", "exp"}


class World:
    """A world of the engine: `build` writes and loads a scene, `place` sets its start, then `advance` and `read`.

    `methods`: the numbers of the four integrators; None for the defaults. `options`: those that differ from the defaults.
    """

    def __init__(self, jsbsim: Any, dt: float, methods: tuple[int, int, int, int] | None) -> None:
        self.api, self.dt, self.methods = jsbsim, dt, methods
        self.options: dict[str, Any] = {}
        logger = jsbsim.DefaultLogger()
        logger.set_min_level(jsbsim.LogLevel.FATAL)
        jsbsim.set_logger(logger)

    def close(self) -> None:
        """Drop the simulation, with which the engine's memory is freed; the files are removed once they are read."""
        self.fdm = None

    def build(self, scene: Scene) -> None:
        """Write the planet and the body of `scene` as files, and load them."""
        if len(scene.bodies) != 1:
            raise Refused("one body in a simulation")
        (self.body,) = scene.bodies
        with tempfile.TemporaryDirectory() as folder:
            place = Path(folder, "aircraft", "body")
            place.mkdir(parents=True)
            (place / "body.xml").write_text(body_file(scene, self.body))
            (planet := Path(folder, "planet.xml")).write_text(PLANET)
            self.fdm = self.api.FGFDMExec(folder, None)
            self.fdm.set_debug_level(0)
            loaded = self.fdm.load_planet(str(planet), False)
            self.fdm.set_aircraft_path("aircraft")
            if not (loaded and self.fdm.load_model("body")):
                raise RuntimeError("JSBSim could not load the body")
        self.fdm.set_dt(self.dt)
        if self.methods is not None:
            for name, number in zip(INTEGRATORS, self.methods, strict=True):
                if self.fdm[name] != number:
                    self.fdm[name] = self.options[name] = number

    def place(self, scene: Scene) -> None:
        """Set the initial state, and let the engine compute the first derivatives, which also become its history."""
        (body,), fdm = scene.bodies, self.fdm
        # Positions are differences from the centre's distance, so they have 3 to 6 digits less than a double.
        reach = max(map(abs, body.position)) + 1e3 * self.dt * max(map(abs, body.velocity))
        self.distance = 1.0 + 1e3 * reach
        self.start = along(body.position, (0.0, 0.0, 1.0), self.distance)
        for axis, value in zip("xyz", self.start, strict=True):
            fdm[f"scene/{axis}"] = value
        matrix = rotation(body.quaternion)
        to_body = tuple(zip(*matrix, strict=True))
        u, v, w = (dot3(row, body.velocity) for row in to_body)
        p, q, r = (dot3(row, body.angular_velocity) for row in to_body)
        initial = {
            "lat-gc-rad": 0.0,
            "long-gc-rad": 0.0,
            "h-sl-ft": self.distance - 1.0,
            "phi-rad": atan2(matrix[2][1], matrix[2][2]),
            "theta-rad": asin(max(-1.0, min(1.0, -matrix[2][0]))),
            "psi-true-rad": atan2(matrix[1][0], matrix[0][0]),
            "u-fps": u,
            "v-fps": v,
            "w-fps": w,
            "p-rad_sec": p,
            "q-rad_sec": q,
            "r-rad_sec": r,
        }
        for name, value in initial.items():
            fdm[f"ic/{name}"] = value
        fdm.run_ic()

    def advance(self, steps: int) -> None:
        run = self.fdm.run
        for _ in range(steps):
            run()

    def read(self) -> Readings:
        fdm = self.fdm
        x, y, z = (fdm[f"position/eci-{axis}-ft"] for axis in "xyz")
        u, v, w = (fdm[f"velocities/eci-{axis}-fps"] for axis in "xyz")
        rates = [fdm[f"velocities/{axis}i-rad_sec"] for axis in "pqr"]
        turn = fdm.get_propagate().get_Tec2b().tolist()  # the rows are the body's axes in the inertial frame
        matrix = [[row[2] for row in turn], [row[1] for row in turn], [-row[0] for row in turn]]
        spin = tuple(dot3(row, rates) for row in matrix)
        place = (self.start[0] + z, self.start[1] + y, self.start[2] - x)
        return Readings({}, {self.body.name: (place, attitude(matrix), (w, v, -u), spin)})  # type: ignore[dict-item]


def dot3(a: Any, b: Any) -> float:
    return float(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def rotation(q: Any) -> list[list[float]]:
    """The matrix, row by row, that takes body components to space."""
    x, y, z, w = q
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]


def attitude(m: list[list[float]]) -> tuple[float, ...]:
    """The quaternion (x, y, z, w) of a matrix, from its largest component (Shepperd, J. Guid. Control 1 (1978) 223)."""
    trace = m[0][0] + m[1][1] + m[2][2]
    largest = max(range(4), key=lambda i: trace if i == 3 else m[i][i])
    if largest == 3:
        q = [m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1], 1 + trace]
    else:
        i, j, k = largest, (largest + 1) % 3, (largest + 2) % 3
        q = [0.0, 0.0, 0.0, m[k][j] - m[j][k]]
        q[i], q[j], q[k] = 1 + 2 * m[i][i] - trace, m[j][i] + m[i][j], m[k][i] + m[i][k]
    size = sum(each * each for each in q) ** 0.5
    return tuple(each / size for each in q)


def body_file(scene: Scene, body: Body) -> str:
    """The body with its mass, moments, forces and torques. A point has any moments: no torque turns it."""
    weight = along(ORIGIN, scene.gravity, body.mass)
    laws = [(force.law, (*PLACES, *VELOCITIES)) for force in scene.forces]
    parts = [
        external("force", "INERTIAL", DIRECTIONS[i], f"<value>{weight[i]!r}</value>") for i in range(3) if weight[i]
    ]
    for law, arguments in laws:
        for direction, text in zip(DIRECTIONS, written(law, arguments), strict=True):
            parts.append(external("force", "INERTIAL", direction, text))
    for torque in scene.torques:
        parts += moments(torque)
    numbered = (part.format(n) for n, part in enumerate(parts))
    moment = body.inertia if any(body.inertia) else (1.0, 1.0, 1.0)
    return BODY.format(*map(repr, moment), repr(body.mass * POUNDS_OF_A_SLUG), "".join(numbered))


def external(kind: str, frame: str, direction: tuple[int, ...], function: str) -> str:
    """An external force or moment, whose name is to be numbered."""
    x, y, z = direction
    place = '<location unit="FT"><x>0</x><y>0</y><z>0</z></location>' if kind == "force" else ""
    return (
        f'<{kind} name="{kind}{{}}" frame="{frame}">{place}<direction><x>{x}</x><y>{y}</y><z>{z}</z></direction>'
        f"<function><sum>{function}<value>0</value></sum></function></{kind}>\n"
    )


def moments(torque: Torque) -> list[str]:
    """A torque that depends on the rates in the body alone, along the body's axes, or on time alone, along those in space.

    Which of the two holds is tried at random attitudes and rates.
    """
    dice = random.Random(1)
    law, in_body, in_space = torque.law, True, True
    for _ in range(4):
        q, w, t = [dice.gauss(0, 1) for _ in range(4)], tuple(dice.gauss(0, 1) for _ in range(3)), dice.random()
        size = sum(each * each for each in q) ** 0.5
        turn = rotation([each / size for each in q])
        x, y, z, s = (each / size for each in q)
        found = law(t, (x, y, z, s), tuple(dot3(row, w) for row in turn))  # type: ignore[arg-type]
        body = tuple(dot3(row, law(t, IDENTITY, w)) for row in turn)  # type: ignore[arg-type]
        still = law(t, IDENTITY, ORIGIN)
        bound = 1e-12 * max(map(abs, found))
        in_body = in_body and all(abs(a - b) <= bound for a, b in zip(found, body, strict=True))
        in_space = in_space and all(abs(a - b) <= bound for a, b in zip(found, still, strict=True))
    if not (in_body or in_space):
        raise Refused("its functions do not know the attitude, on which a torque depends")
    frame, axes = ("BODY", ((1, 0, 0), (0, 1, 0), (0, 0, 1))) if in_body else ("INERTIAL", DIRECTIONS)
    texts = written(lambda t, rates, none: law(t, IDENTITY, rates), RATES)
    return [external("moment", frame, axis, text) for axis, text in zip(axes, texts, strict=True)]


def written(law: Callable[..., Vector], arguments: tuple[str, ...]) -> list[str]:
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
