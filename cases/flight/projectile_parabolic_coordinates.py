"""Lagrange's equations of a projectile in parabolic coordinates, in which its Hamilton-Jacobi equation separates."""

import numpy as np
from gnomon.cases.core import accuracy
from gnomon.cases.declare import *
from gnomon.reference.flight.projectile_parabolic_coordinates import ParabolicProjectile


def parabolic_equations(t: Any, state: Values, parameters: Values) -> Values:
    """The equations of L = (xi^2 + eta^2)(xi'^2 + eta'^2)/2 - g (eta^2 - xi^2)/2."""
    xi, eta, u, v = state
    (g,) = parameters
    share, excess = xi * xi + eta * eta, v * v - u * u
    return u, v, (xi * (excess + g) - 2 * eta * u * v) / share, -(eta * (excess + g) + 2 * xi * u * v) / share


def parabolic_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Per unit mass."""
    xi, eta, u, v = state
    (g,) = parameters
    return ((xi * xi + eta * eta) * (u * u + v * v) / 2 + g * (eta * eta - xi * xi) / 2,)


def momentum_across(t: Any, state: Values, parameters: Values) -> Values:
    """x' = (xi eta)'."""
    xi, eta, u, v = state
    return (xi * v + eta * u,)


def separation(t: Any, state: Values, parameters: Values) -> Values:
    """Twice the constant of separation: (p_xi^2 eta^2 - p_eta^2 xi^2)/(xi^2 + eta^2) - g xi^2 eta^2."""
    xi, eta, u, v = state
    (g,) = parameters
    share = xi * xi + eta * eta
    return (share * (eta * eta * u * u - xi * xi * v * v) - g * xi * xi * eta * eta,)


def _misses_the_focus(n: Mapping[str, Fraction]) -> bool:
    return ParabolicProjectile(n["g"], n["xi"], n["eta"], n["xi_rate"], n["eta_rate"]).crossing() != 0


class ProjectileInParabolicCoordinates(Case):
    """No scene: a position determines xi and eta except for their common sign, which depends on the path."""

    name = "projectile_parabolic_coordinates"
    title = "Projectile in parabolic coordinates"
    section = "11.3-11.8"
    conventions = (
        "x = xi eta horizontal, y = (eta^2 - xi^2)/2 upward; lines of constant xi or eta are parabolas with the focus at "
        "the origin, where the coordinates are singular. xi and eta are continuous in time and change their signs."
    )
    xi = Coordinate("m^(1/2)", -2, typical(-3, 3))
    eta = Coordinate("m^(1/2)", 3, typical(-3, 3))
    xi_rate = Coordinate("m^(1/2)/s", "1.5", typical(-3, 3))
    eta_rate = Coordinate("m^(1/2)/s", "0.5", typical(-3, 3))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", nonnegative(0, 20))
    rules = (Rule("the path misses the focus, x = y = 0", _misses_the_focus),)
    exact_motion = bind(ParabolicProjectile)
    default_span = "2.7"
    variants = (
        Variant(
            "confocal",
            "the path and the coordinates have one focus: eta is exactly constant",
            {"g": 4},
            (0, 1, 2, 0),
        ),
        Variant(
            "above_focus",
            "passes 1e-6 m above the focus: xi changes its sign within a microsecond",
            {"g": 8},
            (-1, 1, "2.000001", "1e-6"),
            "1.3",
        ),
        Variant("below_focus", "the path passes below the focus: eta changes its sign", {"g": 10}, (2, 1, -1, -2)),
        Variant("far", "1e8 m away: the terms of xi'' and eta'' nearly cancel", {}, (10**4, 10**4, 1, 2)),
    )
    invariants = conserved(energy=parabolic_energy, horizontal_momentum=momentum_across, separation=separation)
    forms = (FirstOrder(parabolic_equations),)
    reversal = ("xi_rate", "eta_rate")

    @property
    def time_scale(self) -> float:
        """The time in which gravity changes the velocity by the speed, or in which the body moves as far as the focus is."""
        flight = self.exact_motion.projectile()
        g, speed, away = float(flight.g), hypot(float(flight.vx), float(flight.vy)), self._away(Fraction(0))
        if not speed:
            return sqrt(away / g) if g else float(self.span)
        return min(away / speed, speed / g) if g else away / speed

    @property
    def fastest_time(self) -> float:
        """The least distance from the focus over the speed there, if the path passes close to it."""
        return min([self.time_scale, *(self._away(t) / self._speed(t) for t in self._nearest())])

    def _away(self, t: Number) -> float:
        x, y, _, _ = self.exact_motion.projectile().rational(t)
        return hypot(float(x), float(y))

    def _speed(self, t: Number) -> float:
        _, _, vx, vy = self.exact_motion.projectile().rational(t)
        return hypot(float(vx), float(vy))

    def _nearest(self) -> list[float]:
        """Times in the span at which the distance from the focus is extremal (s)."""
        f = self.exact_motion.projectile()
        x, y, vx, vy, g = map(float, (f.x, f.y, f.vx, f.vy, f.g))
        slope = np.roots([g * g / 2, -1.5 * g * vy, vx * vx + vy * vy - g * y, x * vx + y * vy])
        return [float(t.real) for t in slope if abs(t.imag) < 1e-6 * abs(t) and 0 < t.real < float(self.span)]

    def scales(self) -> dict[str, float]:
        """On a grid, and closest to the focus, where the rates have a peak that may be narrower than the grid spacing."""
        scales = accuracy.grid_scales(self)
        for t in self._nearest():
            xi, eta, u, v = map(float, self.exact(t))
            scales["length"] = max(scales["length"], hypot(xi, eta))
            scales["velocity"] = max(scales["velocity"], hypot(u, v))
        return scales

    def derived(self, digits: int) -> dict[str, Any]:
        """`crossing`: y where the path crosses the vertical x = 0 through the focus (m)."""
        return {"crossing": self.exact_motion.crossing()}
