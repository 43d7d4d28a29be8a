"""A fleet, as a program has joined it: everything else is opened on it.

This module imports the modules of the classes that are opened on a fleet. Those modules import this one, too, but for
type annotations only (``TYPE_CHECKING``): objects of these classes refer to their fleet, which is passed to them. At
run time there is no import circle.
"""

import os
import re
import sys
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any, SupportsIndex
from weakref import WeakSet

from regatta._columns import ColumnPublisher, ColumnReader
from regatta._commands import Commands
from regatta._contract import (
    CommandLogHeader,
    CommandRecord,
    ContactEvent,
    ContactEventHeader,
    EventHeader,
    EventRecord,
    FrameHeader,
    Line,
    OrderHeader,
    OrderRecord,
    WorldHeader,
)
from regatta._control import Control
from regatta._enums import ManagerAnswer
from regatta._errors import NoEngineError, ReadError
from regatta._events import TickReader
from regatta._frame import ColumnValues
from regatta._frames import Frames
from regatta._manager import Manager
from regatta._newest import ClosureReader, ContactReader, FacilityReader, TrafficReader, WorkReader
from regatta._node import Node
from regatta._open import Closes, Open
from regatta._ownership import Ownership
from regatta._routes import Route, Routes
from regatta._tokens import Tokens
from regatta._world import World, world_of

MAX_NAME_BYTES = 64
"""The longest name of a fleet, a column or a program, in bytes."""
WORLD_WAIT = 0.5
"""The longest time, in seconds, to wait for the world that a frame refers to: a program that has just joined can get
its first frame some moments before the world."""
NAME_WAIT = 5.0
"""The longest time, in seconds, to wait for the world that has the names of nodes."""
NAME_VARIABLE = "REGATTA_PLUGIN_NAME"
"""The environment variable with the name that a program goes by unless it chooses one. ``regatta run`` sets it to the
name in the scenario."""


class Fleet(Closes):
    """A fleet, as a program has joined it, whether or not it has an engine yet. Everything else is opened on it.

    A fleet, and everything that is opened on it, belongs to one thread and one process. It doesn't work after
    ``os.fork``: with ``multiprocessing``, use the start method ``spawn`` and join the fleet in each process.

    Everything that is open can be closed, and ``with`` does so at its end; closing the fleet closes all of it::

        with regatta.join("default") as fleet:
            commands = fleet.commands()
            ...
    """

    def __init__(self, name: str, participant: str | None = None) -> None:
        self.name = checked_name(name)
        """The fleet's name."""
        self.participant = _cut(participant or os.environ.get(NAME_VARIABLE) or _program())
        """The name that this program goes by, in lockstep and in ``regatta doctor``."""
        self._node = Node(self.name, self.participant)
        self._tokens = Tokens(self.participant)
        self._closed = False
        self._open: WeakSet[Open] = WeakSet()
        self._columns: dict[str, ColumnReader] = {}
        self._routes: Routes | None = None
        self._manager: Manager | None = None
        self._ownership: Ownership | None = None
        self._owner = self._node.holder("owner")
        self._publishers: WeakSet[ColumnPublisher] = WeakSet()
        self._readers: WeakSet[TickReader[Any]] = WeakSet()
        self._worlds = self._node.receiver("world", "the world", Line, WorldHeader)
        self._world: World | None = None

    @property
    def closed(self) -> bool:
        """Whether it was closed."""
        return self._closed

    def __repr__(self) -> str:
        state = ", closed" if self._closed else ""
        return f"<regatta.Fleet: '{self.name}', joined as '{self.participant}'{state}>"

    def close(self) -> None:
        """Closes everything that is open on the fleet, and leaves the fleet. Frames that the program still refers to
        stay readable. Closing it again does nothing."""
        if not self._closed:
            self._keep_world()
        self._closed = True
        for opened in list(self._open):
            opened.close()
        for port in (self._worlds, self._owner, self._routes, self._manager, *self._columns.values()):
            if port is not None:
                port.close()
        self._node.close()

    def frames(self, rate: float | None = None, after: Iterable[str] = ()) -> Frames:
        """Opens the frames: all of them, or ``rate`` per second.

        In lockstep, the loop gets each tick after the programs named in ``after`` have finished it, so that their
        columns of that tick are there. The names in the environment variable ``REGATTA_PLUGIN_AFTER`` (separated by
        commas) are added.
        """
        return Frames(self, rate, after)

    def world(self, timeout: float | None = None) -> World:
        """Returns the route graph and the robot types. Waits for an engine that isn't there yet, and raises
        :class:`NoEngineError <regatta.NoEngineError>` after ``timeout`` seconds. (``frame.world`` is the world of a
        frame.)"""
        start = time.monotonic()
        while True:
            world = self._newest_world()
            if world is not None:
                return world
            if timeout is not None and time.monotonic() - start >= timeout:
                raise NoEngineError(
                    f"fleet '{self.name}' has no engine; start one with `regatta run`, or name another fleet"
                )
            time.sleep(0.005)

    def column(self, name: str) -> ColumnPublisher:
        """Opens a column for writing. Raises :class:`TakenError <regatta.TakenError>` if another process publishes it.
        (``frame.column`` reads one.)"""
        return ColumnPublisher(self, checked_name(name))

    def columns(self) -> list[str]:
        """Returns the names of the columns that processes publish now, sorted; ``frame.column`` reads them. Takes some
        milliseconds."""
        return self._node.columns()

    def route(self, robot: SupportsIndex) -> Route | None:
        """Returns the legs that a robot has still to drive; ``None`` if there is no such robot.

        Raises :class:`NoEngineError <regatta.NoEngineError>` if no process serves routes (a replay doesn't), or
        :class:`ControlError <regatta.ControlError>` if the engine ends or doesn't answer in time.
        """
        return self.routes([robot])[0]

    def routes(self, robots: Iterable[SupportsIndex]) -> list[Route | None]:
        """Returns the routes of many robots, in their order. That is faster than one by one, because several requests
        are answered in each tick. Raises the same errors as :meth:`route`."""
        self._routes = self._routes or Routes(self._node)
        return self._routes.ask(robots)

    def send(self, robot: SupportsIndex, node: SupportsIndex | str) -> ManagerAnswer:
        """Asks the fleet manager to send a robot to a node, by its id or its name (that of a station, too). Returns :attr:`ManagerAnswer.NOW
        <regatta.ManagerAnswer.NOW>`, or ``LATER`` if the robot finishes its order first.

        Raises :class:`NoEngineError <regatta.NoEngineError>` if the fleet has no manager that takes requests,
        ``ValueError`` for a name that no node has, or several have, or :class:`ControlError <regatta.ControlError>` if
        the manager refuses, ends or doesn't answer in time.
        """
        if isinstance(node, str):
            node = self.world(NAME_WAIT).node(node)
        self._manager = self._manager or Manager(self._node)
        return self._manager.send(robot, node)

    def recall(self, robot: SupportsIndex) -> ManagerAnswer:
        """Asks the fleet manager to call a robot back. Raises the same errors as :meth:`send`."""
        self._manager = self._manager or Manager(self._node)
        return self._manager.recall(robot)

    def commands(self) -> Commands:
        """Opens the commands for sending."""
        return Commands(self)

    def own(self) -> Ownership:
        """Claims the movement of the robots: from now on the engine refuses to assign, extend, release and cancel routes
        for other programs. It ends when it is closed, with the fleet or with the program, however that ends.

        Raises :class:`OwnedError <regatta.OwnedError>` if another program owns it: a fleet has one owner.
        """
        if self._ownership is None or self._ownership.closed:
            self._ownership = Ownership(self)
        return self._ownership

    def control(self) -> Control:
        """Opens the control service."""
        return Control(self)

    def events(self) -> TickReader[EventHeader]:
        """Opens the events of robots. Records have ``kind`` (an :class:`EventKind <regatta.EventKind>`), ``robot``,
        ``token`` (of the command that the event answers, else 0), ``id`` and ``detail``. ``header.dropped`` counts the
        events of the tick that were left out because there were too many."""
        return TickReader(self, "events", "events", EventRecord, EventHeader)

    def command_log(self) -> TickReader[CommandLogHeader]:
        """Opens the command log: the commands that the engine applied, of all senders."""
        return TickReader(self, "command_log", "the command log", CommandRecord, CommandLogHeader)

    def orders(self) -> TickReader[OrderHeader]:
        """Opens the order log, which a fleet manager writes: the progress of transport orders. Records have ``order``, ``kind``
        (a :class:`OrderKind <regatta.OrderKind>`), ``robot`` (``NO_ROBOT`` for none), ``stop``, ``node``, ``action`` (a
        :class:`StopAction <regatta.StopAction>`), ``dwell_secs`` and ``detail``."""
        return TickReader(self, "orders", "the order log", OrderRecord, OrderHeader)

    def contacts(self) -> ContactReader:
        """Opens the contacts: pairs of robots that touch or are about to, which a collision checker publishes."""
        return ContactReader(self)

    def traffic(self) -> TrafficReader:
        """Opens the traffic on edges, which the plugin ``traffic`` publishes while it runs."""
        return TrafficReader(self)

    def closures(self) -> ClosureReader:
        """Opens the closed edges, which no robot may enter."""
        return ClosureReader(self)

    def facilities(self) -> FacilityReader:
        """Opens the states of doors and lifts. ``world.doors`` and ``world.lifts`` describe them."""
        return FacilityReader(self)

    def work(self) -> WorkReader:
        """Opens the figures of the fleet's work, which the fleet manager publishes while it runs."""
        return WorkReader(self)

    def contact_events(self) -> TickReader[ContactEventHeader]:
        """Opens the contacts that begin and end. Records have ``robots``, ``level`` (a :class:`ContactLevel
        <regatta.ContactLevel>`), ``change`` (a :class:`ContactChange <regatta.ContactChange>`), ``edge``, ``x``, ``y``
        and ``relative_speed``."""
        return TickReader(self, "contact_events", "contact events", ContactEvent, ContactEventHeader)

    def _update_columns(self) -> None:
        """Gives the newest values of the columns of this program to readers that have joined since."""
        for publisher in self._publishers:
            publisher.update()

    def _receive_records(self) -> None:
        """Moves the records that have arrived for this program's readers of ticks to the readers' queues."""
        for reader in self._readers:
            reader._receive()

    def _column_values(self, name: str) -> ColumnValues | None:
        if name not in self._columns:
            reader = self._columns[name] = ColumnReader(self._node, checked_name(name))
            self._update_columns()  # the program may publish it itself
            return reader.first()
        return self._columns[name].newest()

    def _published_columns(self, header: FrameHeader, names: Iterable[str]) -> dict[str, ColumnValues]:
        """Returns the newest values of those columns that processes have published in a frame's run."""
        columns = dict[str, ColumnValues]()
        for name in names if not self._closed else ():
            values = self._column_values(name)
            if values is not None and values.run_id == header.run_id:
                columns[name] = values
        return columns

    def _keep_world(self) -> None:
        """Takes the newest world, for the frames that outlive this fleet."""
        try:
            self._newest_world()
        except ReadError:
            pass  # whoever needs it learns that it is missing

    def _newest_world(self) -> World | None:
        sample = self._worlds.latest()
        if sample is not None:
            self._world = world_of(sample)
        return self._world

    def _known_world(self, header: FrameHeader) -> World | None:
        """Returns a frame's world if it has arrived."""
        world = self._world if self._closed else self._newest_world()
        if world is not None and world.run_id == header.run_id and world.revision >= header.world_revision:
            return world
        return None

    def _world_of(self, header: FrameHeader) -> World:
        start = time.monotonic()
        while True:
            world = self._known_world(header)
            if world is not None:
                return world
            if time.monotonic() - start >= WORLD_WAIT:
                raise ReadError(
                    f"fleet '{self.name}': the world of tick {header.tick} has not arrived; its producer is at fault"
                )
            time.sleep(0.001)


def _program() -> str:
    return Path(sys.argv[0]).stem if sys.argv and sys.argv[0] not in ("", "-", "-c") else "python"


def _cut(name: str) -> str:
    return name.encode()[:MAX_NAME_BYTES].decode(errors="ignore")


def checked_name(name: str) -> str:
    """Returns the name of a fleet or a column, or raises ``ValueError`` if it is invalid."""
    if not re.fullmatch(rf"[a-zA-Z0-9._-]{{1,{MAX_NAME_BYTES}}}", name, re.ASCII):
        raise ValueError(
            f"invalid name {name!r}; give it 1 to {MAX_NAME_BYTES} letters (a-z, A-Z), digits, '-', '_' or '.'"
        )
    return name
