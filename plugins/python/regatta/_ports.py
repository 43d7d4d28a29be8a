"""The ends of a fleet's services: what receives, sends, asks and sleeps. With ``_node``, all that knows iceoryx2."""

import ctypes
import gc
from collections.abc import Callable
from typing import Any, Generic, TypeVar

import iceoryx2 as iox
import numpy as np
import numpy.typing as npt

from regatta._contract import Done, Record
from regatta._errors import FullError, HeldError, OpenError, PublishError, ReadError, TakenError

Header = TypeVar("Header", bound=Record)
Request = TypeVar("Request", bound=Record)
Response = TypeVar("Response", bound=Record)
Bytes = npt.NDArray[np.uint8]

NAP = 0.1
"""Upper bound in seconds of one sleep: what a wake-up that got lost would cost."""


def create(service: Any, limit: int, attempt: Callable[[], Any]) -> Any:
    """Opens a port of a service that has room for so many of its kind."""
    try:
        return attempt()
    except Exception:  # each kind of port has an error of its own
        # A dead process may have the place.
        service.try_cleanup_dead_nodes()
    try:
        return attempt()
    except Exception as error:
        raise unusable(service.name.to_string(), limit, error) from None


def unusable(what: str, limit: int, error: Exception) -> OpenError:
    """The error for something that iceoryx2 can't open."""
    if "ExceedsMax" in str(error) and limit == 1:
        return TakenError(
            f"{what} is already published by another process (`regatta doctor` lists them); stop that one, or choose"
            " another name"
        )
    if "ExceedsMax" in str(error):
        return FullError(
            f"{what} has all of its {limit} places taken; stop one of the others, or run `regatta doctor --clean` if some"
            " have died"
        )
    return OpenError(f"can't open {what} in shared memory ({error}); `regatta doctor` says what is wrong with it")


class _Memory:
    """Memory that numpy may look at for as long as it refers to this, which keeps ``owner`` alive."""

    def __init__(self, address: int, size: int, owner: object, writeable: bool) -> None:
        self._owner = owner
        self.__array_interface__ = {"data": (address, not writeable), "shape": (size,), "typestr": "|u1", "version": 3}


class Sample(Generic[Header]):
    """What was received: a copy of the header, and the payload as bytes that stay where they are.

    The payload is read-only, for numpy and for the processor. Its memory is given back to the publisher when nothing
    refers to the sample or to an array of it any more, and not before, whatever happens to the publisher.
    """

    __slots__ = ("elements", "header", "payload")

    def __init__(self, sample: Any, header: type[Header], element_bytes: int) -> None:
        self.header: Header = header()
        ctypes.memmove(ctypes.byref(self.header), sample.user_header_ptr, ctypes.sizeof(header))
        self.elements: int = sample.header.number_of_elements
        memory = _Memory(sample.payload_ptr, self.elements * element_bytes, sample, writeable=False)
        self.payload: Bytes = np.asarray(memory)


class Receiver(Generic[Header]):
    """Receives samples of one service."""

    def __init__(self, service: Any, what: str, payload: type[Record], header: type[Header]) -> None:
        self._service = service
        self._what = what
        self._element_bytes = ctypes.sizeof(payload)
        self._header = header
        limit = service.static_config.max_subscribers
        builder = service.subscriber_builder()
        # Of what has a newest sample, this reads the newest.
        builder = builder.buffer_size(1) if service.static_config.history_size else builder
        self._port = create(service, limit, builder.create)

    def has_samples(self) -> bool:
        """Whether :meth:`receive` has something."""
        try:
            return bool(self._port.has_samples())
        except iox.ConnectionFailure as error:
            raise self._broken(error) from None

    def receive(self) -> Sample[Header] | None:
        """The oldest sample that has not been received yet."""
        try:
            sample = self._port.receive()
        except iox.ReceiveError as error:
            if "ExceedsMaxBorrows" not in str(error):
                raise self._broken(error) from None
            sample = self._receive_after_collecting()
        return None if sample is None else Sample(sample, self._header, self._element_bytes)

    def latest(self) -> Sample[Header] | None:
        """The newest sample, if there is one that has not been received yet."""
        newest = None
        # A few rounds: what producers that have died since left unread comes before what the living one sends. No more,
        # or a producer faster than this loop would keep it busy.
        for _ in range(8):
            if not self.has_samples():
                break
            newest = None
            newest = self.receive()
        return newest

    def has_publisher(self) -> bool:
        """Whether anybody alive publishes. Takes a millisecond or so: it removes what dead processes left."""
        self._service.try_cleanup_dead_nodes()
        return int(self._service.dynamic_config.number_of_publishers) > 0

    def _receive_after_collecting(self) -> Any:
        # What is still referred to may only be garbage that refers to itself, of an exception that was caught, say.
        gc.collect()
        try:
            return self._port.receive()
        except iox.ReceiveError:
            held = self._service.static_config.subscriber_max_borrowed_samples
            raise HeldError(
                f"can't read {self._what}: the last {held} are still referred to, by variables or arrays that you keep;"
                " keep copies instead, frame.x.copy() say"
            ) from None

    def _broken(self, error: Exception) -> ReadError:
        return ReadError(f"can't read {self._what} ({error}); is its producer still alive? `regatta doctor` says")


class Sender(Generic[Header]):
    """Sends samples to one service. Never waits for who receives them."""

    def __init__(self, service: Any, what: str, payload: type[Record]) -> None:
        self._service = service
        self._what = what
        self._element_bytes = ctypes.sizeof(payload)
        builder = service.publisher_builder().max_loaned_samples(1).initial_max_slice_len(1)
        builder = builder.allocation_strategy(iox.AllocationStrategy.PowerOfTwo)
        builder = builder.backpressure_strategy(iox.BackpressureStrategy.DiscardData)
        self._port = create(service, service.static_config.max_publishers, builder.create)

    def send(self, header: Header, elements: int, fill: Callable[[Bytes], None]) -> int:
        """Sends so many elements, which ``fill`` writes straight into shared memory. Returns how many got it."""
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

    def receivers(self) -> int:
        """How many would receive what is sent."""
        return int(self._service.dynamic_config.number_of_subscribers)


class Client(Generic[Request, Response]):
    """Asks the one server of a service."""

    def __init__(self, service: Any, response: type[Response]) -> None:
        self._service = service
        self._response = response
        builder = service.client_builder().backpressure_strategy(iox.BackpressureStrategy.DiscardData)
        self._port = create(service, service.static_config.max_clients, builder.create)

    def ask(self, request: Request) -> Any:
        """Sends a request; its answer comes to what this returns."""
        try:
            return self._port.send_copy(request)
        except (iox.LoanError, iox.RequestSendError) as error:
            raise PublishError(f"can't send a request ({error})") from None

    def answer(self, pending: Any) -> Response | None:
        """The answer to a request, if it is there."""
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
        """Whether anybody answers. One that was killed counts until :meth:`forget_dead`."""
        return int(self._service.dynamic_config.number_of_servers) > 0

    def forget_dead(self) -> None:
        """Removes what dead processes left at this service."""
        self._service.try_cleanup_dead_nodes()


class Wake:
    """Sleeps until another process has news."""

    def __init__(self, service: Any) -> None:
        limit = service.static_config.max_listeners
        self._port = create(service, limit, lambda: service.listener_builder().create())

    def sleep(self, seconds: float) -> None:
        """Sleeps until woken, or for so long, or for a :data:`NAP`, or until a signal comes.

        Forgets the wake-ups so far, so look for news afterwards.
        """
        try:
            self._port.timed_wait(iox.Duration.from_secs_f64(max(0.0, min(seconds, NAP))))
        except iox.ListenerWaitError as error:
            if "InterruptSignal" not in str(error):
                raise ReadError(f"can't wait for a wake-up ({error}); `regatta doctor` says what is wrong") from None


class Reporter:
    """Reports finished ticks to a producer in lockstep."""

    def __init__(self, reports: Any, wake: Any, name: str) -> None:
        builder = reports.publisher_builder().max_loaned_samples(1)
        builder = builder.backpressure_strategy(iox.BackpressureStrategy.DiscardData)
        self._reports = create(reports, reports.static_config.max_publishers, builder.create)
        self._wake = create(wake, wake.static_config.max_notifiers, lambda: wake.notifier_builder().create())
        self._name = name.encode()

    def done(self, run_id: int, tick: int) -> None:
        """Reports that a tick is finished, and wakes the producer."""
        try:
            self._reports.send_copy(Done(run_id, tick, self._name))
            self._wake.notify()
        except (iox.LoanError, iox.SendError) as error:
            raise PublishError(f"can't publish a lockstep report ({error})") from None
        except iox.NotifierNotifyError:
            pass  # the producer looks by itself a little later
