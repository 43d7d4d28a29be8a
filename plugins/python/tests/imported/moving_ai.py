"""Grid maps of MovingAI: free cells with a common side are joined both ways."""

from __future__ import annotations

from pathlib import Path

from imported.curves import Edge, line


def edges(path: Path, cell: float = 1.0) -> list[Edge]:
    """Returns straight edges between the middles of neighbouring free cells, with sides of ``cell`` metres."""
    header, _, grid = path.read_text().partition("map\n")
    height = int(dict(row.split() for row in header.splitlines())["height"])
    rows = grid.split("\n")[:height]

    def middle(row: int, column: int) -> tuple[float, float]:
        # The first row is the northernmost one.
        return (column + 0.5) * cell, (height - row - 0.5) * cell

    free = {(row, column) for row, cells in enumerate(rows) for column, char in enumerate(cells) if char in ".GS"}
    found = []
    for row, column in sorted(free):
        for neighbour in ((row, column + 1), (row + 1, column)):
            if neighbour in free:
                found += Edge(line(middle(row, column), middle(*neighbour))).there_and_back()
    return found
