"""Sixty faults planted in right methods, of these sixteen kinds of methods, before the claims that look for them changed.

Each is a mistake that users make: a term, an index, a time, a sign, a stopping rule, or data kept from call to call.
"""

from functools import partial
from pathlib import Path

from gnomon.cases.core.forms import Charged, Constrained, NBody, RigidBody, SemiLinear
from gnomon.harness.contract.integrator import Steps
from mutants import METHODS, SYMPLECTIC, TEXT, Method, Mutant, replaced
from special_adapters import from_compensated, from_ensemble, from_form, from_rising

from gnomon.verify import from_step

MORE_TEXT = Path(__file__).with_name("more_methods.py").read_text()
FEW = Steps(0.125, 7)
MORE = (
    Method("nystrom", from_step, {"order": 4, "accelerations": True, "sweep": FEW}),
    Method("yoshida6", from_step, {"order": 6, "accelerations": True, "conserves": (*SYMPLECTIC, "momentum")}, ("PARTS",)),
    Method("radau3", from_step, {"order": 3, "sweep": FEW}),
    Method("abm", from_rising, {"order": 4, "sweep": FEW}),
    Method("compensated", from_compensated, {"order": 4, "make": from_rising, "sweep": FEW}),
    Method("ensemble", from_ensemble, {"order": 3, "sweep": FEW}),
    Method("boris", from_form, {"accepts": (Charged,), "order": 2, "conserves": ("volume", "reversible"), "sweep": FEW}),
    Method("rattle", from_form, {"accepts": (Constrained,), "order": 2, "sweep": FEW,
                                 "conserves": (*SYMPLECTIC, "momentum", "constraint")}),
    Method("quaternion", from_form, {"accepts": (RigidBody,), "order": 4, "conserves": ("attitude",), "sweep": FEW}),
    Method("bodies", from_form, {"accepts": (NBody,), "order": 2, "conserves": (*SYMPLECTIC, "momentum"), "sweep": FEW}),
    Method("exponential_heun", from_form, {"accepts": (SemiLinear,), "order": 2, "sweep": FEW}),
)  # fmt: skip
PLANTED = (
    ("nystrom", "weights of position and velocity are exchanged", "h * h / 6 * (a + 2 * b)\n    v = v + h / 6 * (a + 4 * b + c)",
     "h * h / 12 * (a + 4 * b + c)\n    v = v + h / 3 * (a + 2 * b)"),
    ("nystrom", "the middle stage has h^2 / 4", "h * h / 8 * a", "h * h / 4 * a"),
    ("nystrom", "the last stage has the time of the middle", "c = f(t + h, q", "c = f(t + h / 2, q"),
    ("nystrom", "positions from the third on lack the second stage", "q = q + h * v + h * h / 6 * (a + 2 * b)",
     "q = q + h * v + h * h / 6 * np.where(np.arange(len(q)) < 2, a + 2 * b, 3 * a)"),
    ("yoshida6", "the sixth digit of a coefficient", "0.235573213359358133684793182978", "0.235575213359358133684793182978"),
    ("yoshida6", "coefficients with seven digits", "PARTS = (0.784513610477557263819497633866, 0.235573213359358133684793182978, -1.17767998417887100694641568096)",
     "PARTS = (0.7845136, 0.2355732, -1.1776800)"),
    ("yoshida6", "the coefficients in the same order again", "*PARTS[::-1])", "*PARTS)"),
    ("radau3", "one iteration of Newton's method", "range(50)", "range(1)"),
    ("radau3", "the iteration stops at 1e-4", "> 1e-15 *", "> 1e-4 *"),
    ("radau3", "the first Jacobian is kept and iterated three times", "    z = np.zeros((2, n))",
     "    matrix = KEPT.setdefault(n, matrix)\n    z = np.zeros((2, n))"),
    ("radau3", "the Jacobian is transposed", "return np.array(columns).T", "return np.array(columns)"),
    ("radau3", "both stages have the time of the step's end", "(1 / 3, 1.0)", "(1.0, 1.0)"),
    ("abm", "the first steps by Euler's method", "y = y + h / 6 * (a + 2 * b + 2 * c + f(t + h, y + h * c))", "y = y + h * a"),
    ("abm", "the corrector has a wrong sign", "19 * s - 5 * u + x", "19 * s - 5 * u - x"),
    ("abm", "the slopes of an earlier run start this one", "[f(t0, y0)]", "KEPT.setdefault(len(y0), [f(t0, y0)])"),
    ("compensated", "the rest has the wrong sign", "(a + 2 * b + 2 * c + d) + rest", "(a + 2 * b + 2 * c + d) - rest"),
    ("compensated", "the change of a step is added with the rest of the state", "change - (after - y)", "change - after"),
    ("ensemble", "the second motion has the stages of the first", "b = np.array([f(t + h / 3, each) for each in y + h / 3 * a])",
     "b = np.array([f(t + h / 3, each) for each in y + h / 3 * a])\n        b[1:2] = b[0]"),
    ("ensemble", "motions after the first in single precision", "y, found = starts, []",
     "y, found = np.array([each.astype('f4') if i else each for i, each in enumerate(starts)], dtype=float), []"),
    ("ensemble", "the last of several motions stays where it is after half the time", "y = y + h / 4 * (a + 3 * c)",
     "still = (np.arange(len(y)) == len(y) - 1) & (len(y) > 1) & (k >= count // 2)\n        y = np.where(still[:, None], y, y + h / 4 * (a + 3 * c))"),
    ("ensemble", "the motions are returned in reverse", "transpose(1, 0, 2)", "transpose(1, 0, 2)[::-1]"),
    ("boris", "the velocity of the middle of the last step is returned", "            found.append(np.concatenate([x, u]))",
     "            found.append(np.concatenate([x, u - h / 2 * a]))"),
    ("boris", "the magnetic term has the wrong sign", "np.cross(u + np.cross(u, turn), turn)", "np.cross(turn, u + np.cross(turn, u))"),
    ("boris", "the rotation's factor lacks the square", "2 / (1 + turn @ turn)", "2"),
    ("boris", "fields at the start of the step", "form.fields(t + h / 2, tuple(x), p)", "form.fields(t, tuple(x), p)"),
    ("boris", "a smaller mass in the rotation: no gamma", "turn = h / 2 * w / math.sqrt(1 + u @ u / light**2)", "turn = h / 2 * w"),
    ("rattle", "velocities are not projected", "        v = v - (slope @ v) / (slope @ slope) * slope\n", ""),
    ("rattle", "one iteration for the constraint", "range(50)", "range(1)"),
    ("rattle", "the projection lacks the square of the gradient", "(slope @ v) / (slope @ slope)", "(slope @ v) / np.linalg.norm(slope)"),
    ("rattle", "the constraint is solved to 1e-6", "> 1e-15 *", "> 1e-6 *"),
    ("quaternion", "the quaternion is not normalised", "        y[3:] = y[3:] / np.linalg.norm(y[3:])\n", ""),
    ("quaternion", "the norm is the sum of sizes", "y[3:] = y[3:] / np.linalg.norm(y[3:])", "y[3:] = y[3:] / np.sum(np.abs(y[3:]))"),
    ("quaternion", "factors of the product are exchanged", "product(q, np.array([0.0, *spin]))", "product(np.array([0.0, *spin]), q)"),
    ("quaternion", "the angular velocity is rounded to single precision", "spin, q = y[:3], y[3:]", "spin, q = y[:3].astype('f4').astype(float), y[3:]"),
    ("quaternion", "the sign of the gyroscopic term", "p)) - np.cross(spin", "p)) + np.cross(spin"),
    ("bodies", "masses in reverse order", "masses, state = form.masses(p)", "masses, state = form.masses(p)[::-1]"),
    ("bodies", "forces are softened", "np.linalg.norm(line) ** 3", "(line @ line + 1e-6) ** 1.5"),
    ("bodies", "the first body is held", "        x = x + h * v\n", "        x = x + h * v * (np.arange(len(x)) > 0)[:, None]\n"),
    ("bodies", "the third body acts on none", "total[j] -= masses[i] * line / cube", "total[j] -= masses[i] * line / cube\n                total[j] += 0 if i < 2 else masses[i] * line / cube"),
    ("exponential_heun", "phi_1 / 2 in place of phi_2", "h * two @", "h * first / 2 @"),
    ("exponential_heun", "the exponential by three terms of its series", "power, first, two = functions(h * linear)",
     "power, first, two = functions(h * linear)\n    power = np.eye(len(y0)) + h * linear + h * h / 2 * linear @ linear"),
    ("exponential_heun", "the second stage has the time of the first", "form.rest(t + h, tuple(middle), p)", "form.rest(t, tuple(middle), p)"),
    ("dormand_prince", "the error estimate is divided by 100", "/ norm(y, tolerance)", "/ norm(y, tolerance) / 100"),
    ("dormand_prince", "the error of the first two components only", "np.linalg.norm(h * sum(e * s for e, s in zip(E, k, strict=True)))",
     "np.linalg.norm((h * sum(e * s for e, s in zip(E, k, strict=True)))[:2])"),
    ("dormand_prince", "the slope of a rejected step is passed on", "        h = h * min(5.0", "        else:\n            first = k[6]\n        h = h * min(5.0"),
    ("dormand_prince", "states are printed with seven digits", "    return np.array(found)", "    return np.array([[float(f'{x:.7g}') for x in row] for row in found])"),
    ("dormand_prince", "samples are one sample early", "    return np.array(found)", "    return np.array([y0, *found[:-1]])"),
    ("dormand_prince", "the state stays where the step becomes too short", "return np.full((len(times), len(y0)), np.nan)",
     "return np.array([*found, *[y] * (len(times) - len(found))])"),
    ("dormand_prince", "the equations get the time since the start", "k.append(f(t + c * h, new))", "k.append(f(t - t0 + c * h, new))"),
    ("dormand_prince", "dense output of components from the third on is linear",
         "found.append(y + x * (r1 + (1 - x) * (r2 + x * (r3 + (1 - x) * r4))))",
         "found.append(y + x * (r1 + np.where(np.arange(len(y)) < 2, (1 - x) * (r2 + x * (r3 + (1 - x) * r4)), 0)))"),
    ("bogacki_shampine", "an error that is no number is none", "            if not np.isfinite(error)", "            new, d, error = np.nan_to_num(new), np.nan_to_num(d), np.nan_to_num(error)\n            if not np.isfinite(error)"),
    ("bogacki_shampine", "the start is changed by the caller's array", "        found.append(y)", "        found.append(y)\n    y0[:] = y"),
    ("richardson", "substeps 2, 4, 6, 10 with the numbers of 2, 4, 6, 8", "(2, 4, 6, 8)", "(2, 4, 6, 10)"),
    ("richardson", "an absolute tolerance of what is relative", "np.linalg.norm(three - two[1]) / norm(y, tolerance)", "np.linalg.norm(three - two[1]) / tolerance / 1e3"),
    ("rk4", "components from the seventh on by Euler's method", "    return y + h / 6 * (a + 2 * b + 2 * c + d)",
     "    return y + np.where(np.arange(len(y)) < 6, h / 6 * (a + 2 * b + 2 * c + d), h * a)"),
    ("adams", "the time is counted from 0", "t = t0 + k * h", "t = k * h"),
    ("rk4_events", "the guard has the time of the step's start", "event.guard(t + x, tuple(rk4(f, t, y, x)), p)", "event.guard(t, tuple(rk4(f, t, y, x)), p)"),
    ("rk4_events", "the times of events in single precision", "events.append((t, event.name))", "events.append((float(np.float32(t)), event.name))"),
    ("rotation", "three terms of the exponential's series", "    half = np.sin(angle / 2) / (angle / 2)", "    return np.eye(3) + hat(s) + hat(s) @ hat(s) / 2 + hat(s) @ hat(s) @ hat(s) / 6\n    half = 1.0"),
    ("LeapfrogEngine", "the third component of forces is left out", "            value = np.array(force.law(self.t, tuple(x), tuple(v)))",
     "            value = np.array(force.law(self.t, tuple(x), tuple(v))) * [1, 1, 0]"),
)  # fmt: skip
"""(method, fault, text before, text after)."""


def source(method: Method) -> str:
    """The text of the module in which a method is."""
    return TEXT if method in METHODS else MORE_TEXT


def planted() -> list[Mutant]:
    """The planted faults, in this order."""
    methods = {method.name: method for method in (*METHODS, *MORE)}
    return [
        Mutant(methods[name], fault, partial(replaced, methods[name], before, after, source(methods[name])))
        for name, fault, before, after in PLANTED
    ]
