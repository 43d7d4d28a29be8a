"""Worlds with several curves per edge, texts and an origin, of a made-up sample."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import regatta
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
    RobotTypeRecord,
    StationRecord,
    WorldHeader,
    ZoneRecord,
)
from regatta._world import Orientation, world_of

TEXTS = b"\x00\x00" + b"\x06\x00dock 1" + b"\x05\x00gr\xc3\xbcn" + b"\xff\x00short"


def padded(data: bytes) -> bytes:
    """Returns a section that ends with a whole line."""
    return data + bytes(-len(data) % BYTES_PER_LINE)


def line(x: float) -> CurveRecord:
    """Returns a straight curve of 3 m to the east."""
    points = np.array([(x + step, 1.0) for step in range(4)], np.float32)
    return CurveRecord.from_buffer_copy(points.tobytes())


def sample(cut: int = 0) -> Any:
    """Returns a world of two nodes, and two edges of two curves and one, without its last bytes."""
    nodes = [NodeRecord(id=1, name=2, zone=10, role=4), NodeRecord(id=2, name=17, level=10, zone=9_999)]
    edges = [
        EdgeRecord(id=7, destination=1, first_curve=0, curves=2, orientation=2, orientation_angle=1.5, level=10),
        EdgeRecord(id=8, origin=1, first_curve=2, curves=1, name=2),
    ]
    curves = [line(0.0), line(3.0), line(6.0)]
    types = [RobotTypeRecord(name=b"tug", max_rotation_speed=0.5)]
    sections = [b"".join(bytes(record) for record in records) for records in (nodes, edges, curves, types)]
    zones = [ZoneRecord(name=2, capacity=1, nodes=1, edges=2), ZoneRecord(rule=1, first_member=3, edges=1)]
    members = np.array([1, 0, 1, 1], np.uint32).tobytes()
    others = bytes(OtherNameRecord(name=2, node=1))
    door = DoorRecord(name=2, first_edge=0, edges=1, opening_secs=3.0)
    lift = LiftRecord(name=10, levels=2, first_ride=3, rides=1, capacity=1, level_secs=8.0)
    levels = [LiftLevelRecord(name=2, first_node=1, nodes=1), LiftLevelRecord(name=10, first_node=2, nodes=1)]
    facility_members = np.array([1, 0, 1, 0], np.uint32).tobytes()
    sections += [TEXTS, b"".join(map(bytes, zones)), members, others]
    sections += [bytes(door), bytes(lift), b"".join(map(bytes, levels)), facility_members]
    stations = [StationRecord(name=2, nodes=1), StationRecord(name=10, level=2, x=1.5, role=5, first_node=1, nodes=2)]
    station_nodes = np.array([0, 1, 0], np.uint32).tobytes()
    lines = [BackgroundLineRecord(points=2), BackgroundLineRecord(level=10, first_point=2, points=3)]
    points = np.arange(10, dtype=np.float32).tobytes()
    sections += [b"".join(map(bytes, stations)), station_nodes, b"".join(map(bytes, lines)), points]
    payload = b"".join(padded(section) for section in sections)
    header = WorldHeader(run_id=5, revision=2, nodes=2, edges=2, curves=3, robot_types=1, text_bytes=len(TEXTS))
    header.zones, header.zone_members, header.other_names = len(zones), 4, 1
    header.doors, header.lifts, header.lift_levels, header.facility_members = 1, 1, 2, 4
    header.stations, header.station_nodes = 2, 3
    header.background_lines, header.background_points = 2, 5
    header.origin[:] = (3.5e6, -5.25e6)
    data = np.frombuffer(payload[: len(payload) - cut], np.uint8)
    return SimpleNamespace(header=header, payload=data, elements=len(data) // BYTES_PER_LINE)


def test_a_world_has_texts_curves_and_an_origin() -> None:
    world = world_of(sample())
    assert world.origin == (3.5e6, -5.25e6) and (world.run_id, world.revision) == (5, 2)
    assert world.nodes["name"].tolist() == ["dock 1", ""], "the second one's text is shorter than its length"
    assert world.nodes["level"].tolist() == ["", "grün"]
    assert world.nodes["zone"].tolist() == ["grün", ""], "there is no text at the second one's offset"
    assert world.nodes["role"].tolist() == [regatta.Role.CHARGE, regatta.Role.NONE]
    assert world.edges["name"].tolist() == ["", "dock 1"] and world.edges["level"].tolist() == ["grün", ""]
    assert world.edges["orientation"].tolist() == [Orientation.FIXED, Orientation.TANGENTIAL]
    assert world.robot_types["name"].tolist() == ["tug"] and world.robot_types["max_rotation_speed"][0] == 0.5


def test_each_edge_has_its_curves() -> None:
    world = world_of(sample())
    assert world.curves.shape == (3, 4, 2)
    assert world.curves_of(0)[:, :, 0].tolist() == [[0.0, 1.0, 2.0, 3.0], [3.0, 4.0, 5.0, 6.0]]
    assert world.curves_of(1)[:, 0].tolist() == [[6.0, 1.0]]


def test_each_zone_has_its_nodes_and_edges() -> None:
    first, second = world_of(sample()).zones
    assert (first.name, first.rule, first.capacity) == ("dock 1", regatta.ZoneRule.CAPACITY, 1)
    assert (first.nodes.tolist(), first.edges.tolist()) == ([1], [0, 1])
    assert second.rule == regatta.ZoneRule.SAME_DIRECTION and second.edges.tolist() == [1]


def test_doors_and_lifts_have_their_members() -> None:
    world = world_of(sample())
    [door], [lift] = world.doors, world.lifts
    assert (door.name, door.edges.tolist(), door.opening_secs) == ("dock 1", [1], 3.0)
    assert (lift.name, lift.rides.tolist(), lift.capacity, lift.level_secs) == ("grün", [0], 1, 8.0)
    assert [(level.name, level.nodes.tolist()) for level in lift.levels] == [("dock 1", [0]), ("grün", [1])]


def test_nodes_have_other_names() -> None:
    assert world_of(sample()).other_names == (("dock 1", 1),)


def test_edges_are_found_by_id_name_and_nodes() -> None:
    world = world_of(sample())
    for name in ("8", "dock 1", "2..1", "2 .. dock 1"):
        assert world.edge(name) == 8, name
    assert world.edge("1..2") == 7
    for name, reason in (("9", "no edge '9'"), ("", "no edge"), ("2..2", "no edge"), ("1..4", "no node")):
        with pytest.raises(ValueError, match=reason):
            world.edge(name)


def test_stations_have_nodes_and_the_background_has_points() -> None:
    world = world_of(sample())
    first, second = world.stations
    assert (first.name, first.level, first.nodes.tolist()) == ("dock 1", "", [0])
    assert (second.name, second.level, second.x, second.y) == ("grün", "dock 1", 1.5, 0.0)
    assert (second.role, second.nodes.tolist()) == (regatta.Role.TRANSFER, [1, 0])
    floor, wall = world.background
    assert (floor.level, floor.points.tolist()) == ("", [[0.0, 1.0], [2.0, 3.0]])
    assert (wall.level, wall.points.shape) == ("grün", (3, 2))


def test_a_world_that_is_too_short_is_an_error() -> None:
    with pytest.raises(regatta.ReadError, match="shorter than its header"):
        world_of(sample(cut=BYTES_PER_LINE))
