"""A running engine process under a fleet name of its own, and what the tests share."""

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
"""Longest wait for anything, in seconds: these machines may be busy."""


def binary() -> Path:
    """The program ``regatta``: ``REGATTA_BIN``, or else what cargo built last."""
    if "REGATTA_BIN" in os.environ:
        return Path(os.environ["REGATTA_BIN"])
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    built = [path for path in (target / "debug/regatta", target / "release/regatta") if path.exists()]
    if not built:
        pytest.exit(f"no regatta in {target}: run `cargo build` first, or set REGATTA_BIN", returncode=1)
    return max(built, key=lambda path: path.stat().st_mtime)


def eventually(what: str, attempt: Callable[[], T | None]) -> T:
    """Tries until there is a value that is not ``None``."""
    start = time.monotonic()
    while time.monotonic() - start < PATIENCE:
        value = attempt()
        if value is not None:
            return value
        time.sleep(0.005)
    pytest.fail(f"{what}: not within {PATIENCE} s")


class Process:
    """A child process, to be killed when the test ends."""

    def __init__(self, command: list[str | Path]) -> None:
        # Files never fill up, and can be read from the start at any time.
        self._output, self._errors = tempfile.TemporaryFile(), tempfile.TemporaryFile()
        self._read = 0
        self.child = subprocess.Popen(
            [str(part) for part in command],
            stdin=subprocess.DEVNULL,
            stdout=self._output,
            stderr=self._errors,
            # A shell that runs the tests in the background has Ctrl-C ignored, by them and by their children.
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        )

    @property
    def output(self) -> str:
        """All that it has printed."""
        return os.pread(self._output.fileno(), 1 << 24, 0).decode()

    @property
    def errors(self) -> str:
        """All that it has written to standard error."""
        return os.pread(self._errors.fileno(), 1 << 24, 0).decode()

    def lines(self, count: int) -> list[str]:
        """Its next lines on standard output."""

        def look() -> list[str] | None:
            lines = self.output.split("\n")[self._read : -1]
            assert len(lines) >= count or self.child.poll() is None, self.errors
            return lines[:count] if len(lines) >= count else None

        lines = eventually("it prints", look)
        self._read += count
        return lines

    def send(self, number: int) -> None:
        self.child.send_signal(number)

    def kill(self) -> None:
        """As ``kill -9`` does."""
        self.child.kill()
        self.child.wait()

    def end(self, number: int = signal.SIGINT) -> str:
        """Asks it to end, which it must do well; all that it printed."""
        self.child.send_signal(number)
        return self.finish()

    def finish(self) -> str:
        """Waits for its end, which must be a good one; all that it printed."""
        assert self.child.wait(PATIENCE) == 0, self.errors
        return self.output


class Engine:
    """A fleet's name, and its engine when it runs."""

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

        eventually("the engine answers", answers)
        return process

    def start_unanswered(self, *arguments: str, scenario: str = "thirty.yaml") -> Process:
        """Starts an engine."""
        return self.run(binary(), "engine", ROOT / "graphs" / scenario, "--fleet", self.name, *arguments)

    def run(self, *command: str | Path) -> Process:
        """Starts a process that ends with the test, at the latest."""
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
        """Starts a program on this fleet, whose name it has as ``FLEET``."""
        return self.run(sys.executable, "-u", "-c", f"FLEET = {self.name!r}\nimport regatta\n{code}")

    def stop(self) -> None:
        """Ends what still runs."""
        for process in self.processes:
            process.child.terminate()
        for process in self.processes:
            try:
                process.child.wait(PATIENCE)
            except subprocess.TimeoutExpired:
                process.kill()


@pytest.fixture(autouse=True, scope="session")
def clean() -> Iterator[None]:
    """Leaves nothing of the processes that tests have killed: who joins a fleet cleans up after the dead."""
    yield
    regatta.join("test-python-clean")


@pytest.fixture
def engine(request: pytest.FixtureRequest) -> Iterator[Engine]:
    """A fleet that no other test and no other run of the tests has; its engine is to be started."""
    test = re.sub(r"[^a-z0-9]+", "-", request.node.name.removeprefix("test_"))[:30]
    engine = Engine(f"test-python-{test}-{os.getpid()}")
    yield engine
    engine.stop()


@pytest.fixture
def fleet(engine: Engine) -> regatta.Fleet:
    """A place in a fleet whose engine runs."""
    engine.start()
    return regatta.join(engine.name, "test")


def let_ticks_pass(fleet: regatta.Fleet, ticks: int) -> None:
    """Waits until the engine has made so many more ticks."""
    control = fleet.control()
    target = control.status().tick + ticks
    eventually("the engine goes on", lambda: control.status().tick >= target or None)


def next_frame(frames: regatta.Frames) -> regatta.Frame:
    """The next frame."""
    frame = frames.wait(PATIENCE)
    assert frame is not None, "no frame"
    return frame
