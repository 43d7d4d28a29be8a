"""The contract: the numbers in its records and columns."""

from enum import IntEnum

from regatta._contract import LAYOUT


class RobotState(IntEnum):
    """The state of a robot: a value of the column ``state``."""

    IDLE = 0
    """The robot has nothing left to drive."""
    DRIVING = 1
    """The robot drives its released base."""
    WAITING = 2
    """The robot stands at the end of its released base and waits for a release of its horizon."""
    HELD = 3
    """The robot was commanded to hold; it stands, or brakes in order to."""
    FAULTED = 4
    """The robot can't continue; an event gave the reason."""
    TURNING = 5
    """The robot stands at a node and turns on the spot, to the heading of its next edge."""
    STALLED = 6
    """The robot has stopped for a while of its own, or brakes in order to; it goes on afterwards."""
    BROKEN = 7
    """The robot is broken: it stands, or brakes in order to, until it is repaired."""
    ABSENT = 255
    """The row holds no robot. Its pose is meaningless."""


class ClockState(IntEnum):
    """The state of the producer's clock."""

    RUNNING = 0
    """Ticks follow the wall clock, times the requested speed."""
    PAUSED = 1
    """No ticks until a resume or a step."""
    STOPPED = 2
    """The last frame of the run."""
    WARMING_UP = 3
    """The warm-up of a run: ticks come as fast as possible, and the run begins at its end."""


class Shape(IntEnum):
    """The footprint of a robot, about its pose."""

    RECTANGLE = 0
    """``length`` along the heading, ``width`` across it."""
    CIRCLE = 1
    """A circle of diameter ``length``."""


class ZoneRule(IntEnum):
    """The rule for the robots in a zone."""

    CAPACITY = 0
    """At most ``capacity`` robots at the same time."""
    SAME_DIRECTION = 1
    """Several robots only if all have entered at the same node."""


class Role(IntEnum):
    """The purpose of a node."""

    NONE = 0
    """Nothing in particular."""
    PICK = 1
    """Pick a load up."""
    DROP = 2
    """Drop a load."""
    PARK = 3
    """Park."""
    CHARGE = 4
    """Charge."""
    TRANSFER = 5
    """Pick a load up, or drop one."""


class CommandKind(IntEnum):
    """Kinds of command records."""

    LEG = 0
    ASSIGN = 1
    EXTEND = 2
    CANCEL = 3
    HOLD = 4
    RESUME = 5
    SPAWN_AT_NODE = 6
    SPAWN_ON_EDGE = 7
    REMOVE = 8
    RELEASE = 9
    BREAK = 10
    REPAIR = 11
    CLOSE_EDGE = 12
    OPEN_EDGE = 13
    REQUEST_DOOR = 14
    RELEASE_DOOR = 15
    CALL_LIFT = 16
    RELEASE_LIFT = 17


class EventKind(IntEnum):
    """Kinds of events."""

    REACHED_NODE = 1
    """The robot reached the node ``id`` of its route."""
    ROUTE_DONE = 2
    """The robot reached the end of its route."""
    WAITING_FOR_RELEASE = 3
    """The robot reached the end of its released base and waits for a release, or it waits before a closed
    edge, a closed door or a lift."""
    HELD = 4
    """The held robot has come to a stop."""
    RESUMED = 5
    """The held robot continues."""
    ACCEPTED = 6
    """The command ``token`` was carried out."""
    REFUSED = 7
    """The command ``token`` was refused and changed nothing; ``detail`` is a :class:`Refusal`."""
    SPAWNED = 8
    """The robot joined the fleet after the first frame."""
    REMOVED = 9
    """The robot left the fleet."""
    FAULTED = 10
    """The robot can't continue (a random walk at a node without a way out, for example)."""
    STALLED = 11
    """The robot stalls: it stops for a while."""
    RECOVERED = 12
    """The robot no longer stalls."""
    BROKEN_DOWN = 13
    """The robot is broken; ``detail`` is a :class:`BreakdownCause`."""
    REPAIRED = 14
    """The robot is no longer broken."""
    EDGE_CLOSED = 15
    """The edge ``id`` is closed: no robot enters it."""
    EDGE_OPENED = 16
    """The edge ``id`` is open again."""
    DOOR_OPENED = 17
    """The door across the edge ``id`` is open."""
    DOOR_CLOSED = 18
    """The door across the edge ``id`` is closed."""
    LIFT_ARRIVED = 19
    """A cabin has come to the level of the node ``id``, and its doors are open."""
    ACTION_FAILED = 20
    """The robot's action at the stop at the node ``id`` (to pick, to drop, to charge) has failed."""


class FacilityKind(IntEnum):
    """Kinds of facilities."""

    DOOR = 0
    """A door."""
    LIFT = 1
    """A lift."""


class DoorState(IntEnum):
    """The state of a door. Robots pass open doors only."""

    CLOSED = 0
    """It is closed."""
    OPENING = 1
    """It is opening."""
    OPEN = 2
    """It is open."""
    CLOSING = 3
    """It is closing."""


class BreakdownCause(IntEnum):
    """The cause of a breakdown."""

    UNKNOWN = 0
    """Not known."""
    FLAT_BATTERY = 1
    """Its battery is flat. It stays broken until it is repaired, which brings a full battery, or has been charged."""


class Refusal(IntEnum):
    """The reason why a command was refused."""

    UNKNOWN_ROBOT = 1
    """No robot has that id."""
    UNKNOWN_EDGE = 2
    """No edge has that id."""
    UNKNOWN_NODE = 3
    """No node has that id."""
    UNKNOWN_ROBOT_TYPE = 4
    """The world has no such robot type."""
    NOT_CONNECTED = 5
    """A leg doesn't start where the leg before it or the base ends, or where the robot is."""
    NO_REVERSE = 6
    """The edge can't be driven in reverse gear."""
    MALFORMED_ROUTE = 7
    """The route has no legs, or a released leg follows one that is not."""
    DISTANCE_OUT_OF_RANGE = 8
    """The distance is not on the edge, or not a number."""
    FLEET_FULL = 9
    """The fleet has reached its maximum size."""
    MALFORMED_COMMAND = 10
    """The record's kind is unknown, or legs are missing."""
    NOT_STEERABLE = 11
    """The producer takes no commands: a replay, a UDP source."""
    NOT_AHEAD = 12
    """The leg to release is not at or after the end of the robot's base."""
    EDGE_CLOSED = 13
    """A leg of the route is along a closed edge."""
    NOT_OWNER = 14
    """Another process owns the movement of the fleet."""
    NO_DOOR = 15
    """No door is across the edge."""
    NO_LIFT = 16
    """The node is in no cabin."""
    LIFT_IN_USE = 17
    """The lift is requested for another robot."""
    NO_CABIN = 18
    """The cabin isn't at the node."""


class OrderKind(IntEnum):
    """Kinds of records of the order log."""

    CREATED = 1
    """The order exists. It has ``detail`` stops; a record for each follows."""
    STOP = 2
    """A stop of the order: ``node``, ``action`` and ``dwell_secs``."""
    ASSIGNED = 3
    """The order was given to ``robot``."""
    WITHDRAWN = 4
    """The manager withdrew the order from its robot before the first pick."""
    ARRIVED = 5
    """The robot stands at a stop. Its dwell begins, unless it waits there for an operator, for a place
    for its load, or until the station opens."""
    HANDLED = 6
    """The dwell is over: the load is picked or dropped, for example."""
    FINISHED = 7
    """All stops were handled."""
    FAILED = 8
    """The fleet manager has given the order up."""
    CANCELLED = 9
    """The order was cancelled on request."""
    UNROUTABLE = 10
    """No robot can reach its stops, or a storage has no place for it: it waits until it is reopened.
    ``detail`` is an :class:`Obstacle`."""
    REOPENED = 11
    """Its stops can be reached again, or it has got its places."""
    QUEUED = 12
    """The robot waits in the queue before a stop: at a place of it, or elsewhere until one is free."""


class Obstacle(IntEnum):
    """The reason for which no robot can carry an order out."""

    NO_WAY = 0
    """The layout has no way there, or none from there to the next stop."""
    CLOSED_EDGES = 1
    """Edges that are closed."""
    NO_ROBOT = 2
    """The fleet doesn't have the only robot that may get it."""
    BATTERY = 3
    """No robot's full battery lasts for it."""
    NO_PLACE = 4
    """Its storage has no place for it."""


class Activity(IntEnum):
    """The activity of a robot: the values of the column ``activity``."""

    IDLE = 0
    """It has nothing to do."""
    FETCHING = 1
    """It drives to the first stop of an order."""
    CARRYING = 2
    """It has begun an order, and drives to its next stop."""
    HANDLING = 3
    """It stands at a stop, and loads or unloads."""
    WAITING = 4
    """It waits for another robot, for a release of its route, or before a closed edge."""
    QUEUED = 5
    """It waits until there is room on the roads, or in the queue before its stop."""
    CHARGING = 6
    """It charges, or drives to a charger."""
    HELD = 7
    """It was commanded to hold."""
    BROKEN = 8
    """It is broken, and stands until it is repaired."""
    FAULTED = 9
    """It can't continue; an event gave the reason."""
    STALLED = 10
    """It has stopped for a while of its own."""
    MOVING = 11
    """It drives, without an order."""
    ROTATING = 12
    """It turns on the spot, without an order."""

    @property
    def word(self) -> str:
        """The word that all programs show."""
        return self.name.lower()

    def colour(self, ground: str = "light") -> str:
        """The colour that all programs show on a ``light`` or a ``dark`` ground, for example ``#98a0a8``."""
        return str(LAYOUT["activities"][self.word][ground])


class StopAction(IntEnum):
    """The action of a robot at a stop of an order."""

    NONE = 0
    """Nothing but to stand there."""
    PICK = 1
    """Pick a load up."""
    DROP = 2
    """Drop the load."""
    CHARGE = 3
    """Charge."""
    PARK = 4
    """Park."""


class ContactLevel(IntEnum):
    """The distance of two robots from a collision: the values of the column ``collision``, where 0 is clear."""

    POSSIBLE = 1
    """They are within the safety margin, or will touch within the horizon if both continue as they do."""
    TOUCHING = 2
    """Their footprints overlap."""


class ContactChange(IntEnum):
    """The change that a contact event reports."""

    BEGAN = 1
    """The pair reached the level."""
    ENDED = 2
    """The pair left the level."""


class ControlKind(IntEnum):
    """Kinds of control requests."""

    STATUS = 0
    PAUSE = 1
    RESUME = 2
    STEP = 3
    SPEED = 4
    ROBOTS = 5
    SEEK = 6


class ManagerRequestKind(IntEnum):
    """Kinds of requests to a fleet manager."""

    SEND = 1
    """Send a robot to a node."""
    RECALL = 2
    """Call a robot back, and manage it as before."""


class ManagerAnswer(IntEnum):
    """Answers of a fleet manager."""

    NOW = 1
    """It does so now."""
    LATER = 2
    """It does so as soon as the robot's order is finished."""
    UNKNOWN_ROBOT = 3
    UNKNOWN_NODE = 4
    NO_WAY = 5
    """No way leads there, for example because edges are closed."""
    NOT_SENT = 6
    """The robot was not sent anywhere."""
    NOT_READY = 7
    """The manager has seen no frame yet."""
    UNKNOWN_KIND = 8


class Trend(IntEnum):
    """The development of a place where robots lose time."""

    GROWING = 1
    """It costs more time than it used to."""

    STEADY = 2
    """It costs about as much as before."""

    EASING = 3
    """It costs less."""

    OVER = 4
    """No robot loses time there any more."""


class MarkKind(IntEnum):
    """Kinds of marks of a recording."""

    CONTACT = 1
    """Two robots began to touch."""

    FAULT = 2
    """A robot can't continue, or is broken."""

    STOP = 3
    """A robot was held and has come to a stop, or stalls."""

    NOTE = 4
    """A note of a user."""
