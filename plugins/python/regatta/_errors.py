"""Errors. The message says in one line what is wrong, where, and what to do."""


class Error(Exception):
    """The base class of all errors of this package."""


class OpenError(Error):
    """A fleet's service can't be opened."""


class VersionError(OpenError):
    """The fleet uses another version of the contract."""


class TakenError(OpenError):
    """Another process already publishes a service that only one process may publish."""


class FullError(OpenError):
    """All places of a service are taken."""


class ClosedError(Error):
    """The program uses something that it has closed."""


class ReadError(Error):
    """A sample can't be read."""


class HeldError(ReadError):
    """The program still refers to too many frames, or samples of one column."""


class PublishError(Error):
    """A sample can't be published."""


class CommandError(Error):
    """Commands can't be sent. They are kept, and can be sent again."""


class OwnedError(TakenError, CommandError):
    """Another program owns the movement of the fleet, so that this one may not send robots along routes."""


class ControlError(Error):
    """A request wasn't carried out."""


class RefusedError(ControlError):
    """The engine refused a request, for the reason in the message."""


class NoEngineError(CommandError, ControlError):
    """The fleet has no engine that could take commands or requests."""
