"""Forces, computed independently: from second differences of positions."""

from typing import Any

import mpmath
from independent_quantities import ObservedMotion, angle_at_rest, oracle, period_of, swing
from mpmath import cos, hypot, pi, sin


@oracle("tension_lowest_point", "tension_highest_point")
def pull_of_the_rod(observed: ObservedMotion, value: Any) -> Any:
    """L omega^2 + g cos(theta), its largest and least value over a period or a whole turn."""

    def pull(s: Any) -> Any:
        return observed.p.L * s.omega**2 + observed.p.g * cos(s.theta)

    ends = observed.largest(pull, period_of(observed)), observed.least(pull, period_of(observed))
    return ends[value is observed.found["tension_highest_point"]]


@oracle("multiplier")
def pull_over_the_length(observed: ObservedMotion, value: Any) -> Any:
    s = observed.at(0)
    return -(observed.rate("vx") * s.x + (observed.rate("vy") + observed.p.g) * s.y) / (s.x**2 + s.y**2)


@oracle("normal_force_bottom", "normal_force_start")
def normal_force(observed: ObservedMotion, value: Any) -> Any:
    """g cos(slope) + v^2 curvature."""
    if observed.case.name != "cycloidal_pendulum":
        _, t = min((abs(getattr(observed.at(t), observed.names[0])), t) for t in zero_crossings(observed))
        curvature = -observed.jacobian([mpmath.mpf(0)] * 2)[1, 0] / observed.p.g
        return observed.p.g + observed.at(t).v ** 2 * curvature

    def place(t: Any) -> Any:
        phi, a = observed.at(t).phi, observed.p.a
        return mpmath.mpc(a * (phi + sin(phi)), a * (1 - cos(phi)))

    t = zero_crossings(observed)[0] if value is observed.found["normal_force_bottom"] else mpmath.mpf(0)
    along = observed.slope(place, t + mpmath.mpf("1e-9"))
    h = mpmath.mpf("1e-9")
    force = (place(t + h) - 2 * place(t) + place(t - h)) / h**2 + 1j * observed.p.g
    found = (force * mpmath.conj(along * 1j / abs(along))).real
    # the speed along the path is irrelevant; second differences over 1e-9 are accurate to about 16 digits
    return bool(abs(abs(found) - value) < 1e-7)


def zero_crossings(observed: ObservedMotion) -> list[Any]:
    x = observed.names[0]
    quarter = observed.found["period"] / 2
    return [
        mpmath.findroot(lambda t: getattr(observed.at(t), x), (0, quarter), solver="anderson", tol=1e-35, verify=False)
    ]


@oracle("center_of_percussion")
def length_of_the_equivalent_pendulum(observed: ObservedMotion, value: Any) -> Any:
    return observed.p.g / swing(observed, angle_at_rest(observed, 0)) ** 2


@oracle("reaction_along", "reaction_across")
def reaction_of_the_axis(observed: ObservedMotion, value: Any) -> Any:
    """The acceleration of the centre of mass less gravity."""
    s, p = observed.at(0), observed.p
    if value is observed.found["reaction_along"]:
        return p.m * (p.g * cos(s.theta) + p.l * s.omega**2)
    return p.m * (p.g * sin(s.theta) + p.l * observed.rate("omega"))


@oracle("drive_torque")
def growth_of_the_momentum_about_the_shaft(observed: ObservedMotion, value: Any) -> Any:
    def momentum(t: Any) -> Any:
        theta, p = observed.at(t).theta, observed.p
        if hasattr(p, "R"):
            return (p.R * sin(theta)) ** 2 * p.Om
        return p.Om * (p.I_b * sin(theta) ** 2 + p.I_c * cos(theta) ** 2)

    return observed.slope(momentum)


@oracle("bearing_torque")
def growth_of_the_momentum_across_the_shaft(observed: ObservedMotion, value: Any) -> Any:
    """In rotating axes: the rate of the transverse momentum, plus the rotation of I_a theta' with the shaft."""

    def across(t: Any) -> Any:
        theta = observed.at(t).theta
        return observed.p.Om * (observed.p.I_b - observed.p.I_c) * sin(theta) * cos(theta)

    return observed.slope(across) + observed.p.Om * observed.p.I_a * observed.at(0).omega


@oracle("wall_force")
def across_the_slot(observed: ObservedMotion, value: Any) -> Any:
    """The mass times the transverse acceleration in the rotating slot."""
    return (
        observed.p.m
        * mpmath.im(
            mpmath.diff(
                lambda t: observed.at(t).r * mpmath.expj(observed.p.Om * t),
                mpmath.mpf("1e-20"),
                2,
                h=mpmath.mpf("1e-9"),
            )
        )
        if observed.p.mu == 0
        else 2 * observed.p.m * observed.p.Om * observed.at(0).v
    )


@oracle("largest_force")
def force_on_the_accelerated_cart(observed: ObservedMotion, value: Any) -> Any:
    h = 2 * pi / observed.p.w / 12
    return observed.p.M * max(abs(observed.rate("v", k * h)) for k in range(12))


@oracle("cart_way")
def distance_of_the_cart(observed: ObservedMotion, value: Any) -> Any:
    half = pi / observed.p.w
    return abs(observed.at(half).x - observed.at(0).x - half * observed.found["centre_speed"])


@oracle("centre_speed")
def mean_velocity(observed: ObservedMotion, value: Any) -> Any:
    turn = 2 * pi / observed.p.w
    return (observed.at(turn).x - observed.at(0).x) / turn


@oracle("dumbbell_free_flight.tension")
def of_the_rod_between(observed: ObservedMotion, value: Any) -> Any:
    return observed.p.m1 * hypot(observed.rate("vx1"), observed.rate("vy1") + observed.p.g)


@oracle("acceleration", "wedge_acceleration", "relative_acceleration")
def acceleration(observed: ObservedMotion, value: Any) -> Any:
    if observed.case.name == "wedge_block_energy_momentum":
        return observed.rate("V" if value is observed.found["wedge_acceleration"] else "v")
    return observed.rate("v")


@oracle("tension_1", "tension_2")
def tension_of_the_string(observed: ObservedMotion, value: Any) -> Any:
    """Each weight less its mass times acceleration."""
    a = observed.rate("v")
    return (
        observed.p.m1 * (observed.p.g - a)
        if value is observed.found["tension_1"]
        else observed.p.m2 * (observed.p.g + a)
    )


@oracle("wedge_block_energy_momentum.normal_force")
def pushes_the_wedge(observed: ObservedMotion, value: Any) -> Any:
    return observed.p.M * abs(observed.rate("V")) / sin(observed.p.alpha)


@oracle("string_force")
def of_the_unwinding_string(observed: ObservedMotion, value: Any) -> Any:
    return observed.p.m * (observed.p.g - observed.rate("v"))


@oracle("tension_start", "tension_end")
def pull_inward(observed: ObservedMotion, value: Any) -> Any:
    t = 0 if value is observed.found["tension_start"] else observed.span
    return observed.p.m * (observed.p.r0 - observed.p.c * t) * observed.at(t).omega ** 2


@oracle("rate_end")
def at_the_end(observed: ObservedMotion, value: Any) -> Any:
    return observed.at(observed.span).omega


@oracle("shortened_string.work", "work")
def kinetic_energy_gained(observed: ObservedMotion, value: Any) -> Any:
    speeds = [(observed.p.r0 - observed.p.c * t) * observed.at(t).omega for t in (0, observed.span)]
    return observed.p.m * (speeds[1] ** 2 - speeds[0] ** 2) / 2
