"""Recordings, as frames."""

from __future__ import annotations

import os
import secrets
import subprocess
import tempfile

from regatta._errors import ReadError
from regatta._fleet import Fleet
from regatta._frames import Frames
from regatta._program import find_program

TIMEOUT_SECS = 1_000_000
"""The longest time, in seconds, that a replay waits for the body of a loop."""


class Recording(Frames):
    """The frames of a recording, each once, in their order.

    The program ``regatta replay`` publishes the recording as a fleet of its own, and waits for each turn of the loop.
    So ``frame.world`` and ``frame.columns`` work as with a live fleet, and ``recording.fleet.events().take()`` has the
    recorded events up to the frame's tick.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        program = find_program()
        if program is None:
            raise ReadError("the program regatta isn't installed: install the wheel, or set REGATTA_PROGRAM to its path")
        name = f"read-{os.getpid()}-{secrets.token_hex(4)}"
        command = [program, "replay", os.fspath(path), "--fleet", name, "--speed", "max", "--lockstep", name]
        command += ["--lockstep-timeout", str(TIMEOUT_SECS)]
        self._errors = tempfile.TemporaryFile()
        self._replay = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=self._errors
        )
        super().__init__(Fleet(name, name), None)

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
        if self._replay.poll() is None:
            self._replay.terminate()
            self._replay.wait()
        self._errors.close()


def read(path: str | os.PathLike[str]) -> Recording:
    """Opens a recording (MCAP) as frames::

        with regatta.read("run.mcap") as recording:
            for frame in recording:
                print(frame.tick, frame.x.mean())

    Raises :class:`ReadError <regatta.ReadError>` in the loop if the file can't be read.
    """
    return Recording(path)
