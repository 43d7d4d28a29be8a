"""NURBS: the algorithm of de Boor in homogeneous coordinates, span by span."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from imported.curves import STEP, Array, Curve, joined, line, smooth


def nurbs(
    degree: int,
    knots: Sequence[float],
    control: Sequence[Sequence[float]],
    weights: Sequence[float],
    step: float = STEP,
) -> Curve | None:
    """Returns the curve, or ``None`` if these numbers don't make one."""
    count, u = len(control), np.array(knots, np.float64)
    legal = degree >= 1 and count > degree and len(weights) == count and len(u) == count + degree + 1
    if not legal or not (np.isfinite(u).all() and (np.diff(u) >= 0).all() and min(weights) > 0):
        return None
    homogeneous = np.array([(x * w, y * w, w) for (x, y), w in zip(control, weights, strict=True)], np.float64)
    # The derivative is a spline of a lower degree, over the inner knots.
    width = u[degree + 1 : count + degree] - u[1:count]
    steps = np.divide(degree, width, out=np.zeros_like(width), where=width > 0)
    slopes = np.diff(homogeneous, axis=0) * steps[:, np.newaxis]
    spans = [span for span in range(degree, count) if u[span] < u[span + 1]]
    if not spans:
        return None

    def piece(span: int) -> Curve:
        def position(t: Array) -> Array:
            h = _de_boor(degree, u, homogeneous, span, t)
            return h[:, :2] / h[:, 2:]

        def velocity(t: Array) -> Array:
            h = _de_boor(degree, u, homogeneous, span, t)
            d = _de_boor(degree - 1, u[1:-1], slopes, span - 1, t)
            return (d[:, :2] - d[:, 2:] * h[:, :2] / h[:, 2:]) / h[:, 2:]

        start, end = float(u[span]), float(u[span + 1])
        if degree == 1:
            return line(*position(np.array([start, end])))
        return smooth(position, velocity, start, end, step)

    return joined([piece(span) for span in spans])


def _de_boor(degree: int, u: Array, control: Array, span: int, t: Array) -> Array:
    """Evaluates the polynomial of one span: also at its ends, so that both sides of a corner have a value."""
    d = [np.tile(control[span - degree + i], (len(t), 1)) for i in range(degree + 1)]
    for level in range(1, degree + 1):
        for i in range(degree, level - 1, -1):
            low, high = u[span - degree + i], u[span + 1 + i - level]
            share = ((t - low) / (high - low))[:, np.newaxis]
            d[i] = (1 - share) * d[i - 1] + share * d[i]
    return d[degree]
