"""Units of columns: a text as `deg/s`, `km/h` or `rpm` as a factor to SI, with its dimension."""

import math
import re
from collections.abc import Mapping
from typing import NamedTuple

from gnomon.harness.results.visible import shorten


class Unit(NamedTuple):
    """A factor to SI, and the powers of metre, second, kilogram and radian."""

    factor: float
    powers: tuple[float, float, float, float]


LENGTH, TIME, MASS, ANGLE, ONE = (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1), (0, 0, 0, 0)
G0 = 9.80665
"""Standard gravity (m/s^2)."""
UNITS: Mapping[str, Unit] = {
    **{name: Unit(factor, LENGTH) for name, factor in (
        ("m", 1.0), ("km", 1e3), ("cm", 1e-2), ("mm", 1e-3), ("um", 1e-6), ("ft", 0.3048), ("in", 0.0254),
        ("mi", 1609.344), ("nmi", 1852.0), ("au", 149597870700.0),
    )},
    **{name: Unit(factor, TIME) for name, factor in (
        ("s", 1.0), ("sec", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9), ("min", 60.0), ("h", 3600.0), ("d", 86400.0),
    )},
    **{name: Unit(factor, ANGLE) for name, factor in (
        ("rad", 1.0), ("mrad", 1e-3), ("deg", math.pi / 180), ("°", math.pi / 180), ("rev", 2 * math.pi),
        ("turn", 2 * math.pi), ("arcmin", math.pi / 10800), ("arcsec", math.pi / 648000),
    )},
    **{name: Unit(factor, MASS) for name, factor in (("kg", 1.0), ("lb", 0.45359237))},
    "1": Unit(1.0, ONE),
    "-": Unit(1.0, ONE),
    "%": Unit(1e-2, ONE),
    "rpm": Unit(2 * math.pi / 60, (0, -1, 0, 1)),
    "Hz": Unit(2 * math.pi, (0, -1, 0, 1)),
    "kn": Unit(1852 / 3600, (1, -1, 0, 0)),
    "mph": Unit(0.44704, (1, -1, 0, 0)),
    "g": Unit(G0, (1, -2, 0, 0)),
}  # fmt: skip
"""Each unit by its symbol. `g` is standard gravity; a gram would be 1e-3 kg."""
_FACTOR = re.compile(
    r"\s*(?P<by>[/*]?)\s*(?P<open>\(?)(?P<symbol>[A-Za-z°%]+|1|-)(?:\^?(?P<power>\([+-]?\d+/\d+\)|[+-]?\d+(?:\.\d+)?))?(?P<close>\)?)"
)
"""One factor of a unit: `/`, `*` or a space before it, a parenthesis, the symbol, its power."""
_NAMES = {"degrees": "deg", "degree": "deg", "radians": "rad", "radian": "rad", "seconds": "s", "second": "s",
          "metres": "m", "meters": "m", "metre": "m", "meter": "m", "feet": "ft", "hours": "h"}  # fmt: skip


def parse_unit(text: str) -> Unit:
    """The unit of a text such as `deg/s`, `km/h`, `m s^-1` or `m^(1/2)`. Raises ValueError for another text."""
    rest = text.strip().strip("[]").replace("·", "*").replace("**", "^").replace("²", "^2").replace("³", "^3")
    rest = rest[1:-1] if rest.startswith("(") and rest.endswith(")") else rest
    unit, sign, inside, place = Unit(1.0, ONE), 1.0, False, 0
    while place < len(rest):
        part = _FACTOR.match(rest, place)
        symbol = UNITS.get(_NAMES.get(part["symbol"].lower(), part["symbol"])) if part is not None else None
        if part is None or symbol is None:
            raise _unknown(text)
        if not inside:
            sign = -1.0 if part["by"] == "/" else 1.0
        inside = (inside or bool(part["open"])) and not part["close"]
        above, _, below = (part["power"] or "1").strip("()").partition("/")
        power = sign * float(above) / float(below or 1)
        powers = [a + power * b for a, b in zip(unit.powers, symbol.powers, strict=True)]
        unit = Unit(unit.factor * symbol.factor**power, (powers[0], powers[1], powers[2], powers[3]))
        place = part.end()
    if not rest:
        raise _unknown(text)
    return unit


def factor_to(text: str, wanted: str, what: str) -> float:
    """The factor from the unit `text` to the unit `wanted` of a coordinate. Raises ValueError if they do not fit."""
    stated, aim = parse_unit(text), parse_unit(wanted)
    without_angle = [tuple(unit.powers[:3]) for unit in (stated, aim)]
    angles = {unit.powers[3] for unit in (stated, aim)}
    fits = without_angle[0] == without_angle[1] and (len(angles) == 1 or text.strip() in ("1", "-", "1/s"))
    if not fits:
        raise ValueError(f"{what}: {shorten(text)} is not a unit of a number in {wanted}; give another unit")
    return stated.factor / aim.factor


def is_unit(text: str) -> bool:
    """Whether a text is a unit."""
    try:
        parse_unit(text)
    except ValueError:
        return False
    return True


def _unknown(text: str) -> ValueError:
    return ValueError(f"no unit is called {shorten(text)!r}; write one of {', '.join(UNITS)}, or joined as deg/s")
