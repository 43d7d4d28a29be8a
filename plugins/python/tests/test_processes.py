"""Readers that are killed or stopped; and the examples."""

import json
import os
import signal
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import EXAMPLES, PATIENCE, ROOT, Engine, binary, eventually, let_ticks_pass, next_frame

import regatta
from regatta._answers import wait_for

READER = "for frame in regatta.frames(FLEET): print(frame.tick, frame.x.mean(), flush=True)"


def test_killed_readers_cost_the_engine_nothing(fleet: regatta.Fleet, engine: Engine) -> None:
    control = fleet.control()

    def late(work: int) -> tuple[int, int]:
        """Returns the numbers of late ticks and of ticks while ``work`` readers are killed in the middle of reading."""
        before = control.status()
        for _ in range(work):
            reader = engine.python(READER)
            reader.lines(2)
            reader.kill()
        let_ticks_pass(fleet, 200)
        after = control.status()
        return after.late_ticks - before.late_ticks, after.tick - before.tick

    calm, of = late(0)
    # More readers than there are places: the next one gets the place of a dead one.
    disturbed, ticks = late(20)
    # An engine that waits for a reader is late on nearly every tick; a busy machine is late on some.
    assert disturbed <= ticks / 3 + 3 * calm * ticks / of, f"{disturbed} late of {ticks}; {calm} of {of} undisturbed"


def test_a_stopped_reader_continues_with_the_newest_frame(fleet: regatta.Fleet, engine: Engine) -> None:
    reader = engine.python(READER)
    reader.lines(2)
    reader.send(signal.SIGSTOP)
    # Long enough for any queue of wake-ups to fill.
    let_ticks_pass(fleet, 400)
    stopped_until = fleet.control().status().tick
    reader.send(signal.SIGCONT)
    let_ticks_pass(fleet, 50)
    ticks = [int(line.split()[0]) for line in reader.end().splitlines()]
    assert ticks == sorted(ticks) and ticks[-1] > stopped_until
    assert max(np.diff(ticks)) > 200, "the reader skipped the frames that it was too slow for"


def test_the_example_centre_prints_the_centre(fleet: regatta.Fleet, engine: Engine) -> None:
    example = engine.example("centre.py", "--rate", "50")
    lines = example.lines(5)
    assert all(line.startswith("tick ") and line.endswith(") m") for line in lines), lines
    example.end()


def test_a_scenario_starts_a_plugin_in_python(engine: Engine, tmp_path: Path) -> None:
    scenario = (ROOT / "graphs/thirty.yaml").read_text().replace("porto.yaml", str(ROOT / "graphs/porto.yaml"))
    command = [sys.executable, str(EXAMPLES / "centre.py"), "--rate", "20"]
    plugins = json.dumps([{"name": "centre", "command": command}])
    (tmp_path / "scenario.yaml").write_text(f"{scenario}\nplugins: {plugins}\n")
    run = engine.run(binary(), "run", tmp_path / "scenario.yaml", "--trust", "--fleet", engine.name)
    eventually("the plugin prints", lambda: run.output.count(": centre (") >= 3 or None)
    # This fails if a plugin doesn't exit cleanly when it is asked to end.
    run.end()


def test_the_example_tint_by_speed_publishes_a_column(fleet: regatta.Fleet, engine: Engine) -> None:
    example = engine.example("tint_by_speed.py")
    frames = fleet.frames()
    column = eventually("the column", lambda: next_frame(frames).column("relative_speed"))
    assert len(column.values) == 30
    assert 0 <= column.values.min() and 0.1 < column.values.max() <= 1
    example.end()


def test_the_example_stop_in_zone_stops_robots(engine: Engine) -> None:
    engine.start("--robots", "50", "--speed", "10", scenario="warehouse-1000.yaml")
    fleet = regatta.join(engine.name, "test")
    nodes = fleet.world().nodes
    middle = nodes["x"].mean()
    example = engine.example("stop_in_zone.py", "--zone", str(middle), "-1000", "1000", "1000")
    lines = example.lines(10)
    assert all("stops at" in line for line in lines)
    frames = fleet.frames()

    def all_stand() -> regatta.Frame | None:
        frame = next_frame(frames)
        return frame if np.all(frame.state[frame.x > middle + 2.0] == regatta.RobotState.HELD) else None

    frame = eventually("the robots in the zone stand", all_stand)
    assert np.count_nonzero(frame.state == regatta.RobotState.HELD) >= 10
    example.end()


def test_the_example_own_manager_keeps_robots_apart(engine: Engine) -> None:
    engine.start("--robots", "40", "--speed", "10", scenario="warehouse-managed.yaml")
    fleet = regatta.join(engine.name, "test")
    example = engine.example("own_manager.py")
    frames = fleet.frames()
    eventually("most robots drive", lambda: np.count_nonzero(next_frame(frames).speed) > 20 or None)
    start = next_frame(frames).copy()
    while (frame := next_frame(frames)).sim_time < start.sim_time + 60:
        apart = np.hypot(*(np.subtract.outer(column, column) for column in (frame.x, frame.y)))
        # Robots are 0.6 m wide: nearer than that, two centres can't be without a contact.
        assert apart[~np.eye(len(frame), dtype=bool)].min() > 0.6
    assert np.hypot(frame.x - start.x, frame.y - start.y).max() > 5.0
    example.end()


def test_a_fleet_has_one_owner_of_movement(engine: Engine) -> None:
    engine.start("--robots", "10", scenario="warehouse-managed.yaml")
    fleet, other = regatta.join(engine.name, "manager"), regatta.join(engine.name, "other")
    edge = int(fleet.world().edges["id"][0])
    own, foreign, early = fleet.commands(), other.commands(), other.commands()
    refused = early.cancel(0)
    ownership = fleet.own()
    assert fleet.control().status().owner == f"manager (process {os.getpid()})"
    own.cancel(0)
    own.send()
    for command in (foreign.cancel, lambda robot: foreign.assign(robot, [edge])):
        with pytest.raises(regatta.OwnedError, match=r"manager \(process \d+\) moves the robots of fleet"):
            command(0)
    assert len(foreign) == 0
    with pytest.raises(regatta.OwnedError, match=r"manager \(process \d+\) moves the robots of fleet"):
        early.send()
    with other.events() as events:
        # The engine refuses a command that was sent before the movement had an owner.
        early._put()
        with pytest.raises(regatta.OwnedError, match=rf"^refused: manager \(process {os.getpid()}\) moves the robots"):
            wait_for(events, {refused}, PATIENCE)
    foreign.hold(0)
    foreign.send()
    with pytest.raises(regatta.OwnedError, match="moves the robots"):
        other.own()
    example = engine.example("own_manager.py").fail()
    assert example.startswith("own_manager: manager (process") and example.count("\n") == 1

    ownership.close()
    assert fleet.control().status().owner == ""
    foreign.cancel(0)
    foreign.send()


def test_the_ownership_of_a_killed_program_ends(engine: Engine) -> None:
    engine.start("--robots", "10", scenario="warehouse-managed.yaml")
    fleet = regatta.join(engine.name, "other")
    example = engine.example("own_manager.py")
    eventually("it owns the fleet", lambda: "own_manager" in fleet.control().status().owner or None)
    example.kill()
    commands = fleet.commands()
    commands.cancel(0)
    commands.send()
    assert fleet.control().status().owner == ""


@pytest.mark.parametrize("name", ["centre.py", "own_manager.py", "stop_in_zone.py", "tint_by_speed.py"])
def test_examples_have_a_help_text(name: str, engine: Engine) -> None:
    output = engine.example(name, "--help").finish()
    assert all(option in output for option in ("--fleet", "--rate", "--name", "--after"))
