"""The rate at which a program gets frames."""

import time

from regatta._contract import FrameHeader

SLICE = 0.1
"""The longest sleep, in seconds, between two checks whether to end."""


def checked_rate(rate: float) -> float:
    """Returns a rate in frames per second, or raises ``ValueError`` if it is invalid."""
    if not 0 < rate <= 1e6:
        raise ValueError(
            f"invalid rate {rate!r}; give frames per second, greater than 0 and at most 1000000, or None for all"
        )
    return rate


class RateLimiter:
    """Limits the rate at which a program gets frames: by the wall clock, or in lockstep by simulated time so that runs
    repeat."""

    def __init__(self, rate: float | None) -> None:
        self._period = 0.0 if rate is None else 1.0 / rate
        self._period_nanos = round(self._period * 1e9)
        self._wall = time.monotonic()
        self._lockstep = False
        self._run_id = 0
        self._simulated_nanos = 0

    def left(self) -> float:
        """Returns the time, in seconds, until the next frame is due; 0 if it is due. In lockstep, where each frame must
        be received, it always is."""
        return 0.0 if self._lockstep else max(0.0, self._wall - time.monotonic())

    def admits(self, header: FrameHeader) -> bool:
        """Registers a received frame, and returns whether the program gets it."""
        self._lockstep = header.lockstep != 0
        now = time.monotonic()
        # Behind by more than a period: don't hurry to catch up. Frames in lockstep come at any rate, and leave the wall
        # clock where it is: a run may go on without lockstep.
        following = now if self._lockstep else self._wall + self._period
        self._wall = max(following, now - self._period)
        if header.run_id != self._run_id:
            self._run_id, self._simulated_nanos = header.run_id, header.sim_time_nanos
        if self._lockstep and header.sim_time_nanos < self._simulated_nanos:
            return False
        oldest = header.sim_time_nanos - self._period_nanos
        self._simulated_nanos = max(self._simulated_nanos + self._period_nanos, oldest)
        return True
