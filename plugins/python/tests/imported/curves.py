"""Curves as dense polylines with the directions of their tangents."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

STEP = 0.005
"""The length of the segments of what isn't straight, in metres."""
WINDOW = 8
"""The number of segments before and after a place count as near it."""


@dataclass(frozen=True, eq=False)
class Curve:
    """Segments from ``starts`` to ``ends``. The direction of the tangent turns evenly along a segment, from the first
    to the second of its ``directions``, in radians. At a corner, one segment ends in another direction than the next
    begins."""

    starts: Array
    ends: Array
    directions: Array

    @property
    def lengths(self) -> Array:
        """The length of each segment."""
        lengths: Array = np.hypot(*(self.ends - self.starts).T)
        return lengths

    @property
    def length(self) -> float:
        """The length of all."""
        return float(self.lengths.sum())

    def point(self, number: int) -> Array:
        """Returns the first (0) or the last (-1) point."""
        point: Array = self.starts[0] if number == 0 else self.ends[-1]
        return point

    def reversed(self) -> Curve:
        """Returns the curve from its end to its start."""
        return Curve(self.ends[::-1], self.starts[::-1], self.directions[::-1, ::-1] + math.pi)

    def split(self, lengths: Sequence[float]) -> list[Curve]:
        """Divides it at these distances from its start, in ascending order."""
        pieces, rest, done = [], self, 0.0
        for length in lengths:
            first, rest = rest._split(length - done)
            pieces.append(first)
            done = length
        return [*pieces, rest]

    def _split(self, length: float) -> tuple[Curve, Curve]:
        before = np.concatenate([[0.0], np.cumsum(self.lengths)])
        index = int(np.searchsorted(before, length, "right")) - 1
        share = (length - before[index]) / self.lengths[index]
        point = self.starts[index] + share * (self.ends[index] - self.starts[index])
        direction = self.directions[index, 0] + share * (self.directions[index, 1] - self.directions[index, 0])
        first = Curve(
            self.starts[: index + 1],
            np.concatenate([self.ends[:index], [point]]),
            np.concatenate([self.directions[:index], [[self.directions[index, 0], direction]]]),
        )
        second = Curve(
            np.concatenate([[point], self.starts[index + 1 :]]),
            self.ends[index:],
            np.concatenate([[[direction, self.directions[index, 1]]], self.directions[index + 1 :]]),
        )
        return first, second

    def nearest(self, points: Array, around: Array | None = None) -> tuple[Array, Array, Array]:
        """Returns the distances of points from segments, and for the nearest point of each segment, the distance along
        the curve and the direction: arrays of shape (points, segments).

        The segments are all of them; or those near the distances ``around`` along the curve, one for each point.
        """
        lengths = self.lengths
        before = np.cumsum(lengths) - lengths
        index = np.arange(len(lengths))[np.newaxis, :]
        if around is not None:
            index = (np.searchsorted(before, around, "right") - 1)[:, np.newaxis] + np.arange(-WINDOW, WINDOW + 1)
            index = np.clip(index, 0, len(lengths) - 1)
        along = (self.ends - self.starts)[index]
        relative = points[:, np.newaxis, :] - self.starts[index]
        share = (relative * along).sum(axis=2) / np.maximum(lengths**2, 1e-30)[index]
        share = np.clip(share, 0.0, 1.0)
        distance = np.hypot(*np.moveaxis(relative - share[:, :, np.newaxis] * along, 2, 0))
        first, last = self.directions.T
        return distance, before[index] + share * lengths[index], first[index] + share * (last - first)[index]


def joined(curves: Sequence[Curve]) -> Curve:
    """Joins curves, each of which starts where the one before it ends."""
    return Curve(
        np.concatenate([curve.starts for curve in curves]),
        np.concatenate([curve.ends for curve in curves]),
        np.concatenate([curve.directions for curve in curves]),
    )


def line(*points: Sequence[float] | Array) -> Curve:
    """Returns straight segments with corners."""
    positions = np.array(points, np.float64)
    steps = np.diff(positions, axis=0)
    direction = np.arctan2(steps[:, 1], steps[:, 0])
    return Curve(positions[:-1], positions[1:], np.stack([direction, direction], axis=1))


def smooth(
    position: Callable[[Array], Array],
    velocity: Callable[[Array], Array],
    start: float,
    end: float,
    step: float = STEP,
) -> Curve:
    """Samples a curve without corners. Both functions take parameters and return one vector for each."""
    rough = position(np.linspace(start, end, 65))
    length = float(np.hypot(*np.diff(rough, axis=0).T).sum())
    parameters = np.linspace(start, end, max(64, math.ceil(length / step)) + 1)
    points, vectors = position(parameters), velocity(parameters)
    chords = np.diff(points, axis=0)
    # Where a curve stands still (a control point at its end), its direction is that of what follows.
    still = np.hypot(*vectors.T) < 1e-9 * max(length, 1.0)
    vectors[:-1][still[:-1]] = chords[still[:-1]]
    if still[-1]:
        vectors[-1] = chords[-1]
    directions = np.unwrap(np.arctan2(vectors[:, 1], vectors[:, 0]))
    return Curve(points[:-1], points[1:], np.stack([directions[:-1], directions[1:]], axis=1))


def cubic(*control: Sequence[float] | Array) -> Curve:
    """Returns a cubic Bézier curve, by its Bernstein polynomials."""
    p = np.array(control, np.float64)
    assert p.shape == (4, 2)

    def position(t: Array) -> Array:
        u = 1.0 - t
        return np.outer(u**3, p[0]) + np.outer(3 * u**2 * t, p[1]) + np.outer(3 * u * t**2, p[2]) + np.outer(t**3, p[3])

    def velocity(t: Array) -> Array:
        u = 1.0 - t
        return 3 * (
            np.outer(u**2, p[1] - p[0]) + np.outer(2 * u * t, p[2] - p[1]) + np.outer(t**2, p[3] - p[2])
        )

    return smooth(position, velocity, 0.0, 1.0)


def arc(centre: Sequence[float] | Array, radius: float, start: float, end: float, step: float = STEP) -> Curve:
    """Returns an arc between two angles in radians, clockwise if the second is the smaller one."""
    turn = math.copysign(1.0, end - start)
    return smooth(
        lambda a: np.asarray(centre) + radius * np.stack([np.cos(a), np.sin(a)], axis=1),
        lambda a: turn * radius * np.stack([-np.sin(a), np.cos(a)], axis=1),
        start,
        end,
        step,
    )


@dataclass(frozen=True, eq=False)
class Edge:
    """An edge of a file."""

    curve: Curve
    """From its origin to its destination."""
    name: str = ""
    """Its id in the file, if that isn't a number."""
    id: int | None = None
    """Its id in the file, if that is a number. Without any, an edge is known by its ends."""
    offset: float = 0.0
    """The angle of robots to the tangent."""
    heading: float | None = None
    """The heading of robots on the map, if they keep one."""
    any_heading: bool = False
    """Whether the file doesn't say which heading robots have."""
    reverse: bool = False
    """Whether it can be driven from its destination to its origin in reverse gear."""

    def there_and_back(self) -> list[Edge]:
        """Returns it, and an edge in the opposite direction."""
        return [self, replace(self, curve=self.curve.reversed())]
