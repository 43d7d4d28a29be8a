"""Contacts: which robots touch or are about to, as a collision checker publishes them."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from regatta._contract import ContactHeader, ContactRecord, dtype
from regatta._node import Node


@dataclass(frozen=True, eq=False)
class Contacts:
    """All pairs of one frame."""

    header: ContactHeader
    """The frame, and totals."""
    pairs: npt.NDArray[np.void]
    """A structured array, a copy: ``robots`` (two ids), ``level`` (a :class:`ContactLevel <regatta.ContactLevel>`),
    ``since_tick``, ``since_nanos`` (simulated), ``edge``, ``x`` and ``y`` in metres, ``relative_speed`` in m/s. Those that
    touch come first."""


class ContactReader:
    """Reads a fleet's contacts: always the newest. There are some as long as a collision checker runs."""

    def __init__(self, node: Node) -> None:
        self._receiver = node.receiver("contacts", "contacts", ContactRecord, ContactHeader)
        self._dtype = dtype(ContactRecord)
        self._newest: Contacts | None = None

    def latest(self) -> Contacts | None:
        """The newest contacts, if there are some that this hasn't returned yet. Doesn't wait."""
        sample = self._receiver.latest()
        if sample is None:
            return None
        self._newest = Contacts(sample.header, sample.payload.view(self._dtype).copy())
        return self._newest

    def current(self) -> Contacts | None:
        """The contacts that :meth:`latest` returned last."""
        return self._newest
