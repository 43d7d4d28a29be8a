"""Watch and steer Regatta's fleets of mobile robots from Python: numpy views of shared memory, without a copy.

::

    import regatta

    for frame in regatta.frames("default"):
        print(f"tick {frame.tick}: centre ({frame.x.mean():.2f}, {frame.y.mean():.2f}) m")

A program has one place in a fleet, a :class:`Fleet`, and opens on it what it needs. The functions of this module do so by
the fleet's name; :func:`join` does so under a name of your choice.

Units are SI: metres, radians (counter-clockwise from east, in (-π, π]), seconds; x is east and y north.
"""

import argparse
from weakref import WeakValueDictionary

from regatta._columns import ColumnPublisher
from regatta._contacts import ContactReader, Contacts
from regatta._contract import (
    CONTRACT_VERSION,
    NO_EDGE,
    ContactEventHeader,
    ContactHeader,
    ControlResponse,
    EventHeader,
    FrameHeader,
    OrderLogHeader,
)
from regatta._control import Control
from regatta._enums import (
    ClockState,
    ContactChange,
    ContactLevel,
    EventKind,
    OrderKind,
    Refusal,
    RobotState,
    Shape,
)
from regatta._errors import (
    ControlError,
    Error,
    FullError,
    HeldError,
    NoEngineError,
    OpenError,
    OrderError,
    PublishError,
    ReadError,
    RefusedError,
    TakenError,
    VersionError,
)
from regatta._events import TickReader, TickRecords
from regatta._fleet import Fleet, checked_name
from regatta._frame import ColumnValues, Frame
from regatta._frames import Frames, checked_rate
from regatta._orders import Leg, Orders
from regatta._world import World

_joined: WeakValueDictionary[str, Fleet] = WeakValueDictionary()


def join(fleet: str = "default", name: str | None = None) -> Fleet:
    """Joins a fleet under a name of its own: that of the program, unless ``name`` is given."""
    return Fleet(fleet, name)


def frames(fleet: str = "default", rate: float | None = None) -> Frames:
    """Reads a fleet's frames: every one, or so many a second. Loop over it; see :class:`Frames`."""
    return _shared(fleet).frames(rate)


def world(fleet: str = "default", timeout: float | None = None) -> World:
    """A fleet's route graph and robot types; see :meth:`Fleet.world`."""
    return _shared(fleet).world(timeout)


def column(fleet: str, name: str) -> ColumnPublisher:
    """Opens a column of a fleet for writing; see :class:`ColumnPublisher`."""
    return _shared(fleet).column(name)


def orders(fleet: str = "default") -> Orders:
    """Sends orders to a fleet's robots; see :class:`Orders`."""
    return _shared(fleet).orders()


def control(fleet: str = "default") -> Control:
    """Pauses, steps and otherwise controls a fleet's engine; see :class:`Control`."""
    return _shared(fleet).control()


def events(fleet: str = "default") -> TickReader[EventHeader]:
    """Reads what happens to a fleet's robots; see :meth:`Fleet.events`."""
    return _shared(fleet).events()


def contacts(fleet: str = "default") -> ContactReader:
    """Reads which of a fleet's robots touch or are about to; see :meth:`Fleet.contacts`."""
    return _shared(fleet).contacts()


def parser(description: str | None = None) -> argparse.ArgumentParser:
    """The command line that every plugin has: ``--fleet``, ``--rate`` and ``--name``. A scenario starts a plugin with
    ``--fleet``. Add options of your own to it."""
    options = argparse.ArgumentParser(
        description=description, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False
    )
    fleet = options.add_argument("--fleet", metavar="NAME", default="default", type=_fleet)
    fleet.help = "the fleet to read [default: %(default)s]"
    options.add_argument("--rate", metavar="N", type=_rate, help="frames a second to look at, or 'all' [default: all]")
    options.add_argument("--name", metavar="NAME", help="the name to go by [default: the program's]")
    return options


def _rate(text: str) -> float | None:
    try:
        return None if text == "all" else checked_rate(float(text))
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def _fleet(text: str) -> str:
    try:
        return checked_name(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def _shared(name: str) -> Fleet:
    """The program's place in a fleet, which all that this module's functions open share."""
    fleet = _joined.get(name)
    if fleet is None:
        fleet = _joined[name] = Fleet(name)
    return fleet


__all__ = [
    "CONTRACT_VERSION",
    "NO_EDGE",
    "ClockState",
    "ColumnPublisher",
    "ColumnValues",
    "ContactChange",
    "ContactEventHeader",
    "ContactHeader",
    "ContactLevel",
    "ContactReader",
    "Contacts",
    "Control",
    "ControlError",
    "ControlResponse",
    "Error",
    "EventHeader",
    "EventKind",
    "Fleet",
    "Frame",
    "FrameHeader",
    "Frames",
    "FullError",
    "HeldError",
    "Leg",
    "NoEngineError",
    "OpenError",
    "OrderError",
    "OrderKind",
    "OrderLogHeader",
    "Orders",
    "PublishError",
    "ReadError",
    "Refusal",
    "RefusedError",
    "RobotState",
    "Shape",
    "TakenError",
    "TickReader",
    "TickRecords",
    "VersionError",
    "World",
    "column",
    "contacts",
    "control",
    "events",
    "frames",
    "join",
    "orders",
    "parser",
    "world",
]
