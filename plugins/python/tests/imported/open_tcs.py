"""Plant models of openTCS: XML with points in millimetres and paths with control points in units of the drawing."""

from __future__ import annotations

import math
from pathlib import Path
from xml.etree import ElementTree

from imported.curves import Curve, Edge, cubic, joined, line

Point = tuple[float, float]


def edges(path: Path) -> list[Edge]:
    """Returns the paths that aren't locked."""
    model = ElementTree.parse(path).getroot()
    points = {
        # Versions before 6 name them xPosition.
        point.attrib["name"]: (_metres(point, "positionX", "xPosition"), _metres(point, "positionY", "yPosition"))
        for point in model.iter("point")
    }
    layout = model.find("visualLayout")
    assert layout is not None
    scale = (float(layout.attrib["scaleX"]) / 1000, float(layout.attrib["scaleY"]) / 1000)
    found = []
    for path_element in model.iter("path"):
        forward, backward = (float(path_element.attrib[key]) for key in ("maxVelocity", "maxReverseVelocity"))
        if path_element.attrib["locked"] == "true" or forward == backward == 0:
            continue
        ends = (points[path_element.attrib["sourcePoint"]], points[path_element.attrib["destinationPoint"]])
        curve, name = _curve(path_element, ends, scale), path_element.attrib["name"]
        if forward == 0:
            # It can only be driven backwards: from the destination to the source, tail first.
            found.append(Edge(curve.reversed(), name, offset=math.pi))
        else:
            found.append(Edge(curve, name, reverse=backward > 0))
    return found


def _metres(element: ElementTree.Element, *names: str) -> float:
    (value,) = (element.attrib[name] for name in names if name in element.attrib)
    return float(value) / 1000


def _curve(path: ElementTree.Element, ends: tuple[Point, Point], scale: Point) -> Curve:
    layout = path.find("pathLayout")
    if layout is None:
        return line(*ends)
    # The y axis of the drawing points down.
    control = [
        (float(point.attrib["x"]) * scale[0], -float(point.attrib["y"]) * scale[1])
        for point in layout.iter("controlPoint")
    ]
    start, end = ends
    match layout.attrib["connectionType"], len(control):
        case "POLYPATH", _:
            return line(start, *control, end)
        case ("BEZIER" | "BEZIER_3"), 1:
            return cubic(start, control[0], control[0], end)
        case ("BEZIER" | "BEZIER_3"), 5:
            return joined([cubic(start, *control[:3]), cubic(*control[2:], end)])
        case ("BEZIER" | "BEZIER_3"), count if count >= 2:
            return cubic(start, *control[:2], end)
        case _:
            # DIRECT; and ELBOW and SLANTED, whose corners the file doesn't place.
            return line(start, end)
