"""Requests to the fleet manager."""

from __future__ import annotations

from typing import SupportsIndex

from regatta._ask import Asker
from regatta._contract import ManagerRequest, ManagerResponse
from regatta._enums import ManagerAnswer, ManagerRequestKind
from regatta._errors import ControlError
from regatta._node import Node
from regatta._numbers import number

REASONS = {
    ManagerAnswer.UNKNOWN_ROBOT: "there is no robot {robot}",
    ManagerAnswer.UNKNOWN_NODE: "there is no node {node}",
    ManagerAnswer.NO_WAY: "robot {robot} has no way to node {node}",
    ManagerAnswer.NOT_SENT: "robot {robot} was not sent anywhere",
    ManagerAnswer.NOT_READY: "the fleet manager has seen no frame yet",
}


class Manager:
    """Asks a fleet's manager to send robots somewhere."""

    def __init__(self, node: Node) -> None:
        self._asker = Asker(node, "manager", ManagerRequest, ManagerResponse, "fleet manager")

    def close(self) -> None:
        """Frees the place at the service."""
        self._asker.close()

    def send(self, robot: SupportsIndex, node: SupportsIndex) -> ManagerAnswer:
        """Asks to send a robot to a node, by its id."""
        return self._ask(ManagerRequestKind.SEND, number(robot, "robot"), number(node, "node"))

    def recall(self, robot: SupportsIndex) -> ManagerAnswer:
        """Asks to call a robot back."""
        return self._ask(ManagerRequestKind.RECALL, number(robot, "robot"), 0)

    def _ask(self, kind: ManagerRequestKind, robot: int, node: int) -> ManagerAnswer:
        pending = self._asker.send(ManagerRequest(kind=kind, robot=robot, node=node))
        answer = ManagerAnswer(self._asker.wait(pending).answer)
        if answer in (ManagerAnswer.NOW, ManagerAnswer.LATER):
            return answer
        reason = REASONS.get(answer, "the fleet manager doesn't know how")
        raise ControlError(f"refused: {reason.format(robot=robot, node=node)}")
