"""The super eight: four equal bodies that follow each other on one curve."""

from gnomon.cases.declare import *
from gnomon.cases.orbits.many_bodies import (
    alike_bodies,
    are_apart,
    momentum_x,
    momentum_y,
    nbody,
    pair_energy,
    pairs_attract,
    shortest_radian,
    spin_about_z,
)
from gnomon.cases.scenes.two_masses import attracting


class ChoreographySuperEight(IntegratedCase):
    """Four equal bodies chase each other on one curve of three loops, a quarter of a period apart."""

    name = "choreography_super_eight"
    title = "Choreography of four bodies: the super eight (no closed form; certified Taylor)"
    section = "8.9.2"
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
    rules = (Rule("no two bodies are at the same position", lambda n: are_apart(n, 4, "xy")),)
    default_span = "6.1"
    most_work = 50_000
    variants = (
        Variant("unequal", "masses that differ by a percent: the bodies leave the curve", {"m1": "1.01", "m2": "0.99"}),
    )
    invariants = conserved(energy=pair_energy, momentum_x=momentum_x, momentum_y=momentum_y, spin=spin_about_z)
    forms = (SecondOrder(pairs_attract), nbody(4, 2))
    scene = attracting(lambda p: p[1:], lambda r, p: p[0] / r**3, (0, 1))
    alike = alike_bodies(4, "xy")
    mirror = tuple(f"{name}{k}" for k in range(1, 5) for name in ("x", "vx"))

    @property
    def time_scale(self) -> float:
        """The time of a radian of the two bodies that are nearest at the start."""
        return shortest_radian(self.parameter_values(), self.initial_state, 2)
