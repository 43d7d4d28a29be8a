"""Orders: the instructions of a fleet manager to robots."""

from __future__ import annotations

import itertools
import operator
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, SupportsIndex

import numpy as np

from regatta._contract import LAYOUT, OrderHeader, OrderRecord
from regatta._enums import OrderKind
from regatta._errors import NoEngineError, OrderError
from regatta._ports import Bytes, Sender

if TYPE_CHECKING:
    from regatta._fleet import Fleet


@dataclass(frozen=True)
class Leg:
    """One edge of a route."""

    edge: int
    """The id of the edge in the route graph."""
    reverse: bool = False
    """Whether the robot drives the edge from destination to origin, in reverse gear."""
    released: bool = True
    """Whether the robot may drive the edge now. If not, it is horizon, and so are all legs after it."""


class Orders:
    """Collects orders, then sends them together, so that they take effect in the same tick::

        orders = regatta.orders("default")
        orders.hold(4)
        orders.assign(7, [12, regatta.Leg(13, released=False)])
        orders.send()

    Each order gets a token, which the events that answer it carry. Programs with different names get different tokens.
    """

    def __init__(self, fleet: Fleet) -> None:
        self._fleet = fleet
        self._sender: Sender[OrderHeader] = fleet._node.sender("orders", "orders", OrderRecord, OrderHeader)
        self._records: list[OrderRecord] = []

    def assign(self, robot: SupportsIndex, legs: Iterable[Leg | SupportsIndex]) -> int:
        """Gives a robot a new route, from the end of its edge, or from its node. A plain number is the id of an edge
        that the robot may drive forward now. Returns the order's token."""
        return self._route(OrderKind.ASSIGN, robot, legs)

    def extend(self, robot: SupportsIndex, legs: Iterable[Leg | SupportsIndex]) -> int:
        """Drops a robot's horizon and appends legs to its released base. Returns the order's token."""
        return self._route(OrderKind.EXTEND, robot, legs)

    def cancel(self, robot: SupportsIndex) -> int:
        """Drops a robot's route beyond the edge that it is on. Returns the order's token."""
        return self._push(OrderKind.CANCEL, robot=_number(robot, "robot"))

    def hold(self, robot: SupportsIndex) -> int:
        """Makes a robot brake and stand. It keeps its route. Returns the order's token."""
        return self._push(OrderKind.HOLD, robot=_number(robot, "robot"))

    def resume(self, robot: SupportsIndex) -> int:
        """Ends a hold. Returns the order's token."""
        return self._push(OrderKind.RESUME, robot=_number(robot, "robot"))

    def spawn_at_node(self, robot_type: SupportsIndex, node: SupportsIndex) -> int:
        """Spawns a robot on a node, given by its id, in the node's pose. ``robot_type`` is an index into the world's
        robot types. Returns the order's token; the event ``SPAWNED`` has the robot's id."""
        return self._push(
            OrderKind.SPAWN_AT_NODE, robot_type=_number(robot_type, "robot type"), id=_number(node, "node")
        )

    def spawn_on_edge(self, robot_type: SupportsIndex, edge: SupportsIndex, s: float) -> int:
        """Spawns a robot on an edge, given by its id, ``s`` metres from its origin. Returns the order's token."""
        return self._push(
            OrderKind.SPAWN_ON_EDGE, robot_type=_number(robot_type, "robot type"), id=_number(edge, "edge"), s=s
        )

    def remove(self, robot: SupportsIndex) -> int:
        """Removes a robot from the fleet. Returns the order's token."""
        return self._push(OrderKind.REMOVE, robot=_number(robot, "robot"))

    def __len__(self) -> int:
        """Returns the number of records collected so far: one per order, and one per leg."""
        return len(self._records)

    def clear(self) -> None:
        """Discards the collected orders."""
        self._records.clear()

    def send(self) -> None:
        """Sends the collected orders, for the next tick. Does nothing if there are none.

        Raises :class:`NoEngineError <regatta.NoEngineError>` if the fleet has no engine, and :class:`OrderError
        <regatta.OrderError>` if too many samples of orders wait already. The orders are kept then, and can be sent
        again or cleared.
        """
        if not self._records:
            return
        records = (OrderRecord * len(self._records))(*self._records)

        def fill(memory: Bytes) -> None:
            memory[:] = np.frombuffer(memoryview(records).cast("B"), np.uint8)

        if self._sender.send(OrderHeader(self._fleet._tokens.sender), len(records), fill) == 0:
            if self._sender.receivers() == 0:
                raise NoEngineError(
                    f"fleet '{self._fleet.name}' has no engine to take orders; start one with `regatta run`, or name"
                    " another fleet"
                )
            raise OrderError(
                f"fleet '{self._fleet.name}' has not taken the last {LAYOUT['order_buffer']} samples of orders"
                " (is it paused?); send fewer, or wait"
            )
        self._records.clear()

    def _route(self, kind: OrderKind, robot: SupportsIndex, legs: Iterable[Leg | SupportsIndex]) -> int:
        parsed = [leg if isinstance(leg, Leg) else Leg(_number(leg, "edge")) for leg in legs]
        edges = [_number(leg.edge, "edge") for leg in parsed]
        token = self._push(kind, robot=_number(robot, "robot"), legs=len(parsed))
        for edge, leg in zip(edges, parsed):
            self._records.append(
                OrderRecord(token=token, kind=OrderKind.LEG, id=edge, reverse=leg.reverse, released=leg.released)
            )
        return token

    def _push(self, kind: OrderKind, **fields: float) -> int:
        token = self._fleet._tokens.next()
        self._records.append(OrderRecord(token=token, kind=kind, **fields))
        return token


class Tokens:
    """The tokens of a participant, and its number as a sender."""

    def __init__(self, name: str) -> None:
        self.sender = _fnv1a(name.encode())
        self._count = itertools.count(1)

    def next(self) -> int:
        """Returns the next token."""
        return ((self.sender << 32) + next(self._count)) & (2**64 - 1)


def _number(value: SupportsIndex, what: str) -> int:
    number = operator.index(value)
    if not 0 <= number < 2**32:
        raise ValueError(f"invalid {what} {number}; give a number from 0 to {2**32 - 1}")
    return number


def _fnv1a(text: bytes) -> int:
    """Returns the 64-bit FNV-1a hash of a text: the same name gives the same tokens in every run."""
    value = 0xCBF2_9CE4_8422_2325
    for byte in text:
        value = ((value ^ byte) * 0x0000_0100_0000_01B3) & (2**64 - 1)
    return value
