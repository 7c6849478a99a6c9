"""Symplectic splitting methods for q'' = a(t, q): alternate kicks of the velocity and drifts of the position."""

from itertools import pairwise
from typing import Any, ClassVar

from gnomon.cases.core.forms import SecondOrder
from gnomon.harness.contract.integrator import Integrator, Steps
from gnomon.harness.integrators.base.fixed_step import FixedStep, Table
from gnomon.harness.integrators.base.stepping import StepData, evaluate


def splitting_step(s: StepData, t: Any, h: Any) -> bool:
    """One step of kicks and drifts.

    Rows of `table`: kicks b_1 ... b_s and drifts a_1 ... a_s, applied as b_1, a_1, b_2, a_2, ..., in units of h. A
    method that ends with a kick leaves the acceleration at the end of the step in `slope`; the next step begins with
    it.
    """
    table, y, x, slope, store, increment = s.table, s.y, s.x, s.slope, s.store, s.increment
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
                evaluate(s, now)
            for i in range(half):
                increment[half + i] += kick * slope[i]
        if drift != 0.0:
            now += drift
            for i in range(half):
                increment[i] += drift * (y[half + i] + increment[half + i])
    store[0, 0] = 1.0 if table[1, table.shape[1] - 1] == 0.0 else 0.0
    return True


class Splitting(FixedStep):
    """A splitting method given by its kicks and drifts. In a time-dependent potential, time drifts with the position.

    Sums are compensated, which takes one to three per cent of the time, except in methods of order 1 and 2, whose
    errors hide round-off.
    """

    accepts = (SecondOrder,)
    compensated = True
    step = splitting_step

    @classmethod
    def palindrome(cls, kicks: list[Any], drifts: list[Any]) -> Table:
        """The table of a method that begins and ends with a kick: one more kick than drifts, both lists palindromes."""
        return [kicks, [*drifts, kicks[0] * 0]]


class SymplecticEuler(Splitting):
    """Symplectic Euler, kick before drift (de Vogelaere, 1956). Order 1."""

    name, order, conserves, compensated = "Symplectic Euler", 1, ("symplectic", "momentum"), False

    @classmethod
    def coefficients(cls, mp: Any) -> Table:
        return [[mp.mpf(1)], [mp.mpf(1)]]


class Composition(Splitting):
    """A symmetric composition of Störmer-Verlet steps of lengths gamma_1 h, ..., gamma_s h, gamma_i = gamma_{s+1-i}.

    `half` holds the gammas before the middle one, which makes the sum 1.
    """

    conserves = ("symplectic", "reversible", "momentum")
    half: ClassVar[tuple[str, ...]]

    @classmethod
    def lengths(cls, mp: Any) -> list[Any]:
        """The lengths gamma_1 ... gamma_s."""
        first = [mp.mpf(text) for text in cls.half]
        return [*first, 1 - 2 * mp.fsum(first), *reversed(first)]

    @classmethod
    def coefficients(cls, mp: Any) -> Table:
        gamma = cls.lengths(mp)
        kicks = [gamma[0] / 2, *((a + b) / 2 for a, b in pairwise(gamma)), gamma[-1] / 2]
        return cls.palindrome(kicks, gamma)


class StormerVerlet(Composition):
    """Störmer-Verlet in velocity form, kick-drift-kick. Order 2.

    Verlet, Physical Review 159, 1967; in this form Swope, Andersen, Berens, Wilson, J. Chem. Phys. 76, 1982.
    """

    name, order, compensated = "Störmer-Verlet", 2, False
    half = ()


class Composed(FixedStep):
    """A method that composes a symmetric step of its own, with the step lengths of a composition of Störmer-Verlet steps."""

    composition: ClassVar[type[Composition]] = StormerVerlet

    @classmethod
    def coefficients(cls, mp: Any) -> Table:
        return [cls.composition.lengths(mp)]


class PositionVerlet(Splitting):
    """Störmer-Verlet in position form, drift-kick-drift. Order 2.

    Tuckerman, Berne, Martyna, J. Chem. Phys. 97, 1992.
    """

    name, order, compensated = "Position Verlet", 2, False
    conserves = ("symplectic", "reversible", "momentum")
    primary = False

    @classmethod
    def coefficients(cls, mp: Any) -> Table:
        half = mp.mpf(1) / 2
        return [[mp.mpf(0), mp.mpf(1)], [half, half]]


class ForestRuth4(Composition):
    """Three Verlet steps, the middle one backwards (Forest and Ruth, Physica D 43, 1990). Order 4."""

    name, order = "Forest-Ruth 4", 4
    primary = False

    @classmethod
    def lengths(cls, mp: Any) -> list[Any]:
        outer = 1 / (2 - mp.cbrt(2))
        return [outer, 1 - 2 * outer, outer]


class Suzuki4(Composition):
    """Five Verlet steps of order 4, each shorter than the step (Suzuki, Physics Letters A 146, 1990). Order 4."""

    name, order = "Suzuki 4", 4
    primary = False

    @classmethod
    def lengths(cls, mp: Any) -> list[Any]:
        outer = 1 / (4 - mp.cbrt(4))
        return [outer, outer, 1 - 4 * outer, outer, outer]


class McLachlanAtela4(Splitting):
    """Four stages of least error (McLachlan and Atela, Nonlinearity 5, 1992). Order 4.

    The paper prints 19 digits. The numbers here solve the conditions of order 4 to 60 digits: the solution nearest to
    the printed one.
    """

    name, order, conserves = "McLachlan-Atela 4", 4, ("symplectic", "momentum")
    primary = False
    kicks = (
        "0.13449619927743108920547866796401532079138753239894125821562987",
        "-0.2248198030794208058164903083049938953319385313651974711300396",
        "0.756320000515668291111678821505315608545910515179127370480067",
    )
    drifts = (
        "0.51535283743112293640037136933130383226483902331827640374889774",
        "-0.08578201941297364607029239136435776297565089607003913796640787",
        "0.44158302361646652425307674196756387992184707682877562577617118",
    )

    @classmethod
    def coefficients(cls, mp: Any) -> Table:
        rows = [[mp.mpf(text) for text in texts] for texts in (cls.kicks, cls.drifts)]
        return [[*row, 1 - mp.fsum(row)] for row in rows]


class BlanesMoan4(Splitting):
    """Six-stage Runge-Kutta-Nyström splitting SRKN6b (Blanes and Moan, J. Comput. Appl. Math. 142, 2002). Order 4.

    The paper prints 15 digits. b_1, a_1 and b_2 are taken as printed; a_2 and b_3 solve the two conditions of order 3
    to 60 digits, which the printed numbers miss by 1e-14.
    """

    name, order, conserves = "Blanes-Moan 4", 4, ("symplectic", "reversible", "momentum")
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


class BlanesMoan6(Splitting):
    """Eleven-stage Runge-Kutta-Nyström splitting SRKN11b (Blanes and Moan, J. Comput. Appl. Math. 142, 2002). Order 6.

    The paper prints 15 digits. The numbers here solve the conditions of order 6 to 60 digits: the solution nearest to
    the printed one.
    """

    name, order, conserves = "Blanes-Moan 6", 6, ("symplectic", "reversible", "momentum")
    primary = False
    kicks = (
        "0.041464998518262843298778133914704936723936175943344961005660128",
        "0.19812867191806654113672647318149696061253521636787924678145169",
        "-0.040006192104152686888828363535944839375694177760994167916455649",
        "0.075253984301580341127878878527042755541751208428237835700936736",
        "-0.011511387420687770062443201501289199552592637810078202935253411",
    )
    drifts = (
        "0.12322977594627115156108638033336675259052493506632400183290093",
        "0.29055379779955827036641416932791618333021012549376493630722324",
        "-0.12704921262541691566250505382748593447301974790937436380156904",
        "-0.24633176106207540419497348910406286259601062828773676247964847",
        "0.35720887279592775261986034961931046283688937146325047146608727",
    )

    @classmethod
    def coefficients(cls, mp: Any) -> Table:
        b = [mp.mpf(text) for text in cls.kicks]
        a = [mp.mpf(text) for text in cls.drifts]
        b.append(mp.mpf(1) / 2 - mp.fsum(b))
        a.append(1 - 2 * mp.fsum(a))
        return cls.palindrome([*b, *reversed(b)], [*a, *reversed(a[:-1])])


class Yoshida6(Composition):
    """Seven Verlet steps, solution A (Yoshida, Physics Letters A 150, 1990). Order 6.

    The paper prints 15 digits. The numbers here solve the order conditions to 60 digits and agree with the print.
    """

    name, order = "Yoshida 6", 6
    primary = False
    half = (
        "0.7845136104775572638194976338663498757768244174514933845679478",
        "0.23557321335935813368479318297853460168646808210340111900349313",
        "-1.1776799841788710069464156809643157346392692526345984844753685",
    )


class Yoshida8(Composition):
    """Fifteen Verlet steps, solution D (Yoshida, Physics Letters A 150, 1990). Order 8.

    The paper prints 15 digits. The numbers here solve the order conditions to 60 digits and agree with the print to 13.
    """

    name, order = "Yoshida 8", 8
    primary = False
    sweep = Steps(coarsest=1.0, halvings=8)
    half = (
        "0.91484424622979156674879348984750960451811970872885837179725993",
        "0.2536933365662113541461460206899420760976531647324740966322676",
        "-1.4448522368606051576947306575373903549559101017955056024889062",
        "-0.15824063536805017520406677675975424775544511567575156808209837",
        "1.9381391376225259865791864874436417609535933574476502720727931",
        "-1.9606102329753108076076333763996636407924328198260053019104148",
        "0.10279984939179644069811513160122586291101560127844276827170206",
    )


class KahanLi6(Composition):
    """Nine Verlet steps (Kahan and Li, Math. Comp. 66, 1997; Hairer, Lubich, Wanner V.3.11). Order 6.

    gamma_4 is taken as printed, to 26 digits; the other numbers solve the order conditions to 60 digits and agree with
    the print.
    """

    name, order = "Kahan-Li 6", 6
    half = (
        "0.39216144400731413927925056393528047258919685640879611373102114",
        "0.33259913678935943859974862930593431354238498377657380121986722",
        "-0.70624617255763935980996481976569386373727741088384295554673289",
        "0.08221359629355080023149045",
    )


class KahanLi8(Composition):
    """Seventeen Verlet steps (Kahan and Li, Math. Comp. 66, 1997). Order 8.

    gamma_8 is taken as printed, to 26 digits; the other numbers solve the order conditions to 60 digits and agree with
    the print.
    """

    name, order = "Kahan-Li 8", 8
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


INTEGRATORS: tuple[type[Integrator], ...] = (
    SymplecticEuler, StormerVerlet, PositionVerlet, ForestRuth4, McLachlanAtela4, Suzuki4, BlanesMoan4,
    Yoshida6, KahanLi6, BlanesMoan6, Yoshida8, KahanLi8,
)  # fmt: skip
