"""Open objects can be closed, and ``with`` does so."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from conftest import Engine, eventually, next_frame

import regatta
from regatta._contract import LAYOUT

PLACES: int = LAYOUT["services"]["PublishSubscribe"]["frames"]["max_subscribers"]
"""No service has more places than that of the frames."""

OPEN: dict[str, Callable[[regatta.Fleet], Any]] = {
    "frames": lambda fleet: fleet.frames(),
    "column": lambda fleet: fleet.column("mine"),
    "commands": lambda fleet: fleet.commands(),
    "control": lambda fleet: fleet.control(),
    "events": lambda fleet: fleet.events(),
    "command_log": lambda fleet: fleet.command_log(),
    "orders": lambda fleet: fleet.orders(),
    "contacts": lambda fleet: fleet.contacts(),
    "traffic": lambda fleet: fleet.traffic(),
    "closures": lambda fleet: fleet.closures(),
    "facilities": lambda fleet: fleet.facilities(),
    "contact_events": lambda fleet: fleet.contact_events(),
}


@pytest.mark.parametrize("what", OPEN)
def test_with_frees_a_place(what: str, engine: Engine) -> None:
    """More are opened, one after the other, than there is room for; nothing waits for the garbage collector."""
    fleet = regatta.join(engine.name)
    closed = []
    for _ in range(3 if what == "column" else PLACES + 1):
        with OPEN[what](fleet) as opened:
            closed.append(opened)
    assert all(opened.closed for opened in closed)
    closed[0].close()


def test_a_closed_fleet_closes_everything_on_it(engine: Engine) -> None:
    engine.start()
    with regatta.join(engine.name) as fleet:
        opened = {what: open_it(fleet) for what, open_it in OPEN.items()}
        frame = next_frame(opened["frames"])
        route = fleet.route(0)
        values = frame.column("type")
        assert route is not None and values is not None
    assert fleet.closed and all(something.closed for something in opened.values())
    uses: list[Callable[[], object]] = [
        opened["frames"].latest,
        lambda: opened["column"].publish(frame, np.zeros(30)),
        lambda: (opened["commands"].hold(1), opened["commands"].send()),
        opened["control"].status,
        opened["events"].take,
        opened["contacts"].latest,
        fleet.frames,
        fleet.world,
        fleet.columns,
        lambda: fleet.route(0),
        lambda: frame.column("type"),
        lambda: frame.column("other"),
    ]
    for use in uses:
        with pytest.raises(regatta.ClosedError, match="closed"):
            use()
    assert len(frame.x) == 30 == len(values.values), "what was read stays readable"
    assert regatta.world(engine.name).nodes.size, "the functions of the module join again"


def test_a_loop_over_something_that_is_closed_ends(engine: Engine) -> None:
    engine.start(scenario="warehouse-1000.yaml")
    fleet = regatta.join(engine.name)
    with fleet.frames() as frames:
        seen = 0
        for _ in frames:
            seen += 1
            if seen == 3:
                frames.close()
        assert seen == 3
    with fleet.events() as events:
        for _ in events:
            events.close()
    with regatta.frames(engine.name) as frames:
        shared = frames.fleet
        for _ in frames:
            shared.close()
    assert regatta.frames(engine.name).fleet is not shared


def test_a_column_of_the_module_reaches_late_readers(engine: Engine) -> None:
    """A paused engine sends no frames, so that the program publishes its column once and then waits in its loop."""
    engine.start()
    regatta.control(engine.name).pause()
    publisher = engine.python(
        "column = regatta.column(FLEET, 'mine')\n"
        "for frame in regatta.frames(FLEET):\n"
        "    column.publish(frame, frame.x)\n"
        "    print('published', flush=True)\n"
    )
    publisher.lines(1)
    fleet = regatta.join(engine.name)
    frame = next_frame(fleet.frames())
    values = eventually("the column", lambda: frame.column("mine"))
    np.testing.assert_array_equal(values.values, frame.x)
    publisher.end()


def test_the_columns_of_a_fleet_are_listed(engine: Engine) -> None:
    assert regatta.columns(engine.name) == []
    engine.start()
    fleet = regatta.join(engine.name)
    frame = next_frame(fleet.frames())
    assert frame.column("only.read") is None
    assert fleet.columns() == ["type"], "a column that is only read isn't there"
    mine = fleet.column("mine")
    other = engine.python("column = regatta.column(FLEET, 'another')\nprint('open')\nimport time\ntime.sleep(600)")
    other.lines(1)
    assert fleet.columns() == regatta.columns(engine.name) == ["another", "mine", "type"]
    mine.close()
    other.kill()
    assert fleet.columns() == ["type"], "a column of a dead process isn't there"
