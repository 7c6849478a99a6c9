"""The chain of Fermi, Pasta, Ulam and Tsingou with stiff linear springs between soft quartic ones."""

from gnomon.cases.declare import *


def soft_springs(q: Values, parameters: Values) -> Values:
    """The stretch of the four soft springs from q = (q1, q2, q3, s1, s2, s3), each times sqrt(2)."""
    q1, q2, q3, s1, s2, s3 = q
    return q1 - s1, q2 - s2 - q1 - s1, q3 - s3 - q2 - s2, q3 + s3


def soft_pull(t: Any, q: Values, parameters: Values) -> Values:
    """Minus the gradient of the quartic energy."""
    b, _w = parameters
    c0, c1, c2, c3 = (b * d * d * d for d in soft_springs(q, parameters))
    return c1 - c0, c2 - c1, -c2 - c3, c0 + c1, c1 + c2, c2 - c3


def fermi_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    _q1, _q2, _q3, s1, s2, s3 = q
    _b, w = parameters
    a1, a2, a3, e1, e2, e3 = soft_pull(t, q, parameters)
    return a1, a2, a3, e1 - w * w * s1, e2 - w * w * s2, e3 - w * w * s3


def fermi_potential(t: Any, q: Values, parameters: Values) -> Values:
    _q1, _q2, _q3, s1, s2, s3 = q
    b, w = parameters
    d0, d1, d2, d3 = (d * d for d in soft_springs(q, parameters))
    return (w * w * (s1 * s1 + s2 * s2 + s3 * s3) / 2 + b * (d0 * d0 + d1 * d1 + d2 * d2 + d3 * d3) / 4,)


def fermi_equations(t: Any, state: Values, parameters: Values) -> Values:
    return (*state[6:], *fermi_acceleration(t, state[:6], parameters))


def fermi_matrix(parameters: Values) -> Values:
    """Uniform motion of the slow coordinates, harmonic vibration of the stiff springs."""
    _b, w = parameters
    rows = [[0] * 12 for _ in range(12)]
    for i in range(6):
        rows[i][6 + i] = 1
    for i in range(3, 6):
        rows[6 + i][i] = -w * w
    return tuple(entry for row in rows for entry in row)


def fermi_rest(t: Any, state: Values, parameters: Values) -> Values:
    return (0, 0, 0, 0, 0, 0, *soft_pull(t, state[:6], parameters))


def fermi_energy(t: Any, state: Values, parameters: Values) -> Values:
    kinetic = sum(v * v for v in state[6:]) / 2
    return (kinetic + fermi_potential(t, state[:6], parameters)[0],)


def stiff_energies(state: Values, parameters: Values) -> Values:
    """I_1, I_2, I_3: the energies of the stiff springs. Their sum is an adiabatic invariant; they exchange it."""
    _b, w = parameters
    return tuple((state[9 + i] * state[9 + i] + w * w * state[3 + i] * state[3 + i]) / 2 for i in range(3))


class FermiPastaUlam(IntegratedCase):
    """Six unit masses between walls: soft, stiff, soft, stiff, soft, stiff, soft."""

    name = "fermi_pasta_ulam"
    title = "Fermi-Pasta-Ulam-Tsingou chain with stiff springs (no closed form; certified Taylor)"
    section = "6.18"
    conventions = (
        "[inferred] Hairer, Lubich and Wanner, Geometric Numerical Integration, I.5.1 and XIII: q_i = (x_2i + x_(2i-1))/"
        "sqrt 2 and s_i = (x_2i - x_(2i-1))/sqrt 2 of the displacements x; stiff springs of energy w^2 s^2/2, soft ones "
        "of energy b d^4/4, with d the stretch times sqrt 2. Numbers as there: q1 = 1, v1 = 1, s1 = 1/w, u1 = 1."
    )
    q1 = Coordinate("m", 1, typical(-1, 1))
    q2 = Coordinate("m", 0, typical(-1, 1))
    q3 = Coordinate("m", 0, typical(-1, 1))
    s1 = Coordinate("m", "0.02", typical(-0.1, 0.1))
    s2 = Coordinate("m", 0, typical(-0.1, 0.1))
    s3 = Coordinate("m", 0, typical(-0.1, 0.1))
    v1 = Coordinate("m/s", 1, typical(-1, 1))
    v2 = Coordinate("m/s", 0, typical(-1, 1))
    v3 = Coordinate("m/s", 0, typical(-1, 1))
    u1 = Coordinate("m/s", 1, typical(-1, 1))
    u2 = Coordinate("m/s", 0, typical(-1, 1))
    u3 = Coordinate("m/s", 0, typical(-1, 1))
    b = Parameter("1/(m^2 s^2)", 1, "strength of the soft springs", positive(0.5, 2))
    w = Parameter("rad/s", 50, "frequency of the stiff springs", positive(8, 50))
    default_span = "2.03"
    variants = (
        Variant(
            "exchange",
            "w = 10: energy passes from the first stiff spring to the third",
            {"w": 10},
            (1, 0, 0, "0.1", 0, 0, 1, 0, 0, 1, 0, 0),
            "19.9",
        ),
        Variant(
            "omega_200",
            "stiff springs of frequency 200",
            {"w": 200},
            (1, 0, 0, "0.005", 0, 0, 1, 0, 0, 1, 0, 0),
            "1.03",
        ),
        Variant(
            "omega_1000",
            "stiff springs of frequency 1000",
            {"w": 1000},
            (1, 0, 0, "0.001", 0, 0, 1, 0, 0, 1, 0, 0),
            "0.203",
        ),
    )
    invariants = conserved(energy=fermi_energy)
    forms = (
        Separable(fermi_acceleration, fermi_potential),
        SemiLinear(fermi_equations, linear=fermi_matrix, rest=fermi_rest),
    )
    mirror = ("q1", "q2", "q3", "s1", "s2", "s3", "v1", "v2", "v3", "u1", "u2", "u3")

    @property
    def time_scale(self) -> float:
        """The shortest that the motion shows: one radian of the stiff springs."""
        return 1 / float(self.w)

    def derived(self, digits: int) -> dict[str, Any]:
        """The energies of the three stiff springs at the end, and their sum at the start (m^2/s^2)."""
        parameters = self.parameter_values()
        end = self.exact(self.span, digits + 3)
        names = ("stiff_energy_1", "stiff_energy_2", "stiff_energy_3")

        def energy(i: int) -> Any:
            return lambda mp: stiff_energies(tuple(map(mp.mpf, end)), tuple(map(mp.mpf, parameters)))[i]

        return {name: energy(i) for i, name in enumerate(names)} | {
            "stiff_energy": sum(stiff_energies(self.initial_state, parameters), Fraction(0))
        }
