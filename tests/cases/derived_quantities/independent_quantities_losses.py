"""Energy lost at events, and limits of sticking, computed independently: from states before and after events."""

from typing import Any

import mpmath
from gnomon.cases import get
from independent_quantities import HYBRID, ObservedMotion, close, label_of, oracle
from independent_quantities_events import last
from mpmath import cos, pi, sin, sqrt, tan


def kinetic(observed: ObservedMotion, state: Any) -> Any:
    """Kinetic energy of masses m1, m2, ... with velocities v1, ... or (vx1, vy1), ..., or of wheels with rates w1, ..."""
    total = mpmath.mpf(0)
    for name in observed.names:
        if name[0] == "v" or (name[0] == "w" and hasattr(observed.p, "I1")):
            kind = "I" if name[0] == "w" else "m"
            total += getattr(observed.p, f"{kind}{name[-1]}", 1) * getattr(state, name) ** 2 / 2
    return total


@oracle("energy_lost", "energy_released", "friction_work", "dissipated", "energy_loss", of=HYBRID)
def energy_lost(observed: ObservedMotion, value: Any) -> Any:
    label = label_of(observed, value)
    events = observed.events("stop") if label == "friction_work" else observed.events()
    if label == "energy_released":
        return kinetic(observed, events[0].after) - kinetic(observed, events[0].before)
    if observed.case.name == "ballistic_pendulum":
        before, after = events[0].before, events[0].after
        return (observed.p.m * before.u**2 - (observed.p.m + observed.p.M) * (observed.p.L * after.omega) ** 2) / 2
    energies = [observed.invariant("energy", 0, tuple(vars(s).values())) for s in (observed.at(0), events[-1].after)]
    if label == "friction_work":
        # without the work of gravity along the slope
        height = (events[0].after.s - observed.at(0).s) * sin(observed.p.alpha) * observed.p.g
        return -(observed.at(0).v ** 2) / 2 + height
    return energies[0] - energies[1]


@oracle(*(f"energy_{n}" for n in range(1, 6)), of=HYBRID)
def energy_of_the_spring(observed: ObservedMotion, value: Any) -> Any:
    n = int(label_of(observed, value)[-1])
    return observed.p.k * observed.events()[n - 1].after.x ** 2 / 2


@oracle("belt_energy_loss", of=HYBRID)
def slip_of_the_belt(observed: ObservedMotion, value: Any) -> Any:
    """The work of the motor's torque M until the belt grips, less the energy that the wheels have gained."""
    end = last(observed, "grips")
    # w1 is linear in time: its mean times the time is the angle by which the motor turns
    work = observed.p.M * (observed.at(0).w1 + end.after.w1) / 2 * end.time
    return work + kinetic(observed, observed.at(0)) - kinetic(observed, end.after)


@oracle("work", of=HYBRID)
def work_of_the_impulse(observed: ObservedMotion, value: Any) -> Any:
    event = last(observed, "blow")
    return observed.p.m * observed.p.l**2 / 6 * (event.after.omega**2 - event.before.omega**2)


@oracle("impulse", of=HYBRID)
def momentum_gained(observed: ObservedMotion, value: Any) -> Any:
    return observed.p.m * (observed.at(observed.p.off).v - observed.at(0).v)


@oracle("time_varying_force.drift", of=HYBRID)
def mean_velocity(observed: ObservedMotion, value: Any) -> Any:
    turn = 2 * pi / observed.p.w
    return (observed.at(turn).x - observed.at(0).x) / turn


@oracle("friction_angle", of=HYBRID)
def angle_of_friction(observed: ObservedMotion, value: Any) -> bool:
    return close(tan(value), observed.p.mu_s)


@oracle("edge_tension", "largest_edge_tension", of=HYBRID)
def holds_the_hanging_part(observed: ObservedMotion, value: Any) -> Any:
    """The largest value of s (g - s'')."""

    def tension(t: Any) -> Any:
        s = observed.at(t)
        return s.s * (observed.p.g - observed.rate("v", t))

    if value is observed.found["edge_tension"]:
        return tension(0)
    end = observed.found["leaving_time"]
    half = mpmath.findroot(
        lambda t: observed.at(t).s - observed.p.L / 2, (0, end), solver="anderson", tol=1e-35, verify=False
    )
    assert all(tension(half) > tension(half + sign * end / 50) for sign in (1, -1))
    return tension(half)


@oracle("tension_start", of=HYBRID)
def pull_of_the_string(observed: ObservedMotion, value: Any) -> Any:
    s = observed.at(0)
    return observed.p.R * s.omega**2 + observed.p.g * cos(s.theta)


@oracle("holding_deceleration", "holding_lift", of=HYBRID)
def limit_of_sticking(observed: ObservedMotion, value: Any) -> bool:
    """Just below the limit the body sticks, just above it does not."""
    label = "a" if value is observed.found.get("holding_deceleration") else "P"
    moved = []
    for share in (1 - mpmath.mpf("1e-6"), 1 + mpmath.mpf("1e-6")):
        case = get(observed.case.name, **{**observed.case.parameters, label: float(value * share)})
        moved.append(bool(case.events(15)) or case.exact(case.span, 15)[0] != case.initial_state[0])
    return moved in ([False, True], [True, False])


@oracle("rolling_acceleration", of=HYBRID)
def once_it_rolls(observed: ObservedMotion, value: Any) -> Any:
    return observed.rate("v", last(observed, "grips").time * mpmath.mpf("1.5"))


@oracle("friction_to_roll", of=HYBRID)
def of_the_rolling_body(observed: ObservedMotion, value: Any) -> Any:
    """Friction over the normal force: gravity along the slope less the acceleration."""
    p = observed.p
    return (p.g * sin(p.alpha) - observed.found["rolling_acceleration"]) / (p.g * cos(p.alpha))


@oracle("relative_push", of=HYBRID)
def relative_acceleration_of_the_table(observed: ObservedMotion, value: Any) -> Any:
    return observed.p.A * observed.p.w**2 / (observed.p.g + getattr(observed.p, "b", 0))


@oracle("terminal_speed", of=HYBRID)
def drag_holds_the_weight(observed: ObservedMotion, value: Any) -> Any:
    return sqrt(observed.p.g / observed.p.k)


@oracle("best_m2", of=HYBRID)
def makes_the_last_ball_fastest(observed: ObservedMotion, value: Any) -> bool:
    # with a middle mass 1 % larger or smaller the last ball is slower
    speeds = [
        ObservedMotion(get(observed.case.name, **{**observed.case.parameters, "m2": float(value * share)})).found[
            "last_speed"
        ]
        for share in (mpmath.mpf("0.99"), mpmath.mpf(1), mpmath.mpf("1.01"))
    ]
    return bool(speeds[1] > max(speeds[0], speeds[2]))
