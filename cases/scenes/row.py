"""Scene of masses in a row on springs and dampers: free points along x, without gravity."""

from collections.abc import Callable

from gnomon.cases.core.scene import Body, Force, Readings, Scene, SceneForm, Vector

Values = tuple[float, ...]
ORIGIN: Vector = (0.0, 0.0, 0.0)


def masses_in_a_row(count: int, numbers: Callable[[Values], Values], damped: bool = False) -> SceneForm:
    """State (displacement of each..., velocity of each...); in equilibrium neighbours are 1 m apart.

    `numbers(parameters)`: the masses, the stiffnesses of the springs to the ground and of the springs between neighbours; if
    `damped`, then the constants of the dampers to the ground and between neighbours.
    """
    token = "velocity_force" if damped else "position_force"

    def build(state: Values, parameters: Values) -> Scene:
        masses, (ties, links), (drags, pads) = _sorted(numbers(parameters), count, damped)
        bodies = tuple(
            Body(f"mass {i + 1}", masses[i], ORIGIN, (i + state[i], 0.0, 0.0), velocity=(state[count + i], 0.0, 0.0))
            for i in range(count)
        )
        grounded = [Force(f"mass {i + 1}", token, _spring(ties[i], drags[i], float(i))) for i in range(count)]
        coupled = [
            Force(f"mass {i + 2}", "mutual_force", _spring(links[i], pads[i], 1.0), f"mass {i + 1}")
            for i in range(count - 1)
        ]
        return Scene(ORIGIN, bodies, forces=(*grounded, *coupled))

    def observe(readings: Readings, parameters: Values) -> Values:
        parts = [readings.bodies[f"mass {i + 1}"] for i in range(count)]
        return (*(place[0] - i for i, (place, *_) in enumerate(parts)), *(velocity[0] for _, _, velocity, _ in parts))

    return SceneForm(build, observe, frozenset({token, "mutual_force"}), conservative=not damped)


def _sorted(values: Values, count: int, damped: bool) -> tuple[Values, tuple[Values, Values], tuple[Values, Values]]:
    """Masses; springs to the ground and between neighbours; dampers to the ground and between neighbours."""
    masses, rest = values[:count], values[count:]
    springs, dampers = rest[: 2 * count - 1], rest[2 * count - 1 :] if damped else (0.0,) * (2 * count - 1)
    return masses, (springs[:count], springs[count:]), (dampers[:count], dampers[count:])


def _spring(stiffness: float, damping: float, rest: float) -> Callable[[float, Vector, Vector], Vector]:
    def law(t: float, position: Vector, velocity: Vector) -> Vector:
        return -stiffness * (position[0] - rest) - damping * velocity[0], 0.0, 0.0

    return law
