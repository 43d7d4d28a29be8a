"""LIF 1.0 of the VDMA: directed edges that are straight or NURBS, with an orientation for each vehicle type."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from imported.curves import Array, Curve, Edge, joined, line
from imported.nurbs import nurbs

JOINT = 1e-6
"""The smallest gap between a curve and its node that is bridged, in metres."""


def edges(path: Path, vehicle_type: str | None = None) -> list[Edge]:
    """Returns the edges of a file with one layout, with the orientations of a vehicle type: the file's first one, or a
    chosen one, without the edges that aren't for it."""
    (layout,) = json.loads(path.read_text())["layouts"]
    nodes = {node["nodeId"]: _point(node["nodePosition"]) for node in layout["nodes"]}
    uses = [properties for node in layout["nodes"] for properties in node["vehicleTypeNodeProperties"]]
    found = []
    for edge in layout["edges"]:
        of_type = {properties["vehicleTypeId"]: properties for properties in edge["vehicleTypeEdgeProperties"]}
        if vehicle_type is not None and vehicle_type not in of_type:
            continue
        properties = of_type.get(vehicle_type or uses[0]["vehicleTypeId"]) or next(iter(of_type.values()))
        curve = _curve(nodes[edge["startNodeId"]], nodes[edge["endNodeId"]], properties.get("trajectory"))
        angle = float(properties.get("vehicleOrientation", 0.0))
        if properties.get("orientationType", "TANGENTIAL") == "GLOBAL":
            found.append(Edge(curve, edge["edgeId"], heading=angle))
        else:
            found.append(Edge(curve, edge["edgeId"], offset=angle))
    return found


def _curve(start: Array, end: Array, trajectory: dict[str, Any] | None) -> Curve:
    """Returns the trajectory, joined to its nodes by straight segments where it begins or ends elsewhere; without a
    legal trajectory, the straight edge."""
    if trajectory is None:
        return line(start, end)
    points = trajectory["controlPoints"]
    control = [(float(point["x"]), float(point["y"])) for point in points]
    weights = [float(point.get("weight", 1.0)) for point in points]
    curve = nurbs(int(trajectory.get("degree", 1)), trajectory["knotVector"], control, weights)
    if curve is None:
        return line(start, end)
    parts = [curve]
    if np.hypot(*(curve.point(0) - start)) > JOINT:
        parts.insert(0, line(start, curve.point(0)))
    if np.hypot(*(end - curve.point(-1))) > JOINT:
        parts.append(line(curve.point(-1), end))
    return joined(parts)


def _point(position: dict[str, Any]) -> Array:
    return np.array([float(position["x"]), float(position["y"])])
