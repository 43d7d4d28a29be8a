"""Control: pause, resume, step, speed, number of robots, status."""

import time

from regatta._contract import ControlRequest, ControlResponse
from regatta._enums import ControlKind
from regatta._errors import ControlError, NoEngineError, PublishError, ReadError, RefusedError
from regatta._node import Node
from regatta._ports import Client

TIMEOUT = 5.0
"""The longest time, in seconds, to wait for the answer to a request that the engine answers at once."""
POLL = 0.0005
"""The time between two checks for an answer, in seconds."""
CHECK = 1.0
"""The time between two checks whether the engine is still alive, in seconds."""


class Control:
    """Controls a fleet's engine. Every request returns the status after it.

    Requests raise :class:`NoEngineError <regatta.NoEngineError>` if the fleet has no engine, :class:`RefusedError
    <regatta.RefusedError>` with the engine's reason, or :class:`ControlError <regatta.ControlError>` if the engine ends
    or doesn't answer in time.
    """

    def __init__(self, node: Node) -> None:
        self._client: Client[ControlRequest, ControlResponse] = node.client("control", ControlRequest, ControlResponse)
        self._fleet = node.fleet

    def has_engine(self) -> bool:
        """Whether the fleet has an engine."""
        self._client.forget_dead()
        return self._client.has_server()

    def status(self) -> ControlResponse:
        """Returns the status."""
        return self._request(ControlRequest(0, ControlKind.STATUS))

    def pause(self) -> ControlResponse:
        """Stops the clock."""
        return self._request(ControlRequest(0, ControlKind.PAUSE))

    def resume(self) -> ControlResponse:
        """Starts the clock again."""
        return self._request(ControlRequest(0, ControlKind.RESUME))

    def step(self, ticks: int = 1) -> ControlResponse:
        """Pauses the run and advances it by ``ticks``, at the requested speed. Returns when they are done, however long
        that takes."""
        return self._request(ControlRequest(_count(ticks, 2**64), ControlKind.STEP), timeout=None)

    def speed(self, factor: float) -> ControlResponse:
        """Changes the requested speed, in simulated seconds per wall second; ``math.inf`` for as fast as possible."""
        return self._request(ControlRequest(0, ControlKind.SPEED, factor))

    def robots(self, count: int) -> ControlResponse:
        """Changes the number of robots."""
        return self._request(ControlRequest(_count(count, 2**32), ControlKind.ROBOTS))

    def seek(self, seconds: float) -> ControlResponse:
        """Goes to a simulated time. Only replays can."""
        return self._request(ControlRequest(_count(round(seconds * 1e9), 2**64), ControlKind.SEEK))

    def _request(self, request: ControlRequest, timeout: float | None = TIMEOUT) -> ControlResponse:
        if not self._client.has_server():
            raise NoEngineError(
                f"fleet '{self._fleet}' has no engine; start one with `regatta run`, or name another fleet"
            )
        try:
            answer = self._answer(request, timeout)
        except (PublishError, ReadError) as error:
            raise ControlError(
                f"can't reach the engine of fleet '{self._fleet}' ({error}); `regatta doctor` reports what is wrong"
            ) from None
        if not answer.accepted:
            reason = answer.reason.decode(errors="replace")
            raise RefusedError(f"the engine of fleet '{self._fleet}' refused the request: {reason}")
        return answer

    def _answer(self, request: ControlRequest, timeout: float | None) -> ControlResponse:
        pending = self._client.ask(request)
        start = time.monotonic()
        next_check = start + CHECK
        while True:
            # Checked before the answer, so that an answer sent just before the end is not missed.
            connected = pending.is_connected
            answer = self._client.answer(pending)
            if answer is not None:
                return answer
            now = time.monotonic()
            if not connected:
                raise ControlError(f"the engine of fleet '{self._fleet}' ended before it answered")
            if timeout is not None and now - start >= timeout:
                raise ControlError(
                    f"the engine of fleet '{self._fleet}' has not answered within {timeout:.1f} s; is it stopped or"
                    " overloaded?"
                )
            if now >= next_check:
                next_check = now + CHECK
                # An engine that was killed counts as connected until its resources are removed.
                self._client.forget_dead()
            time.sleep(POLL)


def _count(count: int, limit: int) -> int:
    if not 0 <= count < limit:
        raise ValueError(f"{count} is out of range; give a number from 0 to {limit - 1}")
    return count
