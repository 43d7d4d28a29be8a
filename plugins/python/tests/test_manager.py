"""Requests to a fleet manager."""

import pytest

import regatta
from conftest import ROOT, Engine, binary, eventually


def test_without_a_manager_nobody_sends_a_robot(engine: Engine) -> None:
    engine.start()
    with regatta.join(engine.name, "test") as fleet:
        with pytest.raises(regatta.NoEngineError, match="has no fleet manager"):
            fleet.send(1, 2)


def test_a_manager_sends_a_robot_and_calls_it_back(engine: Engine) -> None:
    scenario = "warehouse-managed.yaml"
    engine.start("--robots", "20", scenario=scenario)
    load = ROOT / "graphs" / scenario
    manager = engine.run(binary(), "plugin", "fleet-manager", "--fleet", engine.name, "--load", load)
    with regatta.join(engine.name, "test") as fleet:
        node = int(fleet.world(timeout=5).nodes["id"][100])

        def is_sent() -> bool | None:
            assert manager.child.poll() is None, manager.errors
            try:
                return fleet.send(3, node) in (regatta.ManagerAnswer.NOW, regatta.ManagerAnswer.LATER) or None
            except (regatta.NoEngineError, regatta.ControlError):
                return None

        eventually("the manager takes it", is_sent)
        assert fleet.recall(3) == regatta.ManagerAnswer.NOW
        with pytest.raises(regatta.ControlError, match="robot 3 was not sent anywhere"):
            fleet.recall(3)
        with pytest.raises(regatta.ControlError, match="there is no robot 99"):
            fleet.send(99, node)
        with pytest.raises(regatta.ControlError, match="there is no node 999999"):
            fleet.send(3, 999999)
