"""Energy lost at events, and the limits of what holds."""

from __future__ import annotations

from typing import Any

import mpmath
from gnomon.cases import get
from look_events import last
from mpmath import cos, pi, sin, sqrt, tan
from outside import HYBRID, Outside, close, label_of, oracle


def kinetic(look: Outside, state: Any) -> Any:
    """Of masses m1, m2, ... with velocities v1, ... or (vx1, vy1), ...; of wheels with rates w1, ..."""
    total = mpmath.mpf(0)
    for name in look.names:
        if name[0] == "v" or (name[0] == "w" and hasattr(look.p, "I1")):
            kind = "I" if name[0] == "w" else "m"
            total += getattr(look.p, f"{kind}{name[-1]}", 1) * getattr(state, name) ** 2 / 2
    return total


@oracle("energy_lost", "energy_released", "friction_work", "dissipated", "energy_loss", of=HYBRID)
def energy_gone(look: Outside, value: Any) -> Any:
    label = label_of(look, value)
    events = look.events("stop") if label == "friction_work" else look.events()
    if label == "energy_released":
        return kinetic(look, events[0].after) - kinetic(look, events[0].before)
    if look.case.name == "ballistic_pendulum":
        before, after = events[0].before, events[0].after
        return (look.p.m * before.u**2 - (look.p.m + look.p.M) * (look.p.L * after.omega) ** 2) / 2
    energies = [look.invariant("energy", 0, tuple(vars(s).values())) for s in (look.at(0), events[-1].after)]
    if label == "friction_work":
        # without the slope's own work
        height = (events[0].after.s - look.at(0).s) * sin(look.p.alpha) * look.p.g
        return -(look.at(0).v ** 2) / 2 + height
    return energies[0] - energies[1]


@oracle(*(f"energy_{n}" for n in range(1, 6)), of=HYBRID)
def held_by_the_spring(look: Outside, value: Any) -> Any:
    n = int(label_of(look, value)[-1])
    return look.p.k * look.events()[n - 1].after.x ** 2 / 2


@oracle("belt_energy_loss", of=HYBRID)
def slip_of_the_belt(look: Outside, value: Any) -> Any:
    """The work of the motor's moment M until the grip, less what the wheels have gained."""
    end = last(look, "grips")
    # w1 changes evenly: its mean times the time is the angle by which the motor turns
    work = look.p.M * (look.at(0).w1 + end.after.w1) / 2 * end.time
    return work + kinetic(look, look.at(0)) - kinetic(look, end.after)


@oracle("work", of=HYBRID)
def of_the_blow(look: Outside, value: Any) -> Any:
    event = last(look, "blow")
    return look.p.m * look.p.l**2 / 6 * (event.after.omega**2 - event.before.omega**2)


@oracle("impulse", of=HYBRID)
def momentum_gained(look: Outside, value: Any) -> Any:
    return look.p.m * (look.at(look.p.off).v - look.at(0).v)


@oracle("time_varying_force.drift", of=HYBRID)
def mean_velocity(look: Outside, value: Any) -> Any:
    turn = 2 * pi / look.p.w
    return (look.at(turn).x - look.at(0).x) / turn


@oracle("friction_angle", of=HYBRID)
def repose(look: Outside, value: Any) -> bool:
    return close(tan(value), look.p.mu_s)


@oracle("edge_tension", "largest_edge_tension", of=HYBRID)
def holds_the_hanging_part(look: Outside, value: Any) -> Any:
    """s (g - s''), the largest on the way."""

    def tension(t: Any) -> Any:
        s = look.at(t)
        return s.s * (look.p.g - look.rate("v", t))

    if value is look.found["edge_tension"]:
        return tension(0)
    end = look.found["leaving_time"]
    half = mpmath.findroot(lambda t: look.at(t).s - look.p.L / 2, (0, end), solver="anderson", tol=1e-35, verify=False)
    assert all(tension(half) > tension(half + sign * end / 50) for sign in (1, -1))
    return tension(half)


@oracle("tension_start", of=HYBRID)
def pull_of_the_string(look: Outside, value: Any) -> Any:
    s = look.at(0)
    return look.p.R * s.omega**2 + look.p.g * cos(s.theta)


@oracle("holding_deceleration", "holding_lift", of=HYBRID)
def threshold(look: Outside, value: Any) -> bool:
    """Just below it holds, just above it does not."""
    label = "a" if value is look.found.get("holding_deceleration") else "P"
    moved = []
    for share in (1 - mpmath.mpf("1e-6"), 1 + mpmath.mpf("1e-6")):
        case = get(look.case.name, **{**look.case.parameters, label: float(value * share)})
        moved.append(bool(case.events(15)) or case.exact(case.span, 15)[0] != case.initial_state[0])
    return moved in ([False, True], [True, False])


@oracle("rolling_acceleration", of=HYBRID)
def once_it_rolls(look: Outside, value: Any) -> Any:
    return look.rate("v", last(look, "grips").time * mpmath.mpf("1.5"))


@oracle("friction_to_roll", of=HYBRID)
def of_the_rolling_body(look: Outside, value: Any) -> Any:
    """Friction is what is missing of the weight's pull, over the normal force."""
    p = look.p
    return (p.g * sin(p.alpha) - look.found["rolling_acceleration"]) / (p.g * cos(p.alpha))


@oracle("relative_push", of=HYBRID)
def of_the_table(look: Outside, value: Any) -> Any:
    return look.p.A * look.p.w**2 / (look.p.g + look.p.b)


@oracle("terminal_speed", of=HYBRID)
def drag_holds_the_weight(look: Outside, value: Any) -> Any:
    return sqrt(look.p.g / look.p.k)


@oracle("best_m2", of=HYBRID)
def makes_the_last_ball_fastest(look: Outside, value: Any) -> bool:
    # heavier or lighter by 1 % it is slower
    speeds = [
        Outside(get(look.case.name, **{**look.case.parameters, "m2": float(value * share)})).found["last_speed"]
        for share in (mpmath.mpf("0.99"), mpmath.mpf(1), mpmath.mpf("1.01"))
    ]
    return bool(speeds[1] > max(speeds[0], speeds[2]))
