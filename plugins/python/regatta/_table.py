"""Frames as tables, for data frames and for notebooks.

The columns have the names of those of ``regatta export``, with their units.
"""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from regatta._contract import NO_EDGE
from regatta._enums import Activity, RobotState

if TYPE_CHECKING:
    import pandas
    import polars

    from regatta._frame import Frame

FLOATS = {"x": "x_m", "y": "y_m", "theta": "theta_rad", "speed": "speed_m_per_s", "s": "s_m"}
"""The columns of 32-bit floats, by the attributes of a frame."""
WORDS = {
    "state": [state.name.lower() for state in RobotState if state != RobotState.ABSENT],
    "activity": [activity.word for activity in Activity],
}
"""The columns of words, and their words by number."""
NO_WORD = -1
"""The number of a word that is missing."""
PUBLISHED = {
    "activity": "activity",
    "battery": "battery",
    "collision": "collision",
    "goal": "goal",
    "type": "type",
    "waits_for": "waits-for",
}
"""The columns that processes publish, by their names in a table; in the order of an export."""
NUMBERS = ["edge", "collision", "goal", "type", "waits_for"]
"""The columns of numbers of which some may be missing: they are :data:`NO_EDGE` then."""
SHOWN = 8
"""The number of robots in a notebook's picture of a frame."""

Rows = dict[str, npt.NDArray[Any]]
"""A table: its columns by name. Columns of words have numbers."""


def rows_of(frame: Frame) -> Rows:
    """Returns a row for each robot of a frame, with those of the published columns that processes have published."""
    robots = np.flatnonzero(frame.state != RobotState.ABSENT)
    rows: Rows = {
        "tick": np.full(len(robots), frame.tick, np.uint64),
        "sim_time_s": np.full(len(robots), frame.sim_time),
        "robot": robots.astype(np.uint32),
        **{name: getattr(frame, attribute)[robots] for attribute, name in FLOATS.items()},
        "edge": _edge_ids(frame, robots),
        "state": frame.state[robots].astype(np.int8),
    }
    published = frame._published_columns()
    for name, column in PUBLISHED.items():
        if (values := published.get(column)) is not None:
            rows[name] = _published(name, values.values, robots)
    return rows


def joined(tables: Sequence[Rows]) -> Rows:
    """Returns the rows of several tables, one after the other. Words that some of them lack are missing there."""
    names = dict.fromkeys(name for table in tables for name in table)
    return {name: np.concatenate([_column(table, name) for table in tables]) for name in names}


def to_pandas(rows: Rows) -> pandas.DataFrame:
    """Returns a table as a data frame of pandas."""
    pd = package("pandas")
    columns = dict(rows)
    for name in set(NUMBERS) & set(rows):
        columns[name] = pd.arrays.IntegerArray(rows[name], rows[name] == NO_EDGE)
    for name, words in WORDS.items():
        if name in rows:
            columns[name] = pd.Categorical.from_codes(rows[name], words)
    table: pandas.DataFrame = pd.DataFrame(columns)
    return table


def to_polars(rows: Rows) -> polars.DataFrame:
    """Returns a table as a data frame of polars."""
    pl = package("polars")
    columns: dict[str, Any] = dict(rows)
    for name in set(NUMBERS) & set(rows):
        columns[name] = pl.Series(rows[name]).set(pl.Series(rows[name] == NO_EDGE), None)
    for name, words in WORDS.items():
        if name in rows:
            numbers = pl.Series(rows[name]).set(pl.Series(rows[name] == NO_WORD), None)
            columns[name] = pl.Series(words, dtype=pl.Enum(words)).gather(numbers)
    table: polars.DataFrame = pl.DataFrame(columns)
    return table


def to_html(frame: Frame) -> str:
    """Returns the first robots of a frame as a table."""
    rows = rows_of(frame)
    names = [name for name in rows if name not in ("tick", "sim_time_s")]
    head = "".join(f"<th>{name}</th>" for name in names)
    count = min(SHOWN, len(rows["robot"]))
    lines = ["".join(f"<td>{_cell(name, rows[name][row])}</td>" for name in names) for row in range(count)]
    body = "".join(f"<tr>{line}</tr>" for line in lines)
    caption = f"tick {frame.tick} ({frame.sim_time:.2f} s), {len(frame)} robots"
    more = "" if count == len(frame) else f"<p>{count} of {len(frame)} rows</p>"
    return f"<table><caption>{caption}</caption><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{more}"


def package(name: str) -> Any:
    """Returns a package that makes data frames, or raises ``ImportError`` with the command that installs it."""
    try:
        return importlib.import_module(name)
    except ImportError:
        raise ImportError(
            f"to_{name} needs the package '{name}'; install it, for example with `pip install 'regatta-sim[{name}]'`"
        ) from None


def _edge_ids(frame: Frame, robots: npt.NDArray[np.intp]) -> npt.NDArray[np.uint32]:
    """Returns the ids of the edges that robots are on, which exports have; a frame has indices."""
    ids, index = frame.world.edges["id"], frame.edge[robots]
    edges = np.full(len(robots), NO_EDGE, np.uint32)
    known = index < len(ids)
    edges[known] = ids[index[known]]
    return edges


def _published(name: str, published: npt.NDArray[np.float32], robots: npt.NDArray[np.intp]) -> npt.NDArray[Any]:
    """Returns the values of robots in a published column, as a column of a table."""
    if name in WORDS:
        return _activities(published, robots)
    return _numbers(published, robots) if name in NUMBERS else _of_robots(published, robots)


def _activities(published: npt.NDArray[np.float32], robots: npt.NDArray[np.intp]) -> npt.NDArray[np.int8]:
    """Returns the numbers of robots' activities. Robots without one have none: one that is new, for example."""
    values = _of_robots(published, robots)
    return np.where(np.isin(values, list(Activity)), values, NO_WORD).astype(np.int8)


def _numbers(published: npt.NDArray[np.float32], robots: npt.NDArray[np.intp]) -> npt.NDArray[np.uint32]:
    """Returns robots' numbers of a column, such as ids. Robots without one have none."""
    values = _of_robots(published, robots)
    known = (values >= 0) & (values < NO_EDGE)
    return np.where(known, np.where(known, values, 0).astype(np.uint32), np.uint32(NO_EDGE))


def _of_robots(published: npt.NDArray[np.float32], robots: npt.NDArray[np.intp]) -> npt.NDArray[np.float32]:
    """Returns the published values of robots; NaN of those that are newer than the column."""
    values = np.full(len(robots), np.nan, np.float32)
    known = robots < len(published)
    values[known] = published[robots[known]]
    return values


def _column(table: Rows, name: str) -> npt.NDArray[Any]:
    if name in table:
        return table[name]
    if name in WORDS:
        return np.full(len(table["robot"]), NO_WORD, np.int8)
    missing = np.uint32(NO_EDGE) if name in NUMBERS else np.float32(np.nan)
    return np.full(len(table["robot"]), missing)


def _cell(name: str, value: Any) -> str:
    if name in WORDS:
        return "" if value == NO_WORD else WORDS[name][value]
    if name in NUMBERS and value == NO_EDGE:
        return ""
    return f"{value:.3f}" if name in FLOATS.values() else str(value)
