"""Contacts: pairs of robots that touch or are about to, as a collision checker publishes them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from regatta._contract import ContactHeader, ContactRecord, dtype
from regatta._open import Open

if TYPE_CHECKING:
    from regatta._fleet import Fleet


@dataclass(frozen=True, eq=False)
class Contacts:
    """All contacts of one frame."""

    header: ContactHeader
    """The run and tick of the frame, and totals."""
    pairs: npt.NDArray[np.void]
    """A structured array, a copy: ``robots`` (two ids), ``level`` (a :class:`ContactLevel <regatta.ContactLevel>`),
    ``since_tick``, ``since_nanos`` (simulated), ``edge``, ``x`` and ``y`` in metres, ``relative_speed`` in m/s. The
    pairs that touch come first."""
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

    @property
    def sim_time(self) -> float:
        """The simulated time of the frame since the start of the run, in seconds."""
        return self.header.sim_time_nanos / 1e9


class ContactReader(Open):
    """Reads the newest contacts of a fleet, which a collision checker publishes while it runs."""

    def __init__(self, fleet: Fleet) -> None:
        self._receiver = fleet._node.receiver("contacts", "contacts", ContactRecord, ContactHeader)
        super().__init__(fleet, self._receiver)
        self._dtype = dtype(ContactRecord)
        self._newest: Contacts | None = None

    def latest(self) -> Contacts | None:
        """Returns the newest contacts, if there are some that this hasn't returned yet. Doesn't wait."""
        sample = self._receiver.latest()
        if sample is None:
            return None
        self._newest = Contacts(sample.header, sample.payload.view(self._dtype).copy(), sample.missed)
        return self._newest

    def current(self) -> Contacts | None:
        """Returns the contacts that :meth:`latest` returned last."""
        return self._newest
