"""The world: the route graph and the robot types."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from regatta._contract import BYTES_PER_LINE, EdgeRecord, NodeRecord, RobotTypeRecord, WorldHeader, dtype
from regatta._errors import ReadError
from regatta._ports import Sample

Records = npt.NDArray[np.void]


@dataclass(frozen=True, eq=False)
class World:
    """The route graph and the robot types, as structured arrays: ``world.nodes["x"]``, ``world.edges[7]["length"]``.

    They are copies, to be kept for as long as you like.
    """

    run_id: int
    """The run that it belongs to."""
    revision: int
    """Counts the worlds of a run, from 1."""
    nodes: Records
    """``id`` in the route graph's file, ``x`` and ``y`` in metres, ``theta`` in radians."""
    edges: Records
    """``id`` in the file; ``origin`` and ``destination``: indices of nodes; arc ``length`` in metres; ``control_points``
    P0 to P3 of the Bézier curve, in metres; ``velocity_forward`` and ``velocity_backwards`` in metres per second, the
    latter 0 if reverse gear is not allowed. A frame's ``edge`` column holds indices of these."""
    robot_types: Records
    """``name`` (UTF-8), ``shape`` (a :class:`Shape <regatta.Shape>`), ``length`` and ``width`` in metres, ``max_speed``
    and ``max_acceleration`` in SI units, ``inf`` for no limit. The column ``type`` holds indices of these."""


def world_of(sample: Sample[WorldHeader]) -> World:
    """Cuts a sample into its sections, each of which starts on a whole line."""
    header, start = sample.header, 0
    sections = []
    for record, count in (
        (NodeRecord, header.nodes),
        (EdgeRecord, header.edges),
        (RobotTypeRecord, header.robot_types),
    ):
        kind: np.dtype[Any] = dtype(record)
        end = start + count * kind.itemsize
        if end > len(sample.payload):
            raise ReadError(
                f"the world of {sample.elements} lines is too short for what its header says; its producer is at fault"
            )
        sections.append(sample.payload[start:end].view(kind).copy())
        start = -(-end // BYTES_PER_LINE) * BYTES_PER_LINE
    return World(header.run_id, header.revision, *sections)
