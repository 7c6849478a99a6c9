"""Second derivation for Painleve's rod: two mass points kept on the plane, with the friction of the keeping force."""

from functools import partial
from typing import Any

import flint
from independent_mechanics import System, Vec, World, coefficient, cos, rate, sin, sqrt
from independent_models import model


def dragged(force: Any, w: World, p: Any, x: Any, y: Any, theta: Any) -> None:
    """Two halves of the mass at l/sqrt 3 on either side of the centre have the moment m l^2/3."""
    along = Vec((-cos(theta), sin(theta)))
    for side in (-1, 1):
        reach = p.l * (1 + side / sqrt(3 + 0 * p.l))
        w.mass(p.m / 2, Vec((x, y)) + along * reach, (0, -p.g))
    w.force((x, y), (-p.mu * force, 0 * force))
    w.keep(y)


def there(p: Any, s: Any) -> Any:
    return [s.x, 0, s.theta], [s.vx, 0, s.omega]


def back(p: Any, s: Any, q: Any) -> list[Any]:
    return [q[0], q[2], rate(q[0]), rate(q[2])]


@model("painleve_rod", there=there, back=back)
def painleve_rod(w: World, p: Any, *q: Any) -> None:
    """The normal force is linear in the one that friction belongs to; both are equal."""
    start, speeds = ([coefficient(x, k) for x in q] for k in (0, 1))
    none, one = (
        System(partial(dragged, flint.arb(force)), p, coefficient(w.t, 0), w.s, w.mode).accelerations(start, speeds)[1][
            0
        ]
        for force in (0, 1)
    )
    dragged(none / (1 + none - one), w, p, *q)
