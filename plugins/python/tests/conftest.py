"""Fixtures and helpers: an engine process under a fleet name of its own, and child processes."""

import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TypeVar

import pytest

import regatta

T = TypeVar("T")

ROOT = Path(__file__).resolve().parents[3]
EXAMPLES = ROOT / "plugins/python/examples"

PATIENCE = 60.0
"""The longest wait for anything, in seconds: the machine may be busy."""


def binary() -> Path:
    """Returns the program ``regatta``: ``REGATTA_BIN``, or else the one that cargo built last."""
    if "REGATTA_BIN" in os.environ:
        return Path(os.environ["REGATTA_BIN"])
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    built = [path for path in (target / "debug/regatta", target / "release/regatta") if path.exists()]
    if not built:
        pytest.exit(f"no regatta in {target}: run `cargo build` first, or set REGATTA_BIN", returncode=1)
    return max(built, key=lambda path: path.stat().st_mtime)


def eventually(what: str, attempt: Callable[[], T | None]) -> T:
    """Repeats an attempt until it returns a value that is not ``None``."""
    start = time.monotonic()
    while time.monotonic() - start < PATIENCE:
        value = attempt()
        if value is not None:
            return value
        time.sleep(0.005)
    pytest.fail(f"{what}: not within {PATIENCE} s")


def processes() -> dict[int, str]:
    """Returns the command lines of all processes of this machine, by their numbers."""
    table = subprocess.run(["ps", "-A", "-ww", "-o", "pid=,args="], check=True, capture_output=True, text=True).stdout
    return {int(number): arguments for number, arguments in re.findall(r"^ *(\d+) (.*)$", table, re.MULTILINE)}


class Process:
    """A child process."""

    def __init__(self, command: list[str | Path]) -> None:
        # Unlike pipes, files never fill up, and can be read from the start at any time.
        self._output, self._errors = tempfile.TemporaryFile(), tempfile.TemporaryFile()
        self._read = 0
        self.child = subprocess.Popen(
            [str(part) for part in command],
            stdin=subprocess.DEVNULL,
            stdout=self._output,
            stderr=self._errors,
            # If a shell runs the tests in the background, they and their children inherit that Ctrl-C is ignored.
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        )

    @property
    def output(self) -> str:
        """Everything that it has printed."""
        return os.pread(self._output.fileno(), 1 << 24, 0).decode()

    @property
    def errors(self) -> str:
        """Everything that it has written to standard error."""
        return os.pread(self._errors.fileno(), 1 << 24, 0).decode()

    def lines(self, count: int) -> list[str]:
        """Waits for its next lines on standard output."""

        def next_lines() -> list[str] | None:
            lines = self.output.split("\n")[self._read : -1]
            assert len(lines) >= count or self.child.poll() is None, self.errors
            return lines[:count] if len(lines) >= count else None

        lines = eventually("output", next_lines)
        self._read += count
        return lines

    def send(self, number: int) -> None:
        """Sends a signal."""
        self.child.send_signal(number)

    def kill(self) -> None:
        """Kills it as ``kill -9`` does."""
        self.child.kill()
        self.child.wait()

    def end(self, number: int = signal.SIGINT) -> str:
        """Asks it to end, which must succeed. Returns everything that it printed."""
        self.child.send_signal(number)
        return self.finish()

    def finish(self) -> str:
        """Waits until it has ended, which must be with success. Returns everything that it printed."""
        assert self.child.wait(PATIENCE) == 0, self.errors
        return self.output

    def fail(self) -> str:
        """Waits until it has ended, which must be with an error. Returns what it wrote to standard error."""
        assert self.child.wait(PATIENCE) == 1, self.output
        return self.errors


class Engine:
    """A fleet of its own for a test, with its processes."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.processes: list[Process] = []

    def start(self, *arguments: str, scenario: str = "thirty.yaml") -> Process:
        """Starts an engine and waits until it answers."""
        process = self.start_unanswered(*arguments, scenario=scenario)
        control = regatta.join(self.name, "test").control()

        def answers() -> bool | None:
            assert process.child.poll() is None, process.errors
            try:
                return control.status().pid == process.child.pid or None
            except regatta.ControlError:
                return None

        eventually("an answer of the engine", answers)
        return process

    def start_unanswered(self, *arguments: str, scenario: str = "thirty.yaml") -> Process:
        """Starts an engine, without waiting for it."""
        return self.run(binary(), "engine", ROOT / "graphs" / scenario, "--fleet", self.name, *arguments)

    def run(self, *command: str | Path) -> Process:
        """Starts a process that ends with the test at the latest."""
        process = Process(list(command))
        self.processes.append(process)
        return process

    def example(self, name: str, *arguments: str) -> Process:
        """Starts one of the examples on this fleet."""
        return self.script(EXAMPLES / name, "--fleet", self.name, *arguments)

    def script(self, path: Path, *arguments: str) -> Process:
        """Starts a program in Python."""
        return self.run(sys.executable, path, *arguments)

    def python(self, code: str) -> Process:
        """Starts a program in Python. The variable ``FLEET`` is the fleet's name."""
        return self.run(sys.executable, "-u", "-c", f"FLEET = {self.name!r}\nimport regatta\n{code}")

    def stop(self) -> None:
        """Ends the processes that still run."""
        for process in self.processes:
            process.child.terminate()
        for process in self.processes:
            try:
                process.child.wait(PATIENCE)
            except subprocess.TimeoutExpired:
                process.kill()


@pytest.fixture(autouse=True, scope="session")
def clean() -> Iterator[None]:
    """Cleans up after the processes that tests have killed: each process that joins a fleet does so."""
    yield
    regatta.join("test-python-clean")


@pytest.fixture
def engine(request: pytest.FixtureRequest) -> Iterator[Engine]:
    """A fleet that no other test and no other run of the tests uses. Its engine isn't started yet."""
    test = re.sub(r"[^a-z0-9]+", "-", request.node.name.removeprefix("test_"))[:30]
    engine = Engine(f"test-python-{test}-{os.getpid()}")
    yield engine
    engine.stop()


@pytest.fixture
def fleet(engine: Engine) -> regatta.Fleet:
    """A fleet whose engine runs."""
    engine.start()
    return regatta.join(engine.name, "test")


def let_ticks_pass(fleet: regatta.Fleet, ticks: int) -> None:
    """Waits until the engine has made ``ticks`` more ticks."""
    control = fleet.control()
    target = control.status().tick + ticks
    eventually("more ticks", lambda: control.status().tick >= target or None)


def next_frame(frames: regatta.Frames) -> regatta.Frame:
    """Waits for the next frame."""
    frame = frames.wait(PATIENCE)
    assert frame is not None, "no frame"
    return frame
