"""Functions that cannot be compiled; the comment of a line says how the refusal of that line begins."""

from typing import Any

import numpy as np

OBJECT = {"a": 1.0}


def raising(x: Any, n: int, a: float) -> float:
    if a > 0.0:
        raise ValueError(a)  # compiled code cannot have raise
    return a


def trying(x: Any, n: int, a: float) -> float:
    try:  # compiled code cannot have try
        return a
    finally:
        pass


def kinds(x: Any, n: int, a: float) -> float:
    total = 0
    for i in range(x.size):
        total = total + x[i]  # a float where an integer is wanted
    return total


def growing(x: Any, n: int, a: float) -> float:
    total = 0.0
    for _ in range(n):
        work = np.zeros(n)  # an array of a size that only the emitted code knows
        total += work[0]
    return total


def objects(x: Any, n: int, a: float) -> float:
    return a * OBJECT["a"] + len(x)  # len of an array whose size only the emitted code knows


def generators(x: Any, n: int, a: float) -> float:
    return float(sum(x[i] for i in range(n)))  # a loop over a range of unknown length


def slices(x: Any, n: int, a: float) -> float:
    return float(x[1:5:2][0])  # a slice with a step


def after(x: Any, n: int, a: float) -> float:
    for i in range(n):  # noqa: B007 # i is the variable of a loop and is used outside it
        a += x[0]
    return a + i


def negative_slices(x: Any, n: int, a: float) -> float:
    return float(x[-2:][0])  # the slice [-2:


FUNCTIONS = (negative_slices, raising, trying, kinds, growing, objects, generators, slices, after)
