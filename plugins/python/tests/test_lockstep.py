"""Lockstep: the engine waits for programs in Python, and their runs are reproducible."""

import subprocess
import sys
import time
from collections.abc import Iterator
from itertools import islice

import pytest
from conftest import Engine, Process, binary, eventually

import regatta

LAST = 120
"""The last tick of short runs."""


def ticks_of(program: Process, last: int = LAST) -> list[int]:
    """Waits until a program has printed the last tick, ends it, and returns the ticks that it printed."""
    eventually("the last tick", lambda: f"{last}\n" in program.output or program.child.poll())
    return [int(line) for line in program.end().split()]


@pytest.fixture
def busy() -> Iterator[None]:
    """Two endless loops, which keep both cores of a small machine busy."""
    loops = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(2)]
    yield
    for loop in loops:
        loop.kill()
        loop.wait()


def test_each_tick_comes_exactly_once(engine: Engine) -> None:
    arguments = ("--ticks", str(LAST), "--speed", "max", "--digest")
    digests = []
    for pause in ("0", "0.002"):
        # It outlives the engine, which publishes the last tick again when its clock stops.
        controller = engine.python(
            "import time\n"
            "fleet = regatta.join(FLEET, 'controller')\n"
            "commands = fleet.commands()\n"
            "for frame in fleet.frames():\n"
            f"    time.sleep({pause})\n"
            "    (commands.hold if frame.tick % 7 == 0 else commands.resume)(frame.tick % 30)\n"
            "    commands.send()\n"
            "    assert frame.missed == 0\n"
            "    print(frame.tick, flush=True)\n"
        )
        process = engine.start_unanswered("--lockstep", "controller", *arguments)
        digests.append(process.finish())
        assert ticks_of(controller) == list(range(LAST + 1))
    assert digests[0] == digests[1] != "", "the same run, however slow the controller"


def test_a_tick_that_is_published_again_is_handed_out_once(engine: Engine) -> None:
    reader = engine.python(
        "for frame in regatta.join(FLEET, 'reader').frames(): print(frame.tick, flush=True)\n"
    )
    engine.start("--lockstep", "reader")
    control = regatta.control(engine.name)
    ticks = [control.step(5).tick, *(control.speed(factor).tick for factor in (2.0, 3.0)), control.step(5).tick]
    last = ticks[-1]
    assert ticks == [last - 5, last - 5, last - 5, last]
    assert ticks_of(reader, last) == list(range(last + 1))


def test_a_controller_that_reacts_to_events_gives_one_digest_on_a_busy_machine(engine: Engine, busy: None) -> None:
    digests = set()
    for _ in range(10):
        # Holds each robot that reaches a node, and resumes it 7 ticks later.
        controller = engine.python(
            "from collections import deque\n"
            "fleet = regatta.join(FLEET, 'gatekeeper')\n"
            "events, commands, held = fleet.events(), fleet.commands(), deque()\n"
            "for frame in fleet.frames():\n"
            "    for tick in events.take():\n"
            "        assert (tick.run_id, tick.tick, tick.missed) == (frame.run_id, frame.tick, 0)\n"
            "        for event in tick.records[tick.records['kind'] == regatta.EventKind.REACHED_NODE]:\n"
            "            commands.hold(event['robot'])\n"
            "            held.append((frame.tick + 7, event['robot']))\n"
            "    while held and held[0][0] <= frame.tick:\n"
            "        commands.resume(held.popleft()[1])\n"
            "    commands.send()\n"
            "    if frame.tick == 150: break\n"
            "print(events.lost)\n"
        )
        arguments = ("--ticks", "150", "--speed", "max", "--digest", "--lockstep", "gatekeeper")
        digests.add(engine.start_unanswered(*arguments, scenario="warehouse-1000.yaml").finish())
        assert controller.finish() == "0\n"
    alone = engine.start_unanswered(*arguments[:-2], scenario="warehouse-1000.yaml").finish()
    assert len(digests) == 1 and "" not in digests
    assert digests != {alone}, "the commands have an effect"


def test_a_rate_loses_no_events_in_lockstep(engine: Engine) -> None:
    """100 ticks pass between two frames of the loop, and 64 fit the buffer."""
    counter = engine.python(
        "fleet = regatta.join(FLEET, 'counter')\n"
        "events, frames = fleet.events(), fleet.frames(rate=1)\n"
        "for frame in frames:\n"
        "    taken = events.take()\n"
        "    assert not taken or taken[-1].tick <= frame.tick, 'none of later ticks'\n"
        "    print(frame.tick, len(taken), events.lost, flush=True)\n"
    )
    arguments = ("--ticks", "300", "--speed", "max", "--lockstep", "counter")
    engine.start_unanswered(*arguments, scenario="warehouse-1000.yaml").finish()
    lines = [[int(word) for word in line.split()] for line in counter.end().splitlines()]
    assert [tick for tick, _, _ in lines] == [0, 100, 200, 300]
    assert all(lost == 0 for _, _, lost in lines) and any(taken > 64 for _, taken, _ in lines), lines


@pytest.mark.parametrize("given", ["argument", "option", "variable"])
def test_a_program_that_comes_after_another_has_its_column_of_the_same_tick(engine: Engine, given: str) -> None:
    second = engine.python(
        "import os, sys\n"
        f"given = {given!r}\n"
        "if given == 'variable': os.environ['REGATTA_PLUGIN_AFTER'] = ' first ,'\n"
        "options = regatta.parser().parse_args(['--fleet', FLEET, *(['--after', 'first'] * (given == 'option'))])\n"
        "after = ['first'] if given == 'argument' else options.after\n"
        "for frame in regatta.join(options.fleet, 'second').frames(after=after):\n"
        "    column = frame.column('first')\n"
        "    assert column is not None and (column.tick, column.values[0]) == (frame.tick, frame.tick), column\n"
        "    print(frame.tick, flush=True)\n"
    )
    # The slower one of the two.
    first = engine.python(
        "import time\n"
        "fleet = regatta.join(FLEET, 'first')\n"
        "column = fleet.column('first')\n"
        "for frame in fleet.frames():\n"
        "    time.sleep(0.002)\n"
        "    column.publish(frame, [frame.tick] * len(frame))\n"
    )
    arguments = ("--ticks", str(LAST), "--speed", "max", "--lockstep", "first", "--lockstep", "second")
    engine.start_unanswered(*arguments).finish()
    assert ticks_of(second) == list(range(LAST + 1))
    first.end()


def test_a_program_comes_after_a_plugin_in_rust(engine: Engine) -> None:
    engine.run(binary(), "plugin", "collision", "--fleet", engine.name)
    program = engine.python(
        "fleet = regatta.join(FLEET, 'program')\n"
        "contacts = fleet.contacts()\n"
        "for frame in fleet.frames(after=['collision']):\n"
        "    column, newest = frame.column('collision'), contacts.latest()\n"
        "    assert column is not None and column.tick == frame.tick, column\n"
        "    assert newest is not None and newest.header.tick == frame.tick and newest.missed == 0\n"
        "    print(frame.tick, flush=True)\n"
    )
    arguments = ("--ticks", str(LAST), "--speed", "max", "--lockstep", "program", "--robots", "200")
    engine.start_unanswered(*arguments, scenario="warehouse-1000.yaml").finish()
    assert ticks_of(program) == list(range(LAST + 1))


def test_a_plugin_in_rust_comes_after_a_program_that_reported_before_it_joined(engine: Engine) -> None:
    program = engine.python(
        "fleet = regatta.join(FLEET, 'program')\n"
        "for frame in fleet.frames(): print(frame.tick, flush=True)"
    )
    arguments = ("--lockstep", "program", "--lockstep", "hello", "--lockstep-timeout", "60", "--ticks", "20")
    engine.start_unanswered(*arguments)
    # The program reports tick 0 and waits for tick 1, for which the engine waits for the plugin.
    assert program.lines(1) == ["0"]
    time.sleep(0.5)
    hello = engine.run(binary(), "plugin", "hello", "--after", "program", "--fleet", engine.name)
    assert hello.lines(21)[0].startswith("tick 0:")
    program.end()
    hello.end()


def test_a_program_that_waits_for_another_says_so_and_ends_on_a_signal(engine: Engine) -> None:
    program = engine.python(
        "for frame in regatta.join(FLEET, 'program').frames(after='absent'): print(frame.tick, flush=True)"
    )
    engine.start_unanswered("--lockstep", "program")
    eventually("the message", lambda: "tick" in program.errors or None)
    assert program.errors.endswith("program: waiting for absent to finish tick 0\n")
    assert program.end() == ""


def test_a_program_cannot_come_after_itself(engine: Engine) -> None:
    with pytest.raises(ValueError, match="'me' can't come after itself"):
        regatta.join(engine.name, "me").frames(after=["other", "me"])


def test_a_program_goes_by_the_name_in_the_scenario(engine: Engine, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("REGATTA_PLUGIN_NAME", "from-the-scenario")
    assert regatta.join(engine.name).participant == "from-the-scenario"
    assert regatta.join(engine.name, "mine").participant == "mine"


@pytest.mark.parametrize("end", ["break", "raise RuntimeError('an error')"])
def test_a_program_that_ends_leaves_the_lockstep_and_one_that_fails_does_not(engine: Engine, end: str) -> None:
    engine.python(
        "for frame in regatta.join(FLEET, 'reader').frames():\n"
        "    if frame.tick == 20:\n"
        f"        {end}\n"
    )
    arguments = ("--lockstep", "reader", "--lockstep-timeout", "2", "--ticks", "60", "--speed", "max")
    process = engine.start_unanswered(*arguments)
    left = "reader has left the lockstep" in (process.errors if process.child.wait(60) == 0 else "")
    assert left == (end == "break"), process.errors


def test_frames_that_their_fleet_closes_too_are_closed_once(engine: Engine) -> None:
    process = engine.start_unanswered("--lockstep", "reader", "--ticks", "3", "--speed", "max")
    with regatta.join(engine.name, "reader") as fleet, fleet.frames() as frames:
        assert [frame.tick for frame in islice(frames, 4)] == [0, 1, 2, 3]
    process.finish()
