"""A program's part in lockstep: it waits for the programs that it comes after, and reports each tick."""

from __future__ import annotations

import atexit
import contextlib
import logging
import os
import sys
import time
from collections.abc import Callable, Iterable
from functools import partial

from regatta._contract import FrameHeader
from regatta._errors import PublishError
from regatta._node import Node
from regatta._reports import DoneReports, Reporter
from regatta._silence import SILENCE
from regatta._termination import Termination

log = logging.getLogger("regatta")

AFTER_VARIABLE = "REGATTA_PLUGIN_AFTER"
"""The environment variable with the names of the programs that this one comes after, separated by commas. ``regatta
run`` sets it to the names in the scenario."""


class Lockstep:
    """A program's part in lockstep. Does nothing while frames are not in lockstep."""

    def __init__(self, node: Node, after: Iterable[str]) -> None:
        given = (name.strip() for name in os.environ.get(AFTER_VARIABLE, "").split(","))
        self._after = list(dict.fromkeys([*after, *(name for name in given if name)]))
        if node.name in self._after:
            raise ValueError(f"'{node.name}' can't come after itself; see `after`, --after and {AFTER_VARIABLE}")
        self._node = node
        self._reporter: Reporter | None = None
        self._reports: DoneReports | None = None
        self._last = (0, -1)
        self._run = [0]
        self._leave: Callable[[], None] | None = None

    def is_new(self, header: FrameHeader) -> bool:
        """Registers a frame, and returns whether it is to be handed out. In lockstep each tick counts once: the speed of
        processes would decide whether a frame that is published again is seen."""
        this = (header.run_id, header.tick)
        is_new = this != self._last or not header.lockstep
        self._last = this
        return is_new

    def wait_for_turn(self, header: FrameHeader, termination: Termination) -> bool:
        """Waits until the programs that this one comes after have finished a frame's tick. Returns ``False`` if the
        process is asked to end."""
        if not header.lockstep or not self._after:
            return True
        self._reports = self._reports or self._node.done_reports()
        start: float | None = time.monotonic()
        while not termination.requested:
            missing = self._reports.missing(self._after, header.run_id, header.tick)
            if not missing:
                return True
            if start is not None and time.monotonic() - start >= SILENCE:
                log.warning("%s: waiting for %s to finish tick %d", self._node.name, ", ".join(missing), header.tick)
                start = None
            self._reports.sleep(SILENCE)
        return False

    def report(self, header: FrameHeader) -> None:
        """Reports that a frame's tick is finished."""
        if header.lockstep:
            if self._reporter is None:
                self._reporter = self._node.reporter()
                # Only then is it known whether the program fails. It keeps the reporter until then.
                self._leave = partial(_leave, self._reporter, self._run)
                atexit.register(self._leave)
            self._run[0] = header.run_id
            self._reporter.done(header.run_id, header.tick)

    def close(self) -> None:
        """Leaves the lockstep, and frees the places at the services."""
        leave, self._leave = self._leave, None
        if leave is not None:
            leave()
            atexit.unregister(leave)
        for port in (self._reporter, self._reports):
            if port is not None:
                port.close()

    def update(self) -> None:
        """Gives the last report to programs that have joined since. Must be called every now and then while no frame
        comes."""
        if self._reporter is not None:
            self._reporter.update()


def _leave(reporter: Reporter, run: list[int]) -> None:
    """Leaves the lockstep, unless the program ends because of an error: then the engine names it."""
    failed = sys.exc_info()[0] not in (None, GeneratorExit, KeyboardInterrupt, SystemExit)
    if not failed and getattr(sys, "last_type", None) is None:
        with contextlib.suppress(PublishError):
            reporter.leave(run[0])
