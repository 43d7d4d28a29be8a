"""The message that a program waits for an engine."""

from __future__ import annotations

import logging
import time

from regatta._contract import FrameHeader
from regatta._node import Node
from regatta._ports import Receiver

log = logging.getLogger("regatta")

SILENCE = 1.0
"""The time without news, in seconds, after which the user gets a message."""


class Silence:
    """Reports once that the fleet has no engine."""

    def __init__(self, frames: Receiver[FrameHeader], node: Node) -> None:
        self._frames = frames
        self._node = node
        self._since = time.monotonic()
        self._reported = False

    def check(self) -> None:
        """Registers that no frame has come."""
        if self._reported or time.monotonic() - self._since < SILENCE:
            return
        self._since = time.monotonic()
        if not self._frames.has_publisher():
            log.warning("%s: waiting for an engine of fleet '%s'", self._node.name, self._node.fleet)
            self._reported = True

    def end(self) -> None:
        """Registers that a frame has come."""
        self._since = time.monotonic()
        self._reported = False
