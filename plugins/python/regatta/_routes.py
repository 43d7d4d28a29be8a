"""Routes: the legs that robots are going to drive."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, SupportsIndex

import numpy as np
import numpy.typing as npt

from regatta._ask import Asker
from regatta._contract import LAYOUT, RouteRequest, RouteResponse
from regatta._node import Node
from regatta._numbers import number

OPEN_REQUESTS: int = LAYOUT["services"]["RequestResponse"]["routes"]["max_active_requests_per_client"]
"""The largest number of unanswered requests of one client."""
REVERSE = np.uint32(1 << 31)
"""The bit of a listed leg that marks reverse gear."""


@dataclass(frozen=True, eq=False)
class Route:
    """The legs that a robot has still to drive, as they were between two ticks.

    The first leg is the one that the robot is on, unless it stands at its end or on a node. A robot without a route has
    no legs. For a loop, one lap is listed; for a random walk, the leg that the robot is on.
    """

    run_id: int
    """The run. Edges are those of its world."""
    tick: int
    """Ticks since its start."""
    robot: int
    """The robot."""
    legs: int
    """The number of legs."""
    released: int
    """The number of released legs, which come first: the robot may drive them now. The others are horizon."""
    released_metres: float
    """The metres of the last released leg that are released, from where it is entered; infinity for all of it."""
    edges: npt.NDArray[np.uint32]
    """The edges of the legs in driving order, as indices into the world's edges: all, or the first 256."""
    reverse: npt.NDArray[np.bool_]
    """Whether each of these edges is driven from destination to origin, in reverse gear."""


class Routes:
    """Asks a fleet's engine for the routes of robots."""

    def __init__(self, node: Node) -> None:
        self._asker = Asker(node, "routes", RouteRequest, RouteResponse)

    def close(self) -> None:
        """Frees the place at the service."""
        self._asker.close()

    def ask(self, robots: Iterable[SupportsIndex]) -> list[Route | None]:
        """Returns the routes of robots, in their order; ``None`` for a robot that doesn't exist."""
        requests = deque([RouteRequest(robot=number(robot, "robot")) for robot in robots])
        pending: deque[Any] = deque()
        routes = []
        while pending or requests:
            while requests and len(pending) < OPEN_REQUESTS:
                pending.append(self._asker.send(requests.popleft()))
            routes.append(_route(self._asker.wait(pending.popleft())))
        return routes


def _route(response: RouteResponse) -> Route | None:
    if not response.found:
        return None
    listed = np.array(response.listed, np.uint32)[: response.legs]
    return Route(
        run_id=response.run_id,
        tick=response.tick,
        robot=response.robot,
        legs=response.legs,
        released=response.released,
        released_metres=response.released_metres,
        edges=listed & ~REVERSE,
        reverse=(listed & REVERSE) != 0,
    )
