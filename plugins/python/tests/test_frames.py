"""Frames: their contents, their memory, and their lifetime."""

import os
import signal
import subprocess
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from conftest import PATIENCE, Engine, binary, eventually, let_ticks_pass, next_frame

import regatta
from regatta._contract import FrameHeader, Line


def test_a_frame_has_the_state_of_the_fleet(fleet: regatta.Fleet) -> None:
    ticks = []
    for frame in fleet.frames():
        ticks.append(frame.tick)
        assert len(frame) == 30 == frame.header.robots
        assert frame.sim_time == pytest.approx(frame.tick * 0.01), "100 ticks a second"
        assert {len(column) for column in (frame.x, frame.y, frame.theta, frame.speed, frame.s, frame.edge)} == {30}
        assert frame.x.dtype == np.float32 and frame.edge.dtype == np.uint32 and frame.state.dtype == np.uint8
        assert np.all(np.abs(frame.theta) <= np.pi) and np.all(np.abs(frame.speed) < 10)
        assert set(frame.state) <= {regatta.RobotState.IDLE, regatta.RobotState.DRIVING}
        if len(ticks) == 20:
            break
    assert ticks == sorted(set(ticks)), "each frame once, in order"


def test_missed_frames_are_counted_exactly(fleet: regatta.Fleet) -> None:
    ticks, missed = [], []
    for frame in fleet.frames(rate=20):
        ticks.append(frame.tick)
        missed.append(frame.missed)
        if len(ticks) == 10:
            break
    assert missed[0] == 0, "frames from before the reader joined don't count"
    assert [step - 1 for step in np.diff(ticks)] == missed[1:] and sum(missed) > 9


def test_a_paused_fleet_reads_the_same_from_rust(fleet: regatta.Fleet, engine: Engine) -> None:
    let_ticks_pass(fleet, 10)
    fleet.control().pause()
    frame = next_frame(fleet.frames())
    hello = engine.run(binary(), "plugin", "hello", "--fleet", engine.name)
    mean = [column.mean(dtype=np.float32) for column in (frame.x, frame.y)]
    line = hello.lines(1)[0]
    tick, rest = line.removeprefix("tick ").split(": centre (")
    centre = [float(number) for number in rest.removesuffix(") m").split(", ")]
    assert int(tick) == fleet.control().status().tick
    # The frame may be a tick older than the pause: nothing moves further than this in one.
    assert centre == pytest.approx(mean, abs=0.1)


def test_a_robot_is_on_its_edge(fleet: regatta.Fleet) -> None:
    frame = next_frame(fleet.frames())
    edges, nodes = frame.world.edges[frame.edge], frame.world.nodes
    at_start = frame.s == 0
    assert np.all(frame.s <= edges["length"] * 1.001)
    origin = nodes[edges["origin"][at_start]]
    np.testing.assert_allclose(frame.x[at_start], origin["x"], atol=1e-4)
    assert np.all(edges["curves"] == 1) and frame.world.origin == (0.0, 0.0)
    points = frame.world.curves[edges["first_curve"]]
    pose = np.column_stack([frame.x, frame.y])
    inside = (points.min(axis=1) - 0.01 <= pose) & (pose <= points.max(axis=1) + 0.01)
    assert np.all(inside), "inside the hull of its control points"


def test_columns_are_read_only_views(fleet: regatta.Fleet) -> None:
    frame = next_frame(fleet.frames())

    def all_columns() -> list[npt.NDArray[Any]]:
        return [frame.x, frame.y, frame.theta, frame.speed, frame.s, frame.edge, frame.state]

    columns = all_columns()
    for column, again in zip(columns, all_columns()):
        assert not column.flags.owndata and column.flags.aligned and column.flags.c_contiguous
        assert np.shares_memory(column, again)
        assert column.__array_interface__["data"][0] % 64 == 0, "a cache line"
        with pytest.raises(ValueError, match="read-only"):
            column[0] = 1
        with pytest.raises(ValueError, match="WRITEABLE"):
            column.flags.writeable = True
    gaps = np.diff([column.__array_interface__["data"][0] for column in columns])
    assert list(gaps) == [2 * 64] * 6, "thirty robots are two lines a column, one column after the other"


def test_a_held_frame_is_unchanged_even_when_its_engine_dies(engine: Engine) -> None:
    process = engine.start()
    fleet = regatta.join(engine.name, "test")
    frames = fleet.frames()
    held = next_frame(frames)
    x, copy = held.x, held.x.copy()
    del held
    let_ticks_pass(fleet, 100)
    np.testing.assert_array_equal(x, copy)
    process.kill()
    engine.start()
    next_frame(frames)
    let_ticks_pass(fleet, 100)
    np.testing.assert_array_equal(x, copy)


def test_a_frame_is_unchanged_after_its_reader_is_gone(engine: Engine) -> None:
    """Otherwise the engine would take the memory back, and write to it, while arrays still refer to it."""
    fleet = regatta.join(engine.name, "test")
    frames = fleet.frames()
    engine.start("--speed", "max")
    x = next_frame(frames).x
    copy = x.copy()
    del frames
    others = [regatta.frames(engine.name) for _ in range(4)]
    held = []
    for other in 2 * others:
        # The more different frames are held, the more of its memory the engine uses.
        held.append(next_frame(other))
        let_ticks_pass(other.fleet, 10)
    np.testing.assert_array_equal(x, copy)


def test_a_reader_holds_at_most_two_frames(fleet: regatta.Fleet) -> None:
    frames = fleet.frames()
    held = []
    with pytest.raises(regatta.HeldError, match=r"copy\(\)"):
        for frame in frames:
            held.append(frame.x)
    assert len(held) == 2
    held.clear()
    del frame
    assert len(next_frame(frames)) == 30, "the reader continues"


def test_a_loop_can_keep_the_previous_frame(fleet: regatta.Fleet) -> None:
    previous: regatta.Frame | None = None
    for count, frame in enumerate(fleet.frames()):
        if previous is not None:
            moved = np.hypot(frame.x - previous.x, frame.y - previous.y)
            limit = 10 * (frame.sim_time - previous.sim_time)
            assert frame.tick > previous.tick and np.all(moved <= limit)
        previous = frame
        if count == 50:
            break


def test_the_rate_is_kept(fleet: regatta.Fleet) -> None:
    ticks = []
    for frame in fleet.frames(rate=20):
        ticks.append(frame.tick)
        if len(ticks) == 21:
            break
    # A frame that a busy machine delays comes late, and the next one in time: only the mean is certain.
    assert (ticks[-1] - ticks[0]) / 20 >= 4, "20 of 100 frames a second"
    for rate in (0, -1, float("nan"), 1e7):
        with pytest.raises(ValueError, match="rate"):
            fleet.frames(rate=rate)


def test_a_reader_waits_for_the_engine_and_outlives_it(engine: Engine) -> None:
    # It also opens everything else first: the engine must find the services as it would have created them.
    reader = engine.python(
        "fleet = regatta.join(FLEET, 'early')\n"
        "ports = fleet.commands(), fleet.control(), fleet.events(), fleet.command_log(), fleet.contacts(),"
        " fleet.contact_events(), fleet._column_values('type'), fleet.column('mine')\n"
        "run = 0\n"
        "for frame in fleet.frames():\n"
        "    if frame.run_id != run:\n"
        "        run = frame.run_id\n"
        "        print(run, len(frame.world.edges), flush=True)\n"
    )
    eventually("the message", lambda: "\n" in reader.errors or None)
    assert reader.errors == f"early: waiting for an engine of fleet '{engine.name}'\n"
    first = engine.start()
    runs = reader.lines(1)
    first.kill()
    second = engine.start()
    runs += reader.lines(1)
    second.end()
    engine.start(scenario="warehouse-1000.yaml")
    runs += reader.lines(1)
    assert len({line.split()[0] for line in runs}) == 3, runs
    edges = [int(line.split()[1]) for line in runs]
    assert edges[0] == edges[1] < edges[2], "the third engine has another world"
    reader.end()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_loop_and_nothing_is_left(engine: Engine, number: int) -> None:
    process = engine.start()
    reader = engine.python(
        "for frame in regatta.frames(FLEET): print(frame.tick, flush=True)\nprint('after the loop')\n"
    )
    assert all(int(line) >= 0 for line in reader.lines(3))
    assert reader.end(number).endswith("after the loop\n") and reader.errors == ""
    process.end()
    # The ports of this process were opened by the fixture's helper and are garbage by now.
    assert not [line for line in doctor() if engine.name in line]


def test_a_second_ctrl_c_ends_a_loop_that_hangs(engine: Engine) -> None:
    engine.start()
    reader = engine.python(
        "import time\n"
        "for frame in regatta.frames(FLEET):\n"
        "    print('in', flush=True)\n"
        "    while True:\n"
        "        time.sleep(0.01)\n"
    )
    reader.lines(1)

    def interrupt() -> int | None:
        reader.send(signal.SIGINT)
        return reader.child.poll()

    assert eventually("the end of the process", interrupt) != 0
    assert "KeyboardInterrupt" in reader.errors


def test_a_wrong_version_is_one_clear_error(engine: Engine) -> None:
    other = engine.python(
        "from regatta import _node\n"
        "_node.CONTRACT_VERSION = 4711\n"
        "fleet = regatta.join(FLEET)\n"
        "print('open', flush=True)\n"
        "import time; time.sleep(600)\n"
    )
    assert other.lines(1) == ["open"]
    with pytest.raises(regatta.VersionError) as error:
        regatta.join(engine.name)
    message = str(error.value)
    assert "4711" in message and f"version {regatta.CONTRACT_VERSION}" in message and "\n" not in message
    refused = subprocess.run(
        [binary(), "plugin", "hello", "--fleet", engine.name], capture_output=True, text=True, timeout=PATIENCE
    )
    assert refused.returncode == 1 and "4711" in refused.stderr, "Rust reads the attribute that Python writes"


def test_a_frame_that_contradicts_its_header_is_an_error(engine: Engine) -> None:
    """The test itself is the producer."""
    fleet = regatta.join(engine.name)
    frames, sender = fleet.frames(), fleet._node.sender("frames", "frames", Line, FrameHeader)
    fits = FrameHeader(tick=1, robots=20, stride_lines=2)
    sender.send(fits, 13, lambda memory: memory.fill(0))
    assert len(next_frame(frames)) == 20
    for header in (
        FrameHeader(robots=40, stride_lines=3),
        FrameHeader(robots=20, stride_lines=1),
        FrameHeader(robots=2**32 - 1, stride_lines=2**28),
    ):
        sender.send(header, 13, lambda memory: memory.fill(0))
        with pytest.raises(regatta.ReadError, match="at fault"):
            frames.latest()
    sender.send(FrameHeader(), 0, lambda memory: None)
    assert len(next_frame(frames)) == 0, "a fleet without robots"
    sender.send(FrameHeader(run_id=1, world_revision=1), 0, lambda memory: None)
    with pytest.raises(regatta.ReadError, match="world"):
        next_frame(frames).world


def test_names_are_checked() -> None:
    for bad in ("", "a b", "a/b", "é", "x" * 65):
        with pytest.raises(ValueError, match="name"):
            regatta.join(bad)


def doctor() -> list[str]:
    """Returns the report of `regatta doctor` about shared memory, line by line."""
    environment = {**os.environ, "IOX2_LOG_LEVEL": "Fatal"}
    report = subprocess.run([binary(), "doctor"], capture_output=True, text=True, timeout=PATIENCE, env=environment)
    return report.stdout.splitlines()


def test_the_first_access_to_a_column_finds_its_values(fleet: regatta.Fleet) -> None:
    let_ticks_pass(fleet, 3)
    fleet.control().pause()
    values = next_frame(fleet.frames()).column("type")
    assert values is not None and len(values.values) == 30
