"""Runs that a program steps through."""

from __future__ import annotations

import os
import secrets
import subprocess
import tempfile
import weakref
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from regatta._contract import WorkFigures
from regatta._errors import Error
from regatta._fleet import Fleet
from regatta._frame import Frame
from regatta._frames import Frames
from regatta._open import Closes
from regatta._program import end, environment, find_program
from regatta._study import Study, study

TIMEOUT_SECS = 1_000_000
"""The longest time, in seconds, that the engine waits for the next step."""
TOLERANCE_SECS = 1e-6
"""The time, in simulated seconds, by which a step may end early: the time of a tick is rounded to nanoseconds."""


class RunError(Error):
    """A run has failed."""


class _Frames(Frames):
    """The frames of a run, which end with its process."""

    def __init__(self, fleet: Fleet, process: subprocess.Popen[bytes]) -> None:
        self._process = process
        super().__init__(fleet, None)

    def _is_over(self) -> bool:
        return self._process.poll() is not None


class Run(Closes):
    """A fleet with its engine, its manager and its plugins, which stands until :meth:`step` lets time pass.

    All of them wait for each other, so that a run repeats bit by bit. It ends with :meth:`close`, or ``with``, and at the
    latest with the program.
    """

    def __init__(
        self, scenario: str | os.PathLike[str], *, robots: int | None = None, seed: int | None = None, trust: bool = False
    ) -> None:
        program = find_program()
        if program is None:
            raise RunError("the program regatta isn't installed: install the wheel, or set REGATTA_PROGRAM to its path")
        self.scenario = Path(scenario)
        """The scenario, or the layout."""
        name = f"run-{os.getpid()}-{secrets.token_hex(4)}"
        command = [program, "run", os.fspath(scenario), "--fleet", name, "--speed", "max", "--warm-up", "0"]
        command += ["--lockstep", f"all,{name}", "--lockstep-timeout", str(TIMEOUT_SECS)]
        command += [] if robots is None else ["--robots", str(robots)]
        command += [] if seed is None else ["--seed", str(seed)]
        command += ["--trust"] if trust else []
        # The program that steps the run shows it: no window opens beside it.
        variables = {key: value for key, value in environment().items() if key not in ("DISPLAY", "WAYLAND_DISPLAY")}
        self._errors = tempfile.TemporaryFile()
        self._process = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=self._errors, env=variables
        )
        self._end = weakref.finalize(self, end, self._process, self._errors)
        self.fleet = Fleet(name, name)
        """The fleet, as this program has joined it."""
        self._work = self.fleet.work()
        self._frames: Iterator[Frame] = iter(_Frames(self.fleet, self._process))
        try:
            self.frame = self._next().copy()
            """The frame of the present time, a copy that can be kept."""
        except BaseException:
            self.close()
            raise

    @property
    def sim_time(self) -> float:
        """The present simulated time, in seconds."""
        return self.frame.sim_time

    @property
    def work(self) -> WorkFigures | None:
        """The figures of the fleet manager so far, not older than a simulated second; ``None`` without a manager."""
        return self._work.latest() or self._work.current()

    def step(self, seconds: float) -> Frame:
        """Lets so many simulated seconds pass, and returns the frame then. Commands that were sent before take effect
        with the first tick."""
        now, until = self.sim_time, self.sim_time + seconds - TOLERANCE_SECS
        frame = self.frame
        while now < until:
            frame = self._next()
            now = frame.sim_time
        # A copy: a reader can hold few frames, and a notebook keeps many.
        self.frame = frame.copy()
        return self.frame

    def study(self, robots: str | int | None = None, **settings: Any) -> Study:
        """Computes how many robots the plant of this run holds; see :func:`regatta.study`."""
        return study(self.scenario, robots, **settings)

    def close(self) -> None:
        """Ends the run. Closing it again does nothing."""
        self.fleet.close()
        self._end()

    def __repr__(self) -> str:
        state = "ended" if self._process.poll() is not None else f"at {self.sim_time:.2f} s, {len(self.frame)} robots"
        return f"<regatta.Run: {self.scenario.name}, {state}>"

    def _next(self) -> Frame:
        frame = next(self._frames, None)
        if frame is not None:
            return frame
        self._process.wait()
        self._errors.seek(0)
        lines = [line for line in self._errors.read().decode(errors="replace").splitlines() if line.strip()]
        raise RunError(lines[-1].removeprefix("regatta: ") if lines else "the run has ended")
