"""Traffic: what happens on each edge, as the plugin ``traffic`` publishes it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from regatta._contract import EdgeTraffic, TrafficHeader, dtype
from regatta._errors import ReadError
from regatta._open import Open

if TYPE_CHECKING:
    from regatta._fleet import Fleet


@dataclass(frozen=True, eq=False)
class Traffic:
    """The traffic on all edges. Each period is a structured array, a copy, with a row for each edge of the world:
    ``occupancy`` (the mean number of robots), ``entered_per_hour``, ``relative_speed`` (the mean speed over the speed
    limit), ``waiting_secs`` and ``contact_secs`` (added up over robots), ``released`` and ``planned`` (the mean number of
    robots whose released route leads over the edge, and of others whose planned one does; 0 unless ``header.has_routes``)."""

    header: TrafficHeader
    """The run and tick of the newest frame, and the lengths of the periods."""
    minute: npt.NDArray[np.void]
    """The last minute."""
    ten_minutes: npt.NDArray[np.void]
    """The last ten minutes."""
    run: npt.NDArray[np.void]
    """All of the run that the plugin has seen."""
    missed: int
    """The number of samples that were published between the one that this reader returned before and this one."""

    @property
    def run_id(self) -> int:
        """The run that the frame belongs to."""
        return self.header.run_id

    @property
    def tick(self) -> int:
        """The tick of the frame."""
        return self.header.tick


class TrafficReader(Open):
    """Reads the newest traffic on a fleet's edges, which the plugin ``traffic`` publishes once a simulated second."""

    def __init__(self, fleet: Fleet) -> None:
        self._receiver = fleet._node.receiver("traffic", "traffic", EdgeTraffic, TrafficHeader)
        super().__init__(fleet, self._receiver)
        self._dtype = dtype(EdgeTraffic)
        self._newest: Traffic | None = None

    def latest(self) -> Traffic | None:
        """Returns the newest figures, if there are some that this hasn't returned yet. Doesn't wait."""
        sample = self._receiver.latest()
        if sample is None:
            return None
        figures, edges = sample.payload.view(self._dtype).copy(), sample.header.edges
        if len(figures) != 3 * edges:
            raise ReadError(f"traffic of {len(figures)} figures contradicts its header, with {edges} edges")
        minute, ten_minutes, run = (figures[i * edges : (i + 1) * edges] for i in range(3))
        self._newest = Traffic(sample.header, minute, ten_minutes, run, sample.missed)
        return self._newest

    def current(self) -> Traffic | None:
        """Returns the figures that :meth:`latest` returned last."""
        return self._newest
