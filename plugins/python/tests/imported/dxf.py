"""Drawings in DXF: lines, polylines with bulges, arcs, circles, splines and blocks, all of them driven both ways."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from imported.curves import STEP, Array, Curve, Edge, arc, line
from imported.nurbs import nurbs

JOINT = 1e-3
"""Ends that are nearer are the same node, in metres."""

_METRES = {"1": 0.0254, "2": 0.3048, "4": 1e-3, "5": 1e-2, "6": 1.0}
"""The length of a unit by the number of ``$INSUNITS``."""


@dataclass
class _Entity:
    """An entity: its groups, in order, and for polylines and blocks what belongs to it."""

    kind: str
    groups: list[tuple[int, str]] = field(default_factory=list)
    parts: list[_Entity] = field(default_factory=list)

    def text(self, code: int, default: str = "") -> str:
        return next((value for number, value in self.groups if number == code), default)

    def number(self, code: int, default: float = 0.0) -> float:
        return float(self.text(code, str(default)))

    def numbers(self, code: int) -> list[float]:
        return [float(value) for number, value in self.groups if number == code]

    def point(self, code: int) -> Array:
        return np.array([self.number(code), self.number(code + 10)])

    def points(self) -> list[tuple[float, float]]:
        return list(zip(self.numbers(10), self.numbers(20), strict=True))


def edges(path: Path, layers: set[str] | None = None) -> list[Edge]:
    """Returns the edges of the lines on some layers; on all visible ones if none are given."""
    lines = path.read_text().split("\n")
    groups = [(int(code), value.strip()) for code, value in zip(lines[::2], lines[1::2], strict=False) if code.strip()]
    sections = _sections([group for group in groups if group[0] != 999])
    header = _Entity("", sections["HEADER"])
    unit = 1.0
    for index, (code, value) in enumerate(header.groups):
        if (code, value) == (9, "$INSUNITS"):
            unit = _METRES.get(header.groups[index + 1][1], 1.0)
    hidden = {
        entity.text(2)
        for entity in _entities(sections["TABLES"])
        if entity.kind == "LAYER" and (int(entity.text(70, "0")) & 1 or entity.number(62) < 0)
    }
    blocks = {block.text(2): block for block in _nested(_entities(sections["BLOCKS"]), "BLOCK", "ENDBLK")}
    drawn = [
        curve
        for layer, curve in _curves(_entities(sections["ENTITIES"]), blocks, "0", np.eye(2) * unit, np.zeros(2))
        if layer not in hidden and (layers is None or layer in layers)
    ]
    return [edge for curve in _divided(drawn) for edge in Edge(curve).there_and_back()]


def _sections(groups: list[tuple[int, str]]) -> dict[str, list[tuple[int, str]]]:
    sections: dict[str, list[tuple[int, str]]] = {name: [] for name in ("HEADER", "TABLES", "BLOCKS", "ENTITIES")}
    name = ""
    for index, group in enumerate(groups):
        if group == (0, "SECTION"):
            name = groups[index + 1][1]
        elif group == (0, "ENDSEC"):
            name = ""
        elif name:
            sections.setdefault(name, []).append(group)
    return sections


def _entities(groups: list[tuple[int, str]]) -> list[_Entity]:
    entities: list[_Entity] = []
    for code, value in groups:
        if code == 0:
            entities.append(_Entity(value))
        elif entities:
            entities[-1].groups.append((code, value))
    return entities


def _nested(entities: list[_Entity], kind: str, end: str) -> list[_Entity]:
    """Moves what follows each entity of a kind, up to an end, into it."""
    result: list[_Entity] = []
    owner: _Entity | None = None
    for entity in entities:
        if entity.kind == end:
            owner = None
        elif owner is not None:
            owner.parts.append(entity)
        else:
            result.append(replace(entity, parts=[]))
            owner = result[-1] if entity.kind == kind else None
    return result


def _curves(
    entities: list[_Entity], blocks: dict[str, _Entity], layer: str, matrix: Array, origin: Array
) -> Iterator[tuple[str, Curve]]:
    """Yields the lines of entities with their layers. Those on layer 0 of a block are on the layer of its INSERT."""
    for entity in _nested(entities, "POLYLINE", "SEQEND"):
        own = entity.text(8, "0")
        own = layer if own == "0" else own
        if entity.kind == "INSERT":
            for inner, start in _places(entity):
                block = blocks[entity.text(2)]
                moved = origin + matrix @ (start - inner @ block.point(10))
                yield from _curves(block.parts, blocks, own, matrix @ inner, moved)
            continue
        # Segments are of the same length in metres, whatever the unit is.
        for curve in _shapes(entity, STEP / float(np.hypot(*matrix[:, 0]))):
            yield own, _moved(curve, matrix, origin)


def _places(insert: _Entity) -> Iterator[tuple[Array, Array]]:
    """Yields the matrix and the position of each instance of a block: rows and columns are rotated, but not scaled."""
    angle = math.radians(insert.number(50))
    rotation = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    scale = np.diag([insert.number(41, 1.0), insert.number(42, 1.0)])
    for row in range(int(insert.text(71, "1"))):
        for column in range(int(insert.text(70, "1"))):
            step = np.array([column * insert.number(44), row * insert.number(45)])
            yield rotation @ scale, insert.point(10) + rotation @ step


def _moved(curve: Curve, matrix: Array, origin: Array) -> Curve:
    """Returns a curve that is scaled evenly, rotated and moved."""
    turn = math.atan2(matrix[1, 0], matrix[0, 0])
    assert np.allclose(matrix[:, 1], [-matrix[1, 0], matrix[0, 0]]), "no mirrors"
    return Curve(curve.starts @ matrix.T + origin, curve.ends @ matrix.T + origin, curve.directions + turn)


def _shapes(entity: _Entity, step: float) -> list[Curve]:
    """Returns the curves of an entity, in units of the drawing."""
    closed = bool(int(entity.text(70, "0")) & 1)
    match entity.kind:
        case "LINE":
            return [line(entity.point(10), entity.point(11))]
        case "LWPOLYLINE":
            bulges: list[float] = []
            for code, value in entity.groups:
                if code == 10:
                    bulges.append(0.0)
                elif code == 42:
                    bulges[-1] = float(value)
            return _polyline(entity.points(), bulges, closed, step)
        case "POLYLINE":
            vertices = [vertex for vertex in entity.parts if vertex.kind == "VERTEX"]
            points = [(vertex.number(10), vertex.number(20)) for vertex in vertices]
            return _polyline(points, [vertex.number(42) for vertex in vertices], closed, step)
        case "ARC":
            start, end = entity.number(50), entity.number(51)
            first, last = math.radians(start), math.radians(start + (end - start) % 360)
            return [arc(entity.point(10), entity.number(40), first, last, step)]
        case "CIRCLE":
            quarter = math.pi / 2
            return [
                arc(entity.point(10), entity.number(40), index * quarter, (index + 1) * quarter, step)
                for index in range(4)
            ]
        case "SPLINE":
            points = entity.points()
            weights = entity.numbers(41) or [1.0] * len(points)
            curve = nurbs(int(entity.text(71)), entity.numbers(40), points, weights, step)
            return [] if curve is None else [curve]
        case _:
            return []


def _polyline(points: list[tuple[float, float]], bulges: list[float], closed: bool, step: float) -> list[Curve]:
    """Returns its segments. A bulge is the tangent of a quarter of an arc's angle, above 0 if counter-clockwise."""
    ends = [*points[1:], points[0]] if closed else points[1:]
    curves = []
    for start, end, bulge in zip(points, ends, bulges, strict=False):
        if start == end:
            continue
        if bulge == 0:
            curves.append(line(start, end))
            continue
        a, b = np.array(start), np.array(end)
        chord, angle = b - a, 4 * math.atan(bulge)
        radius = float(np.hypot(*chord)) / 2 / math.sin(abs(angle) / 2)
        # The centre is on the left of a chord with a positive bulge below 1.
        left = np.array([-chord[1], chord[0]]) / 2
        centre = (a + b) / 2 + left / math.tan(angle / 2)
        first = math.atan2(*(a - centre)[::-1])
        curves.append(arc(centre, radius, first, first + angle, step))
    return curves


def _divided(curves: list[Curve]) -> list[Curve]:
    """Divides curves where an end of another one lies on them, and leaves out straight lines that come again."""
    ends = np.array([curve.point(number) for curve in curves for number in (0, -1)])
    pieces: list[Curve] = []
    seen: set[tuple[tuple[float, ...], ...]] = set()
    for curve in curves:
        distance, along, _ = curve.nearest(ends)
        nearest = distance.argmin(axis=1)
        rows = np.arange(len(ends))
        places = along[rows, nearest][distance[rows, nearest] <= JOINT]
        places = np.sort(places[(places > JOINT) & (places < curve.length - JOINT)])
        places = places[np.diff(places, prepend=-1.0) > JOINT]
        for piece in curve.split(places.tolist()):
            key = tuple(sorted(tuple(np.round(piece.point(number), 3).tolist()) for number in (0, -1)))
            straight = abs(piece.length - np.hypot(*(piece.point(-1) - piece.point(0)))) < 1e-9
            if straight and key in seen:
                continue
            seen.update([key] if straight else [])
            pieces.append(piece)
    return pieces

