"""The forces of a scene as a C function that MuJoCo calls at each stage.

MuJoCo's manual warns that callbacks in Python are "likely to incur a severe performance impact", and takes a C function
instead. The laws of a scene are compiled together as one function of the time and of the motions of bodies. A law that
can be neither traced nor emitted from its source stays a function of Python, which the engine calls at each stage.

`passive` is compiled once. It finds the table of a world, whose words are listed below, by a number of the model, which no
reset of the state changes, and reads the places of bodies in the engine's own arrays.
"""

import ctypes
import itertools
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from gnomon.cases.core.scene import Scene
from gnomon.harness.adapters.engines.compiled_laws import Law, Laws, compile_laws
from gnomon.harness.adapters.engines.scene_run import LOAD, MOTION
from gnomon.harness.kernels.c_structures import c_functions, floats_at, run_at, word_at

TIME, NUMERIC = 0, 0
"""The word of MuJoCo's data that is its time, and the word of its model that is the address of `numeric_data`, once the
library is loaded."""
VELOCITY, APPLY, FRAME, PLACES, TURNS, TARGET, LAWS, NUMBERS, MOTIONS, LOADS, BODIES, JOINTS, ROWS = range(13)
"""The words of a table: the addresses of `mj_objectVelocity` and `mj_applyFT`, the frame of its velocities, the addresses of
`xpos`, `xquat` and `qfrc_passive`, of the compiled laws, of their numbers, of the motions and of the loads, the numbers of
bodies and of prescribed joints, and then the index of each body and of each joint's rate."""


def passive(model: Any, data: Any) -> int:
    """Add the forces of a scene at the time and in the state of a stage."""
    table = word_at(word_at(model, NUMERIC), 0)
    bodies, motions, loads = word_at(table, BODIES), word_at(table, MOTIONS), word_at(table, LOADS)
    for k in range(bodies):
        body, motion = word_at(table, ROWS + k), motions + 8 * MOTION * k
        run_at(word_at(table, VELOCITY), model, data, word_at(table, FRAME), body, motion, 0)
        copy(word_at(table, PLACES) + 24 * body, motion + 48, 3)
        copy(word_at(table, TURNS) + 32 * body, motion + 72, 4)
    run_at(word_at(table, LAWS), floats_at(data + 8 * TIME, 1)[0], motions, word_at(table, NUMBERS), loads)
    target = word_at(table, TARGET)
    for k in range(bodies):
        body, load = word_at(table, ROWS + k), loads + 8 * LOAD * k
        place = motions + 8 * MOTION * k + 48
        run_at(word_at(table, APPLY), model, data, load, load + 24, place, body, target)
    drives = loads + 8 * LOAD * bodies
    for k in range(word_at(table, JOINTS)):
        rate = word_at(table, ROWS + bodies + k)
        floats_at(target, rate + 1)[rate] += floats_at(drives, k + 1)[k]
    return 0


def copy(source: Any, target: Any, size: int) -> None:
    numbers, places = floats_at(source, size), floats_at(target, size)
    for i in range(size):
        places[i] = numbers[i]


def time_function(
    laws: Sequence[Law], driven: Callable[[Law, Any], Sequence[Any]]
) -> Callable[[float], Sequence[float]]:
    """The function of time that computes the numbers `driven(law, t)` of all laws, compiled if they can be traced."""
    compiled = compile_laws(Scene((0.0, 0.0, 0.0), ()), laws, driven)
    if compiled is None:
        return lambda t: [value for law in laws for value in driven(law, t)]
    array, numbers, nothing = compiled.kernel.array, compiled.numbers, np.zeros(0)
    return lambda t: array(t, nothing, numbers).tolist()  # type: ignore[no-any-return]


class CompiledForces:
    """The C function of the forces of a scene in a world, and the memory that it uses.

    `rates`: the first rates of the prescribed joints, in the sequence of their laws.
    """

    def __init__(self, mujoco: Any, model: Any, data: Any, laws: Laws, rates: Sequence[int]) -> None:
        motions, _, loads = (np.zeros(size + 1) for size in laws.kernel.sizes)
        arrays = data.xpos, data.xquat, data.qfrc_passive
        self.held = laws, motions, loads  # C holds their addresses
        self.table = np.array([
            *functions(mujoco), int(mujoco.mjtObj.mjOBJ_XBODY), *(array.ctypes.data for array in arrays),
            laws.kernel.address, *(array.ctypes.data for array in (laws.numbers, motions, loads)),
            len(laws.bodies), len(rates), *(model.body(name).id for name in laws.bodies), *rates,
        ])  # fmt: skip
        model.numeric_data.view(np.int64)[0] = self.table.ctypes.data
        self.pointer = POINTER(c_functions(((passive, "int int"),), words_of(mujoco))["passive"])


@cache
def functions(mujoco: Any) -> tuple[int, ...]:
    """The addresses of the functions of MuJoCo that the forces call."""
    (file,) = (path for path in Path(mujoco.__file__).parent.glob("*mujoco.*") if path.suffix != ".lib")
    library = ctypes.CDLL(str(file))
    called = library.mj_objectVelocity, library.mj_applyFT
    return tuple(ctypes.cast(each, ctypes.c_void_p).value or 0 for each in called)


@cache
def words_of(mujoco: Any) -> tuple[tuple[str, int], ...]:
    """The words TIME and NUMERIC of this build of MuJoCo: where a known time and a known address stand.

    In the data the addresses of arrays come after the time.
    """
    model = mujoco.MjModel.from_xml_string(f"<mujoco>{TABLE}</mujoco>")
    data = mujoco.MjData(model)
    data.time = MARK
    time = words_before(data.xpos.ctypes.data, data).index(int(np.float64(MARK).view(np.int64)))
    return ("TIME", time), ("NUMERIC", len(words_before(model.numeric_data.ctypes.data, model)))


def words_before(word: int, structure: Any) -> list[int]:
    """The words of a structure of MuJoCo before this one."""
    return list(
        itertools.takewhile(lambda each: each != word, (word_at(structure._address, n) for n in itertools.count()))
    )


POINTER = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)
TABLE = '<custom><numeric name="table" data="0"/></custom>'
"""The element of a model that can hold the address of a table."""
MARK = 0.7264905161847
