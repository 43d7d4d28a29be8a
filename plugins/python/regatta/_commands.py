"""Commands: the instructions of a fleet manager to robots."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast, overload

import numpy as np
import numpy.typing as npt

from regatta._answers import wait_for
from regatta._contract import LAYOUT, NO_ROBOT, CommandHeader, CommandRecord, dtype
from regatta._enums import CommandKind
from regatta._errors import CommandError, NoEngineError
from regatta._numbers import Number, Numbers, number, numbers
from regatta._open import Open
from regatta._ownership import check_owner
from regatta._ports import Bytes, Sender
from regatta._tokens import TokenArray

if TYPE_CHECKING:
    from regatta._fleet import Fleet

RECORD = dtype(CommandRecord)
MOVEMENT = [CommandKind.ASSIGN, CommandKind.EXTEND, CommandKind.RELEASE, CommandKind.CANCEL]
"""The kinds of commands that only the owner of a fleet's movement may send."""


@dataclass(frozen=True)
class Leg:
    """One edge of a route."""

    edge: int
    """The id of the edge in the route graph."""
    reverse: bool = False
    """Whether the robot drives the edge from destination to origin, in reverse gear."""
    released: bool = True
    """Whether the robot may drive the edge now. If not, it is horizon, and so are all legs after it."""


Floats = Sequence[float] | npt.NDArray[np.floating[Any]]
"""Numbers of metres: a list or an array."""

Bools = Sequence[bool] | npt.NDArray[np.bool_]
"""Truth values: a list or an array."""

Legs = Iterable[Leg | Number]
"""A route. A plain number is the id of an edge that the robot may drive forward now."""


class Commands(Open):
    """Collects commands, then sends them together, so that they take effect in the same tick::

        commands = regatta.commands("default")
        commands.hold(4)
        commands.resume(np.flatnonzero(frame.x > 40.0))
        commands.assign(7, [12, regatta.Leg(13, released=False)])
        commands.release(7, 13, metres=2.5)
        commands.send()

    Nothing is sent before :meth:`send`. Commands that send robots along routes (``assign``, ``extend``, ``release``,
    ``cancel``) raise :class:`OwnedError <regatta.OwnedError>` at once if another program owns the movement of the robots.

    Each command gets a token, which the events that answer it carry. Programs with different names get different tokens.
    For a list or an array of robots, each robot gets a command of its own, and the tokens are an array.
    """

    def __init__(self, fleet: Fleet) -> None:
        self._sender: Sender[CommandHeader] = fleet._node.sender("commands", "commands", CommandRecord, CommandHeader)
        self._records = bytearray()
        super().__init__(fleet, self._sender)

    @overload
    def assign(self, robot: Number, legs: Legs) -> int: ...
    @overload
    def assign(self, robot: Numbers, legs: Iterable[Legs]) -> TokenArray: ...
    def assign(self, robot: Number | Numbers, legs: Legs | Iterable[Legs]) -> int | TokenArray:
        """Gives a robot a new route, from the end of its edge, or from its node. A plain number is the id of an edge
        that the robot may drive forward now. Returns the command's token. Several robots need one route each."""
        return self._route(CommandKind.ASSIGN, robot, legs)

    @overload
    def extend(self, robot: Number, legs: Legs) -> int: ...
    @overload
    def extend(self, robot: Numbers, legs: Iterable[Legs]) -> TokenArray: ...
    def extend(self, robot: Number | Numbers, legs: Legs | Iterable[Legs]) -> int | TokenArray:
        """Drops a robot's horizon and appends legs to its released base. Returns the command's token. Several robots need
        one route each."""
        return self._route(CommandKind.EXTEND, robot, legs)

    @overload
    def release(self, robot: Number, edge: Number, metres: float, reverse: bool = False) -> int: ...
    @overload
    def release(
        self, robot: Numbers, edge: Number | Numbers, metres: float | Floats, reverse: bool | Bools = False
    ) -> TokenArray: ...
    def release(
        self,
        robot: Number | Numbers,
        edge: Number | Numbers,
        metres: float | Floats,
        reverse: bool | Bools = False,
    ) -> int | TokenArray:
        """Releases a robot's horizon up to ``metres`` along a leg, from where the leg is entered; ``math.inf`` for all of
        it. The leg is the first one along this edge, in this gear, at or after the end of the base. Returns the command's
        token. Several robots may have an edge, a distance and a gear each."""
        gears = np.asarray(reverse, np.uint32)
        return self._push(
            CommandKind.RELEASE,
            robot=numbers(robot, "robot"),
            id=numbers(edge, "edge"),
            s=_metres(metres),
            reverse=gears if gears.ndim else int(gears),
        )

    @overload
    def cancel(self, robot: Number) -> int: ...
    @overload
    def cancel(self, robot: Numbers) -> TokenArray: ...
    def cancel(self, robot: Number | Numbers) -> int | TokenArray:
        """Drops a robot's route beyond the edge that it is on. Returns the command's token."""
        return self._push(CommandKind.CANCEL, robot=numbers(robot, "robot"))

    @overload
    def hold(self, robot: Number) -> int: ...
    @overload
    def hold(self, robot: Numbers) -> TokenArray: ...
    def hold(self, robot: Number | Numbers) -> int | TokenArray:
        """Makes a robot brake and stand. It keeps its route. Returns the command's token."""
        return self._push(CommandKind.HOLD, robot=numbers(robot, "robot"))

    @overload
    def resume(self, robot: Number) -> int: ...
    @overload
    def resume(self, robot: Numbers) -> TokenArray: ...
    def resume(self, robot: Number | Numbers) -> int | TokenArray:
        """Ends a hold. Returns the command's token."""
        return self._push(CommandKind.RESUME, robot=numbers(robot, "robot"))

    @overload
    def break_down(self, robot: Number) -> int: ...
    @overload
    def break_down(self, robot: Numbers) -> TokenArray: ...
    def break_down(self, robot: Number | Numbers) -> int | TokenArray:
        """Makes a robot break down: it brakes and stands until it is repaired. Returns the command's token."""
        return self._push(CommandKind.BREAK, robot=numbers(robot, "robot"))

    @overload
    def repair(self, robot: Number) -> int: ...
    @overload
    def repair(self, robot: Numbers) -> TokenArray: ...
    def repair(self, robot: Number | Numbers) -> int | TokenArray:
        """Repairs a robot that is broken. Returns the command's token."""
        return self._push(CommandKind.REPAIR, robot=numbers(robot, "robot"))

    @overload
    def close_edge(self, edge: Number) -> int: ...
    @overload
    def close_edge(self, edge: Numbers) -> TokenArray: ...
    def close_edge(self, edge: Number | Numbers) -> int | TokenArray:
        """Closes an edge, by its id: no robot enters it any more, and robots on it leave it. Returns the command's token."""
        return self._push(CommandKind.CLOSE_EDGE, robot=NO_ROBOT, id=numbers(edge, "edge"))

    @overload
    def open_edge(self, edge: Number) -> int: ...
    @overload
    def open_edge(self, edge: Numbers) -> TokenArray: ...
    def open_edge(self, edge: Number | Numbers) -> int | TokenArray:
        """Opens a closed edge again. Returns the command's token."""
        return self._push(CommandKind.OPEN_EDGE, robot=NO_ROBOT, id=numbers(edge, "edge"))

    def request_door(self, edge: Number, robot: Number = NO_ROBOT) -> int:
        """Opens the doors across an edge, by its id, or keeps them open: for ten simulated seconds, for a robot or an
        operator. Returns the command's token."""
        return self._request(CommandKind.REQUEST_DOOR, edge, robot)

    def release_door(self, edge: Number, robot: Number = NO_ROBOT) -> int:
        """Ends a request of the doors across an edge. Returns the command's token."""
        return self._request(CommandKind.RELEASE_DOOR, edge, robot)

    def call_lift(self, node: Number, robot: Number = NO_ROBOT) -> int:
        """Calls a lift to the level of a node in its cabin, by the node's id, for a robot or an operator. It stays for ten
        simulated seconds at least. Returns the command's token."""
        return self._request(CommandKind.CALL_LIFT, node, robot)

    def release_lift(self, node: Number, robot: Number = NO_ROBOT) -> int:
        """Ends a call of the lift with that node. Returns the command's token."""
        return self._request(CommandKind.RELEASE_LIFT, node, robot)

    def _request(self, kind: CommandKind, identity: Number, robot: Number) -> int:
        token = self._fleet._tokens.next()
        self._records += CommandRecord(token=token, kind=kind, robot=number(robot, "robot"), id=number(identity, "id"))
        return token

    @overload
    def spawn_at_node(self, robot_type: Number, node: Number) -> int: ...
    @overload
    def spawn_at_node(self, robot_type: Number | Numbers, node: Numbers) -> TokenArray: ...
    @overload
    def spawn_at_node(self, robot_type: Numbers, node: Number) -> TokenArray: ...
    def spawn_at_node(self, robot_type: Number | Numbers, node: Number | Numbers) -> int | TokenArray:
        """Spawns a robot on a node, given by its id, in the node's pose. ``robot_type`` is an index into the world's
        robot types. Returns the command's token; the event ``SPAWNED`` has the robot's id. An array of nodes spawns a
        robot on each."""
        return self._push(
            CommandKind.SPAWN_AT_NODE, robot_type=numbers(robot_type, "robot type"), id=numbers(node, "node")
        )

    @overload
    def spawn_on_edge(self, robot_type: Number, edge: Number, s: float) -> int: ...
    @overload
    def spawn_on_edge(self, robot_type: Number | Numbers, edge: Numbers, s: float | Floats) -> TokenArray: ...
    @overload
    def spawn_on_edge(self, robot_type: Number | Numbers, edge: Number, s: Floats) -> TokenArray: ...
    def spawn_on_edge(
        self, robot_type: Number | Numbers, edge: Number | Numbers, s: float | Floats
    ) -> int | TokenArray:
        """Spawns a robot on an edge, given by its id, ``s`` metres from its origin. Returns the command's token. Arrays
        spawn a robot for each of their elements."""
        return self._push(
            CommandKind.SPAWN_ON_EDGE,
            robot_type=numbers(robot_type, "robot type"),
            id=numbers(edge, "edge"),
            s=_metres(s),
        )

    @overload
    def remove(self, robot: Number) -> int: ...
    @overload
    def remove(self, robot: Numbers) -> TokenArray: ...
    def remove(self, robot: Number | Numbers) -> int | TokenArray:
        """Removes a robot from the fleet. Returns the command's token."""
        return self._push(CommandKind.REMOVE, robot=numbers(robot, "robot"))

    def __repr__(self) -> str:
        return f"<regatta.Commands: {len(self)} records for fleet '{self._fleet.name}'>"

    def __len__(self) -> int:
        """Returns the number of records collected so far: one per command, and one per leg."""
        return len(self._records) // RECORD.itemsize

    def clear(self) -> None:
        """Discards the collected commands."""
        self._records.clear()

    def send(self, timeout: float | None = None) -> None:
        """Sends the collected commands, for the next tick. Does nothing if there are none.

        With a ``timeout`` in seconds, it also waits for the answers of the engine, and raises :class:`RefusedError
        <regatta.RefusedError>` with the reasons if it refuses commands (:class:`OwnedError <regatta.OwnedError>` if another
        program has become the owner of the movement), or :class:`ControlError <regatta.ControlError>` if answers are missing
        by then (not in lockstep: there the answers come with the next frame).

        Raises :class:`NoEngineError <regatta.NoEngineError>` if the fleet has no engine, and :class:`CommandError
        <regatta.CommandError>` if too many samples of commands wait already. Raises :class:`OwnedError
        <regatta.OwnedError>` if routes are among them, and another program owns the movement of the robots. The commands
        are kept then, and can be sent again or cleared.
        """
        if not self._records:
            return
        if timeout is None:
            return self._send()
        kinds, tokens = (np.frombuffer(self._records, RECORD)[field] for field in ("kind", "token"))
        waited = {int(token) for token in tokens[kinds != CommandKind.LEG]}
        del kinds, tokens  # views of the records, which could not be cleared
        with self._fleet.events() as events:
            self._send()
            wait_for(events, waited, timeout)

    def _send(self) -> None:
        if np.isin(np.frombuffer(self._records, RECORD)["kind"], MOVEMENT).any():
            check_owner(self._fleet)
        self._put()

    def _put(self) -> None:
        def fill(memory: Bytes) -> None:
            memory[:] = np.frombuffer(self._records, np.uint8)

        if self._sender.send(CommandHeader(self._fleet._tokens.sender), len(self), fill) == 0:
            if self._sender.receivers() == 0:
                raise NoEngineError(
                    f"fleet '{self._fleet.name}' has no engine to take commands; start one with `regatta run`, or name"
                    " another fleet"
                )
            raise CommandError(
                f"fleet '{self._fleet.name}' has not taken the last {LAYOUT['command_buffer']} samples of commands"
                " (is it paused?); send fewer, or wait"
            )
        self._records.clear()

    def _route(self, kind: CommandKind, robot: Number | Numbers, legs: Legs | Iterable[Legs]) -> int | TokenArray:
        robots, given = numbers(robot, "robot"), cast(Any, legs)
        check_owner(self._fleet)
        if isinstance(robots, int):
            return self._push_route(kind, robots, _parsed(given))
        routes = [_parsed(route) for route in given]
        if len(routes) != len(robots):
            raise ValueError(f"{len(routes)} routes for {len(robots)} robots; give one route per robot")
        tokens = [self._push_route(kind, robot, route) for robot, route in zip(robots.tolist(), routes)]
        return np.array(tokens, np.uint64)

    def _push_route(self, kind: CommandKind, robot: int, legs: list[Leg]) -> int:
        token = self._fleet._tokens.next()
        self._records += CommandRecord(token=token, kind=kind, robot=robot, legs=len(legs))
        for leg in legs:
            self._records += CommandRecord(
                token=token, kind=CommandKind.LEG, id=leg.edge, reverse=leg.reverse, released=leg.released
            )
        return token

    def _push(self, kind: CommandKind, **fields: float | npt.NDArray[Any]) -> int | TokenArray:
        if kind in MOVEMENT:
            check_owner(self._fleet)
        shapes = [values.shape for values in fields.values() if isinstance(values, np.ndarray)]
        if not shapes:
            token = self._fleet._tokens.next()
            self._records += CommandRecord(token=token, kind=kind, **fields)
            return token
        if len(set(shapes)) != 1:
            lengths = " and ".join(str(len(values)) for values in fields.values() if isinstance(values, np.ndarray))
            raise ValueError(f"lists of {lengths} elements don't fit together; give lists of one length")
        records = np.zeros(shapes[0], RECORD)
        tokens = records["token"] = self._fleet._tokens.take(len(records))
        records["kind"] = kind
        for name, values in fields.items():
            records[name] = values
        self._records += records.tobytes()
        return tokens


def _metres(values: float | Floats) -> float | npt.NDArray[np.float32]:
    array = np.asarray(values, np.float32)
    return array if array.ndim else float(array)


def _parsed(legs: Legs) -> list[Leg]:
    """Returns a route with the ids of its edges as plain numbers."""
    parsed = []
    for leg in legs:
        leg = leg if isinstance(leg, Leg) else Leg(cast(int, leg))
        parsed.append(Leg(number(leg.edge, "edge"), leg.reverse, leg.released))
    return parsed
