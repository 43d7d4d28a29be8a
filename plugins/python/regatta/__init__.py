"""Watch and steer Regatta's fleets of mobile robots from Python, with numpy views of shared memory.

::

    import regatta

    for frame in regatta.frames("default"):
        print(f"tick {frame.tick}: centre ({frame.x.mean():.2f}, {frame.y.mean():.2f}) m")

A program joins a fleet once, as a :class:`Fleet`, and opens readers, publishers and clients on it. The functions of
this module do both, given the fleet's name; :func:`join` joins under a name of your choice.

Units are SI: metres, radians (counter-clockwise from east, in (-π, π]), seconds; x is east and y north.
"""

import argparse
from collections.abc import Iterable
from typing import SupportsIndex
from weakref import WeakValueDictionary

from regatta._columns import ColumnPublisher
from regatta._commands import Commands, Leg
from regatta._contract import (
    CONTRACT_VERSION,
    NO_EDGE,
    NO_ROBOT,
    CommandLogHeader,
    ContactEventHeader,
    ContactHeader,
    EventHeader,
    FrameHeader,
    OrderHeader,
    TrafficHeader,
    WorkFigures,
)
from regatta._control import Control, ControlResponse, RobotsByState
from regatta._enums import (
    Activity,
    BreakdownCause,
    ClockState,
    CommandKind,
    ContactChange,
    ContactLevel,
    DoorState,
    EventKind,
    FacilityKind,
    ManagerAnswer,
    Obstacle,
    OrderKind,
    Refusal,
    RobotState,
    Role,
    Shape,
    StopAction,
    ZoneRule,
)
from regatta._errors import (
    ClosedError,
    CommandError,
    ControlError,
    Error,
    FullError,
    HeldError,
    NoEngineError,
    OpenError,
    OwnedError,
    PublishError,
    ReadError,
    RefusedError,
    TakenError,
    VersionError,
)
from regatta._events import TickReader, TickRecords
from regatta._fleet import Fleet, checked_name
from regatta._frame import ColumnValues, Frame
from regatta._frames import Frames
from regatta._newest import (
    ClosureReader,
    ContactReader,
    Contacts,
    FacilityReader,
    Traffic,
    TrafficReader,
    WorkReader,
)
from regatta._ownership import Ownership
from regatta._rate import checked_rate
from regatta._read import Recording, read
from regatta._routes import Route
from regatta._run import Run, RunError, RunResult, run
from regatta._study import Study, StudyError, study
from regatta._world import BackgroundLine, Door, Lift, LiftLevel, Orientation, Station, World, Zone

__version__ = "0.1.0"
"""The version of this package, and of the program of the same wheel."""

_joined: WeakValueDictionary[str, Fleet] = WeakValueDictionary()


def join(fleet: str = "default", name: str | None = None) -> Fleet:
    """Joins a fleet. The program goes by ``name`` there; without one, by the name that the environment variable
    ``REGATTA_PLUGIN_NAME`` gives (``regatta run`` sets it), or else by the name of its file."""
    return Fleet(fleet, name)


def frames(fleet: str = "default", rate: float | None = None, after: Iterable[str] = ()) -> Frames:
    """Opens a fleet's frames: all of them, or ``rate`` per second; see :meth:`Fleet.frames` and :class:`Frames`."""
    return _shared(fleet).frames(rate, after)


def world(fleet: str = "default", timeout: float | None = None) -> World:
    """Returns a fleet's route graph and robot types; see :meth:`Fleet.world`."""
    return _shared(fleet).world(timeout)


def column(fleet: str, name: str) -> ColumnPublisher:
    """Opens a column of a fleet for writing; see :class:`ColumnPublisher`."""
    return _shared(fleet).column(name)


def columns(fleet: str = "default") -> list[str]:
    """Returns the names of the columns that a fleet's processes publish now; see :meth:`Fleet.columns`."""
    return _shared(fleet).columns()


def route(fleet: str, robot: SupportsIndex) -> Route | None:
    """Returns the legs that a robot has still to drive; see :meth:`Fleet.route`."""
    return _shared(fleet).route(robot)


def routes(fleet: str, robots: Iterable[SupportsIndex]) -> list[Route | None]:
    """Returns the routes of many robots; see :meth:`Fleet.routes`."""
    return _shared(fleet).routes(robots)


def commands(fleet: str = "default") -> Commands:
    """Opens the commands of a fleet for sending; see :class:`Commands`."""
    return _shared(fleet).commands()


def control(fleet: str = "default") -> Control:
    """Opens the control service of a fleet's engine; see :class:`Control`."""
    return _shared(fleet).control()


def events(fleet: str = "default") -> TickReader[EventHeader]:
    """Opens the events of a fleet's robots; see :meth:`Fleet.events`."""
    return _shared(fleet).events()


def contacts(fleet: str = "default") -> ContactReader:
    """Opens the contacts of a fleet's robots; see :meth:`Fleet.contacts`."""
    return _shared(fleet).contacts()


def parser(description: str | None = None) -> argparse.ArgumentParser:
    """Returns the command-line parser that every plugin has, to which you can add options of your own.

    Its options are ``fleet``, ``rate``, ``name`` and ``after``. A scenario starts a plugin with ``--fleet``::

        options = regatta.parser(__doc__).parse_args()
        fleet = regatta.join(options.fleet, options.name)
        for frame in fleet.frames(options.rate, options.after):
            ...
    """
    options = argparse.ArgumentParser(
        description=description, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False
    )
    fleet = options.add_argument("--fleet", metavar="NAME", default="default", type=_fleet)
    fleet.help = "the fleet to read [default: %(default)s]"
    options.add_argument("--rate", metavar="N", type=_rate, help="frames per second to read, or 'all' [default: all]")
    name = options.add_argument("--name", metavar="NAME")
    name.help = "the name to go by, in lockstep and in `regatta doctor` [default: the program's name]"
    after = options.add_argument("--after", metavar="NAME", action="append", default=[])
    after.help = "in lockstep, handle each tick after this plugin has; may be repeated"
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
    """Returns the fleet, joined once for all functions of this module."""
    fleet = _joined.get(name)
    if fleet is None or fleet.closed:
        fleet = _joined[name] = Fleet(name)
    return fleet


__all__ = [
    "CONTRACT_VERSION",
    "NO_EDGE",
    "NO_ROBOT",
    "Activity",
    "BackgroundLine",
    "BreakdownCause",
    "ClockState",
    "ClosedError",
    "ClosureReader",
    "ColumnPublisher",
    "ColumnValues",
    "CommandError",
    "CommandKind",
    "CommandLogHeader",
    "Commands",
    "ContactChange",
    "ContactEventHeader",
    "ContactHeader",
    "ContactLevel",
    "ContactReader",
    "Contacts",
    "Control",
    "ControlError",
    "ControlResponse",
    "Door",
    "DoorState",
    "Error",
    "EventHeader",
    "EventKind",
    "FacilityKind",
    "FacilityReader",
    "Fleet",
    "Frame",
    "FrameHeader",
    "Frames",
    "FullError",
    "HeldError",
    "Leg",
    "Lift",
    "LiftLevel",
    "ManagerAnswer",
    "NoEngineError",
    "Obstacle",
    "OpenError",
    "OrderHeader",
    "OrderKind",
    "Orientation",
    "OwnedError",
    "Ownership",
    "PublishError",
    "ReadError",
    "Recording",
    "Refusal",
    "RefusedError",
    "RobotState",
    "RobotsByState",
    "Role",
    "Route",
    "Run",
    "RunError",
    "RunResult",
    "Shape",
    "Station",
    "StopAction",
    "Study",
    "StudyError",
    "TakenError",
    "TickReader",
    "TickRecords",
    "Traffic",
    "TrafficHeader",
    "TrafficReader",
    "VersionError",
    "WorkFigures",
    "WorkReader",
    "World",
    "Zone",
    "ZoneRule",
    "column",
    "columns",
    "commands",
    "contacts",
    "control",
    "events",
    "frames",
    "join",
    "parser",
    "read",
    "route",
    "routes",
    "run",
    "study",
    "world",
]
