"""Tables of nodes and edges in two files: metres, and edges that are straight or have the control points of a cubic."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

from imported.curves import Edge, cubic, line


def edges(nodes: Path, edges: Path) -> list[Edge]:
    """Returns the edges; those in the opposite direction have the next free numbers."""
    with nodes.open() as file:
        places = {row["id"]: (float(row["x [m]"]), float(row["y [m]"])) for row in csv.DictReader(file)}
    with edges.open() as file:
        rows = list(csv.DictReader(file))
    free = max(int(row["ID"]) for row in rows) + 1
    found = []
    for row in rows:
        start, end = places[row["From"]], places[row["To"]]
        control = [(float(row[x]), float(row[y])) for x, y in (("x1", "y1"), ("x2", "y2")) if row[x]]
        edge = Edge(cubic(start, *control, end) if control else line(start, end), id=int(row["ID"]))
        found.append(edge)
        if row["Bidirectional"] == "yes":
            found.append(replace(edge, curve=edge.curve.reversed(), id=free))
            free += 1
    return found
