"""Frames as tables, for data frames and for notebooks."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from regatta._contract import NO_EDGE
from regatta._enums import RobotState

if TYPE_CHECKING:
    import pandas
    import polars

    from regatta._frame import Frame

FLOATS = "x", "y", "theta", "speed", "s"
STATES = [state.name.lower() for state in RobotState if state != RobotState.ABSENT]
SHOWN = 8
"""The number of robots in a notebook's picture of a frame."""


def to_pandas(frame: Frame) -> pandas.DataFrame:
    """Returns a frame as a data frame of pandas."""
    pd = _package("pandas")
    robots = _robots(frame)
    edge = frame.edge[robots]
    columns = {
        "tick": np.full(len(robots), frame.tick, np.uint64),
        "sim_time": np.full(len(robots), frame.sim_time),
        **{name: getattr(frame, name)[robots] for name in FLOATS},
        "edge": pd.arrays.IntegerArray(edge, edge == NO_EDGE),
        "state": pd.Categorical.from_codes(frame.state[robots].astype(np.int8), STATES),
    }
    table: pandas.DataFrame = pd.DataFrame(columns, index=pd.Index(robots, name="robot"))
    return table


def to_polars(frame: Frame) -> polars.DataFrame:
    """Returns a frame as a data frame of polars."""
    pl = _package("polars")
    robots = _robots(frame)
    edge = frame.edge[robots]
    columns = {
        "robot": robots.astype(np.uint32),
        **{name: getattr(frame, name)[robots] for name in FLOATS},
        "edge": pl.Series(edge).set(pl.Series(edge == NO_EDGE), None),
        "state": pl.Series(STATES, dtype=pl.Enum(STATES)).gather(frame.state[robots]),
    }
    table: polars.DataFrame = pl.DataFrame(columns).select(
        pl.lit(frame.tick, pl.UInt64).alias("tick"), pl.lit(frame.sim_time, pl.Float64).alias("sim_time"), pl.all()
    )
    return table


def to_html(frame: Frame) -> str:
    """Returns the first robots of a frame as a table."""
    names = "robot", *FLOATS, "edge", "state"
    rows = []
    for robot in _robots(frame)[:SHOWN]:
        floats = [f"{getattr(frame, name)[robot]:.3f}" for name in FLOATS]
        edge = "" if frame.edge[robot] == NO_EDGE else frame.edge[robot]
        rows.append([robot, *floats, edge, STATES[frame.state[robot]]])
    head = "".join(f"<th>{name}</th>" for name in names)
    body = "".join("<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>" for row in rows)
    caption = f"tick {frame.tick} ({frame.sim_time:.2f} s), {len(frame)} robots"
    more = "" if len(rows) == len(frame) else f"<p>{len(rows)} of {len(frame)} rows</p>"
    return f"<table><caption>{caption}</caption><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{more}"


def _robots(frame: Frame) -> npt.NDArray[np.intp]:
    """Returns the rows that hold a robot."""
    return np.flatnonzero(frame.state != RobotState.ABSENT)


def _package(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError:
        raise ImportError(
            f"frame.to_{name} needs the package '{name}'; install it, for example with `pip install 'regatta-sim[{name}]'`"
        ) from None
