"""A simulation of JSBSim that holds one free body, written as XML files of its own: planet, body and forces.

How it is driven, and why:

- The planet is a sphere that does not rotate and does not attract; a scene's gravity is an external force.
- Forces are functions in XML, traced from the laws of the scene, so they are evaluated at each new state. A force that is
  set from Python arrives a step late, which leaves order 1.
- The numbers of a scene, in SI units, are given as feet, slugs and pounds of force, in which the equations are the same.
- The body starts at latitude and longitude 0, far from the planet's centre, where directions have no singularity. There the
  axes of the scene are north, east and down, so that the usual start has no singular Euler angles.

Traps: a mass in slugs becomes too small by 2.15e-7, so it is given as a weight in pounds, 32.174049 for a slug.
`reset_to_initial_conditions` restores the default integrators; `run_ic` keeps them, and fills the history of the multistep
methods with the first derivative.
"""

import tempfile
import warnings
from math import asin, atan2, hypot
from pathlib import Path
from typing import Any

from gnomon.cases.core.scene import Quaternion, Readings, Scene
from gnomon.harness.adapters.engines.jsbsim_files import PLANET, Matrix, body_file, rotation
from gnomon.harness.adapters.engines.vectors import along, dot
from gnomon.harness.contract.integrator import Refused

SELECTORS = tuple(
    f"simulation/integrator/{part}"
    for part in ("rate/rotational", "rate/translational", "position/rotational", "position/translational")
)


class World:
    """A world of the engine: `build` writes and loads a scene, `place` sets its start, then `advance` and `read`.

    `methods`: the numbers of the four integrators; None for the defaults. `options`: those that differ from the defaults.
    """

    def __init__(self, jsbsim: Any, dt: float, methods: tuple[int, int, int, int] | None) -> None:
        self.api, self.dt, self.methods = jsbsim, dt, methods
        self.options: dict[str, Any] = {}
        self.fdm: Any = None
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
            for name, number in zip(SELECTORS, self.methods, strict=True):
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
        forward, right, below = zip(*matrix, strict=True)  # the axes of the body, in space
        initial = {
            "lat-gc-rad": 0.0,
            "long-gc-rad": 0.0,
            "h-sl-ft": self.distance - 1.0,
            "phi-rad": atan2(matrix[2][1], matrix[2][2]),
            "theta-rad": asin(max(-1.0, min(1.0, -matrix[2][0]))),
            "psi-true-rad": atan2(matrix[1][0], matrix[0][0]),
            "u-fps": dot(forward, body.velocity),
            "v-fps": dot(right, body.velocity),
            "w-fps": dot(below, body.velocity),
            "p-rad_sec": dot(forward, body.angular_velocity),
            "q-rad_sec": dot(right, body.angular_velocity),
            "r-rad_sec": dot(below, body.angular_velocity),
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
        p, q, r = (fdm[f"velocities/{axis}i-rad_sec"] for axis in "pqr")
        with warnings.catch_warnings(action="ignore", category=PendingDeprecationWarning):  # it is a numpy.matrix
            axes = fdm.get_propagate().get_Tec2b()
        forward, right, below = axes.tolist()  # of the body, in the inertial frame
        matrix = (
            (forward[2], right[2], below[2]),
            (forward[1], right[1], below[1]),
            (-forward[0], -right[0], -below[0]),
        )
        place = (self.start[0] + z, self.start[1] + y, self.start[2] - x)
        spin = (dot(matrix[0], (p, q, r)), dot(matrix[1], (p, q, r)), dot(matrix[2], (p, q, r)))
        return Readings({}, {self.body.name: (place, attitude(matrix), (w, v, -u), spin)})


def attitude(m: Matrix) -> Quaternion:
    """The quaternion of a matrix, from its largest component (Shepperd, J. Guid. Control 1 (1978) 223)."""
    trace = m[0][0] + m[1][1] + m[2][2]
    largest = max(range(4), key=lambda i: trace if i == 3 else m[i][i])
    if largest == 3:
        q = [m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1], 1 + trace]
    else:
        i, j, k = largest, (largest + 1) % 3, (largest + 2) % 3
        q = [0.0, 0.0, 0.0, m[k][j] - m[j][k]]
        q[i], q[j], q[k] = 1 + 2 * m[i][i] - trace, m[j][i] + m[i][j], m[k][i] + m[i][k]
    size = hypot(*q)
    return q[0] / size, q[1] / size, q[2] / size, q[3] / size
