"""Control: pause, resume, step, speed, number of robots, status."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from regatta import _contract
from regatta._ask import TIMEOUT, Asker
from regatta._contract import ControlRequest
from regatta._enums import ClockState, ControlKind
from regatta._errors import RefusedError
from regatta._open import Open

if TYPE_CHECKING:
    from regatta._fleet import Fleet


class RobotsByState(NamedTuple):
    """The numbers of robots by state: ``robots_by_state.held``, or ``robots_by_state[RobotState.HELD]``."""

    idle: int
    driving: int
    waiting: int
    held: int
    faulted: int
    turning: int
    stalled: int
    broken: int


@dataclass(frozen=True, repr=False)
class ControlResponse:
    """The status of an engine after a request."""

    run_id: int
    """The run."""
    tick: int
    """Ticks since its start."""
    sim_time_nanos: int
    """Simulated time since its start, in nanoseconds; :attr:`sim_time` has seconds."""
    late_ticks: int
    """The number of ticks that ended after their deadline."""
    tick_cost_p50_nanos: int
    """The median cost of a tick over the last second or so, in nanoseconds."""
    tick_cost_p99_nanos: int
    """The 99th percentile of the cost of a tick, in nanoseconds."""
    resident_bytes: int
    """The engine's resident memory, in bytes; 0 where it is unknown."""
    wall_time_nanos: int
    """Wall time since the start of the run, in nanoseconds."""
    robots_by_state: RobotsByState
    """The numbers of robots by state."""
    robots: int
    """The number of robots."""
    pid: int
    """The engine's process."""
    clock: ClockState
    """The state of the clock."""
    speed: float
    """The requested speed, in simulated seconds per wall second; ``inf`` for as fast as possible."""
    real_time_factor: float
    """The measured speed over the last second or so."""
    accepted: bool
    """Whether the engine carried the request out. It did, unless an error was raised."""
    reason: str
    """The reason for a refusal, or an empty text."""
    owner: str
    """The process that owns the movement of the robots, such as ``fleet-manager (process 4711)``, or an empty text."""

    @property
    def sim_time(self) -> float:
        """Simulated time since the start of the run, in seconds."""
        return self.sim_time_nanos / 1e9

    def __repr__(self) -> str:
        states = [f"{count} {state}" for state, count in self.robots_by_state._asdict().items() if count]
        return (
            f"<regatta.ControlResponse: tick {self.tick} ({self.sim_time:.2f} s), {self.clock.name.lower()} at"
            f" {self.speed:g} x, {self.robots} robots ({', '.join(states) or 'none'}), {self.late_ticks} late ticks,"
            f" process {self.pid}>"
        )


class Control(Open):
    """Controls a fleet's engine. Every request returns the status after it.

    Requests raise :class:`NoEngineError <regatta.NoEngineError>` if the fleet has no engine, :class:`RefusedError
    <regatta.RefusedError>` with the engine's reason, or :class:`ControlError <regatta.ControlError>` if the engine ends
    or doesn't answer in time.
    """

    def __init__(self, fleet: Fleet) -> None:
        self._asker = Asker(fleet._node, "control", ControlRequest, _contract.ControlResponse)
        super().__init__(fleet, self._asker)

    def has_engine(self) -> bool:
        """Whether the fleet has an engine."""
        return self._asker.has_engine()

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
        response = _readable(self._asker.wait(self._asker.send(request), timeout))
        if not response.accepted:
            raise RefusedError(f"the engine of fleet '{self._fleet.name}' refused the request: {response.reason}")
        return response


def _readable(response: _contract.ControlResponse) -> ControlResponse:
    return ControlResponse(
        run_id=response.run_id,
        tick=response.tick,
        sim_time_nanos=response.sim_time_nanos,
        late_ticks=response.late_ticks,
        tick_cost_p50_nanos=response.tick_cost_p50_nanos,
        tick_cost_p99_nanos=response.tick_cost_p99_nanos,
        resident_bytes=response.resident_bytes,
        wall_time_nanos=response.wall_time_nanos,
        robots_by_state=RobotsByState(*response.robots_by_state),
        robots=response.robots,
        pid=response.pid,
        clock=ClockState(response.clock),
        speed=response.speed,
        real_time_factor=response.real_time_factor,
        accepted=response.accepted != 0,
        reason=response.reason.decode(errors="replace"),
        owner=response.owner.decode(errors="replace"),
    )


def _count(count: int, limit: int) -> int:
    if not 0 <= count < limit:
        raise ValueError(f"{count} is out of range; give a number from 0 to {limit - 1}")
    return count
