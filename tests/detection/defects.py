"""Real defects from public trackers, each rebuilt in a minimal integrator: the link, the fault, and its text.

A rebuilt defect has the fault of the thread in one of the right methods, or in a function of its own. It does not copy
the project's code: each fault was read from its thread. The projects have mended most of the defects.
"""

from dataclasses import dataclass
from typing import Any

from gnomon.harness.contract.integrator import Integrator, Steps
from mutants import METHODS, TEXT, Method, made, replaced

from gnomon.verify import from_solve, from_step

RIGHT = {method.name: method for method in METHODS}
FUNCTIONS = """

def kutta3_frozen(f, t, y, h):
    a = f(t, y)
    b = f(t, y + h / 2 * a)
    c = f(t, y + h * (2 * b - a))
    return y + h / 6 * (a + 4 * b + c)


def fehlberg(f, t, y, h, a53=-3544 / 2565, weights=(16 / 135, 0.0, 6656 / 12825, 28561 / 56430, -9 / 50, 2 / 55)):
    k1 = f(t, y)
    k2 = f(t + h / 4, y + h / 4 * k1)
    k3 = f(t + 3 / 8 * h, y + h * (3 / 32 * k1 + 9 / 32 * k2))
    k4 = f(t + 12 / 13 * h, y + h * (1932 / 2197 * k1 - 7200 / 2197 * k2 + 7296 / 2197 * k3))
    k5 = f(t + h, y + h * (439 / 216 * k1 - 8 * k2 + 3680 / 513 * k3 - 845 / 4104 * k4))
    k6 = f(t + h / 2, y + h * (-8 / 27 * k1 + 2 * k2 + a53 * k3 + 1859 / 4104 * k4 - 11 / 40 * k5))
    return y + h * sum(w * k for w, k in zip(weights, (k1, k2, k3, k4, k5, k6), strict=True))


def fehlberg_typo(f, t, y, h):
    return fehlberg(f, t, y, h, -3554 / 2565)


def fehlberg_lower(f, t, y, h):
    return fehlberg(f, t, y, h, weights=(25 / 216, 0.0, 1408 / 2565, 2197 / 4104, -1 / 5, 0.0))


def diagonally_implicit(f, t, y, h):
    k = m = f(t, y)
    for _ in range(200):
        k = f(t + h / 2, y + h / 2 * k)
        m = f(t + 3 / 2 * h, y + h * (2 * m - k / 2)) * 0.3 + m * 0.7
    return y + h * (3 / 2 * m - k / 2)


def euler_called_symplectic(f, t, y, h):
    q, v = np.split(y, 2)
    return np.concatenate([q + h * v, v + h * f(t, q)])


def trapezoidal(f, t0, y0, times, step):
    count = round(times[-1] / step)
    h, y, found = times[-1] / count, y0, []
    before = f(t0, y0)
    for k in range(count):
        slope = f(t0 + k * h, y)
        y = y + h / 2 * (slope + before)
        before = slope
        if (k + 1) % (count // len(times)) == 0:
            found.append(y)
    return np.array(found)


def one_by_one(f, t, y, h):
    middle = y.copy()
    for i in range(len(y)):
        middle[i] = y[i] + h / 2 * f(t, middle)[i]
    return y + h * f(t + h / 2, middle)


def omits_steps(f, t0, y0, times, step):
    t, y, found = t0, y0, []
    for end in times:
        while t + step <= end:
            y = rk4(f, t, y, step)
            t = t + step
        found.append(y)
    return np.array(found)


def time_in_single_precision(f, t0, y0, times, step):
    t, y, found = np.float32(t0), y0, []
    count = round(times[0] / step)
    h = times[0] / count
    for _ in times:
        for _ in range(count):
            y = rk4(f, float(t), y, h)
            t = np.float32(t + np.float32(h))
        found.append(y)
    return np.array(found)


def first_step_in_other_units(f, t0, y0, times, step):
    t, y, found = t0, y0, []
    count = round(times[0] / step)
    h = times[0] / count
    for k in range(len(times)):
        for i in range(count):
            y = rk4(f, t, y, h / 1000 if k == i == 0 else h)
            t = t + h
        found.append(y)
    return np.array(found)


def positions_in_single_precision(f, t0, y0, times, step):
    q, v = (part.astype("f4") for part in np.split(y0, 2))
    found, count = [], round(times[0] / step)
    h = np.float32(times[0] / count)
    before = q - h * v + h * h / 2 * f(t0, q.astype("f8")).astype("f4")
    t = t0
    for _ in times:
        for _ in range(count):
            q, before = q + (q - before) + h * h * f(t, q.astype("f8")).astype("f4"), q
            t = t + float(h)
        found.append(np.concatenate([q, (q - before) / h]).astype("f8"))
    return np.array(found)
"""
FIXED = {"sweep": Steps(0.125, 8)}


@dataclass(frozen=True)
class Defect:
    """`changes` of the text of a right method, or none where `method` is a function of FUNCTIONS."""

    link: str
    what: str
    method: Method
    changes: tuple[tuple[str, str], ...] = ()

    def integrator(self) -> Integrator:
        text = TEXT if self.changes else TEXT + FUNCTIONS
        for before, after in self.changes:
            text = replaced(self.method, before, after, text)
        return made(self.method, text, self.link.rsplit("/", 1)[1])


def own(name: str, make: Any, **declared: Any) -> Method:
    return Method(name, make, declared)


GITHUB = "https://github.com/"
ROWS: tuple[tuple[str, str, Method, tuple[tuple[str, str], ...]], ...] = (
    ("f1tenth/f1tenth_gym/pull/52", "the third stage is evaluated at the second stage's state",
     RIGHT["rk4"], (("c = f(t + h / 2, y + h / 2 * b)", "c = f(t + h / 2, y + h / 2 * a)"),)),
    ("probabilistic-numerics/probnum/issues/252", "the time does not advance in the stages",
     RIGHT["rk4"], (("b = f(t + h / 2", "b = f(t"), ("c = f(t + h / 2", "c = f(t"), ("d = f(t + h", "d = f(t"))),
    ("mandli/intro-numerical-methods/issues/36", "a stage's time lacks the factor of the step",
     RIGHT["rk4"], (("c = f(t + h / 2", "c = f(t + 1 / 2"),)),
    ("CliMA/Oceananigans.jl/issues/6003", "forces of time are evaluated at the step's start in every stage",
     own("kutta3_frozen", from_step, order=3), ()),
    ("JuliaGNI/GeometricIntegrators.jl/issues/148", "the time given to the equations is that within the step",
     RIGHT["rk4"], (("a = f(t, y)", "t = 0.0\n    a = f(t, y)"),)),
    ("headmyshoulder/odeint-v2/issues/150", "velocity Verlet with h / 2 v + h^2 a",
     RIGHT["verlet"], (("q = q + h * middle", "q = q + h / 2 * v + h * h * f(t, q)"),)),
    ("chaos-polymtl/lethe/pull/134", "half a square of the step times the acceleration is added twice",
     RIGHT["verlet"], (("q = q + h * middle", "q = q + h * middle + h * h / 2 * f(t, q)"),)),
    ("chaos-polymtl/lethe/pull/2082", "the velocity is not staggered: symplectic Euler",
     RIGHT["verlet"], (("middle = v + h / 2 * f(t, q)", "middle = v + h * f(t, q)"), ("v = middle + h / 2 * f(t + h, q)", "v = middle"))),
    ("TeamAtomECS/AtomECS/pull/18", "the second half kick has the force of the step's start",
     RIGHT["verlet"], (("middle = v + h / 2 * f(t, q)", "old = f(t, q)\n    middle = v + h / 2 * old"), ("h / 2 * f(t + h, q)", "h / 2 * old"))),
    ("SciML/OrdinaryDiffEq.jl/issues/577", "explicit Euler under the name of symplectic Euler",
     own("euler_called_symplectic", from_step, order=1, accelerations=True, conserves=("symplectic",)), ()),
    ("hannorein/rebound/pull/882", "a truncated coefficient of a composition",
     RIGHT["yoshida"], (("1 / (2 - 2 ** (1 / 3))", "1.3512071919"),)),
    ("pathsim/pathsim/issues/232", "declared order 5, the row of order 4 is passed on", own("fehlberg_lower", from_step, order=5), ()),
    ("pathsim/pathsim/issues/232#a53", "a digit of a coefficient", own("fehlberg_typo", from_step, order=5), ()),
    ("giovannipurpura/daceypy/pull/11", "a denominator that lacks its last digit",
     RIGHT["dormand_prince"], (("49 / 176", "49 / 17"),)),
    ("JuliaGNI/RungeKutta.jl/pull/27", "a method of order 1 that is declared of order 2",
     own("diagonally_implicit", from_step, order=2, **FIXED), ()),
    ("llnl/sundials/pull/850", "a wrong sign in the weights of the error estimate", RIGHT["dormand_prince"], (("-1 / 40", "1 / 40"),)),
    ("princemahajan/FLINT/issues/14", "coefficients of the dense output changed places",
     RIGHT["dormand_prince"], (("87487479700 / 32700410799, -10690763975 / 1880347072", "-10690763975 / 1880347072, 87487479700 / 32700410799"),)),
    ("scipy/scipy/issues/14480", "the last term of the dense output is left out where the next step is longer",
     RIGHT["dormand_prince"], (("            while len(found) < len(times) and", "            r4 = r4 if 0.9 * error**-0.2 <= 1 else 0 * r4\n            while len(found) < len(times) and"),)),
    ("LupoLab/Luna.jl/pull/436", "the dense output overwrites the slope that is passed on",
     RIGHT["dormand_prince"], (("t, y, first = t + h, new, k[6]", "first = k[6] if len(found) == before else k[4]\n            t, y = t + h, new"),
                               ("r1 = new - y", "before = len(found)\n            r1 = new - y"))),
    ("OpenModelica/OpenModelica/pull/10153", "a wrong formula of the dense output",
     RIGHT["dormand_prince"], (("(r2 + x * (r3 + (1 - x) * r4))", "(r2 + (1 - x) * (r3 + x * r4))"),)),
    ("OPALX-project/OPAL/issues/1375", "the time of a leapfrog counts twice",
     RIGHT["verlet"], (("f(t, q)", "f(2 * t, q)"), ("f(t + h, q)", "f(2 * (t + h), q)"))),
    ("havokentity/demont-engine/issues/270", "positions of Verlet's method in single precision",
     own("positions_in_single_precision", from_solve, order=2, accelerations=True, **FIXED), ()),
    ("Facepunch/sbox-issues/issues/8096", "the time in single precision",
     own("time_in_single_precision", from_solve, order=4, **FIXED), ()),
    ("space-wizards/RobustToolbox/pull/1037", "small displacements are ignored",
     RIGHT["verlet"], (("q = q + h * middle", "q = np.where(np.abs(h * middle) < 1e-3, q, q + h * middle)"),)),
    ("SciML/DiffEqGPU.jl/pull/537", "the last step is too long, and its end is called the end of the span",
     RIGHT["bogacki_shampine"], (("step = end - t if last else h", "step = h"),)),
    ("headmyshoulder/odeint-v2/issues/99", "a sample is the state after it was passed",
     RIGHT["bogacki_shampine"], (("step = end - t if last else h", "step = h"), ("t, y, a = end if last else t + step", "t, y, a = t + step"))),
    ("SciML/SimpleDiffEq.jl/issues/81", "the last step is omitted where rounding says so",
     own("omits_steps", from_solve, order=4, **FIXED), ()),
    ("SciML/OrdinaryDiffEq.jl/issues/1638", "the first slope is that of an earlier run",
     RIGHT["dormand_prince"], (("found, first = [], f(t0, y0)", "found, first = [], KEPT.pop(len(y0), f(t0, y0))"),
                               ("    return np.array(found)", "    KEPT[len(y0)] = first\n    return np.array(found)"))),
    ("openrocket/openrocket/pull/3013", "of a stage's slopes only the last counts",
     RIGHT["dormand_prince"], (("sum(a * b for a, b in zip(row, k, strict=True))", "(row[-1] * k[-1])"),)),
    ("anderkve/FYS3150/issues/73", "components are updated before the slopes of the others are computed",
     own("one_by_one", from_step, order=2), ()),
    ("JSBSim-Team/jsbsim/pull/1453", "a trapezoidal rule with the slope before, of order 1",
     own("trapezoidal", from_solve, order=2, **FIXED), ()),
    ("google-deepmind/mujoco_warp/issues/1662", "what is not finite becomes finite",
     RIGHT["rk4"], (("return y + h / 6 * (a + 2 * b + 2 * c + d)", "return np.nan_to_num(y + h / 6 * (a + 2 * b + 2 * c + d))"),)),
    ("scipy/scipy/issues/9228", "an event between the ends of a step is missed: the sign is compared at the ends only",
     RIGHT["rk4_events"], (("if side(last) > 0:", "if side(0.0) < 0 < side(last):"),)),
    ("pybamm-team/PyBaMM/issues/1318", "the event is where a line through the ends of the step says",
     RIGHT["rk4_events"], (("first = high, event", "a, b = side(0.0), side(last)\n                    first = (last * a / (a - b) if a < 0 else high), event"),)),
    ("sofa-framework/sofa/pull/172", "a map that is right for small angles only, in place of the exponential of a rotation",
     RIGHT["rotation"], (("R @ exponential(change[1])", "R @ (np.linalg.inv(np.eye(3) - hat(change[1]) / 2) @ (np.eye(3) + hat(change[1]) / 2))"),)),
    ("tomstewart89/Geometry/issues/13", "an angle below a limit becomes 1 in the formula of the exponential",
     RIGHT["rotation"], (("if angle < 1e-8:\n        return np.eye(3) + hat(s)", "if angle < 1e-5:\n        angle = 1.0"),)),
    ("avianphysics/avian/pull/747", "the rotation of a step is multiplied from the other side",
     RIGHT["rotation"], (("R @ exponential(change[1])", "exponential(change[1]) @ R"),)),
    ("google/brax/pull/62", "it rotates twice as fast", RIGHT["rotation"], (("R @ exponential(change[1])", "R @ exponential(2 * change[1])"),)),
    ("gyroflow/gyroflow/issues/644", "the first step is in other units",
     own("first_step_in_other_units", from_solve, order=4, **FIXED), ()),
)  # fmt: skip
DEFECTS = tuple(Defect(GITHUB + link, what, method, changes) for link, what, method, changes in ROWS)
