"""Commands, control requests and columns that programs send, and the events that answer commands."""

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pandas
import pytest
from conftest import Engine, eventually, let_ticks_pass, next_frame

import regatta
from regatta import EventKind, RobotState


@pytest.fixture
def warehouse(engine: Engine) -> regatta.Fleet:
    """A fleet of twenty robots that never stop."""
    engine.start("--robots", "20", scenario="warehouse-1000.yaml")
    return regatta.join(engine.name, "manager")


class Answers:
    """Collects events, and finds the one that answers a command."""

    def __init__(self, fleet: regatta.Fleet) -> None:
        self.reader = fleet.events()
        self.seen: list[np.void] = []

    def wait(self, what: str, wanted: Callable[[np.void], bool]) -> np.void:
        def find() -> np.void | None:
            self.seen += [record for tick in self.reader.take() for record in tick.records]
            return next((record for record in self.seen if wanted(record)), None)

        return eventually(what, find)

    def to(self, token: int) -> np.void:
        """Waits for the event that accepts or refuses a command."""
        ends = EventKind.ACCEPTED, EventKind.REFUSED
        return self.wait("an answer", lambda record: record["token"] == token and record["kind"] in ends)


def test_a_held_robot_stands_until_it_is_resumed(warehouse: regatta.Fleet) -> None:
    answers, commands, frames = Answers(warehouse), warehouse.commands(), warehouse.frames()
    token = commands.hold(7)
    assert len(commands) == 1
    commands.send()
    assert len(commands) == 0
    assert answers.to(token)["kind"] == EventKind.ACCEPTED
    answers.wait("the robot stands", lambda record: record["kind"] == EventKind.HELD and record["robot"] == 7)
    before = next_frame(frames)
    let_ticks_pass(warehouse, 100)
    after = next_frame(frames)
    assert after.tick >= before.tick + 50
    assert before.state[7] == after.state[7] == RobotState.HELD and after.speed[7] == 0
    assert (before.x[7], before.y[7]) == (after.x[7], after.y[7])
    assert np.any((before.x != after.x) | (before.y != after.y)), "the other robots drive"
    commands.resume(np.int64(7))
    commands.send()
    del before

    def moves() -> bool | None:
        frame = next_frame(frames)
        return frame.state[7] != RobotState.HELD and (frame.x[7], frame.y[7]) != (after.x[7], after.y[7]) or None

    eventually("the robot drives on", moves)


def test_commands_are_accepted_or_refused(engine: Engine) -> None:
    engine.start("--robots", "0")
    fleet = regatta.join(engine.name, "manager")
    answers, commands, log = Answers(fleet), fleet.commands(), fleet.command_log()
    edge = fleet.world().edges[0]
    spawned = commands.spawn_on_edge(0, edge["id"], 0.5)
    commands.send()
    robot = int(answers.wait("a spawned robot", lambda record: record["kind"] == EventKind.SPAWNED)["robot"])
    edges, node = fleet.world().edges, fleet.world().nodes["id"][0]
    onward = next(other for other in edges if other["origin"] == edge["destination"])
    beyond = next(other for other in edges if other["origin"] == onward["destination"])
    tokens = [
        spawned,
        commands.assign(robot, [onward["id"]]),
        commands.extend(robot, [regatta.Leg(beyond["id"], released=False)]),
        commands.cancel(robot),
        commands.hold(robot),
        commands.resume(robot),
        commands.spawn_at_node(0, node),
        commands.remove(robot),
    ]
    refused = {
        commands.hold(4711): regatta.Refusal.UNKNOWN_ROBOT,
        commands.spawn_at_node(9, node): regatta.Refusal.UNKNOWN_ROBOT_TYPE,
        commands.spawn_on_edge(0, edge["id"], 1e6): regatta.Refusal.DISTANCE_OUT_OF_RANGE,
        commands.spawn_at_node(0, 4711): regatta.Refusal.UNKNOWN_NODE,
    }
    commands.send()
    assert len(set(tokens)) == len(tokens)
    assert [EventKind(answers.to(token)["kind"]) for token in tokens] == [EventKind.ACCEPTED] * len(tokens)
    for token, reason in refused.items():
        answer = answers.to(token)
        assert (answer["kind"], answer["detail"]) == (EventKind.REFUSED, reason)
    logged = [token for tick in log.take() for token in tick.records["token"]]
    assert set(tokens) | refused.keys() == set(logged)


def test_a_closed_edge_is_entered_by_nobody_and_known_to_late_readers(warehouse: regatta.Fleet) -> None:
    answers, commands, frames = Answers(warehouse), warehouse.commands(), warehouse.frames()
    edges = warehouse.world().edges["id"]
    tokens = commands.close_edge([edges[3], edges[5]])
    commands.send()
    assert [answers.to(token)["kind"] for token in tokens] == [EventKind.ACCEPTED] * 2
    closed = answers.wait("an event", lambda record: record["kind"] == EventKind.EDGE_CLOSED)
    assert (closed["id"], closed["robot"]) == (edges[3], regatta.NO_ROBOT)
    late = warehouse.closures()
    eventually("the closed edges", lambda: late.latest() or None)
    run_id = next_frame(frames).run_id
    assert list(late.edges(run_id)) == sorted([edges[3], edges[5]]) and len(late.edges(run_id + 1)) == 0
    token = commands.open_edge(edges[3])
    commands.send()
    assert answers.to(token)["kind"] == EventKind.ACCEPTED
    eventually("the change", lambda: late.latest() or None)
    assert list(late.edges(run_id)) == [edges[5]]


def test_commands_are_checked_before_they_are_sent(warehouse: regatta.Fleet) -> None:
    commands = warehouse.commands()
    for bad in (-1, 2**32):
        with pytest.raises(ValueError, match="robot"):
            commands.hold(bad)
        with pytest.raises(ValueError, match="edge"):
            commands.assign(0, [0, bad])
    with pytest.raises(TypeError, match="str"):
        commands.hold("a")  # type: ignore[arg-type]
    with pytest.raises(TypeError):
        commands.hold(1.5)  # type: ignore[call-overload]
    assert len(commands) == 0, "no part of an invalid command is kept"


def test_commands_for_arrays_of_robots(engine: Engine) -> None:
    engine.start("--robots", "0", scenario="warehouse-1000.yaml")
    fleet = regatta.join(engine.name, "manager")
    answers, commands, log = Answers(fleet), fleet.commands(), fleet.command_log()
    fleet.control().pause()
    nodes, edges = fleet.world().nodes["id"], fleet.world().edges

    def accepted(tokens: npt.NDArray[np.uint64]) -> None:
        assert tokens.dtype == np.uint64 and len(set(tokens)) == len(tokens)
        commands.send()
        fleet.control().step(1)
        assert {EventKind(answers.to(token)["kind"]) for token in tokens} == {EventKind.ACCEPTED}

    accepted(commands.spawn_at_node(0, nodes[:3]))
    accepted(commands.spawn_on_edge([0, 0], edges["id"][:2], s=[0.25, 0.5]))
    accepted(commands.hold(np.arange(5)))
    assert set(next_frame(fleet.frames()).state[:5]) == {RobotState.HELD}
    accepted(commands.resume([0, 2, 4]))
    states = next_frame(fleet.frames()).state
    assert set(states[[1, 3]]) == {RobotState.HELD} and RobotState.HELD not in states[[0, 2, 4]]
    leaving = [edges["id"][edges["origin"] == node] for node in range(3)]
    ahead = [next(edge for edge in edges if edge["origin"] == edges[on]["destination"])["id"] for on in range(2)]
    accepted(commands.assign([0, 1, 2, 3, 4], [[legs[0]] for legs in leaving] + [np.array([edge]) for edge in ahead]))
    accepted(commands.cancel([3, 4]))
    accepted(commands.assign(np.array([4, 3]), np.array([ahead[1:], ahead[:1]])))
    accepted(commands.remove(range(5)))
    logged = np.concatenate([tick.records for tick in log.take()])
    routes = logged[(logged["kind"] == regatta.CommandKind.ASSIGN) | (logged["kind"] == regatta.CommandKind.LEG)]
    assert list(routes["kind"][:4]) == [1, 0, 1, 0], "each command is followed by its legs"
    assert list(routes["token"][::2]) == list(routes["token"][1::2])


def test_commands_for_arrays_are_checked_before_they_are_sent(warehouse: regatta.Fleet) -> None:
    commands = warehouse.commands()
    for bad in ([1, -1], [2**32], np.array([0, 2**40]), [2**70]):
        with pytest.raises(ValueError, match="robot"):
            commands.hold(bad)
    with pytest.raises(ValueError, match="one route per robot"):
        commands.assign([1, 2], [[3]])
    with pytest.raises(ValueError, match="edge"):
        commands.extend([1, 2], [[3], [4, -1]])
    with pytest.raises(ValueError, match="one after the other|list"):
        commands.hold(np.zeros((2, 2), int))
    with pytest.raises(ValueError, match="3.*2|2.*3"):
        commands.spawn_at_node([0, 0], [1, 2, 3])
    for wrong in (np.ones(20, bool), [1.5, 2.0], ["a"]):
        with pytest.raises(TypeError, match="robot"):
            commands.hold(wrong)  # type: ignore[arg-type]
    assert len(commands) == 0, "no part of an invalid command is kept"
    assert len(commands.hold([])) == 0 == len(commands)
    assert len(commands.hold([1, 2])) == 2 == len(commands)
    commands.assign([1, 2], [[3, 4], [5]])
    assert len(commands) == 7


def test_tokens_of_arrays_continue_those_of_single_commands(engine: Engine) -> None:
    commands = regatta.join(engine.name, "a").commands()
    first = commands.hold(0)
    assert isinstance(first, int) and commands.hold([1, 2, 3]).tolist() == [first + 1, first + 2, first + 3]
    assert commands.hold(np.uint8(4)) == first + 4 and commands.hold(np.array(5)) == first + 5
    robots = pandas.DataFrame({"x": [1.0, 2.0, 3.0]})
    assert len(commands.hold(robots.index[robots.x > 1.5].to_numpy())) == 2


def test_a_response_is_readable(warehouse: regatta.Fleet) -> None:
    status = warehouse.control().pause()
    assert status.clock is regatta.ClockState.PAUSED and status.accepted is True and status.reason == ""
    assert status.sim_time == status.sim_time_nanos / 1e9 == pytest.approx(status.tick * 0.01)
    assert status.robots_by_state.driving == status.robots_by_state[RobotState.DRIVING] > 0
    assert repr(status) == (
        f"<regatta.ControlResponse: tick {status.tick} ({status.sim_time:.2f} s), paused at 1 x, 20 robots"
        f" (20 driving), {status.late_ticks} late ticks, process {status.pid}>"
    )


def test_headers_are_readable(warehouse: regatta.Fleet) -> None:
    header = next_frame(warehouse.frames()).header
    text = repr(header)
    assert text.startswith(f"FrameHeader(run_id={header.run_id}, tick={header.tick}, ") and "reserved" not in text


def test_names_are_text(warehouse: regatta.Fleet) -> None:
    name = warehouse.world().robot_types["name"][0]
    assert isinstance(name, str) and name and name.isprintable()


def test_commands_without_an_engine_are_kept(engine: Engine) -> None:
    commands = regatta.commands(engine.name)
    commands.hold(1)
    with pytest.raises(regatta.NoEngineError, match=engine.name):
        commands.send()
    assert len(commands) == 1
    commands.clear()
    commands.send()


def test_commands_to_a_paused_engine_are_an_error_once_its_buffer_is_full(warehouse: regatta.Fleet) -> None:
    warehouse.control().pause()
    commands = warehouse.commands()
    with pytest.raises(regatta.CommandError, match="paused"):
        for _ in range(10_000):
            commands.hold(1)
            commands.send()
    assert len(commands) == 1


def test_tokens_equal_those_of_rust(engine: Engine) -> None:
    """The FNV-1a hash of the name, shifted: ``regatta_plugin::Commands`` computes the same."""
    commands = regatta.join(engine.name, "a").commands()
    assert commands.hold(0) == ((0xAF63_DC4C_8601_EC8C << 32) & (2**64 - 1)) + 1
    assert commands.hold(0) & 0xFFFF_FFFF == 2


def test_the_engine_carries_out_or_refuses_requests(warehouse: regatta.Fleet, engine: Engine) -> None:
    control = warehouse.control()
    assert control.has_engine()
    assert control.pause().clock == regatta.ClockState.PAUSED
    tick = control.status().tick
    assert control.step(25).tick == tick + 25
    assert control.robots(33).robots == 33
    assert control.speed(4.0).speed == 4.0
    with pytest.raises(regatta.RefusedError, match=engine.name):
        control.speed(math.nan)
    with pytest.raises(regatta.RefusedError):
        control.seek(1.0)
    with pytest.raises(ValueError, match="range"):
        control.step(-1)
    status = control.resume()
    assert status.clock == regatta.ClockState.RUNNING and sum(status.robots_by_state) == 33


def test_a_request_without_an_engine_is_an_error(engine: Engine) -> None:
    with pytest.raises(regatta.NoEngineError, match=engine.name):
        regatta.control(engine.name).pause()
    with pytest.raises(regatta.NoEngineError, match=engine.name):
        regatta.world(engine.name, timeout=0.05)
    process = engine.start()
    control = regatta.control(engine.name)
    process.kill()
    with pytest.raises(regatta.ControlError):
        control.status()
    # While another process cleans up after it, it still counts.
    eventually("the end of the engine", lambda: not control.has_engine() or None)


def test_a_column_is_read_as_it_was_published(warehouse: regatta.Fleet, engine: Engine) -> None:
    published = regatta.column(engine.name, "mine")
    frames = warehouse.frames()
    assert next_frame(frames).column("mine") is None
    for frame in frames:
        published.publish(frame, frame.tick + np.arange(len(frame)) / 64)
        column = frame.column("mine")
        assert column is not None and (column.run_id, column.tick) == (frame.run_id, frame.tick)
        assert column.missed == 0
        np.testing.assert_array_equal(column.values, np.float32(frame.tick) + np.arange(20, dtype=np.float32) / 64)
        assert not column.values.flags.owndata and not column.values.flags.writeable
        if frame.header.tick % 20 == 0:
            break
    with pytest.raises(regatta.PublishError, match="one value per robot"):
        published.publish(frame, [1.0, 2.0])
    with pytest.raises(ValueError, match="float"):
        published.publish(frame, ["a"] * 20)
    for _ in range(3):
        published.publish(frame, np.zeros(20))
    column = frame.column("mine")
    assert column is not None and column.missed == 2, "samples that were never sent don't count as missed"
    with pytest.raises(regatta.TakenError, match="mine"):
        warehouse.column("mine")
    with pytest.raises(ValueError, match="name"):
        warehouse.column("my/column")


def test_the_column_of_a_dead_publisher_can_be_opened_again(engine: Engine) -> None:
    fleet = regatta.join(engine.name)
    other = engine.python("column = regatta.column(FLEET, 'mine')\nprint('open')\nimport time\ntime.sleep(600)")
    other.lines(1)
    with pytest.raises(regatta.TakenError, match="columns/mine"):
        fleet.column("mine")
    other.kill()
    fleet.column("mine")


def test_a_place_of_a_reader_is_free_again_when_it_closes(engine: Engine) -> None:
    fleet = regatta.join(engine.name)
    readers = []
    with pytest.raises(regatta.FullError, match="64 places"):
        while True:
            readers.append(fleet.contacts())
    assert len(readers) == 64
    readers.pop()
    fleet.contacts()


def test_the_producer_publishes_the_column_type(warehouse: regatta.Fleet) -> None:
    frames = warehouse.frames()
    column = eventually("the column", lambda: next_frame(frames).column("type"))
    frame = next_frame(frames)
    assert len(column.values) == len(frame)
    assert len(frame.world.robot_types[column.values.astype(int)]) == 20


def test_a_loop_over_events_waits_for_them(engine: Engine) -> None:
    engine.start("--robots", "20", scenario="warehouse-1000.yaml")
    reader = engine.python(
        "for tick in regatta.events(FLEET):\n"
        "    for event in tick.records[tick.records['kind'] == regatta.EventKind.REACHED_NODE]:\n"
        "        print(tick.tick, event['robot'], event['id'], tick.missed, flush=True)\n"
    )
    lines = [[int(word) for word in line.split()] for line in reader.lines(5)]
    nodes = set(regatta.world(engine.name).nodes["id"])
    assert all(robot < 20 and node in nodes and missed == 0 for _, robot, node, missed in lines)
    reader.end()


def test_a_loop_over_events_loses_none_while_it_reads_one_frame_per_second(engine: Engine) -> None:
    """At 100 Hz and one frame a second, some 100 ticks with events pass between two frames."""
    reader = engine.python(
        "import time\n"
        "fleet = regatta.join(FLEET)\n"
        "frames, events = fleet.frames(), fleet.events()\n"
        "print('open', flush=True)\n"
        "due, ticks, looked = time.monotonic(), 0, 0\n"
        "for tick in events:\n"
        "    ticks += 1\n"
        "    if time.monotonic() >= due:\n"
        "        due += 1\n"
        "        looked += frames.latest() is not None\n"
        "print(ticks, looked, events.lost)\n"
    )
    reader.lines(1)
    engine.start_unanswered("--ticks", "350", scenario="warehouse-1000.yaml").finish()
    ticks, looked, lost = (int(word) for word in reader.end().split()[-3:])
    assert ticks > 150 and 2 <= looked <= 6 and lost == 0


@pytest.mark.parametrize("opened_on", ["fleet", "module"])
def test_a_loop_over_one_frame_per_second_loses_no_events(engine: Engine, opened_on: str) -> None:
    """At 100 Hz, some 100 ticks with events pass between two frames."""
    reader = engine.python(
        {
            "fleet": "fleet = regatta.join(FLEET)\nevents, frames = fleet.events(), fleet.frames(rate=1)\n",
            "module": "events = regatta.events(FLEET)\nframes = regatta.frames(FLEET, rate=1)\n",
        }[opened_on]
        + "print('open', flush=True)\n"
        "seen, ticks = 0, []\n"
        "for frame in frames:\n"
        "    seen += 1\n"
        "    ticks += events.take()\n"
        "ticks += events.take()\n"
        "assert all(before.tick < after.tick for before, after in zip(ticks, ticks[1:])), 'oldest first'\n"
        "print(seen, len(ticks), ticks[-1].header.sequence, events.lost)\n"
    )
    reader.lines(1)
    engine.start_unanswered("--ticks", "450", scenario="warehouse-1000.yaml").finish()
    seen, ticks, sequence, lost = (int(word) for word in reader.end().split()[-4:])
    assert ticks == sequence > 250 and lost == 0
    assert 2 <= seen <= 8
    assert reader.errors == ""


def test_ticks_that_are_not_taken_are_bounded(engine: Engine, monkeypatch: pytest.MonkeyPatch) -> None:
    """The test itself publishes them."""
    from regatta import _events
    from regatta._contract import EventHeader, EventRecord

    monkeypatch.setattr(_events, "MAX_QUEUED", 100)
    fleet = regatta.join(engine.name)
    reader, sender = fleet.events(), fleet._node.sender("events", "events", EventRecord, EventHeader)
    for sequence in range(1, 1301):
        sender.send(EventHeader(run_id=1, tick=sequence, sequence=sequence), 0, lambda memory: None)
        fleet._receive_records()
    taken = []
    while ticks := reader.take():
        taken += ticks
    assert [tick.tick for tick in taken] == [*range(1, 101), *range(277, 1301)]
    assert reader.lost == sum(tick.missed for tick in taken) == taken[100].missed == 176


def test_lost_ticks_are_reported_at_ten_times_as_many(engine: Engine, caplog: pytest.LogCaptureFixture) -> None:
    """The test itself publishes them."""
    from regatta._contract import EventHeader, EventRecord

    fleet = regatta.join(engine.name, "slow")
    reader, sender = fleet.events(), fleet._node.sender("events", "events", EventRecord, EventHeader)
    for sequence in (1, 2, 5, 22, 25, 26, 300):
        sender.send(EventHeader(run_id=1, tick=sequence, sequence=sequence), 0, lambda memory: None)
        reader.take()
    assert [(record.name, record.levelname, record.getMessage()) for record in caplog.records] == [
        ("regatta", "WARNING", f"slow: lost events of {lost} ticks so far; the program is too slow")
        for lost in (2, 20, 293)
    ]


def test_a_loop_that_is_left_loses_no_ticks(engine: Engine) -> None:
    """The test itself publishes them."""
    from regatta._contract import EventHeader, EventRecord

    fleet = regatta.join(engine.name)
    reader, sender = fleet.events(), fleet._node.sender("events", "events", EventRecord, EventHeader)
    for sequence in range(1, 6):
        sender.send(EventHeader(run_id=1, tick=sequence, sequence=sequence), 0, lambda memory: None)
    assert next(iter(reader)).tick == 1
    assert [tick.tick for tick in reader.take()] == [2, 3, 4, 5]


def test_a_reader_that_is_too_slow_counts_the_ticks_that_it_missed(engine: Engine) -> None:
    engine.start("--speed", "max", scenario="warehouse-1000.yaml")
    fleet = regatta.join(engine.name)
    reader = fleet.events()
    first = eventually("events", lambda: reader.take() or None)[-1]
    lost_before = reader.lost
    let_ticks_pass(fleet, 2_000)
    late = reader.take()
    assert len(late) >= 64 and late[0].missed > 100
    assert first.header.sequence + late[0].missed + 1 == late[0].header.sequence
    assert sum(tick.missed for tick in late) == reader.lost - lost_before
    assert sum(tick.missed for tick in late[1:]) == late[-1].header.sequence - late[0].header.sequence - len(late[1:])
    assert all(earlier.tick < later.tick for earlier, later in zip(late, late[1:]))


def test_traffic_is_read(engine: Engine) -> None:
    """The test itself publishes it."""
    from regatta._contract import EdgeTraffic, TrafficHeader, dtype

    fleet = regatta.join(engine.name)
    reader, sender = fleet.traffic(), fleet._node.sender("traffic", "traffic", EdgeTraffic, TrafficHeader)
    assert reader.latest() is None
    figures = np.zeros(6, dtype(EdgeTraffic))
    figures["waiting_secs"] = range(6)
    header = TrafficHeader(run_id=1, tick=7, sequence=3, edges=2)
    header.period_secs[:] = [60, 600, 700]
    sender.send(header, 6, lambda memory: np.copyto(memory, figures.view(np.uint8)))
    traffic = reader.latest()
    assert traffic is not None and (traffic.run_id, traffic.tick, list(traffic.header.period_secs)) == (1, 7, [60, 600, 700])
    for period, expected in zip([traffic.minute, traffic.ten_minutes, traffic.run], np.split(figures, 3)):
        np.testing.assert_array_equal(period, expected)
    assert reader.latest() is None and reader.current() is traffic
    sender.send(TrafficHeader(run_id=1, edges=5), 6, lambda memory: None)
    with pytest.raises(regatta.ReadError, match="contradicts its header"):
        reader.latest()


def test_contacts_are_read(engine: Engine) -> None:
    """The test itself publishes them."""
    from regatta._contract import ContactHeader, ContactRecord, dtype

    fleet = regatta.join(engine.name)
    reader, sender = fleet.contacts(), fleet._node.sender("contacts", "contacts", ContactRecord, ContactHeader)
    assert reader.latest() is None
    pairs = np.zeros(2, dtype(ContactRecord))
    pairs["robots"] = [[1, 2], [3, 4]]
    pairs["level"] = [regatta.ContactLevel.TOUCHING, regatta.ContactLevel.POSSIBLE]
    pairs["relative_speed"] = 1.5
    header = ContactHeader(run_id=1, tick=7, sim_time_nanos=70_000_000, sequence=3, touching=1, possible=1)
    sender.send(header, 2, lambda memory: np.copyto(memory, pairs.view(np.uint8)))
    contacts = reader.latest()
    assert contacts is not None and (contacts.header.tick, contacts.header.touching) == (7, 1)
    np.testing.assert_array_equal(contacts.pairs, pairs)
    assert reader.latest() is None and reader.current() is contacts
    assert (contacts.run_id, contacts.tick, contacts.sim_time) == (1, 7, 0.07)
    assert contacts.missed == 0, "samples from before the reader joined don't count"
    sender.send(ContactHeader(run_id=1, tick=8, sequence=5), 0, lambda memory: None)
    empty = reader.latest()
    assert empty is not None and len(empty.pairs) == 0 and empty.missed == 1
