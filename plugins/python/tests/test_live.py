"""Runs that a program steps through."""

import gc
import re

import numpy as np
import pytest
from conftest import ROOT, binary, eventually, processes

import regatta

SCENARIO = ROOT / "graphs/warehouse-charging.yaml"


@pytest.fixture(autouse=True)
def program(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("REGATTA_PROGRAM", str(binary()))


def test_a_run_stands_between_steps_and_repeats() -> None:
    ends = []
    for _ in range(2):
        with regatta.run(SCENARIO, robots=12) as run:
            assert run.sim_time == 0.0
            frame = run.step(20)
            assert frame.sim_time == pytest.approx(20.0, abs=0.05)
            assert run.fleet.frames().wait(5.0) is not None, "others may watch"
            assert run.sim_time == frame.sim_time, "it stands"
            run.step(15)
            ends.append((run.frame.tick, run.frame.x.copy(), run.frame.speed.copy()))
            assert run.work is not None and run.work.robots == 12
            assert "12 robots" in repr(run)
    assert ends[0][0] == ends[1][0]
    assert np.array_equal(ends[0][1], ends[1][1])
    assert (ends[0][2] > 0).any(), "the manager takes part"


def test_nodes_have_names_and_those_of_stations() -> None:
    with regatta.run(ROOT / "graphs/imported/lif/ex_10_7.lif.json", robots=2) as run:
        world = run.frame.world
        first = int(world.nodes["id"][0])
        assert world.node(str(first)) == first
        names = [name for name, _ in world.other_names]
        with pytest.raises(ValueError, match=r"several nodes are called .*; give an id"):
            world.node(next(name for name in names if names.count(name) > 1))
        with pytest.raises(ValueError, match="did you mean"):
            run.fleet.send(0, names[0] + "x")
        alone = next(name for name in world.nodes["name"].tolist() if name)
        index = world.nodes["name"].tolist().index(alone)
        assert world.node(alone) == int(world.nodes["id"][index])


def test_a_run_that_can_not_begin_says_why() -> None:
    with pytest.raises(regatta.RunError, match=r"missing\.yaml"):
        regatta.run("missing.yaml")


def test_the_owner_of_movement_has_a_name_while_the_engine_waits_for_the_program() -> None:
    with regatta.run(SCENARIO, robots=4) as run:
        commands = run.fleet.commands()
        with pytest.raises(regatta.OwnedError) as error:
            commands.cancel(0)
        named = re.match(r"fleet-manager \(process (\d+)\) moves the robots of fleet", str(error.value))
        assert named, error.value
        assert f"plugin fleet-manager --fleet {run.fleet.name}" in processes()[int(named[1])]


def test_a_run_ends_when_nothing_refers_to_it() -> None:
    run = regatta.run(SCENARIO, robots=4)
    name = run.fleet.name
    assert any(name in arguments for arguments in processes().values())
    del run
    gc.collect()
    eventually("no process", lambda: not any(name in arguments for arguments in processes().values()) or None)
