"""A choreography of five equal bodies that follow each other on one curve."""

from gnomon.cases.declare import *
from gnomon.cases.orbits.many_bodies import ManyBodies


class ChoreographyFiveBodies(ManyBodies, count=5):
    """Five equal bodies chase each other on one curve of four loops, a fifth of a period apart."""

    name = "choreography_five_bodies"
    title = "Choreography of five bodies on a chain of four loops (no closed form; certified Taylor)"
    conventions = (
        "[inferred] Not in the book: C. Simo, New families of solutions in N-body problems (European Congress of Mathematics, "
        "Barcelona 2000), whose start has 6 decimals; extended to 36 decimals, with which the bodies change places after a fifth "
        "of the period 2 pi. G = 1."
    )
    x1 = Coordinate("m", "1.657666012549265919637248276845842566", typical(1.64767, 1.66767))
    y1 = Coordinate("m", 0, typical(-0.01, 0.01))
    x2 = Coordinate("m", "0.439775050426290432594325408055333777", typical(0.429775, 0.449775))
    y2 = Coordinate("m", "-0.169716862319628001043690109202425471", typical(-0.179717, -0.159717))
    x3 = Coordinate("m", "-1.268608056700923392412949546478255060", typical(-1.27861, -1.25861))
    y3 = Coordinate("m", "-0.267650773258183166600651004891690732", typical(-0.277651, -0.257651))
    x4 = Coordinate("m", "-1.268608056700923392412949546478255060", typical(-1.27861, -1.25861))
    y4 = Coordinate("m", "0.267650773258183166600651004891690732", typical(0.257651, 0.277651))
    x5 = Coordinate("m", "0.439775050426290432594325408055333777", typical(0.429775, 0.449775))
    y5 = Coordinate("m", "0.169716862319628001043690109202425471", typical(0.159717, 0.179717))
    vx1 = Coordinate("m/s", 0, typical(-0.01, 0.01))
    vy1 = Coordinate("m/s", "-0.593785277963250532411071269720914442", typical(-0.603785, -0.583785))
    vx2 = Coordinate("m/s", "1.822785487627250654929103561190374429", typical(1.81279, 1.83279))
    vy2 = Coordinate("m/s", "0.128248005600028338065937700136904716", typical(0.118248, 0.138248))
    vx3 = Coordinate("m/s", "1.271563936574906607847298815927814986", typical(1.26156, 1.28156))
    vy3 = Coordinate("m/s", "0.168644633381596928139597934723552505", typical(0.158645, 0.178645))
    vx4 = Coordinate("m/s", "-1.271563936574906607847298815927814986", typical(-1.28156, -1.26156))
    vy4 = Coordinate("m/s", "0.168644633381596928139597934723552505", typical(0.158645, 0.178645))
    vx5 = Coordinate("m/s", "-1.822785487627250654929103561190374429", typical(-1.83279, -1.81279))
    vy5 = Coordinate("m/s", "0.128248005600028338065937700136904716", typical(0.118248, 0.138248))
    G = Parameter("m^3/(kg s^2)", 1, "constant of gravitation", positive(0.99, 1.01))
    m1 = Parameter("kg", 1, "mass of body 1", positive(0.99, 1.01))
    m2 = Parameter("kg", 1, "mass of body 2", positive(0.99, 1.01))
    m3 = Parameter("kg", 1, "mass of body 3", positive(0.99, 1.01))
    m4 = Parameter("kg", 1, "mass of body 4", positive(0.99, 1.01))
    m5 = Parameter("kg", 1, "mass of body 5", positive(0.99, 1.01))
    default_span = "6.1"
    most_work = 50_000
    variants = (
        Variant("unequal", "masses that differ by a percent: the bodies leave the curve", {"m1": "1.01", "m2": "0.99"}),
    )
