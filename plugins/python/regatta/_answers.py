"""Answers of the engine to commands: acceptances and refusals, with their reasons in words."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

from regatta._enums import EventKind, Refusal
from regatta._errors import ControlError, OwnedError, RefusedError
from regatta._ownership import owned

if TYPE_CHECKING:
    from regatta._events import TickReader

REASONS = {
    Refusal.UNKNOWN_ROBOT: "there is no robot {id}",
    Refusal.UNKNOWN_EDGE: "there is no edge {id}",
    Refusal.UNKNOWN_NODE: "there is no node {id}",
    Refusal.UNKNOWN_ROBOT_TYPE: "there is no robot type {id}",
    Refusal.NOT_CONNECTED: "edge {id} doesn't start where the route before it, or the robot's edge, ends",
    Refusal.NO_REVERSE: "edge {id} can't be driven in reverse gear",
    Refusal.MALFORMED_ROUTE: "the route has no edges",
    Refusal.DISTANCE_OUT_OF_RANGE: "the distance is not on edge {id}",
    Refusal.FLEET_FULL: "the fleet has reached its maximum size",
    Refusal.MALFORMED_COMMAND: "the command is malformed",
    Refusal.NOT_STEERABLE: "this producer takes no commands; an engine does",
    Refusal.NOT_AHEAD: "edge {id} is not ahead in the robot's plan, or is released already",
    Refusal.EDGE_CLOSED: "edge {id} is closed",
    Refusal.NOT_OWNER: "another process moves the robots of this fleet",
    Refusal.NO_DOOR: "no door is across edge {id}",
    Refusal.NO_LIFT: "node {id} is in no lift",
    Refusal.LIFT_IN_USE: "the lift of node {id} is in use by another robot; try again later",
    Refusal.NO_CABIN: "the cabin of the lift isn't at {id}",
}
"""The words of ``regatta command`` for each reason."""

POLL_SECS = 0.002
"""The time between two looks for answers, in seconds."""


def wait_for(events: TickReader[Any], tokens: set[int], timeout: float) -> None:
    """Waits until each command has an answer. Raises :class:`RefusedError <regatta.RefusedError>` if some are refused,
    :class:`OwnedError <regatta.OwnedError>` if some are because another program owns the movement of the robots, and
    :class:`ControlError <regatta.ControlError>` if answers are missing after ``timeout`` seconds."""
    reasons: list[str] = []
    is_owned = False
    waiting, deadline = set(tokens), time.monotonic() + timeout
    while waiting:
        for tick in events.take():
            for event in tick.records:
                if int(event["token"]) not in waiting or event["kind"] not in (EventKind.ACCEPTED, EventKind.REFUSED):
                    continue
                waiting.discard(int(event["token"]))
                if event["kind"] == EventKind.REFUSED:
                    is_owned |= event["detail"] == Refusal.NOT_OWNER
                    reasons.append(reason(int(event["detail"]), int(event["id"])))
        if waiting and time.monotonic() >= deadline:
            raise ControlError(f"{len(waiting)} commands have no answer after {timeout:g} s; is the engine paused?")
        if waiting:
            time.sleep(POLL_SECS)
    if reasons:
        different = "; ".join(dict.fromkeys(reasons))
        if is_owned:
            different = different.replace(REASONS[Refusal.NOT_OWNER], str(owned(events._fleet)))
        count = "" if len(tokens) == 1 else f"{len(reasons)} of {len(tokens)} commands "
        error = OwnedError if is_owned else RefusedError
        raise error(f"{count}refused: {different}")


def reason(detail: int, identity: int) -> str:
    """Returns the reason of a refusal in words."""
    known = [refusal for refusal in Refusal if refusal == detail]
    return REASONS[known[0]].format(id=identity) if known else f"reason {detail}"
