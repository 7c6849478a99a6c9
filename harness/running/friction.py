"""The modes of a body that slides with dry friction, or sticks, from its acceleration and the bounds of friction."""

from collections.abc import Callable, Sequence
from numbers import Real
from typing import Any

from gnomon.cases.core.forms import Friction, Mode, Transition, Values
from gnomon.harness.kernels.read_function import NoFormulasError, formulas
from gnomon.harness.running.call_watch import place

Number = float | Callable[..., Any]
"""A number, or a function of (t, y, *args) that returns one."""

MORE = 1 + 2.0**-40
"""A body begins to slide at MORE times its static friction: at exactly the kinetic friction round-off would have the sign
of its first acceleration, and could stop it again at once."""


def sliding_friction(
    acceleration: Number, kinetic: Number, static: Number | None = None, args: Sequence[Any] = ()
) -> Friction:
    """State a body on a line with dry friction: it slides to the right, slides to the left, or sticks.

    `sign(v)` in a right-hand side makes the steps of every method collapse once the body sticks. Here a method with events,
    such as `gnomon:DOP853 [events]`, locates the end of sliding and of sticking, and each mode is smooth. The state is
    (x, v).

    Parameters
    ----------
    acceleration : callable or float
        ``acceleration(t, y, *args)``: the force without friction over the mass, from formulas without a branch.
    kinetic : callable or float
        The friction of sliding over the mass, at least 0: mu g on a plane. It may depend on (t, y, *args) too.
    static : callable or float, optional
        The largest friction of sticking over the mass, at least `kinetic`; by default `kinetic`.
    args : tuple, optional
        Further arguments of the functions.

    Returns
    -------
    Friction
        The form for `gnomon.solve`.

    Raises
    ------
    ValueError
        For a negative bound, for `static` below `kinetic`, and for a function without formulas.

    Examples
    --------
    >>> import gnomon
    >>> block = gnomon.sliding_friction(lambda t, y: -9 * y[0], kinetic=1.0, static=1.5)
    >>> found = gnomon.solve(block, (0, 10), [2.0, 0.0], "gnomon:DOP853 [events]")
    >>> found.y[:, -1].round(6) + 0.0  # nine half oscillations, each shorter by 2/9 m than the last
    array([0., 0.])
    """
    static = kinetic if static is None else static
    for name, value in (("kinetic", kinetic), ("static", static)):
        if isinstance(value, Real) and not 0 <= value < float("inf"):  # type: ignore[operator]
            raise ValueError(f"{name}={value!r}: give friction over mass, a number from 0")
    if isinstance(kinetic, Real) and isinstance(static, Real) and static < kinetic:  # type: ignore[operator]
        raise ValueError(
            f"static={static!r} is below kinetic={kinetic!r}: a body that has just stopped would not stick"
        )
    push, brake, hold = (_formula(value, args) for value in (acceleration, kinetic, static))

    def sliding(t: Any, state: Values, parameters: Values) -> Values:
        return state[1], push(t, state, ())[0] - parameters[-1] * brake(t, state, ())[0]

    def sticking(t: Any, state: Values, parameters: Values) -> Values:
        return 0, 0

    def speed(t: Any, state: Values, parameters: Values) -> Values:
        return (state[1],)

    def stop(t: Any, state: Values, parameters: Values) -> Values:
        return state[0], 0

    def stay(t: Any, state: Values, parameters: Values) -> Values:
        return state

    def to_the_right(t: Any, state: Values, parameters: Values) -> Values:
        return (push(t, state, ())[0] - MORE * hold(t, state, ())[0],)

    def to_the_left(t: Any, state: Values, parameters: Values) -> Values:
        return (push(t, state, ())[0] + MORE * hold(t, state, ())[0],)

    def bounds(t: Any, state: Values, parameters: Values) -> Values:
        return brake(t, state, ())[0], hold(t, state, ())[0]

    def at_rest(t: Any, state: Values, parameters: Values) -> str:
        if to_the_right(t, state, ())[0] > 0:
            return "right"
        return "left" if to_the_left(t, state, ())[0] < 0 else "stick"

    def start(t: Any, state: Values, parameters: Values) -> str:
        if state[1] == 0:
            return at_rest(t, state, parameters)
        return "right" if state[1] > 0 else "left"

    return Friction(
        modes=(Mode("right", sliding, (1.0,)), Mode("left", sliding, (-1.0,)), Mode("stick", sticking)),
        start=start,
        transitions=(
            Transition("stop from the right", "right", speed, -1, stop, at_rest),
            Transition("stop from the left", "left", speed, 1, stop, at_rest),
            Transition("slip to the right", "stick", to_the_right, 1, stay, "right"),
            Transition("slip to the left", "stick", to_the_left, -1, stay, "left"),
        ),
        settle=0.0,
        sliding=sliding,
        bounds=bounds,
    )


def _formula(value: Number, args: Sequence[Any]) -> Callable[..., Any]:
    """The value as a function of (t, state, parameters) that gives a tuple of one number."""
    function: Callable[..., Any] = value if callable(value) else lambda t, y, *_: value

    def bound(function: Callable[..., Any]) -> Callable[..., Any]:
        return lambda t, state, parameters: function(t, state, *args)

    try:
        return formulas(function, bound, "friction", (2, 0, 1))
    except NoFormulasError as error:
        raise ValueError(f"{place(function)} has no formulas ({str(error)[:160]}); write it as one") from None
