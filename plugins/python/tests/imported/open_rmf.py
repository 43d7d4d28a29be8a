"""Navigation graphs of Open-RMF: straight directed lanes between the vertices of a level.

They are written by ``building_map_generator`` in the style of PyYAML; this reads only that style.
"""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np

from imported.curves import Edge, line

SAME_PLACE = 0.01
"""Vertices of a lift that are nearer to the one below are moved, in metres."""
SHIFT = 0.02
"""The distance by which they are moved to the east, in metres."""


def edges(path: Path) -> list[Edge]:
    """Returns the lanes of all levels, and the edges of lifts."""
    levels = _yaml(path.read_text())["levels"]
    _part([content["vertices"] for content in levels.values()])
    found = []
    for level, content in levels.items():
        points = [(float(x), float(y)) for x, y, _ in content["vertices"]]
        for index, lane in enumerate(content["lanes"]):
            constraint = (lane[2] if len(lane) > 2 else {}).get("orientation_constraint", "")
            offset = math.pi if constraint == "backward" else 0.0
            found.append(Edge(line(points[lane[0]], points[lane[1]]), f"{level}/{index}", offset=offset))
    return [*found, *_lifts([content["vertices"] for content in levels.values()])]


def _lifts(levels: list[list[Any]]) -> list[Edge]:
    """Returns an edge each way between the cabins of a lift on consecutive levels."""
    found = []
    for lower, upper in zip(levels, levels[1:], strict=False):
        for lift in sorted({properties["lift"] for *_, properties in lower if properties.get("lift")}):
            ends = [[(x, y) for x, y, other in level if other.get("lift") == lift] for level in (lower, upper)]
            if len(ends[0]) == len(ends[1]) == 1:
                # A robot keeps the heading with which it has entered the cabin.
                found += Edge(line(ends[0][0], ends[1][0]), any_heading=True).there_and_back()
    return found


def _part(levels: list[list[Any]]) -> None:
    """Moves the vertices of lifts that are at the same place as those of the level below."""
    below: dict[str, Any] = {}
    for level in levels:
        for vertex in level:
            lift = vertex[2].get("lift")
            if not lift:
                continue
            if lift in below and np.hypot(vertex[0] - below[lift][0], vertex[1] - below[lift][1]) < SAME_PLACE:
                vertex[:2] = [below[lift][0] + SHIFT, below[lift][1]]
            below[lift] = vertex


def _yaml(text: str) -> Any:
    """Parses maps and lists in block style, with flow collections inside lines. Long ones go on in the next lines."""
    lines: list[tuple[int, str]] = []
    for row in text.split("\n"):
        if lines and _open(lines[-1][1]):
            lines[-1] = (lines[-1][0], lines[-1][1] + " " + row.strip())
        elif row.strip():
            lines.append((len(row) - len(row.lstrip()), row.strip()))
    value, rest = _block(lines)
    assert not rest, rest[:3]
    return value


def _open(text: str) -> bool:
    """Whether a flow collection goes on after a line."""
    return text.count("{") + text.count("[") > text.count("}") + text.count("]")


def _block(lines: list[tuple[int, str]]) -> tuple[Any, list[tuple[int, str]]]:
    """Parses the collection that the first line begins."""
    indent, first = lines[0]
    if first.startswith("- "):
        items = []
        while lines and lines[0][0] == indent and lines[0][1].startswith("- "):
            # The rest of the line is as if it stood in a line of its own.
            inner = lines[0][1][2:].lstrip()
            column = indent + len(lines[0][1]) - len(inner)
            if inner.startswith("- ") or _KEY.match(inner):
                item, lines = _block([(column, inner), *lines[1:]])
            else:
                item, lines = _flow(inner), lines[1:]
            items.append(item)
        return items, lines
    entries = {}
    while lines and lines[0][0] == indent and not lines[0][1].startswith("- "):
        match = _KEY.match(lines[0][1])
        assert match, lines[0]
        key, inner = str(_scalar(match[1])), (match[2] or "").strip()
        lines = lines[1:]
        if inner:
            entries[key] = _flow(inner)
        else:
            # Lists in maps aren't indented.
            entries[key], lines = _block(lines)
    return entries, lines


_KEY = re.compile(r"([^\[{'\":]+|'[^']*'):(?:\s+(.*))?$")
_TOKEN = re.compile(r"\s*([\[\]{},]|'(?:[^']|'')*'|\"[^\"]*\"|[^\[\]{},'\"]+)")


def _flow(text: str) -> Any:
    """Parses a value in flow style."""
    tokens = [token.strip() for token in _TOKEN.findall(text)]
    value, rest = _flow_value(tokens)
    assert not rest, text
    return value


def _flow_value(tokens: list[str]) -> tuple[Any, list[str]]:
    token, tokens = tokens[0], tokens[1:]
    if token == "[":
        items = []
        while tokens[0] != "]":
            item, tokens = _flow_value(tokens)
            items.append(item)
            tokens = tokens[1:] if tokens[0] == "," else tokens
        return items, tokens[1:]
    if token == "{":
        entries = {}
        while tokens[0] != "}":
            key, _, inner = tokens[0].partition(":")
            if inner.strip():
                entries[key], tokens = _scalar(inner.strip()), tokens[1:]
            else:
                entries[key], tokens = _flow_value(tokens[1:])
            tokens = tokens[1:] if tokens[0] == "," else tokens
        return entries, tokens[1:]
    return _scalar(token), tokens


def _scalar(text: str) -> Any:
    if text[:1] in "'\"" and len(text) > 1:
        return text[1:-1]
    for number in (int, float):
        try:
            return number(text)
        except ValueError:
            pass
    return {"true": True, "false": False, "null": None}.get(text, text)
