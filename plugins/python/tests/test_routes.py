"""Routes: what robots are going to drive."""

import numpy as np
import pytest
from conftest import Engine, eventually, next_frame

import regatta


def test_a_route_has_the_legs_that_were_commanded(engine: Engine) -> None:
    engine.start("--robots", "0")
    fleet = regatta.join(engine.name, "manager")
    commands, edges = fleet.commands(), fleet.world().edges
    first = edges[0]
    second = next(index for index, edge in enumerate(edges) if edge["origin"] == first["destination"])
    third = next(index for index, edge in enumerate(edges) if edge["origin"] == edges[second]["destination"])
    fleet.control().pause()
    commands.spawn_on_edge(0, first["id"], 0.5)
    commands.send()
    fleet.control().step(1)
    commands.assign(0, [edges["id"][second], regatta.Leg(edges["id"][third], released=False)])
    commands.send()
    tick = fleet.control().step(1).tick
    route = fleet.route(0)
    assert route is not None and (route.robot, route.tick) == (0, tick)
    assert list(route.edges) == [0, second, third] and route.edges.dtype == np.uint32
    assert list(route.reverse) == [False] * 3 and (route.legs, route.released) == (3, 2)
    assert list(edges["id"][route.edges][: route.released]) == [first["id"], edges["id"][second]]
    assert regatta.route(engine.name, np.int64(0)) is not None
    assert fleet.route(4711) is None, "no such robot"
    with pytest.raises(ValueError, match="robot"):
        fleet.route(-1)


def test_many_routes_come_at_once(engine: Engine) -> None:
    engine.start("--robots", "300", scenario="warehouse-1000.yaml")
    fleet = regatta.join(engine.name)
    frame = next_frame(fleet.frames())
    robots = np.flatnonzero(frame.state == regatta.RobotState.DRIVING)
    routes = fleet.routes(robots)
    assert [route.robot for route in routes if route is not None] == robots.tolist()
    assert len({route.tick for route in routes if route is not None}) < len(robots), "several per tick"
    assert fleet.routes([0, 4711])[1] is None and fleet.routes([]) == [] == regatta.routes(engine.name, [])


def test_routes_without_an_engine_are_an_error(engine: Engine) -> None:
    with pytest.raises(regatta.NoEngineError, match=engine.name):
        regatta.routes(engine.name, [1])
    process = engine.start()
    fleet = regatta.join(engine.name)
    assert fleet.route(0) is not None
    process.kill()
    with pytest.raises(regatta.ControlError):
        fleet.routes([0, 1])
    engine.start()
    assert eventually("a route", lambda: fleet.route(0)) is not None
