"""Records of each tick: events, applied commands, changes of contacts."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, TypeVar

import numpy as np
import numpy.typing as npt

from regatta._contract import LAYOUT, CommandLogHeader, ContactEventHeader, EventHeader, OrderHeader, Record, dtype
from regatta._open import Open
from regatta._ports import NAP
from regatta._termination import Termination

if TYPE_CHECKING:
    from regatta._fleet import Fleet

log = logging.getLogger("regatta")

MAX_QUEUED = 1 << 16
"""The largest number of ticks in a reader's queue, which bounds its memory if the program never takes them: 11 minutes
at 100 ticks a second."""

Header = TypeVar("Header", bound=EventHeader | CommandLogHeader | ContactEventHeader | OrderHeader)


@dataclass(frozen=True, eq=False)
class TickRecords(Generic[Header]):
    """The records of one tick. ``records`` is a structured array, a copy: ``records["robot"]``."""

    header: Header
    records: npt.NDArray[np.void]
    missed: int
    """The number of samples (ticks with records) that this reader lost between the last one and this one, because it
    was too slow."""

    @property
    def run_id(self) -> int:
        """The run that the tick belongs to."""
        return self.header.run_id

    @property
    def tick(self) -> int:
        """The tick."""
        return self.header.tick


class TickReader(Open, Generic[Header]):
    """Reads the records of a service tick by tick.

    Loop over it, or call :meth:`take` in a loop over frames::

        events = fleet.events()
        for frame in fleet.frames(rate=1):
            for tick in events.take():
                ...

    Neither loses records, however low the rate: the loop over frames wakes with each frame while it waits, and receives
    the records of each tick into a queue of this reader, from which :meth:`take` returns them. The queue holds up to
    65536 ticks.

    While the body of a loop works, or if there is no loop, nothing is received. The last 1024 ticks with records are kept
    then (at 100 ticks a second, those of 10 s or more). Older ones are lost: ``missed`` and :attr:`lost` count them,
    and a warning (of the logger ``regatta``) gives their number, the first time and whenever it is ten times as large.

    All records of a tick are published before its frame. In lockstep, :meth:`take` in the body of the loop over frames
    therefore has exactly the records up to the frame's tick, and the run is reproducible. (Contact events and
    the order log are the exceptions: their publishers get the same frame. They are complete if the loop comes after those:
    ``fleet.frames(after=["collision"])``.)
    """

    def __init__(self, fleet: Fleet, service: str, what: str, record: type[Record], header: type[Header]) -> None:
        self._what = what
        self._receiver = fleet._node.receiver(service, what, record, header)
        super().__init__(fleet, self._receiver)
        self._dtype = dtype(record)
        self._queue: deque[TickRecords[Header]] = deque()
        self._warn_at = 1
        fleet._readers.add(self)

    def close(self) -> None:
        """Stops reading, and discards the queue. Closing it again does nothing."""
        self._fleet._readers.discard(self)
        self._queue.clear()
        super().close()

    @property
    def lost(self) -> int:
        """The number of samples that this reader lost so far."""
        return self._receiver.lost

    def take(self) -> list[TickRecords[Header]]:
        """Returns the records of all ticks that have arrived, oldest first. Doesn't wait."""
        self._receive()
        taken = list(self._queue)
        self._queue.clear()
        return taken

    def __iter__(self) -> Iterator[TickRecords[Header]]:
        """Waits for records, tick by tick, until Ctrl-C or SIGTERM."""
        wake = self._fleet._node.wake()
        with Termination() as termination:
            while not (termination.requested or self.closed):
                if not self._queue:
                    self._receive()
                if self._queue:
                    yield self._queue.popleft()
                else:
                    # Contact events come without a wake-up.
                    wake.sleep(NAP)

    def _receive(self) -> None:
        """Moves the records that have arrived to the queue."""
        # Bounded, so that a publisher faster than this can't keep a program from its frames.
        for _ in range(min(2 * LAYOUT["event_buffer"], MAX_QUEUED - len(self._queue))):
            sample = self._receiver.receive()
            if sample is None:
                break
            records = sample.payload.view(self._dtype).copy()
            self._queue.append(TickRecords(sample.header, records, sample.missed))
            del sample  # given back before the next is asked for
        if self.lost >= self._warn_at:
            self._warn_at = 10 * self.lost
            program = self._fleet._node.name
            log.warning("%s: lost %s of %d ticks so far; the program is too slow", program, self._what, self.lost)
