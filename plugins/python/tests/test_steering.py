"""What goes the other way: orders, control, columns; and the events that answer."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from conftest import Engine, eventually, let_ticks_pass, next_frame

import regatta
from regatta import EventKind, RobotState


@pytest.fixture
def warehouse(engine: Engine) -> regatta.Fleet:
    """A fleet of twenty that drives for ever."""
    engine.start("--robots", "20", scenario="warehouse-1000.yaml")
    return regatta.join(engine.name, "manager")


class Answers:
    """Collects events and finds those that answer an order."""

    def __init__(self, fleet: regatta.Fleet) -> None:
        self.reader = fleet.events()
        self.seen: list[np.void] = []

    def wait(self, what: str, wanted: Callable[[np.void], bool]) -> np.void:
        def look() -> np.void | None:
            self.seen += [record for tick in self.reader.take() for record in tick.records]
            return next((record for record in self.seen if wanted(record)), None)

        return eventually(what, look)

    def to(self, token: int) -> np.void:
        """What became of an order."""
        ends = EventKind.ACCEPTED, EventKind.REFUSED
        return self.wait("an answer", lambda record: record["token"] == token and record["kind"] in ends)


def test_a_held_robot_stands_until_it_is_resumed(warehouse: regatta.Fleet) -> None:
    answers, orders, frames = Answers(warehouse), warehouse.orders(), warehouse.frames()
    token = orders.hold(7)
    assert len(orders) == 1
    orders.send()
    assert len(orders) == 0
    assert answers.to(token)["kind"] == EventKind.ACCEPTED
    answers.wait("it stands", lambda record: record["kind"] == EventKind.HELD and record["robot"] == 7)
    before = next_frame(frames)
    let_ticks_pass(warehouse, 100)
    after = next_frame(frames)
    assert after.tick >= before.tick + 50
    assert before.state[7] == after.state[7] == RobotState.HELD and after.speed[7] == 0
    assert (before.x[7], before.y[7]) == (after.x[7], after.y[7])
    assert np.any((before.x != after.x) | (before.y != after.y)), "the others drive"
    orders.resume(np.int64(7))
    orders.send()
    del before

    def moves() -> bool | None:
        frame = next_frame(frames)
        return frame.state[7] != RobotState.HELD and (frame.x[7], frame.y[7]) != (after.x[7], after.y[7]) or None

    eventually("it drives on", moves)


def test_orders_are_carried_out_or_refused(engine: Engine) -> None:
    engine.start("--robots", "0")
    fleet = regatta.join(engine.name, "manager")
    answers, orders, log = Answers(fleet), fleet.orders(), fleet.order_log()
    edge = fleet.world().edges[0]
    spawned = orders.spawn_on_edge(0, edge["id"], 0.5)
    orders.send()
    robot = int(answers.wait("a robot", lambda record: record["kind"] == EventKind.SPAWNED)["robot"])
    edges, node = fleet.world().edges, fleet.world().nodes["id"][0]
    onward = next(other for other in edges if other["origin"] == edge["destination"])
    beyond = next(other for other in edges if other["origin"] == onward["destination"])
    tokens = [
        spawned,
        orders.assign(robot, [onward["id"]]),
        orders.extend(robot, [regatta.Leg(beyond["id"], released=False)]),
        orders.cancel(robot),
        orders.hold(robot),
        orders.resume(robot),
        orders.spawn_at_node(0, node),
        orders.remove(robot),
    ]
    refused = {
        orders.hold(4711): regatta.Refusal.UNKNOWN_ROBOT,
        orders.spawn_at_node(9, node): regatta.Refusal.UNKNOWN_ROBOT_TYPE,
        orders.spawn_on_edge(0, edge["id"], 1e6): regatta.Refusal.DISTANCE_OUT_OF_RANGE,
        orders.spawn_at_node(0, 4711): regatta.Refusal.UNKNOWN_NODE,
    }
    orders.send()
    assert len(set(tokens)) == len(tokens)
    assert [EventKind(answers.to(token)["kind"]) for token in tokens] == [EventKind.ACCEPTED] * len(tokens)
    for token, reason in refused.items():
        answer = answers.to(token)
        assert (answer["kind"], answer["detail"]) == (EventKind.REFUSED, reason)
    logged = [token for tick in log.take() for token in tick.records["token"]]
    assert set(tokens) | refused.keys() == set(logged)


def test_orders_are_checked_before_they_are_sent(warehouse: regatta.Fleet) -> None:
    orders = warehouse.orders()
    for bad in (-1, 2**32):
        with pytest.raises(ValueError, match="robot"):
            orders.hold(bad)
        with pytest.raises(ValueError, match="edge"):
            orders.assign(0, [0, bad])
    with pytest.raises(TypeError, match="str"):
        orders.hold("a")  # type: ignore[arg-type]
    with pytest.raises(TypeError):
        orders.hold(1.5)  # type: ignore[arg-type]
    assert len(orders) == 0, "nothing of them is kept"


def test_orders_without_an_engine_are_kept(engine: Engine) -> None:
    orders = regatta.orders(engine.name)
    orders.hold(1)
    with pytest.raises(regatta.NoEngineError, match=engine.name):
        orders.send()
    assert len(orders) == 1
    orders.clear()
    orders.send()


def test_a_paused_engine_that_takes_no_orders_is_told_of(warehouse: regatta.Fleet) -> None:
    warehouse.control().pause()
    orders = warehouse.orders()
    with pytest.raises(regatta.OrderError, match="paused"):
        for _ in range(10_000):
            orders.hold(1)
            orders.send()
    assert len(orders) == 1


def test_tokens_are_those_that_rust_gives(engine: Engine) -> None:
    """FNV-1a of the name, shifted: ``regatta_plugin::Orders`` makes the same of it."""
    orders = regatta.join(engine.name, "a").orders()
    assert orders.hold(0) == ((0xAF63_DC4C_8601_EC8C << 32) & (2**64 - 1)) + 1
    assert orders.hold(0) & 0xFFFF_FFFF == 2


def test_control(warehouse: regatta.Fleet, engine: Engine) -> None:
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


def test_control_without_an_engine(engine: Engine) -> None:
    with pytest.raises(regatta.NoEngineError, match=engine.name):
        regatta.control(engine.name).pause()
    with pytest.raises(regatta.NoEngineError, match=engine.name):
        regatta.world(engine.name, timeout=0.05)
    process = engine.start()
    control = regatta.control(engine.name)
    process.kill()
    with pytest.raises(regatta.ControlError):
        control.status()
    assert not control.has_engine()


def test_a_column_is_read_as_it_was_published(warehouse: regatta.Fleet, engine: Engine) -> None:
    published = regatta.column(engine.name, "mine")
    frames = warehouse.frames()
    assert next_frame(frames).column("mine") is None
    for frame in frames:
        published.publish(frame, frame.tick + np.arange(len(frame)) / 64)
        column = frame.column("mine")
        assert column is not None and (column.run_id, column.tick) == (frame.run_id, frame.tick)
        np.testing.assert_array_equal(column.values, np.float32(frame.tick) + np.arange(20, dtype=np.float32) / 64)
        assert not column.values.flags.owndata and not column.values.flags.writeable
        if frame.header.tick % 20 == 0:
            break
    with pytest.raises(regatta.PublishError, match="one value per robot"):
        published.publish(frame, [1.0, 2.0])
    with pytest.raises(regatta.TakenError, match="mine"):
        warehouse.column("mine")
    with pytest.raises(ValueError, match="name"):
        warehouse.column("my/column")


def test_a_dead_publishers_column_can_be_taken_over(engine: Engine) -> None:
    fleet = regatta.join(engine.name)
    other = engine.python("column = regatta.column(FLEET, 'mine')\nprint('open')\nimport time\ntime.sleep(600)")
    other.lines(1)
    with pytest.raises(regatta.TakenError, match="columns/mine"):
        fleet.column("mine")
    other.kill()
    fleet.column("mine")


def test_places_for_readers_run_out_and_come_back(engine: Engine) -> None:
    fleet = regatta.join(engine.name)
    readers = []
    with pytest.raises(regatta.FullError, match="16 places"):
        while True:
            readers.append(fleet.contacts())
    assert len(readers) == 16
    readers.pop()
    fleet.contacts()


def test_the_producers_own_column(warehouse: regatta.Fleet) -> None:
    frames = warehouse.frames()
    column = eventually("the types", lambda: next_frame(frames).column("type"))
    frame = next_frame(frames)
    assert len(column.values) == len(frame)
    assert len(frame.world.robot_types[column.values.astype(int)]) == 20


def test_events_can_be_waited_for(engine: Engine) -> None:
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


def test_a_reader_that_is_too_slow_is_told_what_it_missed(engine: Engine) -> None:
    engine.start("--speed", "max", scenario="warehouse-1000.yaml")
    fleet = regatta.join(engine.name)
    reader = fleet.events()
    first = eventually("events", lambda: reader.take() or None)[-1]
    let_ticks_pass(fleet, 2_000)
    late = reader.take()
    assert len(late) >= 64 and late[0].missed > 100
    assert first.header.sequence + late[0].missed + 1 == late[0].header.sequence
    assert sum(tick.missed for tick in late[1:]) == late[-1].header.sequence - late[0].header.sequence - len(late[1:])
    assert all(earlier.tick < later.tick for earlier, later in zip(late, late[1:]))


def test_contacts_are_read(engine: Engine) -> None:
    """A checker of the test's own publishes; the reader has no part in it."""
    from regatta._contract import ContactHeader, ContactRecord, dtype

    fleet = regatta.join(engine.name)
    reader, sender = fleet.contacts(), fleet._node.sender("contacts", "contacts", ContactRecord, ContactHeader)
    assert reader.latest() is None
    pairs = np.zeros(2, dtype(ContactRecord))
    pairs["robots"] = [[1, 2], [3, 4]]
    pairs["level"] = [regatta.ContactLevel.TOUCHING, regatta.ContactLevel.POSSIBLE]
    pairs["relative_speed"] = 1.5
    header = ContactHeader(run_id=1, tick=7, touching=1, possible=1)
    sender.send(header, 2, lambda memory: np.copyto(memory, pairs.view(np.uint8)))
    contacts = reader.latest()
    assert contacts is not None and (contacts.header.tick, contacts.header.touching) == (7, 1)
    np.testing.assert_array_equal(contacts.pairs, pairs)
    assert reader.latest() is None and reader.current() is contacts
    sender.send(ContactHeader(tick=8), 0, lambda memory: None)
    empty = reader.latest()
    assert empty is not None and len(empty.pairs) == 0
