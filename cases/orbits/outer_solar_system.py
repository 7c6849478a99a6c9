"""The outer solar system: the Sun with the inner planets, Jupiter, Saturn, Uranus, Neptune and Pluto."""

from gnomon.cases.declare import *
from gnomon.cases.orbits.many_bodies import ManyBodies


class OuterSolarSystem(ManyBodies, count=6, axes="xyz"):
    """Five planets round the Sun, on nearly circular orbits of 12 to 248 years that disturb each other a little."""

    name = "outer_solar_system"
    title = "Outer solar system (no closed form; certified Taylor)"
    conventions = (
        "[inferred] Not in the book: E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, I.2.4, with the data "
        "of 5 September 1994, 0 h. The unit of length, written m, is the astronomical unit; of time, written s, the day; of "
        "mass, written kg, the solar mass. The Sun has the masses of the inner planets too. Body 1 is the Sun, 2 Jupiter, 3 Saturn, 4 Uranus, 5 Neptune, 6 Pluto. Errors of "
        "each body's position and velocity are relative to their own size."
    )
    x1 = Coordinate("m", "0", typical(-0.01, 0.01), group="length of sun")
    y1 = Coordinate("m", "0", typical(-0.01, 0.01), group="length of sun")
    z1 = Coordinate("m", "0", typical(-0.01, 0.01), group="length of sun")
    x2 = Coordinate("m", "-3.5023653", typical(-3.53739, -3.46734), group="length of jupiter")
    y2 = Coordinate("m", "-3.8169847", typical(-3.85515, -3.77881), group="length of jupiter")
    z2 = Coordinate("m", "-1.5507963", typical(-1.5663, -1.53529), group="length of jupiter")
    x3 = Coordinate("m", "9.0755314", typical(8.98478, 9.16629), group="length of saturn")
    y3 = Coordinate("m", "-3.0458353", typical(-3.07629, -3.01538), group="length of saturn")
    z3 = Coordinate("m", "-1.6483708", typical(-1.66485, -1.63189), group="length of saturn")
    x4 = Coordinate("m", "8.3101420", typical(8.22704, 8.39324), group="length of uranus")
    y4 = Coordinate("m", "-16.2901086", typical(-16.453, -16.1272), group="length of uranus")
    z4 = Coordinate("m", "-7.2521278", typical(-7.32465, -7.17961), group="length of uranus")
    x5 = Coordinate("m", "11.4707666", typical(11.3561, 11.5855), group="length of neptune")
    y5 = Coordinate("m", "-25.7294829", typical(-25.9868, -25.4722), group="length of neptune")
    z5 = Coordinate("m", "-10.8169456", typical(-10.9251, -10.7088), group="length of neptune")
    x6 = Coordinate("m", "-15.5387357", typical(-15.6941, -15.3833), group="length of pluto")
    y6 = Coordinate("m", "-25.2225594", typical(-25.4748, -24.9703), group="length of pluto")
    z6 = Coordinate("m", "-3.1902382", typical(-3.22214, -3.15834), group="length of pluto")
    vx1 = Coordinate("m/s", "0", typical(-1e-05, 1e-05), group="velocity of sun")
    vy1 = Coordinate("m/s", "0", typical(-1e-05, 1e-05), group="velocity of sun")
    vz1 = Coordinate("m/s", "0", typical(-1e-05, 1e-05), group="velocity of sun")
    vx2 = Coordinate("m/s", "0.00565429", typical(0.00555429, 0.00575429), group="velocity of jupiter")
    vy2 = Coordinate("m/s", "-0.00412490", typical(-0.0042249, -0.0040249), group="velocity of jupiter")
    vz2 = Coordinate("m/s", "-0.00190589", typical(-0.00200589, -0.00180589), group="velocity of jupiter")
    vx3 = Coordinate("m/s", "0.00168318", typical(0.00158318, 0.00178318), group="velocity of saturn")
    vy3 = Coordinate("m/s", "0.00483525", typical(0.00473525, 0.00493525), group="velocity of saturn")
    vz3 = Coordinate("m/s", "0.00192462", typical(0.00182462, 0.00202462), group="velocity of saturn")
    vx4 = Coordinate("m/s", "0.00354178", typical(0.00344178, 0.00364178), group="velocity of uranus")
    vy4 = Coordinate("m/s", "0.00137102", typical(0.00127102, 0.00147102), group="velocity of uranus")
    vz4 = Coordinate("m/s", "0.00055029", typical(0.00045029, 0.00065029), group="velocity of uranus")
    vx5 = Coordinate("m/s", "0.00288930", typical(0.0027893, 0.0029893), group="velocity of neptune")
    vy5 = Coordinate("m/s", "0.00114527", typical(0.00104527, 0.00124527), group="velocity of neptune")
    vz5 = Coordinate("m/s", "0.00039677", typical(0.00029677, 0.00049677), group="velocity of neptune")
    vx6 = Coordinate("m/s", "0.00276725", typical(0.00266725, 0.00286725), group="velocity of pluto")
    vy6 = Coordinate("m/s", "-0.00170702", typical(-0.00180702, -0.00160702), group="velocity of pluto")
    vz6 = Coordinate("m/s", "-0.00136504", typical(-0.00146504, -0.00126504), group="velocity of pluto")
    G = Parameter("m^3/(kg s^2)", "2.95912208286e-4", "constant of gravitation", positive(2.9e-4, 3e-4))
    m1 = Parameter("kg", "1.00000597682", "mass of the Sun and the inner planets", positive(0.900005, 1.10001))
    m2 = Parameter("kg", "0.000954786104043", "mass of Jupiter", positive(0.000859307, 0.00105026))
    m3 = Parameter("kg", "0.000285583733151", "mass of Saturn", positive(0.000257025, 0.000314142))
    m4 = Parameter("kg", "0.0000437273164546", "mass of Uranus", positive(3.93546e-05, 4.81e-05))
    m5 = Parameter("kg", "0.0000517759138449", "mass of Neptune", positive(4.65983e-05, 5.69535e-05))
    m6 = Parameter("kg", Fraction(1, 130_000_000), "mass of Pluto", positive(6.92308e-09, 8.46154e-09))
    default_span = 20_000
    most_work = 150_000
    variants = (Variant("long", "1e5 days: 23 turns of Jupiter, 9 of Saturn", span=100_000),)
