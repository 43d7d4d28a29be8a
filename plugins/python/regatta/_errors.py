"""Errors: what is wrong, where, and what to do about it, in one line."""


class Error(Exception):
    """Any error of this package."""


class OpenError(Error):
    """A fleet's service can't be opened."""


class VersionError(OpenError):
    """The fleet speaks another version of the contract."""


class TakenError(OpenError):
    """Somebody else already publishes what only one process may publish."""


class FullError(OpenError):
    """All places at a service are taken."""


class ReadError(Error):
    """Something can't be read."""


class HeldError(ReadError):
    """Too many frames, or samples of one column, are still referred to."""


class PublishError(Error):
    """Something can't be published."""


class OrderError(Error):
    """Orders can't be sent. They are kept, to be sent again."""


class ControlError(Error):
    """A request wasn't carried out."""


class RefusedError(ControlError):
    """The engine refused a request, and said why."""


class NoEngineError(OrderError, ControlError):
    """The fleet has no engine to take orders or requests."""
