"""Graphs of Nav2's Route Server: GeoJSON whose lines are directed and straight, from node to node."""

from __future__ import annotations

import json
from pathlib import Path

from imported.curves import Edge, line


def edges(path: Path) -> list[Edge]:
    """Returns the edges; those whose id was used before have the next free numbers."""
    features = json.loads(path.read_text())["features"]
    nodes = {
        feature["properties"]["id"]: feature["geometry"]["coordinates"]
        for feature in features
        if feature["geometry"]["type"] == "Point"
    }
    lines = [feature["properties"] for feature in features if feature["geometry"]["type"] != "Point"]
    # Where a robot would drive from a node to the same node, there is nothing to drive.
    lines = [edge for edge in lines if edge["startid"] != edge["endid"]]
    used: set[int] = set()
    free = max(edge["id"] for edge in lines) + 1
    found = []
    for edge in lines:
        number = edge["id"]
        if number in used:
            number, free = free, free + 1
        used.add(number)
        found.append(Edge(line(nodes[edge["startid"]], nodes[edge["endid"]]), id=number))
    return found
