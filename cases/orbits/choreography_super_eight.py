"""The super eight: four equal bodies that follow each other on one curve."""

from gnomon.cases.declare import *
from gnomon.cases.orbits.many_bodies import ManyBodies


class ChoreographySuperEight(ManyBodies, count=4):
    """Four equal bodies chase each other on one curve of three loops, a quarter of a period apart."""

    name = "choreography_super_eight"
    title = "Choreography of four bodies: the super eight (no closed form; certified Taylor)"
    conventions = (
        "[inferred] Not in the book: C. Simo, New families of solutions in N-body problems (European Congress of Mathematics, "
        "Barcelona 2000), whose start has 6 decimals; extended to 36 decimals, with which the bodies change places after a quarter "
        "of the period 2 pi. G = 1."
    )
    x1 = Coordinate("m", "1.382856843618418812489901360054943992", typical(1.37286, 1.39286))
    y1 = Coordinate("m", 0, typical(-0.01, 0.01))
    x2 = Coordinate("m", 0, typical(-0.01, 0.01))
    y2 = Coordinate("m", "0.157029922281220299600954521531863964", typical(0.14703, 0.16703))
    x3 = Coordinate("m", "-1.382856843618418812489901360054943992", typical(-1.39286, -1.37286))
    y3 = Coordinate("m", 0, typical(-0.01, 0.01))
    x4 = Coordinate("m", 0, typical(-0.01, 0.01))
    y4 = Coordinate("m", "-0.157029922281220299600954521531863964", typical(-0.16703, -0.14703))
    vx1 = Coordinate("m/s", 0, typical(-0.01, 0.01))
    vy1 = Coordinate("m/s", "0.584872630814875087252719539281561131", typical(0.574873, 0.594873))
    vx2 = Coordinate("m/s", "1.871935245878675838835892606949965946", typical(1.86194, 1.88194))
    vy2 = Coordinate("m/s", 0, typical(-0.01, 0.01))
    vx3 = Coordinate("m/s", 0, typical(-0.01, 0.01))
    vy3 = Coordinate("m/s", "-0.584872630814875087252719539281561131", typical(-0.594873, -0.574873))
    vx4 = Coordinate("m/s", "-1.871935245878675838835892606949965946", typical(-1.88194, -1.86194))
    vy4 = Coordinate("m/s", 0, typical(-0.01, 0.01))
    G = Parameter("m^3/(kg s^2)", 1, "constant of gravitation", positive(0.99, 1.01))
    m1 = Parameter("kg", 1, "mass of body 1", positive(0.99, 1.01))
    m2 = Parameter("kg", 1, "mass of body 2", positive(0.99, 1.01))
    m3 = Parameter("kg", 1, "mass of body 3", positive(0.99, 1.01))
    m4 = Parameter("kg", 1, "mass of body 4", positive(0.99, 1.01))
    default_span = "6.1"
    most_work = 50_000
    variants = (
        Variant("unequal", "masses that differ by a percent: the bodies leave the curve", {"m1": "1.01", "m2": "0.99"}),
    )
