"""Ctrl-C and SIGTERM, as a flag."""

import signal
import threading
from types import FrameType
from typing import Any, ClassVar

_SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]


class Termination:
    """A context manager in which the first Ctrl-C (or SIGTERM, or SIGHUP) only sets a flag. A second Ctrl-C raises
    ``KeyboardInterrupt`` as usual.

    Signals that have a handler of the program keep it. Threads other than the main one, in which Python can't install
    handlers, leave all signals as they are.
    """

    _entered: ClassVar[int] = 0
    _requested: ClassVar[bool] = False
    _before: ClassVar[dict[int, Any]] = {}

    def __enter__(self) -> "Termination":
        if threading.current_thread() is threading.main_thread():
            if Termination._entered == 0:
                self._watch()
            Termination._entered += 1
        return self

    def __exit__(self, *_: object) -> None:
        if threading.current_thread() is threading.main_thread():
            Termination._entered -= 1
            if Termination._entered == 0:
                self._restore()

    @property
    def requested(self) -> bool:
        """Whether the process was asked to end."""
        return Termination._requested

    @classmethod
    def _watch(cls) -> None:
        for number in _SIGNALS:
            handler = signal.getsignal(number)
            if handler in (signal.SIG_DFL, signal.default_int_handler):
                cls._before[number] = handler
                signal.signal(number, cls._on_signal)

    @classmethod
    def _restore(cls) -> None:
        for number, handler in cls._before.items():
            signal.signal(number, handler)
        cls._before.clear()
        cls._requested = False

    @classmethod
    def _on_signal(cls, number: int, _: FrameType | None) -> None:
        if number == signal.SIGINT and cls._requested:
            raise KeyboardInterrupt
        cls._requested = True
