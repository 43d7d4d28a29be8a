"""Orders: what a fleet manager asks of robots."""

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
    """Its id in the route graph."""
    reverse: bool = False
    """Drive it from destination to origin, in reverse gear."""
    released: bool = True
    """The robot may drive it now; if not, it is horizon, and so are all legs after it."""


class Orders:
    """Sends orders: collects them, then sends them together, so that they take effect in the same tick::

        orders = regatta.orders("default")
        orders.hold(4)
        orders.assign(7, [12, regatta.Leg(13, released=False)])
        orders.send()

    Each order gets a token, which the events that answer it carry. Tokens of programs of different names differ.
    """

    def __init__(self, fleet: Fleet) -> None:
        self._fleet = fleet
        self._sender: Sender[OrderHeader] = fleet._node.sender("orders", "orders", OrderRecord, OrderHeader)
        self._records: list[OrderRecord] = []

    def assign(self, robot: SupportsIndex, legs: Iterable[Leg | SupportsIndex]) -> int:
        """Gives a robot a new route, from where its edge ends, or its node. A plain number is the id of an edge to drive
        forward, now. Returns the order's token."""
        return self._route(OrderKind.ASSIGN, robot, legs)

    def extend(self, robot: SupportsIndex, legs: Iterable[Leg | SupportsIndex]) -> int:
        """Drops a robot's horizon and appends legs to its released base. Returns the order's token."""
        return self._route(OrderKind.EXTEND, robot, legs)

    def cancel(self, robot: SupportsIndex) -> int:
        """Drops a robot's route beyond the edge that it is on. Returns the order's token."""
        return self._push(OrderKind.CANCEL, robot=_number(robot, "robot"))

    def hold(self, robot: SupportsIndex) -> int:
        """Has a robot brake and stand, keeping its route. Returns the order's token."""
        return self._push(OrderKind.HOLD, robot=_number(robot, "robot"))

    def resume(self, robot: SupportsIndex) -> int:
        """Ends a hold. Returns the order's token."""
        return self._push(OrderKind.RESUME, robot=_number(robot, "robot"))

    def spawn_at_node(self, robot_type: SupportsIndex, node: SupportsIndex) -> int:
        """Puts a new robot on a node, by the node's id, in the node's pose. ``robot_type`` is an index into the world's
        robot types. Returns the order's token; the event ``SPAWNED`` has the robot's id."""
        return self._push(
            OrderKind.SPAWN_AT_NODE, robot_type=_number(robot_type, "robot type"), id=_number(node, "node")
        )

    def spawn_on_edge(self, robot_type: SupportsIndex, edge: SupportsIndex, s: float) -> int:
        """Puts a new robot on an edge, by the edge's id, ``s`` metres from its origin. Returns the order's token."""
        return self._push(
            OrderKind.SPAWN_ON_EDGE, robot_type=_number(robot_type, "robot type"), id=_number(edge, "edge"), s=s
        )

    def remove(self, robot: SupportsIndex) -> int:
        """Takes a robot out of the fleet. Returns the order's token."""
        return self._push(OrderKind.REMOVE, robot=_number(robot, "robot"))

    def __len__(self) -> int:
        """Records collected so far: one an order, and one a leg."""
        return len(self._records)

    def clear(self) -> None:
        """Forgets what was collected."""
        self._records.clear()

    def send(self) -> None:
        """Sends what was collected, for the next tick. Does nothing if that is nothing.

        Raises :class:`NoEngineError <regatta.NoEngineError>` if nobody takes orders and :class:`OrderError
        <regatta.OrderError>` if too many wait already; the orders are kept, to be sent again or cleared.
        """
        if not self._records:
            return
        records = (OrderRecord * len(self._records))(*self._records)

        def fill(memory: Bytes) -> None:
            memory[:] = np.frombuffer(memoryview(records).cast("B"), np.uint8)

        if self._sender.send(OrderHeader(self._fleet._tokens.sender), len(records), fill) == 0:
            if self._sender.receivers() == 0:
                raise NoEngineError(
                    f"fleet '{self._fleet.name}' has no engine to take orders; start one, or name another fleet"
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
    """The tokens of one participant, and its number as a sender."""

    def __init__(self, name: str) -> None:
        self.sender = _fnv1a(name.encode())
        self._count = itertools.count(1)

    def next(self) -> int:
        """The next token."""
        return ((self.sender << 32) + next(self._count)) & (2**64 - 1)


def _number(value: SupportsIndex, what: str) -> int:
    number = operator.index(value)
    if not 0 <= number < 2**32:
        raise ValueError(f"{number} is no {what}; give a number from 0 to {2**32 - 1}")
    return number


def _fnv1a(text: bytes) -> int:
    """FNV-1a, 64 bits: the same name gives the same tokens in every run."""
    value = 0xCBF2_9CE4_8422_2325
    for byte in text:
        value = ((value ^ byte) * 0x0000_0100_0000_01B3) & (2**64 - 1)
    return value
