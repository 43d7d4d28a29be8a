"""Columns: one value per robot, published by a plugin."""

import time

import numpy as np
import numpy.typing as npt

from regatta._contract import WORDS_PER_LINE, ColumnHeader, Line
from regatta._errors import PublishError, ReadError
from regatta._frame import ColumnValues, Frame
from regatta._node import Node
from regatta._ports import Bytes, Sender


FIRST_WAIT = 0.25
"""Seconds in which a publisher hands a new reader what it has published before."""


class ColumnPublisher:
    """Publishes a column: one value per robot, for the frame that they were worked out from.

    The viewer can tint robots by it, and every other process can read it.
    """

    def __init__(self, node: Node, name: str) -> None:
        self._sender: Sender[ColumnHeader] = node.sender(f"columns/{name}", "a column", Line, ColumnHeader)
        self._sent = 0

    def publish(self, frame: Frame, values: npt.ArrayLike) -> None:
        """Publishes one value per robot of the frame. They are written as 32-bit floats.

        Raises :class:`PublishError <regatta.PublishError>` if there are more or fewer.
        """
        given = np.asarray(values)
        robots = len(frame)
        if given.shape != (robots,):
            raise PublishError(
                f"a column of shape {given.shape} doesn't fit a frame of {robots} robots; it needs one value per robot"
            )

        def fill(memory: Bytes) -> None:
            memory.view(np.float32)[:robots] = given

        self._sent = (self._sent + 1) % 2**32
        header = ColumnHeader(frame.run_id, frame.tick, robots, self._sent)
        self._sender.send(header, -(-robots // WORDS_PER_LINE), fill)


class ColumnReader:
    """Reads a column: always the newest values."""

    def __init__(self, node: Node, name: str) -> None:
        self._receiver = node.receiver(f"columns/{name}", f"column '{name}'", Line, ColumnHeader)
        self._name = name
        self._newest: ColumnValues | None = None

    def first(self) -> ColumnValues | None:
        """As :meth:`newest`, but waits for what a publisher that is there has published before."""
        deadline = time.monotonic() + FIRST_WAIT
        while (values := self.newest()) is None and time.monotonic() < deadline and self._receiver.has_publisher():
            time.sleep(0.002)
        return values

    def newest(self) -> ColumnValues | None:
        """The newest values, whether or not they were returned before."""
        if self._receiver.has_samples():
            self._newest = None
            sample = self._receiver.latest()
            if sample is not None:
                header, words = sample.header, sample.payload.view(np.float32)
                if len(words) < header.robots:
                    raise ReadError(f"column '{self._name}' is too short for what its header says")
                self._newest = ColumnValues(header.run_id, header.tick, words[: header.robots])
        return self._newest
