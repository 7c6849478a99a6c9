"""Symplectic splitting methods for q'' = a(t, q): kicks of the velocity and drifts of the position in turn."""

from __future__ import annotations

from itertools import pairwise
from typing import Any, ClassVar

from gnomon.cases.forms import SecondOrder
from gnomon.harness.integrator import Integrator, Steps
from gnomon.harness.integrators.fixed_step import FixedStep, Table
from gnomon.harness.integrators.stepping import call


def splitting_step(
    f: Any, t: Any, h: Any, y: Any, p: Any, table: Any, x: Any, slope: Any, store: Any, increment: Any
) -> bool:
    """Rows of `table`: kicks b_1 ... b_s and drifts a_1 ... a_s, in the order b_1, a_1, b_2, a_2, ..., in steps of h.

    A method that ends with a kick leaves the acceleration at the end of the step in `slope`, where the next starts.
    """
    half = x.size
    for i in range(2 * half):
        increment[i] = 0.0
    now = t
    for j in range(table.shape[1]):
        kick = h * table[0, j]
        drift = h * table[1, j]
        if kick != 0.0:
            if j > 0 or store[0, 0] == 0.0:
                for i in range(half):
                    x[i] = y[i] + increment[i]
                call(f, now, x, p, slope)
            for i in range(half):
                increment[half + i] += kick * slope[i]
        if drift != 0.0:
            now += drift
            for i in range(half):
                increment[i] += drift * (y[half + i] + increment[half + i])
    store[0, 0] = 1.0 if table[1, table.shape[1] - 1] == 0.0 else 0.0
    return True


class Splitting(FixedStep):
    """A splitting method by its kicks and drifts. With time in the potential, time drifts with the position."""

    accepts = (SecondOrder,)
    step = splitting_step

    @classmethod
    def palindrome(cls, kicks: list[Any], drifts: list[Any]) -> Table:
        """Kicks first and last: both sequences mirrored, one more kick than drifts."""
        return [kicks, [*drifts, kicks[0] * 0]]


class SymplecticEuler(Splitting):
    """Symplectic Euler, kick before drift (de Vogelaere, 1956). Order 1."""

    name, order, conserves = "Symplectic Euler", 1, ("symplectic",)

    @classmethod
    def coefficients(cls, mp: Any) -> Table:
        return [[mp.mpf(1)], [mp.mpf(1)]]


class Composition(Splitting):
    """A symmetric composition of Störmer-Verlet steps of lengths gamma_1 h, ..., gamma_s h, gamma_i = gamma_{s+1-i}.

    `half` holds gamma_1 to the middle one's left neighbour, `stages` is s; the middle gamma makes the sum 1.
    """

    conserves = ("symplectic", "reversible")
    half: ClassVar[tuple[str, ...]]

    @classmethod
    def lengths(cls, mp: Any) -> list[Any]:
        """gamma_1 ... gamma_s."""
        first = [mp.mpf(text) for text in cls.half]
        return [*first, 1 - 2 * mp.fsum(first), *reversed(first)]

    @classmethod
    def coefficients(cls, mp: Any) -> Table:
        gamma = cls.lengths(mp)
        kicks = [gamma[0] / 2, *((a + b) / 2 for a, b in pairwise(gamma)), gamma[-1] / 2]
        return cls.palindrome(kicks, gamma)


class StormerVerlet(Composition):
    """Störmer-Verlet in velocity form, kick-drift-kick (Verlet, Physical Review 159, 1967). Order 2."""

    name, order = "Störmer-Verlet", 2
    half = ()


class Suzuki4(Composition):
    """Five Verlet steps of order 4, each shorter than the step (Suzuki, Physics Letters A 146, 1990). Order 4."""

    name, order = "Suzuki 4", 4

    @classmethod
    def lengths(cls, mp: Any) -> list[Any]:
        outer = 1 / (4 - mp.cbrt(4))
        return [outer, outer, 1 - 4 * outer, outer, outer]


class BlanesMoan4(Splitting):
    """Six-stage Runge-Kutta-Nyström splitting SRKN6b (Blanes and Moan, J. Comput. Appl. Math. 142, 2002). Order 4.

    The paper prints 15 digits. b_1, a_1 and b_2 are taken as printed; a_2 and b_3 solve the two conditions of order 3
    to 60 digits; the printed ones miss them by 1e-14.
    """

    name, order, conserves = "Blanes-Moan 4", 4, ("symplectic", "reversible")
    kicks = (
        "0.0829844064174052",
        "0.396309801498368",
        "-0.039056304922345844779619677270012315621652493361354296653291596",
    )
    drifts = ("0.245298957184271", "0.60487266571109442310932851278210607471495279307045101061363871")

    @classmethod
    def coefficients(cls, mp: Any) -> Table:
        b = [mp.mpf(text) for text in cls.kicks]
        a = [mp.mpf(text) for text in cls.drifts]
        a.append(mp.mpf(1) / 2 - mp.fsum(a))
        b.append(1 - 2 * mp.fsum(b))
        return cls.palindrome([*b, *reversed(b[:-1])], [*a, *reversed(a)])


class KahanLi6(Composition):
    """Nine Verlet steps (Kahan and Li, Math. Comp. 66, 1997; Hairer, Lubich, Wanner V.3.11). Order 6.

    gamma_4 is taken as printed, to 26 digits; the others solve the order conditions to 60 and agree with the print.
    """

    name, order = "Kahan-Li 6", 6
    half = (
        "0.39216144400731413927925056393528047258919685640879611373102114",
        "0.33259913678935943859974862930593431354238498377657380121986722",
        "-0.70624617255763935980996481976569386373727741088384295554673289",
        "0.08221359629355080023149045",
    )


class KahanLi8(Composition):
    """Seventeen Verlet steps, summed with compensation (Kahan and Li, Math. Comp. 66, 1997). Order 8.

    gamma_8 is taken as printed, to 26 digits; the others solve the order conditions to 60 and agree with the print.
    """

    name, order, compensated = "Kahan-Li 8", 8, True
    sweep = Steps(coarsest=2.0, halvings=8)
    half = (
        "0.13020248308889008087881763196448727458024330835702879528984021",
        "0.561162981775108384561964407699006039542722657663950622430196",
        "-0.3894749626448472864080785979078473431452702107154056100906315",
        "0.15884190655515560089621074576835192803589564420953955769585983",
        "-0.39590389413323757733623153960762296372479867366435459716749166",
        "0.18453964097831570709183254164881600929881402056956303940260264",
        "0.25837438768632204729397911010216834919371490242675069327553148",
        "0.29501172360931029887096624",
    )


INTEGRATORS: tuple[type[Integrator], ...] = (SymplecticEuler, StormerVerlet, Suzuki4, BlanesMoan4, KahanLi6, KahanLi8)
