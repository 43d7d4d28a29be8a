"""The world: the route graph and the robot types."""

from __future__ import annotations

import difflib
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
import numpy.typing as npt

from regatta._contract import (
    BYTES_PER_LINE,
    BackgroundLineRecord,
    CurveRecord,
    DoorRecord,
    EdgeRecord,
    LiftLevelRecord,
    LiftRecord,
    NodeRecord,
    OtherNameRecord,
    Record,
    RobotTypeRecord,
    StationRecord,
    WorldHeader,
    ZoneRecord,
    dtype,
)
from regatta._errors import ReadError
from regatta._ports import Sample

Records = npt.NDArray[np.void]

_LENGTH_BYTES = 2
"""The bytes of a text's length, which precede the text."""
_INDEX_BYTES = 4
"""The bytes of the index of a node or an edge."""
_POINT_BYTES = 8
"""The bytes of a point."""


class Orientation(IntEnum):
    """The heading of robots along an edge, in both gears."""

    TANGENTIAL = 0
    """That of the edge's tangent, from origin to destination."""
    OFFSET = 1
    """At ``orientation_angle`` to the tangent."""
    FIXED = 2
    """``orientation_angle`` on the map."""


@dataclass(frozen=True, eq=False)
class Zone:
    """A group of nodes and edges with a rule: a block, a mutex group, the cabin of a lift."""

    name: str
    rule: int
    """A :class:`ZoneRule <regatta.ZoneRule>`."""
    capacity: int
    """The largest number of robots at the same time; 0 if the rule is another one."""
    nodes: npt.NDArray[np.uint32]
    """The indices of its nodes."""
    edges: npt.NDArray[np.uint32]
    """The indices of its edges."""


@dataclass(frozen=True, eq=False)
class Station:
    """A place with a name that robots serve from nodes."""

    name: str
    level: str
    """Its level (floor); empty for none."""
    x: float
    """Metres to the east."""
    y: float
    """Metres to the north."""
    role: int
    """A :class:`Role <regatta.Role>`."""
    nodes: npt.NDArray[np.uint32]
    """The indices of its nodes."""


@dataclass(frozen=True, eq=False)
class BackgroundLine:
    """A line that means nothing to robots: a wall, the outline of a floor or a rack."""

    level: str
    """Its level (floor); empty for none."""
    points: npt.NDArray[np.float32]
    """The points that it leads through, in metres: an array of shape (points, 2)."""


@dataclass(frozen=True, eq=False)
class Door:
    """A door across edges. Robots pass it only while it is open."""

    name: str
    edges: npt.NDArray[np.uint32]
    """The indices of its edges."""
    line: npt.NDArray[np.float32]
    """Its two ends, in metres: an array of shape (2, 2)."""
    opening_secs: float
    """Seconds from closed to open."""
    closing_secs: float
    """Seconds from open to closed."""


@dataclass(frozen=True, eq=False)
class LiftLevel:
    """A level that a lift serves."""

    name: str
    nodes: npt.NDArray[np.uint32]
    """The indices of the nodes in the cabin while it is there."""


@dataclass(frozen=True, eq=False)
class Lift:
    """A lift: a cabin that carries robots from level to level."""

    name: str
    levels: tuple[LiftLevel, ...]
    """From the lowest to the highest."""
    rides: npt.NDArray[np.uint32]
    """The indices of the edges from level to level."""
    capacity: int
    """The largest number of robots in the cabin."""
    level_secs: float
    """Seconds of the cabin from a level to the next."""
    opening_secs: float
    """Seconds from closed to open of its doors."""
    closing_secs: float
    """Seconds from open to closed."""


@dataclass(frozen=True, eq=False, repr=False)
class World:
    """The route graph and the robot types, as structured arrays: ``world.nodes["x"]``, ``world.edges[7]["length"]``.

    They are copies, which a program can keep for as long as it likes.
    """

    run_id: int
    """The run that the world belongs to."""
    revision: int
    """Counts the worlds of a run, from 1."""
    origin: tuple[float, float]
    """Metres east and north of (0, 0) of the fleet's positions, on the map of the route graph's file: a position on
    that map is ``origin`` + position."""
    nodes: Records
    """``id`` in the route graph's file, ``x`` and ``y`` in metres, ``theta`` in radians; ``name``, ``level`` and
    ``zone`` (``str``, empty for none); ``role`` (a :class:`Role <regatta.Role>`)."""
    edges: Records
    """``id`` in the route graph's file; ``origin`` and ``destination``: indices of nodes; arc ``length`` in metres;
    ``first_curve``, the index of the first of the edge's curves, and ``curves``, their number; ``speed`` and
    ``reverse_speed`` in metres per second, the latter 0 if reverse gear is not allowed; ``name``, ``level`` and
    ``zone`` (``str``, empty for none); ``orientation`` (an :class:`Orientation <regatta.Orientation>`) and
    ``orientation_angle`` in radians. A frame's ``edge`` column holds indices into these."""
    curves: npt.NDArray[np.float32]
    """The control points of all edges' cubic Bézier curves, in metres: an array of shape (curves, 4, 2).
    :meth:`curves_of` returns those of one edge."""
    robot_types: Records
    """``name`` (a ``str``), ``shape`` (a :class:`Shape <regatta.Shape>`), ``length`` and ``width`` in metres,
    ``max_speed`` and ``max_acceleration`` in SI units, ``inf`` for no limit; ``max_rotation_speed`` of turns on the
    spot in radians per second, 0 if the type can't turn on the spot, and ``max_rotation_acceleration`` in radians per
    second squared. The column ``type`` holds indices into these."""

    zones: tuple[Zone, ...] = ()
    """The zones with a rule, which fleet managers keep."""

    other_names: tuple[tuple[str, int], ...] = ()
    """Names of nodes besides their own, with the index of the node: those of stations there, and of nodes at the same
    place that the layout was read without."""

    doors: tuple[Door, ...] = ()
    """The doors. ``fleet.facilities()`` reads their states."""

    lifts: tuple[Lift, ...] = ()
    """The lifts."""

    stations: tuple[Station, ...] = ()
    """The stations."""

    background: tuple[BackgroundLine, ...] = ()
    """The lines of the background."""

    def curves_of(self, edge: int) -> npt.NDArray[np.float32]:
        """Returns the control points of an edge's curves from origin to destination, in metres: an array of shape
        (curves, 4, 2). Each curve starts where the one before it ends."""
        record = self.edges[edge]
        first = int(record["first_curve"])
        return self.curves[first : first + int(record["curves"])]

    def node(self, name: str) -> int:
        """Returns the id of a node, given its name, that of a station there, or its id as a text.

        Raises ``ValueError`` if no node has the name, or several have it.
        """
        ids = self.nodes["id"]
        found = set(ids[self.nodes["name"] == name].tolist()) if name else set()
        if not found:
            found = {int(ids[index]) for other, index in self.other_names if other == name}
        if name.isascii() and name.isdigit() and int(name) in ids:
            return int(name)
        if len(found) == 1:
            return int(found.pop())
        if found:
            raise ValueError(f"several nodes are called {name!r}: {sorted(found)}; give an id")
        names = {*self.nodes["name"].tolist(), *(other for other, _ in self.other_names)} - {""}
        close = difflib.get_close_matches(name, names, 1)
        hint = f"; did you mean {close[0]!r}?" if close else "; `regatta graph info` lists the nodes of a layout"
        raise ValueError(f"no node is called {name!r}{hint}")

    def edge(self, name: str) -> int:
        """Returns the id of an edge, given its name, its id as a text, or the nodes at its ends as ``"FROM..TO"``.

        Raises ``ValueError`` if there is no such edge, or several.
        """
        ids = self.edges["id"]
        if name.isascii() and name.isdigit() and int(name) in ids:
            return int(name)
        found = ids[self.edges["name"] == name].tolist() if name else []
        origin, separator, destination = name.partition("..")
        if separator and not found:
            ends = [self.node(end.strip()) for end in (origin, destination)]
            nodes = self.nodes["id"]
            origins, destinations = (nodes[self.edges[end]] for end in ("origin", "destination"))
            found = ids[(origins == ends[0]) & (destinations == ends[1])].tolist()
        if len(found) == 1:
            return int(found[0])
        if found:
            raise ValueError(f"{name!r} stands for several edges: {sorted(found)}; give an id")
        raise ValueError(f"there is no edge {name!r}: give an id, a name, or the nodes at its ends as 'FROM..TO'")

    def __repr__(self) -> str:
        counts = f"{len(self.nodes)} nodes, {len(self.edges)} edges, {len(self.robot_types)} robot types"
        return f"<regatta.World: revision {self.revision}, {counts}>"


def world_of(sample: Sample[WorldHeader]) -> World:
    """Splits a sample into its sections, each of which starts on a whole line."""
    header, sections = sample.header, _Sections(sample)
    nodes = sections.records(NodeRecord, header.nodes)
    edges = sections.records(EdgeRecord, header.edges)
    curves = sections.records(CurveRecord, header.curves)["control_points"].copy()
    robot_types = _with_text(sections.records(RobotTypeRecord, header.robot_types))
    texts = sections.section(header.text_bytes).tobytes()
    zones = sections.records(ZoneRecord, header.zones)
    members = sections.section(header.zone_members * _INDEX_BYTES).view(np.uint32).copy()
    others = sections.records(OtherNameRecord, header.other_names)
    other_names = tuple((_text_at(texts, int(other["name"])), int(other["node"])) for other in others)
    nodes, edges = (_with_texts(records, texts) for records in (nodes, edges))
    world_zones = tuple(_zone(zone, members, texts) for zone in zones)
    origin = tuple(header.origin)
    doors, lifts = _facilities(header, sections, texts)
    stations = _stations(header, sections, texts)
    background = _background(header, sections, texts)
    return World(
        header.run_id,
        header.revision,
        origin,
        nodes,
        edges,
        curves,
        robot_types,
        world_zones,
        other_names,
        doors,
        lifts,
        stations,
        background,
    )


def _facilities(
    header: WorldHeader, sections: _Sections, texts: bytes
) -> tuple[tuple[Door, ...], tuple[Lift, ...]]:
    """Reads the doors and the lifts."""
    doors = sections.records(DoorRecord, header.doors)
    lifts = sections.records(LiftRecord, header.lifts)
    levels = sections.records(LiftLevelRecord, header.lift_levels)
    members = sections.section(header.facility_members * _INDEX_BYTES).view(np.uint32).copy()

    def some(first: Any, count: Any) -> npt.NDArray[np.uint32]:
        return members[int(first) : int(first) + int(count)]

    all_levels = tuple(
        LiftLevel(_text_at(texts, int(level["name"])), some(level["first_node"], level["nodes"])) for level in levels
    )

    def door(record: Any) -> Door:
        edges = some(record["first_edge"], record["edges"])
        times = float(record["opening_secs"]), float(record["closing_secs"])
        return Door(_text_at(texts, int(record["name"])), edges, record["line"].copy(), *times)

    def lift(record: Any) -> Lift:
        first = int(record["first_level"])
        served = all_levels[first : first + int(record["levels"])]
        rides = some(record["first_ride"], record["rides"])
        times = float(record["level_secs"]), float(record["opening_secs"]), float(record["closing_secs"])
        return Lift(_text_at(texts, int(record["name"])), served, rides, int(record["capacity"]), *times)

    return tuple(map(door, doors)), tuple(map(lift, lifts))


def _stations(header: WorldHeader, sections: _Sections, texts: bytes) -> tuple[Station, ...]:
    """Reads the stations."""
    stations = sections.records(StationRecord, header.stations)
    nodes = sections.section(header.station_nodes * _INDEX_BYTES).view(np.uint32).copy()

    def station(record: Any) -> Station:
        name, level = (_text_at(texts, int(record[field])) for field in ("name", "level"))
        first = int(record["first_node"])
        served = nodes[first : first + int(record["nodes"])]
        return Station(name, level, float(record["x"]), float(record["y"]), int(record["role"]), served)

    return tuple(map(station, stations))


def _background(header: WorldHeader, sections: _Sections, texts: bytes) -> tuple[BackgroundLine, ...]:
    """Reads the lines of the background."""
    lines = sections.records(BackgroundLineRecord, header.background_lines)
    numbers = sections.section(header.background_points * _POINT_BYTES).view(np.float32).copy()
    points = numbers.reshape(-1, 2)

    def line(record: Any) -> BackgroundLine:
        first = int(record["first_point"])
        return BackgroundLine(_text_at(texts, int(record["level"])), points[first : first + int(record["points"])])

    return tuple(map(line, lines))


def _zone(zone: Any, members: npt.NDArray[np.uint32], texts: bytes) -> Zone:
    """Returns a zone with its members."""
    first_edge = int(zone["first_member"]) + int(zone["nodes"])
    nodes = members[int(zone["first_member"]) : first_edge]
    edges = members[first_edge : first_edge + int(zone["edges"])]
    return Zone(_text_at(texts, int(zone["name"])), int(zone["rule"]), int(zone["capacity"]), nodes, edges)


class _Sections:
    """The sections of a sample, read one after the other."""

    def __init__(self, sample: Sample[WorldHeader]) -> None:
        self._sample = sample
        self._start = 0

    def section(self, count: int) -> npt.NDArray[np.uint8]:
        """Returns the next section, of that many bytes. It is a view of shared memory."""
        end = self._start + count
        if end > len(self._sample.payload):
            raise ReadError(
                f"the world of {self._sample.elements} lines is shorter than its header says; its producer is at fault"
            )
        section = self._sample.payload[self._start : end]
        self._start = -(-end // BYTES_PER_LINE) * BYTES_PER_LINE
        return section

    def records(self, record: type[Record], count: int) -> Records:
        """Returns a copy of the next section, of that many records."""
        record_type: np.dtype[Any] = dtype(record)
        return self.section(count * record_type.itemsize).view(record_type).copy()


def _text_at(texts: bytes, offset: int) -> str:
    """Returns the text at an offset; the empty text for the offset 0, and if there is none."""
    length = int.from_bytes(texts[offset : offset + _LENGTH_BYTES], "little")
    text = texts[offset + _LENGTH_BYTES : offset + _LENGTH_BYTES + length]
    if offset == 0 or len(text) < length:
        return ""
    try:
        return text.decode()
    except UnicodeDecodeError:
        return ""


def _with_texts(records: Records, texts: bytes) -> Records:
    """Returns nodes or edges whose names, levels and zones are ``str`` instead of offsets."""
    columns = {name: records[name] for name in records.dtype.names or () if name != "reserved"}
    for name in ("name", "level", "zone"):
        # Many records have the same text, or none: each text is decoded once.
        offsets, index = np.unique(columns[name], return_inverse=True)
        columns[name] = np.array([_text_at(texts, int(offset)) for offset in offsets], dtype=np.str_)[index]
    return _joined(columns, len(records))


def _with_text(records: Records) -> Records:
    """Returns records whose text is ``str`` instead of UTF-8."""
    columns = {name: records[name] for name in records.dtype.names or ()}
    for name, column in columns.items():
        if column.dtype.kind == "S":
            columns[name] = np.char.decode(column, "utf-8", "replace")
    return _joined(columns, len(records))


def _joined(columns: dict[str, npt.NDArray[Any]], count: int) -> Records:
    """Returns records with these columns."""
    records = np.zeros(count, [(name, column.dtype) for name, column in columns.items()])
    for name, column in columns.items():
        records[name] = column
    return records
