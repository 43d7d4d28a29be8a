"""Recordings as frames."""

import csv
import gc
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import polars
import pytest
from conftest import ROOT, binary, eventually, processes

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


def replays(path: Path) -> list[str]:
    """Returns the command lines of the replays of a file."""
    return [arguments for arguments in processes().values() if f"replay {path}" in arguments]


def test_a_replay_ends_with_a_program_that_is_killed(tmp_path: Path) -> None:
    path = record(tmp_path)
    code = f"import regatta, time; r = regatta.read({str(path)!r}); next(iter(r)); print('open', flush=True); time.sleep(60)"
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as reader:
        assert reader.stdout is not None
        assert reader.stdout.readline() == "open\n"
        assert replays(path)
        reader.kill()
    eventually("the end of the replay", lambda: None if replays(path) else True)


def test_a_replay_outlives_the_thread_that_opened_it(tmp_path: Path) -> None:
    path, opened = record(tmp_path), []
    thread = threading.Thread(target=lambda: opened.append(regatta.read(path)))
    thread.start()
    thread.join()
    with opened[0] as recording:
        assert sum(1 for _ in recording) == 51


def exported(path: Path) -> list[dict[str, str]]:
    """Returns the rows that the program exports."""
    table = path.with_suffix(".csv")
    subprocess.run([str(binary()), "export", str(path), "-o", str(table)], check=True, capture_output=True)
    with table.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_a_recording_is_a_table_as_the_program_exports_it(tmp_path: Path) -> None:
    path = record(tmp_path)
    rows = exported(path)
    header = list(rows[0])
    with regatta.read(path) as recording:
        of_frame = next(iter(recording)).to_polars()
        table, pandas = recording.to_polars(), recording.to_pandas()
    assert table.columns == list(pandas.columns)
    assert header == table.columns
    assert table.columns[-3:] == ["goal", "type", "waits_for"]
    assert ["time_s", "run", *of_frame.columns] == table.columns
    assert len(table) == len(pandas) == len(rows) == 204
    seconds = [float(row["sim_time_s"]) for row in rows]
    assert table["sim_time_s"].to_list() == list(pandas["sim_time_s"]) == pytest.approx(seconds, abs=1e-9)
    times = [float(row["time_s"]) for row in rows]
    assert table["time_s"].to_list() == list(pandas["time_s"]) == pytest.approx(times, abs=1e-9)
    for name in set(table.columns) - {"time_s", "sim_time_s", "state", "activity"}:
        texts = [row[name] for row in rows]
        known = [text or None for text in texts]
        of_export = polars.Series(known, dtype=polars.String).cast(table[name].dtype)
        assert of_export.equals(table[name]), name
        of_pandas = [None if is_missing else value for value, is_missing in zip(pandas[name], pandas[name].isna())]
        assert of_export.equals(polars.Series(of_pandas, dtype=table[name].dtype)), name
    assert table["state"].to_list() == list(pandas["state"]) == [row["state"] for row in rows]
    activities = [row["activity"] for row in rows]
    assert table["activity"].to_list() == list(pandas["activity"]) == activities
    assert {"carrying", "fetching"} & set(activities)


def test_a_table_has_a_frame_per_period_and_a_limit_of_rows(tmp_path: Path) -> None:
    recording = regatta.read(record(tmp_path))
    assert recording.to_polars(every=1.0)["tick"].unique().to_list() == [0, 10, 20, 30, 40, 50]
    assert recording.to_polars(every=0.25)["tick"].unique().to_list()[:5] == [0, 3, 5, 8, 10]
    assert len(recording.to_pandas(every=1.0, rows=24)) == 24
    with pytest.raises(regatta.ReadError, match=r"run\.mcap has more than 23 rows; give every="):
        recording.to_pandas(every=1.0, rows=23)
    for wrong in (0.0, -1.0, float("nan")):
        with pytest.raises(ValueError, match="give a positive number of seconds"):
            recording.to_pandas(every=wrong)


def test_the_text_of_a_recording_names_its_file(tmp_path: Path) -> None:
    path = record(tmp_path)
    with regatta.read(path) as recording:
        assert repr(recording) == f"<regatta.Recording: '{path}'>"
    assert repr(recording) == f"<regatta.Recording: '{path}', closed>"


def test_a_replay_ends_when_nothing_refers_to_the_recording(tmp_path: Path) -> None:
    path = record(tmp_path)
    recording = regatta.read(path)
    assert len(replays(path)) == 1
    del recording
    gc.collect()
    eventually("no replay", lambda: not replays(path) or None)
    for frame in regatta.read(path):
        break
    gc.collect()
    eventually("no replay", lambda: not replays(path) or None)
    assert len(frame) == 4, "what was read stays readable"


@pytest.mark.parametrize("end", ["", "raise RuntimeError('mine')", "import sys; sys.exit(3)"])
def test_a_replay_ends_with_the_program(end: str, tmp_path: Path) -> None:
    path = record(tmp_path)
    code = f"import regatta\nrecording = regatta.read({str(path)!r})\nframes = iter(recording)\nnext(frames)\n{end}\n"
    program = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert program.returncode == {"": 0, "r": 1, "i": 3}[end[:1]], program.stderr
    assert ("mine" in program.stderr) == ("mine" in end)
    eventually("no replay", lambda: not replays(path) or None)
