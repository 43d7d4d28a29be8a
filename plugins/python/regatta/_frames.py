"""Reading frames."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from regatta._contract import FrameHeader, Line
from regatta._frame import Frame
from regatta._lockstep import Lockstep
from regatta._open import Open
from regatta._rate import SLICE, RateLimiter, checked_rate
from regatta._silence import Silence
from regatta._termination import Termination

if TYPE_CHECKING:
    from regatta._fleet import Fleet


class Frames(Open):
    """Reads a fleet's frames: always the newest, at any pace. It can't slow the engine down.

    Loop over it::

        for frame in regatta.frames():
            print(frame.tick, frame.x.mean())

    The loop waits for an engine that isn't there yet, continues when the engine restarts, and ends on Ctrl-C or SIGTERM
    (a second Ctrl-C raises ``KeyboardInterrupt``). While the body of the loop works, frames are skipped; the next one
    is the newest, and ``frame.missed`` is the number of those skipped. While the loop waits, it receives the events for
    the fleet's :class:`TickReader <regatta.TickReader>`, so that a low rate loses none.

    If the engine waits for this program (``--lockstep NAME``), the loop gets every tick, and each once. The next
    iteration, or the end of the loop, reports that the tick is finished; commands and columns for it must be sent before.
    In the body, :meth:`fleet.events().take() <regatta.TickReader.take>` has all events up to the frame's tick, and none
    of later ticks. The programs named in ``after`` have finished the tick, so their columns belong to it.
    """

    def __init__(self, fleet: Fleet, rate: float | None, after: Iterable[str] = ()) -> None:
        if rate is not None:
            checked_rate(rate)
        self._rate = rate
        self._lockstep = Lockstep(fleet._node, [after] if isinstance(after, str) else after)
        self._frames = fleet._node.receiver("frames", "a frame", Line, FrameHeader)
        self._wake = fleet._node.wake()
        super().__init__(fleet, self._frames, self._wake, self._lockstep)

    @property
    def fleet(self) -> Fleet:
        """The fleet that this reads, as this program has joined it."""
        return self._fleet

    def latest(self) -> Frame | None:
        """Returns the newest frame, if there is one that this hasn't returned yet. Doesn't wait."""
        sample = self._frames.latest()
        return None if sample is None else Frame(sample, self._fleet)

    def wait(self, timeout: float) -> Frame | None:
        """Waits for a frame that this hasn't returned yet, and returns the newest; ``None`` after ``timeout``
        seconds."""
        deadline = time.monotonic() + timeout
        while not self._frames.has_samples():
            left = deadline - time.monotonic()
            if left <= 0:
                return None
            self._wake.sleep(left)
        return self.latest()

    def _sleep(self, seconds: float) -> None:
        """Sleeps for ``seconds`` or a :data:`SLICE <regatta._rate.SLICE>` at most. If the program reads records of
        ticks, wakes with each frame and receives them, because their buffer is small."""
        if self._fleet._readers:
            self._wake.sleep(seconds)
            self._fleet._receive_records()
        else:
            time.sleep(min(seconds, SLICE))

    def _is_over(self) -> bool:
        """Whether no frame will come any more. A live fleet may always get another engine."""
        return False

    def __iter__(self) -> Iterator[Frame]:
        limiter, lockstep = RateLimiter(self._rate), self._lockstep
        silence = Silence(self._frames, self._fleet._node)
        with Termination() as termination:
            while not (termination.requested or self.closed):
                left = limiter.left()
                if left > 0:
                    self._sleep(left)
                    continue
                frame = self.wait(SLICE)
                # Also before a tick that the program doesn't get is reported: in lockstep, each tick's records count.
                self._fleet._receive_records()
                if frame is None:
                    if self._is_over():
                        return
                    silence.check()
                    lockstep.update()
                    self._fleet._update_columns()
                    continue
                silence.end()
                header = frame.header
                try:
                    is_new = lockstep.is_new(header)
                    if limiter.admits(header) and is_new and lockstep.wait_for_turn(header, termination):
                        yield frame
                finally:
                    # Given back before the next is waited for, unless the body of the loop refers to it.
                    del frame
                    # A program that leaves the loop has finished the frame, too.
                    if not self.closed:
                        lockstep.report(header)
