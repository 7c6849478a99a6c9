"""Burrau's problem: three bodies of masses 3, 4, 5 fall from rest at the corners of a 3-4-5 triangle."""

from gnomon.cases.core import accuracy
from gnomon.cases.declare import *
from gnomon.cases.orbits.many_bodies import ManyBodies


class ThreeBodyPythagorean(ManyBodies, count=3):
    """Three bodies in a plane that fall together from rest, pass each other closely again and again, and part."""

    name = "three_body_pythagorean"
    title = "Pythagorean three-body problem: close encounters (no closed form; certified Taylor)"
    conventions = (
        "[inferred] Not in the book: C. Burrau, Astronomische Nachrichten 195 (1913) 113; V. Szebehely, C. F. Peters, The "
        "Astronomical Journal 72 (1967) 876. Each mass is opposite to the side of its length; at rest, the centre of mass at "
        "the origin, G = 1. Errors of each body's position and velocity are relative to their own size."
    )
    x1 = Coordinate("m", 1, typical(0.9, 1.1), group="length of body 1")
    y1 = Coordinate("m", 3, typical(2.9, 3.1), group="length of body 1")
    x2 = Coordinate("m", -2, typical(-2.1, -1.9), group="length of body 2")
    y2 = Coordinate("m", -1, typical(-1.1, -0.9), group="length of body 2")
    x3 = Coordinate("m", 1, typical(0.9, 1.1), group="length of body 3")
    y3 = Coordinate("m", -1, typical(-1.1, -0.9), group="length of body 3")
    vx1 = Coordinate("m/s", 0, typical(-0.2, 0.2), group="velocity of body 1")
    vy1 = Coordinate("m/s", 0, typical(-0.2, 0.2), group="velocity of body 1")
    vx2 = Coordinate("m/s", 0, typical(-0.2, 0.2), group="velocity of body 2")
    vy2 = Coordinate("m/s", 0, typical(-0.2, 0.2), group="velocity of body 2")
    vx3 = Coordinate("m/s", 0, typical(-0.2, 0.2), group="velocity of body 3")
    vy3 = Coordinate("m/s", 0, typical(-0.2, 0.2), group="velocity of body 3")
    G = Parameter("m^3/(kg s^2)", 1, "constant of gravitation", positive(0.8, 1.25))
    m1 = Parameter("kg", 3, "mass of body 1", positive(2.5, 3.5))
    m2 = Parameter("kg", 4, "mass of body 2", positive(3.5, 4.5))
    m3 = Parameter("kg", 5, "mass of body 3", positive(4.5, 5.5))
    default_span = "4.3"
    variants = (
        Variant(
            "third_encounter", "bodies 2 and 3 pass at 0.0085 m, from 3 m: two hundred times faster there", span="9.3"
        ),
    )

    def scales(self) -> dict[str, float]:
        """At the samples: the speeds have peaks at close encounters, far narrower than a grid spacing."""
        return accuracy.grid_scales(self, samples_alone=True)

    @property
    def time_scale(self) -> float:
        """Half of the time at the start: the bodies come closer as they fall."""
        return super().time_scale / 2
