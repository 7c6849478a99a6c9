"""The Pleiades problem of Hairer, Norsett and Wanner: seven stars in a plane, with nearly collisions."""

from gnomon.cases.declare import *
from gnomon.cases.orbits.many_bodies import ManyBodies


class Pleiades(ManyBodies, count=7):
    """Seven stars of masses 1 to 7 in a plane, two of which pass each other closely several times."""

    name = "pleiades"
    title = "Pleiades: seven stars in a plane (no closed form; certified Taylor)"
    conventions = (
        "[inferred] Not in the book: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, II.10; "
        "Test Set for IVP Solvers, problem PLEI. G = 1; star k has the mass k."
    )
    x1 = Coordinate("m", 3, typical(2.9, 3.1))
    y1 = Coordinate("m", 3, typical(2.9, 3.1))
    x2 = Coordinate("m", 3, typical(2.9, 3.1))
    y2 = Coordinate("m", -3, typical(-3.1, -2.9))
    x3 = Coordinate("m", -1, typical(-1.1, -0.9))
    y3 = Coordinate("m", 2, typical(1.9, 2.1))
    x4 = Coordinate("m", -3, typical(-3.1, -2.9))
    y4 = Coordinate("m", 0, typical(-0.1, 0.1))
    x5 = Coordinate("m", 2, typical(1.9, 2.1))
    y5 = Coordinate("m", 0, typical(-0.1, 0.1))
    x6 = Coordinate("m", -2, typical(-2.1, -1.9))
    y6 = Coordinate("m", -4, typical(-4.1, -3.9))
    x7 = Coordinate("m", 2, typical(1.9, 2.1))
    y7 = Coordinate("m", 4, typical(3.9, 4.1))
    vx1 = Coordinate("m/s", 0, typical(-0.1, 0.1))
    vy1 = Coordinate("m/s", 0, typical(-0.1, 0.1))
    vx2 = Coordinate("m/s", 0, typical(-0.1, 0.1))
    vy2 = Coordinate("m/s", 0, typical(-0.1, 0.1))
    vx3 = Coordinate("m/s", 0, typical(-0.1, 0.1))
    vy3 = Coordinate("m/s", 0, typical(-0.1, 0.1))
    vx4 = Coordinate("m/s", 0, typical(-0.1, 0.1))
    vy4 = Coordinate("m/s", "-1.25", typical(-1.35, -1.15))
    vx5 = Coordinate("m/s", 0, typical(-0.1, 0.1))
    vy5 = Coordinate("m/s", 1, typical(0.9, 1.1))
    vx6 = Coordinate("m/s", "1.75", typical(1.65, 1.85))
    vy6 = Coordinate("m/s", 0, typical(-0.1, 0.1))
    vx7 = Coordinate("m/s", "-1.5", typical(-1.6, -1.4))
    vy7 = Coordinate("m/s", 0, typical(-0.1, 0.1))
    G = Parameter("m^3/(kg s^2)", 1, "constant of gravitation", positive(0.9, 1.1))
    m1 = Parameter("kg", 1, "mass of star 1", positive(0.9, 1.1))
    m2 = Parameter("kg", 2, "mass of star 2", positive(1.8, 2.2))
    m3 = Parameter("kg", 3, "mass of star 3", positive(2.7, 3.3))
    m4 = Parameter("kg", 4, "mass of star 4", positive(3.6, 4.4))
    m5 = Parameter("kg", 5, "mass of star 5", positive(4.5, 5.5))
    m6 = Parameter("kg", 6, "mass of star 6", positive(5.4, 6.6))
    m7 = Parameter("kg", 7, "mass of star 7", positive(6.3, 7.7))
    default_span = 3
    most_work = 100_000
    variants = (Variant("half", "until the first close encounters", span="1.5"),)
