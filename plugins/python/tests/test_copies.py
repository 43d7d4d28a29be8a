"""Frames that outlive their reader, their loop or their notebook's cell: copies, displayed frames, and data frames."""

import importlib
import sys
from typing import Any, cast

import numpy as np
import numpy.typing as npt
import pytest
from conftest import Engine, eventually, let_ticks_pass, next_frame

import regatta
from regatta import RobotState
from regatta._contract import EdgeRecord, FrameHeader, Line, WorldHeader, dtype

TABLE = ["tick", "sim_time_s", "x_m", "y_m", "theta_rad", "speed_m_per_s", "s_m", "edge", "state"]
COLUMNS = "x", "y", "theta", "speed", "s", "edge", "state"


def test_a_copy_equals_its_frame_and_holds_no_shared_memory(fleet: regatta.Fleet) -> None:
    frames = fleet.frames()
    copies: list[regatta.Frame] = []
    for frame in frames:
        copy = frame.copy()
        assert type(copy) is regatta.Frame and (copy.tick, copy.run_id) == (frame.tick, frame.run_id)
        assert (len(copy), copy.sim_time, copy.missed) == (len(frame), frame.sim_time, frame.missed)
        for name in COLUMNS:
            ours, theirs = getattr(copy, name), getattr(frame, name)
            np.testing.assert_array_equal(ours, theirs)
            assert ours.dtype == theirs.dtype and not np.shares_memory(ours, theirs)
        copies.append(copy)
        if len(copies) == 10:
            break
    assert len({copy.tick for copy in copies}) == 10
    copies[0].x[3] = 4711.0
    assert copies[0].x[3] == 4711.0 != frame.x[3], "its arrays can be changed"


def test_a_copy_keeps_its_world_when_the_engine_restarts(engine: Engine) -> None:
    process = engine.start()
    fleet = regatta.join(engine.name, "test")
    frames = fleet.frames()
    copy = next_frame(frames).copy()
    edges = len(copy.world.edges)
    process.kill()
    engine.start(scenario="warehouse-1000.yaml")
    eventually("a frame of the second run", lambda: next_frame(frames).run_id != copy.run_id or None)
    assert len(fleet.world().edges) > edges == len(copy.world.edges)


def test_a_frame_is_unchanged_after_its_fleet_is_closed(engine: Engine) -> None:
    with regatta.join(engine.name, "test") as fleet:
        frames = fleet.frames()
        engine.start("--speed", "max")
        x = next_frame(frames).x
        copy = x.copy()
    others = [regatta.frames(engine.name) for _ in range(4)]
    held = []
    for other in 2 * others:
        # The more different frames are held, the more of its memory the engine uses.
        held.append(next_frame(other))
        let_ticks_pass(other.fleet, 10)
    np.testing.assert_array_equal(x, copy)


@pytest.fixture
def notebook() -> Any:
    """A notebook's shell, as Jupyter runs it."""
    from IPython.core.interactiveshell import InteractiveShell

    shell: Any = cast(Any, InteractiveShell)()
    # Jupyter asks an object for all of its pictures: as text and as HTML.
    shell.display_formatter.active_types = shell.display_formatter.format_types
    yield shell
    shell.reset(new_session=False)
    shell.history_manager.end_session()


def test_displayed_frames_dont_fill_up_a_notebook(notebook: Any, fleet: regatta.Fleet) -> None:
    notebook.push({"frames": fleet.frames(), "next_frame": next_frame})
    for cell in ["next_frame(frames)", "frame = next_frame(frames); frame", "[next_frame(frames)]"] * 3:
        result = notebook.run_cell(cell, store_history=True)
        result.raise_error()
    out = notebook.user_ns["Out"]
    assert len(out) == 9, "the notebook still has all of them"
    assert out[1].tick < out[4].tick < out[7].tick
    assert len(out[1].x) == 30 and not out[1].x.flags.writeable


def test_displayed_arrays_are_an_error_that_says_what_holds_them(notebook: Any, fleet: regatta.Fleet) -> None:
    notebook.push({"frames": fleet.frames(), "next_frame": next_frame})
    for _ in range(2):
        notebook.run_cell("next_frame(frames).x", store_history=True).raise_error()
    result = notebook.run_cell("next_frame(frames).x", store_history=True)
    with pytest.raises(regatta.HeldError, match=r"Out\[\].*frame\.x\.copy\(\)"):
        result.raise_error()


def test_a_displayed_column_doesnt_stay_pinned(notebook: Any, fleet: regatta.Fleet) -> None:
    column, frames = fleet.column("mine"), fleet.frames()
    frame = next_frame(frames)

    def read(value: float) -> regatta.ColumnValues:
        column.publish(frame, np.full(30, value))
        values = frame.column("mine")
        assert values is not None
        return values

    notebook.push({"read": read})
    for value in range(5):
        notebook.run_cell(f"read({value})", store_history=True).raise_error()
    shown = notebook.user_ns["Out"]
    assert [values.values[29] for values in shown.values()] == [0, 1, 2, 3, 4]
    kept = [read(value).copy() for value in (7, 8, 9)]
    assert [copy.values[0] for copy in kept] == [7, 8, 9]


def test_the_text_of_a_frame_says_what_it_is(fleet: regatta.Fleet) -> None:
    frame = next_frame(fleet.frames())
    shared = frame.x
    assert str(frame) == f"<regatta.Frame: tick {frame.tick} ({frame.sim_time:.2f} s), 30 robots>"
    assert np.shares_memory(frame.x, shared), "printing it copies nothing"
    assert repr(frame) == str(frame)
    assert not np.shares_memory(frame.x, shared) and not frame.x.flags.writeable
    np.testing.assert_array_equal(frame.x, shared)
    html = frame._repr_html_()
    assert f"tick {frame.tick}" in html and "30 robots" in html and "<th>theta_rad</th>" in html and "driving" in html
    assert html.count("<tr>") < 15, "the first robots only"


@pytest.fixture
def sparse(engine: Engine) -> regatta.Frame:
    """A frame of four robots, one of which is absent and one on no edge. The test itself is the producer."""
    fleet = regatta.join(engine.name)
    frames, sender = fleet.frames(), fleet._node.sender("frames", "frames", Line, FrameHeader)

    def fill(memory: Any) -> None:
        columns = memory[: 6 * 64].view(np.float32).reshape(6, 16)
        columns[:5] = np.arange(5)[:, None] + np.arange(16) / 16
        columns[5].view(np.uint32)[:4] = [3, regatta.NO_EDGE, 7, 3]
        memory[6 * 64 :][:4] = [RobotState.DRIVING, RobotState.IDLE, RobotState.ABSENT, RobotState.HELD]

    def fill_edges(memory: Any) -> None:
        memory[:] = 0
        memory.view(dtype(EdgeRecord))["id"] = 100 + np.arange(8)

    worlds = fleet._node.sender("world", "the world", Line, WorldHeader)
    worlds.send(WorldHeader(revision=1, edges=8), 8, fill_edges)
    header = FrameHeader(tick=120, robots=4, stride_lines=1, sim_time_nanos=1_200_000_000, clock=1, speed=2.0)
    sender.send(header, 7, fill)
    frame = next_frame(frames)
    assert len(frame.world.edges) == 8, "received while its sender is there"
    return frame


def test_a_frame_knows_the_clock(sparse: regatta.Frame) -> None:
    assert sparse.clock is regatta.ClockState.PAUSED


def test_a_frame_as_a_data_frame_of_pandas(sparse: regatta.Frame) -> None:
    table = sparse.to_pandas()
    assert list(table.columns) == TABLE
    assert list(table.index) == [0, 1, 3] and table.index.name == "robot", "absent robots have no row"
    assert set(table.tick) == {120} and set(table.sim_time_s) == {1.2}
    assert list(table.state) == ["driving", "idle", "held"]
    assert table.x_m.dtype == np.float32 and table.loc[3, "x_m"] == sparse.x[3]
    assert list(table.edge.isna()) == [False, True, False] and list(table.edge.dropna()) == [103, 103], "ids"
    table.loc[0, "x_m"] = 4711.0
    assert sparse.x[0] == 0.0, "a copy"


def test_a_frame_as_a_data_frame_of_polars(sparse: regatta.Frame) -> None:
    table = sparse.to_polars()
    assert table.columns == [*TABLE[:2], "robot", *TABLE[2:]]
    assert table["robot"].to_list() == [0, 1, 3]
    assert set(table["tick"]) == {120} and set(table["sim_time_s"]) == {1.2}
    assert table["state"].to_list() == ["driving", "idle", "held"]
    assert table["y_m"].to_list() == [1.0, 1.0625, 1.1875] and table["edge"].to_list() == [103, None, 103]


def test_a_table_has_the_activities_that_a_manager_publishes(sparse: regatta.Frame) -> None:
    """The test itself is the manager, too."""
    column = sparse._fleet.column("activity")

    def publish(*numbers: float) -> None:
        column.publish(sparse, numbers)
        eventually("the activities", lambda: list(values_of(sparse)) == list(numbers) or None)

    early = sparse.copy()
    publish(regatta.Activity.CARRYING, 0.5, regatta.Activity.IDLE, regatta.Activity.HELD)
    copy = sparse.copy()
    publish(*[regatta.Activity.QUEUED] * 4)
    assert "activity" not in early.to_pandas() and "activity" not in early.to_polars()
    assert list(sparse.to_pandas().activity) == ["queued"] * 3
    assert copy.to_pandas().activity.to_dict()[0] == "carrying" and copy.to_pandas().activity.isna()[1]
    assert copy.to_polars()["activity"].to_list() == ["carrying", None, "held"]
    html = sparse._repr_html_()
    assert "<th>activity</th>" in html and html.count("<td>queued</td>") == 3


def test_a_table_has_the_other_columns_of_an_export(sparse: regatta.Frame) -> None:
    waits_for, battery = (sparse._fleet.column(name) for name in ("waits-for", "battery"))
    waits_for.publish(sparse, [3.0, np.nan, 0.0, 0.0])
    battery.publish(sparse, [0.5, np.nan, 1.0, 2.0])
    table, polars = sparse.to_pandas(), sparse.to_polars()
    assert list(table.columns)[-2:] == polars.columns[-2:] == ["battery", "waits_for"]
    assert polars["waits_for"].to_list() == [3, None, 0]
    assert table.waits_for.isna()[1] and table.waits_for[0] == 3
    assert table.battery[0] == 0.5 and np.isnan(table.battery[1])


def values_of(frame: regatta.Frame) -> npt.NDArray[np.float32]:
    values = frame.column("activity")
    return np.empty(0, np.float32) if values is None else values.values


def test_data_frames_of_a_loop_hold_no_frames(fleet: regatta.Fleet) -> None:
    pandas, polars = [], []
    for frame in fleet.frames():
        pandas.append(frame.to_pandas())
        polars.append(frame.to_polars())
        if len(pandas) == 5:
            break
    assert [len(table) for table in pandas] == [len(table) for table in polars] == [30] * 5
    assert pandas[0].tick[0] < pandas[4].tick[0] == polars[4]["tick"][0]


@pytest.mark.parametrize("package", ["pandas", "polars"])
def test_a_missing_package_is_one_clear_error(
    sparse: regatta.Frame, package: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    importlib.import_module(package)
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(ImportError, match=rf"pip install 'regatta-sim\[{package}\]'"):
        getattr(sparse, f"to_{package}")()
