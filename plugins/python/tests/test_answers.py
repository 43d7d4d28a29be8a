"""Commands whose answers a program waits for."""

import re

import pytest
from conftest import ROOT, Engine

import regatta


def test_a_refused_route_is_told_with_its_reason(engine: Engine) -> None:
    engine.start()
    with regatta.join(engine.name, "test") as fleet:
        commands = fleet.commands()
        commands.hold(3)
        commands.send(timeout=5)
        commands.assign(3, [999_999])
        with pytest.raises(regatta.RefusedError, match="^refused: there is no edge 999999$"):
            commands.send(timeout=5)
        assert len(commands) == 0, "they were sent"
        commands.hold([4, 77_777])
        with pytest.raises(regatta.RefusedError, match="1 of 2 commands refused: there is no robot 77777"):
            commands.send(timeout=5)
        assert repr(commands) == f"<regatta.Commands: 0 records for fleet '{engine.name}'>"
        assert repr(fleet).startswith(f"<regatta.Fleet: '{engine.name}', joined as 'test'")


def test_the_version_is_that_of_the_package() -> None:
    project = (ROOT / "plugins/python/pyproject.toml").read_text(encoding="utf-8")
    found = re.search(r'^version = "(.+)"$', project, re.MULTILINE)
    assert found is not None and found[1] == regatta.__version__
