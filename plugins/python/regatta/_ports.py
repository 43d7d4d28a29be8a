"""The ports of a fleet's services: receivers, senders, clients and wake-ups.

Only this module, ``_reports`` and ``_node`` use iceoryx2.
"""

import ctypes
import gc
import sys
from collections.abc import Callable
from typing import Any, Generic, TypeVar

import iceoryx2 as iox
import numpy as np
import numpy.typing as npt

from regatta._contract import Record, Sequenced
from regatta._errors import FullError, HeldError, OpenError, PublishError, ReadError, TakenError
from regatta._open import ClosedPort
from regatta._sequence import LostSamples

Header = TypeVar("Header", bound=Record)
SequencedHeader = TypeVar("SequencedHeader", bound=Sequenced)
Request = TypeVar("Request", bound=Record)
Response = TypeVar("Response", bound=Record)
Bytes = npt.NDArray[np.uint8]

ENGINE = "engine"
"""The name that an engine goes by in its fleet."""

NAP = 0.1
"""The longest sleep, in seconds, which bounds the cost of a lost wake-up."""

MAX_ROUNDS = 16
"""The largest number of samples that one search for the newest goes through: samples that dead publishers left unread
come before those of the living one. It is bounded so that a publisher faster than the reader can't keep it busy."""


def _is(error: Exception, reason: str) -> bool:
    """Whether an error of iceoryx2 has a reason, such as ``InterruptSignal``. A part of a reason's name stands for all
    reasons with that part.

    Reasons are compared as text, because the exceptions of iceoryx2 0.10.0 have nothing else: each is a plain subclass
    of ``Exception`` with one argument, the reason's name in Rust (``ExceedsMaxBorrows``), in some errors in brackets
    (``PublishSubscribeOpenError(ExceedsMaxNumberOfNodes)``). There are no subclasses, codes or attributes that tell the
    reasons of an error apart.
    """
    return reason in str(error)


def create(service: Any, limit: int, attempt: Callable[[], Any]) -> Any:
    """Opens a port of a service that has room for ``limit`` ports of its kind."""
    try:
        return attempt()
    except Exception:  # each kind of port has an error of its own
        # A dead process may still occupy the place.
        service.try_cleanup_dead_nodes()
    try:
        return attempt()
    except Exception as error:
        raise unusable(service.name.to_string(), limit, error) from None


def unusable(what: str, limit: int, error: Exception) -> OpenError:
    """Returns the error for a service that iceoryx2 can't open."""
    is_full = _is(error, "ExceedsMax")
    if is_full and limit == 1:
        return TakenError(
            f"{what} is already published by another process (`regatta doctor` lists them); stop that one, or choose"
            " another name"
        )
    if is_full:
        return FullError(
            f"{what} has all of its {limit} places taken; stop a reader, or run `regatta doctor --clean` if some have"
            " died"
        )
    return OpenError(f"can't open {what} in shared memory ({error}); `regatta doctor` reports what is wrong with it")


def update_connections(publisher: Any) -> None:
    """Connects readers that have joined since to a publisher, and gives them the sample that is kept for late
    joiners."""
    try:
        publisher.update_connections()
    except iox.ConnectionFailure:
        pass  # a reader that died half connected is cleaned up by the next process to join


class _Memory:
    """Memory that numpy arrays can be views of. While an array refers to this object, ``owner`` stays alive."""

    def __init__(self, address: int, size: int, owner: object, writeable: bool) -> None:
        self._owner = owner
        self.__array_interface__ = {"data": (address, not writeable), "shape": (size,), "typestr": "|u1", "version": 3}


class Sample(Generic[SequencedHeader]):
    """A received sample: a copy of its header, and a view of its payload as bytes in shared memory.

    The payload is read-only, for numpy and for the processor. Its memory goes back to the publisher when nothing refers
    to the sample or to an array of it any more, and not before, even if the publisher ends.
    """

    __slots__ = ("elements", "header", "missed", "payload")

    def __init__(self, sample: Any, port: Any, header: type[SequencedHeader], element_bytes: int) -> None:
        self.missed = 0
        """The number of samples that were published between the one that this reader got before and this one."""
        self.header: SequencedHeader = header()
        ctypes.memmove(ctypes.byref(self.header), sample.user_header_ptr, ctypes.sizeof(header))
        self.elements: int = sample.header.number_of_elements
        # The port, too: a publisher takes back, and overwrites, the memory of samples whose receiver is gone.
        memory = _Memory(sample.payload_ptr, self.elements * element_bytes, (port, sample), writeable=False)
        self.payload: Bytes = np.asarray(memory)


class Receiver(Generic[SequencedHeader]):
    """Receives the samples of a service, and counts those that it loses."""

    def __init__(self, service: Any, what: str, payload: type[Record], header: type[SequencedHeader]) -> None:
        self._service = service
        self._what = what
        self._element_bytes = ctypes.sizeof(payload)
        self._header = header
        self._lost = LostSamples()
        limit = service.static_config.max_subscribers
        builder = service.subscriber_builder()
        # A service that keeps its newest sample for late joiners is read for the newest sample only.
        builder = builder.buffer_size(1) if service.static_config.history_size else builder
        self._port = create(service, limit, builder.create)

    @property
    def lost(self) -> int:
        """The number of samples lost so far."""
        return self._lost.total

    def has_samples(self) -> bool:
        """Whether a sample waits to be received."""
        try:
            return bool(self._port.has_samples())
        except iox.ConnectionFailure as error:
            raise self._broken(error) from None

    def receive(self) -> Sample[SequencedHeader] | None:
        """Returns the oldest sample that has not been received yet."""
        try:
            sample = self._port.receive()
        except iox.ReceiveError as error:
            if not _is(error, "ExceedsMaxBorrows"):
                raise self._broken(error) from None
            sample = self._receive_after_collecting()
        if sample is None:
            return None
        received = Sample(sample, self._port, self._header, self._element_bytes)
        received.missed = self._lost.before(received.header)
        return received

    def latest(self) -> Sample[SequencedHeader] | None:
        """Returns the newest sample, if there is one that has not been received yet."""
        newest: Sample[SequencedHeader] | None = None
        missed = 0
        for _ in range(MAX_ROUNDS):
            if not self.has_samples():
                break
            if newest is not None:
                missed += newest.missed + 1
                newest = None  # given back first: a reader may hold few samples at a time
            newest = self.receive()
        if newest is not None:
            newest.missed += missed
        return newest

    def close(self) -> None:
        """Frees the place at the service, as soon as nothing refers to a sample any more."""
        self._port = ClosedPort(self._what)

    def has_publisher(self) -> bool:
        """Whether a living process publishes. Takes a millisecond or so, because it removes the resources of
        dead processes."""
        self._service.try_cleanup_dead_nodes()
        return int(self._service.dynamic_config.number_of_publishers) > 0

    def _receive_after_collecting(self) -> Any:
        # The references may be cyclic garbage, for example of an exception that was caught.
        gc.collect()
        try:
            return self._port.receive()
        except iox.ReceiveError:
            held = self._service.static_config.subscriber_max_borrowed_samples
            hint = " (a notebook's Out[] refers to each array that a cell shows)" if "IPython" in sys.modules else ""
            raise HeldError(
                f"can't read {self._what}: variables or arrays of this program still refer to the last {held}{hint};"
                " keep copies instead, for example frame.copy() or frame.x.copy()"
            ) from None

    def _broken(self, error: Exception) -> ReadError:
        return ReadError(
            f"can't read {self._what} ({error}); is its producer still alive? `regatta doctor` lists the living ones"
        )


class Sender(Generic[Header]):
    """Sends samples to a service. Never waits for a reader."""

    def __init__(self, service: Any, what: str, payload: type[Record]) -> None:
        self._service = service
        self._what = what
        self._element_bytes = ctypes.sizeof(payload)
        builder = service.publisher_builder().max_loaned_samples(1).initial_max_slice_len(1)
        builder = builder.allocation_strategy(iox.AllocationStrategy.PowerOfTwo)
        builder = builder.backpressure_strategy(iox.BackpressureStrategy.DiscardData)
        self._port = create(service, service.static_config.max_publishers, builder.create)

    def send(self, header: Header, elements: int, fill: Callable[[Bytes], None]) -> int:
        """Sends a sample of ``elements`` elements, which ``fill`` writes straight into shared memory.

        ``fill`` may still complete the header. Returns the number of readers that received the sample.
        """
        try:
            loan = self._port.loan_slice_uninit(elements)
            fill(np.asarray(_Memory(loan.payload_ptr, elements * self._element_bytes, loan, writeable=True)))
            ctypes.memmove(loan.user_header_ptr, ctypes.byref(header), ctypes.sizeof(header))
            return int(loan.assume_init().send())
        except iox.LoanError as error:
            hint = "`regatta doctor` shows how much there is"
            raise PublishError(f"no shared memory for {self._what} ({error}); {hint}") from None
        except iox.SendError as error:
            raise PublishError(f"can't publish {self._what} ({error})") from None

    def update(self) -> None:
        """Connects readers that have joined since, and gives them the sample that the service keeps for late
        joiners."""
        update_connections(self._port)

    def close(self) -> None:
        """Frees the place at the service."""
        self._port = ClosedPort(self._what)

    def receivers(self) -> int:
        """Returns the number of readers of the service."""
        return int(self._service.dynamic_config.number_of_subscribers)


class Client(Generic[Request, Response]):
    """Sends requests to the server of a service."""

    def __init__(self, service: Any, what: str, response: type[Response]) -> None:
        self._service = service
        self._what = what
        self._response = response
        builder = service.client_builder().backpressure_strategy(iox.BackpressureStrategy.DiscardData)
        self._port = create(service, service.static_config.max_clients, builder.create)

    def ask(self, request: Request) -> Any:
        """Sends a request. Returns the pending response, through which the answer arrives."""
        try:
            return self._port.send_copy(request)
        except (iox.LoanError, iox.RequestSendError) as error:
            raise PublishError(f"can't send a request ({error})") from None

    def answer(self, pending: Any) -> Response | None:
        """Returns the answer to a request, if it has arrived."""
        try:
            received = pending.receive()
        except iox.ReceiveError as error:
            raise ReadError(f"can't read an answer ({error})") from None
        if received is None:
            return None
        answer = self._response()
        ctypes.memmove(ctypes.byref(answer), received.payload_ptr, ctypes.sizeof(answer))
        return answer

    def has_server(self) -> bool:
        """Whether the service has a server. One that was killed counts until :meth:`forget_dead`."""
        return int(self._service.dynamic_config.number_of_servers) > 0

    def close(self) -> None:
        """Frees the place at the service."""
        self._port = self._service = ClosedPort(self._what)

    def forget_dead(self) -> None:
        """Removes the resources of dead processes at this service."""
        self._service.try_cleanup_dead_nodes()


class Claim:
    """A claim that this process holds: the one notifier of an event service, which notifies nobody. It ends with the
    process."""

    def __init__(self, service: Any) -> None:
        self._port = create(service, 1, lambda: service.notifier_builder().create())

    def close(self) -> None:
        """Gives the claim up."""
        self._port = ClosedPort("a claim")


class Holder:
    """Tells whether a living process holds a claim."""

    def __init__(self, service: Any, node: Any) -> None:
        self._service = service
        self._node = node

    def is_held(self) -> bool:
        """Whether a living process holds it. Takes a millisecond or so if one does."""
        if int(self._service.dynamic_config.number_of_notifiers) > 0:
            self._service.try_cleanup_dead_nodes()
        return int(self._service.dynamic_config.number_of_notifiers) > 0

    def members(self) -> list[str]:
        """Returns the other living members of the fleet that may hold it, such as ``fleet-manager (process 4711)``: all
        that have the service open, without the engine, which only watches it. (iceoryx2's binding doesn't tell which of
        them holds it.)"""
        own = self._node.id.value
        alive = [state[0] for state in self._service.nodes if isinstance(state, iox.NodeState.Alive)]
        others = [view.details for view in alive if view.id.value != own and view.details is not None]
        names = [(details.name.as_str().rsplit("/")[-1], details.process_id) for details in others]
        return [f"{name} (process {process})" for name, process in names if name != ENGINE]

    def close(self) -> None:
        """Stops watching."""
        self._service = self._node = ClosedPort("a claim")


class Wake:
    """The listening end of an event service: sleeps until another process has news."""

    def __init__(self, service: Any) -> None:
        limit = service.static_config.max_listeners
        self._port = create(service, limit, lambda: service.listener_builder().create())

    def close(self) -> None:
        """Frees the place at the service."""
        self._port = ClosedPort("a wake-up")

    def sleep(self, seconds: float) -> None:
        """Sleeps until woken or until a signal arrives, but no longer than ``seconds`` or a :data:`NAP`.

        Consumes the wake-ups so far: check for news afterwards. News that arrives after the check ends the next sleep
        at once.
        """
        try:
            self._port.timed_wait(iox.Duration.from_secs_f64(max(0.0, min(seconds, NAP))))
        except iox.ListenerWaitError as error:
            if not _is(error, "InterruptSignal"):
                raise ReadError(f"can't wait for a wake-up ({error}); `regatta doctor` reports what is wrong") from None
