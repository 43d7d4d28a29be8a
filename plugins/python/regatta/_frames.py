"""Reading frames."""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator
from typing import TYPE_CHECKING

from regatta._contract import FrameHeader, Line
from regatta._frame import Frame
from regatta._ports import Receiver
from regatta._termination import Termination

if TYPE_CHECKING:
    from regatta._fleet import Fleet

log = logging.getLogger("regatta")

SLICE = 0.1
"""Longest sleep in seconds between two looks whether to end."""
SILENCE = 1.0
"""After so many seconds without frames, look whether there is an engine at all."""


class Frames:
    """Reads a fleet's frames: always the newest, at whatever pace. It can't slow the engine down.

    Loop over it::

        for frame in regatta.frames():
            print(frame.tick, frame.x.mean())

    The loop waits for an engine that isn't there yet, goes on when the engine restarts, and ends on Ctrl-C or SIGTERM
    (a second Ctrl-C raises ``KeyboardInterrupt``). Frames that come while its body works are skipped but for the newest.
    If the engine waits for this program (``--lockstep NAME``), every frame comes, and the next round of the loop is the
    report that this one is finished.
    """

    def __init__(self, fleet: Fleet, rate: float | None) -> None:
        if rate is not None:
            checked_rate(rate)
        self._fleet = fleet
        self._rate = rate
        self._frames = fleet._node.receiver("frames", "a frame", Line, FrameHeader)
        self._wake = fleet._node.wake()

    @property
    def fleet(self) -> Fleet:
        """The place in the fleet that this is opened on."""
        return self._fleet

    def latest(self) -> Frame | None:
        """The newest frame, if there is one that this hasn't returned yet. Doesn't wait."""
        sample = self._frames.latest()
        return None if sample is None else Frame(sample, self._fleet)

    def wait(self, timeout: float) -> Frame | None:
        """The newest frame, as soon as there is one that this hasn't returned yet; ``None`` after ``timeout`` seconds."""
        deadline = time.monotonic() + timeout
        while not self._frames.has_samples():
            left = deadline - time.monotonic()
            if left <= 0:
                return None
            self._wake.sleep(left)
        return self.latest()

    def __iter__(self) -> Iterator[Frame]:
        pace, silence, reporter = _Pace(self._rate), _Silence(self._frames, self._fleet), None
        with Termination() as termination:
            while not termination.requested:
                if not pace.sleep():
                    continue
                frame = self.wait(SLICE)
                if frame is None:
                    silence.look()
                    continue
                silence.end()
                header = frame.header
                try:
                    if pace.is_due(header):
                        yield frame
                finally:
                    # Given back before the next is waited for, unless the loop's body refers to it.
                    del frame
                    # Whoever leaves the loop has finished the frame, too.
                    if header.lockstep:
                        reporter = reporter or self._fleet._node.reporter()
                        reporter.done(header.run_id, header.tick)


def checked_rate(rate: float) -> float:
    """A number of frames a second, if it is one."""
    if not 0 < rate <= 1e6:
        raise ValueError(f"{rate!r} is no rate; give frames per second, greater than 0 and at most 1000000, or None for all")
    return rate


class _Pace:
    """Keeps to the wanted rate: by the wall clock, or in lockstep by simulated time so that runs repeat."""

    def __init__(self, rate: float | None) -> None:
        self._period = 0.0 if rate is None else 1.0 / rate
        self._period_nanos = round(self._period * 1e9)
        self._wall = time.monotonic()
        self._lockstep = False
        self._run_id = 0
        self._simulated_nanos = 0

    def sleep(self) -> bool:
        """Sleeps until the next frame is due, for a :data:`SLICE` at most. Whether it is due."""
        left = self._wall - time.monotonic()
        if self._lockstep or left <= 0:
            return True
        time.sleep(min(left, SLICE))
        return left <= SLICE

    def is_due(self, header: FrameHeader) -> bool:
        """Whether a frame is to be looked at."""
        self._lockstep = header.lockstep != 0
        # Behind by more than a period: don't hurry to catch up.
        self._wall = max(self._wall + self._period, time.monotonic() - self._period)
        if header.run_id != self._run_id:
            self._run_id, self._simulated_nanos = header.run_id, header.sim_time_nanos
        if self._lockstep and header.sim_time_nanos < self._simulated_nanos:
            return False
        oldest = header.sim_time_nanos - self._period_nanos
        self._simulated_nanos = max(self._simulated_nanos + self._period_nanos, oldest)
        return True


class _Silence:
    """Says once that there is no engine."""

    def __init__(self, frames: Receiver[FrameHeader], fleet: Fleet) -> None:
        self._frames = frames
        self._fleet = fleet
        self._since = time.monotonic()
        self._said = False

    def look(self) -> None:
        """No frame came."""
        if self._said or time.monotonic() - self._since < SILENCE:
            return
        self._since = time.monotonic()
        if not self._frames.has_publisher():
            log.warning("%s: waiting for an engine of fleet '%s'", self._fleet.participant, self._fleet.name)
            self._said = True

    def end(self) -> None:
        """A frame came."""
        self._since = time.monotonic()
        self._said = False
