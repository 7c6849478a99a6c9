"""The figure eight: three equal bodies that follow each other on one curve."""

from gnomon.cases.declare import *
from gnomon.cases.orbits.many_bodies import ManyBodies

PERIOD = "6.325914009782138550424699803636009984"


class FigureEight(ManyBodies, count=3):
    """Three equal bodies chase each other on a curve of the shape of an eight, a third of a period apart."""

    name = "figure_eight"
    title = "Figure eight of three bodies (no closed form; certified Taylor)"
    conventions = (
        "[inferred] Not in the book: A. Chenciner, R. Montgomery, Annals of Mathematics 152 (2000) 881, with C. Simo's start in "
        "positions of 8 decimals; velocities and period are extended to 36 decimals, with which the bodies change places "
        "after a third of the period. G = 1."
    )
    x1 = Coordinate("m", "0.97000436", typical(0.960004, 0.980004))
    y1 = Coordinate("m", "-0.24308753", typical(-0.253088, -0.233088))
    x2 = Coordinate("m", "-0.97000436", typical(-0.980004, -0.960004))
    y2 = Coordinate("m", "0.24308753", typical(0.233088, 0.253088))
    x3 = Coordinate("m", 0, typical(-0.01, 0.01))
    y3 = Coordinate("m", 0, typical(-0.01, 0.01))
    vx1 = Coordinate("m/s", "0.466203684069539353403271366847563232", typical(0.456204, 0.476204))
    vy1 = Coordinate("m/s", "0.432365730917476850052927754029036161", typical(0.422366, 0.442366))
    vx2 = Coordinate("m/s", "0.466203684069539353403271366847563232", typical(0.456204, 0.476204))
    vy2 = Coordinate("m/s", "0.432365730917476850052927754029036161", typical(0.422366, 0.442366))
    vx3 = Coordinate("m/s", "-0.932407368139078706806542733695126464", typical(-0.942407, -0.922407))
    vy3 = Coordinate("m/s", "-0.864731461834953700105855508058072322", typical(-0.874731, -0.854731))
    G = Parameter("m^3/(kg s^2)", 1, "constant of gravitation", positive(0.99, 1.01))
    m1 = Parameter("kg", 1, "mass of body 1", positive(0.99, 1.01))
    m2 = Parameter("kg", 1, "mass of body 2", positive(0.99, 1.01))
    m3 = Parameter("kg", 1, "mass of body 3", positive(0.99, 1.01))
    default_span = "12.1"
    most_work = 100_000
    variants = (
        Variant("ten_periods", "ten periods: the phase error adds up", span=63),
        Variant(
            "unequal",
            "masses that differ by a percent: the bodies leave the curve",
            {"m1": "1.01", "m2": "0.99"},
            span="25.1",
        ),
    )
