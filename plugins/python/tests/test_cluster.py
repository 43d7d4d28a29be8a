"""Studies on a cluster: a real scheduler with two workers."""

import importlib.util
import json
import os
import queue
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from pathlib import Path

import pytest
from conftest import PATIENCE, ROOT, Process, binary, eventually

from regatta.cluster._adapter import MOST_TRIES, Adapter, Event
from regatta.cluster._run import Ended, content_hash

PLANT = ROOT / "graphs/thirty.yaml"
SHORT = ["--robots", "2,4", "--duration", "2min", "--seeds", "2", "--reliefs", "1"]
LONG = ["--robots", "4", "--duration", "10h", "--seeds", "2"]

has_dask = importlib.util.find_spec("distributed") is not None
needs_dask = pytest.mark.skipif(
    not has_dask and "REGATTA_PYTHON_TESTS" not in os.environ, reason="needs Dask: pip install 'regatta-sim[study]'"
)
# Ray's client server needs gRPC, which the extra brings and Ray alone doesn't.
has_ray = all(importlib.util.find_spec(name) is not None for name in ("ray", "grpc"))


def study(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    """Runs a study to its end."""
    command = [str(part) for part in (binary(), "study", PLANT, *SHORT, *arguments)]
    environment = os.environ | {"REGATTA_PYTHON": sys.executable}
    return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=4 * PATIENCE)


@pytest.fixture(scope="module")
def local(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The answer of the processes on this machine."""
    folder = tmp_path_factory.mktemp("local")
    done = study("--output", folder)
    assert done.returncode == 0, done.stderr
    return (folder / "study.json").read_bytes()


class Cluster:
    """A scheduler of Dask with two workers."""

    def __init__(self, folder: Path, program: Path | None = None) -> None:
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
        here: list[str | Path] = ["env", f"REGATTA_PROGRAM={program or binary()}", sys.executable, "-m", "dask"]
        host, port = self.address.removeprefix("tcp://").split(":")
        self.scheduler = Process([*here, "scheduler", "--host", host, "--port", port, "--no-dashboard"])
        options: list[str | Path] = ["--nthreads", "1", "--no-nanny", "--no-dashboard", "--local-directory", folder]
        self.workers = [Process([*here, "worker", self.address, *options]) for _ in range(2)]
        joined = "Registered to:"
        eventually("two workers", lambda: all(joined in worker.errors for worker in self.workers) or None)

    def stop(self) -> None:
        for process in (*self.workers, self.scheduler):
            process.kill()


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[Cluster]:
    cluster = Cluster(tmp_path)
    yield cluster
    cluster.stop()


@pytest.fixture
def started(cluster: Cluster, tmp_path: Path) -> Iterator[Callable[..., Process]]:
    """Starts studies on the cluster."""
    processes = []

    def start(*options: str) -> Process:
        program: list[str | Path] = ["env", f"REGATTA_PYTHON={sys.executable}"]
        program += [binary(), "study", PLANT, *options]
        processes.append(Process([*program, "--on", cluster.address, "--output", tmp_path / "study"]))
        return processes[-1]

    yield start
    for process in processes:
        process.kill()


def runs_of(process: Process) -> list[int]:
    """Returns the ids of the processes that a worker has started and that still run."""
    pid = process.child.pid
    found = subprocess.run(["pgrep", "-f", "study-run", "-P", str(pid)], capture_output=True, text=True)
    return [int(line) for line in found.stdout.split()]


def has_ended(pid: int) -> bool:
    """Tells whether a process has ended; nobody may have waited for it yet (such a zombie has no command line)."""
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes() == b""
    except (FileNotFoundError, ProcessLookupError):
        return True


@needs_dask
def test_two_workers_give_the_same_answer_byte_by_byte(cluster: Cluster, local: bytes, tmp_path: Path) -> None:
    done = study("--on", cluster.address, "--output", tmp_path / "study")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "study/study.json").read_bytes() == local


@needs_dask
def test_the_runs_of_a_killed_worker_are_done_again(
    cluster: Cluster, started: Callable[..., Process], local: bytes, tmp_path: Path
) -> None:
    process = started(*SHORT)
    eventually("the first result", lambda: list((tmp_path / "study/results").glob("*.json")) or None)
    (run, *_) = eventually("a run on the first worker", lambda: runs_of(cluster.workers[0]) or None)
    cluster.workers[0].kill()
    process.finish()
    assert (tmp_path / "study/study.json").read_bytes() == local
    eventually("the end of the run with its worker", lambda: has_ended(run) or None)
    drafts = [path for path in (tmp_path / "study/results").iterdir() if path.suffix != ".json"]
    assert drafts == []


@needs_dask
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_runs_under_way_end_with_their_study(
    cluster: Cluster, started: Callable[..., Process], number: signal.Signals
) -> None:
    process = started(*LONG)
    eventually("a run on each worker", lambda: all(map(runs_of, cluster.workers)) or None)
    process.send(number)
    process.child.wait(PATIENCE)
    eventually("the end of the runs", lambda: not any(map(runs_of, cluster.workers)) or None)
    assert number == signal.SIGKILL or "interrupted" in process.errors.splitlines()[-1]


@needs_dask
def test_a_study_ends_with_its_scheduler(cluster: Cluster, started: Callable[..., Process]) -> None:
    process = started(*LONG)
    eventually("a run on each worker", lambda: all(map(runs_of, cluster.workers)) or None)
    cluster.scheduler.kill()
    process.child.wait(PATIENCE)
    assert "the connection to the Dask scheduler" in process.errors.splitlines()[-1]
    eventually("the end of the runs", lambda: not any(map(runs_of, cluster.workers)) or None)


@needs_dask
def test_a_worker_with_another_version_is_named(tmp_path: Path) -> None:
    old = tmp_path / "regatta"
    old.write_text("#!/bin/sh\necho 'regatta 0.0.9'\n")
    old.chmod(0o755)
    cluster = Cluster(tmp_path, old)
    done = study("--on", cluster.address, "--output", tmp_path / "study")
    cluster.stop()
    assert done.returncode == 1
    assert "has Regatta 0.0.9, and this is" in done.stderr.splitlines()[-1] and "Traceback" not in done.stderr


@needs_dask
@pytest.mark.parametrize("is_listening", [False, True])
def test_an_address_where_nobody_answers(is_listening: bool, tmp_path: Path) -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        if is_listening:
            free.listen()
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
        start = time.monotonic()
        done = study("--on", address, "--output", tmp_path)
        assert time.monotonic() - start < 15
    assert done.returncode == 1
    assert f"no Dask scheduler answers at {address}; start one" in done.stderr and done.stderr.count("\n") == 1


def test_a_job_array_does_the_runs_of_the_first_round(local: bytes, tmp_path: Path) -> None:
    (tmp_path / "regatta").symlink_to(binary())
    folder = tmp_path / "array"
    assert study("--export-jobs", folder).returncode == 0
    path = os.pathsep.join([str(tmp_path), os.environ["PATH"]])
    subprocess.run([folder / "run.sh", "2"], cwd="/", env=os.environ | {"PATH": path}, check=True)
    ids = (folder / "jobs.txt").read_text().split()
    times = {id: (folder / f"results/{id}.json").stat().st_mtime_ns for id in ids}
    done = study("--output", folder)
    assert done.returncode == 0, done.stderr
    assert times == {id: (folder / f"results/{id}.json").stat().st_mtime_ns for id in ids}, "no run was done again"
    assert (folder / "study.json").read_bytes() == local


class Unreliable:
    """A cluster that ends each task as it is told to."""

    name = "test"

    def __init__(self, *endings: Ended | Exception) -> None:
        self._endings = list(endings)

    def slots(self) -> int:
        return 1

    def is_lost(self) -> bool:
        return False

    def submit(self, job: tuple[str, bytes], layout: Path, version: str) -> Future[Ended]:
        future: Future[Ended] = Future()
        ending = self._endings.pop(0)
        if isinstance(ending, Exception):
            future.set_exception(ending)
        else:
            future.set_result(ending)
        return future

    def close(self) -> None:
        pass


LOST = RuntimeError("its worker has died\nat length")
GOOD: Ended = {"result": b"good", "hash": content_hash(b"good")}


@pytest.mark.parametrize(
    ("endings", "failure"),
    [
        ([GOOD], None),
        ([LOST, {"result": b"bad", "hash": content_hash(b"good")}, GOOD], None),
        ([LOST] * MOST_TRIES, "lost 3 times with its worker: RuntimeError: its worker has died"),
        ([{"failure": "a robot is on no node"}], "a robot is on no node"),
    ],
)
def test_a_task_whose_worker_is_lost_is_done_again(
    endings: list[Ended | Exception], failure: str | None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = {name: str(tmp_path / name) for name in ("job", "layout", "result")}
    (tmp_path / "job").write_bytes(b"{}")
    events: queue.SimpleQueue[Event] = queue.SimpleQueue()
    events.put(json.dumps({"id": "a", **files}))
    adapter = Adapter(Unreliable(*endings), "", events)
    for _ in range(1 + len(endings)):
        event = events.get(timeout=PATIENCE)
        assert event is not None
        adapter.handle(event)
    assert json.loads(capsys.readouterr().out) == {"id": "a", "failure": failure}
    assert (tmp_path / "result").exists() == (failure is None)


def test_ray_without_its_client_is_told(tmp_path: Path) -> None:
    (tmp_path / "ray.py").touch()
    (tmp_path / "grpc.py").write_text("raise ModuleNotFoundError('no gRPC', name='grpc')")
    code = "from regatta.cluster._clusters import connect; connect('ray://127.0.0.1:' + __import__('sys').argv[1], print)"
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", 0))
        listening.listen()
        command = [sys.executable, "-c", code, str(listening.getsockname()[1])]
        environment = os.environ | {"PYTHONPATH": str(tmp_path)}
        done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=PATIENCE)
    message = done.stderr.splitlines()[-1]
    assert "has Ray without its client: pip install 'regatta-sim[study-ray]'" in message, done.stderr


def is_open(port: int) -> bool | None:
    """Whether somebody listens on a port of this machine."""
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0 or None


@pytest.mark.skipif(not has_ray, reason="needs Ray: pip install 'regatta-sim[study-ray]'")
def test_ray_gives_the_same_answer_byte_by_byte(local: bytes, tmp_path: Path) -> None:
    ports = [socket.socket() for _ in range(2)]
    for port in ports:
        port.bind(("127.0.0.1", 0))
    gcs, client = (port.getsockname()[1] for port in ports)
    for port in ports:
        port.close()
    ray = [sys.executable, "-m", "ray.scripts.scripts", "start", "--head", "--block", "--num-cpus=2"]
    options = ["--node-ip-address=127.0.0.1", f"--port={gcs}", f"--ray-client-server-port={client}"]
    environment = ["env", f"REGATTA_PROGRAM={binary()}", "RAY_USAGE_STATS_ENABLED=0"]
    head = Process([*environment, *ray, *options, "--include-dashboard=false", "--disable-usage-stats"])
    try:
        eventually("the head", lambda: "Ray runtime started" in head.output or head.child.poll())
        assert head.child.poll() is None, head.errors
        # The head says that before its client server listens.
        eventually("the client server", lambda: is_open(client))
        done = study("--on", f"ray://127.0.0.1:{client}", "--output", tmp_path / "study")
    finally:
        head.child.terminate()
        head.child.wait(PATIENCE)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "study/study.json").read_bytes() == local
