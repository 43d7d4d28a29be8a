"""A process's place in a fleet, on which services are opened."""

import time
from collections.abc import Callable
from typing import Any, TypeVar

import iceoryx2 as iox

from regatta._contract import CONTRACT_VERSION, LAYOUT, ColumnHeader, Done, Line, Record, Sequenced
from regatta._domain import iceoryx2_config
from regatta._errors import VersionError
from regatta._open import ClosedPort
from regatta._ports import Claim, Client, Holder, Receiver, Sender, Wake, unusable
from regatta._reports import DoneReports, Reporter

SequencedHeader = TypeVar("SequencedHeader", bound=Sequenced)
Header = TypeVar("Header", bound=Record)
Request = TypeVar("Request", bound=Record)
Response = TypeVar("Response", bound=Record)

ATTEMPTS = 10
"""The number of attempts to open a service, 50 ms apart: services come and go while other processes start and stop."""

# Each error of iceoryx2 becomes one of this package's.
iox.set_log_level_from_env_or(iox.LogLevel.Fatal)


class Node:
    """A process that has joined a fleet. Services are opened on it as ``layout.json`` describes them."""

    def __init__(self, fleet: str, name: str) -> None:
        self.fleet = fleet
        self.name = name
        # iceoryx2's limit is 128 bytes; the name of a node serves `regatta doctor` only.
        node_name = f"regatta/{fleet}/{name}".encode()[:128].decode(errors="ignore")
        builder = iox.NodeBuilder.new().config(iceoryx2_config()).name(iox.NodeName.new(node_name))
        # iceoryx2's own handling intercepts every signal that a process can get.
        builder = builder.signal_handling_mode(iox.SignalHandlingMode.Disabled)
        try:
            self._node: Any = builder.create(iox.ServiceType.Ipc)
        except iox.NodeCreationFailure as error:
            raise unusable(f"fleet '{fleet}'", 0, error) from None

    def receiver(
        self, service: str, what: str, payload: type[Record], header: type[SequencedHeader]
    ) -> Receiver[SequencedHeader]:
        """Opens the receiving end of a service, whether or not it has a sender yet. ``what`` names a sample in
        errors."""
        return Receiver(self._slices(service, payload, header), what, payload, header)

    def sender(self, service: str, what: str, payload: type[Record], header: type[Header]) -> Sender[Header]:
        """Opens a sending end of a service. ``what`` names a sample in errors."""
        return Sender(self._slices(service, payload, header), what, payload)

    def client(self, service: str, request: type[Request], response: type[Response]) -> Client[Request, Response]:
        """Opens a client of a request-response service."""
        opened = self._open("RequestResponse", service, lambda builder: builder.request_response(request, response))
        return Client(opened, f"the service '{service}' of fleet '{self.fleet}'", response)

    def columns(self) -> list[str]:
        """Returns the names of the columns that living processes publish, sorted. Takes some milliseconds, because it
        lists all services of the machine."""
        prefix = f"regatta/{self.fleet}/columns/"
        services = iox.Service.list(self._node.config, iox.ServiceType.Ipc)
        names = sorted(service.name().to_string() for service in services)
        columns = [name.removeprefix(prefix) for name in names if name.startswith(prefix)]
        return [name for name in columns if self._is_published(name)]

    def close(self) -> None:
        """Leaves the fleet, as soon as nothing that was opened is left."""
        self._node = ClosedPort(f"fleet '{self.fleet}'")

    def wake(self) -> Wake:
        """Opens the event service that wakes readers after each frame."""
        return Wake(self._event("wake"))

    def claim(self, service: str) -> Claim:
        """Claims what one process has at a time. Raises :class:`TakenError <regatta.TakenError>` if another one has it."""
        return Claim(self._event(service))

    def holder(self, service: str) -> Holder:
        """Tells whether a process has made a claim."""
        return Holder(self._event(service), self._node)

    def reporter(self) -> Reporter:
        """Opens the sending end of lockstep reports, under the name of this process."""
        return Reporter(self._done(), self._event("done"), self.name)

    def done_reports(self) -> DoneReports:
        """Opens the receiving end of lockstep reports."""
        return DoneReports(self._done(), Wake(self._event("done")))

    def _is_published(self, column: str) -> bool:
        service = self._slices(f"columns/{column}", Line, ColumnHeader)
        service.try_cleanup_dead_nodes()
        return int(service.dynamic_config.number_of_publishers) > 0

    def _done(self) -> Any:
        return self._open("PublishSubscribe", "done", lambda builder: builder.publish_subscribe(Done))

    def _event(self, service: str) -> Any:
        return self._open("Event", service, lambda builder: builder.event())

    def _slices(self, service: str, payload: type[Record], header: type[Record]) -> Any:
        details = _config("PublishSubscribe", service)["message_type_details"]
        # ctypes can't align a structure to cache lines.
        alignment = iox.Alignment.new(details["payload"]["alignment"])

        def typed(builder: Any) -> Any:
            slices = builder.publish_subscribe(iox.Slice[payload])
            return slices.user_header(header).payload_alignment(alignment)

        return self._open("PublishSubscribe", service, typed)

    def _open(self, pattern: str, service: str, typed: Callable[[Any], Any]) -> Any:
        config = _config(pattern, service)
        what = f"regatta/{self.fleet}/{service}"
        name = iox.ServiceName.new(what)
        version = iox.AttributeVerifier.new().require(
            iox.AttributeKey.new(LAYOUT["version_attribute"]), iox.AttributeValue.new(str(CONTRACT_VERSION))
        )
        service_builder = self._node.service_builder
        for attempt in range(1, ATTEMPTS + 1):
            try:
                builder = typed(service_builder(name))
                # The layout names each setting as iceoryx2's builders do.
                for setting, value in config.items():
                    if isinstance(value, int):
                        builder = getattr(builder, setting)(value)
                return builder.open_or_create_with_attributes(version)
            except Exception as error:  # each pattern has an error of its own
                # Checked first, because another version also explains payload types that differ.
                self._check_version(name, pattern)
                if attempt == ATTEMPTS:
                    raise unusable(what, config["max_nodes"], error) from None
            time.sleep(0.05)

    def _check_version(self, name: Any, pattern: str) -> None:
        """Raises :class:`VersionError` if the service exists and has another version of the contract."""
        try:
            patterns = iox.MessagingPattern
            details = iox.Service.details(name, self._node.config, getattr(patterns, pattern), iox.ServiceType.Ipc)
        except iox.ServiceDetailsError:
            return
        if details is None:
            return
        values = details.attributes().key_values(iox.AttributeKey.new(LAYOUT["version_attribute"]))
        theirs = values[0].to_string() if values else "unknown"
        if theirs != str(CONTRACT_VERSION):
            raise VersionError(
                f"fleet '{self.fleet}' uses contract version {theirs}, this program uses version {CONTRACT_VERSION}"
                f" ({name.to_string()}); use both from the same release, or use another fleet name"
            ) from None


def _config(pattern: str, service: str) -> dict[str, Any]:
    config: dict[str, Any] = LAYOUT["services"][pattern]["columns/NAME" if service.startswith("columns/") else service]
    return config
