"""Records of each tick: events, applied orders, changes of contacts."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
import numpy.typing as npt

from regatta._contract import LAYOUT, ContactEventHeader, EventHeader, OrderLogHeader, Record, dtype
from regatta._node import Node
from regatta._ports import NAP
from regatta._termination import Termination

Header = TypeVar("Header", bound=EventHeader | OrderLogHeader | ContactEventHeader)


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


class TickReader(Generic[Header]):
    """Reads the records of a service tick by tick.

    It holds the last 64 ticks with records that it hasn't taken yet. A reader that lags behind further loses the
    oldest, and ``missed`` is their number. There are two ways to lose none:

    - Loop over it. The loop wakes with each frame, and so it keeps up however rarely the program reads a frame::

          frames, events = fleet.frames(), fleet.events()
          for tick in events:
              frame = frames.latest()  # the newest one, if there is a new one

    - Call :meth:`take` in a loop over all frames, without a rate: at 100 ticks a second, a loop over one frame a second
      would lose events. Skip frames in the body of the loop instead::

          due = 0.0
          for frame in fleet.frames():
              for tick in events.take():
                  ...
              if frame.sim_time >= due:
                  due = frame.sim_time + 1.0
                  ...

      All records of a tick are published before its frame. In lockstep, :meth:`take` in the body of the loop therefore
      has exactly the records up to the frame's tick, and the run is reproducible. (Contact events are the exception:
      their publisher gets the same frame. They are complete if the loop comes after it:
      ``fleet.frames(after=["collision"])``.)
    """

    def __init__(self, node: Node, service: str, what: str, record: type[Record], header: type[Header]) -> None:
        self._receiver = node.receiver(service, what, record, header)
        self._node = node
        self._dtype = dtype(record)

    @property
    def lost(self) -> int:
        """The number of samples that this reader lost so far."""
        return self._receiver.lost

    def take(self) -> list[TickRecords[Header]]:
        """Returns the records of all ticks that have arrived, oldest first. Doesn't wait."""
        taken = []
        # Bounded, so that a publisher faster than this can't keep a program from its frames.
        for _ in range(2 * LAYOUT["event_buffer"]):
            sample = self._receiver.receive()
            if sample is None:
                break
            records = sample.payload.view(self._dtype).copy()
            taken.append(TickRecords(sample.header, records, sample.missed))
            del sample  # given back before the next is asked for
        return taken

    def __iter__(self) -> Iterator[TickRecords[Header]]:
        """Waits for records, tick by tick, until Ctrl-C or SIGTERM."""
        wake = self._node.wake()
        with Termination() as termination:
            while not termination.requested:
                taken = self.take()
                for records in taken:
                    yield records
                    if termination.requested:
                        return
                # More may have arrived while the body of the loop worked. Contact events come without a wake-up.
                if not taken:
                    wake.sleep(NAP)
