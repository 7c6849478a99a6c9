"""Aiming at a target that falls (Beatty, Dynamics, 6.4.2)."""

from gnomon.cases.declare import *
from gnomon.reference.numerics.balls import ball


class FallingTarget(Check):
    """Percy Panther's law: a shot aimed at a target that is released at the same moment hits it, at any speed."""

    name = "falling_target"
    title = "Shot aimed at a target that falls as it is fired: it hits"
    section = "6.4.2"
    conventions = (
        "Shot from the origin at speed v, aimed at a target at (X, Y), which falls from rest from that moment. time: d/v, d "
        "the distance; height: of the hit, Y - g time^2/2, below the ground if the shot is too slow; miss: the distance "
        "of shot and target at that time, which is zero. slowest: the speed with which the hit is at the height of the "
        "muzzle. envelope: the greatest height that a shot of this speed reaches at X."
    )
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    v = Parameter("m/s", 40, "speed of the shot", positive())
    X = Parameter("m", 30, "distance of the target")
    Y = Parameter("m", 20, "height of the target", positive())
    rules = (Rule("X is not zero (the shot is not straight up)", lambda p: p["X"] != 0),)
    variants = (
        Variant("fast", "v = 1e9 m/s: the target has fallen by 6e-15 m", {"v": 10**9}),
        Variant("slow", "v = 1e-3 m/s: the hit is far below the ground", {"v": "1e-3"}),
        Variant("far", "the target 1e8 m away and 1 m up", {"X": 10**8, "Y": 1}),
        Variant(
            "just_slowest", "hits 3e-13 m above the muzzle's height", {"g": 2, "v": "2.5000000000001", "X": 3, "Y": 4}
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
        """The shot's parabola and the target's fall when both have the same x; the envelope from the best angle."""
        aim = mp.atan2(p.Y, p.X)
        across, up = p.v * mp.cos(aim), p.v * mp.sin(aim)
        time = p.X / across
        shot, target = up * time - p.g * time**2 / 2, p.Y - p.g * time**2 / 2
        # the hit is at the muzzle's height if the shot's return takes as long as the target's fall
        slowest = mp.sqrt(p.g * p.Y / 2) / mp.sin(aim)
        # y = X tan - g X^2 (1 + tan^2)/(2 v^2) is largest where its derivative by tan vanishes
        best = mp.findroot(lambda k: p.X - p.g * p.X**2 * k / p.v**2, p.v**2 / (p.g * p.X) + 1)
        return {
            "time": time,
            "height": target,
            "miss": shot - target,
            "slowest": slowest,
            "envelope": p.X * best - p.g * p.X**2 * (1 + best**2) / (2 * p.v**2),
        }
