"""Aiming at a target that falls (Beatty, Dynamics, 6.4.2)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gnomon.cases.core.check import Check, Setting
from gnomon.cases.core.numbers import Domain, Parameter, Rule, positive
from gnomon.reference.numerics.balls import ball


class FallingTarget(Check):
    """Percy Panther's law: who aims at a target that is let go as the shot is fired hits it, at any speed."""

    name = "falling_target"
    title = "Shot aimed at a target that falls as it is fired: it hits"
    section = "6.4.2"
    conventions = (
        "Shot from the origin at speed v, aimed at a target at (X, Y), which falls from rest at that moment. time: d/v, d "
        "the distance; height: of the hit, Y - g time^2/2, below the ground where the shot is too slow; miss: the distance "
        "of shot and target then, zero. slowest: the speed that hits at the height of the muzzle. envelope: how high any "
        "shot of this speed gets at X."
    )
    parameter_list = (
        Parameter("g", "m/s^2", "9.81", "acceleration of gravity"),
        Parameter("v", "m/s", 40, "speed of the shot"),
        Parameter("X", "m", 30, "distance of the target"),
        Parameter("Y", "m", 20, "height of the target"),
    )
    domain = Domain(
        {name: positive() for name in ("g", "v", "Y")},
        (Rule("X is not zero (the shot is not straight up)", lambda p: p["X"] != 0),),
    )
    variants = (
        Setting("fast", "v = 1e9: the target has fallen 6e-15 m", {"v": 10**9}),
        Setting("slow", "v = 1e-3: both far below the ground", {"v": "1e-3"}),
        Setting("far", "the target 1e8 away and 1 up", {"X": 10**8, "Y": 1}),
        Setting(
            "just_slowest", "hits 3e-13 above the muzzle's height", {"g": 2, "v": "2.5000000000001", "X": 3, "Y": 4}
        ),
    )
    guard = 60

    def formulas(self, p: Any) -> Mapping[str, Any]:
        distance = (p.X * p.X + p.Y * p.Y).sqrt()
        time = distance / p.v
        fall = p.g * (p.X * p.X + p.Y * p.Y) / (2 * p.v * p.v)
        return {
            "time": time,
            "height": p.Y - fall,
            "miss": ball(0),
            "slowest": (p.g * (p.X * p.X + p.Y * p.Y) / (2 * p.Y)).sqrt(),
            "envelope": p.v * p.v / (2 * p.g) - p.g * p.X * p.X / (2 * p.v * p.v),
        }

    def otherwise(self, mp: Any, p: Any) -> Mapping[str, Any]:
        """The parabola by its angle and the target's fall, when both have the same x; the envelope by its best angle."""
        aim = mp.atan2(p.Y, p.X)
        across, up = p.v * mp.cos(aim), p.v * mp.sin(aim)
        time = p.X / across
        shot, target = up * time - p.g * time**2 / 2, p.Y - p.g * time**2 / 2
        # the hit is at the muzzle's height where the shot's own fall back takes as long as the target's
        slowest = mp.sqrt(p.g * p.Y / 2) / mp.sin(aim)
        # y = X tan - g X^2 (1 + tan^2)/(2 v^2) is highest where its slope in tan vanishes
        best = mp.findroot(lambda k: p.X - p.g * p.X**2 * k / p.v**2, p.v**2 / (p.g * p.X) + 1)
        return {
            "time": time,
            "height": target,
            "miss": shot - target,
            "slowest": slowest,
            "envelope": p.X * best - p.g * p.X**2 * (1 + best**2) / (2 * p.v**2),
        }
