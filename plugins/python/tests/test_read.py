"""Recordings as frames."""

import subprocess
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT, binary

import regatta


@pytest.fixture(autouse=True)
def program(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("REGATTA_PROGRAM", str(binary()))


def record(folder: Path) -> Path:
    """Records 5 s of a managed fleet at 10 frames a second."""
    (folder / "orders.yaml").write_text(
        f"graph: {ROOT}/graphs/square.yaml\nrate: 10\nrobots: [{{count: 4, routes: none}}]\n"
        "load: {endless: robots}\n"
        f"plugins: [fleet-manager, {{name: record, args: [-o, {folder}/run.mcap]}}]\n"
    )
    command = [binary(), "run", folder / "orders.yaml", "--in-process", "--simulated", "5s", "--trust"]
    subprocess.run([str(part) for part in command], check=True, capture_output=True)
    return folder / "run.mcap"


def test_a_recording_is_read_frame_by_frame(tmp_path: Path) -> None:
    with regatta.read(record(tmp_path)) as recording:
        events = recording.fleet.events()
        ticks, driven, accepted = [], 0.0, 0
        last = None
        for frame in recording:
            ticks.append(frame.tick)
            assert len(frame) == 4 and len(frame.world.edges) > 4
            if last is not None:
                driven += float(np.hypot(frame.x - last[0], frame.y - last[1]).sum())
            last = (frame.x.copy(), frame.y.copy())
            for of_tick in events.take():
                accepted += int((of_tick.records["kind"] == regatta.EventKind.ACCEPTED).sum())
    assert ticks == list(range(51))
    assert driven > 1.0 and accepted > 0
    assert recording.closed


def test_a_loop_may_end_early_and_a_file_that_is_no_recording_is_an_error(tmp_path: Path) -> None:
    path = record(tmp_path)
    with regatta.read(path) as recording:
        assert next(iter(recording)).tick == 0
    for wrong in (tmp_path / "missing.mcap", tmp_path / "orders.yaml"):
        with regatta.read(wrong) as recording, pytest.raises(regatta.ReadError, match=wrong.name):
            list(recording)
