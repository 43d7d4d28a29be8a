"""The ownership of movement: while a program owns it, no other one may send robots along routes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from regatta._errors import ControlError, OwnedError, TakenError
from regatta._open import Open

if TYPE_CHECKING:
    from regatta._fleet import Fleet


class Ownership(Open):
    """The movement of a fleet's robots, which this program owns: the engine refuses routes from others.

    It ends when it is closed, together with its fleet, or with the program.
    """

    def __init__(self, fleet: Fleet) -> None:
        try:
            claim = fleet._node.claim("owner")
        except TakenError:
            raise owned(fleet) from None
        super().__init__(fleet, claim)


def check_owner(fleet: Fleet) -> None:
    """Raises :class:`OwnedError <regatta.OwnedError>` if another program owns the movement of the fleet."""
    own = fleet._ownership
    if (own is None or own.closed) and fleet._owner.is_held():
        raise owned(fleet)


def owned(fleet: Fleet) -> OwnedError:
    """Returns the error for a fleet whose movement another program owns."""
    return OwnedError(
        f"{_owner(fleet)} moves the robots of fleet '{fleet.name}'; stop it first, or ask it to send a robot with"
        " fleet.send()"
    )


def _owner(fleet: Fleet) -> str:
    """Returns the name of the owner, with its process."""
    members = fleet._owner.members()
    if len(members) == 1:
        return members[0]
    # The engine knows which of them it is. In lockstep it doesn't answer while a program has its turn.
    with fleet.control() as control:
        try:
            owner = control.status().owner
        except ControlError:
            owner = ""
    return owner or " or ".join(members) or "another process"
