"""Sixty faults planted in the methods of `families.py`, in a program and in older right methods, before claims changed.

Kinds: answers that are no motion of the system; dense output; error norms and estimates; slopes that are kept; falling
times; energy of engines; restitution that depends on the speed.
"""

from functools import partial
from pathlib import Path

import planted_faults
from gnomon.cases.core.forms import FirstOrder, SemiLinear
from gnomon.harness.contract.integrator import Integrator, Steps, Tolerance
from mutants import METHODS, SYMPLECTIC, Method, Mutant, made, replaced
from special_adapters import from_class, from_compensated, from_engine_class, from_events, from_form, from_program

from gnomon.verify import from_solve, from_step

FAMILY_TEXT = Path(__file__).with_name("families.py").read_text()
PROGRAM_TEXT = Path(__file__).with_name("program_rk4.py").read_text()
FEW = Steps(0.125, 7)
DIFFERENCES = {"jacobian": "differences"}
SPLITTING = {"accelerations": True, "sweep": FEW, "conserves": (*SYMPLECTIC, "momentum")}
EXPONENTIAL = {"accepts": (SemiLinear,), "sweep": FEW}
PROGRAM = Method("program_rk4", from_program, {})
FAMILIES = (
    Method("exponential_euler", from_step, {"order": 2, "sweep": FEW, **DIFFERENCES}),
    Method("exponential_midpoint", from_step, {"order": 2, "sweep": FEW, **DIFFERENCES}),
    Method("exponential_rosenbrock3", from_step, {"order": 3, "sweep": FEW, **DIFFERENCES}),
    Method("etd_rk4", from_form, {"order": 4, **EXPONENTIAL}),
    Method("etd2", from_form, {"order": 2, **EXPONENTIAL}),
    Method("lawson4", from_form, {"order": 4, **EXPONENTIAL}),
    Method("strang", from_form, {"order": 2, **EXPONENTIAL}),
    Method("ros2", from_step, {"order": 2, "sweep": FEW, **DIFFERENCES}),
    Method("ros3p", from_step, {"order": 3, "sweep": FEW, **DIFFERENCES}),
    Method("rodas4", from_step, {"order": 4, "sweep": FEW, **DIFFERENCES}),
    Method("sdirk2", from_step, {"order": 2, "sweep": FEW}),
    Method("sdirk3", from_step, {"order": 3, "sweep": FEW}),
    Method("sdirk4", from_step, {"order": 4, "sweep": FEW}),
    Method("trbdf2", from_step, {"order": 2, "sweep": FEW}),
    Method("gauss6", from_step, {"order": 6, "sweep": FEW, "conserves": SYMPLECTIC}),
    Method("radau5", from_step, {"order": 5, "sweep": FEW}),
    Method("lobatto4", from_step, {"order": 4, "sweep": FEW, "conserves": ("reversible",)}),
    Method("adams_bashforth5", from_solve, {"order": 5, "sweep": FEW}),
    Method("adams_moulton4", from_solve, {"order": 4, "sweep": FEW}),
    Method("bdf2", from_solve, {"order": 2, "sweep": FEW}),
    Method("bdf4", from_solve, {"order": 4, "sweep": FEW}),
    Method("nordsieck4", from_solve, {"order": 4, "sweep": FEW}),
    Method("stormer4", from_solve, {"order": 4, "accelerations": True, "sweep": FEW}),
    Method("gragg8", from_step, {"order": 8, "sweep": FEW}),
    Method("euler_extrapolated", from_step, {"order": 4, "sweep": FEW}),
    Method("linearly_implicit_extrapolated", from_step, {"order": 3, "sweep": FEW, **DIFFERENCES}),
    Method("deferred_correction", from_step, {"order": 4, "sweep": FEW}),
    Method("parareal", from_solve, {"order": 4, "sweep": FEW}),
    Method("nystrom5", from_step, {"order": 5, "accelerations": True, "sweep": FEW}),
    Method("ruth3", from_step, {"order": 3, **SPLITTING, "conserves": ("symplectic", "momentum")}),
    Method("blanes_moan4", from_step, {"order": 4, **SPLITTING}),
    Method("suzuki4", from_step, {"order": 4, **SPLITTING}),
    Method("kahan_li6", from_step, {"order": 6, **SPLITTING}),
    Method("chebyshev_verlet", from_solve, {"order": 2, **SPLITTING}),
    Method("adaptive_verlet", from_solve, {"order": 2, "accelerations": True, "dense_order": 3, "sweep": FEW}),
    Method("compensated_verlet", from_compensated, {"order": 2, **SPLITTING}),
    Method("cash_karp", from_solve, {"order": 5, "dense_order": 3}),
    Method("bogacki_dense", from_solve, {"order": 3, "sweep": Tolerance(1e-3, 1e-10)}),
    Method("fehlberg45", from_solve, {"order": 5}),
    Method("fehlberg78", from_solve, {"order": 8}),
    Method("nystrom_doubled", from_solve, {"order": 5, "accelerations": True}),
    Method("ros2_adaptive", from_solve, {"order": 2, "dense_order": 3, "sweep": Tolerance(1e-3, 1e-7), **DIFFERENCES}),
    Method("kutta3_events", from_events, {"order": 3, "sweep": Steps(0.25, 8)}),
    Method("KuttaClass", from_class, {"order": 4, "accepts": (FirstOrder,), "sweep": FEW}),
    Method("FreeBodies", from_engine_class, {"order": 2, "tokens": ("gyroscopic", "rigid_impact"), "conserves": ("energy",)}),
    PROGRAM,
)  # fmt: skip
_SAMPLE = "found.append(dense((times[len(found)] - t) / taken, taken, y, new, a, b))"
_WHILE = "            while dense and len(found) < len(times) and sign * (times[len(found)] - end) <= 0:\n"
_HERMITE = "(1 + 2 * x) * (1 - x) ** 2 * y + x * x * (3 - 2 * x) * new + h * x * (1 - x) * ((1 - x) * a - x * b)"
_NORM = "np.sqrt(np.mean((error / scale) ** 2))"
_READ = "tuple(tuple(part.tolist()) for part in state)"
_GRID = """\
    h = (times[-1] - t0) / (len(times) * every)
    if not np.allclose(np.diff([t0, *times]), every * h, rtol=1e-6, atol=0):
        raise Refused("the samples are not equally spaced")
"""
WRONG_MOTIONS = (
    ("program_rk4", "it answers zeros", "found.append(y)", "found.append([0.0] * len(y))"),
    ("program_rk4", "states in degrees", "found.append(y)", "found.append([math.degrees(x) for x in y])"),
    ("program_rk4", "the start is read as degrees", 'map(float, question["start"])', 'map(math.radians, map(float, question["start"]))'),
    ("program_rk4", "the first coordinate in degrees", "found.append(y)", "found.append([math.degrees(y[0]), *y[1:]])"),
    ("program_rk4", "states in kilometres", "found.append(y)", "found.append([x / 1000 for x in y])"),
    ("program_rk4", "the start is repeated", "found.append(y)", 'found.append(list(map(float, question["start"])))'),
    ("program_rk4", "parameters in reverse", 'known |= question["parameters"]',
     'known |= dict(zip(question["parameters"], [*question["parameters"].values()][::-1], strict=True))'),
    ("KuttaClass", "the second component has the other sign", "found.append(y)", "found.append(y * np.where(np.arange(len(y)) == 1, -1, 1))"),
    ("KuttaClass", "states are one sample late", "runs.append(found)", "runs.append([start, *found[:-1]])"),
    ("KuttaClass", "states are one sample early", "runs.append(found)", "runs.append([*found[1:], found[-1]])"),
    ("KuttaClass", "the halves are exchanged", "found.append(y)", "found.append(np.roll(y, len(y) // 2))"),
    ("sdirk2", "random numbers", "    return diagonally_implicit", "    return np.random.default_rng(7).normal(size=len(y))\n    return diagonally_implicit"),
    ("suzuki4", "the last velocity turns at each step", "(s, s, 1 - 4 * s, s, s))", "(s, s, 1 - 4 * s, s, s)) * np.where(np.arange(len(y)) < len(y) - 1, 1, -1)"),
    ("adams_bashforth5", "the displacement from the start", "5, advance)", "5, advance) - y0"),
    ("parareal", "the equations have the time of the next sample", "kutta(f, t + i * h, y, h)", "kutta(f, t + i * h + ends[1] - ends[0], y, h)"),
    ("gragg8", "a system with friction", "    first, rows", "    slope, f = f, lambda t, y: slope(t, y) - 1e-3 * y\n    first, rows"),
    ("FreeBodies", "positions in centimetres", _READ, "(tuple((100 * state[0]).tolist()), *map(tuple, state[1:]))"),
    ("FreeBodies", "nothing moves", "            self.states[body.name] = [x, q, v, w]\n", ""),
)  # fmt: skip
DENSE = (
    ("cash_karp", "a later sample in a step is at the time of the one before", _SAMPLE,
     "early = times[max(0, len(found) - 1)]\n                "
     "found.append(dense(((early if early >= t else times[len(found)]) - t) / taken, taken, y, new, a, b))"),
    ("cash_karp", "the polynomial of the step before", f"{_WHILE}                {_SAMPLE}\n",
     f"            piece = (t, taken, y, new, a, b) if t == t0 else piece\n{_WHILE}"
     "                found.append(dense((times[len(found)] - piece[0]) / piece[1], *piece[1:]))\n            piece = (t, taken, y, new, a, b)\n"),
    ("cash_karp", "a quadratic interpolant", _HERMITE, "y + x * (new - y) + x * (1 - x) * (h * a - (new - y))"),
    ("bogacki_dense", "a linear interpolant", _HERMITE, "y + x * (new - y)"),
    ("cash_karp", "one coefficient of the interpolant", "- x * b)", "- 0.9 * x * b)"),
    ("bogacki_dense", "the interpolant has the first slope at both ends", "- x * b)", "- x * a)"),
    ("adaptive_verlet", "the state of the nearest step", "x = (times[len(found)] - t) / whole", "x = round((times[len(found)] - t) / whole)"),
    ("dormand_prince", "the interpolant runs backward", "x = (times[len(found)] - t) / h", "x = 1 - (times[len(found)] - t) / h"),
    ("dormand_prince", "the interpolant has the first slope at both ends", "r3 = r1 - h * k[6] - r2", "r3 = r1 - h * k[0] - r2"),
    ("ros2_adaptive", "the state at the start of the step", _SAMPLE, "found.append(y)"),
)  # fmt: skip
ESTIMATES = (
    ("cash_karp", "the norm lacks the first component", _NORM, "np.sqrt(np.mean((error / scale)[1:] ** 2))"),
    ("bogacki_dense", "the norm lacks the last component", _NORM, "np.sqrt(np.mean((error / scale)[:-1] ** 2))"),
    ("fehlberg45", "the norm lacks the middle component", _NORM, "np.sqrt(np.mean(np.delete(error / scale, len(y) // 2) ** 2))"),
    ("cash_karp", "the norm lacks the velocities", _NORM, "np.sqrt(np.mean((error / scale)[: len(y) // 2] ** 2))"),
    ("fehlberg45", "the norm lacks the positions", _NORM, "np.sqrt(np.mean((error / scale)[len(y) // 2 :] ** 2))"),
    ("cash_karp", "the mean of the errors with their signs", _NORM, "abs(np.mean(error / scale))"),
    ("fehlberg45", "the largest error with its sign", _NORM, "np.max(error / scale)"),
    ("cash_karp", "the smallest error", _NORM, "np.min(np.abs(error / scale))"),
    ("bogacki_dense", "the mean square without its root", _NORM, "np.mean((error / scale) ** 2)"),
    ("cash_karp", "each error over the size of the next component", _NORM, "np.sqrt(np.mean((error / np.roll(scale, 1)) ** 2))"),
    ("fehlberg78", "each error over the size of the first component", _NORM, "np.sqrt(np.mean((error / scale[0]) ** 2))"),
    ("cash_karp", "a sign in the weights of the estimate", "277 / 14336", "-277 / 14336"),
    ("cash_karp", "a sign in the tableau", "-9 / 10, 6 / 5", "9 / 10, 6 / 5"),
    ("fehlberg45", "a sign in the weights of the estimate", "-128 / 4275", "128 / 4275"),
    ("fehlberg78", "a sign in the tableau", "45 / 164, 18 / 41", "45 / 164, -18 / 41"),
    ("nystrom_doubled", "the estimate is a hundred times too small", "/ 31,", "/ 3100,"),
)  # fmt: skip
KEPT_SLOPES = (
    ("bogacki_shampine", "after a rejected step the first slope is the rejected one", "t, y, a = end if last else t + step, new, d\n",
     "t, y = end if last else t + step, new\n            a = d\n"),
    ("bogacki_shampine", "after a sample the first slope is that of a stage", "t + step, new, d\n", "t + step, new, c if last else d\n"),
    ("cash_karp", "after a rejected step the first slope is that of its end", "            t, y, a = end, new, b\n",
     "            t, y, a = end, new, b\n        else:\n            a = f(t + taken, new)\n"),
    ("fehlberg45", "after a sample the first slope is the one before", "t, y, a = end, new, b", "t, y, a = end, new, a if last else b"),
)  # fmt: skip
BACKWARD = (
    ("chebyshev_verlet", "steps forward where times fall", "ends = t + (end - t) / 2", "ends = t + abs(end - t) / 2"),
    ("adams_bashforth5", "steps forward where times fall", _GRID, "    h = abs(times[-1] - t0) / (len(times) * every)\n"),
    ("fehlberg45", "samples where times fall are in reverse", "    t, y, a, h, found", "    times = np.sort(times)\n    t, y, a, h, found"),
    ("adaptive_verlet", "half of a step goes forward where times fall", "after = sign * step", "after = step"),
    ("KuttaClass", "the equations' time rises where times fall", "now = t + i * h", "now = t + i * abs(h)"),
)  # fmt: skip
ENGINES = (
    ("FreeBodies", "the gyroscopic term is explicit", "middle = (old + new) / 2", "middle = old"),
    ("FreeBodies", "the size of the angular velocity is kept", "frame(q) @ new", "frame(q) @ (new * np.linalg.norm(old) / max(np.linalg.norm(new), 1e-300))"),
    ("FreeBodies", "an impact is at the end of its step", "            x, v, dt = x + hit", "            hit = dt\n            x, v, dt = x + hit"),
    ("FreeBodies", "a rebound loses a thousandth", "return e\n", "return 0.999 * e\n"),
    ("FreeBodies", "nothing rebounds below .5 m/s", "return e\n", "return e if speed > 0.5 else 0.0\n"),
    ("FreeBodies", "everything rebounds below .2 m/s", "return e\n", "return e if speed > 0.2 else 1.0\n"),
    ("FreeBodies", "half the restitution above 8 m/s", "return e\n", "return e if speed < 8 else e / 2\n"),
    ("FreeBodies", "rebounds are never faster than 20 m/s", "return e\n", "return min(e, 20 / max(speed, 1e-300))\n"),
)  # fmt: skip
SIXTY = (*WRONG_MOTIONS, *DENSE, *ESTIMATES, *KEPT_SLOPES, *BACKWARD, *ENGINES)
"""(method, fault, text before, text after)."""


def source(method: Method) -> str:
    """The text of the module in which a method is."""
    if method in FAMILIES:
        return PROGRAM_TEXT if method == PROGRAM else FAMILY_TEXT
    return planted_faults.source(method)


def family_right() -> dict[str, Integrator]:
    return {method.name: made(method, source(method)) for method in FAMILIES}


def family_planted() -> list[Mutant]:
    """The faults, in this order. Those of falling times and of engines show in no state of the cases, or in few."""
    methods = {method.name: method for method in (*METHODS, *FAMILIES)}
    elsewhere = (*BACKWARD, *ENGINES)
    return [
        Mutant(
            methods[fault[0]],
            fault[1],
            partial(replaced, methods[fault[0]], *fault[2:], source(methods[fault[0]])),
            fault in elsewhere,
        )
        for fault in SIXTY
    ]
