"""Ports and readers that a program has open on a fleet, and their end."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from regatta._errors import ClosedError

if TYPE_CHECKING:
    from regatta._fleet import Fleet

Self = TypeVar("Self", bound="Closes")


class Port(Protocol):
    """One end of a service, or several."""

    def close(self) -> None:
        """Frees the port's place at its service."""


class ClosedPort:
    """Takes the place of a port that was closed. iceoryx2 would end the process if a port were used after its end."""

    __slots__ = ("_what",)

    def __init__(self, what: str) -> None:
        self._what = what

    def __getattr__(self, _: str) -> Any:
        raise ClosedError(f"{self._what} is closed in this program; open it again to use it")


class Closes:
    """Something that can be closed, at the latest at the end of a ``with``."""

    def close(self) -> None:
        """Closes it. Closing it again does nothing."""
        raise NotImplementedError

    def __enter__(self: Self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class Open(Closes):
    """Something that is open on a fleet. It keeps its fleet, and is closed together with it.

    It is also closed when the program no longer refers to it. Every later use raises :class:`ClosedError
    <regatta.ClosedError>`; a loop over it ends.
    """

    def __init__(self, fleet: Fleet, *ports: Port) -> None:
        self._fleet = fleet
        self._ports = ports
        self._closed = False
        fleet._open.add(self)

    def __repr__(self) -> str:
        state = ", closed" if self._closed else ""
        return f"<regatta.{type(self).__name__}: fleet '{self._fleet.name}'{state}>"

    @property
    def closed(self) -> bool:
        """Whether it was closed."""
        return self._closed

    def close(self) -> None:
        """Closes it, which frees its place at the fleet, once no array refers to shared memory that it has read.
        Closing it again does nothing."""
        self._closed = True
        for port in self._ports:
            port.close()
