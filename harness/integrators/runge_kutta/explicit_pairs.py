"""Embedded explicit Runge-Kutta pairs of orders 3 to 9; DOP853 has a module of its own."""

from __future__ import annotations

from typing import ClassVar

from gnomon.harness.contract.integrator import Integrator, Tolerance
from gnomon.harness.integrators.runge_kutta import verner_table
from gnomon.harness.integrators.runge_kutta.embedded import Embedded, Row


class BogackiShampine3(Embedded):
    """Bogacki and Shampine's 3(2) pair (Applied Mathematics Letters 2, 1989), cubic Hermite dense output. Order 3."""

    name, order = "Bogacki-Shampine 3(2)", 3
    primary = False
    sweep = Tolerance(1e-3, 1e-10)
    stages = ({}, {0: "1/2"}, {1: "3/4"})
    weights: ClassVar[Row] = {0: "2/9", 1: "1/3", 2: "4/9"}
    errors = ({0: "-5/72", 1: "1/12", 2: "1/9", 3: "-1/8"},)
    dense = ()


class DormandPrince5(Embedded):
    """Dormand and Prince's 5(4) pair (J. Comput. Appl. Math. 6, 1980). Order 5.

    Dense output of order 4: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.6.
    """

    name, order = "Dormand-Prince 5(4)", 5
    primary = False
    sweep = Tolerance(1e-3, 1e-12)
    stages = (
        {},
        {0: "1/5"},
        {0: "3/40", 1: "9/40"},
        {0: "44/45", 1: "-56/15", 2: "32/9"},
        {0: "19372/6561", 1: "-25360/2187", 2: "64448/6561", 3: "-212/729"},
        {0: "9017/3168", 1: "-355/33", 2: "46732/5247", 3: "49/176", 4: "-5103/18656"},
    )
    weights: ClassVar[Row] = {0: "35/384", 2: "500/1113", 3: "125/192", 4: "-2187/6784", 5: "11/84"}
    errors = ({0: "71/57600", 2: "-71/16695", 3: "71/1920", 4: "-17253/339200", 5: "22/525", 6: "-1/40"},)
    dense = (
        {
            0: "-12715105075/11282082432",
            2: "87487479700/32700410799",
            3: "-10690763975/1880347072",
            4: "701980252875/199316789632",
            5: "-1453857185/822651844",
            6: "69997945/29380423",
        },
    )


class Tsitouras5(Embedded):
    """Tsitouras's 5(4) pair (Computers and Mathematics with Applications 62, 2011). Order 5.

    The paper prints 16 to 20 digits. c_2, c_3, c_4, b_2 and the last weight of the error are taken as printed; the rest
    solve the conditions of orders 5 and 4 to 60 digits and agree with the print. Dense output of order 4.
    """

    name, order = "Tsitouras 5(4)", 5
    primary = False
    sweep = Tolerance(1e-3, 1e-12)
    stages = (
        {},
        {0: "0.161"},
        {
            0: "-0.008480655492356988544426874250230774675121177393430391537369234",
            1: "0.3354806554923569885444268742502307746751211773934303915373692",
        },
        {
            0: "2.897153057105493432130432594192938764924887287701866490314867",
            1: "-6.359448489975074843148159912383825625952700647415626703305929",
            2: "4.362295432869581411017727318190886861027813359713760212991062",
        },
        {
            0: "5.32586482843925660442887792084051131783647625309704010120236",
            1: "-11.74888356406282787774717033978577296188744178259862899288667",
            2: "7.495539342889836208304604784564358155658679161518186721010133",
            3: "-0.0924950663617552492565020793320719161134998340602953524403475",
        },
        {
            0: "5.861455442946420028659251486982647890394337666164814434818157",
            1: "-12.92096931784710929170611868178335939541780751955743459166312",
            2: "8.159367898576158643180400794539253485181918321135053305748355",
            3: "-0.0715849732814009972245305425258297386912721314736354488272114",
            4: "-0.02826905039406838290900305721271224146717633626879770007617876",
        },
    )
    weights: ClassVar[Row] = {
        0: "0.09646076681806522951816731316512876333711995238157997181903319",
        1: "0.01",
        2: "0.4798896504144995747752495322905965199130404621990332488332635",
        3: "1.37900857410374189319227482185687277075646264309136052593494",
        4: "-3.290069515436080679901047585711363850115683290894936158531297",
        5: "2.32471052409977398241535591839876579610906023322296241194406",
    }
    errors = (
        {
            0: "-0.001780011052225771443378550607539534775944678804333659557637451",
            1: "-0.0008164344596567469032236360633546862401862537590159047610940605",
            2: "0.00788087801026199601031472767252630423862873377710312860325813",
            3: "-0.1447110071732629075371651479726351167209227123431676776195142",
            4: "0.5823571654525552250199376106520421794260781239567387797673045",
            5: "-0.4580821059291869466616365188325542974428047279788398179474684",
            6: "1/66",
        },
    )
    dense = (
        {
            0: "-1.053088497729021557227490302523068549943200714276300422714502",
            1: "0.1017",
            2: "2.490627285651252793083545072588195938348679998812982561444638",
            3: "-16.54810288924490271830729786228247324907755171709632631121928",
            4: "47.37952196281928121868158186819883280230797593090408035165005",
            5: "-34.8706578614966097362303387759814869416359034983444361791609",
            6: "2.5",
        },
    )


class Verner6(Embedded):
    """Verner's most robust 6(5) pair (Numerical Algorithms 53, 2010). Order 6.

    The most efficient one has weights of 8, -130 and 122 that cancel, which loses digits in binary64. Samples are separate
    steps of the same order within a step.
    """

    name, order = "Verner 6(5)", 6
    primary = False
    sweep = Tolerance(1e-3, 1e-13)
    stages = (
        {},
        {0: "9/50"},
        {0: "29/324", 1: "25/324"},
        {0: "1/16", 2: "3/16"},
        {0: "79129/250000", 2: "-261237/250000", 3: "19663/15625"},
        {0: "1336883/4909125", 2: "-25476/30875", 3: "194159/185250", 4: "8225/78546"},
        {0: "-2459386/14727375", 2: "19504/30875", 3: "2377474/13615875", 4: "-6157250/5773131", 5: "902/735"},
        {0: "2699/7410", 2: "-252/1235", 3: "-1393253/3993990", 4: "236875/72618", 5: "-135/49", 6: "15/22"},
    )
    weights: ClassVar[Row] = {0: "11/144", 3: "256/693", 5: "125/504", 6: "125/528", 7: "5/72"}
    errors = (
        {
            0: "15/848",
            3: "-60/539",
            4: "312500/366177",
            5: "-375/392",
            6: "125/528",
            7: "9145/71064",
            8: "-2995/17766",
        },
    )


class Verner9(Embedded):
    """Verner's most efficient 9(8) pair (Numerical Algorithms 53, 2010). Order 9.

    Samples are separate steps of the same order within a step.
    """

    name, order = "Verner 9(8)", 9
    primary = False
    stages, weights = verner_table.STAGES, verner_table.WEIGHTS
    errors = (verner_table.ERROR,)


INTEGRATORS: tuple[type[Integrator], ...] = (BogackiShampine3, DormandPrince5, Tsitouras5, Verner6, Verner9)
