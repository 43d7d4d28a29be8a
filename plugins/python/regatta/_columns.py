"""Columns: one value per robot, published by a plugin."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from regatta._contract import WORDS_PER_LINE, ColumnHeader, Line
from regatta._errors import PublishError, ReadError
from regatta._frame import ColumnValues, Frame
from regatta._node import Node
from regatta._open import Open
from regatta._ports import Bytes, Sender
from regatta._sequence import SequenceCounter

if TYPE_CHECKING:
    from regatta._fleet import Fleet

FIRST_WAIT = 1.0
"""The longest time, in seconds, to wait until a publisher gives a new reader the values that it has published
before."""


class ColumnPublisher(Open):
    """Publishes a column: one value per robot, for the frame that the values were computed from.

    The viewer can tint robots by it, and every other process can read it.
    """

    def __init__(self, fleet: Fleet, name: str) -> None:
        what = f"column '{name}'"
        self._sender: Sender[ColumnHeader] = fleet._node.sender(f"columns/{name}", what, Line, ColumnHeader)
        self._sequence = SequenceCounter()
        super().__init__(fleet, self._sender)
        fleet._publishers.add(self)

    def close(self) -> None:
        """Stops publishing: readers keep the last values that they have got, and another process may publish the
        column. Closing it again does nothing."""
        self._fleet._publishers.discard(self)
        super().close()

    def publish(self, frame: Frame, values: npt.ArrayLike) -> None:
        """Publishes one value per robot of the frame, as 32-bit floats.

        Raises :class:`PublishError <regatta.PublishError>` if there are more or fewer values than robots.
        """
        given = np.asarray(values)
        robots = len(frame)
        if given.shape != (robots,):
            raise PublishError(
                f"a column of shape {given.shape} doesn't fit a frame of {robots} robots; it needs one value per robot"
            )

        header = ColumnHeader(run_id=frame.run_id, tick=frame.tick, robots=robots)

        def fill(memory: Bytes) -> None:
            memory.view(np.float32)[:robots] = given
            # Only now: a number that isn't sent would count as a lost sample.
            header.sequence = self._sequence.next(frame.run_id)

        self._sender.send(header, -(-robots // WORDS_PER_LINE), fill)

    def update(self) -> None:
        """Gives the newest values to readers that have joined since. Publishing does so as well, and so does a loop
        over frames while no frame comes."""
        self._sender.update()


class ColumnReader:
    """Reads the newest values of a column."""

    def __init__(self, node: Node, name: str) -> None:
        self._receiver = node.receiver(f"columns/{name}", f"column '{name}'", Line, ColumnHeader)
        self._name = name
        self._newest: ColumnValues | None = None

    def close(self) -> None:
        """Frees the place at the column."""
        self._newest = None
        self._receiver.close()

    def first(self) -> ColumnValues | None:
        """Returns the newest values. If there is a publisher, waits a moment for the values that it has published
        before."""
        deadline = time.monotonic() + FIRST_WAIT
        while (values := self.newest()) is None and time.monotonic() < deadline and self._receiver.has_publisher():
            time.sleep(0.002)
        return values

    def newest(self) -> ColumnValues | None:
        """Returns the newest values, whether or not they were returned before."""
        if self._receiver.has_samples():
            self._newest = None
            sample = self._receiver.latest()
            if sample is not None:
                header, words = sample.header, sample.payload.view(np.float32)
                if len(words) < header.robots:
                    raise ReadError(f"column '{self._name}' is shorter than its header says; its publisher is at fault")
                self._newest = ColumnValues(header.run_id, header.tick, words[: header.robots], sample.missed)
        return self._newest
