"""Recordings, as frames and as tables."""

from __future__ import annotations

import math
import os
import secrets
import subprocess
import tempfile
import weakref
from pathlib import Path
from time import monotonic, sleep
from typing import TYPE_CHECKING

import numpy as np

from regatta._errors import ReadError
from regatta._fleet import Fleet
from regatta._frame import Frame
from regatta._frames import Frames
from regatta._newest import RecordingClock
from regatta._program import end, environment, find_program
from regatta._table import Rows, joined, package, rows_of, to_pandas, to_polars
from regatta._termination import Termination

if TYPE_CHECKING:
    import pandas
    import polars

TIMEOUT_SECS = 1_000_000
"""The longest time, in seconds, that a replay waits for the body of a loop."""
MAX_ROWS = 10_000_000
"""The largest number of rows of a table, unless the program gives another one: half a gigabyte or so."""
CLOCK_SECS = 10.0
"""The longest wait, in seconds, for the time of the recording."""
TOLERANCE_SECS = 1e-6
"""The time, in seconds, by which a frame may be early: the time of a tick is rounded to nanoseconds."""


class Recording(Frames):
    """The frames of a recording, each once, in their order.

    The program ``regatta replay`` publishes the recording as a fleet of its own, and waits for each turn of the loop.
    So ``frame.world`` and ``frame.columns`` work as with a live fleet, and ``recording.fleet.events().take()`` has the
    recorded events up to the frame's tick. The replay ends with this object: when it is closed, when nothing refers to
    it any more, or with the program.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        program = find_program()
        if program is None:
            raise ReadError("the program regatta isn't installed: install the wheel, or set REGATTA_PROGRAM to its path")
        self.path = Path(path)
        """The file."""
        name = f"read-{os.getpid()}-{secrets.token_hex(4)}"
        command = [program, "replay", os.fspath(path), "--fleet", name, "--speed", "max", "--lockstep", name]
        command += ["--lockstep-timeout", str(TIMEOUT_SECS)]
        self._errors = tempfile.TemporaryFile()
        self._replay = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=self._errors, env=environment()
        )
        self._end = weakref.finalize(self, end, self._replay, self._errors)
        super().__init__(Fleet(name, name), None)

    def __repr__(self) -> str:
        state = ", closed" if self.closed else ""
        return f"<regatta.Recording: '{self.path}'{state}>"

    def to_pandas(self, every: float | None = None, rows: int = MAX_ROWS) -> pandas.DataFrame:
        """Returns the whole recording as a data frame of pandas, which must be installed.

        It has a row per robot and frame, without absent robots, in the order of time. The columns are those of
        ``regatta export``: ``time_s`` (of the recording's clock), ``run`` (from 0), ``tick``, ``sim_time_s``, ``robot``, ``x_m``, ``y_m``, ``theta_rad``,
        ``speed_m_per_s``, ``s_m``, ``edge`` (its id in the route graph; missing if the robot is on none), ``state``
        (a category), and those that were recorded of ``activity`` (a category), ``battery``, ``collision``, ``goal``, ``type`` and
        ``waits_for``.

        ``every`` is a period of simulated time, in seconds: 1.0 takes the first frame of each second. Without it, all
        frames are taken. They are read one after the other, so that only the table takes memory.

        The file is read from its start, however much of it a loop has read. Raises :class:`ReadError
        <regatta.ReadError>` if it can't be read or has more than ``rows`` rows, and ``ValueError`` unless ``every`` is
        positive.
        """
        package("pandas")
        return to_pandas(_rows_of_all(self.path, every, rows))

    def to_polars(self, every: float | None = None, rows: int = MAX_ROWS) -> polars.DataFrame:
        """Returns the whole recording as a data frame of polars, which must be installed. Arguments, columns and errors
        are those of :meth:`to_pandas`."""
        package("polars")
        return to_polars(_rows_of_all(self.path, every, rows))

    def _is_over(self) -> bool:
        code = self._replay.poll()
        if code is None:
            return False
        if code != 0:
            self._errors.seek(0)
            lines = [line for line in self._errors.read().decode().splitlines() if line.strip()]
            raise ReadError(lines[-1].removeprefix("regatta: ") if lines else "the replay has ended with an error")
        return True

    def close(self) -> None:
        if self.closed:
            return
        super().close()
        # The fleet closes all that is open on it.
        self._fleet.close()
        self._end()


def read(path: str | os.PathLike[str]) -> Recording:
    """Opens a recording (MCAP) as frames, or as a table::

        with regatta.read("run.mcap") as recording:
            for frame in recording:
                print(frame.tick, frame.x.mean())

        table = regatta.read("run.mcap").to_pandas(every=1.0)

    Raises :class:`ReadError <regatta.ReadError>` in the loop if the file can't be read.
    """
    return Recording(path)


def _recorded_time(clock: RecordingClock, frame: Frame) -> float:
    """Returns the time of a frame on the recording's clock, in seconds. The replay tells it before the frame."""
    until = monotonic() + CLOCK_SECS
    while (time := clock.time_of(frame.run_id, frame.header.sim_time_nanos)) is None:
        if monotonic() > until:
            raise ReadError("the replay doesn't tell the time of its recording")
        sleep(0.001)
    return time


class _Thinning:
    """Takes the first frame of each period of simulated time."""

    def __init__(self, every: float | None) -> None:
        if every is not None and not 0.0 < every < math.inf:
            raise ValueError(f"every={every} is no time; give a positive number of seconds")
        self._every = every
        self._taken: tuple[int, int] | None = None
        """The run and the number of the period of the frame that was taken last."""

    def takes(self, frame: Frame) -> bool:
        if self._every is None:
            return True
        period = frame.run_id, math.floor((frame.sim_time + TOLERANCE_SECS) / self._every)
        is_new = period != self._taken
        self._taken = period
        return is_new


def _rows_of_all(path: Path, every: float | None, limit: int) -> Rows:
    """Returns the rows of all frames of a recording, or of one per period."""
    thinning, tables, count, runs = _Thinning(every), list[Rows](), 0, dict[int, int]()
    with Termination() as termination, Recording(path) as recording, RecordingClock(recording.fleet) as clock:
        for frame in recording:
            if not thinning.takes(frame):
                continue
            table = rows_of(frame)
            run = runs.setdefault(frame.run_id, len(runs))
            length = len(table["robot"])
            count += length
            if count > limit:
                raise ReadError(f"{path} has more than {limit} rows; give every=1.0 (seconds), or a larger rows=")
            time = np.full(length, _recorded_time(clock, frame))
            tables.append({"time_s": time, "run": np.full(length, run, np.uint32), **table})
        if termination.requested:
            raise KeyboardInterrupt
    if not tables:
        raise ReadError(f"{path} has no frames")
    return joined(tables)
