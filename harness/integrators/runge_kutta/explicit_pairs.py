"""Embedded explicit Runge-Kutta pairs of orders 3 to 9; DOP853 has a module of its own."""

from gnomon.harness.contract.integrator import Integrator, Tolerance
from gnomon.harness.integrators.base.tableau import ButcherTableau, parse_rows
from gnomon.harness.integrators.runge_kutta.embedded import Embedded
from gnomon.harness.integrators.runge_kutta.verner_table import VERNER_98


class BogackiShampine3(Embedded):
    """Bogacki and Shampine's 3(2) pair (Applied Mathematics Letters 2, 1989), cubic Hermite dense output. Order 3."""

    name, order = "Bogacki-Shampine 3(2)", 3
    primary = False
    sweep = Tolerance(1e-3, 1e-10)
    tableau = ButcherTableau(
        orders=(3, 2),
        a=parse_rows("; 1/2; 0 3/4;"),
        b=parse_rows("2/9 1/3 4/9;")[0],
        errors=parse_rows("-5/72 1/12 1/9 -1/8;"),
        dense=(),
    )


class DormandPrince5(Embedded):
    """Dormand and Prince's 5(4) pair (J. Comput. Appl. Math. 6, 1980). Order 5.

    Dense output of order 4: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.6.
    """

    name, order = "Dormand-Prince 5(4)", 5
    primary = False
    sweep = Tolerance(1e-3, 1e-12)
    tableau = ButcherTableau(
        orders=(5, 4),
        a=parse_rows("""
            ;
            1/5;
            3/40 9/40;
            44/45 -56/15 32/9;
            19372/6561 -25360/2187 64448/6561 -212/729;
            9017/3168 -355/33 46732/5247 49/176 -5103/18656;
        """),
        b=parse_rows("35/384 0 500/1113 125/192 -2187/6784 11/84;")[0],
        errors=parse_rows("71/57600 0 -71/16695 71/1920 -17253/339200 22/525 -1/40;"),
        dense=parse_rows("""
            -12715105075/11282082432 0 87487479700/32700410799 -10690763975/1880347072 701980252875/199316789632
            -1453857185/822651844 69997945/29380423;
        """),
    )


class Tsitouras5(Embedded):
    """Tsitouras's 5(4) pair (Computers and Mathematics with Applications 62, 2011). Order 5.

    The paper prints 16 to 20 digits. c_2, c_3, c_4, b_2 and the last weight of the error are taken as printed; the
    other numbers solve the conditions of orders 5 and 4 to 60 digits and agree with the print. Dense output of order 4.
    """

    name, order = "Tsitouras 5(4)", 5
    primary = False
    sweep = Tolerance(1e-3, 1e-12)
    tableau = ButcherTableau(
        orders=(5, 4),
        a=parse_rows("""
            ;
            0.161;
            -0.008480655492356988544426874250230774675121177393430391537369234
            0.3354806554923569885444268742502307746751211773934303915373692;
            2.897153057105493432130432594192938764924887287701866490314867
            -6.359448489975074843148159912383825625952700647415626703305929
            4.362295432869581411017727318190886861027813359713760212991062;
            5.32586482843925660442887792084051131783647625309704010120236
            -11.74888356406282787774717033978577296188744178259862899288667
            7.495539342889836208304604784564358155658679161518186721010133
            -0.0924950663617552492565020793320719161134998340602953524403475;
            5.861455442946420028659251486982647890394337666164814434818157
            -12.92096931784710929170611868178335939541780751955743459166312
            8.159367898576158643180400794539253485181918321135053305748355
            -0.0715849732814009972245305425258297386912721314736354488272114
            -0.02826905039406838290900305721271224146717633626879770007617876;
        """),
        b=parse_rows("""
            0.09646076681806522951816731316512876333711995238157997181903319 0.01
            0.4798896504144995747752495322905965199130404621990332488332635
            1.37900857410374189319227482185687277075646264309136052593494
            -3.290069515436080679901047585711363850115683290894936158531297
            2.32471052409977398241535591839876579610906023322296241194406;
        """)[0],
        errors=parse_rows("""
            -0.001780011052225771443378550607539534775944678804333659557637451
            -0.0008164344596567469032236360633546862401862537590159047610940605
            0.00788087801026199601031472767252630423862873377710312860325813
            -0.1447110071732629075371651479726351167209227123431676776195142
            0.5823571654525552250199376106520421794260781239567387797673045
            -0.4580821059291869466616365188325542974428047279788398179474684 1/66;
        """),
        dense=parse_rows("""
            -1.053088497729021557227490302523068549943200714276300422714502 0.1017
            2.490627285651252793083545072588195938348679998812982561444638
            -16.54810288924490271830729786228247324907755171709632631121928
            47.37952196281928121868158186819883280230797593090408035165005
            -34.8706578614966097362303387759814869416359034983444361791609 2.5;
        """),
    )


class Verner6(Embedded):
    """Verner's most robust 6(5) pair (Numerical Algorithms 53, 2010). Order 6.

    Verner's most efficient 6(5) pair has weights of 8, -130 and 122 that cancel, which loses digits in binary64.
    Samples are separate steps of the same order within a step.
    """

    name, order = "Verner 6(5)", 6
    primary = False
    sweep = Tolerance(1e-3, 1e-13)
    tableau = ButcherTableau(
        orders=(6, 5),
        a=parse_rows("""
            ;
            9/50;
            29/324 25/324;
            1/16 0 3/16;
            79129/250000 0 -261237/250000 19663/15625;
            1336883/4909125 0 -25476/30875 194159/185250 8225/78546;
            -2459386/14727375 0 19504/30875 2377474/13615875 -6157250/5773131 902/735;
            2699/7410 0 -252/1235 -1393253/3993990 236875/72618 -135/49 15/22;
        """),
        b=parse_rows("11/144 0 0 256/693 0 125/504 125/528 5/72;")[0],
        errors=parse_rows("15/848 0 0 -60/539 312500/366177 -375/392 125/528 9145/71064 -2995/17766;"),
    )


class Verner9(Embedded):
    """Verner's most efficient 9(8) pair (Numerical Algorithms 53, 2010). Order 9.

    Samples are separate steps of the same order within a step.
    """

    name, order = "Verner 9(8)", 9
    primary = False
    tableau = VERNER_98


INTEGRATORS: tuple[type[Integrator], ...] = (BogackiShampine3, DormandPrince5, Tsitouras5, Verner6, Verner9)
