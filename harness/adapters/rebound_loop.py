"""The loop over samples that drives REBOUND by its C interface, compiled once for all problems.

It calls the functions behind `Simulation.steps`, `synchronize` and `integrate`, and copies numbers from REBOUND's own
memory. Python is entered once for a motion, as reading an attribute takes 1 us, and a call of a method 2 us.

`integrate` replaces the handler of SIGINT: afterwards Ctrl-C does nothing. The old handler is put back.
"""

import ctypes
import signal
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from typing import Any, NamedTuple

from gnomon.harness.contract.integrator import Floats
from gnomon.harness.kernels import machine
from gnomon.harness.kernels.c_structures import floats_at, result_at, run_at, word_at

INTERRUPTED = 6
"""The status REB_STATUS_SIGINT. A status above 0 ends a motion early."""


class Layout(NamedTuple):
    """Where the numbers of a sample are: rows of `width` numbers, each from its number `first` on.

    REBOUND keeps the address of the rows at the address `pointer`, and may change it in a step.
    """

    pointer: int
    width: int
    first: int = 0


def take_steps(advance: int, synchronize: int, simulation: int, count: float) -> int:
    """Take `count` steps, then synchronize positions and velocities to one time; `advance` and `synchronize` are addresses."""
    status = result_at(advance, simulation, int(count))
    run_at(synchronize, simulation)
    return int(status)


def integrate_to(advance: int, synchronize: int, simulation: int, time: float) -> int:
    """Integrate to this time, where the last step ends."""
    return int(result_at(advance, simulation, time))


move = integrate_to


def follow(
    advance: int, synchronize: int, simulation: int, pointer: int, width: int, first: int, ends: Floats, samples: Floats
) -> int:
    """Advance to each sample, and copy its numbers into `samples` (samples, rows, numbers); returns the last status."""
    for k in range(ends.size):
        status = move(advance, synchronize, simulation, ends[k])
        if status > 0:
            return status
        numbers = floats_at(word_at(pointer, 0), width * samples.shape[1])
        for i in range(samples.shape[1]):
            for j in range(samples.shape[2]):
                samples[k, i, j] = numbers[width * i + first + j]
    return 0


def follower(simulation: Any, ends: Floats, layout: Layout, by_steps: bool = False) -> Callable[[Floats], str | None]:
    """The function that runs a simulation through all samples, into an array (samples, rows, numbers).

    It returns the reason for an early end, or None. `ends`: the times of samples, or numbers of steps if `by_steps`.
    """
    import rebound  # only with the library is there a simulation

    library = rebound.clibrebound
    advance = library.reb_simulation_steps if by_steps else library.reb_simulation_integrate
    called = [ctypes.cast(each, ctypes.c_void_p).value for each in (advance, library.reb_simulation_synchronize)]
    arguments = *called, ctypes.addressof(simulation), *layout
    run = machine.function(
        follow,
        "int int int int int int float[1] float[3]",
        replaced={"move": take_steps if by_steps else integrate_to},
    )

    def through(samples: Floats) -> str | None:
        with nullcontext() if by_steps else interrupt_kept():
            status = run(*arguments, ends, samples)
        if status == INTERRUPTED:
            raise KeyboardInterrupt
        try:
            simulation.process_messages()  # warnings, and the error behind a status
        except RuntimeError as error:
            return f"{error} at t = {simulation.t:g}"
        return f"status {status} at t = {simulation.t:g}" if status > 0 else None

    return through


def restarter(simulation: Any, engine: str, options: Mapping[str, float]) -> Callable[[], None]:
    """The function that sets the integrator of a simulation again, which clears its state, and then its options.

    It writes each option into the memory of REBOUND's state, at the offset that REBOUND's table of fields gives: setting an
    attribute of Python would search that table each time, which takes 4 us.
    """
    import rebound
    from rebound.binarydata_field_descriptor import REB_BINARYDATA_DTYPE as TYPES

    name, place = engine.encode(), ctypes.byref(simulation)
    simulation.integrator = engine
    fields = simulation.integrator.callbacks.field_descriptor_list
    descriptors = [(fields.field_descriptor_for_name(option), value) for option, value in options.items()]
    places = [(TYPES[field.dtype], field.offset, value) for field, value in descriptors]

    def restart() -> None:
        rebound.clibrebound.reb_simulation_set_integrator(place, name)
        state = simulation.integrator.state
        for kind, offset, value in places:
            kind.from_address(state + offset).value = value

    return restart


@contextmanager
def interrupt_kept() -> Iterator[None]:
    """Put back the handler of SIGINT that REBOUND replaces (only the main thread may)."""
    handler = signal.getsignal(signal.SIGINT)
    try:
        yield
    finally:
        if threading.current_thread() is threading.main_thread():
            signal.signal(signal.SIGINT, handler)
