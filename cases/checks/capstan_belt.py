"""The friction of a belt around a pulley (Beatty, Dynamics, 10.12.1)."""

from gnomon.cases.declare import *


class CapstanBelt(Check):
    name = "capstan_belt"
    title = "Belt on a pulley about to slip: tensions and torque"
    section = "10.12.1"
    conventions = (
        "[inferred] A massless belt touches a pulley over the angle beta and is about to slip, with friction mu: the "
        "tension grows from `slack` to slack e^(mu beta). torque: of the belt on the pulley of radius r; pressing: "
        "the sum of the magnitudes of all normal forces."
    )
    slack = Parameter("N", 20, "tension of the slack side", positive())
    mu = Parameter("1", "0.3", "coefficient of friction", positive(0.05, 1))
    beta = Parameter("rad", "3.5", "angle over which the belt touches the pulley", positive())
    r = Parameter("m", "0.1", "radius of the pulley", positive(0.05, 1))
    variants = (
        Variant("slippery", "mu = 1e-12: the difference of the tensions cancels", {"mu": "1e-12"}),
        Variant("bollard", "ten turns of a rope: a ratio of 1.5e8", {"beta": "62.831853"}),
    )
    guard = 40

    def formulas(self, p: Any) -> Mapping[str, Any]:
        gain = (p.mu * p.beta).expm1()
        return {
            "tight": p.slack * (p.mu * p.beta).exp(),
            "ratio": (p.mu * p.beta).exp(),
            "torque": p.slack * p.r * gain,
            "pressing": p.slack * gain / p.mu,
        }

    def otherwise(self, mp: Any, p: Any) -> Mapping[str, Any]:
        """The belt in pieces, each about to slip under its own normal force; extrapolated to infinitely many pieces."""
        rows: list[list[Any]] = []
        while True:
            half = p.beta / 2 ** (len(rows) + 4)
            # Across a piece of angle 2 h with normal force N: (T2 + T1) sin h = N, (T2 - T1) cos h = mu N.
            share = p.mu * mp.tan(half)
            row = [p.slack * ((1 + share) / (1 - share)) ** (2 ** (len(rows) + 3))]
            for k, above in enumerate(rows[-1] if rows else []):
                row.append(row[k] + (row[k] - above) / (4 ** (k + 1) - 1))
            rows.append(row)
            # The power of so many pieces loses a few digits, fewer than `guard`.
            if len(rows) > 1 and abs(row[-1] - rows[-2][-1]) <= mp.mpf(10) ** (20 - mp.dps) * row[-1]:
                tight = row[-1]
                break
        gained = tight - p.slack
        return {"tight": tight, "ratio": tight / p.slack, "torque": gained * p.r, "pressing": gained / p.mu}
