"""Ids that programs give: of robots, edges, nodes and robot types."""

import operator
from collections.abc import Sequence
from typing import Any, SupportsIndex

import numpy as np
import numpy.typing as npt

Number = int | np.integer[Any]
"""A whole number."""
Numbers = Sequence[Number] | npt.NDArray[np.integer[Any]]
"""Whole numbers: a list, a range, or an array."""

LIMIT = 2**32
"""Ids are less than this."""


def number(value: SupportsIndex, what: str) -> int:
    """Returns an id, or raises ``ValueError`` if it is out of range. ``what`` names it in errors."""
    number = operator.index(value)
    if not 0 <= number < LIMIT:
        raise ValueError(f"invalid {what} {number}; give a number from 0 to {LIMIT - 1}")
    return number


def numbers(values: Number | Numbers, what: str) -> int | npt.NDArray[np.uint32]:
    """Returns one id as a number, or several as an array.

    Raises ``TypeError`` if they aren't whole numbers, and ``ValueError`` if one is out of range.
    """
    if isinstance(values, int | np.integer):
        return number(values, what)
    array = np.asarray(values)
    if array.ndim == 0:
        return number(array.item(), what)
    if array.ndim > 1:
        raise ValueError(f"give one {what}, or a list of them, not an array of shape {array.shape}")
    if array.size == 0:
        return np.zeros(0, np.uint32)
    if array.dtype.kind == "b":
        raise TypeError(f"a mask names no {what}; give the numbers, for example np.flatnonzero(mask)")
    if array.dtype.kind == "O":
        array = np.array([operator.index(value) for value in array], object)
    elif array.dtype.kind not in "iu":
        raise TypeError(f"give each {what} as a whole number, not as {array.dtype.name}")
    outside = (array < 0) | (array >= LIMIT)
    if outside.any():
        number(array[outside][0], what)
    return array.astype(np.uint32)
