"""What happens from tick to tick: events, orders taken, changes of contacts."""

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
    """What one tick brought. ``records`` is a structured array, a copy: ``records["robot"]``."""

    header: Header
    records: npt.NDArray[np.void]
    missed: int
    """Ticks that this reader was too slow for, between the last ones it got and these."""

    @property
    def run_id(self) -> int:
        """The run that the tick belongs to."""
        return self.header.run_id

    @property
    def tick(self) -> int:
        """The tick."""
        return self.header.tick


class TickReader(Generic[Header]):
    """Reads what happens from tick to tick. One that lags more than 64 such ticks behind misses the oldest, and is told
    how many."""

    def __init__(self, node: Node, service: str, what: str, record: type[Record], header: type[Header]) -> None:
        self._receiver = node.receiver(service, what, record, header)
        self._node = node
        self._dtype = dtype(record)
        self._last = (0, 0)

    def take(self) -> list[TickRecords[Header]]:
        """All that has arrived, oldest first. Doesn't wait."""
        taken = []
        # Bounded, so that a producer faster than this can't keep a program from its frames.
        for _ in range(2 * LAYOUT["event_buffer"]):
            sample = self._receiver.receive()
            if sample is None:
                break
            records = sample.payload.view(self._dtype).copy()
            taken.append(TickRecords(sample.header, records, self._missed(sample.header)))
            del sample  # given back before the next is asked for
        return taken

    def __iter__(self) -> Iterator[TickRecords[Header]]:
        """Waits for what comes, until Ctrl-C or SIGTERM."""
        wake = self._node.wake()
        with Termination() as termination:
            while not termination.requested:
                yield from self.take()
                wake.sleep(NAP)

    def _missed(self, header: Header) -> int:
        run_id, sequence = self._last
        self._last = (header.run_id, header.sequence)
        return max(0, header.sequence - sequence - 1) if header.run_id == run_id else 0
