"""Requests to a fleet's engine, and its answers."""

from __future__ import annotations

import time
from typing import Any, Generic, TypeVar

from regatta._contract import Record
from regatta._errors import ControlError, NoEngineError, PublishError, ReadError
from regatta._node import Node

Request = TypeVar("Request", bound=Record)
Response = TypeVar("Response", bound=Record)

TIMEOUT = 5.0
"""The longest time, in seconds, to wait for the answer to a request that the engine answers at once."""
POLL = 0.0005
"""The time between two checks for an answer, in seconds."""
CHECK = 1.0
"""The time between two checks whether the engine is still alive, in seconds."""


class Asker(Generic[Request, Response]):
    """The asking end of a service of a fleet's engine, or of its fleet manager."""

    def __init__(
        self,
        node: Node,
        service: str,
        request: type[Request],
        response: type[Response],
        server: str = "engine",
    ) -> None:
        self._fleet = node.fleet
        self._server = server
        self._client = node.client(service, request, response)

    def close(self) -> None:
        """Frees the place at the service."""
        self._client.close()

    def has_engine(self) -> bool:
        """Whether the fleet has an engine. Takes a millisecond or so, because it removes the resources of dead
        processes."""
        self._client.forget_dead()
        return self._client.has_server()

    def send(self, request: Request) -> Any:
        """Sends a request. Returns the pending response, for :meth:`wait`.

        Raises :class:`NoEngineError <regatta.NoEngineError>` if the fleet has no engine, or :class:`ControlError
        <regatta.ControlError>`.
        """
        if not self._client.has_server():
            raise NoEngineError(
                f"fleet '{self._fleet}' has no {self._server}; start one with `regatta run`, or name another fleet"
            )
        try:
            return self._client.ask(request)
        except PublishError as error:
            raise self._unreachable(error) from None

    def wait(self, pending: Any, timeout: float | None = TIMEOUT) -> Response:
        """Waits for the answer to a request, for ``timeout`` seconds or without a limit.

        Raises :class:`ControlError <regatta.ControlError>` if the engine ends, or doesn't answer in time.
        """
        start = time.monotonic()
        next_check = start + CHECK
        while True:
            # Checked before the answer, so that an answer sent just before the end is not missed.
            connected = pending.is_connected
            answer = self._answer(pending)
            if answer is not None:
                return answer
            now = time.monotonic()
            if not connected:
                raise ControlError(f"the {self._server} of fleet '{self._fleet}' ended before it answered")
            if timeout is not None and now - start >= timeout:
                raise ControlError(
                    f"the {self._server} of fleet '{self._fleet}' has not answered within {timeout:.1f} s; is it stopped or"
                    " overloaded?"
                )
            if now >= next_check:
                next_check = now + CHECK
                # An engine that was killed counts as connected until its resources are removed.
                self._client.forget_dead()
            time.sleep(POLL)

    def _answer(self, pending: Any) -> Response | None:
        try:
            return self._client.answer(pending)
        except ReadError as error:
            raise self._unreachable(error) from None

    def _unreachable(self, error: Exception) -> ControlError:
        return ControlError(
            f"can't reach the {self._server} of fleet '{self._fleet}' ({error}); `regatta doctor` reports what is wrong"
        )
