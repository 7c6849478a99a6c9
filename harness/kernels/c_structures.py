"""Source text for compiled functions that a C library calls: it reads arrays behind pointers in a C structure."""

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
"""`words_at(address, count)` gives `count` addresses as an array, `floats_at(address, count)` gives float64 numbers."""
