"""A program's place in a fleet: what everything else is opened on."""

import re
import sys
import time
from pathlib import Path

from regatta._columns import ColumnPublisher, ColumnReader
from regatta._contacts import ContactReader
from regatta._contract import (
    ContactEvent,
    ContactEventHeader,
    EventHeader,
    EventRecord,
    FrameHeader,
    Line,
    OrderLogHeader,
    OrderRecord,
    WorldHeader,
)
from regatta._control import Control
from regatta._errors import NoEngineError, ReadError
from regatta._events import TickReader
from regatta._frame import ColumnValues
from regatta._frames import Frames
from regatta._node import Node
from regatta._orders import Orders, Tokens
from regatta._world import World, world_of

MAX_NAME_BYTES = 64
"""Longest name of a fleet, a column or a program, in bytes."""
WORLD_WAIT = 0.5
"""Seconds to wait for the world that a frame names: who joins just now can have its first frame some moments before."""


class Fleet:
    """A program's place in a fleet, whether or not that has an engine yet. Everything else is opened on it.

    It and all that is opened on it are to be used from one thread. Not to be carried across ``os.fork``: with
    ``multiprocessing``, use the start method ``spawn`` and open what each process needs there.
    """

    def __init__(self, name: str, participant: str | None = None) -> None:
        self.name = checked_name(name)
        """The fleet's name."""
        self.participant = _cut(participant or _program())
        """The name that this program goes by, in lockstep and in ``regatta doctor``."""
        self._node = Node(self.name, self.participant)
        self._tokens = Tokens(self.participant)
        self._columns: dict[str, ColumnReader] = {}
        self._worlds = self._node.receiver("world", "the world", Line, WorldHeader)
        self._world: World | None = None

    def frames(self, rate: float | None = None) -> Frames:
        """Reads the frames: every one, or so many a second."""
        return Frames(self, rate)

    def world(self, timeout: float | None = None) -> World:
        """The route graph and the robot types. Waits for an engine that isn't there yet: after ``timeout`` seconds without
        one it raises :class:`NoEngineError <regatta.NoEngineError>`. (``frame.world`` is the one of a frame.)"""
        start = time.monotonic()
        while True:
            world = self._newest_world()
            if world is not None:
                return world
            if timeout is not None and time.monotonic() - start >= timeout:
                raise NoEngineError(f"fleet '{self.name}' has no engine; start one with `regatta run`, or name another")
            time.sleep(0.005)

    def column(self, name: str) -> ColumnPublisher:
        """Opens a column for writing. Raises :class:`TakenError <regatta.TakenError>` if somebody else publishes it.
        (``frame.column`` reads one.)"""
        return ColumnPublisher(self._node, checked_name(name))

    def orders(self) -> Orders:
        """Opens the orders, for sending."""
        return Orders(self)

    def control(self) -> Control:
        """Opens the control service, for sending requests."""
        return Control(self._node)

    def events(self) -> TickReader[EventHeader]:
        """Reads what happens to robots. Records have ``kind`` (an :class:`EventKind <regatta.EventKind>`), ``robot``,
        ``token`` (of the order that they answer, else 0), ``id`` and ``detail``; the header counts those ``dropped``."""
        return TickReader(self._node, "events", "events", EventRecord, EventHeader)

    def order_log(self) -> TickReader[OrderLogHeader]:
        """Reads the orders that the engine takes, whoever sent them."""
        return TickReader(self._node, "order_log", "orders taken", OrderRecord, OrderLogHeader)

    def contacts(self) -> ContactReader:
        """Reads which robots touch or are about to, while a collision checker runs."""
        return ContactReader(self._node)

    def contact_events(self) -> TickReader[ContactEventHeader]:
        """Reads which contacts begin and end. Records have ``robots``, ``level`` (a :class:`ContactLevel
        <regatta.ContactLevel>`), ``change`` (a :class:`ContactChange <regatta.ContactChange>`), ``edge``, ``x``, ``y``
        and ``relative_speed``."""
        return TickReader(self._node, "contact_events", "contact events", ContactEvent, ContactEventHeader)

    def _column_values(self, name: str) -> ColumnValues | None:
        if name not in self._columns:
            reader = self._columns[name] = ColumnReader(self._node, checked_name(name))
            return reader.first()
        return self._columns[name].newest()

    def _newest_world(self) -> World | None:
        sample = self._worlds.latest()
        if sample is not None:
            self._world = world_of(sample)
        return self._world

    def _world_of(self, header: FrameHeader) -> World:
        start = time.monotonic()
        while True:
            world = self._newest_world()
            if world is not None and world.run_id == header.run_id and world.revision >= header.world_revision:
                return world
            if time.monotonic() - start >= WORLD_WAIT:
                raise ReadError(f"fleet '{self.name}': the world of tick {header.tick} has not come; its producer is at fault")
            time.sleep(0.001)


def _program() -> str:
    return Path(sys.argv[0]).stem if sys.argv and sys.argv[0] not in ("", "-", "-c") else "python"


def _cut(name: str) -> str:
    return name.encode()[:MAX_NAME_BYTES].decode(errors="ignore")


def checked_name(name: str) -> str:
    """The name of a fleet or a column, if it is one."""
    if not re.fullmatch(rf"[a-zA-Z0-9._-]{{1,{MAX_NAME_BYTES}}}", name, re.ASCII):
        raise ValueError(
            f"{name!r} is no name; give it 1 to {MAX_NAME_BYTES} letters (a-z, A-Z), digits, '-', '_' or '.'"
        )
    return name
