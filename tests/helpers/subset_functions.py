"""Plain functions (x, n, a) -> float: those INSIDE the subset of Python that can be compiled, each with a part of it in its
name, and those OUTSIDE it, in which a comment says how the refusal of its line begins."""

from math import cos, exp, sin, sqrt
from typing import Any, NamedTuple

import numpy as np

LIMIT = 7
OBJECT = {"a": 1.0}


def helper(x: Any, k: int) -> Any:
    if k > 2 and x[k] > 0.0:
        return sin(x[k])
    return -1.0


def early(x: Any, limit: float) -> int:
    for i in range(x.size):
        if abs(x[i]) > limit:
            return i
    return -1


def pair(a: Any, b: Any) -> tuple[Any, Any]:
    return a + b, a - b


def branches(x: Any, n: int, a: float) -> float:
    if a > 0.5:
        value = a * x[0]
    elif a < -0.5 or n % 2 == 0:
        value = x[1] - a
    else:
        value = 1.0
    return value if not (value > 0.0) else 2.0 * value


def loops(x: Any, n: int, a: float) -> float:
    total = 0.0
    for i in range(x.size):
        if i % n == 0:
            continue
        if x[i] > 1.5:
            break
        total += x[i] * a + helper(x, i)
    while total > 3.0:
        total /= 2.0
    for k in range(x.size - 1, -1, -2):
        total = total * 0.5 + x[k]
    return total


def returns(x: Any, n: int, a: float) -> float:
    return early(x, a) + 10.0 * early(x, 100.0)


def integers(x: Any, n: int, a: float) -> float:
    k = n - 6
    return float((k // 3) * 100 + (k % 3) * 10 + (-1) ** n + int(a * 10.0) + k * k + round(a * 3.0))


def chained(x: Any, n: int, a: float) -> float:
    return float(-1.0 < a <= 0.25 < x[0]) + 2.0 * float(not 0 < n < LIMIT)


def guarded(x: Any, n: int, a: float) -> float:
    k = n if n < x.size and x[n] > 0.0 else 0
    return (x[k + 1] if k + 1 < x.size else a) + x[-1]


def extremes(x: Any, n: int, a: float) -> float:
    return max(a, x[0], x[1]) + 3.0 * min(a, x[0]) + abs(a) + float(abs(3 - n))


def powers(x: Any, n: int, a: float) -> float:
    return a**3 + (a * a + 1.0) ** -2 + (a * a + 1.0) ** 0.3 + 2.0**n + a**0


def functions(x: Any, n: int, a: float) -> float:
    return float(sin(a) + cos(a) + exp(a) + sqrt(a * a + 1.0) + np.log10(a * a + 1.0) + np.floor(a) + np.hypot(a, 1.0))


def arrays(x: Any, n: int, a: float) -> float:
    work, count = np.zeros((3, x.size)), np.zeros(2, dtype=np.int64)
    for i in range(x.size):
        work[1, i] = x[i]
    row = work[1]
    row[0] += a
    for i in range(x.size):
        count[i % 2] += 1
    rest = work[1:]
    return float(rest[0, 0] + work[2, x.size - 1] + count[0] - 2 * count[1] + row.size)


def tuples(x: Any, n: int, a: float) -> float:
    both = pair(a, x[0])
    for _ in range(n):
        both = pair(both[0] * 0.5, both[1])
    first, second = both
    return float(first * 2.0 + second)


def complexes(x: Any, n: int, a: float) -> float:
    z = np.empty(2, dtype=np.complex128)
    z[0] = complex(a, x[0])
    z[1] = z[0] * complex(0.5, -1.0) - z[0] / complex(2.0, a)
    return float(z[1].real + 2.0 * z[1].imag + abs(z[0]))


def slices(x: Any, n: int, a: float) -> float:
    work, total = np.zeros(12), 0.0
    table = work[2:8].reshape((2, 3))
    for i in range(2):
        for j in range(3):
            table[i, j] = a * (3 * i + j + 1)
    for k in range(40):
        total = 0.5 * total + work[k % 12]
    table[0] = table[1]
    table[1] = a
    work[9:][:] = x[:3]
    return float(total + table[0, 2] + table[1, 2] + work[11] + table.reshape(6)[5] + work[: n + 1].size)


def nothing(x: Any) -> None:
    """A function of a docstring alone."""


def nested(x: Any, n: int, a: float) -> float:
    work, total = np.zeros((LIMIT, LIMIT)), 0.0
    for i in range(LIMIT):
        for j in range(LIMIT):
            for k in range(i, LIMIT):
                work[i, j] += a * (k - 2 * j)
        total = 0.5 * total - work[i, i]
    nothing(x)
    return float(total + work[LIMIT - 1, 0])


class Line(NamedTuple):
    x: Any
    slope: float
    spare: Any
    work: Any


def add_up(line: Line, n: int) -> float:
    total = 0.0
    for i in range(n % line.x.size):
        line.work[0] += line.slope * line.x[i]
        total += line.work[0]
    return total


def records(x: Any, n: int, a: float) -> float:
    line = Line(x, a, np.zeros(1), np.zeros(2))
    steeper = line._replace(slope=2.0 * a, work=line.work[1:])
    return add_up(line, n) - add_up(steeper, n) + line.work[1] + steeper.slope


INSIDE = (
    branches, loops, returns, integers, chained, guarded, extremes, powers, functions, arrays, tuples, complexes, slices,
    nested, records,
)  # fmt: skip


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


def stepped_slices(x: Any, n: int, a: float) -> float:
    return float(x[1:5:2][0])  # a slice with a step


def after(x: Any, n: int, a: float) -> float:
    for i in range(n):  # noqa: B007 # i is the variable of a loop and is used outside it
        a += x[0]
    return a + i


def negative_slices(x: Any, n: int, a: float) -> float:
    return float(x[-2:][0])  # the slice [-2:


OUTSIDE = (negative_slices, raising, trying, kinds, growing, objects, generators, stepped_slices, after)
