"""Readers of the newest sample of a service: contacts, traffic, closed edges and figures of work."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, TypeVar

import numpy as np
import numpy.typing as npt

from regatta._contract import (
    ClosedEdge,
    ClosureHeader,
    ContactHeader,
    ContactRecord,
    EdgeTraffic,
    FacilityHeader,
    FacilityState,
    Record,
    RecordingHeader,
    RecordingMark,
    Sequenced,
    TrafficHeader,
    WorkFigures,
    WorkHeader,
    dtype,
)
from regatta._errors import ReadError
from regatta._open import Open
from regatta._ports import Sample

if TYPE_CHECKING:
    from regatta._fleet import Fleet

Header = TypeVar("Header", bound=Sequenced)
FrameBound = TypeVar("FrameBound", ContactHeader, TrafficHeader)
Records = npt.NDArray[np.void]


@dataclass(frozen=True, eq=False)
class OfFrame(Generic[FrameBound]):
    """The content of a sample that belongs to a frame."""

    header: FrameBound
    """The run and tick of the frame, and totals."""

    @property
    def run_id(self) -> int:
        """The run that the frame belongs to."""
        return self.header.run_id

    @property
    def tick(self) -> int:
        """The tick of the frame."""
        return self.header.tick

    @property
    def sim_time(self) -> float:
        """The simulated time of the frame since the start of the run, in seconds."""
        return self.header.sim_time_nanos / 1e9


@dataclass(frozen=True, eq=False)
class Contacts(OfFrame[ContactHeader]):
    """All contacts of one frame."""

    pairs: Records
    """A structured array, a copy: ``robots`` (two ids), ``level`` (a :class:`ContactLevel <regatta.ContactLevel>`),
    ``since_tick``, ``since_nanos`` (simulated), ``edge``, ``x`` and ``y`` in metres, ``relative_speed`` in m/s. The
    pairs that touch come first."""
    missed: int
    """The number of samples that were published between the one that this reader returned before and this one."""


@dataclass(frozen=True, eq=False)
class Traffic(OfFrame[TrafficHeader]):
    """The traffic on all edges. Each period is a structured array, a copy, with a row for each edge of the world:
    ``occupancy`` (the mean number of robots), ``entered_per_hour``, ``relative_speed`` (the mean speed over the speed
    limit), ``waiting_secs`` and ``contact_secs`` (added up over robots), ``released`` and ``planned`` (the mean number of
    robots whose released route leads over the edge, and of others whose planned one does; 0 unless ``header.has_routes``)."""

    minute: Records
    """The last minute."""
    ten_minutes: Records
    """The last ten minutes."""
    run: Records
    """All of the run that the plugin has seen."""
    missed: int
    """The number of samples that were published between the one that this reader returned before and this one."""


class NewestReader(Open, Generic[Header]):
    """Reads the newest sample of a service."""

    def __init__(self, fleet: Fleet, service: str, record: type[Record], header: type[Header]) -> None:
        self._receiver = fleet._node.receiver(service, service, record, header)
        super().__init__(fleet, self._receiver)
        self._dtype = dtype(record)

    def _latest(self) -> tuple[Sample[Header], Records] | None:
        """Returns the newest sample with a copy of its records, if this hasn't returned it yet."""
        sample = self._receiver.latest()
        return None if sample is None else (sample, sample.payload.view(self._dtype).copy())


class ContactReader(NewestReader[ContactHeader]):
    """Reads the newest contacts of a fleet, which a collision checker publishes while it runs."""

    def __init__(self, fleet: Fleet) -> None:
        super().__init__(fleet, "contacts", ContactRecord, ContactHeader)
        self._newest: Contacts | None = None

    def latest(self) -> Contacts | None:
        """Returns the newest contacts, if there are some that this hasn't returned yet. Doesn't wait."""
        latest = self._latest()
        if latest is None:
            return None
        sample, pairs = latest
        self._newest = Contacts(sample.header, pairs, sample.missed)
        return self._newest

    def current(self) -> Contacts | None:
        """Returns the contacts that :meth:`latest` returned last."""
        return self._newest


class TrafficReader(NewestReader[TrafficHeader]):
    """Reads the newest traffic on a fleet's edges, which the plugin ``traffic`` publishes once a simulated second."""

    def __init__(self, fleet: Fleet) -> None:
        super().__init__(fleet, "traffic", EdgeTraffic, TrafficHeader)
        self._newest: Traffic | None = None

    def latest(self) -> Traffic | None:
        """Returns the newest figures, if there are some that this hasn't returned yet. Doesn't wait."""
        latest = self._latest()
        if latest is None:
            return None
        sample, figures = latest
        edges = sample.header.edges
        if len(figures) != 3 * edges:
            raise ReadError(f"traffic of {len(figures)} figures contradicts its header, with {edges} edges")
        minute, ten_minutes, run = (figures[i * edges : (i + 1) * edges] for i in range(3))
        self._newest = Traffic(sample.header, minute, ten_minutes, run, sample.missed)
        return self._newest

    def current(self) -> Traffic | None:
        """Returns the figures that :meth:`latest` returned last."""
        return self._newest


class ClosureReader(NewestReader[ClosureHeader]):
    """Reads the closed edges of a fleet. A reader that is opened later knows them, too::

        closures = fleet.closures()
        closures.latest()
        closed = closures.edges(frame.run_id)
    """

    def __init__(self, fleet: Fleet) -> None:
        super().__init__(fleet, "closures", ClosedEdge, ClosureHeader)
        self._newest: tuple[int, npt.NDArray[np.uint32]] | None = None

    def latest(self) -> bool:
        """Takes the newest change, and returns whether there was one that wasn't taken yet. Doesn't wait."""
        latest = self._latest()
        if latest is not None:
            sample, edges = latest
            self._newest = (sample.header.run_id, edges["edge"])
        return latest is not None

    def edges(self, run_id: int) -> npt.NDArray[np.uint32]:
        """Returns the ids of the edges that are closed in a run, sorted, as of the last :meth:`latest`."""
        if self._newest is None or self._newest[0] != run_id:
            return np.empty(0, np.uint32)
        return self._newest[1]


class FacilityReader(NewestReader[FacilityHeader]):
    """Reads the states of a fleet's doors and lifts. A reader that is opened later knows them, too::

        facilities = fleet.facilities()
        facilities.latest()
        for state in facilities.states(frame.run_id):
            print(regatta.FacilityKind(state["kind"]), state["index"], regatta.DoorState(state["door"]))
    """

    def __init__(self, fleet: Fleet) -> None:
        super().__init__(fleet, "facilities", FacilityState, FacilityHeader)
        self._newest: tuple[int, Records] | None = None

    def latest(self) -> bool:
        """Takes the newest change, and returns whether there was one that wasn't taken yet. Doesn't wait."""
        latest = self._latest()
        if latest is not None:
            sample, states = latest
            self._newest = (sample.header.run_id, states)
        return latest is not None

    def states(self, run_id: int) -> Records:
        """Returns the states of all doors, then of all lifts, in a run, as of the last :meth:`latest`: ``kind`` (a
        :class:`FacilityKind <regatta.FacilityKind>`) and ``index`` among ``world.doors`` or ``world.lifts``; ``door``
        (a :class:`DoorState <regatta.DoorState>`), also of a lift's doors; ``level``, ``next_level`` and
        ``called_level`` of a lift; the ``robot`` for which it is requested, and the number of ``requests``."""
        if self._newest is None or self._newest[0] != run_id:
            return np.empty(0, dtype(FacilityState))
        return self._newest[1]


class WorkReader(NewestReader[WorkHeader]):
    """Reads the figures of a fleet's work, which the fleet manager publishes once in a simulated second: those of the
    run so far, also for a reader that is opened later::

        work = fleet.work()
        if figures := work.latest():
            print(figures.orders_per_hour, figures.service_p50_secs)
    """

    def __init__(self, fleet: Fleet) -> None:
        super().__init__(fleet, "work", WorkFigures, WorkHeader)
        self._newest: WorkFigures | None = None

    def latest(self) -> WorkFigures | None:
        """Returns the newest figures, if there are some that this hasn't returned yet. Doesn't wait."""
        sample = self._receiver.latest()
        if sample is None or sample.payload.nbytes < ctypes.sizeof(WorkFigures):
            return None
        self._newest = WorkFigures.from_buffer_copy(sample.payload.tobytes())
        return self._newest

    def current(self) -> WorkFigures | None:
        """Returns the figures that :meth:`latest` returned last."""
        return self._newest


class RecordingClock(NewestReader[RecordingHeader]):
    """Reads how far the clock of a recording that is replayed is ahead of the simulated time of its runs."""

    def __init__(self, fleet: Fleet) -> None:
        super().__init__(fleet, "recording", RecordingMark, RecordingHeader)
        self._header: RecordingHeader | None = None

    def time_of(self, run_id: int, sim_time_nanos: int) -> float | None:
        """Returns the time of the recording's clock at a simulated time of a run, in seconds; ``None`` as long as the
        replay hasn't told it."""
        if (sample := self._receiver.latest()) is not None:
            self._header = sample.header
        if self._header is None or self._header.run_id != run_id:
            return None
        return ((self._header.ahead_nanos + sim_time_nanos) % (1 << 64)) / 1e9
