"""Text for compiled functions that a C library calls: arrays behind the pointers in its structures."""

from gnomon.harness.kernels.equations import INNER

ARRAYS_BEHIND_POINTERS = f"""\
from numba import carray, njit, types
from numba.core import cgutils
from numba.extending import intrinsic

@intrinsic
def pointer_at(typing_context, address):
    def code(context, builder, signature, arguments):
        return builder.inttoptr(arguments[0], cgutils.voidptr_t)
    return types.voidptr(address), code

@njit({INNER})
def words_at(address, count):
    return carray(pointer_at(address), count, types.uintp)

@njit({INNER})
def floats_at(address, count):
    return carray(pointer_at(address), count, types.float64)
"""
"""`words_at` and `floats_at`: arrays of addresses and of float64 at an address."""
