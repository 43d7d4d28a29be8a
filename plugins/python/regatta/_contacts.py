"""Contacts: pairs of robots that touch or are about to, as a collision checker publishes them."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from regatta._contract import ContactHeader, ContactRecord, dtype
from regatta._node import Node


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


class ContactReader:
    """Reads the newest contacts of a fleet, which a collision checker publishes while it runs."""

    def __init__(self, node: Node) -> None:
        self._receiver = node.receiver("contacts", "contacts", ContactRecord, ContactHeader)
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
