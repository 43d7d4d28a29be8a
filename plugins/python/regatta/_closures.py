"""Closed edges: those that no robot may enter now."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from regatta._contract import ClosedEdge, ClosureHeader, dtype
from regatta._open import Open

if TYPE_CHECKING:
    from regatta._fleet import Fleet


class ClosureReader(Open):
    """Reads which edges of a fleet are closed. A reader that is opened later knows them, too::

        closures = fleet.closures()
        closures.latest()
        closed = closures.edges(frame.run_id)
    """

    def __init__(self, fleet: Fleet) -> None:
        self._receiver = fleet._node.receiver("closures", "closures", ClosedEdge, ClosureHeader)
        super().__init__(fleet, self._receiver)
        self._dtype = dtype(ClosedEdge)
        self._newest: tuple[int, npt.NDArray[np.uint32]] | None = None

    def latest(self) -> bool:
        """Takes the newest change, and returns whether there was one that wasn't taken yet. Doesn't wait."""
        sample = self._receiver.latest()
        if sample is None:
            return False
        edges: npt.NDArray[np.uint32] = sample.payload.view(self._dtype)["edge"].copy()
        self._newest = (sample.header.run_id, edges)
        return True

    def edges(self, run_id: int) -> npt.NDArray[np.uint32]:
        """Returns the ids of the edges that are closed in a run, sorted, as of the last :meth:`latest`."""
        if self._newest is None or self._newest[0] != run_id:
            return np.empty(0, np.uint32)
        return self._newest[1]
