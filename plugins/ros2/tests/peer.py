"""A peer on Cyclone DDS, with services and actions as nodes of ROS 2 call them."""

import os
import time

# Cyclone DDS prefers other interfaces, and finds nobody on loopback without being told where.
os.environ.setdefault(
    "CYCLONEDDS_URI",
    """<CycloneDDS><Domain id="any">
    <General><AllowMulticast>false</AllowMulticast>
    <Interfaces><NetworkInterface address="127.0.0.1"/></Interfaces></General>
    <Discovery><ParticipantIndex>auto</ParticipantIndex>
    <Peers><Peer address="127.0.0.1"/></Peers></Discovery>
    </Domain></CycloneDDS>""",
)

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

TIMEOUT = 45.0

QOS = Qos(
    Policy.Reliability.Reliable(duration(seconds=1)),
    Policy.Durability.Volatile,
    Policy.History.KeepLast(20),
    Policy.DataRepresentation(use_cdrv0_representation=True, use_xcdrv2_representation=False),
)


class Peer:
    def __init__(self, domain):
        self.participant = DomainParticipant(domain)

    def reader(self, name, kind):
        return DataReader(self.participant, Topic(self.participant, name, kind, QOS), QOS)

    def writer(self, name, kind):
        writer = DataWriter(self.participant, Topic(self.participant, name, kind, QOS), QOS)
        wait(f"a reader of {name}", lambda: len(writer.get_matched_subscriptions()) > 0)
        return writer

    def service(self, name, request, response):
        return Service(self, name, request, response)


class Service:
    """Calls a service, one request at a time."""

    def __init__(self, peer, name, request, response):
        self.name = name
        self.responses = peer.reader(f"rr/{name}Reply", response)
        self.requests = peer.writer(f"rq/{name}Request", request)
        wait(
            f"the responses of {name}",
            lambda: len(self.responses.get_matched_publications()) > 0,
        )
        # The other side must know the reader of its responses, too.
        time.sleep(0.5)

    def send(self, request):
        self.requests.write(request)

    def receive(self):
        return wait(f"an answer of {self.name}", lambda: next(iter(self.responses.take(1)), None))

    def call(self, request):
        self.send(request)
        return self.receive()


def wait(what, attempt):
    end = time.monotonic() + TIMEOUT
    while True:
        found = attempt()
        if found:
            return found
        assert time.monotonic() < end, f"{what}: not within {TIMEOUT} s"
        time.sleep(0.02)
