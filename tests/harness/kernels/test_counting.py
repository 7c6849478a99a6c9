"""A function that counts its calls is the one that is timed, called through a counter."""

import ctypes
from dataclasses import replace

import numpy as np
from gnomon.harness.contract.problem import problem_of
from gnomon.harness.kernels.equations import right_hand_side
from gnomon.harness.registry import lookup

from gnomon import cases


def test_counting_changes_no_bit_and_counts_each_call_once() -> None:
    """Else counts and times would belong to different equations."""
    case = cases.get("gyrocompass").rounded()
    plain = problem_of(case, lookup.find_one("gnomon:RK4").accepts)
    counted = replace(plain, counted=True)
    state = np.array(case.initial_state, dtype=float)
    wanted = right_hand_side(plain).array(0.5, state, plain.buffer)
    kernel, buffer, out = right_hand_side(counted), counted.buffer, np.empty_like(state)
    before = buffer[-1]
    kernel.pointer(0.5, state, buffer, out)
    np.testing.assert_array_equal(out, wanted)
    np.testing.assert_array_equal(kernel.array(0.5, state, buffer), wanted)
    assert buffer[-1] == before + 2
    np.testing.assert_array_equal(kernel.bound(buffer)(0.5, state), wanted)
    assert buffer[-1] == before + 3
    out[:] = np.nan
    numbers = ctypes.POINTER(ctypes.c_double)
    function = ctypes.CFUNCTYPE(None, ctypes.c_double, numbers, numbers, numbers)(kernel.address)
    function(0.5, *(array.ctypes.data_as(numbers) for array in (state, buffer, out)))
    np.testing.assert_array_equal(out, wanted)
    assert buffer[-1] == before + 4
    assert right_hand_side(plain).plain is None
