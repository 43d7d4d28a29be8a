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


@dataclass(frozen=True, eq=False, repr=False)
class World:
    """The route graph and the robot types, as structured arrays: ``world.nodes["x"]``, ``world.edges[7]["length"]``.

    They are copies, which a program can keep for as long as it likes.
    """

    run_id: int
    """The run that the world belongs to."""
    revision: int
    """Counts the worlds of a run, from 1."""
    nodes: Records
    """``id`` in the route graph's file, ``x`` and ``y`` in metres, ``theta`` in radians."""
    edges: Records
    """``id`` in the route graph's file; ``origin`` and ``destination``: indices of nodes; arc ``length`` in metres;
    ``control_points`` P0 to P3 of the Bézier curve, in metres; ``velocity_forward`` and ``velocity_backwards`` in
    metres per second, the latter 0 if reverse gear is not allowed. A frame's ``edge`` column holds indices into
    these."""
    robot_types: Records
    """``name`` (a ``str``), ``shape`` (a :class:`Shape <regatta.Shape>`), ``length`` and ``width`` in metres,
    ``max_speed`` and ``max_acceleration`` in SI units, ``inf`` for no limit. The column ``type`` holds indices into
    these."""

    def __repr__(self) -> str:
        counts = f"{len(self.nodes)} nodes, {len(self.edges)} edges, {len(self.robot_types)} robot types"
        return f"<regatta.World: revision {self.revision}, {counts}>"


def world_of(sample: Sample[WorldHeader]) -> World:
    """Splits a sample into its sections, each of which starts on a whole line."""
    header, start = sample.header, 0
    sections = []
    for record, count in (
        (NodeRecord, header.nodes),
        (EdgeRecord, header.edges),
        (RobotTypeRecord, header.robot_types),
    ):
        record_type: np.dtype[Any] = dtype(record)
        end = start + count * record_type.itemsize
        if end > len(sample.payload):
            raise ReadError(
                f"the world of {sample.elements} lines is shorter than its header says; its producer is at fault"
            )
        sections.append(sample.payload[start:end].view(record_type).copy())
        start = -(-end // BYTES_PER_LINE) * BYTES_PER_LINE
    nodes, edges, robot_types = sections
    return World(header.run_id, header.revision, nodes, edges, _with_text(robot_types))


def _with_text(records: Records) -> Records:
    """Returns records whose text is ``str`` instead of UTF-8."""
    columns = {name: records[name] for name in records.dtype.names or ()}
    for name, column in columns.items():
        if column.dtype.kind == "S":
            columns[name] = np.char.decode(column, "utf-8", "replace")
    text = np.zeros(len(records), [(name, column.dtype) for name, column in columns.items()])
    for name, column in columns.items():
        text[name] = column
    return text
