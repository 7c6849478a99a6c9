"""Equations of Andrews' squeezing mechanism: seven angles, the joints of the knee with three chains.

Angles and parameters have the names of the Test Set for IVP Solvers. The state is (beta, theta, gamma, phi, delta, omega,
epsilon) and their rates. The knee P is where coupler and chains meet.
"""

from gnomon.cases.declare import Any, Values, cos, sin, sqrt


def squeezer_rates(t: Any, state: Values, parameters: Values) -> Values:
    """Index 1, the multipliers eliminated by the joints' structure.

    The joints give each acceleration as T beta'' + c: the lever's two equations theta'' and gamma'', hence the knee's
    acceleration A beta'' + B, and from this each dyad's two angles. Then T . (M (T beta'' + c) - forces) = 0.
    """
    beta, theta, gamma, phi, delta, omega, epsilon, vb, vt, vg, vp, vd, vo, ve = state
    (m1, m2, m3, m4, m5, m6, m7, i1, i2, i3, i4, i5, i6, i7, d, da, e, ea, rr, ra, ss, sa, sb, sc, sd, ta, tb, u, ua, ub,
     zf, zt, fa, ax, ay, c0, l0, mom) = parameters  # fmt: skip
    sbe, cbe, sth, cth = sin(beta), cos(beta), sin(theta), cos(theta)
    sg, cg, sph, cph, som, com = sin(gamma), cos(gamma), sin(phi), cos(phi), sin(omega), cos(omega)
    sbt, cbt = sbe * cth + cbe * sth, cbe * cth - sbe * sth
    s2, c2, s3, c3 = sin(phi + delta), cos(phi + delta), sin(omega + epsilon), cos(omega + epsilon)
    # the knee: (x1, -y1) beta'' + (x0, -y0), with theta'' = h beta'' + k from the lever
    px, py, qx, qy = d * sbt, d * cbt, -rr * sbe, -rr * cbe
    both, square = (vb + vt) * (vb + vt), vb * vb
    kx, ky = py * both + qy * square, -(px * both + qx * square)
    across = 1 / (px * sg + py * cg)
    turned = rr * (sbe * sg + cbe * cg) * across
    h = turned - 1
    k = (kx * sg + ky * cg + ss * (vg * vg)) * -across
    x1, y1, x0, y0 = px * turned + qx, py * turned + qy, px * k + kx, py * k + ky
    gx, gy = cg / ss, sg / -ss
    tg, kg = x1 * gx + y1 * gy, x0 * gx + y0 * gy
    # the dyad of phi and delta
    vd2, vs2, lower = vd * vd, (vp + vd) * (vp + vd), (-1 / zt) / cph
    td = (x1 * s2 + y1 * c2) * lower
    kd = (x0 * s2 + y0 * c2 + e * vs2 + zt * (sph * vd2)) * lower
    ex, ey, bent = c2 / e, s2 / -e, (-zt / e) * sph - 1
    tp = x1 * ex + y1 * ey + td * bent
    kp = x0 * ex + y0 * ey + kd * bent + (zt / e) * (cph * vd2)
    # the dyad of omega and epsilon
    ve2, vs3, upper = ve * ve, (vo + ve) * (vo + ve), (1 / u) / com
    zx, zy, below = s3 / -zf, c3 / -zf, (u / zf) * som - 1
    te = (y1 * zx - x1 * zy) * (zf * upper)
    ke = (y0 * zx - x0 * zy + vs3 - (u / zf) * (som * ve2)) * (zf * upper)
    to = x1 * zx + y1 * zy + te * below
    ko = x0 * zx + y0 * zy + ke * below + (-u / zf) * (com * ve2)
    # masses, and the inertial less the given forces at beta'' = 0
    arm2, arm4, arm6 = m2 * da * rr, m4 * zt * (e - ea), m6 * u * (zf - fa)
    m22, m44, m66 = m2 * da * da + i2, m4 * (e - ea) * (e - ea) + i4, m6 * (zf - fa) * (zf - fa) + i6
    m21, m54, m76 = -arm2 * cth + m22, arm4 * sph + m44, -arm6 * som + m66
    m11, m33 = 2 * m21 + (m1 * ra * ra + m2 * rr * rr + i1 - m22), m3 * (sa * sa + sb * sb) + i3
    m55 = 2 * m54 + (m4 * zt * zt + m5 * (ta * ta + tb * tb) + i5 - m44)
    m77 = 2 * m76 + (m6 * u * u + m7 * (ua * ua + ub * ub) + i7 - m66)
    p, q = ax * sd - ay * sc, ax * sc + ay * sd
    length = sqrt((2 * p) * cg + (2 * q) * sg + (sd * sd + sc * sc + ax * ax + ay * ay))
    n3 = ((c0 * l0) / length - c0) * (p * sg + -q * cg) + m33 * kg
    w2, w4, w6 = arm2 * sth, -arm4 * cph, arm6 * com
    n1, n2 = w2 * (both - square) + m21 * k - mom, -(w2 * square) + m22 * k
    n4, n5 = m44 * kp + m54 * kd + w4 * vd2, m54 * kp + m55 * kd + w4 * (vd2 - vs2)
    n6, n7 = m66 * ko + m76 * ke + w6 * ve2, m76 * ko + m77 * ke + w6 * (ve2 - vs3)
    load = n1 + h * n2 + tg * n3 + tp * n4 + td * n5 + to * n6 + te * n7
    inertia = (
        m11 + h * (2 * m21 + m22 * h) + m33 * (tg * tg) + tp * (m44 * tp + 2 * (m54 * td)) + m55 * (td * td)
        + to * (m66 * to + 2 * (m76 * te)) + m77 * (te * te)
    )  # fmt: skip
    a = load * (-1 / inertia)
    return (
        vb, vt, vg, vp, vd, vo, ve, a, h * a + k, tg * a + kg, tp * a + kp, td * a + kd, to * a + ko, te * a + ke,
    )  # fmt: skip


def squeezer_masses(t: Any, place: Values, parameters: Values) -> Values:
    _beta, theta, _gamma, phi, _delta, omega, _epsilon = place
    (m1, m2, m3, m4, m5, m6, m7, i1, i2, i3, i4, i5, i6, i7, _d, da, e, ea, rr, ra, _ss, sa, sb, _sc, _sd, ta, tb, u, ua, ub,
     zf, zt, fa, _ax, _ay, _c0, _l0, _mom) = parameters  # fmt: skip
    lower, upper = e - ea, zf - fa
    m22, m44, m66 = m2 * da * da + i2, m4 * lower * lower + i4, m6 * upper * upper + i6
    m21, m54, m76 = m22 - m2 * da * rr * cos(theta), m44 + m4 * zt * lower * sin(phi), m66 - m6 * u * upper * sin(omega)
    m11 = m1 * ra * ra + m2 * rr * rr + i1 - m22 + 2 * m21
    m33 = m3 * (sa * sa + sb * sb) + i3
    m55 = m4 * zt * zt + m5 * (ta * ta + tb * tb) + i5 - m44 + 2 * m54
    m77 = m6 * u * u + m7 * (ua * ua + ub * ub) + i7 - m66 + 2 * m76
    return (
        m11, m21, 0, 0, 0, 0, 0,
        m21, m22, 0, 0, 0, 0, 0,
        0, 0, m33, 0, 0, 0, 0,
        0, 0, 0, m44, m54, 0, 0,
        0, 0, 0, m54, m55, 0, 0,
        0, 0, 0, 0, 0, m66, m76,
        0, 0, 0, 0, 0, m76, m77,
    )  # fmt: skip


def spring_of(gamma: Any, parameters: Values) -> tuple[Any, Any]:
    """The spring's length, and its derivative by gamma times the length."""
    sc, sd, ax, ay = parameters[23], parameters[24], parameters[33], parameters[34]
    x, y = sd * cos(gamma) + sc * sin(gamma), sd * sin(gamma) - sc * cos(gamma)
    return sqrt((x + ax) * (x + ax) + (y + ay) * (y + ay)), ay * x - ax * y


def squeezer_forces(t: Any, place: Values, parameters: Values) -> Values:
    """The torque of the drive on beta and that of the spring on gamma."""
    length, turn = spring_of(place[2], parameters)
    c0, l0, mom = parameters[35:]
    return mom, 0, -c0 * (length - l0) / length * turn, 0, 0, 0, 0


def accelerations_of_the_joints(t: Any, state: Values, parameters: Values) -> Values:
    """The terms of the rates in Lagrange's equations: centrifugal and Coriolis forces."""
    _beta, theta, _gamma, phi, _delta, omega, _epsilon, vb, vt, _vg, vp, vd, vo, ve = state
    (_m1, m2, _m3, m4, _m5, m6, _m7, _i1, _i2, _i3, _i4, _i5, _i6, _i7, _d, da, e, ea, rr, _ra, _ss, _sa, _sb, _sc, _sd, _ta,
     _tb, u, _ua, _ub, zf, zt, fa, _ax, _ay, _c0, _l0, _mom) = parameters  # fmt: skip
    crank, lower, upper = m2 * da * rr * sin(theta), m4 * zt * (e - ea) * cos(phi), m6 * u * (zf - fa) * cos(omega)
    return (
        -crank * vt * (vt + 2 * vb), crank * vb * vb, 0,
        lower * vd * vd, -lower * vp * (vp + 2 * vd), -upper * ve * ve, upper * vo * (vo + 2 * ve),
    )  # fmt: skip


def closures(t: Any, place: Values, parameters: Values) -> Values:
    """The knee along each of the three chains, up to the place of their pivots: constant on the motion."""
    beta, theta, gamma, phi, delta, omega, epsilon = place
    d, e, rr, ss, u, zf, zt = (
        parameters[14],
        parameters[16],
        parameters[18],
        parameters[20],
        parameters[27],
        parameters[30],
        parameters[31],
    )
    x, y = rr * cos(beta) - d * cos(beta + theta), rr * sin(beta) - d * sin(beta + theta)
    return (
        x - ss * sin(gamma),
        y + ss * cos(gamma),
        x - e * sin(phi + delta) - zt * cos(delta),
        y + e * cos(phi + delta) - zt * sin(delta),
        x - zf * cos(omega + epsilon) - u * sin(epsilon),
        y - zf * sin(omega + epsilon) + u * cos(epsilon),
    )


def normals_of_the_joints(t: Any, place: Values, parameters: Values) -> Values:
    """The gradients of the closures, row by row."""
    beta, theta, gamma, phi, delta, omega, epsilon = place
    d, e, rr, ss, u, zf, zt = (
        parameters[14],
        parameters[16],
        parameters[18],
        parameters[20],
        parameters[27],
        parameters[30],
        parameters[31],
    )
    x2, y2 = d * sin(beta + theta), -d * cos(beta + theta)
    x1, y1 = x2 - rr * sin(beta), y2 + rr * cos(beta)
    x4, y4 = -e * cos(phi + delta), -e * sin(phi + delta)
    x6, y6 = zf * sin(omega + epsilon), -zf * cos(omega + epsilon)
    return (
        x1, x2, -ss * cos(gamma), 0, 0, 0, 0,
        y1, y2, -ss * sin(gamma), 0, 0, 0, 0,
        x1, x2, 0, x4, x4 + zt * sin(delta), 0, 0,
        y1, y2, 0, y4, y4 - zt * cos(delta), 0, 0,
        x1, x2, 0, 0, 0, x6, x6 - u * cos(epsilon),
        y1, y2, 0, 0, 0, y6, y6 - u * sin(epsilon),
    )  # fmt: skip


def squeezer_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Kinetic energy, the spring's, and -mom beta of the constant torque (J)."""
    masses, rates = squeezer_masses(t, state[:7], parameters), state[7:]
    kinetic = sum([masses[8 * i] * rates[i] * rates[i] / 2 for i in range(7)])
    mixed = sum([masses[8 * i + 1] * rates[i] * rates[i + 1] for i in (0, 3, 5)])
    length, _ = spring_of(state[2], parameters)
    c0, l0, mom = parameters[35:]
    return (kinetic + mixed + c0 * (length - l0) * (length - l0) / 2 - mom * state[0],)
