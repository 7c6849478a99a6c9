"""Energy at practical steps: how much a user of an engine or a method loses or gains, as sentences beside the claims.

A right method of order 1 passes all claims about order and still may stop a bouncing ball, or turn a tumbling body to
another axis, at the step of 1/240 s that games and robots use. No such number is a fault by itself.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from multiprocessing.connection import Connection
from typing import Any

import numpy as np
from gnomon.cases import Case, get
from gnomon.cases.core.scene import Contact, SceneForm
from gnomon.harness.contract.integrator import Floats, Integrator, Steps
from gnomon.harness.contract.problem import takes
from gnomon.harness.measuring.reference_solution import CaseSpec
from gnomon.harness.registry import references, selection
from gnomon.harness.studies.growth import PERIODS, STRETCH, Subject, in_extended_precision, trajectories
from gnomon.harness.studies.preflight_rates import Engine
from gnomon.harness.studies.preflight_scenes import ATTITUDE, GRAVITY, MASS, RADIUS, SPIN, free, state
from gnomon.harness.system.supervisor import Job, Send, run, sender
from gnomon.reference.numerics.precision import shortened

STEPS_A_SECOND, SECONDS = 240, 60
EVERY = 4
"""Steps from one reading to the next: 60 readings a second. The highest reading is 0.3 mm below the top of a flight."""
LATE = 5
"""Seconds, or periods, at the end over which a change is averaged, or the highest point is found: several turns or flights."""
LATE_READINGS = LATE * STEPS_A_SECOND // EVERY
MOMENTS, TURNING = (1.0, 2.0, 3.0), (2.0, 2.0, 4.0)
"""Moments of the free body, and its angular velocity (rad/s). Between the middle and the last axis: by a third more energy
it would turn about the middle axis, by a tenth less about the last."""
HEIGHT = 1.0
PERIODS_LONG, SAMPLES_A_PERIOD = 100, 4
STEPS_A_PERIOD = {"pendulum_simple": 40, "kepler_orbit": 100}
"""By default 40. On the orbit of eccentricity 0.6 a 40th of a period is no step that anyone would take."""
TOLERANCE = 1e-6
SYSTEMS = (
    "pendulum_simple", "kepler_orbit", "euler_top", "charge_in_E_and_B", "holonomic_constraint_dae",
    "bouncing_ball/engines_e1",
)  # fmt: skip
"""A method is shown on the first two that it takes. The ball, of restitution 1, is for methods that take events only."""
MOST = 2
LIMIT = 20.0
"""Processor seconds of a sentence."""
SMALL = 1e-6
"""A smaller change is given as a number, larger ones in per cent."""
DIFFERENCE, CANCELS = 2.0**-17, 1e-3
"""The relative step of a difference. An energy that is a smaller part of its terms is no size: as on a parabolic orbit."""
MANY = 10.0
"""A larger change is given as a factor."""
GROWN = 1.5
"""A change has grown if it is this many times as large as any change in the first half; a line has 2."""
SEEN = 1e-3
"""The least change of an axis or of the angular momentum that is said, relative."""

BALL = free(
    "rigid_impact", gravity=(0.0, 0.0, -GRAVITY), inertia=(2 / 5 * MASS * RADIUS**2,) * 3, radius=RADIUS,
    contacts=(Contact("body", (0.0, 0.0, 1.0), restitution=1.0),),
)  # fmt: skip
TUMBLING = free("gyroscopic", inertia=MOMENTS)


def describe_energy(
    integrator: Integrator, names: Sequence[selection.CaseLike] | None = None, ends: float = math.inf
) -> tuple[str, ...]:
    """Say how an integrator changes the energy at practical steps; each sentence is measured in a killable process.

    Parameters
    ----------
    integrator : Integrator
        An engine, which moves a free body and a ball of restitution 1 for 60 s at 1/240 s as far as it models them, or
        a method, which moves systems that keep their energy for 100 periods.
    names : sequence of str, Case or ExactCase, optional
        The cases on which a method is shown, the first two that keep their energy; by default `SYSTEMS`.
    ends : float
        The time of the clock `monotonic` after which nothing more is measured.

    Returns
    -------
    tuple of str
        A sentence for each system; it says so if there is no number.

    Examples
    --------
    >>> from gnomon.verify import from_step
    >>> euler = from_step(lambda f, t, y, h: y + h * f(t, y), name="Euler", order=1)
    >>> for sentence in describe_energy(euler, ["harmonic_oscillator"]):
    ...     print(sentence.partition(":")[0])
    harmonic_oscillator
    """
    measures = _scenes(integrator) or _motions(integrator, names)
    answers: dict[str, str] = {}
    jobs = [EnergyJob(measure, answers, [title]) for title, measure in measures.items()]
    run(jobs, len(jobs), ends)
    return tuple(f"{title}: {answers[title]}" for title in measures)


Measure = Callable[[], str]


def _scenes(integrator: Integrator) -> dict[str, Measure]:
    """The scenes of an engine that it models."""
    if SceneForm not in integrator.accepts:
        return {}
    forms = {"free body": (TUMBLING, turn_body), "ball of restitution 1": (BALL, drop_ball)}
    return {
        title: partial(measure, Engine(integrator))
        for title, (form, measure) in forms.items()
        if integrator.unsupported(form) is None
    }


def _motions(integrator: Integrator, names: Sequence[selection.CaseLike] | None) -> dict[str, Measure]:
    """The cases of a method that keep their energy."""
    if names:
        cases = [case for case in selection.find_cases(names) if energy_of(case)]
    else:
        cases = [get(*name.split("/")) for name in SYSTEMS]
    chosen = [case.rounded() for case in cases if takes(integrator, case)][:MOST]
    return {case.id: partial(follow_motion, integrator, case) for case in chosen}


def energy_of(case: Case) -> str | None:
    """The name of the energy that a case without events keeps; None without one."""
    energies = (name for name, each in case.invariants.items() if "energy" in name and each.law == "constant")
    return next(energies, None) if case.hybrid is None else None


def turn_body(engine: Engine) -> str:
    """Say how the energy of a free body changes, and towards which of its axes it turns."""
    path = _path(engine, TUMBLING, state(spin=TURNING))
    spin = turn_back(path[:, ATTITUDE], path[:, SPIN])
    momenta, first = np.array(MOMENTS) * spin, np.multiply(MOMENTS, TURNING)
    twice, begin = np.sum(momenta * spin, axis=1), float(first @ TURNING)
    changes = twice / begin - 1
    text = f"{say_change(changes, LATE_READINGS)} in {SECONDS} s at 1/{STEPS_A_SECOND} s"
    if not np.all(np.isfinite(path)):
        return text
    late = slice(-LATE_READINGS, None)
    if not oscillates(changes, LATE_READINGS):
        squares = np.sum(momenta[late] ** 2, axis=1)
        text += say_axis(float(first @ first) / begin, float(np.mean(squares) / np.mean(twice[late])))
    in_space = turn_back(path[late, ATTITUDE] * (-1, -1, -1, 1), momenta[late])
    off = float(np.linalg.norm(np.mean(in_space, axis=0) - first) / np.linalg.norm(first))
    return text + (f", angular momentum off by {percent(off)}" if off > SEEN else "")


def say_axis(before: float, after: float) -> str:
    """The axis to which a free body turned, from L^2 over twice the energy: the moment about an axis of steady rotation.

    From between the middle and the last moment it rises towards the last, or falls towards the middle, and beyond it.
    """
    least, middle, largest = MOMENTS
    if abs(after - before) <= SEEN * (largest - least):
        return ""
    if after > before:
        return ", towards the axis of the largest moment"
    beyond = after < middle - SEEN * (largest - least)
    return ", towards the axis of the least moment" if beyond else ", towards the middle axis"


def turn_back(attitudes: Floats, vectors: Floats) -> Floats:
    """Vectors (n, 3) in the axes of bodies with these attitudes (n, 4); also if a quaternion has another length."""
    q = attitudes / np.linalg.norm(attitudes, axis=1, keepdims=True)
    axis, scalar = -q[:, :3], q[:, 3:]
    turned: Floats = vectors + 2 * np.cross(axis, np.cross(axis, vectors) + scalar * vectors)
    return turned


def drop_ball(engine: Engine) -> str:
    """Say how high a ball of restitution 1 still flies after it fell from `HEIGHT`."""
    heights = _path(engine, BALL, state((0.0, 0.0, HEIGHT + RADIUS)))[:, 2] - RADIUS
    after = f"after {SECONDS} s at 1/{STEPS_A_SECOND} s"
    if not np.all(np.isfinite(heights)):
        return f"no finite height {after}"
    share = float(np.max(heights[-LATE_READINGS:])) / HEIGHT
    if share < -RADIUS:
        return f"below the plane {after}"
    return f"{100 * share:.0f} % of its height {after}" if share >= 0.005 else f"no height left {after}"


def _path(engine: Engine, form: SceneForm, start: Floats) -> Floats:
    """Readings of a free body, shape (times, 13)."""
    times = np.arange(1, SECONDS * STEPS_A_SECOND // EVERY + 1) * (EVERY / STEPS_A_SECOND)
    readings: Floats = engine.solve(form, [start], times.tolist(), 1 / STEPS_A_SECOND)[0]
    return readings


def follow_motion(integrator: Integrator, case: Case) -> str:
    """Say how the energy of a case changes over 100 periods; of a case without a period, over its span.

    Such a motion may end soon after. A period then stands for 2 pi time scales.
    """
    name = energy_of(case) or "energy"
    steps, sweep = STEPS_A_PERIOD.get(case.name, 40), integrator.sweep
    setting = steps if isinstance(sweep, Steps) else min(max(TOLERANCE, sweep.tightest), sweep.loosest)
    unit, scales, periods = "period", 1.0, float(PERIODS_LONG)
    if not set(PERIODS) & set(case.quantities()):
        unit, scales = "time scale", 2 * math.pi
        periods = float(case.times[-1]) / (scales * float(case.time_scale) * STRETCH)
    samples = max(SAMPLES_A_PERIOD, round(SAMPLES_A_PERIOD * periods))
    subject = Subject(integrator.id, setting, "", periods=periods, starts=1, samples=samples)
    _, start, states, _ = trajectories(subject, case, integrator)
    value = in_extended_precision(case.invariants[name].function, np.array(case.parameter_values(), dtype=float))
    with np.errstate(all="ignore"):  # a state may overflow
        changes = np.asarray((value(states[0]) - value(start[0])) / size_of(value, start[0]), dtype=float)
    text = say_change(changes, min(LATE * SAMPLES_A_PERIOD, samples // 4))
    at = f"{steps / scales:.3g} steps a {unit}" if isinstance(sweep, Steps) else f"tolerance {setting:g}"
    return f"{text} after {periods * scales:.0f} {unit}s at {at}"


def size_of(value: Callable[[Floats], Any], start: Floats) -> float:
    """The size of an energy at the start; where its terms cancel, their size: the sum of |x dE/dx| over the state."""
    near = start * (1 + np.diag([DIFFERENCE] * len(start)))
    terms = float(np.sum(np.abs(value(near) - value(start)))) / DIFFERENCE
    size = abs(float(value(start)))
    return size if size > CANCELS * terms else terms or 1.0


def say_change(changes: Floats, late: int) -> str:
    """The relative change of the energy in words: the mean of the `late` last samples, or the largest if it oscillates."""
    if not np.all(np.isfinite(changes)):
        return "energy not finite"
    end, largest = float(np.mean(changes[-late:])), float(np.max(np.abs(changes)))
    if largest < SMALL:
        return f"energy kept to {max(largest, 2.0**-53):.1g}"
    if oscillates(changes, late):
        return f"energy within {percent(largest)}"
    return f"energy {1 + end:.2g} times as large" if end > MANY else f"energy {percent(end, sign=True)}"


def oscillates(changes: Floats, late: int) -> bool:
    """Whether changes come and go: the `late` last ones differ by more than their mean, or earlier ones come back to a third.

    Those of the second half count, and only if the mean is no larger than the first half had it.
    """
    first, second = np.split(np.abs(changes), [len(changes) // 2])
    end = abs(float(np.mean(changes[-late:])))
    returns = np.ptp(changes[-late:]) > end or np.min(second) < end / 3
    return bool(returns and end <= GROWN * np.max(first))


def percent(share: float, sign: bool = False) -> str:
    """A share in per cent, with two digits.

    >>> percent(-0.0031416, sign=True), percent(0.284), percent(1.0)
    ('-0.31 %', '28 %', '100 %')
    """
    return np.format_float_positional(100 * share, precision=2, fractional=False, trim="-", sign=sign) + " %"


@dataclass(eq=False)
class EnergyJob(Job):
    """A sentence still to be measured, `pending` by its title. One that ends its process, or hangs, has no number."""

    measure: Measure
    answers: dict[str, str]
    pending: list[str]
    limit: float = LIMIT

    def work(self, send: Send) -> None:
        _say(self.measure, send)

    def process(self) -> tuple[str, Callable[[Connection], object]]:
        if not (isinstance(self.measure, partial) and self.measure.func is follow_motion):
            return super().process()
        integrator, case = self.measure.args
        if references.process_method(integrator) == "fork":
            return super().process()
        return "forkserver", partial(_serve, references.reference(integrator), CaseSpec.of(case))

    def receive(self, message: Any) -> None:
        self.answers[self.pending.pop()] = str(message)

    def lose(self, why: str, late: bool = False) -> None:
        self.receive(f"energy not measured: {why}")

    def stop(self) -> None:
        if self.pending:
            self.receive("energy not measured: the time of --max-seconds is over")


def _say(measure: Measure, send: Send) -> None:
    try:
        send(measure())
    except Exception as error:  # the user's code may raise anything
        send(f"energy not measured: {type(error).__name__}: {shortened(str(error).partition(chr(10))[0])}")


def _serve(reference: references.Reference, spec: CaseSpec, connection: Connection) -> None:
    """Do the work of an EnergyJob in a new process, which imports the user's module, and send the results."""
    integrator, (case, _) = references.dereference(reference), spec.build()
    _say(partial(follow_motion, integrator, case), sender(connection))
