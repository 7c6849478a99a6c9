"""Droplets in electric fields: the ink jet, and Millikan's oil drop.

Cases: ink_jet_printer, millikan_oil_drop.
"""

from dataclasses import replace

from gnomon.cases.declare import *
from gnomon.cases.scenes.point import free_point, railed_point
from gnomon.reference.flight.droplets import InkJet, OilDrop
from gnomon.reference.numerics.precision import exact
from mpmath import mpf


def between_plates(t: Any, state: Values, parameters: Values) -> Values:
    """r'' = (0, (q/m) E) - nu r'."""
    _x, _y, vx, vy = state
    q_m, field, _plates, _gap, nu = parameters
    return vx, vy, -nu * vx, q_m * field - nu * vy


def behind_plates(t: Any, state: Values, parameters: Values) -> Values:
    _x, _y, vx, vy = state
    nu = parameters[4]
    return vx, vy, -nu * vx, -nu * vy


def on_paper(t: Any, state: Values, parameters: Values) -> Values:
    return 0, 0, 0, 0


def end_of_plates(t: Any, state: Values, parameters: Values) -> Values:
    _q_m, _field, plates, _gap, _nu = parameters
    return (state[0] - plates,)


def paper(t: Any, state: Values, parameters: Values) -> Values:
    _q_m, _field, plates, gap, _nu = parameters
    return (state[0] - plates - gap,)


def at_plates_end(t: Any, state: Values, parameters: Values) -> Values:
    _q_m, _field, plates, _gap, _nu = parameters
    return plates, state[1], state[2], state[3]


def dried(t: Any, state: Values, parameters: Values) -> Values:
    _q_m, _field, plates, gap, _nu = parameters
    return plates + gap, state[1], 0, 0


def jet_mode(t: Any, state: Values, parameters: Values) -> str:
    x = exact(state[0])
    _q_m, _field, plates, gap, _nu = map(exact, parameters[:5])
    if x < plates:
        return "plates"
    return "flight" if x < plates + gap else "paper"


def jet_rates(t: float, state: Values, parameters: Values) -> Values:
    """The acceleration between and behind the plates, for the force of a scene."""
    return (between_plates if state[0] < parameters[2] else behind_plates)(t, state, parameters)


def jet_scene() -> tuple[SceneForm, SceneForm]:
    """Scenes of the flight alone, and of the flight to the paper (at x = 0 in the scene), to which the drop sticks."""
    plain = free_point(jet_rates, (0, 1))

    def build(state: Values, parameters: Values) -> Scene:
        scene = plain.build(state, parameters)
        reach = parameters[2] + parameters[3]
        (drop,), (force,) = scene.bodies, scene.forces

        def push(t: float, place: Vector, velocity: Vector) -> Vector:
            return force.law(t, (place[0] + reach, *place[1:]), velocity)

        x, y, z = drop.position
        return replace(
            scene,
            bodies=(replace(drop, position=(x - reach, y, z), radius=0.0),),
            forces=(replace(force, law=push),),
            contacts=(Contact("point", (-1.0, 0.0, 0.0), adhesive=True),),
        )

    def observe(readings: Readings, parameters: Values) -> Values:
        x, *others = plain.observe(readings, parameters)
        return (x + parameters[2] + parameters[3], *others)

    return plain, SceneForm(build, observe, plain.needs | {"adhesive_contact"}, conservative=False)


FLIGHT_SCENE, PAPER_SCENE = jet_scene()


class InkJetPrinter(Case):
    name = "ink_jet_printer"
    title = "Ink drop between deflecting plates, then free flight to the paper"
    section = "6.3.3"
    conventions = "x along the jet, y across; no gravity; Stokes drag nu v per unit mass; the paper stops the drop."
    x = Coordinate("m", 0, typical(0, 0.4))
    y = Coordinate("m", 0, typical(-1, 1), group="deflection")
    vx = Coordinate("m/s", 18, positive(0.5, 5))
    vy = Coordinate("m/s", 0, typical(-1, 1), group="deflecting velocity")
    q_m = Parameter("C/kg", "1.5e-3", "charge over mass", typical(-2, 2))
    E = Parameter("V/m", 1_400_000, "field between the plates", typical(-2, 2))
    l = Parameter("m", "0.016", "length of the plates", positive(0.5, 3))
    D = Parameter("m", "0.01", "distance from the plates to the paper", positive(0.5, 3))
    nu = Parameter("1/s", 0, "drag over mass and speed", nonnegative(0, 2))
    rules = (Rule("the drop starts before the paper (x < l + D)", lambda n: n["x"] < n["l"] + n["D"]),)
    exact_motion = bind(lambda c: InkJet(c.q_m * c.E, c.l, c.l + c.D, c.nu, *c.initial_state))
    variants = (
        Variant("drag", "air slows the drop in flight", {"nu": 400}),
        Variant("stopped_by_air", "drag stops the drop before the paper: no second event", {"nu": 1000}, span="0.0071"),
        Variant("weak_drag", "nu = 1e-9: the logarithms for the event times cancel", {"nu": "1e-9"}),
    )
    forms = (
        Hybrid(
            modes=(Mode("plates", between_plates), Mode("flight", behind_plates), Mode("paper", on_paper)),
            start=jet_mode,
            transitions=(
                Transition("leaves", "plates", end_of_plates, 1, at_plates_end, "flight"),
                Transition("lands", "flight", paper, 1, dried, "paper"),
            ),
            terminal=frozenset({"paper"}),
        ),
    )

    @property
    def scene(self) -> SceneForm:
        return PAPER_SCENE if self.exact_motion.reaches(self.exact_motion.paper) else FLIGHT_SCENE

    @property
    def time_scale(self) -> float:
        """The time of the flight to the paper without drag."""
        way = self.l + self.D - self.x
        return float(way / self.vx)

    def natural_span(self) -> Number:
        """1.25 times the flight to the paper; three times that without drag if the drop does not arrive."""
        motion = self.exact_motion
        return 1.27 * float(motion.time_at(motion.paper)) if motion.reaches(motion.paper) else 3.1 * self.time_scale

    def list_events(self, digits: int) -> tuple[Event, ...]:
        """`leaves` the plates, `lands` on the paper."""
        motion, events = self.exact_motion, list[Event]()
        for name, place in (("leaves", motion.plates), ("lands", motion.paper)):
            if motion.x >= place or not motion.reaches(place) or motion.time_at(place, 20) > self.span:
                continue
            before = motion.crossing(place, digits)
            after = before if name == "leaves" else (*before[:2], mpf(0), mpf(0))
            events.append(Event(motion.time_at(place, digits), name, before, after))
        return tuple(events)

    def same_course(self, other: Case) -> bool:
        q_m, field, plates, gap, nu = other.parameter_values()
        theirs, mine = InkJet(q_m * field, plates, plates + gap, nu, *other.initial_state), self.exact_motion
        return all(
            theirs.reaches(a) == mine.reaches(b) for a, b in ((theirs.plates, mine.plates), (theirs.paper, mine.paper))
        )

    def derived(self, digits: int) -> dict[str, Any]:
        """`deflection`: y on the paper (m); without drag q E l (l/2 + D)/(m v^2)."""
        motion, paper = self.exact_motion, self.exact_motion.paper
        if not motion.reaches(paper):
            return {}
        return {"landing_time": motion.time_at(paper, digits), "deflection": motion.crossing(paper, digits)[1]}


def oil_drop_equations(t: Any, state: Values, parameters: Values) -> Values:
    """v' = -g (1 - rho_air/rho) + q E/m - v/tau, m = 4 pi a^3 rho/3, 1/tau = 9 eta/(2 a^2 rho)."""
    _y, v = state
    g, a, rho, rho_air, eta, q, field = parameters
    pi = 4 * atan(1)
    mass = 4 * pi * a * a * a * rho / 3
    return v, -g * (1 - rho_air / rho) + q * field / mass - 9 * eta / (2 * a * a * rho) * v


def oil_drop_matrix(parameters: Values) -> Values:
    _g, a, rho, _rho_air, eta, _q, _field = parameters
    return 0, 1, 0, -9 * eta / (2 * a * a * rho)


def oil_drop_load(t: Any, state: Values, parameters: Values) -> Values:
    g, a, rho, rho_air, _eta, q, field = parameters
    pi = 4 * atan(1)
    return 0, -g * (1 - rho_air / rho) + q * field / (4 * pi * a * a * a * rho / 3)


DROP_SCENE = railed_point(oil_drop_equations)


class MillikanOilDrop(Case):
    name = "millikan_oil_drop"
    title = "Millikan's oil drop: gravity, buoyancy, Stokes drag and a field"
    section = "6.5"
    conventions = "y upward; q E > 0 lifts the drop; no slip correction, no added mass."
    y = Coordinate("m", 0)
    v = Coordinate("m/s", 0)
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    a = Parameter("m", "1e-6", "radius of the drop", positive())
    rho = Parameter("kg/m^3", 886, "density of the oil", positive())
    rho_air = Parameter("kg/m^3", "1.2", "density of the air", nonnegative(0, 1))
    eta = Parameter("Pa s", "1.8e-5", "viscosity of the air", positive())
    q = Parameter("C", "8.01e-19", "charge: five elementary charges", typical(-2, 2))
    E = Parameter("V/m", 100_000, "field", typical(-2, 2))
    exact_motion = bind(
        lambda c: OilDrop(
            9 * c.eta / (2 * c.a**2 * c.rho),
            (-c.g * (1 - c.rho_air / c.rho),),
            (c.y,),
            (c.v,),
            3 * c.q * c.E / (4 * c.a**3 * c.rho),
        )
    )
    default_span = Span(20.7, "time scale")
    quantity_names = ("relaxation_time", "falling_speed", "rising_speed")
    variants = (
        Variant("no_field", "falls to its limiting speed", {"E": 0}),
        Variant("stiff", "100 s with a relaxation time of 1e-5 s: seven decades apart", span=100),
        Variant("balanced", "the field nearly carries the drop: a difference of large forces", {"E": "45401.5"}),
    )
    forms = (SemiLinear(oil_drop_equations, linear=oil_drop_matrix, rest=oil_drop_load),)
    scene = DROP_SCENE

    @property
    def time_scale(self) -> float:
        """The relaxation time m/(6 pi eta a)."""
        return 1 / float(self.exact_motion.nu)

    def derived(self, digits: int) -> dict[str, Any]:
        """`charge` by Millikan's formula from the two limiting speeds, which is the parameter q."""
        return {"charge": self.exact_motion.charge(self.a, self.eta, self.E, digits) if self.E else None}
