"""Systems of other people's with their states at the end of a span, published or in closed form.

The functions are as users of SciPy write them, with numpy and math in several styles. `SYSTEMS` has their spans, starts and
digits. The digits that circulate are often of a slightly different problem than a file states (a period or a constant such
as 0.0057 is rounded to binary64), and the last of them may be wrong: so `System` has both the published digits and those of
the problem as stated here.
"""

import csv
from collections.abc import Callable
from dataclasses import dataclass
from math import pi, sin
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
from mpmath import mp, mpf

import gnomon


def pleiades(t, u):
    x, y, vx, vy = u[:7], u[7:14], u[14:21], u[21:]
    mass = np.arange(1, 8)
    ax = np.zeros_like(x)
    ay = np.zeros_like(y)
    for i in range(7):
        for j in range(7):
            if i != j:
                r3 = ((x[i] - x[j]) ** 2 + (y[i] - y[j]) ** 2) ** 1.5
                ax[i] += mass[j] * (x[j] - x[i]) / r3
                ay[i] += mass[j] * (y[j] - y[i]) / r3
    return np.concatenate([vx, vy, ax, ay])


def van_der_pol(t, y, eps):
    return [y[1], ((1 - y[0] ** 2) * y[1] - y[0]) / eps]


def hires(t, y):
    dy = np.empty_like(y)
    dy[0] = -1.71 * y[0] + 0.43 * y[1] + 8.32 * y[2] + 0.0007
    dy[1] = 1.71 * y[0] - 8.75 * y[1]
    dy[2] = -10.03 * y[2] + 0.43 * y[3] + 0.035 * y[4]
    dy[3] = 8.32 * y[1] + 1.71 * y[2] - 1.12 * y[3]
    dy[4] = -1.745 * y[4] + 0.43 * (y[5] + y[6])
    dy[5] = -280 * y[5] * y[7] + 0.69 * y[3] + 1.71 * y[4] - 0.43 * y[5] + 0.69 * y[6]
    dy[6] = 280 * y[5] * y[7] - 1.81 * y[6]
    dy[7] = -dy[6]
    return dy


def rober(t, y):
    a, b, c = y
    slow, fast, back = 0.04 * a, 3e7 * b * b, 1e4 * b * c
    return [-slow + back, slow - back - fast, fast]


def e5(t, y, a=7.89e-10, b=1.1e7, c=1.13e9, d=1.13e3):
    made, bound, lost, freed = a * y[0], b * y[0] * y[2], c * y[1] * y[2], d * y[3]
    return np.array([-made - bound, made - lost, made - lost - bound + freed, bound - freed])


def beam(t, y, n=40):
    th, thdot = y[:n], y[n:]
    d = th[1:] - th[:-1]
    sd, cd = np.sin(d), np.cos(d)

    # bending, and the force at the free end as long as it acts
    v = np.empty_like(th)
    v[0] = n**4 * (-3 * th[0] + th[1])
    v[1:-1] = n**4 * (th[:-2] - 2 * th[1:-1] + th[2:])
    v[-1] = n**4 * (th[-2] - th[-1])
    if t <= pi:
        fy = 1.5 * np.sin(t) ** 2
        fx = -fy
        v = v + n**2 * (fy * np.cos(th) - fx * np.sin(th))

    # w = D v + thdot^2, and C w' = w for the tridiagonal C of cosines
    w = thdot**2
    w[1:] -= sd * v[:-1]
    w[:-1] += sd * v[1:]
    diagonal = [1.0] + [2.0] * (n - 2) + [3.0]
    for i in range(n - 2, -1, -1):
        q = -cd[i] / diagonal[i + 1]
        w[i] -= q * w[i + 1]
        diagonal[i] += q * cd[i]
    w[0] /= diagonal[0]
    for i in range(1, n):
        w[i] = (w[i] + cd[i - 1] * w[i - 1]) / diagonal[i]

    # u = C v + D w
    u = np.concatenate([v[:1], 2 * v[1:-1], 3 * v[-1:]])
    u[1:] -= cd * v[:-1] + sd * w[:-1]
    u[:-1] += -cd * v[1:] + sd * w[1:]
    return np.concatenate([thdot, u])


def arenstorf(t, y, mu=0.012277471):
    x1, x2, v1, v2 = y
    near = ((x1 + mu) ** 2 + x2**2) ** 1.5
    far = ((x1 - (1 - mu)) ** 2 + x2**2) ** 1.5
    a1 = x1 + 2 * v2 - (1 - mu) * (x1 + mu) / near - mu * (x1 - (1 - mu)) / far
    a2 = x2 - 2 * v1 - (1 - mu) * x2 / near - mu * x2 / far
    return np.array([v1, v2, a1, a2])


def lorenz(t, y, sigma=10.0, rho=28.0, beta=8 / 3):
    x, y, z = y
    return [sigma * (y - x), x * (rho - z) - y, x * y - beta * z]


def torque(t, w, I=(2.0, 2.0, 3.0)):  # noqa: E741
    return [
        (I[1] - I[2]) / I[0] * w[1] * w[2],
        (I[2] - I[0]) / I[1] * w[2] * w[0],
        ((I[0] - I[1]) * w[0] * w[1] + 0.25 * np.sin(t) ** 2) / I[2],
    ]


def eulr(t, y):
    I1, I2, I3 = 0.5, 2.0, 3.0
    push = 0.25 * sin(t) ** 2 if 3 * pi <= t <= 4 * pi else 0.0
    return [
        (I2 - I3) / I1 * y[1] * y[2],
        (I3 - I1) / I2 * y[2] * y[0],
        (I1 - I2) / I3 * y[0] * y[1] + push,
    ]


def bead(t, y, g, R):
    theta, omega = y
    return omega, np.sin(theta) / (1 - np.cos(theta)) * (g / R - omega**2) / 2


def chain(t, y, stiffness, amplitude, drive):
    n = len(y) // 2
    x, v = y[:n], y[n:]
    left = np.hstack([amplitude * np.sin(drive * t), x[:-1]])
    right = np.hstack([x[1:], 0.0])
    return np.hstack([v, stiffness * (left - 2 * x + right)])


def falling(t, y, g, e):
    return [y[1], -g]


def ground(t, y, g, e):
    return y[0]


ground.terminal = True
ground.direction = -1


G, BOUNCE = 9.81, 0.8


def flight(t, state, p):
    return state[1], -p[0]


def gap(t, state, p):
    return (state[0],)


def rebound(t, state, p):
    return 0.0, -p[1] * state[1]


def starts_in(t, state, p):
    return "flight"


impact = gnomon.Transition("impact", "flight", gap, -1, rebound, "flight")
ball = gnomon.Hybrid((gnomon.Mode("flight", flight),), starts_in, (impact,), settle=1e-9)


def torque_at(t, start, inertia):
    """Angular velocity of a symmetric body: the third component is an integral, the others turn by an angle."""
    t, w1, w2, w3 = (mpf(x) for x in (t, *start))
    across, along = mpf(inertia[0]), mpf(inertia[2])
    spin = w3 + (t / 2 - mp.sin(2 * t) / 4) / (4 * along)
    turned = w3 * t + (t**2 / 4 + (mp.cos(2 * t) - 1) / 8) / (4 * along)
    angle = (along - across) / across * turned
    return (
        w1 * mp.cos(angle) - w2 * mp.sin(angle),
        w1 * mp.sin(angle) + w2 * mp.cos(angle),
        spin,
    )


def bead_at(t, start, g, R):
    """Parameter of the cycloid x = R (theta - sin theta), y = R (1 + cos theta): the arc length is harmonic (Huygens)."""
    t, g, R = mpf(t), mpf(g), mpf(R)
    rate = mp.sqrt(g / R) / 2
    amplitude = mp.cos(mpf(start[0]) / 2)
    half = mp.acos(amplitude * mp.cos(rate * t))
    return 2 * half, 2 * amplitude * rate * mp.sin(rate * t) / mp.sin(half)


def chain_at(t, n, stiffness, amplitude, drive):
    """Masses of a chain from rest, one end driven, by its normal modes."""
    t, stiffness, amplitude, drive = mpf(t), mpf(stiffness), mpf(amplitude), mpf(drive)
    x, v = [mpf(0)] * n, [mpf(0)] * n
    for j in range(1, n + 1):
        rate = 2 * mp.sqrt(stiffness) * mp.sin(j * mp.pi / (2 * (n + 1)))
        shape = [mp.sin(i * j * mp.pi / (n + 1)) for i in range(1, n + 1)]
        force = stiffness * amplitude * 2 / (n + 1) * shape[0] / (rate**2 - drive**2)
        place = force * (mp.sin(drive * t) - drive / rate * mp.sin(rate * t))
        speed = force * drive * (mp.cos(drive * t) - mp.cos(rate * t))
        x = [a + place * b for a, b in zip(x, shape, strict=True)]
        v = [a + speed * b for a, b in zip(v, shape, strict=True)]
    return (*x, *v)


def ball_at(t, height, g, e):
    """Height and velocity of a ball that was let go, before its bounces accumulate."""
    left, g, e = mpf(t), mpf(g), mpf(e)
    fall = mp.sqrt(2 * mpf(height) / g)
    if left <= fall:
        return height - g * left**2 / 2, -g * left
    left -= fall
    up = e * g * fall
    while left > 2 * up / g:
        left -= 2 * up / g
        up *= e
    return up * left - g * left**2 / 2, up - g * left


def digits(numbers):
    return tuple(mpmath.nstr(x, 25) for x in numbers)


def ends(name):
    """The published and the derived digits of a system with many components."""
    with (Path(__file__).parent / "published_ends.csv").open() as table:
        rows = [row for row in csv.DictReader(table) if row["system"] == name]
    return tuple(row["published"] for row in rows), tuple(row["end"] for row in rows)


@dataclass(frozen=True)
class System:
    """Equations, a span, a start, and what others say of the end.

    `published`: the digits at the end as they are published; `end`: those of the problem as stated here, with its binary64
    numbers, by the way that `derived` names; it shares nothing with gnomon. `expects`: what a user would expect of an answer.
    `jumps`: the times at which a derivative of the input jumps.
    """

    f: Callable[..., Any] | gnomon.Hybrid
    t_span: tuple[float, float]
    start: tuple[float, ...]
    published: tuple[str, ...]
    end: tuple[str, ...]
    source: str
    derived: str
    expects: str
    args: tuple[float, ...] = ()
    stiff: bool = False
    jumps: tuple[float, ...] = ()

    def apart(self):
        """The distance from `published` to `end`, relative to each component, or to 1 where that is published as 0."""
        with mp.workdps(40):
            pairs = [(mpf(a), mpf(b)) for a, b in zip(self.published, self.end, strict=True)]
            return float(max(abs(a - b) / (abs(a) or 1) for a, b in pairs))


TEST_SET = "Test Set for IVP Solvers (Mazzia, Magherini, Iavernaro; University of Bari), subroutine solut of "
RADAU = ", by RADAU with a unit roundoff of 1.01e-19 at tolerances of 1.1e-18"
EXTRAPOLATED = "extrapolation of the midpoint rule in 45 digits, at tolerances of 1e-24 to 1e-34"
COLLOCATED = "Radau IIA of 7 and 9 stages in 45 digits"
CLOSED = "closed form"

LORENZ_START = (-13.763610682134200525014401054361653864, -19.578751942451795538838041446009558866, 27.0)
LORENZ_DIGITS = (
    "-13.763610682134200525014401054361653864100864854092",
    "-19.578751942451795538838041446009558866114240053428",
    "27",
)
LORENZ_SOURCE = (
    "Abad, Barrio, Dena, Computing periodic orbits with arbitrary precision, Phys. Rev. E 84, 016701 (2011), and the examples "
    "of TIDES: the orbit AB of Viswanath closes after 1.5586522107161747275678702092126960705284805489972"
)
SPIN, SPIN_INERTIA = (1.0, 0.0, 0.9), (2.0, 2.0, 3.0)
BEAD, WIRE = (1.0, 0.0), (9.81, 0.5)
LINKS, DRIVE = 10, (100.0, 0.05, 7.0)

with mp.workdps(40):
    TORQUE_END = digits(torque_at(20.0, SPIN, SPIN_INERTIA))
    BEAD_END = digits(bead_at(5.0, BEAD, *WIRE))
    CHAIN_END = digits(chain_at(4.0, LINKS, *DRIVE))
    BALL_END = digits(ball_at(2.0, 1.0, G, BOUNCE))

SYSTEMS = {
    "pleiades": System(
        pleiades, (0.0, 3.0), (3, 3, -1, -3, 2, -2, 2, 3, -3, 2, 0, 0, -4, 4, 0, 0, 0, 0, 0, 1.75, -1.5, 0, 0, 0, -1.25, 1, 0, 0),
        *ends("pleiades"), TEST_SET + "plei.f", EXTRAPOLATED,
        "not stiff; accelerations without velocities; close encounters near t = 1.23 and 1.68",
    ),
    "van_der_pol": System(
        van_der_pol, (0.0, 2.0), (2.0, 0.0), ("0.1706167732170483e1", "-0.8928097010247975"),
        ("1.70616773217046500846", "-0.8928097010248165484"), TEST_SET + "vdpol.f" + RADAU, COLLOCATED,
        "stiff: jumps that last 1e-6 between slow arcs; an explicit method does not end in time",
        args=(1e-6,), stiff=True,
    ),
    "hires": System(
        hires, (0.0, 321.8122), (1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0057), *ends("hires"),
        TEST_SET + "hires.f, by RADAU5 on a Cray C90 with a unit roundoff of 1.01e-19 at tolerances of 1.1e-18", COLLOCATED,
        "mildly stiff; the end lies in a fast change, where the rounding of the constants moves the digits by 2e-13",
        stiff=True,
    ),
    "rober": System(
        rober, (0.0, 1e11), (1.0, 0.0, 0.0), ("0.2083340149701255e-7", "0.8333360770334713e-13", "0.9999999791665050"),
        ("2.08334014970129414384e-8", "8.33336077033478322718e-14", "0.999999979166515169379"),
        TEST_SET + "rober.f" + RADAU, COLLOCATED,
        "stiff; components 14 decades apart, so an absolute tolerance decides; their sum stays 1, and the published sum is 1e-14 less",
        stiff=True,
    ),
    "e5": System(
        e5, (0.0, 1e13), (1.76e-3, 0.0, 0.0, 0.0),
        ("0.1152903278711829e-290", "0.8867655517642120e-22", "0.8854814626268838e-22", "0"),
        ("0", "8.86123352129108424168e-23", "8.86123352129108424168e-23", "0"), TEST_SET + "e5.f" + RADAU, COLLOCATED,
        "stiff; y2 = y3 + y4 always, which rounding loses, in binary64 wholly: three published digits of both are right. The first "
        "component is below 1.76e-3 exp(-7890), the fourth as small: 0 in binary64, so no published digit of the first is right",
        stiff=True,
    ),
    "beam": System(
        beam, (0.0, 5.0), (0.0,) * 80, *ends("beam"), TEST_SET + "beam.f" + RADAU,
        "extrapolation of the midpoint rule in 113 bits at a tolerance of 1e-20, with a step that ends at pi",
        "stiff and oscillating, up to 6400 rad / s; a branch on the time: the second derivative of the input jumps at pi; the "
        "published velocities are right to 6e-11",
        stiff=True, jumps=(pi,),
    ),
    "arenstorf": System(
        arenstorf, (0.0, 17.0652165601579625588917206249), (0.994, 0.0, 0.0, -2.00158510637908252240537862224),
        ("0.994", "0", "0", "-2.00158510637908252240537862224"),
        ("0.9939999999999088403381", "-3.030943022982418331012e-13", "-4.928536581055052732733e-11", "-2.001585106393270238498"),
        "Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), pages 129 and 130: the orbit closes", EXTRAPOLATED,
        "not stiff; a start near a mass; accelerations with velocities. Closed to 27 digits with the decimal numbers, to 5e-11 "
        "with the binary64 numbers next to them",
    ),
    "lorenz": System(
        lorenz, (0.0, 1.5586522107161747275678702092126961), LORENZ_START, LORENZ_DIGITS,
        ("-13.7636106821341941051", "-19.57875194245179608462", "26.99999999999997846452"), LORENZ_SOURCE, EXTRAPOLATED,
        "not stiff; chaotic, and a span of one revolution is too short to show it",
    ),
    "lorenz_ten_revolutions": System(
        lorenz, (0.0, 15.586522107161747275678702092126961), LORENZ_START, LORENZ_DIGITS,
        ("-13.76361068143611026399", "-19.57875194310045798133", "26.99999999680447627876"),
        LORENZ_SOURCE + "; ten revolutions are an example of desolve_tides_mpfr of SageMath", EXTRAPOLATED,
        "not stiff; chaotic: the rounding of the start grows to 1e-10",
    ),
    "torque": System(
        torque, (0.0, 20.0), SPIN, TORQUE_END, TORQUE_END, "not published; a symmetric body, whose spin is an integral", CLOSED,
        "not stiff; a rigid body; depends on time",
    ),
    "eulr": System(
        eulr, (0.0, 20.0), SPIN, ("0.987794560340436648385", "0.123140942018291232916", "1.26252516958480454431"),
        ("0.987794560340436648385", "0.123140942018291232916", "1.26252516958480454431"),
        "EULR of Hairer, Norsett, Wanner I, with the angular acceleration that collections of programs add (pfos, GOSS); no "
        "published end was found", EXTRAPOLATED,
        "not stiff; a branch on the time, at whose ends the second derivative of the torque jumps",
        jumps=(3 * pi, 4 * pi),
    ),
    "bead": System(
        bead, (0.0, 5.0), BEAD, BEAD_END, BEAD_END, "Huygens, Horologium oscillatorium (1673): a bead on a cycloid is harmonic", CLOSED,
        "not stiff; accelerations that depend on velocities, so no separable form",
        args=WIRE,
    ),
    "chain": System(
        chain, (0.0, 4.0), (0.0,) * (2 * LINKS), CHAIN_END, CHAIN_END, "not published; ten masses between springs, one end driven", CLOSED,
        "not stiff; linear accelerations without velocities; depends on time",
        args=DRIVE,
    ),
    "ball": System(
        ball, (0.0, 2.0), (1.0, 0.0), BALL_END, BALL_END, "not published; a ball that bounces, three times in the span", CLOSED,
        "modes and transitions; the bounces accumulate at t = 4.06",
        args=(G, BOUNCE),
    ),
}  # fmt: skip
"""The twelve, with Lorenz over ten revolutions, and a torque in closed form besides `eulr`."""
