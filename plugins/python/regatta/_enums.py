"""The contract: the numbers that stand in its records and columns."""

from enum import IntEnum


class RobotState(IntEnum):
    """What a robot is doing: the column ``state``."""

    IDLE = 0
    """Has nothing left to drive."""
    DRIVING = 1
    """Drives its released base."""
    WAITING = 2
    """Stands at the end of its released base and waits for a release of its horizon."""
    HELD = 3
    """Was told to hold and stands, or brakes in order to."""
    FAULTED = 4
    """Can't go on; an event said why."""
    ABSENT = 255
    """This row holds no robot. Its pose means nothing."""


class ClockState(IntEnum):
    """What the producer's clock is doing."""

    RUNNING = 0
    PAUSED = 1
    STOPPED = 2


class Shape(IntEnum):
    """The footprint of a robot, about its pose."""

    RECTANGLE = 0
    """``length`` along the heading, ``width`` across it."""
    CIRCLE = 1
    """A circle of diameter ``length``."""


class OrderKind(IntEnum):
    """Kinds of :class:`OrderRecord`."""

    LEG = 0
    ASSIGN = 1
    EXTEND = 2
    CANCEL = 3
    HOLD = 4
    RESUME = 5
    SPAWN_AT_NODE = 6
    SPAWN_ON_EDGE = 7
    REMOVE = 8


class EventKind(IntEnum):
    """What happened to a robot."""

    REACHED_NODE = 1
    """It came to the node ``id`` of its route."""
    ROUTE_DONE = 2
    """It came to the end of its route."""
    WAITING_FOR_RELEASE = 3
    """It came to the end of its released base and waits for more."""
    HELD = 4
    """It was told to hold and has come to a stand."""
    RESUMED = 5
    """It was held and goes on."""
    ACCEPTED = 6
    """The order ``token`` was carried out."""
    REFUSED = 7
    """The order ``token`` was refused and changed nothing; ``detail`` is a :class:`Refusal`."""
    SPAWNED = 8
    """It joined the fleet."""
    REMOVED = 9
    """It left the fleet."""
    FAULTED = 10
    """It can't go on."""


class Refusal(IntEnum):
    """Why an order was refused."""

    UNKNOWN_ROBOT = 1
    UNKNOWN_EDGE = 2
    UNKNOWN_NODE = 3
    UNKNOWN_ROBOT_TYPE = 4
    NOT_CONNECTED = 5
    """A leg doesn't start where the one before it, the base, or the robot ends."""
    NO_REVERSE = 6
    """The edge can't be driven in reverse gear."""
    MALFORMED_ROUTE = 7
    """The route has no legs, or a released leg follows one that is not."""
    DISTANCE_OUT_OF_RANGE = 8
    """The distance is not on the edge."""
    FLEET_FULL = 9
    """The fleet is as large as it may get."""
    MALFORMED_ORDER = 10
    """The record's kind is unknown, or legs are missing."""


class ContactLevel(IntEnum):
    """How near two robots are to a collision: the values of the column ``collision``, where 0 is clear."""

    POSSIBLE = 1
    """Within the safety margin, or they will touch soon if both go on as they do."""
    TOUCHING = 2
    """Their footprints overlap."""


class ContactChange(IntEnum):
    """What a :class:`ContactEvent` tells."""

    BEGAN = 1
    ENDED = 2


class ControlKind(IntEnum):
    """Kinds of :class:`ControlRequest`."""

    STATUS = 0
    PAUSE = 1
    RESUME = 2
    STEP = 3
    SPEED = 4
    ROBOTS = 5
    SEEK = 6
